/* detect/narrow_phase.c - stage 8 in batches, see narrow_phase.h.
 *
 * Each worker takes its pairs through the filters at once; what survives waits in the worker's
 * queue of that kind until it is full, then goes through conservative advancement. Events go to
 * blocks of a shared store and are sorted at the end, so neither they nor their order depend on
 * who tested what. */
#include "detect/narrow_phase.h"

#include "base/timer.h"
#include "detect/narrow_events.h"

#include <string.h>

enum { QUEUE_SIZE = 2 * PAIR_BATCH_SIZE };

/* Pairs that passed the filters, as slots. */
typedef struct survivor_queue {
    size_t count;
    uint32_t first[QUEUE_SIZE], second[QUEUE_SIZE];
} survivor_queue;

typedef struct narrow_worker {
    narrow_phase_counts counts;
    survivor_queue queues[2]; /* of each feature_kind */
    event_writer writer;
} narrow_worker;

struct narrow_phase {
    memory *heap;
    narrow_phase_input input;
    narrow_worker *workers;
    int worker_count; /* allocated */
    event_store store;
    _Atomic double earliest; /* smallest time of an event so far */
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
        worker->queues[0].count = worker->queues[1].count = 0;
        event_writer_start(&worker->writer, &narrow->store);
    }
    return true;
}

tulle_status narrow_phase_start(narrow_phase *narrow, const narrow_phase_input *input) {
    narrow->input = *input;
    atomic_store(&narrow->earliest, 1.0);
    if (!event_store_start(narrow->heap, &narrow->store, input->threads) ||
        !make_workers(narrow, input->threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    return TULLE_OK;
}

static void load_pair(const pair_tables *tables, feature_kind kind, uint32_t first, uint32_t second,
                      moving_pair *pair, uint32_t records[4]) {
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        records[0] = tables->vertex_corners[first];
        memcpy(records + 1, tables->triangle_corners + 3 * (size_t)second, 3 * sizeof *records);
    } else {
        memcpy(records, tables->edge_corners + 2 * (size_t)first, 2 * sizeof *records);
        memcpy(records + 2, tables->edge_corners + 2 * (size_t)second, 2 * sizeof *records);
    }
    for (int k = 0; k < 4; k++) {
        pair->start[k] = vec3_load(tables->records[records[k]].start, 0);
        pair->end[k] = vec3_load(tables->records[records[k]].end, 0);
    }
}

static double find_separation(const narrow_phase_input *input, feature_kind kind,
                              const uint32_t records[4]) {
    if (!input->vertex_surface) return input->separations[0];
    size_t const a = input->vertex_surface[records[0]];
    size_t const b = input->vertex_surface[records[kind == FEATURE_EDGE_EDGE ? 2 : 1]];
    return input->separations[a * input->set->surface_count + b];
}

/* Edges in ascending order of their features, so that results do not depend on the tree. */
static void order_slots(const pair_tables *tables, feature_kind kind, uint32_t *first,
                        uint32_t *second) {
    if (kind == FEATURE_EDGE_EDGE &&
        tables->edge_features[*first] > tables->edge_features[*second]) {
        uint32_t const swapped = *first;
        *first = *second;
        *second = swapped;
    }
}

static uint64_t make_key(const pair_tables *tables, feature_kind kind, uint32_t first,
                         uint32_t second) {
    return kind == FEATURE_VERTEX_TRIANGLE
               ? (uint64_t)tables->vertex_features[first] << 32 | tables->triangle_features[second]
               : (uint64_t)tables->edge_features[first] << 32 | tables->edge_features[second];
}

static void lower_earliest(narrow_phase *narrow, double time) {
    double known = atomic_load_explicit(&narrow->earliest, memory_order_relaxed);
    while (time < known && !atomic_compare_exchange_weak(&narrow->earliest, &known, time)) {}
}

static void test_queue(narrow_phase *narrow, const pair_tables *tables, feature_kind kind,
                       narrow_worker *worker) {
    double const began = timer_now();
    survivor_queue *const queue = &worker->queues[kind];
    for (size_t i = 0; i < queue->count; i++) {
        moving_pair pair;
        uint32_t records[4];
        load_pair(tables, kind, queue->first[i], queue->second[i], &pair, records);
        toi_result const result =
            time_of_impact(kind, &pair, find_separation(&narrow->input, kind, records));
        if (result.state == TOI_SEPARATED) continue;
        event_writer_add(&worker->writer, (raw_event){.key = make_key(tables, kind, queue->first[i],
                                                                      queue->second[i]),
                                                      .time = result.lower_bound,
                                                      .kind = (uint8_t)kind,
                                                      .state = (uint8_t)result.state});
        if (narrow->input.only_earliest) lower_earliest(narrow, result.lower_bound);
    }
    worker->counts.tested_count += queue->count;
    queue->count = 0;
    worker->counts.impact_seconds += timer_now() - began;
}

void consume_pairs(void *context, const pair_tables *tables, const pair_batch *batch, int worker) {
    narrow_phase *const narrow = context;
    narrow_worker *const own = &narrow->workers[worker];
    survivor_queue *const queue = &own->queues[batch->kind];
    double const began = timer_now();
    size_t const before = queue->count;
    for (size_t i = 0; i < batch->count; i++) {
        uint32_t first = batch->first[i], second = batch->second[i], records[4];
        order_slots(tables, batch->kind, &first, &second);
        moving_pair pair;
        load_pair(tables, batch->kind, first, second, &pair, records);
        double const separation = find_separation(&narrow->input, batch->kind, records);
        if (separation == 0.0 && pair_cannot_cross(&pair)) continue;
        if (pair_stays_apart(batch->kind, &pair, separation)) continue;
        queue->first[queue->count] = first;
        queue->second[queue->count++] = second;
    }
    own->counts.candidate_count += batch->count;
    own->counts.filtered_count += batch->count - (queue->count - before);
    own->counts.filter_seconds += timer_now() - began;
    if (queue->count > QUEUE_SIZE - PAIR_BATCH_SIZE) test_queue(narrow, tables, batch->kind, own);
}

void narrow_phase_flush(narrow_phase *narrow, const pair_tables *tables, int worker) {
    narrow_worker *const own = &narrow->workers[worker];
    test_queue(narrow, tables, FEATURE_VERTEX_TRIANGLE, own);
    test_queue(narrow, tables, FEATURE_EDGE_EDGE, own);
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
        sum.filtered_count += counts->filtered_count;
        sum.tested_count += counts->tested_count;
        sum.filter_seconds += counts->filter_seconds;
        sum.impact_seconds += counts->impact_seconds;
    }
    return sum;
}
