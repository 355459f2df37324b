# libtulle_io, shared and static: mesh, cache and run files, VTP files (Expat, zlib), scene files (libyaml) and
# subdivision. It stands on the public headers of libtulle; what it shares of src/base and src/geom it has as a hidden
# copy of its own.
find_package(PkgConfig REQUIRED)
pkg_check_modules(YAML REQUIRED IMPORTED_TARGET yaml-0.1)
find_package(EXPAT REQUIRED)
find_package(ZLIB REQUIRED)
set(tulle_io_libraries PkgConfig::YAML EXPAT::EXPAT ZLIB::ZLIB)

set(io_sources)
foreach(folder io scene subdivision)
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${folder}/*.c)
    list(APPEND io_sources ${sources})
endforeach()
# Alembic is C++. Without it a file of C says so.
if(TULLE_ALEMBIC)
    enable_language(CXX)
    find_package(Alembic REQUIRED)
    list(FILTER io_sources EXCLUDE REGEX alembic_none[.]c$)
    list(APPEND io_sources ${PROJECT_SOURCE_DIR}/src/io/animation/alembic.cpp)
    list(APPEND tulle_io_libraries Alembic::Alembic)
endif()
tulle_add_objects(tulle_io_parts ${io_sources})
target_link_libraries(tulle_io_parts PRIVATE ${tulle_io_libraries})

tulle_add_archive(tulle_io_static tulle_io_parts tulle_common)
add_library(tulle_io_shared SHARED $<TARGET_OBJECTS:tulle_io_parts> $<TARGET_OBJECTS:tulle_common>)
# For the program and for tests of the inside.
add_library(tulle_io_inside ${tulle_inside_type} EXCLUDE_FROM_ALL $<TARGET_OBJECTS:tulle_io_parts>)
tulle_set_up_library(tulle_io_static tulle_io)
tulle_set_up_library(tulle_io_shared tulle_io)
tulle_set_up_library(tulle_io_inside tulle_io_inside)
target_link_libraries(tulle_io_static INTERFACE tulle_static ${tulle_io_libraries})
target_link_libraries(tulle_io_inside PUBLIC tulle_inside ${tulle_io_libraries})
target_link_libraries(tulle_io_shared PUBLIC tulle_shared PRIVATE ${tulle_io_libraries} m tulle_flags)
add_library(tulle::tulle_io ALIAS tulle_io_shared)
add_library(tulle::tulle_io_static ALIAS tulle_io_static)
