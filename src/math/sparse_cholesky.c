/* math/sparse_cholesky.c - pattern of the factor, see sparse_cholesky.h. */
#include "math/sparse_cholesky_parts.h"

#include <stdlib.h>
#include <string.h>

/* While the pattern is found. */
typedef struct pattern_builder {
    memory *heap;
    sparse_cholesky *factor;
    block_pattern pattern;
    const dissection *cuts;
    uint32_t *marks; /* by place: number of the front that has seen it, + 1 */
} pattern_builder;

static int compare_places(const void *a, const void *b) {
    uint32_t const x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static bool add_row(pattern_builder *work, uint32_t front, uint32_t place) {
    sparse_cholesky *const factor = work->factor;
    if (work->marks[place] == front + 1) return true;
    work->marks[place] = front + 1;
    if (!ARRAY_RESERVE(work->heap, &factor->rows, 1)) return false;
    factor->rows.data[factor->rows.count++] = place;
    return true;
}

/* Later vertices: what own ones touch, and what is left of the fronts below. */
static bool find_rows(pattern_builder *work, uint32_t index) {
    sparse_cholesky *const factor = work->factor;
    cholesky_front *const front = &factor->fronts.data[index];
    uint32_t const end = front->begin + front->own;
    front->row_begin = factor->rows.count;
    bool ok = true;
    for (uint32_t place = front->begin; place < end; place++) {
        uint32_t const vertex = factor->order[place];
        for (uint32_t k = work->pattern.begin[vertex]; k < work->pattern.begin[vertex + 1]; k++) {
            uint32_t const other = factor->places[work->pattern.columns[k]];
            if (other >= end) ok = ok && add_row(work, index, other);
        }
    }
    for (uint32_t c = front->child_begin; c < front->child_end; c++) {
        const cholesky_front *const child = &factor->fronts.data[factor->children.data[c]];
        for (size_t k = 0; k < child->others; k++) {
            uint32_t const place = factor->rows.data[child->row_begin + k];
            if (place >= end) ok = ok && add_row(work, index, place);
        }
    }
    if (!ok) return false;
    front->others = (uint32_t)(factor->rows.count - front->row_begin);
    if (front->others > 0)
        qsort(factor->rows.data + front->row_begin, front->others, sizeof(uint32_t),
              compare_places);
    return true;
}

/* Place of a vertex in a front, own ones first; TULLE_NONE if it is not there. */
uint32_t find_in_front(const sparse_cholesky *factor, const cholesky_front *front, uint32_t place) {
    if (place < front->begin) return TULLE_NONE;
    if (place < front->begin + front->own) return place - front->begin;
    if (front->others == 0) return TULLE_NONE;
    const uint32_t *const rows = factor->rows.data + front->row_begin;
    const uint32_t *const found =
        bsearch(&place, rows, front->others, sizeof(uint32_t), compare_places);
    return found ? front->own + (uint32_t)(found - rows) : TULLE_NONE;
}

/* Where a front's later vertices are in its parent. */
static bool find_runs(pattern_builder *work, cholesky_front *front) {
    sparse_cholesky *const factor = work->factor;
    front->run_begin = (uint32_t)factor->runs.count;
    const cholesky_front *const parent =
        front->parent == TULLE_NONE ? NULL : &factor->fronts.data[front->parent];
    for (uint32_t k = 0; parent && k < front->others; k++) {
        uint32_t const to = find_in_front(factor, parent, factor->rows.data[front->row_begin + k]);
        front_run *const last = factor->runs.count > front->run_begin
                                    ? &factor->runs.data[factor->runs.count - 1]
                                    : NULL;
        if (last && to == last->to + last->count && to != parent->own) {
            last->count++;
            continue;
        }
        if (!ARRAY_RESERVE(work->heap, &factor->runs, 1)) return false;
        factor->runs.data[factor->runs.count++] = (front_run){k, to, 1};
    }
    front->run_end = (uint32_t)factor->runs.count;
    return true;
}

/* The pattern's blocks on and below the diagonal of own columns. */
static bool find_entries(pattern_builder *work, cholesky_front *front) {
    sparse_cholesky *const factor = work->factor;
    front->entry_begin = factor->entries.count;
    size_t const stride = get_panel(front, NULL).stride;
    for (uint32_t column = 0; column < front->own; column++) {
        uint32_t const vertex = factor->order[front->begin + column];
        for (uint32_t k = work->pattern.begin[vertex]; k < work->pattern.begin[vertex + 1]; k++) {
            uint32_t const other = work->pattern.columns[k];
            if (factor->places[other] < front->begin + column) continue;
            uint32_t const row = find_in_front(factor, front, factor->places[other]);
            if (!ARRAY_RESERVE(work->heap, &factor->entries, 1)) return false;
            factor->entries.data[factor->entries.count++] =
                (front_entry){k, other, vertex, (uint32_t)(3 * column * stride + 3 * (size_t)row)};
        }
    }
    front->entry_end = factor->entries.count;
    return true;
}

/* Products and sums of a front's factor and update. */
static uint64_t count_operations(const cholesky_front *front) {
    uint64_t const own = 3 * (uint64_t)front->own, others = 3 * (uint64_t)front->others;
    return own * own * own / 3 + own * own * others + own * others * others;
}

static bool make_fronts(pattern_builder *work) {
    sparse_cholesky *const factor = work->factor;
    size_t const count = work->cuts->nodes.count;
    if (!ARRAY_RESERVE(work->heap, &factor->fronts, count) ||
        !ARRAY_RESERVE(work->heap, &factor->children, count))
        return false;
    factor->fronts.count = count;
    for (size_t i = 0; i < count; i++) {
        const dissection_node *const node = &work->cuts->nodes.data[i];
        factor->fronts.data[i] = (cholesky_front){
            .begin = node->begin, .own = node->end - node->begin, .parent = node->parent};
    }
    /* Children come just before their parent's other children or the parent: collect backwards. */
    for (size_t i = 0; i < count; i++)
        if (factor->fronts.data[i].parent != TULLE_NONE)
            factor->fronts.data[factor->fronts.data[i].parent].child_end++;
    uint32_t place = 0;
    for (size_t i = 0; i < count; i++) {
        cholesky_front *const front = &factor->fronts.data[i];
        uint32_t const children = front->child_end;
        front->child_begin = front->child_end = place;
        place += children;
    }
    factor->children.count = place;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t const parent = factor->fronts.data[i].parent;
        if (parent != TULLE_NONE)
            factor->children.data[factor->fronts.data[parent].child_end++] = i;
    }
    return true;
}

