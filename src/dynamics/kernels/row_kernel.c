/* dynamics/kernels/row_kernel.c - one vertex adds up what lies around it, in a fixed order: forces
 * with the three axes side by side, blocks with their six numbers side by side. Between the passes
 * the forces of the system are those so far, and the right-hand side has their sources, f - D w. */
#include "dynamics/row_kernel.h"
#include "math/vertex_lanes.h"

/* ---- blocks ---- */

/* The six numbers of a block. */
typedef struct block6 {
    lanes4 first;
    lanes2 last;
} block6;

/* a I */
SIMD_INLINE block6 block_scalar(double a) { return (block6){{a, 0.0, 0.0, a}, {0.0, a}}; }

SIMD_INLINE block6 block_load(const double *from) {
    block6 block = {.first = lanes4_load(from)};
    memcpy(&block.last, from + 4, sizeof block.last);
    return block;
}

SIMD_INLINE void block_store(double *to, block6 block) {
    memcpy(to, &block.first, sizeof block.first);
    memcpy(to + 4, &block.last, sizeof block.last);
}

SIMD_INLINE block6 block_add(block6 a, block6 b) {
    return (block6){a.first + b.first, a.last + b.last};
}

SIMD_INLINE block6 block_sub(block6 a, block6 b) {
    return (block6){a.first - b.first, a.last - b.last};
}

/* factor g g^T */
SIMD_INLINE block6 block_square(lanes4 g, double factor) {
    lanes4 const scaled = factor * g;
    return (block6){__builtin_shufflevector(scaled, scaled, 0, 0, 0, 1) *
                        __builtin_shufflevector(g, g, 0, 1, 2, 1),
                    __builtin_shufflevector(scaled, scaled, 1, 2) *
                        __builtin_shufflevector(g, g, 2, 2)};
}

/* The drag of a triangle between any two of its corners. */
SIMD_INLINE block6 get_drag(const assembly *work, size_t triangle) {
    return block_square(lanes4_load(&work->terms.triangle_drags[triangle].x), work->alpha);
}

/* What the membrane brings to the block of both ends of an edge. */
SIMD_INLINE block6 get_edge_block(const assembly *work, size_t edge) {
    if (work->spring_blocks) return block_load(work->spring_blocks[edge].m);
    block6 sum = block_scalar(0.0);
    for (size_t side = 0; side < 2; side++) {
        uint32_t const place = work->model->edge_places[2 * edge + side];
        if (place != TULLE_NONE) sum = block_add(sum, block_load(work->membrane_blocks[place].m));
    }
    return sum;
}

/* ---- forces ---- */

/* What a vertex gathers. */
typedef struct row_sums {
    lanes4 force, source; /* f and f - D w */
} row_sums;

SIMD_INLINE lanes4 load_row(const double *values, size_t v) {
    return (lanes4){values[3 * v], values[3 * v + 1], values[3 * v + 2], 0.0};
}

SIMD_INLINE row_sums load_sums(const assembly *work, size_t v) {
    return (row_sums){load_row(work->system->forces, v),
                      load_row(work->system->right_hand_side, v)};
}

SIMD_INLINE void store_sums(const assembly *work, size_t v, const row_sums *sums) {
    if (!work->is_renewed) lanes4_store3(work->system->forces + 3 * v, sums->force);
    lanes4_store3(work->system->right_hand_side + 3 * v, sums->source);
}

/* ---- the matrix, the vertices' own forces and those of the membrane ---- */

SIMD_INLINE void add_spring(const assembly *work, size_t edge, double sign, row_sums *sums) {
    if (work->spring_forces) sums->force += sign * lanes4_load(&work->spring_forces[edge].x);
    sums->source += sign * lanes4_load(&work->spring_sources[edge].x);
}

/* Forces of elements, and the drag on the diagonal. */
SIMD_INLINE block6 add_triangles(const assembly *work, uint32_t v, block6 block, row_sums *sums) {
    const topology *const surface = work->model->surface;
    const adjacency *const uses = &surface->vertex_triangles;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        size_t const triangle = uses->items[k];
        const uint32_t *const corners = surface->triangles + 3 * triangle;
        if (work->membrane_sources) {
            size_t const place =
                3 * triangle + (size_t)(corners[1] == v) + 2 * (size_t)(corners[2] == v);
            if (work->membrane_forces) sums->force += lanes4_load(&work->membrane_forces[place].x);
            sums->source += lanes4_load(&work->membrane_sources[place].x);
        }
        if (work->has_wind) block = block_add(block, get_drag(work, triangle));
    }
    return block;
}

void TULLE_KERNEL(begin_rows)(const assembly *work, size_t begin, size_t end) {
    const cloth_model *const model = work->model;
    const topology *const surface = model->surface;
    block_matrix *const matrix = &work->system->matrix;
    double const alpha = work->alpha, beta = work->beta;
    vec3 const g = work->surroundings->gravity;
    lanes4 const gravity = {g.x, g.y, g.z, 0.0};
    for (size_t v = begin; v < end; v++) {
        /* Mass, gravity and the drag of the air at rest. */
        double const mass = model->masses[v], damping = mass * model->air_damping[v];
        size_t const diagonal = matrix->diagonal_positions[v];
        block6 own = block_scalar(mass + alpha * (damping + model->bend_block_damping[diagonal]) +
                                  beta * model->bend_blocks[diagonal]);
        row_sums sums;
        sums.force = gravity * mass + -damping * load_row(work->state->velocities, v);
        sums.source = sums.force + damping * load_row(work->start_velocities, v);

        /* The membrane, and the blocks off the diagonal, each of which belongs to an edge. */
        const uint32_t *edges = surface->vertex_edges.items + surface->vertex_edges.begin[v];
        for (size_t k = model->block_begin[v]; k < model->block_begin[v + 1]; k++) {
            if (k == diagonal) continue;
            size_t const s = *edges++; /* as neighbours ascend */
            block6 const membrane = get_edge_block(work, s);
            own = block_add(own, membrane);
            block6 const bending =
                block_scalar(alpha * model->bend_block_damping[k] + beta * model->bend_blocks[k]);
            block6 block = block_sub(bending, membrane);
            for (size_t side = 0; work->has_wind && side < 2; side++) {
                uint32_t const triangle = surface->edge_triangles[2 * s + side];
                if (triangle != TULLE_NONE) block = block_add(block, get_drag(work, triangle));
            }
            block_store(matrix->values + BLOCK_NUMBERS * k, block);
            if (work->spring_sources)
                add_spring(work, s, surface->edges[2 * s] == v ? 1.0 : -1.0, &sums);
        }
        own = add_triangles(work, (uint32_t)v, own, &sums);
        block_store(matrix->values + BLOCK_NUMBERS * diagonal, own);
        store_sums(work, v, &sums);
    }
}

