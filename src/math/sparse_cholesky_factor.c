/* math/sparse_cholesky_factor.c - numbers of the factor, see sparse_cholesky.h. */
#include "base/parallel.h"
#include "math/sparse_cholesky_parts.h"

#include <math.h>
#include <string.h>

/* A pivot under this part of its diagonal entry is rounding: single precision keeps 6e-8 of it,
 * some tens of times in one sum. */
#define LEAST_PIVOT 1e-6F
/* Any pivot is at least this, so that its inverse is finite. */
#define SMALLEST_PIVOT 1e-30F

/* A part of a term: a block that joins a panel. */
typedef struct term_block {
    uint32_t front, target, place, is_diagonal;
    float values[9]; /* column-major */
} term_block;

typedef struct factor_work {
    sparse_cholesky *factor;
    const cholesky_matrix *matrix;
    const front_task *tasks;
    const uint32_t *block_begin; /* of each front, into blocks */
    const term_block *blocks;
    float *panels, *stacks; /* of each worker */
} factor_work;

/* ---- terms ---- */

typedef struct term_sorter {
    const sparse_cholesky *factor;
    const cholesky_matrix *matrix;
    const uint32_t *owners; /* front of each place */
    term_block *blocks;
    size_t count;
} term_sorter;

static bool takes_part(const term_sorter *work, uint32_t vertex) {
    return vertex != TULLE_NONE && !(work->matrix->is_fixed && work->matrix->is_fixed[vertex]);
}

/* Where the block of two vertices goes; false if it is not in the factor. */
static bool locate_block(const term_sorter *work, uint32_t a, uint32_t b, term_block *block) {
    const sparse_cholesky *const factor = work->factor;
    uint32_t const first = factor->places[a], second = factor->places[b];
    uint32_t const low = first < second ? first : second, high = first < second ? second : first;
    block->front = work->owners[low];
    const cholesky_front *const front = &factor->fronts.data[block->front];
    uint32_t const row = find_in_front(factor, front, high);
    if (row == TULLE_NONE) return false;
    size_t const stride = get_panel(front, NULL).stride;
    block->place = low;
    block->is_diagonal = low == high;
    block->target = (uint32_t)(3 * (low - front->begin) * stride + 3 * (size_t)row);
    return true;
}

/* Whether the vertices of the term that are on both sides of `side`, or with `side` 0 all of them,
 * are joined in the factor. */
static bool is_joined(const term_sorter *work, const cholesky_term *term, uint32_t begin,
                      uint32_t end) {
    term_block block;
    for (uint32_t i = begin; i < end; i++)
        for (uint32_t j = i + 1; j < end; j++)
            if (takes_part(work, term->vertices[i]) && takes_part(work, term->vertices[j]) &&
                !locate_block(work, term->vertices[i], term->vertices[j], &block))
                return false;
    return true;
}

static void add_blocks(term_sorter *work, const cholesky_term *term, uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; i++)
        for (uint32_t j = i; j < end; j++) {
            if (!takes_part(work, term->vertices[i]) || !takes_part(work, term->vertices[j]))
                continue;
            term_block *const block = &work->blocks[work->count++];
            locate_block(work, term->vertices[i], term->vertices[j], block);
            double const scale = term->weights[i] * term->weights[j];
            for (size_t k = 0; k < 9; k++) block->values[k] = (float)(scale * term->stiffness.m[k]);
        }
}

/* Blocks of all terms, in their order; of sides that are not joined each by itself, if it is. */
static uint64_t list_blocks(term_sorter *work) {
    uint64_t dropped = 0;
    for (size_t t = 0; t < work->matrix->term_count; t++) {
        const cholesky_term *const term = &work->matrix->terms[t];
        if (is_joined(work, term, 0, 4)) {
            add_blocks(work, term, 0, 4);
            continue;
        }
        dropped++;
        if (is_joined(work, term, 0, term->side)) add_blocks(work, term, 0, term->side);
        if (is_joined(work, term, term->side, 4)) add_blocks(work, term, term->side, 4);
    }
    return dropped;
}

static uint32_t *find_owners(const sparse_cholesky *factor, arena *scratch) {
    uint32_t *const owners = ARENA_NEW(scratch, uint32_t, factor->vertex_count);
    for (uint32_t i = 0; owners && i < factor->fronts.count; i++)
        for (uint32_t k = 0; k < factor->fronts.data[i].own; k++)
            owners[factor->fronts.data[i].begin + k] = i;
    return owners;
}

/* Sorts the blocks by front, keeping their order in each. */
static tulle_status sort_terms(factor_work *work, arena *scratch, uint64_t *dropped) {
    size_t const fronts = work->factor->fronts.count, most = 10 * work->matrix->term_count;
    uint32_t *const begin = ARENA_NEW_ZEROED(scratch, uint32_t, fronts + 2);
    term_block *const listed = ARENA_NEW(scratch, term_block, most);
    term_block *const sorted = ARENA_NEW(scratch, term_block, most);
    const uint32_t *const owners = find_owners(work->factor, scratch);
    if (!begin || !listed || !sorted || !owners) return TULLE_ERROR_OUT_OF_MEMORY;
    term_sorter sorter = {work->factor, work->matrix, owners, listed, 0};
    *dropped = list_blocks(&sorter);
    for (size_t i = 0; i < sorter.count; i++) begin[listed[i].front + 2]++;
    for (size_t f = 0; f < fronts; f++) begin[f + 2] += begin[f + 1];
    for (size_t i = 0; i < sorter.count; i++) sorted[begin[listed[i].front + 1]++] = listed[i];
    work->block_begin = begin;
    work->blocks = sorted;
    return TULLE_OK;
}

/* ---- fronts ---- */

