/* dynamics/wind_work.c - the work of the wind in a step, as the linear system reckons with it.
 *
 * The force on a triangle at (x0, v0) is carried on to the mean velocity of the step by the part of
 * its derivative that the matrix holds, along the normal at x0. Takes the motion of the step; gives
 * the work on the cloth, negative where air slows it. */
#include "base/parallel.h"
#include "dynamics/compute_forces.h"
#include "dynamics/wind.h"

enum { VERTICES_PER_CHUNK = 256, TRIANGLES_PER_CHUNK = 1024 };

typedef struct wind_task {
    const cloth_model *model;
    const motion_state *state;
    const tulle_wind *wind;
    const double *mean;
    vec3 *relative; /* [m/s] to the air, of each vertex */
    double *sums;   /* by chunk */
} wind_task;

static void sample_wind(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    wind_task *const task = context;
    const motion_state *const state = task->state;
    gust_cell cell = {0};
    const vec3 *const known =
        state->terms && state->terms->is_complete ? state->terms->air_velocities : NULL;
    for (size_t v = begin; v < end; v++) {
        vec3 const place = vec3_load(state->positions, v);
        vec3 const air =
            known ? known[v] : wind_get_velocity(task->wind, place, state->time, &cell);
        task->relative[v] = vec3_sub(vec3_load(state->velocities, v), air);
    }
}

static void measure_triangles(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    wind_task *const task = context;
    const motion_state *const state = task->state;
    double sum = 0.0;
    for (size_t t = begin; t < end; t++) {
        vec3 corners[3], relative = {0.0, 0.0, 0.0}, start = relative, mean = relative;
        for (int k = 0; k < 3; k++) {
            size_t const v = cloth_get_corners(task->model, t)[k];
            corners[k] = vec3_load(state->positions, v);
            start = vec3_add_scaled(start, vec3_load(state->velocities, v), 1.0 / 3.0);
            relative = vec3_add_scaled(relative, task->relative[v], 1.0 / 3.0);
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

tulle_status measure_wind_work(const cloth_model *model, const motion_state *state,
                               const double *mean, wind_work_options options, arena *scratch,
                               double *work) {
    *work = 0.0;
    if (!(options.wind->drag_coefficient > 0.0)) return TULLE_OK;
    arena_mark const mark = arena_get_mark(scratch);
    size_t const count = model->triangle_count;
    size_t const chunks = parallel_chunk_count(count, TRIANGLES_PER_CHUNK);
    wind_task task = {.model = model, .state = state, .wind = options.wind, .mean = mean};
    task.relative = ARENA_NEW(scratch, vec3, model->vertex_count);
    task.sums = ARENA_NEW(scratch, double, chunks);
    if (!task.relative || !task.sums) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, options.threads, sample_wind, &task);
    parallel_for(count, TRIANGLES_PER_CHUNK, options.threads, measure_triangles, &task);
    for (size_t i = 0; i < chunks; i++) *work += state->time_step * task.sums[i];
    arena_release(scratch, mark);
    return TULLE_OK;
}
