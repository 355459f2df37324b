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
    size_t spring_chunks;
    double *sums; /* by chunk, of springs, then of vertices */
} excess_task;

/* Of the values at a spring's ends. */
static inline vec3 get_difference(const cloth_spring *spring, const double *values) {
    return vec3_sub(vec3_load(values, spring->vertices[1]), vec3_load(values, spring->vertices[0]));
}

static double measure_springs(const excess_task *task, size_t begin, size_t end) {
    const double *const guess = task->state->guess;
    double const h = task->state->time_step;
    double sum = 0.0;
    for (size_t s = begin; s < end; s++) {
        const cloth_spring *const spring = &task->model->springs[s];
        vec3 const start = get_difference(spring, task->state->positions);
        spring_edge const from =
            guess ? spring_limit_guess(spring, start,
                                       vec3_add_scaled(start, get_difference(spring, guess), h))
                  : spring_make_edge(start);
        vec3 const to = vec3_add_scaled(start, get_difference(spring, task->mean), h);
        vec3 const d = vec3_sub(to, from.edge);
        double const length = from.length, rest = spring->rest_length;
        if (!(length > 0.0)) continue;
        double const along = vec3_dot(from.edge, d) / length;
        double const beside2 = vec3_norm2(d) - along * along,
                     across2 = beside2 > 0.0 ? beside2 : 0.0;
        spring_law const law = spring_get_law(spring, length - rest);
        double const pull = law.tension / length;
        double const reckoned = law.energy + (law.tension + 0.5 * law.slope * along) * along +
                                0.5 * (pull > 0.0 ? pull : 0.0) * across2;
        sum += spring_get_law(spring, vec3_norm(to) - rest).energy - reckoned;
    }
    return sum;
}

static double measure_inertia(const excess_task *task, size_t begin, size_t end) {
    double sum = 0.0;
    for (size_t v = begin; v < end; v++)
        sum +=
            0.5 * task->model->masses[v] *
            vec3_norm2(vec3_sub(vec3_load(task->mean, v), vec3_load(task->state->velocities, v)));
    return sum;
}

/* Springs in chunks, then vertices. */
static void measure_chunks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    excess_task *const task = context;
    for (size_t i = begin; i < end; i++) {
        bool const is_spring = i < task->spring_chunks;
        size_t const count = is_spring ? task->model->spring_count : task->model->vertex_count;
        size_t const first = ITEMS_PER_CHUNK * (is_spring ? i : i - task->spring_chunks);
        size_t const last = count - first < ITEMS_PER_CHUNK ? count : first + ITEMS_PER_CHUNK;
        task->sums[i] =
            is_spring ? measure_springs(task, first, last) : measure_inertia(task, first, last);
    }
}

static double add_up(const double *sums, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += sums[i];
    return sum;
}

tulle_status measure_linear_excess(const cloth_model *model, const motion_state *state,
                                   const double *mean, int threads, arena *scratch,
                                   linear_excess *excess) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const spring_chunks = parallel_chunk_count(model->spring_count, ITEMS_PER_CHUNK);
    size_t const vertex_chunks = parallel_chunk_count(model->vertex_count, ITEMS_PER_CHUNK);
    excess_task task = {.model = model,
                        .state = state,
                        .mean = mean,
                        .spring_chunks = spring_chunks,
                        .sums = ARENA_NEW(scratch, double, spring_chunks + vertex_chunks)};
    if (!task.sums) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(spring_chunks + vertex_chunks, 1, threads, measure_chunks, &task);
    excess->springs = add_up(task.sums, spring_chunks);
    excess->inertia = add_up(task.sums + spring_chunks, vertex_chunks);
    arena_release(scratch, mark);
    return TULLE_OK;
}