static bool lay_out_fronts(pattern_builder *work) {
    sparse_cholesky *const factor = work->factor;
    size_t const count = factor->fronts.count;
    for (uint32_t i = 0; i < count; i++)
        if (!find_rows(work, i)) return false;
    for (size_t i = 0; i < count; i++) {
        cholesky_front *const front = &factor->fronts.data[i];
        front_panel const panel = get_panel(front, NULL);
        front->panel = factor->panel_size;
        front->vector = factor->vector_size;
        factor->panel_size += panel.own * panel.stride;
        if (panel.own * panel.stride > factor->largest_panel)
            factor->largest_panel = panel.own * panel.stride;
        factor->vector_size += panel.stride;
        factor->operations += count_operations(front);
        factor->entry_count += panel.own * (panel.own + 1) / 2 + panel.own * panel.others;
        if (!find_runs(work, front) || !find_entries(work, front)) return false;
    }
    return plan_tasks(work->heap, factor);
}

static bool allocate_numbers(memory *heap, sparse_cholesky *factor) {
    size_t const count = factor->vertex_count;
    factor->columns = memory_allocate(heap, factor->panel_size * sizeof(int16_t));
    factor->scales = memory_allocate(heap, 3 * count * sizeof(float));
    factor->inverses = memory_allocate(heap, 3 * count * sizeof(float));
    factor->updates = memory_allocate(heap, factor->update_size * sizeof(float));
    factor->vectors = memory_allocate(heap, factor->vector_size * sizeof(float));
    factor->floors = memory_allocate(heap, 3 * count * sizeof(float));
    factor->is_fixed = memory_allocate_zeroed(heap, count, 1);
    factor->raised = memory_allocate(heap, factor->fronts.count * sizeof(uint32_t));
    return factor->columns && factor->scales && factor->inverses && factor->updates &&
           factor->vectors && factor->floors && factor->is_fixed && factor->raised;
}

