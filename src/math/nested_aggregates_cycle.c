/* math/nested_aggregates_cycle.c - the use of nested aggregates, see nested_aggregates.h.
 *
 * A cycle for  A z = r  of a level: a step of Jacobi's method from 0, the cycle of the level above
 * for what is left, and another step. A step goes by a part of D^-1 r so small that it converges,
 * so the cycle is symmetric and positive. No eigenvalue of D^-1 A is over the number of members
 * that a term of A joins. On the first level a contact, a triangle or a hinge joins four at most,
 * blocks of a grid, too. Bending has terms of more; there 3.3 is the most that was measured. Above
 * it a term joins six or so. Large levels above the first take two steps before, the outer and the
 * inner one, and the same two after, in the other order. The last level, of a few aggregates, takes
 * several steps.
 *
 * Based on: Bramble, Pasciak, Xu, Parallel multilevel preconditioners, 1990 (levels are added);
 * Briggs, Henson, McCormick, A multigrid tutorial, 2000 (cycles). Departure: the first level is
 * added to the diagonal of the vertices, which spares products with the whole matrix; cycles begin
 * there. */
#include "math/nested_aggregates.h"

#include "base/parallel.h"

#include <string.h>

/* Aggregates of a chunk of a loop. A level with no more than MOST_ALONE is not shared among
 * threads. */
enum { MOST_ALONE = 256, AGGREGATES_PER_CHUNK = 64 };
/* Blocks of a grid and vertices of its rows in a chunk. */
enum { BLOCKS_PER_CHUNK = 1024, VERTICES_PER_CHUNK = 2048 };
/* Part of D^-1 r that a step goes above the first level. */
static const float STEP_ABOVE = 0.3F;
/* Where a level takes two, the parts of the inner and the outer ones: Chebyshev's for eigenvalues
 * from 5/3 to 20/3. They converge below 8.3. */
static const float INNER_STEP = 0.417F, OUTER_STEP = 0.168F;
/* Smaller levels take one: it does there, and loops over them cost more than what they do. */
enum { MOST_WITH_ONE_STEP = 256 };
/* Steps on the last level. */
enum { LAST_STEPS = 8 };

static size_t choose_chunk(size_t count) {
    return count > MOST_ALONE ? AGGREGATES_PER_CHUNK : MOST_ALONE;
}

typedef struct cycle_task {
    nested_aggregates *all;
    const aggregate_level *level;
    const float *below;              /* residual of the level below, */
    float *guess_below;              /* and its guess, */
    size_t vertex_step, number_step; /* whose numbers lie so */
    const single_vectors *vertices;  /* null: not of vertices */
    float part;                      /* of D^-1 r that a step goes */
    int threads;
} cycle_task;

static void store3(float *to, floats4 a) { memcpy(to, &a, 3 * sizeof(float)); }

/* Three numbers of a member of the level below. */
static floats4 load_member(const cycle_task *task, size_t member) {
    const float *const r = task->below + member * task->vertex_step;
    if (task->number_step == 1) return floats4_load(r);
    floats4 const numbers = {r[0], r[task->number_step], r[2 * task->number_step], 0.0F};
    return numbers;
}

/* A step's part of D^-1 r. */
static floats4 get_step(const cycle_task *task, size_t aggregate, floats4 r) {
    const float *const m = task->level->inverse + 9 * aggregate;
    return ((floats4_load(m) * r[0] + floats4_load(m + 3) * r[1]) + floats4_load(m + 6) * r[2]) *
           task->part;
}

/* The residual P^T r of a level, and the first step. */
static void restrict_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const cycle_task *const task = context;
    const aggregate_level *const level = task->level;
    const weight_list *const list = &level->of_aggregates;
    const uint8_t *const is_fixed = task->all->is_fixed;
    for (size_t a = begin; a < end; a++) {
        floats4 r = {0.0F, 0.0F, 0.0F, 0.0F};
        if (list->begin) {
            for (size_t i = list->begin[a]; i < list->begin[a + 1]; i++)
                r += load_member(task, list->columns[i]) * list->weights[i];
        } else {
            for (size_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++)
                if (!is_fixed[level->members[i]]) r += load_member(task, level->members[i]);
        }
        store3(level->residual + 3 * a, r);
        store3(level->guess + 3 * a, get_step(task, a, r));
    }
}

