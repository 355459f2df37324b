/* math/kernel_target.h - which of the variants of a kernel runs. Kernels (files in a folder
 * `kernels`) are compiled once for each vector width, see cmake/kernels.cmake; they use vectors of
 * a fixed number of lanes without contraction, so each variant gives the same bits. */
#ifndef TULLE_MATH_KERNEL_TARGET_H
#define TULLE_MATH_KERNEL_TARGET_H

#include <stdbool.h>

typedef enum kernel_target {
    KERNEL_BASE,
    KERNEL_AVX2,
    KERNEL_AVX512,
    KERNEL_TARGET_COUNT
} kernel_target;

/* The widest that this processor has, or the one that was forced. */
kernel_target kernel_target_get(void);
/* For tests: forces a target; false when the processor lacks it. Not thread-safe. */
bool kernel_target_force(kernel_target target);

/* Inside kernels: the name of this variant. */
#ifdef TULLE_KERNEL_TARGET
#define TULLE_KERNEL_JOIN(name, target) name##_##target
#define TULLE_KERNEL_NAME(name, target) TULLE_KERNEL_JOIN(name, target)
#define TULLE_KERNEL(name) TULLE_KERNEL_NAME(name, TULLE_KERNEL_TARGET)
#endif

/* Outside: declares all variants of a kernel with one prototype, and picks one. */
#ifdef TULLE_HAS_WIDE_KERNELS
#define TULLE_DECLARE_KERNEL(result, name, parameters)                                             \
    result name##_base parameters;                                                                 \
    result name##_avx2 parameters;                                                                 \
    result name##_avx512 parameters;
#define TULLE_PICK_KERNEL(name)                                                                    \
    (kernel_target_get() == KERNEL_AVX512 ? name##_avx512                                          \
     : kernel_target_get() == KERNEL_AVX2 ? name##_avx2                                            \
                                          : name##_base)
#else
#define TULLE_DECLARE_KERNEL(result, name, parameters) result name##_base parameters;
#define TULLE_PICK_KERNEL(name) name##_base
#endif

#endif
