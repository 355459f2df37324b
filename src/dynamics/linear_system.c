/* dynamics/linear_system.c - storage and use of the system that compute_forces fills: the end
 * velocities of each integrator. */
#include "dynamics/compute_forces.h"
#include "dynamics/hysteresis.h"

tulle_status linear_system_build(memory *heap, const cloth_model *model, bool has_forces,
                                 linear_system *system) {
    linear_system result = {.vertex_count = model->vertex_count};
    block_pattern const blocks = {model->block_begin, model->block_columns};
    block_pattern const scalars = {model->scalar_begin, model->scalar_columns};
    tulle_status const status =
        block_matrix_build(heap, model->vertex_count, blocks, scalars, &result.matrix);
    if (status != TULLE_OK) return status;
    result.matrix.scalar_parts[0] = model->bend_scalar_damping;
    result.matrix.scalar_parts[1] = model->bend_scalars;
    result.right_hand_side = memory_allocate_zeroed(heap, 3 * model->vertex_count, sizeof(double));
    if (has_forces)
        result.forces = memory_allocate_zeroed(heap, 3 * model->vertex_count, sizeof(double));
    bool const has_sliders = model->sliders && model->sliders->has_bend;
    if (has_sliders)
        result.slider_scalars = memory_allocate(heap, model->scalar_count * sizeof(double));
    result.scalar_count = model->scalar_count;
    if (!result.right_hand_side || (has_forces && !result.forces) ||
        (has_sliders && !result.slider_scalars)) {
        linear_system_destroy(heap, &result);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    *system = result;
    return TULLE_OK;
}

void linear_system_destroy(memory *heap, linear_system *system) {
    size_t const count = system->vertex_count;
    block_matrix_destroy(heap, &system->matrix);
    memory_release(heap, system->right_hand_side, 3 * count * sizeof(double));
    memory_release(heap, system->forces, 3 * count * sizeof(double));
    memory_release(heap, system->slider_scalars, system->scalar_count * sizeof(double));
    *system = (linear_system){0};
}

void finish_velocities(const linear_system *system, const cloth_start *state, size_t vertex_count,
                       const double *mean, double *velocities) {
    for (size_t i = 0; i < 3 * vertex_count; i++) {
        double const u = mean[i];
        if (system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON)
            velocities[i] = state->velocities[i] + (u - state->velocities[i]) / system->share;
        else if (system->integrator == TULLE_INTEGRATOR_BDF2)
            velocities[i] = (u - (1.0 - system->share) * state->previous_mean[i]) / system->share;
        else
            velocities[i] = u;
    }
}