/* product = A guess of these rows */
static void multiply(const aggregate_level *level, size_t begin, size_t end) {
    single_matrix const matrix = {.row_begin = level->row_begin,
                                  .columns = level->columns,
                                  .scalar_begin = level->no_scalars,
                                  .scalar_columns = level->columns,
                                  .values = level->values,
                                  .scalar_values = level->values};
    single_vectors const vectors = {
        .direction = level->guess, .product = level->product, .vertex_step = 3, .number_step = 1};
    (void)TULLE_PICK_KERNEL(single_multiply)(&matrix, &vectors, begin, end);
}

/* What the guess leaves, into `product`. */
static void leave_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const aggregate_level *const level = ((const cycle_task *)context)->level;
    multiply(level, begin, end);
    for (size_t i = 3 * begin; i < 3 * end; i++)
        level->product[i] = level->residual[i] - level->product[i];
}

/* Adds what the level above found to the guess of its members. */
static void spread_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const cycle_task *const task = context;
    const aggregate_level *const above = task->level;
    const weight_list *const list = &above->of_members;
    size_t const step = task->number_step;
    for (size_t m = begin; m < end; m++) {
        float *const guess = task->guess_below + m * task->vertex_step;
        floats4 sum = {guess[0], guess[step], guess[2 * step], 0.0F};
        for (uint32_t k = list->begin[m]; k < list->begin[m + 1]; k++)
            sum +=
                floats4_load(above->correction + 3 * (size_t)list->columns[k]) * list->weights[k];
        for (size_t i = 0; i < 3; i++) guess[i * step] = sum[i];
    }
}

/* A step from the guess to the correction, and the dot of that with the residual. */
static void step_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const cycle_task *const task = context;
    const aggregate_level *const level = task->level;
    double dot = 0.0;
    multiply(level, begin, end);
    for (size_t a = begin; a < end; a++) {
        const float *const r = level->residual + 3 * a, *const y = level->product + 3 * a;
        const float *const z = level->guess + 3 * a;
        floats4 const left = {r[0] - y[0], r[1] - y[1], r[2] - y[2], 0.0F};
        floats4 const from = {z[0], z[1], z[2], 0.0F};
        floats4 const to = from + get_step(task, a, left);
        store3(level->correction + 3 * a, to);
        for (size_t k = 0; k < 3; k++) dot += (double)r[k] * (double)to[k];
    }
    level->dots[chunk] = dot;
}

static void run(cycle_task *task, const aggregate_level *level, parallel_body body) {
    task->level = level;
    parallel_for(level->count, choose_chunk(level->count), task->threads, body, task);
}

/* The cycle from the level above on for what a level's guess leaves, which is added to the guess.
 */
static void correct_guess(cycle_task *task, size_t l, const single_vectors *left);

static void take_step(cycle_task *task, const aggregate_level *level, float part) {
    task->part = part;
    run(task, level, step_chunk);
}

/* The next step goes on from the correction. */
static void take_over(const aggregate_level *level) {
    memcpy(level->guess, level->correction, 3 * level->count * sizeof(float));
}

static void correct_level(cycle_task *task, size_t l) {
    const aggregate_level *const level = &task->all->levels[l];
    bool const is_last = l + 1 == task->all->level_count;
    bool const takes_two = l > 0 && !is_last && level->count > MOST_WITH_ONE_STEP;
    float const only = l == 0 ? FIRST_STEP : STEP_ABOVE;
    task->part = takes_two ? OUTER_STEP : only;
    run(task, level, restrict_chunk);
    if (is_last) {
        take_step(task, level, only);
        for (int step = 2; step < LAST_STEPS; step++) {
            take_over(level);
            take_step(task, level, only);
        }
        return;
    }
    if (takes_two) {
        take_step(task, level, INNER_STEP);
        take_over(level);
    }
    run(task, level, leave_chunk);
    single_vectors const left = {
        .product = level->product, .direction = level->guess, .vertex_step = 3, .number_step = 1};
    correct_guess(task, l, &left);
    if (takes_two) {
        take_step(task, level, INNER_STEP);
        take_over(level);
    }
    take_step(task, level, takes_two ? OUTER_STEP : only);
}

