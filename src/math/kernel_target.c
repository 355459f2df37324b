/* math/kernel_target.c - see kernel_target.h. */
#include "math/kernel_target.h"

#include <stdatomic.h>

static atomic_int chosen = -1;

static bool is_supported(kernel_target target) {
#ifdef TULLE_HAS_WIDE_KERNELS
    __builtin_cpu_init();
    bool const has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                          __builtin_cpu_supports("bmi2");
    if (target == KERNEL_AVX2) return has_avx2;
    if (target == KERNEL_AVX512)
        return has_avx2 && __builtin_cpu_supports("avx512f") &&
               __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512bw");
#endif
    return target == KERNEL_BASE;
}

kernel_target kernel_target_get(void) {
    int target = atomic_load_explicit(&chosen, memory_order_relaxed);
    if (target < 0) {
        target = KERNEL_AVX512;
        while (!is_supported((kernel_target)target)) target--;
        atomic_store_explicit(&chosen, target, memory_order_relaxed);
    }
    return (kernel_target)target;
}

bool kernel_target_force(kernel_target target) {
    if (!is_supported(target)) return false;
    atomic_store_explicit(&chosen, (int)target, memory_order_relaxed);
    return true;
}
