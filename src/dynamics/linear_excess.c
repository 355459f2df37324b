/* dynamics/linear_excess.c - how far a step's linear system is from the truth, as energy.
 *
 * With x* where the springs were linearised, e their extension and d the way of their difference
 * vector from there, a = n . d, the linear system reckons with the energy
 *     V(e*) + t(e*) a + t'(e*)/2 a^2 + max(t(e*) / l*, 0)/2 |d - n a|^2,
 * t the tension,
 * and the spring has V(e). All else in the system is exact (bending of a flat rest shape)
 * or takes energy only. */
#include "base/parallel.h"
#include "dynamics/compute_forces.h"
#include "dynamics/spring.h"

#include <math.h>

enum { ITEMS_PER_CHUNK = 1024 };

typedef struct excess_task {
    const cloth_model *model;
    const motion_state *state;
    const double *mean;
    double *sums; /* by chunk */
} excess_task;

/* Difference vector of a spring at x0 + h u; null u: at x0. */
static vec3 get_difference(const excess_task *task, const cloth_spring *spring, const double *u) {
    const double *const x = task->state->positions;
    size_t const a = spring->vertices[0], b = spring->vertices[1];
    vec3 const start = vec3_sub(vec3_load(x, b), vec3_load(x, a));
    if (!u) return start;
    return vec3_add_scaled(start, vec3_sub(vec3_load(u, b), vec3_load(u, a)),
                           task->state->time_step);
}

static void measure_springs(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    excess_task *const task = context;
    double sum = 0.0;
    for (size_t s = begin; s < end; s++) {
        const cloth_spring *const spring = &task->model->springs[s];
        vec3 const from = spring_limit_guess(spring, get_difference(task, spring, NULL),
                                             get_difference(task, spring, task->state->guess));
        vec3 const to = get_difference(task, spring, task->mean);
        vec3 const d = vec3_sub(to, from);
        double const length = vec3_norm(from), rest = spring->rest_length;
        if (!(length > 0.0)) continue;
        double const along = vec3_dot(from, d) / length;
        double const across2 = fmax(vec3_norm2(d) - along * along, 0.0);
        spring_law const law = spring_get_law(spring, length - rest);
        double const reckoned = law.energy + (law.tension + 0.5 * law.slope * along) * along +
                                0.5 * fmax(law.tension / length, 0.0) * across2;
        sum += spring_get_law(spring, vec3_norm(to) - rest).energy - reckoned;
    }
    task->sums[chunk] = sum;
}

static void measure_inertia(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    excess_task *const task = context;
    double sum = 0.0;
    for (size_t v = begin; v < end; v++)
        sum +=
            0.5 * task->model->masses[v] *
            vec3_norm2(vec3_sub(vec3_load(task->mean, v), vec3_load(task->state->velocities, v)));
    task->sums[chunk] = sum;
}

static double add_up(excess_task *task, size_t count, int threads, parallel_body measure) {
    parallel_for(count, ITEMS_PER_CHUNK, threads, measure, task);
    double sum = 0.0;
    for (size_t i = 0; i < parallel_chunk_count(count, ITEMS_PER_CHUNK); i++) sum += task->sums[i];
    return sum;
}

tulle_status measure_linear_excess(const cloth_model *model, const motion_state *state,
                                   const double *mean, int threads, arena *scratch,
                                   linear_excess *excess) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const most =
        model->spring_count > model->vertex_count ? model->spring_count : model->vertex_count;
    excess_task task = {
        .model = model,
        .state = state,
        .mean = mean,
        .sums = ARENA_NEW(scratch, double, parallel_chunk_count(most, ITEMS_PER_CHUNK))};
    if (!task.sums) return TULLE_ERROR_OUT_OF_MEMORY;
    excess->springs = add_up(&task, model->spring_count, threads, measure_springs);
    excess->inertia = add_up(&task, model->vertex_count, threads, measure_inertia);
    arena_release(scratch, mark);
    return TULLE_OK;
}
