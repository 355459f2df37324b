/* dynamics/bending_matrix.h - the parts of the cloth model that bending needs: hinges, their
 * couplings, and the constant bending matrix on the system's pattern. Used by cloth_model.c alone.
 */
#ifndef TULLE_DYNAMICS_BENDING_MATRIX_H
#define TULLE_DYNAMICS_BENDING_MATRIX_H

#include "dynamics/cloth_model.h"

/* Borrowed input; areas [m^2] of triangles. */
typedef struct bending_input {
    const topology *surface;
    const double *rest_positions;
    const tulle_material *materials;
    const uint32_t *vertex_materials;
    const double *areas;
} bending_input;

/* Fills model->hinges (allocated, hinge_count) and the couplings. False: no memory. */
bool bending_build_hinges(memory *heap, const bending_input *input, cloth_model *model);

/* From hinges, couplings, vertex_hinges and the block pattern: the scalar pattern and the bending
 * matrix on both patterns. False: no memory; bending_destroy then releases what there is. */
bool bending_build_matrix(memory *heap, cloth_model *model);
void bending_destroy(memory *heap, cloth_model *model);

#endif
