/* dynamics/wind.c - wind drag and seeded gusts: the force on triangles, and its work in a step.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 5 (drag -k_f |w| (n . w) n per area, w relative to the air). The gusts are value
 * noise after Perlin, An image synthesizer, 1985: random vectors on a lattice in space and time,
 * blended smoothly. Departure: the blend is divided by the root of the sum of squared weights, so
 * the standard deviation is the same everywhere and not smaller between lattice points. */
#include "dynamics/assembly.h"

#include "base/hash.h"
#include "base/parallel.h"

#include <math.h>

/* Lattice spacing over correlation length: makes the mean correlation 1/e at that distance. */
static const double SPACING_PER_LENGTH = 1.215;

/* Random values at the 16 points of a lattice cell, each of mean 0 and variance 1 within [-3, 3]:
 * the sum of three uniform ones in [-1, 1]. */
static void fill_cell(uint64_t seed, const int64_t corner[4], gust_cell *cell) {
    cell->is_filled = true;
    for (int axis = 0; axis < 4; axis++) cell->corner[axis] = corner[axis];
    for (int point = 0; point < 16; point++) {
        uint64_t key = hash_mix(seed + UINT64_C(0x9e3779b97f4a7c15));
        for (int axis = 0; axis < 4; axis++)
            key = hash_mix(key ^ ((uint64_t)(corner[axis] + ((point >> axis) & 1)) +
                                  UINT64_C(0x9e3779b97f4a7c15) * (uint64_t)(axis + 1)));
        for (int i = 0; i < 3; i++) {
            uint64_t const bits = hash_mix(key + (uint64_t)i + 1);
            double sum = 0.0;
            for (int part = 0; part < 3; part++)
                sum += (double)((bits >> (21 * part)) & 0x1fffff) * (2.0 / 0x1fffff) - 1.0;
            cell->values[point][i] = sum;
        }
    }
}

vec3 wind_compute_velocity(const tulle_wind *wind, vec3 place, double time, gust_cell *cell) {
    vec3 const mean = {wind->velocity[0], wind->velocity[1], wind->velocity[2]};
    if (!(wind->gust_strength > 0.0)) return mean;
    double const spacing = SPACING_PER_LENGTH * wind->gust_length;
    double const coordinates[4] = {place.x / spacing, place.y / spacing, place.z / spacing,
                                   time / (SPACING_PER_LENGTH * wind->gust_time)};
    /* Lattice point, and weights of both sides by the smoothed fraction 3 s^2 - 2 s^3. Places
     * beyond 2^53 spacings have no fraction left; they are held inside the range of the integer. */
    int64_t corner[4];
    double parts[4][2];
    bool is_same = cell->is_filled;
    for (int axis = 0; axis < 4; axis++) {
        double const value = coordinates[axis], above = value > -9e15 ? value : -9e15;
        double const limited = above < 9e15 ? above : 9e15, whole = (double)(int64_t)limited;
        double const base = whole > limited ? whole - 1.0 : whole, s = limited - base;
        corner[axis] = (int64_t)base;
        is_same = is_same && corner[axis] == cell->corner[axis];
        parts[axis][1] = s * s * (3.0 - 2.0 * s);
        parts[axis][0] = 1.0 - parts[axis][1];
    }
    if (!is_same) fill_cell(wind->seed, corner, cell);
    vec3 sum = {0.0, 0.0, 0.0};
    double squares = 0.0;
    double const sides[4] = {parts[0][0] * parts[1][0], parts[0][1] * parts[1][0],
                             parts[0][0] * parts[1][1], parts[0][1] * parts[1][1]};
    for (int point = 0; point < 16; point++) {
        double const weight = sides[point & 3] * parts[2][point >> 2 & 1] * parts[3][point >> 3];
        sum = vec3_add_scaled(sum, vec3_load(cell->values[point], 0), weight);
        squares += weight * weight;
    }
    return vec3_add_scaled(mean, sum, wind->gust_strength / sqrt(squares));
}

