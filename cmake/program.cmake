# The program: scene files (libyaml) and the command line, with the library linked in.
find_package(PkgConfig REQUIRED)
pkg_check_modules(YAML REQUIRED IMPORTED_TARGET yaml-0.1)
file(GLOB scene_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/scene/*.c)
file(GLOB app_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/app/*.c)

if(scene_sources)
    add_library(tulle_scene STATIC ${scene_sources})
    target_include_directories(tulle_scene PUBLIC ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(tulle_scene PRIVATE tulle_flags PUBLIC tulle_static PkgConfig::YAML)
endif()

add_executable(tulle_program ${app_sources})
target_include_directories(tulle_program PRIVATE ${PROJECT_SOURCE_DIR}/src)
target_link_libraries(tulle_program PRIVATE tulle_flags $<TARGET_NAME_IF_EXISTS:tulle_scene> tulle_static)
set_target_properties(tulle_program PROPERTIES OUTPUT_NAME tulle)

# The examples, against the shared library as their readers will.
file(GLOB example_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/examples/*.c)
foreach(source ${example_sources})
    get_filename_component(name ${source} NAME_WE)
    add_executable(example_${name} ${source})
    target_link_libraries(example_${name} PRIVATE tulle_flags tulle_shared)
    set_target_properties(example_${name} PROPERTIES OUTPUT_NAME ${name} RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/examples)
endforeach()
