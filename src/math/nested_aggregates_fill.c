/* math/nested_aggregates_fill.c - numbers and use of nested aggregates, see nested_aggregates.h.
 *
 * G of a level is the sum of the entries of A between vertices of one aggregate. Each entry is
 * added once, at the first level that joins its row and column, and goes up with its aggregate from
 * there. The sums are in double precision, because springs cancel in them and masses are left.
 *
 * Based on: Bramble, Pasciak, Xu, Parallel multilevel preconditioners, 1990; Zhang, Multilevel
 * Schwarz methods, 1992 (diagonal blocks at every level). Departure: aggregates are constant. */
#include "math/conjugate_gradients.h"
#include "math/nested_aggregates.h"

#include "base/parallel.h"

#include <string.h>

/* Aggregates of a chunk of a loop. A level with no more than MOST_ALONE is not shared among
 * threads. */
enum { MOST_ALONE = 256, AGGREGATES_PER_CHUNK = 64 };

static size_t choose_chunk(size_t count) {
    return count > MOST_ALONE ? AGGREGATES_PER_CHUNK : MOST_ALONE;
}

/* An aggregate of level l has one sum, a block, for each level from l on. The level above adds up
 * the sums of its members. */
typedef struct fill_task {
    nested_aggregates *all;
    const block_matrix *matrix;
    size_t level;
    const double *below; /* sums of the level below; null: the matrix */
    double *sums;
} fill_task;

/* Sums of the entries of some rows, by level. The last ones are of what no level joins, and serve
 * nothing. */
typedef struct level_sums {
    double blocks[AGGREGATE_LEVELS_MAX + 1][BLOCK_NUMBERS];
    double scalars[AGGREGATE_LEVELS_MAX + 1];
} level_sums;

/* Adds the entries of a row from the diagonal on. Those beyond it count for their mirror images,
 * too. */
static void add_row(const fill_task *task, size_t row, level_sums *sums) {
    const nested_aggregates *const all = task->all;
    const block_matrix *const matrix = task->matrix;
    uint32_t const diagonal = matrix->diagonal_positions[row];
    for (uint32_t k = diagonal; k < matrix->row_begin[row + 1]; k++) {
        if (all->is_fixed[matrix->columns[k]]) continue;
        double *const to = sums->blocks[all->block_levels[k]];
        const double *const m = matrix->values + BLOCK_NUMBERS * (size_t)k;
        double const times = k == diagonal ? 1.0 : 2.0;
        for (size_t i = 0; i < BLOCK_NUMBERS; i++) to[i] += times * m[i];
    }
    for (uint32_t k = matrix->scalar_begin[row + 1]; k-- > matrix->scalar_begin[row];) {
        size_t const column = matrix->scalar_columns[k];
        if (column < row) break;
        double const times = column == row ? 1.0 : 2.0;
        if (!all->is_fixed[column])
            sums->scalars[all->scalar_levels[k]] += times * block_matrix_get_scalar(matrix, k);
    }
}

static void sum_members(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_task *const task = context;
    const nested_aggregates *const all = task->all;
    const aggregate_level *const level = &all->levels[task->level];
    size_t const size = 9 * (all->level_count - task->level);
    for (size_t a = begin; a < end; a++) {
        double *const sums = task->sums + size * a;
        memset(sums, 0, size * sizeof(double));
        level_sums of_rows = {0};
        for (uint32_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++) {
            size_t const member = level->members[i];
            if (!task->below) {
                if (!all->is_fixed[member]) add_row(task, member, &of_rows);
                continue;
            }
            const double *const from = task->below + (size + 9) * member + 9;
            for (size_t k = 0; k < size; k++) sums[k] += from[k];
        }
        for (size_t l = 0; !task->below && l < all->level_count; l++) {
            const double *const m = of_rows.blocks[l];
            double const s = of_rows.scalars[l];
            double const full[9] = {m[0] + s, m[1], m[2], m[1],    m[3] + s,
                                    m[4],     m[2], m[4], m[5] + s};
            memcpy(sums + 9 * l, full, sizeof full);
        }
        /* what a level joins counts in all above it */
        for (size_t i = 0; size > 9 && i < 9; i++) sums[9 + i] += sums[i];
        memcpy(level->matrix_blocks + 9 * a, sums, 9 * sizeof(double));
    }
}

bool nested_aggregates_set_matrix(nested_aggregates *aggregates, const block_matrix *matrix,
                                  const uint8_t *is_fixed, int threads, arena *scratch) {
    arena_mark const mark = arena_get_mark(scratch);
    if (is_fixed)
        memcpy(aggregates->is_fixed, is_fixed, aggregates->vertex_count);
    else
        memset(aggregates->is_fixed, 0, aggregates->vertex_count);
    fill_task task = {.all = aggregates, .matrix = matrix};
    bool ok = true;
    for (size_t l = 0; ok && l < aggregates->level_count; l++) {
        size_t const count = aggregates->levels[l].count;
        task.level = l;
        task.below = l == 0 ? NULL : task.sums;
        task.sums = ARENA_NEW(scratch, double, 9 * (aggregates->level_count - l) * count);
        ok = task.sums != NULL;
        if (ok) parallel_for(count, choose_chunk(count), threads, sum_members, &task);
    }
    arena_release(scratch, mark);
    return ok;
}

