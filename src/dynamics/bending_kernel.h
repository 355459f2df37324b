/* dynamics/bending_kernel.h - kernels of bending: bodies of parallel_for over hinges and triangles,
 * whose context is the assembly. */
#ifndef TULLE_DYNAMICS_BENDING_KERNEL_H
#define TULLE_DYNAMICS_BENDING_KERNEL_H

#include "dynamics/assembly.h"
#include "math/kernel_target.h"

/* c of hinges and, where there is damping, its rate. */
TULLE_DECLARE_KERNEL(void, fill_hinge_vectors,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))
/* The moments of hinges, where all are flat at rest. */
TULLE_DECLARE_KERNEL(void, fill_hinge_moments,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))
/* Damping in triangles, see kernels/bending_damping.c. */
TULLE_DECLARE_KERNEL(void, fill_bending_damping,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))

#endif
