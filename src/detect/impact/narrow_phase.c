/* detect/impact/narrow_phase.c - tests of candidates in batches, see narrow_phase.h.
 *
 * Each worker takes its pairs through the filters as they come, several at a time. Pairs that
 * survive wait in the worker's pool of that kind; a full pool goes through conservative
 * advancement. Pairs out of the range of the kernels are tested one by one. Events go to blocks of
 * a shared store and are sorted at the end, so neither they nor their order depend on who tested
 * what. */
#include "detect/impact/narrow_phase.h"

#include "base/timer.h"
#include "detect/impact/impact_pool.h"
#include "detect/impact/narrow_events.h"

#include <math.h>
#include <string.h>

enum { FILTER_PART = 512 }; /* pairs of a batch that are filtered at a time */

/* [largest coordinate] What a gap of points may differ from that of the true paths: two points are
 * off by half a unit of floats each, and sums round by less than 84 halves in all. */
static const double GAP_ROUNDING = 128.0 * 0x1.0p-24;
static const double GAP_UNDERFLOW = 0x1.0p-140;
/* Where coordinates are larger, sums may overflow. */
static const double LARGEST_POINT = 1e37;
/* The length of a diagonal, rounded upward: distances are shorter than gaps by that. */
static const double DIAGONAL = 1.7321;

/* No event is later: everything is wanted. */
static const double NO_LIMIT = 2.0;

typedef struct narrow_worker {
    narrow_phase_counts counts;
    impact_pool pools[2]; /* of each feature_kind */
    impact_result results[IMPACT_POOL_SIZE];
    uint32_t first[FILTER_PART + 16], second[FILTER_PART + 16]; /* pairs being filtered */
    double separations[FILTER_PART + 8];
    uint32_t odd[IMPACT_POOL_SIZE];
    event_writer writer;
} narrow_worker;

struct narrow_phase {
    memory *heap;
    narrow_phase_input input;
    narrow_worker *workers;
    int worker_count; /* allocated */
    event_store store;
    double most_separation;  /* [m] of any pair */
    _Atomic double earliest; /* smallest time of an event so far, for only_earliest */
};

tulle_status narrow_phase_create(memory *heap, narrow_phase **result) {
    narrow_phase *const narrow = memory_allocate_zeroed(heap, 1, sizeof *narrow);
    if (!narrow) return TULLE_ERROR_OUT_OF_MEMORY;
    narrow->heap = heap;
    *result = narrow;
    return TULLE_OK;
}

static void free_workers(narrow_phase *narrow) {
    memory_release(narrow->heap, narrow->workers,
                   (size_t)narrow->worker_count * sizeof *narrow->workers);
    narrow->workers = NULL;
    narrow->worker_count = 0;
}

void narrow_phase_destroy(narrow_phase *narrow) {
    if (!narrow) return;
    memory *const heap = narrow->heap;
    free_workers(narrow);
    event_store_free(heap, &narrow->store);
    memory_release(heap, narrow, sizeof *narrow);
}

static bool make_workers(narrow_phase *narrow, int threads) {
    if (threads > narrow->worker_count) {
        free_workers(narrow);
        narrow->workers =
            memory_allocate_zeroed(narrow->heap, (size_t)threads, sizeof *narrow->workers);
        if (!narrow->workers) return false;
        narrow->worker_count = threads;
    }
    for (int w = 0; w < threads; w++) {
        narrow_worker *const worker = &narrow->workers[w];
        worker->counts = (narrow_phase_counts){0};
        worker->pools[0].count = worker->pools[1].count = 0;
        worker->pools[0].filtered_count = worker->pools[1].filtered_count = 0;
        event_writer_start(&worker->writer, &narrow->store);
    }
    return true;
}