static void invert_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const aggregate_level *const level = context;
    for (size_t a = begin; a < end; a++) {
        conjugate_gradients_problem const problem = {.diagonal = level->blocks + 9 * a};
        double m[BLOCK_NUMBERS];
        invert_block_of(&problem, 0, m);
        double const full[9] = {m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]};
        for (size_t i = 0; i < 9; i++) level->inverse[9 * a + i] = (float)full[i];
    }
}

void nested_aggregates_set_terms(nested_aggregates *aggregates, const matrix_term *terms,
                                 size_t count, int threads) {
    for (size_t l = 0; l < aggregates->level_count; l++) {
        aggregate_level *const level = &aggregates->levels[l];
        memcpy(level->blocks, level->matrix_blocks, 9 * level->count * sizeof(double));
    }
    for (size_t t = 0; t < count; t++) {
        const matrix_term *const term = &terms[t];
        uint32_t members[4];
        double weights[4];
        for (size_t k = 0; k < 4; k++) {
            uint32_t const vertex = term->vertices[k];
            bool const is_free = vertex != TULLE_NONE && !aggregates->is_fixed[vertex];
            members[k] = is_free ? vertex : TULLE_NONE;
            weights[k] = term->weights[k];
        }
        for (size_t l = 0; l < aggregates->level_count; l++) {
            const aggregate_level *const level = &aggregates->levels[l];
            /* Each vertex becomes its aggregate; vertices of the same aggregate become one. */
            for (size_t k = 0; k < 4; k++) {
                if (members[k] == TULLE_NONE) continue;
                members[k] = level->parents[members[k]];
                for (size_t j = 0; j < k && members[k] != TULLE_NONE; j++) {
                    if (members[j] != members[k]) continue;
                    weights[j] += weights[k];
                    members[k] = TULLE_NONE;
                }
            }
            for (size_t k = 0; k < 4; k++) {
                if (members[k] == TULLE_NONE) continue;
                double *const to = level->blocks + 9 * (size_t)members[k];
                for (size_t i = 0; i < 9; i++)
                    to[i] += weights[k] * weights[k] * term->stiffness.m[i];
            }
        }
    }
    for (size_t l = 0; l < aggregates->level_count; l++)
        parallel_for(aggregates->levels[l].count, choose_chunk(aggregates->levels[l].count),
                     threads, invert_chunk, &aggregates->levels[l]);
}

/* ---- the correction ---- */

typedef struct correct_task {
    nested_aggregates *all;
    const aggregate_level *level;
    const float *below;              /* residual of the level below, */
    size_t vertex_step, number_step; /* whose numbers lie so */
} correct_task;

/* Three numbers of a member of the level below. */
static floats4 load_member(const correct_task *task, size_t member) {
    const float *const r = task->below + member * task->vertex_step;
    if (task->number_step == 1) return floats4_load(r);
    floats4 const numbers = {r[0], r[task->number_step], r[2 * task->number_step], 0.0F};
    return numbers;
}

/* Residual and own correction of a level's aggregates, and the dot of both. */
static void restrict_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    double dot = 0.0;
    const correct_task *const task = context;
    const aggregate_level *const level = task->level;
    const uint8_t *const is_fixed = level == task->all->levels ? task->all->is_fixed : NULL;
    for (size_t a = begin; a < end; a++) {
        floats4 r = {0.0F, 0.0F, 0.0F, 0.0F}; /* summed over the members */
        for (size_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++) {
            if (is_fixed && is_fixed[level->members[i]]) continue;
            r += load_member(task, level->members[i]);
        }
        const float *const m = level->inverse + 9 * a;
        floats4 const z =
            (floats4_load(m) * r[0] + floats4_load(m + 3) * r[1]) + floats4_load(m + 6) * r[2];
        for (size_t k = 0; k < 3; k++) {
            level->residual[3 * a + k] = r[k];
            level->correction[3 * a + k] = z[k];
            dot += (double)r[k] * (double)z[k];
        }
    }
    level->dots[chunk] = dot;
}

double nested_aggregates_correct(nested_aggregates *aggregates, const single_vectors *vectors,
                                 int threads) {
    double dot = 0.0;
    correct_task task = {.all = aggregates,
                         .below = vectors->residual,
                         .vertex_step = vectors->vertex_step,
                         .number_step = vectors->number_step};
    for (size_t l = 0; l < aggregates->level_count; l++) {
        const aggregate_level *const level = task.level = &aggregates->levels[l];
        size_t const chunk = choose_chunk(level->count);
        parallel_for(level->count, chunk, threads, restrict_chunk, &task);
        dot += parallel_sum(level->dots, parallel_chunk_count(level->count, chunk));
        task.below = level->residual;
        task.vertex_step = 3;
        task.number_step = 1;
    }
    /* Down again: each level adds the correction of the level above. */
    for (size_t l = aggregates->level_count; l-- > 1;) {
        const aggregate_level *const above = &aggregates->levels[l];
        float *const correction = aggregates->levels[l - 1].correction;
        for (size_t a = 0; a < above->member_count; a++)
            for (size_t k = 0; k < 3; k++)
                correction[3 * a + k] += above->correction[3 * (size_t)above->parents[a] + k];
    }
    return dot;
}
