/* math/sparse_cholesky_tasks.c - cuts the fronts into tasks that run side by side, and gives their
 * updates places. The cut depends on the pattern alone.
 *
 * Trees of little work are one task each, all in the first wave; the fronts above them follow in
 * waves by depth. Inside a task an update is read only by the front above, so two stacks do, one
 * for even and one for odd depths: an update is put on one while its children's are the last on the
 * other. Updates that are read by another task keep their place. */
#include "math/sparse_cholesky_parts.h"

/* Trees with at most this part of all work are one task: enough for eight threads to balance. */
enum { WORK_PARTS = 32 };

typedef struct task_planner {
    memory *heap;
    sparse_cholesky *factor;
    uint64_t *work;   /* of each front and all below */
    uint32_t *firsts; /* first front of the tree below each */
    uint32_t *depths;
} task_planner;

static size_t get_update_size(const cholesky_front *front) {
    size_t const rows = front_round_up(3 * (size_t)front->others);
    return rows * rows;
}

/* Work of assembly and of the loops around the products counts too. */
static uint64_t estimate_work(const cholesky_front *front) {
    uint64_t const own = 3 * (uint64_t)front->own, others = 3 * (uint64_t)front->others;
    return own * (own + others) * (own + others) + 4 * (own + others) * (own + others);
}

static uint32_t sum_up(task_planner *plan) {
    uint32_t deepest = 0;
    const sparse_cholesky *const factor = plan->factor;
    for (uint32_t i = 0; i < factor->fronts.count; i++) {
        const cholesky_front *const front = &factor->fronts.data[i];
        plan->work[i] = estimate_work(front);
        plan->firsts[i] = i;
        for (uint32_t c = front->child_begin; c < front->child_end; c++) {
            uint32_t const child = factor->children.data[c];
            plan->work[i] += plan->work[child];
            if (plan->firsts[child] < plan->firsts[i]) plan->firsts[i] = plan->firsts[child];
        }
    }
    for (uint32_t i = (uint32_t)factor->fronts.count; i-- > 0;) {
        uint32_t const parent = factor->fronts.data[i].parent;
        plan->depths[i] = parent == TULLE_NONE ? 0 : plan->depths[parent] + 1;
        if (plan->depths[i] > deepest) deepest = plan->depths[i];
    }
    return deepest;
}

/* Offsets of a task's updates in its worker's stacks, and of its last, which is kept. */
static void place_updates(task_planner *plan, front_task task) {
    sparse_cholesky *const factor = plan->factor;
    size_t used[2] = {0, 0}, most[2] = {0, 0};
    cholesky_front *const last = &factor->fronts.data[task.end - 1];
    last->keeps_update = true;
    last->update = factor->update_size;
    factor->update_size += get_update_size(last);
    for (uint32_t i = task.begin; i + 1 < task.end; i++) {
        cholesky_front *const front = &factor->fronts.data[i];
        size_t const parity = plan->depths[i] & 1U;
        front->update = used[parity];
        used[parity] += get_update_size(front);
        if (used[parity] > most[parity]) most[parity] = used[parity];
        for (uint32_t c = front->child_begin; c < front->child_end; c++) {
            uint32_t const child = factor->children.data[c];
            if (child >= task.begin)
                used[1 - parity] -= get_update_size(&factor->fronts.data[child]);
        }
    }
    for (uint32_t i = task.begin; i + 1 < task.end; i++)
        factor->fronts.data[i].update += plan->depths[i] & 1U ? most[0] : 0;
    if (most[0] + most[1] > factor->largest_stack) factor->largest_stack = most[0] + most[1];
}

static bool add_task(task_planner *plan, uint32_t begin, uint32_t end) {
    sparse_cholesky *const factor = plan->factor;
    if (!ARRAY_RESERVE(plan->heap, &factor->tasks, 1)) return false;
    front_task const task = {begin, end};
    factor->tasks.data[factor->tasks.count++] = task;
    place_updates(plan, task);
    return true;
}

static bool end_wave(task_planner *plan) {
    sparse_cholesky *const factor = plan->factor;
    if (!ARRAY_RESERVE(plan->heap, &factor->waves, 1)) return false;
    factor->waves.data[factor->waves.count++] = (uint32_t)factor->tasks.count;
    return true;
}

static bool make_tasks(task_planner *plan, uint32_t deepest) {
    sparse_cholesky *const factor = plan->factor;
    uint32_t const count = (uint32_t)factor->fronts.count;
    uint64_t total = 0;
    for (uint32_t i = 0; i < count; i++)
        if (factor->fronts.data[i].parent == TULLE_NONE) total += plan->work[i];
    uint64_t const share = total / WORK_PARTS;
    if (!end_wave(plan)) return false;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t const parent = factor->fronts.data[i].parent;
        bool const is_small = plan->work[i] <= share;
        bool const is_top = parent == TULLE_NONE || plan->work[parent] > share;
        if (is_small && is_top && !add_task(plan, plan->firsts[i], i + 1)) return false;
    }
    if (!end_wave(plan)) return false;
    for (uint32_t depth = deepest + 1; depth-- > 0;) {
        for (uint32_t i = 0; i < count; i++)
            if (plan->depths[i] == depth && plan->work[i] > share && !add_task(plan, i, i + 1))
                return false;
        if (factor->tasks.count > factor->waves.data[factor->waves.count - 1] && !end_wave(plan))
            return false;
    }
    return true;
}

bool plan_tasks(memory *heap, sparse_cholesky *factor) {
    size_t const count = factor->fronts.count;
    task_planner plan = {heap, factor, NULL, NULL, NULL};
    plan.work = memory_allocate(heap, count * sizeof *plan.work);
    plan.firsts = memory_allocate(heap, count * sizeof *plan.firsts);
    plan.depths = memory_allocate(heap, count * sizeof *plan.depths);
    bool const ok = plan.work && plan.firsts && plan.depths && make_tasks(&plan, sum_up(&plan));
    memory_release(heap, plan.work, count * sizeof *plan.work);
    memory_release(heap, plan.firsts, count * sizeof *plan.firsts);
    memory_release(heap, plan.depths, count * sizeof *plan.depths);
    return ok;
}