static bool build_pattern(memory *heap, sparse_cholesky *factor, block_pattern pattern,
                          const double *positions) {
    size_t const count = factor->vertex_count;
    dissection cuts;
    if (!dissection_build(heap, count, pattern, positions, &cuts)) return false;
    pattern_builder work = {heap, factor, pattern, &cuts, NULL};
    factor->order = memory_allocate(heap, count * sizeof(uint32_t));
    factor->places = memory_allocate(heap, count * sizeof(uint32_t));
    work.marks = memory_allocate_zeroed(heap, count, sizeof(uint32_t));
    bool ok = factor->order && factor->places && work.marks;
    for (uint32_t place = 0; ok && place < count; place++) {
        factor->order[place] = cuts.order[place];
        factor->places[cuts.order[place]] = place;
    }
    ok = ok && make_fronts(&work) && lay_out_fronts(&work) && allocate_numbers(heap, factor);
    memory_release(heap, work.marks, count * sizeof(uint32_t));
    dissection_destroy(heap, &cuts);
    return ok;
}

sparse_cholesky *sparse_cholesky_build(memory *heap, size_t vertex_count, block_pattern pattern,
                                       const double *positions) {
    sparse_cholesky *const factor = memory_allocate_zeroed(heap, 1, sizeof *factor);
    if (!factor) return NULL;
    factor->vertex_count = vertex_count;
    if (build_pattern(heap, factor, pattern, positions)) return factor;
    sparse_cholesky_destroy(heap, factor);
    return NULL;
}

void sparse_cholesky_destroy(memory *heap, sparse_cholesky *factor) {
    if (!factor) return;
    size_t const count = factor->vertex_count;
    memory_release(heap, factor->order, count * sizeof(uint32_t));
    memory_release(heap, factor->places, count * sizeof(uint32_t));
    memory_release(heap, factor->columns, factor->panel_size * sizeof(int16_t));
    memory_release(heap, factor->scales, 3 * count * sizeof(float));
    memory_release(heap, factor->inverses, 3 * count * sizeof(float));
    memory_release(heap, factor->updates, factor->update_size * sizeof(float));
    memory_release(heap, factor->vectors, factor->vector_size * sizeof(float));
    memory_release(heap, factor->floors, 3 * count * sizeof(float));
    memory_release(heap, factor->is_fixed, count);
    memory_release(heap, factor->raised, factor->fronts.count * sizeof(uint32_t));
    ARRAY_FREE(heap, &factor->fronts);
    ARRAY_FREE(heap, &factor->children);
    ARRAY_FREE(heap, &factor->rows);
    ARRAY_FREE(heap, &factor->runs);
    ARRAY_FREE(heap, &factor->entries);
    ARRAY_FREE(heap, &factor->tasks);
    ARRAY_FREE(heap, &factor->waves);
    memory_release(heap, factor, sizeof *factor);
}

sparse_cholesky_size sparse_cholesky_measure(const sparse_cholesky *factor) {
    size_t const floats = factor->update_size + factor->vector_size + 9 * factor->vertex_count;
    return (sparse_cholesky_size){.entries = factor->entry_count,
                                  .operations = factor->operations,
                                  .bytes = floats * sizeof(float) +
                                           factor->panel_size * sizeof(int16_t) +
                                           factor->entries.capacity * sizeof(front_entry) +
                                           factor->rows.capacity * sizeof(uint32_t) +
                                           factor->runs.capacity * sizeof(front_run) +
                                           factor->fronts.capacity * sizeof(cholesky_front)};
}
