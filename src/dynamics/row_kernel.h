/* dynamics/row_kernel.h - kernels that fill the rows of the linear system, vertex by vertex. */
#ifndef TULLE_DYNAMICS_ROW_KERNEL_H
#define TULLE_DYNAMICS_ROW_KERNEL_H

#include "dynamics/assembly.h"
#include "math/kernel_target.h"

/* Fills rows of the matrix, for all forces, and starts the sums of forces and sources with the
 * vertices' own and those of the membrane. */
TULLE_DECLARE_KERNEL(void, begin_rows, (const assembly *work, size_t begin, size_t end))
/* Adds to the sums what bending and its damping bring. */
TULLE_DECLARE_KERNEL(void, gather_bending, (const assembly *work, size_t begin, size_t end))
/* Adds what wind brings, and makes the right-hand side of the sources. */
TULLE_DECLARE_KERNEL(void, end_rows, (const assembly *work, size_t begin, size_t end))

#endif
