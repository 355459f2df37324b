/* dynamics/row_kernel.h - kernels that fill the rows of the linear system, vertex by vertex: bodies
 * of parallel_for, whose context is the assembly. */
#ifndef TULLE_DYNAMICS_ROW_KERNEL_H
#define TULLE_DYNAMICS_ROW_KERNEL_H

#include "dynamics/assembly.h"
#include "math/kernel_target.h"

/* The terms that do not depend on the guess, summed by vertex: gravity, bending, and what patches
 * bring. */
TULLE_DECLARE_KERNEL(void, sum_terms,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))
/* The matrix, for all forces, and the sums with those of the membrane. */
TULLE_DECLARE_KERNEL(void, fill_rows,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))

#endif
