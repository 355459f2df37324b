/* dynamics/kernels/row_kernel.c - one vertex adds up what lies around it, in a fixed order: sources
 * with the three axes side by side, blocks with their six numbers side by side. */
#include "dynamics/row_kernel.h"
#include "math/vertex_lanes.h"

/* ---- blocks ---- */

/* The six numbers of a block. */
typedef struct block6 {
    lanes4 first;
    lanes2 last;
} block6;

/* a I; a is finite. */
SIMD_INLINE block6 block_scalar(double a) {
    return (block6){a * (lanes4){1.0, 0.0, 0.0, 1.0}, a * (lanes2){0.0, 1.0}};
}

SIMD_INLINE block6 block_load(const symmetric3 *from) {
    block6 block = {.first = lanes4_load(from->m)};
    memcpy(&block.last, from->m + 4, sizeof block.last);
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

/* ---- terms ---- */

SIMD_INLINE lanes4 load_row(const double *values, size_t v) {
    return (lanes4){values[3 * v], values[3 * v + 1], values[3 * v + 2], 0.0};
}

/* The sum of the slots around a vertex. */
SIMD_INLINE lanes4 sum_around(const vec3 *slots, const adjacency *uses, size_t v) {
    lanes4 sum = {0.0, 0.0, 0.0, 0.0};
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++)
        sum += lanes4_load(&slots[uses->items[k]].x);
    return sum;
}

/* A row of the bending matrix times the positions. It sums to zero; differences keep rounding small
 * far from the origin. */
SIMD_INLINE lanes4 sum_products(const double *numbers, const uint32_t *columns, size_t begin,
                                size_t end, const double *positions, lanes4 here) {
    lanes4 sum = {0.0, 0.0, 0.0, 0.0};
    for (size_t k = begin; k < end; k++)
        sum += (lanes4_load(positions + 4 * (size_t)columns[k]) - here) * numbers[k];
    return sum;
}

SIMD_INLINE lanes4 apply_bending(const cloth_model *model, size_t v, const double *positions) {
    lanes4 const here = lanes4_load(positions + 4 * v);
    return sum_products(model->bend_scalars, model->scalar_columns, model->scalar_begin[v],
                        model->scalar_begin[v + 1], positions, here) +
           sum_products(model->bend_blocks, model->block_columns, model->block_begin[v],
                        model->block_begin[v + 1], positions, here);
}

void TULLE_KERNEL(sum_terms)(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    const cloth_model *const model = work->model;
    adjacency const corners = {.begin = model->surface->vertex_triangles.begin,
                               .items = model->vertex_corners};
    padded_vertices const padded = work->padded;
    bool const has_elastic = model->has_bending && model->bends_by_matrix;
    vec3 const g = work->surroundings->gravity;
    lanes4 const gravity = {g.x, g.y, g.z, 0.0};
    for (size_t v = begin; v < end; v++) {
        /* Gravity and the drag of the air at rest. */
        double const mass = model->masses[v], damping = mass * model->air_damping[v];
        lanes4 const velocity = lanes4_load(padded.velocities + 4 * v);
        lanes4 const start = lanes4_load(padded.starts + 4 * v);
        lanes4 sum = gravity * mass + damping * (start - velocity);
        if (has_elastic) sum -= apply_bending(model, v, padded.bent);
        if (work->hinge_forces) sum += sum_around(work->hinge_forces, &model->vertex_hinges, v);
        if (work->corner_sources) sum += sum_around(work->corner_sources, &corners, v);
        if (work->far_sources) sum += sum_around(work->far_sources, &model->vertex_fars, v);
        lanes4_store3(&work->terms.sums[v].x, sum);
    }
}

/* ---- rows ---- */

/* What the blocks of a row are made of. */
typedef struct block_sources {
    const symmetric3 *slots;     /* of membrane and wind, negated */
    const uint32_t *edge_places; /* two an edge; of springs null: a slot an edge */
    const double *stiffness, *damping;
    double alpha, beta;
} block_sources;

SIMD_INLINE block6 get_edge_block(const block_sources *from, size_t edge) {
    if (!from->edge_places) return block_load(&from->slots[edge]);
    const uint32_t *const places = from->edge_places + 2 * edge;
    return block_add(block_load(&from->slots[places[0]]), block_load(&from->slots[places[1]]));
}

