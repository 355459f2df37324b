/* dynamics/bending_couplings.h - how hinges are coupled: the constants of the bending energy. Used
 * while the model is built. */
#ifndef TULLE_DYNAMICS_BENDING_COUPLINGS_H
#define TULLE_DYNAMICS_BENDING_COUPLINGS_H

#include "dynamics/cloth_model.h"

#include <stdbool.h>

typedef struct bending_shape {
    const cloth_model_def *def;
    const double *areas;     /* [m^2] at rest, by triangle */
    const double *softening; /* by hinge, in (0, 1]: of slivers */
} bending_shape;

/* Fills the model's couplings, from its hinges and those of its triangles. False: no memory. */
bool bending_build_couplings(memory *heap, const bending_shape *shape, cloth_model *model);

#endif
