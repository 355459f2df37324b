/* dynamics/kernels/bending_kernel.c - vectors and moments of hinges, and what vertices gather of
 * them: the three axes side by side. */
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
        lanes4 const elastic = sum_couplings(work->model, h, work->hinge_deviations);
        lanes4 damping = {0.0, 0.0, 0.0, 0.0};
        for (int side = 0; side < 2 && work->bend_dampings; side++) {
            uint32_t const place = work->model->hinges[h].sides[side];
            const bend_damping_response *const in = &work->bend_dampings[place / 3];
            damping += lanes4_load(&in->normal.x) * in->moments[place % 3];
        }
        lanes4_store3(&work->terms.hinge_moments[h].x, elastic + damping);
    }
}

/* ---- vertices ---- */

/* The three numbers of a vertex. */
SIMD_INLINE lanes4 load_row(const double *values, size_t v) {
    return (lanes4){values[3 * v], values[3 * v + 1], values[3 * v + 2], 0.0};
}

/* What the hinges around a vertex push it with. */
SIMD_INLINE void add_hinges(const assembly *work, size_t v, lanes4 *force, lanes4 *source) {
    const adjacency *const uses = &work->model->vertex_hinges;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        uint32_t const use = uses->items[k], hinge = use / 4;
        lanes4 const push = work->terms.hinge_forces
                                ? lanes4_load(&work->terms.hinge_forces[use].x)
                                : lanes4_load(&work->terms.hinge_moments[hinge].x) *
                                      -work->model->hinges[hinge].weights[use % 4];
        *force += push;
        *source += push;
    }
}

/* What the turning of normals around a vertex pushes it with: see bending_damping.c. */
SIMD_INLINE void add_turning(const assembly *work, uint32_t v, lanes4 *force, lanes4 *source) {
    const adjacency *const uses = &work->model->surface->vertex_triangles;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        size_t const triangle = uses->items[k];
        const uint32_t *const corners = work->model->surface->triangles + 3 * triangle;
        const vec3 *const at = work->terms.bend_forces + 2 * triangle; /* on corners 1 and 2 */
        lanes4 const push = corners[0] == v   ? -(lanes4_load(&at[0].x) + lanes4_load(&at[1].x))
                            : corners[1] == v ? lanes4_load(&at[0].x)
                                              : lanes4_load(&at[1].x);
        *force += push;
        *source += push;
    }
}

void TULLE_KERNEL(gather_bending)(const assembly *work, size_t begin, size_t end) {
    const cloth_model *const model = work->model;
    linear_system *const system = work->system;
    lane_source const starts = lane_source_make(work->start_velocities, model->vertex_count);
    for (size_t v = begin; v < end; v++) {
        lanes4 force = load_row(system->forces, v), source = load_row(system->right_hand_side, v);
        add_hinges(work, v, &force, &source);
        if (work->terms.bend_forces) add_turning(work, (uint32_t)v, &force, &source);
        /* The source -D w of the constant matrix. */
        for (size_t k = model->scalar_begin[v]; k < model->scalar_begin[v + 1]; k++)
            source += lanes4_get(&starts, model->scalar_columns[k]) * model->bend_scalar_damping[k];
        for (size_t k = model->block_begin[v]; k < model->block_begin[v + 1]; k++)
            source += lanes4_get(&starts, model->block_columns[k]) * model->bend_block_damping[k];
        if (!work->is_renewed) lanes4_store3(system->forces + 3 * v, force);
        lanes4_store3(system->right_hand_side + 3 * v, source);
    }
}