static void correct_guess(cycle_task *task, size_t l, const single_vectors *left) {
    const aggregate_level *const above = &task->all->levels[l + 1];
    task->below = left->product;
    task->vertex_step = left->vertex_step;
    task->number_step = left->number_step;
    correct_level(task, l + 1);
    task->level = above;
    task->guess_below = left->direction;
    task->vertex_step = left->vertex_step;
    task->number_step = left->number_step;
    parallel_for(above->member_count, choose_chunk(above->member_count), task->threads,
                 spread_chunk, task);
}

/* ---- the first level of a grid ---- */

static void restrict_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const cycle_task *const task = context;
    grid_transfer_restrict(task->all->grid, task->vertices, begin, end);
}

static void expand_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    grid_transfer_expand(((const cycle_task *)context)->all->grid, begin, end);
}

static void step_first(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const grid_transfer *const grid = ((const cycle_task *)context)->all->grid;
    TULLE_PICK_KERNEL(grid_take_step)(&grid->vectors, begin, end);
}

static void leave_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const grid_transfer *const grid = ((const cycle_task *)context)->all->grid;
    (void)TULLE_PICK_KERNEL(diagonal_multiply)(&grid->matrix, &grid->vectors, begin, end);
    TULLE_PICK_KERNEL(grid_leave)(&grid->vectors, begin, end);
}

static void step_last(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const cycle_task *const task = context;
    const grid_transfer *const grid = task->all->grid;
    (void)TULLE_PICK_KERNEL(diagonal_multiply)(&grid->matrix, &grid->vectors, begin, end);
    task->all->levels[0].dots[chunk] = TULLE_PICK_KERNEL(grid_end_step)(&grid->vectors, begin, end);
}

static void run_blocks(cycle_task *task, parallel_body body) {
    parallel_for(task->all->levels[0].count, BLOCKS_PER_CHUNK, task->threads, body, task);
}

static void run_rows(cycle_task *task, parallel_body body) {
    const grid_transfer *const grid = task->all->grid;
    size_t const row_count = grid->rows.block_count;
    size_t const chunk = 1 + row_count * VERTICES_PER_CHUNK / task->all->vertex_count;
    parallel_for(row_count, chunk, task->threads, body, task);
}

double nested_aggregates_correct(nested_aggregates *aggregates, const single_vectors *vectors,
                                 int threads) {
    if (aggregates->level_count == 0) return 0.0;
    cycle_task task = {.all = aggregates,
                       .below = vectors->residual,
                       .vertex_step = vectors->vertex_step,
                       .number_step = vectors->number_step,
                       .vertices = vectors,
                       .threads = threads};
    const aggregate_level *const first = &aggregates->levels[0];
    const grid_transfer *const grid = aggregates->grid;
    if (!grid) {
        correct_level(&task, 0);
        return parallel_sum(first->dots,
                            parallel_chunk_count(first->count, choose_chunk(first->count)));
    }
    /* as correct_level */
    bool const is_last = aggregates->level_count == 1;
    run_rows(&task, restrict_rows);
    run_blocks(&task, step_first);
    if (!is_last) {
        run_blocks(&task, leave_rows);
        correct_guess(&task, 0, &grid->vectors);
    }
    run_blocks(&task, step_last);
    for (int step = 2; is_last && step < LAST_STEPS; step++) {
        for (size_t i = 0; i < 3; i++)
            memcpy(grid->vectors.direction + i * grid->vectors.number_step,
                   grid->vectors.preconditioned + i * grid->vectors.number_step,
                   first->count * sizeof(float));
        run_blocks(&task, step_last);
    }
    run_rows(&task, expand_rows);
    return parallel_sum(first->dots, parallel_chunk_count(first->count, BLOCKS_PER_CHUNK));
}

void nested_aggregates_add(const nested_aggregates *aggregates, const single_vectors *vectors,
                           size_t begin, size_t end) {
    if (aggregates->level_count == 0) return;
    if (aggregates->grid) {
        grid_transfer_add(aggregates->grid, vectors->preconditioned, vectors->number_step, begin,
                          end);
        return;
    }
    const aggregate_level *const first = &aggregates->levels[0];
    for (size_t v = begin; v < end; v++) {
        const float *const found = first->correction + 3 * (size_t)first->parents[v];
        float *const to = vectors->preconditioned + v * vectors->vertex_step;
        for (size_t i = 0; i < 3 && !aggregates->is_fixed[v]; i++)
            to[i * vectors->number_step] += found[i];
    }
}