tulle_status narrow_phase_start(narrow_phase *narrow, const narrow_phase_input *input) {
    narrow->input = *input;
    atomic_store(&narrow->earliest, NO_LIMIT);
    size_t const pair_count =
        input->vertex_surface ? input->set->surface_count * input->set->surface_count : 1;
    narrow->most_separation = 0.0;
    for (size_t i = 0; i < pair_count; i++)
        narrow->most_separation = fmax(narrow->most_separation, input->separations[i]);
    if (!event_store_start(narrow->heap, &narrow->store, input->threads) ||
        !make_workers(narrow, input->threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    return TULLE_OK;
}

static void get_records(const pair_tables *tables, feature_kind kind, uint32_t first,
                        uint32_t second, uint32_t records[4]) {
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        records[0] = tables->vertex_corners[first];
        memcpy(records + 1, tables->triangle_corners + 3 * (size_t)second, 3 * sizeof *records);
    } else {
        memcpy(records, tables->edge_corners + 2 * (size_t)first, 2 * sizeof *records);
        memcpy(records + 2, tables->edge_corners + 2 * (size_t)second, 2 * sizeof *records);
    }
}

static double get_separation(const narrow_phase_input *input, feature_kind kind,
                             const uint32_t records[4]) {
    if (!input->vertex_surface) return input->separations[0];
    size_t const a = input->vertex_surface[records[0]];
    size_t const b = input->vertex_surface[records[kind == FEATURE_EDGE_EDGE ? 2 : 1]];
    return input->separations[a * input->set->surface_count + b];
}

static void add_event(narrow_phase *narrow, const pair_tables *tables, feature_kind kind,
                      const impact_result *result, narrow_worker *own) {
    bool const has_face = kind == FEATURE_VERTEX_TRIANGLE;
    const uint32_t *const first = has_face ? tables->vertex_features : tables->edge_features;
    const uint32_t *const second = has_face ? tables->triangle_features : tables->edge_features;
    event_writer_add(&own->writer, (raw_event){.key = (uint64_t)first[result->first] << 32 |
                                                      second[result->second],
                                               .time = result->time,
                                               .kind = (uint8_t)kind,
                                               .state = (uint8_t)result->state});
    if (!narrow->input.only_earliest) return;
    double known = atomic_load_explicit(&narrow->earliest, memory_order_relaxed);
    while (result->time < known &&
           !atomic_compare_exchange_weak(&narrow->earliest, &known, result->time)) {}
}

/* Takes the pairs of a pool through conservative advancement. */
static void advance_pool(narrow_phase *narrow, const pair_tables *tables, feature_kind kind,
                         bool is_last, narrow_worker *own) {
    double const began = timer_now();
    bool const only_earliest = narrow->input.only_earliest;
    double latest =
        only_earliest ? atomic_load_explicit(&narrow->earliest, memory_order_relaxed) : NO_LIMIT;
    size_t const count = TULLE_PICK_KERNEL(advance_impacts)(&own->pools[kind], kind, is_last,
                                                            only_earliest, &latest, own->results);
    for (size_t i = 0; i < count; i++) add_event(narrow, tables, kind, &own->results[i], own);
    own->counts.impact_seconds += timer_now() - began;
}

/* Pairs that are not finite, or huge or tiny. */
static void test_odd_pair(narrow_phase *narrow, const pair_tables *tables, const slot_pairs *pairs,
                          uint32_t index, narrow_worker *own) {
    moving_pair pair;
    impact_result result = {.first = pairs->first[index], .second = pairs->second[index]};
    uint32_t records[4];
    get_records(tables, pairs->kind, result.first, result.second, records);
    for (int k = 0; k < 4; k++) {
        pair.start[k] = vec3_load(tables->records[records[k]].start, 0);
        pair.end[k] = vec3_load(tables->records[records[k]].end, 0);
    }
    double const separation = get_separation(&narrow->input, pairs->kind, records);
    if (prove_apart(pairs->kind, &pair, separation) == APART_BY_DIRECTION) return;
    own->counts.pooled_count++;
    own->counts.tested_count++;
    toi_result const found = time_of_impact(pairs->kind, &pair, separation);
    if (found.state == TOI_SEPARATED) return;
    result.time = found.lower_bound;
    result.state = found.state;
    add_event(narrow, tables, pairs->kind, &result, own);
}

/* Takes pairs through the first direction into the pool, which is emptied whenever it is full. */
static void begin_pairs(narrow_phase *narrow, const pair_tables *tables, slot_pairs pairs,
                        narrow_worker *own) {
    impact_pool *const pool = &own->pools[pairs.kind];
    while (pairs.count > 0) {
        size_t const room = IMPACT_POOL_SIZE - pool->count;
        slot_pairs part = pairs;
        part.count = pairs.count < room ? pairs.count : room;
        size_t const before = pool->count;
        size_t const odd_count = TULLE_PICK_KERNEL(begin_impacts)(tables, &part, pool, own->odd);
        own->counts.pooled_count += pool->count - before;
        own->counts.tested_count += pool->count - before;
        for (size_t i = 0; i < odd_count; i++)
            test_odd_pair(narrow, tables, &part, own->odd[i], own);
        pairs.count -= part.count;
        pairs.first += part.count;
        pairs.second += part.count;
        if (pairs.separations) pairs.separations += part.count;
        if (pool->count > IMPACT_POOL_SIZE / 2)
            advance_pool(narrow, tables, pairs.kind, false, own);
    }
}

/* The gap of points beyond which a pair keeps any separation. */
static float choose_limit(const narrow_phase *narrow, const pair_tables *tables) {
    if (!(tables->largest_point < LARGEST_POINT)) return INFINITY;
    double const separation = DIAGONAL * tables->point_scale * narrow->most_separation;
    double const limit = separation + GAP_ROUNDING * tables->largest_point + GAP_UNDERFLOW;
    return nextafterf((float)limit, INFINITY);
}

/* The separations of pairs, or null where all are 0. */
static const double *list_separations(const narrow_phase *narrow, const pair_tables *tables,
                                      const slot_pairs *pairs, double *separations) {
    if (narrow->most_separation == 0.0) return NULL;
    for (size_t i = 0; i < pairs->count; i++) {
        uint32_t records[4] = {0};
        if (narrow->input.vertex_surface)
            get_records(tables, pairs->kind, pairs->first[i], pairs->second[i], records);
        separations[i] = get_separation(&narrow->input, pairs->kind, records);
    }
    return separations;
}

void consume_pairs(void *context, const pair_tables *tables, const pair_batch *batch, int worker) {
    narrow_phase *const narrow = context;
    narrow_worker *const own = &narrow->workers[worker];
    double const began = timer_now(), impact_began = own->counts.impact_seconds;
    float const limit = choose_limit(narrow, tables);
    for (size_t begin = 0; begin < batch->count; begin += FILTER_PART) {
        size_t const left = batch->count - begin;
        slot_pairs pairs = {batch->kind, left < FILTER_PART ? left : FILTER_PART,
                            batch->first + begin, batch->second + begin, NULL};
        if (tables->points) {
            pairs.count = TULLE_PICK_KERNEL(filter_directions)(tables, &pairs, limit, own->first,
                                                               own->second);
            pairs.first = own->first;
            pairs.second = own->second;
        }
        pairs.separations = list_separations(narrow, tables, &pairs, own->separations);

        /* Those that may cross, edges in ascending order of their features, so that results do not
         * depend on the tree. */
        pairs.count = TULLE_PICK_KERNEL(filter_coplanarity)(tables, &pairs, own->first, own->second,
                                                            own->separations);
        pairs.first = own->first;
        pairs.second = own->second;
        for (size_t i = 0; batch->kind == FEATURE_EDGE_EDGE && i < pairs.count; i++) {
            uint32_t const first = own->first[i], second = own->second[i];
            bool const swaps = tables->edge_features[first] > tables->edge_features[second];
            own->first[i] = swaps ? second : first;
            own->second[i] = swaps ? first : second;
        }
        begin_pairs(narrow, tables, pairs, own);
    }
    own->counts.candidate_count += batch->count;
    own->counts.filter_seconds += timer_now() - began - (own->counts.impact_seconds - impact_began);
}

void narrow_phase_flush(narrow_phase *narrow, const pair_tables *tables, int worker) {
    narrow_worker *const own = &narrow->workers[worker];
    advance_pool(narrow, tables, FEATURE_VERTEX_TRIANGLE, true, own);
    advance_pool(narrow, tables, FEATURE_EDGE_EDGE, true, own);
    event_writer_finish(&own->writer);
}

bool narrow_phase_finish(narrow_phase *narrow, tulle_status *status) {
    if (!event_store_is_complete(narrow->heap, &narrow->store, narrow->input.threads, status))
        return false;
    if (event_store_sort(narrow->heap, &narrow->store, narrow->input.only_earliest)) return true;
    *status = TULLE_ERROR_OUT_OF_MEMORY;
    return false;
}

const raw_event *narrow_phase_get_events(const narrow_phase *narrow, size_t *count) {
    *count = narrow->store.sorted.count;
    return narrow->store.sorted.data;
}

narrow_phase_counts narrow_phase_get_counts(const narrow_phase *narrow) {
    narrow_phase_counts sum = {0};
    for (int w = 0; w < narrow->input.threads; w++) {
        const narrow_phase_counts *const counts = &narrow->workers[w].counts;
        sum.candidate_count += counts->candidate_count;
        sum.pooled_count += counts->pooled_count;
        sum.tested_count += counts->tested_count - narrow->workers[w].pools[0].filtered_count -
                            narrow->workers[w].pools[1].filtered_count;
        sum.filter_seconds += counts->filter_seconds;
        sum.impact_seconds += counts->impact_seconds;
    }
    sum.filtered_count = sum.candidate_count - sum.tested_count;
    return sum;
}
