/* step/stretch.c - how far a substep would stretch cloth: its paths are judged before they are
 * accepted. */
#include "step/stretch.h"

#include "base/parallel.h"
#include "dynamics/compute_forces.h"

#include <math.h>

/* Growth that only takes up slack is free up to this stretch. An edge may grow by this share of its
 * rest length in one substep. */
static const double STRETCH_FREE = 1.15, STRETCH_GROWTH_MAX = 0.25;

/* A yarn may grow by this share of its limit in one substep, beyond what is free (dynamics). */
static const double YARN_GROWTH_MAX = 0.1;

/* A torn edge grows by this factor in one substep. By the paper's response no other vertex gains
 * what one loses, so contact can give energy on and on. */
static const double TORN_GROWTH = 1.5;

/* Lengths of an edge [m]: at rest, at the start of the substep, at its end. */
typedef struct edge_lengths {
    double rest, start, end;
} edge_lengths;

static edge_lengths measure_lengths(const step_model *model, const motion_state *state,
                                    const step_work *work, size_t edge) {
    const double *const states[3] = {model->rest, state->positions, work->sub.end};
    size_t const a = model->topo.edges[2 * edge], b = model->topo.edges[2 * edge + 1];
    double lengths[3];
    for (int k = 0; k < 3; k++)
        lengths[k] = vec3_norm(vec3_sub(vec3_load(states[k], a), vec3_load(states[k], b)));
    return (edge_lengths){lengths[0], lengths[1], lengths[2]};
}

/* Chunks at most, and edges of one at least. */
enum { GROWTH_CHUNKS = 16, GROWTH_CHUNK_LEAST = 4096 };

typedef struct growth_task {
    const step_model *model;
    const motion_state *state;
    const step_work *work;
    double growths[GROWTH_CHUNKS];
} growth_task;

/* Few edges are long enough to grow by too much, and only those are measured at the start. */
static void measure_growth(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    growth_task *const task = context;
    const step_model *const model = task->model;
    double const shortest = (STRETCH_FREE + STRETCH_GROWTH_MAX) * (1.0 - 1e-9);
    double growth = 0.0;
    for (size_t e = begin; e < end; e++) {
        const uint32_t *const ends = model->topo.edges + 2 * e;
        double squares[2]; /* [m^2] of the edge's length at rest and at the end */
        const double *const states[2] = {model->rest, task->work->sub.end};
        for (int k = 0; k < 2; k++)
            squares[k] =
                vec3_norm2(vec3_sub(vec3_load(states[k], ends[0]), vec3_load(states[k], ends[1])));
        if (squares[1] <= shortest * shortest * squares[0]) continue;
        edge_lengths const length = measure_lengths(model, task->state, task->work, e);
        double const before = fmax(length.start / length.rest, STRETCH_FREE);
        growth = fmax(growth, length.end / length.rest - before);
    }
    task->growths[chunk] = growth;
}

/* The most that an edge grows, as a multiple of what is too much. */
static double measure_edge_growth(const step_model *model, const motion_state *state,
                                  const step_work *work) {
    growth_task task = {.model = model, .state = state, .work = work};
    size_t const count = model->cloth_edge_count, even = count / GROWTH_CHUNKS + 1;
    size_t const chunk = even > GROWTH_CHUNK_LEAST ? even : GROWTH_CHUNK_LEAST;
    parallel_for(count, chunk, work->threads, measure_growth, &task);
    double growth = 0.0;
    for (int k = 0; k < GROWTH_CHUNKS; k++) growth = fmax(growth, task.growths[k]);
    return growth / STRETCH_GROWTH_MAX;
}

tulle_status step_judge_stretch(const step_model *model, motion_state *state, step_work *work,
                                double most, bool *stretches) {
    double growth;
    /* The paper's response stretches stiff yarns whatever the length of the substep. */
    if (model->cloth_model->elements && !work->sub.scene.response->may_tear_cloth) {
        tulle_status const status =
            cloth_measure_yarn_growth(model->cloth_model, state->positions, work->sub.end,
                                      work->threads, &work->scratch, &growth);
        if (status != TULLE_OK) return status;
        growth /= YARN_GROWTH_MAX;
    } else {
        growth = measure_edge_growth(model, state, work);
    }
    *stretches = growth > most && !model->cloth_model->shape;
    return TULLE_OK;
}

bool step_is_torn(const step_model *model, const motion_state *state, const step_work *work) {
    for (size_t e = 0; e < model->cloth_edge_count; e++) {
        edge_lengths const length = measure_lengths(model, state, work, e);
        if (length.end > TORN_STRETCH * length.rest && length.end > TORN_GROWTH * length.start)
            return true;
    }
    return false;
}
