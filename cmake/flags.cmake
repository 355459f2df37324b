# How every file is compiled: C17, all warnings, no contraction of floating point, so that results have the same bits on
# every machine. Targets link tulle_flags privately.
set(CMAKE_C_STANDARD 17)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)

add_library(tulle_flags INTERFACE)
target_compile_options(tulle_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wvla
    $<$<C_COMPILER_ID:GNU>:-Wdouble-promotion> # clang's would mean INFINITY and NAN, too
    $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes> -ffp-contract=off $<$<BOOL:${TULLE_WARNINGS_AS_ERRORS}>:-Werror>)
# GCC 12 joins products with sums of alternate signs in spite of -ffp-contract=off, where the processor is told to have
# instructions for that, as by -march=native.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64|i.86)$" AND CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
    set(is_narrow $<NOT:$<BOOL:$<TARGET_PROPERTY:TULLE_HAS_AVX512>>>)
    target_compile_options(tulle_flags INTERFACE -mno-fma $<${is_narrow}:-mno-avx512f>)
endif()
if(TULLE_SANITIZE)
    target_compile_options(tulle_flags INTERFACE -fsanitize=${TULLE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(tulle_flags INTERFACE -fsanitize=${TULLE_SANITIZE})
endif()
# What is counted: sources of the libraries and the program, whose targets are in the top folder; not the tests. An inlined
# function would count its branches once more for each place that it is called from.
if(TULLE_COVERAGE)
    set(is_counted $<STREQUAL:$<TARGET_PROPERTY:SOURCE_DIR>,${PROJECT_SOURCE_DIR}>)
    target_compile_options(tulle_flags INTERFACE "$<${is_counted}:--coverage;-fprofile-update=atomic;-fno-inline>")
    target_link_options(tulle_flags INTERFACE --coverage)
endif()
