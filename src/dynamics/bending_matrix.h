/* dynamics/bending_matrix.h - the parts of the cloth model that bending needs: hinges, their
 * couplings, and the constant bending matrix on the system's pattern. Used by cloth_model.c alone.
 */
#ifndef TULLE_DYNAMICS_BENDING_MATRIX_H
#define TULLE_DYNAMICS_BENDING_MATRIX_H

#include "dynamics/cloth_model.h"

/* Fills model->hinges (allocated, hinge_count), the hinges of triangles and of vertices, the
 * couplings and, where there is damping, patches, from the triangles' rest areas [m^2]. False: no
 * memory. */
bool bending_build_hinges(memory *heap, const cloth_model_def *def, const double *areas,
                          cloth_model *model);

/* From hinges, couplings, vertex_hinges and the block pattern: the scalar pattern and the bending
 * matrix on both patterns. False: no memory. */
bool bending_build_matrix(memory *heap, cloth_model *model);

/* Each of these may be called again. */
void bending_release_patches(memory *heap, cloth_model *model);
void bending_release_hinges(memory *heap, cloth_model *model);

#endif
