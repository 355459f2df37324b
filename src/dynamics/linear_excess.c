/* dynamics/linear_excess.c - how far a step's linear system is from the truth, as energy.
 *
 * A spring is linearised at x*, where its length is l*, its extension e* and its unit direction
 * n. From there its difference vector goes the way d to extension e; a = n . d. With t the
 * tension, the linear system expects the energy
 *     V(e*) + t(e*) a + t'(e*)/2 a^2 + max(t(e*) / l*, 0)/2 |d - n a|^2,
 * but the spring has V(e). Everything else in the system is exact (bending of a flat rest shape)
 * or only takes energy. For elements of woven cloth see kernels/membrane_kernel.c.
 *
 * The quadratic part of V is half of the curvature. */
#include "base/parallel.h"
#include "dynamics/compute_forces.h"
#include "dynamics/excess_kernel.h"

#include <math.h>

enum { ITEMS_PER_CHUNK = 1024 };
/* A descent goes so much of its way at least, and is exact above that after so many iterations. */
static const double LEAST_DESCENT = 0.05;
enum { DESCENT_ITERATIONS = 12 };

typedef struct excess_task {
    const cloth_model *model;
    const cloth_start *state;
    const double *mean;
    excess_motion motion;     /* of springs */
    membrane_motion elements; /* of woven cloth */
    size_t part_count;        /* springs or elements */
    size_t spring_chunks;
    way_energies *sums; /* by chunk: of springs; then of vertices, inertia and m |u - guess|^2 */
} excess_task;

/* Chunks of springs, then chunks of vertices. */
static void measure_chunks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    excess_task *const task = context;
    const cloth_model *const model = task->model;
    const uint8_t *const idle_parts = model->elements ? model->idle_triangles : NULL;
    for (size_t i = begin; i < end; i++) {
        bool const is_spring = i < task->spring_chunks;
        size_t const count = is_spring ? task->part_count : model->vertex_count;
        size_t const first = ITEMS_PER_CHUNK * (is_spring ? i : i - task->spring_chunks);
        size_t const last = count - first < ITEMS_PER_CHUNK ? count : first + ITEMS_PER_CHUNK;
        task->sums[i] = (way_energies){0.0, 0.0};
        if (are_idle(is_spring ? idle_parts : model->idle_vertices, first, last)) continue;
        if (is_spring) {
            task->sums[i] = model->elements
                                ? TULLE_PICK_KERNEL(sum_membrane_excess)(&task->elements,
                                                                         task->mean, first, last)
                                : TULLE_PICK_KERNEL(sum_excess)(model->springs + first,
                                                                last - first, &task->motion);
            continue;
        }
        const double *const guess = task->state->guess;
        for (size_t v = first; v < last; v++) {
            vec3 const u = vec3_load(task->mean, v);
            vec3 const change = vec3_sub(u, vec3_load(task->state->velocities, v));
            task->sums[i].excess += 0.5 * model->masses[v] * vec3_norm2(change);
            if (guess)
                task->sums[i].curvature +=
                    model->masses[v] * vec3_norm2(vec3_sub(u, vec3_load(guess, v)));
        }
    }
}

tulle_status measure_linear_excess(const cloth_model *model, const cloth_start *state,
                                   const double *mean, int threads, arena *scratch,
                                   linear_excess *excess) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const part_count = model->elements ? model->triangle_count : model->edge_count;
    size_t const spring_chunks = parallel_chunk_count(part_count, ITEMS_PER_CHUNK);
    size_t const vertex_chunks = parallel_chunk_count(model->vertex_count, ITEMS_PER_CHUNK);
    excess_task task = {.model = model,
                        .state = state,
                        .mean = mean,
                        .motion = {state->positions, state->guess, mean, state->time_step},
                        .elements = {.elements = model->elements,
                                     .fabrics = model->fabrics,
                                     .vertex_count = model->vertex_count,
                                     .positions = state->positions,
                                     .guess = state->guess,
                                     .time_step = state->time_step,
                                     .beta = 1.0},
                        .part_count = part_count,
                        .spring_chunks = spring_chunks,
                        .sums = ARENA_NEW(scratch, way_energies, spring_chunks + vertex_chunks)};
    if (!task.sums) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(spring_chunks + vertex_chunks, 1, threads, measure_chunks, &task);
    *excess = (linear_excess){0.0, 0.0, 0.0};
    for (size_t i = 0; i < spring_chunks + vertex_chunks; i++) {
        *(i < spring_chunks ? &excess->springs : &excess->inertia) += task.sums[i].excess;
        excess->curvature += task.sums[i].curvature;
    }
    arena_release(scratch, mark);
    return TULLE_OK;
}

/* At a share t of the way the system expects q (t^2 / 2 - t) more energy than at the guess, q being
 * the curvature. What springs take beyond that grows as t^4, since they turn and stiffen. The sum
 * is least where 4 excess / q t^3 + t = 1. */
double choose_descent(const linear_excess *excess) {
    if (!(excess->springs > 0.0 && excess->curvature > 0.0)) return 1.0;
    double const factor = 4.0 * excess->springs / excess->curvature;
    double share = 1.0;
    for (int i = 0; i < DESCENT_ITERATIONS; i++) /* Newton's method, from above */
        share = (1.0 + 2.0 * factor * share * share * share) / (1.0 + 3.0 * factor * share * share);
    return fmax(share, LEAST_DESCENT);
}