SIMD_INLINE double get_bending(const block_sources *from, size_t block) {
    return from->alpha * from->damping[block] + from->beta * from->stiffness[block];
}

/* Stores blocks [begin, end) of a row, which belong to these edges. Returns `own` with what they
 * bring to the diagonal. */
SIMD_INLINE block6 fill_blocks(const block_sources *from, const uint32_t *edges, size_t begin,
                               size_t end, double *values, block6 own) {
    for (size_t k = begin; k < end; k++) {
        block6 const block = get_edge_block(from, edges[k - begin]);
        own = block_add(own, block);
        block_store(values + BLOCK_NUMBERS * k,
                    block_sub(block_scalar(get_bending(from, k)), block));
    }
    return own;
}

SIMD_INLINE lanes4 sum_springs(const assembly *work, size_t v) {
    lanes4 sum = {0.0, 0.0, 0.0, 0.0};
    const adjacency *const uses = &work->model->surface->vertex_edges;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        size_t const edge = uses->items[k];
        double const sign = work->model->surface->edges[2 * edge] == v ? 1.0 : -1.0;
        sum += sign * lanes4_load(&work->spring_sources[edge].x);
    }
    return sum;
}

/* Of the drag of a triangle, any two corners have the same. So blocks off the diagonal have brought
 * twice what belongs to it, negated. */
SIMD_INLINE block6 add_drags(const assembly *work, size_t v, block6 own) {
    const adjacency *const uses = &work->model->surface->vertex_triangles;
    for (size_t k = uses->begin[v]; k < uses->begin[v + 1]; k++) {
        lanes4 const g = lanes4_load(&work->terms.triangle_drags[uses->items[k]].x);
        own = block_add(own, block_square(g, 3.0 * work->alpha));
    }
    return own;
}

/* The right-hand side by the table in compute_forces.c. */
SIMD_INLINE lanes4 add_inertia(const assembly *work, size_t v, lanes4 source) {
    const cloth_start *const state = work->state;
    double const c = work->share;
    lanes4 start = load_row(state->velocities, v);
    if (work->is_bdf2)
        start = (1.0 - c) * load_row(state->previous_mean, v) + c * (2.0 - c) * start +
                -c * (1.0 - c) * load_row(state->previous_velocities, v);
    return start * work->model->masses[v] + work->gamma * source;
}

void TULLE_KERNEL(fill_rows)(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    const cloth_model *const model = work->model;
    const topology *const surface = model->surface;
    block_matrix *const matrix = &work->system->matrix;
    adjacency const corners = {.begin = surface->vertex_triangles.begin,
                               .items = model->vertex_corners};
    block_sources const from = {.slots = work->spring_blocks ? work->spring_blocks
                                                             : work->membrane_blocks,
                                .edge_places = work->spring_blocks ? NULL : model->edge_places,
                                .stiffness = model->bend_blocks,
                                .damping = model->bend_block_damping,
                                .alpha = work->alpha,
                                .beta = work->beta};
    for (size_t v = begin; v < end && !work->finds_forces; v++) {
        size_t const diagonal = matrix->diagonal_positions[v], first = model->block_begin[v];
        double const mass = model->masses[v];
        block6 own = block_scalar(mass + work->alpha * (mass * model->air_damping[v]) +
                                  get_bending(&from, diagonal));
        /* Blocks off the diagonal belong to edges, in the order of neighbours. */
        const uint32_t *const edges = surface->vertex_edges.items + surface->vertex_edges.begin[v];
        own = fill_blocks(&from, edges, first, diagonal, matrix->values, own);
        own = fill_blocks(&from, edges + (diagonal - first), diagonal + 1,
                          model->block_begin[v + 1], matrix->values, own);
        if (work->has_wind) own = add_drags(work, v, own);
        block_store(matrix->values + BLOCK_NUMBERS * diagonal, own);
    }
    for (size_t v = begin; v < end; v++) {
        lanes4 sum = lanes4_load(&work->terms.sums[v].x);
        sum += work->membrane_sources ? sum_around(work->membrane_sources, &corners, v)
                                      : sum_springs(work, v);
        lanes4_store3(work->sums + 3 * v, work->finds_forces ? sum : add_inertia(work, v, sum));
    }
}
