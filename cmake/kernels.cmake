# Files of src/**/kernels/ are compiled once for each vector width of the processor family; the program picks one when it
# runs. Every function in them carries the name TULLE_KERNEL(name), so name_base, name_avx2, name_avx512.
file(GLOB_RECURSE kernel_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/*.c)
list(FILTER kernel_sources INCLUDE REGEX "/kernels/")
set(tulle_kernel_targets base)
# The memory sanitizer takes all lanes of a vector's comparison for undefined where one is, also those that are masked out:
# it is given plain C.
if(NOT TULLE_SANITIZE MATCHES "memory" AND CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$" AND CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
    list(APPEND tulle_kernel_targets avx2 avx512)
    target_compile_definitions(tulle_flags INTERFACE TULLE_HAS_WIDE_KERNELS)
endif()
set(kernel_flags_base $<$<STREQUAL:${TULLE_SANITIZE},memory>:-U__SSE2__>)
set(kernel_flags_avx2 -mavx2 -mbmi -mbmi2)
set(kernel_flags_avx512 -mavx2 -mbmi -mbmi2 -mavx512f -mavx512vl -mavx512dq -mavx512bw -mprefer-vector-width=512)

set(tulle_kernel_parts)
if(kernel_sources)
    foreach(target ${tulle_kernel_targets})
        set(library tulle_kernels_${target})
        tulle_add_objects(${library} ${kernel_sources})
        target_compile_definitions(${library} PRIVATE TULLE_KERNEL_TARGET=${target})
        target_compile_options(${library} PRIVATE -Wno-psabi ${kernel_flags_${target}})
        list(APPEND tulle_kernel_parts ${library})
    endforeach()
endif()
