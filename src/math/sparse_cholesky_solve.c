/* math/sparse_cholesky_solve.c - solves with the factor, see sparse_cholesky.h: down the tree's
 * fronts with L, each handing on what its later vertices lose, and back up with L^T. */
#include "base/parallel.h"
#include "math/sparse_cholesky_parts.h"

#include <string.h>

typedef struct solve_work {
    sparse_cholesky *factor;
    const front_task *tasks;
    const float *r;
    float *z;
} solve_work;

static void solve_one_down(const solve_work *work, uint32_t index) {
    const sparse_cholesky *const factor = work->factor;
    const cholesky_front *const front = &factor->fronts.data[index];
    packed_front const panel = get_packed(factor, front);
    float *const x = factor->vectors + front->vector;
    memset(x + panel.own, 0, (panel.stride - panel.own) * sizeof(float));
    for (size_t v = 0; v < front->own; v++) {
        uint32_t const vertex = factor->order[front->begin + v];
        for (size_t i = 0; i < 3; i++)
            x[3 * v + i] = factor->is_fixed[vertex] ? 0.0F : work->r[3 * (size_t)vertex + i];
    }
    for (uint32_t c = front->child_begin; c < front->child_end; c++) {
        const cholesky_front *const child = &factor->fronts.data[factor->children.data[c]];
        const float *const from = factor->vectors + child->vector + 3 * (size_t)child->own;
        for (uint32_t k = child->run_begin; k < child->run_end; k++) {
            front_run const run = factor->runs.data[k];
            for (size_t i = 0; i < 3 * (size_t)run.count; i++)
                x[3 * (size_t)run.to + i] += from[3 * (size_t)run.from + i];
        }
    }
    TULLE_PICK_KERNEL(solve_front_down)(&panel, x);
}

static void solve_one_up(const solve_work *work, uint32_t index) {
    const sparse_cholesky *const factor = work->factor;
    const cholesky_front *const front = &factor->fronts.data[index];
    packed_front const panel = get_packed(factor, front);
    float *const x = factor->vectors + front->vector;
    if (front->parent != TULLE_NONE) {
        const float *const from = factor->vectors + factor->fronts.data[front->parent].vector;
        for (uint32_t k = front->run_begin; k < front->run_end; k++) {
            front_run const run = factor->runs.data[k];
            memcpy(x + panel.own + 3 * (size_t)run.from, from + 3 * (size_t)run.to,
                   3 * (size_t)run.count * sizeof(float));
        }
    }
    TULLE_PICK_KERNEL(solve_front_up)(&panel, x);
    for (size_t v = 0; v < front->own; v++) {
        uint32_t const vertex = factor->order[front->begin + v];
        for (size_t i = 0; i < 3; i++)
            work->z[3 * (size_t)vertex + i] = factor->is_fixed[vertex] ? 0.0F : x[3 * v + i];
    }
}

static void run_down(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const solve_work *const work = context;
    for (size_t t = begin; t < end; t++)
        for (uint32_t i = work->tasks[t].begin; i < work->tasks[t].end; i++)
            solve_one_down(work, i);
}

static void run_up(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const solve_work *const work = context;
    for (size_t t = end; t-- > begin;)
        for (uint32_t i = work->tasks[t].end; i-- > work->tasks[t].begin;) solve_one_up(work, i);
}

void sparse_cholesky_solve(sparse_cholesky *factor, const float *r, float *z, int threads) {
    solve_work work = {.factor = factor, .r = r, .z = z};
    const uint32_t *const waves = factor->waves.data;
    size_t const count = factor->waves.count - 1;
    for (size_t w = 0; w < count; w++) {
        work.tasks = factor->tasks.data + waves[w];
        parallel_for(waves[w + 1] - waves[w], 1, threads, run_down, &work);
    }
    for (size_t w = count; w-- > 0;) {
        work.tasks = factor->tasks.data + waves[w];
        parallel_for(waves[w + 1] - waves[w], 1, threads, run_up, &work);
    }
}
