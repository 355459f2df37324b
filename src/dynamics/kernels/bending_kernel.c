/* dynamics/kernels/bending_kernel.c - vectors and moments of hinges, the three axes side by
 * side. */
#include "dynamics/bending_kernel.h"
#include "math/vertex_lanes.h"

/* As bend_sum_corners. */
SIMD_INLINE lanes4 sum_corners(const cloth_hinge *hinge, const lane_source *values) {
    lanes4 const origin = lanes4_get(values, hinge->vertices[0]);
    lanes4 sum = {0.0, 0.0, 0.0, 0.0};
    for (int k = 1; k < 4; k++)
        sum += hinge->weights[k] * (lanes4_get(values, hinge->vertices[k]) - origin);
    return sum;
}

void TULLE_KERNEL(fill_hinge_vectors)(void *context, size_t begin, size_t end, size_t chunk,
                                      int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    size_t const count = work->model->vertex_count;
    lane_source const positions = lane_source_make(work->state->positions, count);
    lane_source const velocities = lane_source_make(work->state->velocities, count);
    for (size_t h = begin; h < end; h++) {
        const cloth_hinge *const hinge = &work->model->hinges[h];
        lanes4_store3(&work->hinge_vectors[h].x, sum_corners(hinge, &positions));
        if (work->hinge_rates)
            lanes4_store3(&work->hinge_rates[h].x, sum_corners(hinge, &velocities));
    }
}

/* The elastic moment of a hinge, as bend_compute_moment. */
SIMD_INLINE lanes4 sum_couplings(const cloth_model *model, size_t h, const vec3 *deviations) {
    lanes4 moment = {0.0, 0.0, 0.0, 0.0};
    if (model->couplings) {
        for (size_t k = model->coupling_begin[h]; k < model->coupling_begin[h + 1]; k++)
            moment += model->couplings[k] * lanes4_load(&deviations[model->coupling_hinges[k]].x);
        return moment;
    }
    uint32_t hinges[HINGE_COUPLINGS];
    size_t places[HINGE_COUPLINGS];
    size_t const count = bend_list_sides(model, h, hinges, places);
    for (size_t k = 0; k < count; k++)
        moment += model->side_couplings[places[k]] * lanes4_load(&deviations[hinges[k]].x);
    return moment;
}

void TULLE_KERNEL(fill_hinge_moments)(void *context, size_t begin, size_t end, size_t chunk,
                                      int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    for (size_t h = begin; h < end; h++) {
        lanes4 elastic = {0.0, 0.0, 0.0, 0.0};
        if (!work->model->bends_by_matrix)
            elastic = sum_couplings(work->model, h, work->hinge_deviations);
        lanes4 damping = {0.0, 0.0, 0.0, 0.0};
        for (int side = 0; side < 2 && work->bend_dampings; side++) {
            uint32_t const place = work->model->hinges[h].sides[side];
            const bend_damping_response *const in = &work->bend_dampings[place / 3];
            damping += lanes4_load(&in->normal.x) * in->moments[place % 3];
        }
        lanes4_store3(&work->terms.hinge_moments[h].x, elastic + damping);
    }
}
