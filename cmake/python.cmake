# The Python package beside the libraries, in python/tulle of the build directory: PYTHONPATH=build/release/python. Its modules are
# copied, and what follows from the headers is made by python/generate.py. Built with the tests, or by `make python`.
execute_process(COMMAND sh ${PROJECT_SOURCE_DIR}/paper/find_python.sh "cffi, numpy" OUTPUT_VARIABLE tulle_python_program
    OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT tulle_python_program OR CMAKE_CROSSCOMPILING OR TULLE_SANITIZE) # a sanitizer wants to be loaded before Python
    return()
endif()
file(GLOB_RECURSE package_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/python/tulle/*.py)
file(GLOB_RECURSE public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/*.h)
set(package ${PROJECT_BINARY_DIR}/python)
add_custom_command(OUTPUT ${package}/made
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${package}/tulle
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${PROJECT_SOURCE_DIR}/python/tulle ${package}/tulle
    COMMAND ${tulle_python_program} ${PROJECT_SOURCE_DIR}/python/generate.py ${PROJECT_SOURCE_DIR}/include ${package}/tulle
    COMMAND ${CMAKE_COMMAND} -E touch ${package}/made
    DEPENDS ${package_sources} ${public_headers} ${PROJECT_SOURCE_DIR}/python/generate.py ${PROJECT_SOURCE_DIR}/python/field_comments.py VERBATIM)
set(in_all)
if(TULLE_BUILD_TESTS)
    set(in_all ALL)
endif()
add_custom_target(tulle_python ${in_all} DEPENDS ${package}/made)
add_dependencies(tulle_python tulle_shared tulle_io_shared tulle_program)
