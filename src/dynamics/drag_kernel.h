/* dynamics/drag_kernel.h - a kernel of what triangles bring wherever the membrane is linearised:
 * the drag of the air, and damping of bending. */
#ifndef TULLE_DYNAMICS_DRAG_KERNEL_H
#define TULLE_DYNAMICS_DRAG_KERNEL_H

#include "dynamics/assembly.h"
#include "math/kernel_target.h"

/* A body of parallel_for over triangles, whose context is the assembly. `begin` is a multiple of
 * PATCH_LANES. */
TULLE_DECLARE_KERNEL(void, fill_drag,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))

#endif