static void add_entry(const factor_work *work, const front_entry *entry, float *panel,
                      size_t stride) {
    const cholesky_matrix *const matrix = work->matrix;
    float *const target = panel + entry->target;
    bool const is_diagonal = entry->row == entry->column;
    if (matrix->is_fixed && (matrix->is_fixed[entry->row] || matrix->is_fixed[entry->column])) {
        for (size_t i = 0; i < 3 && is_diagonal; i++) target[i * stride + i] = 1.0F;
        return;
    }
    /* The block lies in the column's row of the matrix: its transpose goes to the factor. */
    const double *const block = matrix->blocks + 9 * (size_t)entry->source;
    double shift = 0.0;
    for (int i = 0; i < 2; i++)
        if (matrix->shifts[i]) shift += matrix->shift_factors[i] * matrix->shifts[i][entry->source];
    for (size_t i = 0; i < 3; i++)
        for (size_t j = 0; j < 3; j++)
            target[j * stride + i] = (float)(block[3 * i + j] - (i == j ? shift : 0.0));
}

static void assemble_matrix(const factor_work *work, uint32_t index, float *panel, size_t stride) {
    const sparse_cholesky *const factor = work->factor;
    const cholesky_front *const front = &factor->fronts.data[index];
    for (size_t k = front->entry_begin; k < front->entry_end; k++)
        add_entry(work, &factor->entries.data[k], panel, stride);
    for (uint32_t k = work->block_begin ? work->block_begin[index] : 0;
         work->block_begin && k < work->block_begin[index + 1]; k++) {
        const term_block *const block = &work->blocks[k];
        for (size_t i = 0; i < 9; i++) {
            /* Above the diagonal nothing is read. */
            panel[block->target + i / 3 * stride + i % 3] += block->values[i];
        }
    }
    float *const floors = factor->floors + 3 * (size_t)front->begin;
    for (size_t i = 0; i < 3 * (size_t)front->own; i++)
        floors[i] = fmaxf(LEAST_PIVOT * panel[i * stride + i], SMALLEST_PIVOT);
}

static float *get_update(const factor_work *work, const cholesky_front *front, int worker) {
    return front->keeps_update
               ? work->factor->updates + front->update
               : work->stacks + (size_t)worker * work->factor->largest_stack + front->update;
}

/* Adds a child's update to the panel and the update of its parent. */
static void add_child(const factor_work *work, const cholesky_front *child,
                      const front_panel *panel, float *update, int worker) {
    update_sum const sum = {.from = get_update(work, child, worker),
                            .from_stride = front_round_up(3 * (size_t)child->others),
                            .runs = work->factor->runs.data + child->run_begin,
                            .run_count = child->run_end - child->run_begin,
                            .panel = *panel,
                            .update = update};
    TULLE_PICK_KERNEL(add_update)(&sum);
}

/* The lower triangle of `size` columns, whole registers of rows. */
static void clear_lower(float *columns, size_t size, size_t stride) {
    for (size_t j = 0; j < size; j++) {
        size_t const top = j / FRONT_ROWS * FRONT_ROWS;
        memset(columns + j * stride + top, 0, (stride - top) * sizeof(float));
    }
}

static void factor_one(const factor_work *work, uint32_t index, int worker) {
    sparse_cholesky *const factor = work->factor;
    const cholesky_front *const front = &factor->fronts.data[index];
    front_panel const panel =
        get_panel(front, work->panels + (size_t)worker * factor->largest_panel);
    float *const update = get_update(work, front, worker);
    memset(panel.columns, 0, panel.own * panel.stride * sizeof(float));
    clear_lower(update, panel.others, front_round_up(panel.others));
    assemble_matrix(work, index, panel.columns, panel.stride);
    for (uint32_t c = front->child_begin; c < front->child_end; c++)
        add_child(work, &factor->fronts.data[factor->children.data[c]], &panel, update, worker);
    factor->raised[index] =
        TULLE_PICK_KERNEL(factor_front)(&panel, factor->floors + 3 * (size_t)front->begin, update);
    packed_front const packed = get_packed(factor, front);
    TULLE_PICK_KERNEL(pack_front)(&panel, &packed);
}

static void run_tasks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const factor_work *const work = context;
    for (size_t t = begin; t < end; t++)
        for (uint32_t i = work->tasks[t].begin; i < work->tasks[t].end; i++)
            factor_one(work, i, worker);
}

tulle_status sparse_cholesky_factor(sparse_cholesky *factor, const cholesky_matrix *matrix,
                                    int threads, arena *scratch, cholesky_report *report) {
    factor_work work = {.factor = factor, .matrix = matrix};
    arena_mark const mark = arena_get_mark(scratch);
    *report = (cholesky_report){0};
    tulle_status status = TULLE_OK;
    size_t const workers = (size_t)threads;
    work.panels = ARENA_NEW(scratch, float, workers * factor->largest_panel);
    work.stacks = ARENA_NEW(scratch, float, workers * factor->largest_stack);
    if (!work.panels || !work.stacks) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK && matrix->term_count > 0)
        status = sort_terms(&work, scratch, &report->dropped_terms);
    if (status == TULLE_OK) {
        for (size_t w = 0; w + 1 < factor->waves.count; w++) {
            work.tasks = factor->tasks.data + factor->waves.data[w];
            parallel_for(factor->waves.data[w + 1] - factor->waves.data[w], 1, threads, run_tasks,
                         &work);
        }
        for (size_t i = 0; i < factor->fronts.count; i++)
            report->raised_pivots += factor->raised[i];
        for (size_t v = 0; v < factor->vertex_count; v++)
            factor->is_fixed[v] = matrix->is_fixed && matrix->is_fixed[v];
    }
    arena_release(scratch, mark);
    return status;
}
