# libtulle, shared and static, from the same object files: every folder of src/ but scene/, render/ and app/.
set(library_sources)
foreach(folder base math geom detect dynamics contact world check io)
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

add_library(tulle_objects OBJECT ${library_sources})
target_include_directories(tulle_objects PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
target_compile_definitions(tulle_objects PRIVATE TULLE_BUILD_SHARED)
target_link_libraries(tulle_objects PRIVATE tulle_flags)
set_target_properties(tulle_objects PROPERTIES POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET hidden)

set(tulle_private_libraries m)
if(TULLE_THREADS STREQUAL "openmp")
    find_package(OpenMP REQUIRED COMPONENTS C)
    target_compile_options(tulle_objects PRIVATE ${OpenMP_C_FLAGS})
    list(PREPEND tulle_private_libraries ${OpenMP_C_LIB_NAMES})
elseif(TULLE_THREADS STREQUAL "pthreads")
    list(PREPEND tulle_private_libraries pthread)
endif()

include(cmake/kernels.cmake)
add_library(tulle_static STATIC $<TARGET_OBJECTS:tulle_objects> ${tulle_kernel_objects})
add_library(tulle_shared SHARED $<TARGET_OBJECTS:tulle_objects> ${tulle_kernel_objects})
foreach(library tulle_static tulle_shared)
    set_target_properties(${library} PROPERTIES OUTPUT_NAME tulle LINKER_LANGUAGE C)
    target_include_directories(${library} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()
target_link_libraries(tulle_static INTERFACE ${tulle_private_libraries})
target_link_libraries(tulle_shared PRIVATE ${tulle_private_libraries} tulle_flags)
if(NOT TULLE_SANITIZE)
    target_link_options(tulle_shared PRIVATE -Wl,--no-undefined)
endif()
set_target_properties(tulle_shared PROPERTIES VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} EXPORT_NAME tulle)
set_target_properties(tulle_static PROPERTIES EXPORT_NAME tulle_static)
add_library(tulle::tulle ALIAS tulle_shared)
add_library(tulle::tulle_static ALIAS tulle_static)
