/* math/vector_width.h - compiles a kernel for several vector widths, chosen when the program loads.
 * The kernels are written with vectors of a fixed number of lanes and without contraction, so each
 * width gives the same bits. */
#ifndef TULLE_MATH_VECTOR_WIDTH_H
#define TULLE_MATH_VECTOR_WIDTH_H

/* Sanitizers instrument the selecting function before they are ready to run, so they get one width.
 */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__linux__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TULLE_VECTOR_CLONES __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define TULLE_VECTOR_CLONES
#endif

/* Four doubles, loaded from any address of a double. */
typedef double lanes4 __attribute__((vector_size(32), aligned(8), may_alias));

#endif