/* ---- the air ---- */

/* The air at each vertex. */
typedef struct air_samples {
    const tulle_wind *wind;
    const cloth_start *state;
    vec3 *velocities; /* [m/s] */
} air_samples;

static void sample_air(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const air_samples *const air = context;
    gust_cell cell = {0};
    for (size_t v = begin; v < end; v++)
        air->velocities[v] = wind_compute_velocity(air->wind, vec3_load(air->state->positions, v),
                                                   air->state->time, &cell);
}

bool fill_air(assembly *work) {
    if (!work->terms.air_velocities) return true;
    air_samples air = {&work->surroundings->wind, work->state, work->terms.air_velocities};
    parallel_for(work->model->vertex_count, VERTICES_PER_CHUNK, work->threads, sample_air, &air);
    return true;
}

/* ---- its work ----
 *
 * The linear system continues the force on a triangle from (x0, v0) to the mean velocity of the
 * step. It does so by the part of the force's derivative that the matrix holds, along the normal at
 * x0. The work is negative where the air slows the cloth. */

typedef struct work_task {
    const cloth_model *model;
    const cloth_start *state;
    const tulle_wind *wind;
    const double *mean;
    const vec3 *air; /* [m/s] at each vertex */
    double *sums;    /* by chunk */
} work_task;

static void measure_triangles(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    work_task *const task = context;
    const cloth_start *const state = task->state;
    double sum = 0.0;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *const vertices = task->model->surface->triangles + 3 * t;
        vec3 corners[3], relative = {0.0, 0.0, 0.0}, start = relative, mean = relative;
        for (int k = 0; k < 3; k++) {
            size_t const v = vertices[k];
            vec3 const velocity = vec3_load(state->velocities, v);
            corners[k] = vec3_load(state->positions, v);
            start = vec3_add_scaled(start, velocity, 1.0 / 3.0);
            relative = vec3_add_scaled(relative, vec3_sub(velocity, task->air[v]), 1.0 / 3.0);
            mean = vec3_add_scaled(mean, vec3_load(task->mean, v), 1.0 / 3.0);
        }
        wind_response const response =
            wind_evaluate(task->wind->drag_coefficient, corners, relative);
        double const change = vec3_dot(response.normal, vec3_sub(mean, start));
        vec3 const force =
            vec3_add_scaled(response.force, response.normal, -response.drag * change);
        sum += vec3_dot(force, mean);
    }
    task->sums[chunk] = sum;
}

tulle_status measure_wind_work(const cloth_model *model, const cloth_start *state,
                               const double *mean, wind_work_options options, arena *scratch,
                               double *work) {
    *work = 0.0;
    if (!(options.wind->drag_coefficient > 0.0)) return TULLE_OK;
    arena_mark const mark = arena_get_mark(scratch);
    size_t const count = model->triangle_count, vertices = model->vertex_count;
    size_t const chunks = parallel_chunk_count(count, TRIANGLES_PER_CHUNK);
    bool const has_air = state->terms && state->terms->is_complete && state->terms->air_velocities;
    vec3 *const air = has_air ? state->terms->air_velocities : ARENA_NEW(scratch, vec3, vertices);
    work_task task = {.model = model,
                      .state = state,
                      .wind = options.wind,
                      .mean = mean,
                      .air = air,
                      .sums = ARENA_NEW_ZEROED(scratch, double, chunks)};
    if (!air || !task.sums) return TULLE_ERROR_OUT_OF_MEMORY;
    air_samples samples = {options.wind, state, air};
    if (!has_air) parallel_for(vertices, VERTICES_PER_CHUNK, options.threads, sample_air, &samples);
    parallel_for_busy(model->idle_triangles, count, TRIANGLES_PER_CHUNK, options.threads,
                      measure_triangles, &task);
    for (size_t i = 0; i < chunks; i++) *work += state->time_step * task.sums[i];
    arena_release(scratch, mark);
    return TULLE_OK;
}
