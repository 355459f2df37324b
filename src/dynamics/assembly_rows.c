/* dynamics/assembly_rows.c - each vertex gathers its row of the matrix and of the right-hand side
 * from the slots of its elements, in a fixed order: springs, hinges, triangles. */
#include "dynamics/assembly.h"

#include <math.h>

/* Adds the drag of a triangle to a block. */
static inline void add_drag(const assembly *work, uint32_t triangle, symmetric3 *block) {
    if (triangle == TULLE_NONE) return;
    vec3 const g = work->terms.triangle_drags[triangle];
    symmetric3 const drag = symmetric3_make(0.0, work->factor.alpha, g);
    symmetric3_add(block, &drag);
}

static void store_block(linear_system *system, size_t position, const symmetric3 *block) {
    for (size_t i = 0; i < BLOCK_NUMBERS; i++)
        system->matrix.values[BLOCK_NUMBERS * position + i] = block->m[i];
}

/* What a vertex gathers. */
typedef struct vertex_sum {
    vec3 force, source; /* f and f - D w */
    symmetric3 diagonal;
} vertex_sum;

/* Forces and sources so far; the diagonal has the springs' part from the first pass. */
static void load_sum(const linear_system *system, size_t vertex, vertex_sum *sum) {
    sum->force = vec3_load(system->forces, vertex);
    sum->source = vec3_load(system->right_hand_side, vertex);
}

static void store_sum(linear_system *system, size_t vertex, const vertex_sum *sum) {
    vec3_store(system->forces, vertex, sum->force);
    vec3_store(system->right_hand_side, vertex, sum->source);
}

/* Blocks of one row off the diagonal, and the springs' part of the sums. */
static void gather_springs(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    const adjacency *const around = &model->surface->vertex_edges;
    const uint32_t *edges = around->items + around->begin[vertex]; /* as neighbours ascend */
    for (size_t k = model->block_begin[vertex]; k < model->block_begin[vertex + 1]; k++) {
        if (model->block_columns[k] == vertex) continue;
        uint32_t const s = *edges++;
        const cloth_spring *const spring = &model->springs[s];
        double const sign = spring->vertices[0] == vertex ? 1.0 : -1.0;
        if (work->spring_forces)
            sum->force = vec3_add_scaled(sum->force, work->spring_forces[s], sign);
        sum->source = vec3_add_scaled(sum->source, work->spring_sources[s], sign);
        symmetric3_add(&sum->diagonal, &work->spring_blocks[s]);
        double const bend = work->factor.alpha * model->bend_block_damping[k] +
                            work->factor.beta * model->bend_blocks[k];
        symmetric3 block = symmetric3_make(bend, 0.0, (vec3){0.0, 0.0, 0.0});
        for (int i = 0; i < 6; i++) block.m[i] -= work->spring_blocks[s].m[i];
        if (work->has_wind) {
            add_drag(work, model->surface->edge_triangles[2 * (size_t)s], &block);
            add_drag(work, model->surface->edge_triangles[2 * (size_t)s + 1], &block);
        }
        store_block(work->system, k, &block);
    }
}

/* Forces of hinges, and the source -D w of bending damping. */
static void gather_hinges(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    for (size_t k = model->vertex_hinges.begin[vertex]; k < model->vertex_hinges.begin[vertex + 1];
         k++) {
        uint32_t const use = model->vertex_hinges.items[k];
        vec3 const force = work->terms.hinge_forces
                               ? work->terms.hinge_forces[use]
                               : bend_get_flat_force(&model->hinges[use / 4], use % 4,
                                                     work->terms.hinge_moments[use / 4]);
        sum->force = vec3_add(sum->force, force);
        sum->source = vec3_add(sum->source, force);
    }
    const adjacency *const uses = &model->surface->vertex_triangles;
    for (size_t k = uses->begin[vertex]; work->terms.bend_forces && k < uses->begin[vertex + 1];
         k++) {
        uint32_t const triangle = uses->items[k];
        const uint32_t *const corners = cloth_get_corners(model, triangle);
        size_t const corner = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
        vec3 const force = bend_get_damping_force(work->terms.bend_forces + 2 * triangle, corner);
        sum->force = vec3_add(sum->force, force);
        sum->source = vec3_add(sum->source, force);
    }
    for (size_t k = model->scalar_begin[vertex]; k < model->scalar_begin[vertex + 1]; k++) {
        sum->source = vec3_add_scaled(sum->source,
                                      vec3_load(work->start_velocities, model->scalar_columns[k]),
                                      model->bend_scalar_damping[k]);
    }
    for (size_t k = model->block_begin[vertex]; k < model->block_begin[vertex + 1]; k++)
        sum->source =
            vec3_add_scaled(sum->source, vec3_load(work->start_velocities, model->block_columns[k]),
                            model->bend_block_damping[k]);
}

