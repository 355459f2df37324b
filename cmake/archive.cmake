# tulle_add_archive(NAME PARTS...): a static library of object libraries whose only global names are those of the public headers.
#
# All objects become one, in which the names of hidden visibility are made local; so a host may have functions of the
# same names. Without objcopy, and where gcov or sanitizers have added names of their own, the library holds the objects
# as they are.
set(has_hidden_names OFF)
if(CMAKE_OBJCOPY AND CMAKE_C_COMPILER_ID MATCHES "GNU|Clang" AND NOT APPLE AND NOT TULLE_SANITIZE AND NOT TULLE_COVERAGE)
    set(has_hidden_names ON)
endif()
if(NOT has_hidden_names AND NOT TULLE_SANITIZE AND NOT TULLE_COVERAGE)
    message(STATUS "objcopy is not there: the static libraries show their inner names")
endif()

function(tulle_add_archive name)
    list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
    if(NOT has_hidden_names)
        add_library(${name} STATIC ${objects})
    else()
        set(whole ${CMAKE_CURRENT_BINARY_DIR}/${name}.o)
        separate_arguments(flags NATIVE_COMMAND "${CMAKE_C_FLAGS}")
        add_custom_command(OUTPUT ${whole}
            COMMAND ${CMAKE_C_COMPILER} ${flags} -r -nostdlib -Wl,--force-group-allocation -o ${whole} ${objects}
            COMMAND ${CMAKE_OBJCOPY} --localize-hidden ${whole}
            DEPENDS ${objects} COMMAND_EXPAND_LISTS VERBATIM)
        add_library(${name} STATIC ${whole})
        add_dependencies(${name} ${ARGN})
    endif()
    set_target_properties(${name} PROPERTIES LINKER_LANGUAGE C)
endfunction()