/* ---- bending ---- */

/* What the hinges around a vertex push it with. */
SIMD_INLINE void add_hinges(const assembly *work, size_t v, row_sums *sums) {
    const adjacency *const uses = &work->model->vertex_hinges;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        uint32_t const use = uses->items[k], hinge = use / 4;
        lanes4 const push = work->terms.hinge_forces
                                ? lanes4_load(&work->terms.hinge_forces[use].x)
                                : lanes4_load(&work->terms.hinge_moments[hinge].x) *
                                      -work->model->hinges[hinge].weights[use % 4];
        sums->force += push;
        sums->source += push;
    }
}

/* What the turning of normals around a vertex pushes it with: see bending_damping.c. */
SIMD_INLINE void add_turning(const assembly *work, uint32_t v, row_sums *sums) {
    const adjacency *const uses = &work->model->surface->vertex_triangles;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        size_t const triangle = uses->items[k];
        const uint32_t *const corners = work->model->surface->triangles + 3 * triangle;
        const vec3 *const at = work->terms.bend_forces + 2 * triangle; /* on corners 1 and 2 */
        lanes4 const push = corners[0] == v   ? -(lanes4_load(&at[0].x) + lanes4_load(&at[1].x))
                            : corners[1] == v ? lanes4_load(&at[0].x)
                                              : lanes4_load(&at[1].x);
        sums->force += push;
        sums->source += push;
    }
}

/* Minus the bending matrix times the positions. Its rows sum to zero; differences keep rounding
 * small far from the origin. */
SIMD_INLINE void add_elastic(const cloth_model *model, size_t v, const lane_source *positions,
                             row_sums *sums) {
    lanes4 const here = lanes4_get(positions, v);
    lanes4 sum = {0.0, 0.0, 0.0, 0.0};
    for (size_t k = model->scalar_begin[v]; k < model->scalar_begin[v + 1]; k++)
        sum += (lanes4_get(positions, model->scalar_columns[k]) - here) * model->bend_scalars[k];
    for (size_t k = model->block_begin[v]; k < model->block_begin[v + 1]; k++)
        sum += (lanes4_get(positions, model->block_columns[k]) - here) * model->bend_blocks[k];
    sums->force -= sum;
    sums->source -= sum;
}

void TULLE_KERNEL(gather_bending)(const assembly *work, size_t begin, size_t end) {
    const cloth_model *const model = work->model;
    lane_source const starts = lane_source_make(work->start_velocities, model->vertex_count);
    lane_source const positions = lane_source_make(work->state->positions, model->vertex_count);
    for (size_t v = begin; v < end; v++) {
        row_sums sums = load_sums(work, v);
        if (model->bends_by_matrix) add_elastic(model, v, &positions, &sums);
        if (work->terms.hinge_forces || work->terms.hinge_moments) add_hinges(work, v, &sums);
        if (work->terms.bend_forces) add_turning(work, (uint32_t)v, &sums);
        /* The source -D w of the constant matrix. */
        size_t const scalars = model->has_bend_damping ? model->scalar_begin[v + 1] : 0;
        size_t const blocks = model->has_bend_damping ? model->block_begin[v + 1] : 0;
        for (size_t k = model->scalar_begin[v]; k < scalars; k++)
            sums.source +=
                lanes4_get(&starts, model->scalar_columns[k]) * model->bend_scalar_damping[k];
        for (size_t k = model->block_begin[v]; k < blocks; k++)
            sums.source +=
                lanes4_get(&starts, model->block_columns[k]) * model->bend_block_damping[k];
        store_sums(work, v, &sums);
    }
}

/* ---- wind, and the right-hand side ---- */

void TULLE_KERNEL(end_rows)(const assembly *work, size_t begin, size_t end) {
    const motion_state *const state = work->state;
    const adjacency *const uses = &work->model->surface->vertex_triangles;
    double const c = work->share;
    for (size_t v = begin; v < end; v++) {
        row_sums sums = load_sums(work, v);
        for (size_t k = uses->begin[v]; work->has_wind && k < uses->begin[v + 1]; k++) {
            size_t const triangle = uses->items[k];
            if (work->triangle_forces)
                sums.force += lanes4_load(&work->triangle_forces[triangle].x);
            sums.source += lanes4_load(&work->terms.triangle_sources[triangle].x);
        }
        lanes4 start = load_row(state->velocities, v); /* a of the table in compute_forces.c */
        if (work->is_bdf2)
            start = (1.0 - c) * load_row(state->previous_mean, v) + c * (2.0 - c) * start +
                    -c * (1.0 - c) * load_row(state->previous_velocities, v);
        sums.source = start * work->model->masses[v] + work->gamma * sums.source;
        store_sums(work, v, &sums);
    }
}
