/* dynamics/wind_kernel.h - kernel: the wind on a range of triangles, a body of parallel_for whose
 * context is the assembly. */
#ifndef TULLE_DYNAMICS_WIND_KERNEL_H
#define TULLE_DYNAMICS_WIND_KERNEL_H

#include "dynamics/assembly.h"
#include "math/kernel_target.h"

TULLE_DECLARE_KERNEL(void, fill_triangle_wind,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))

#endif