static void gather_triangles(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const adjacency *const uses = &work->model->surface->vertex_triangles;
    for (size_t k = uses->begin[vertex]; k < uses->begin[vertex + 1]; k++) {
        uint32_t const triangle = uses->items[k];
        if (work->triangle_forces)
            sum->force = vec3_add(sum->force, work->triangle_forces[triangle]);
        sum->source = vec3_add(sum->source, work->terms.triangle_sources[triangle]);
    }
}

static void add_drags(const assembly *work, uint32_t vertex, symmetric3 *diagonal) {
    const adjacency *const uses = &work->model->surface->vertex_triangles;
    for (size_t k = uses->begin[vertex]; k < uses->begin[vertex + 1]; k++)
        add_drag(work, uses->items[k], diagonal);
}

/* M a of the table in compute_forces.c, divided by the mass. */
static vec3 get_start(const assembly *work, uint32_t vertex) {
    const motion_state *const state = work->state;
    vec3 const v0 = vec3_load(state->velocities, vertex);
    if (!work->is_bdf2) return v0;
    double const c = work->factor.share;
    vec3 const mean = vec3_load(state->previous_mean, vertex);
    vec3 const previous = vec3_load(state->previous_velocities, vertex);
    vec3 const start = vec3_add_scaled(vec3_scale(mean, 1.0 - c), v0, c * (2.0 - c));
    return vec3_add_scaled(start, previous, -c * (1.0 - c));
}

/* The row of the matrix, and sums of the vertex itself and its springs. */
static void fill_row(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    linear_system *const system = work->system;
    double const mass = model->masses[vertex], damping = mass * model->air_damping[vertex];
    vec3 const w = vec3_load(work->start_velocities, vertex);
    size_t const position = system->matrix.diagonal_positions[vertex];
    double const own = mass + work->factor.alpha * (damping + model->bend_block_damping[position]) +
                       work->factor.beta * model->bend_blocks[position];
    sum->diagonal = symmetric3_make(own, 0.0, (vec3){0.0, 0.0, 0.0});
    sum->force = vec3_add_scaled(vec3_scale(work->surroundings->gravity, mass),
                                 vec3_load(work->state->velocities, vertex), -damping);
    sum->source = vec3_add_scaled(sum->force, w, damping);
    gather_springs(work, vertex, sum);
    if (work->has_wind) add_drags(work, vertex, &sum->diagonal);
    store_block(system, position, &sum->diagonal);
}

/* The right-hand side from all sources. */
static void finish_source(const assembly *work, uint32_t vertex, vec3 source) {
    vec3_store(work->system->right_hand_side, vertex,
               vec3_add_scaled(vec3_scale(get_start(work, vertex), work->model->masses[vertex]),
                               source, work->factor.gamma));
}

void assembly_gather_springs(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    for (size_t v = begin; v < end; v++) {
        vertex_sum sum;
        fill_row(work, (uint32_t)v, &sum);
        store_sum(work->system, v, &sum);
    }
}

void assembly_gather_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    for (size_t v = begin; v < end; v++) {
        vertex_sum sum;
        load_sum(work->system, v, &sum);
        gather_hinges(work, (uint32_t)v, &sum);
        store_sum(work->system, v, &sum);
    }
}

void assembly_finish_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    linear_system *const system = work->system;
    for (size_t v = begin; v < end; v++) {
        uint32_t const vertex = (uint32_t)v;
        vertex_sum sum;
        load_sum(system, v, &sum);
        if (work->has_wind) gather_triangles(work, vertex, &sum);
        vec3_store(system->forces, v, sum.force);
        finish_source(work, vertex, sum.source);
    }
}

void assembly_renew_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    for (size_t v = begin; v < end; v++) {
        uint32_t const vertex = (uint32_t)v;
        vertex_sum sum;
        fill_row(work, vertex, &sum);
        if (work->model->has_bending) gather_hinges(work, vertex, &sum);
        if (work->has_wind) gather_triangles(work, vertex, &sum);
        finish_source(work, vertex, sum.source);
    }
}
