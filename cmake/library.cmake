# libtulle, shared and static, from the same object files: base, math, geom, detect, dynamics, contact, world, check. It
# needs libc, libm and threads.
set(library_sources)
foreach(folder base math geom detect dynamics contact step world check)
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${folder}/*.c)
    list(FILTER sources EXCLUDE REGEX "/kernels/") # kernels.cmake compiles these
    list(APPEND library_sources ${sources})
endforeach()

# One of the parallel_*.c files runs the chunks of parallel_for.
if(NOT TULLE_THREADS MATCHES "^(pthreads|openmp|none)$")
    message(FATAL_ERROR "TULLE_THREADS is \"${TULLE_THREADS}\"; it should be pthreads, openmp or none")
endif()
list(FILTER library_sources EXCLUDE REGEX "/base/parallel_[a-z]+\\.c$")
list(APPEND library_sources ${PROJECT_SOURCE_DIR}/src/base/parallel_${TULLE_THREADS}.c)

# Mutants relink one shared library in place of every test (tools/mutate.py).
set(tulle_inside_type STATIC)
set(tulle_visibility hidden)
if(TULLE_SHARED_INSIDE)
    set(tulle_inside_type SHARED)
    set(tulle_visibility default)
endif()

# tulle_add_objects(NAME SOURCES...): compiled as a part of a library; names are hidden unless they are TULLE_API.
function(tulle_add_objects name)
    add_library(${name} OBJECT ${ARGN})
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
    target_compile_definitions(${name} PRIVATE TULLE_BUILD_SHARED)
    target_link_libraries(${name} PRIVATE tulle_flags)
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET ${tulle_visibility} EXCLUDE_FROM_ALL ON)
endfunction()

# Files without public names, of which libtulle_io holds a copy of its own.
set(common_sources base/arena.c base/error.c base/hash.c base/memory.c base/sort.c base/text.c base/words.c geom/big_integer.c geom/cut_polygon.c geom/cut_polygons.c
    geom/exact_predicates.c geom/mesh_indices.c geom/topology.c)
list(TRANSFORM common_sources PREPEND ${PROJECT_SOURCE_DIR}/src/)
list(REMOVE_ITEM library_sources ${common_sources})
tulle_add_objects(tulle_common ${common_sources})
tulle_add_objects(tulle_engine ${library_sources})

set(tulle_private_libraries m)
if(TULLE_THREADS STREQUAL "openmp")
    find_package(OpenMP REQUIRED COMPONENTS C)
    target_compile_options(tulle_engine PRIVATE ${OpenMP_C_FLAGS})
    list(PREPEND tulle_private_libraries ${OpenMP_C_LIB_NAMES})
elseif(TULLE_THREADS STREQUAL "pthreads")
    list(PREPEND tulle_private_libraries pthread)
endif()

include(cmake/kernels.cmake)
set(tulle_parts tulle_common tulle_engine ${tulle_kernel_parts})
list(TRANSFORM tulle_parts REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE tulle_objects)
tulle_add_archive(tulle_static ${tulle_parts})
add_library(tulle_shared SHARED ${tulle_objects})
# For the program and for tests of the inside, which is all there under its own names.
add_library(tulle_inside ${tulle_inside_type} EXCLUDE_FROM_ALL ${tulle_objects})
target_include_directories(tulle_inside PUBLIC ${PROJECT_SOURCE_DIR}/src)

# tulle_set_up_library(NAME OUTPUT): what all of these have in common.
function(tulle_set_up_library name output)
    set_target_properties(${name} PROPERTIES OUTPUT_NAME ${output} LINKER_LANGUAGE C EXPORT_NAME ${name})
    target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    get_target_property(type ${name} TYPE)
    if(type STREQUAL "SHARED_LIBRARY")
        set_target_properties(${name} PROPERTIES VERSION ${PROJECT_VERSION} EXPORT_NAME ${output}
            SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
        if(NOT TULLE_SANITIZE)
            target_link_options(${name} PRIVATE -Wl,--no-undefined)
        endif()
    endif()
    if(NOT TULLE_INSTALL)
        set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON) # built when something links it
    endif()
endfunction()
tulle_set_up_library(tulle_static tulle)
tulle_set_up_library(tulle_shared tulle)
tulle_set_up_library(tulle_inside tulle_inside)
target_link_libraries(tulle_static INTERFACE ${tulle_private_libraries})
target_link_libraries(tulle_inside PUBLIC ${tulle_private_libraries})
target_link_libraries(tulle_shared PRIVATE ${tulle_private_libraries} tulle_flags)
add_library(tulle::tulle ALIAS tulle_shared)
add_library(tulle::tulle_static ALIAS tulle_static)
