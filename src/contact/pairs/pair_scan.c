/* contact/pairs/pair_scan.c - see pair_scan.h. The cheap test runs over fixed chunks; each copies
 * its survivors to its own part of one array. The survivors, moved together and sorted, go through
 * the full test; what passes is moved together again. */
#include "contact/pairs/pair_scan.h"

#include "base/parallel.h"
#include "contact/pairs/pair_filter.h"
#include "contact/pairs/sort_pairs.h"

#include <string.h>

enum {
    FILTER_CHUNK = 4096, /* pairs; some 30 microseconds */
    FILTER_PART = 512    /* of these, picked at a time */
};
/* Times of pairs that are dropped. */
static const double DROPPED = -1.0;
static const double DROPPED_TURNING = -2.0;
static const double DROPPED_NEAR = -3.0;

typedef struct scan_work {
    const pair_scan *scan;
    pair_filter filter;
    feature_kind kind;          /* being filtered */
    const feature_pair *pairs;  /* of that kind */
    feature_pair *kept;         /* FILTER_CHUNK for each chunk */
    uint32_t *kept_counts;      /* of each chunk */
    feature_pair *survivors[2]; /* by feature_kind, sorted */
    size_t survivor_counts[2];
    pair_event *events;
    stop_poll *stop;
} scan_work;

static void filter_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    scan_work *const work = context;
    const topology *const topo = work->filter.topo;
    const bool *const changed = work->scan->has_changed;
    feature_pair *const kept = work->kept + chunk * FILTER_CHUNK;
    size_t kept_count = 0;
    work->kept_counts[chunk] = 0;
    if (stop_is_wanted(work->stop, worker)) return;
    for (size_t i = begin; i < end; i += FILTER_PART) {
        const feature_pair *part = work->pairs + i;
        size_t count = end - i < FILTER_PART ? end - i : FILTER_PART;
        feature_pair picked[FILTER_PART]; /* those of which a vertex has changed */
        if (changed) {
            size_t picked_count = 0;
            for (size_t k = 0; k < count; k++) {
                picked[picked_count] = part[k];
                picked_count += pair_has_mark(topo, work->kind, part[k], changed);
            }
            part = picked;
            count = picked_count;
        }
        kept_count += TULLE_PICK_KERNEL(filter_pairs)(&work->filter, work->kind, part, count,
                                                      kept + kept_count);
    }
    work->kept_counts[chunk] = (uint32_t)kept_count;
}

/* The full test. Vertices and triangles come first; a chunk may hold the last of them and the first
 * pairs of edges. */
static void measure_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    scan_work *const work = context;
    if (stop_is_wanted(work->stop, worker)) return;
    size_t const first_edge = work->survivor_counts[FEATURE_VERTEX_TRIANGLE];
    while (begin < end) {
        bool const is_vertex = begin < first_edge;
        feature_kind const kind = is_vertex ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
        const feature_pair *const pairs =
            work->survivors[kind] + (is_vertex ? begin : begin - first_edge);
        size_t const count = (is_vertex && end > first_edge ? first_edge : end) - begin;
        pair_event *const event = work->events + begin;
        scan_verdict verdicts[SCAN_MOST];
        for (size_t i = 0; i < count; i++) {
            event[i].kind = kind;
            event[i].pair = pairs[i];
        }
        work->scan->measure(work->scan->context, kind, event, count, verdicts);
        for (size_t i = 0; i < count; i++) {
            if (verdicts[i] == SCAN_DROP) event[i].time = DROPPED;
            if (verdicts[i] == SCAN_DROP_TURNING) event[i].time = DROPPED_TURNING;
            if (verdicts[i] == SCAN_DROP_NEAR) event[i].time = DROPPED_NEAR;
        }
        begin += count;
    }
}

tulle_status scan_pairs(const contact_scene *scene, const pair_list *pairs, const pair_scan *scan,
                        pair_events *result) {
    const feature_pair *const lists[2] = {pairs->vertex_triangle.data, pairs->edge_edge.data};
    size_t const counts[2] = {pairs->vertex_triangle.count, pairs->edge_edge.count};
    size_t const first_counts[2] = {scene->vertex_count, scene->set->topo->edge_count};
    scan_work work = {
        .scan = scan,
        .filter = {scene->set->topo, scan->records, scan->at_start, scan->at_end},
        .stop = scene->stop,
    };
    *result = (pair_events){0};
    if (counts[0] + counts[1] >= UINT32_MAX) return TULLE_ERROR_LIMIT;

    /* the cheap test of each kind: what passes is moved together and sorted */
    for (int kind = 0; kind < 2; kind++) {
        size_t const chunk_count = parallel_chunk_count(counts[kind], FILTER_CHUNK);
        work.kind = (feature_kind)kind;
        work.pairs = lists[kind];
        work.kept = ARENA_NEW(scene->scratch, feature_pair, chunk_count * FILTER_CHUNK);
        work.kept_counts = ARENA_NEW(scene->scratch, uint32_t, chunk_count);
        if (!work.kept || !work.kept_counts) return TULLE_ERROR_OUT_OF_MEMORY;
        parallel_for(counts[kind], FILTER_CHUNK, scene->threads, filter_chunk, &work);
        size_t count = 0;
        for (size_t chunk = 0; chunk < chunk_count; chunk++) {
            memmove(work.kept + count, work.kept + chunk * FILTER_CHUNK,
                    work.kept_counts[chunk] * sizeof *work.kept);
            count += work.kept_counts[chunk];
        }
        work.survivors[kind] = work.kept;
        work.survivor_counts[kind] = count;
        tulle_status const status =
            sort_pairs(scene->scratch, scene->threads, work.kept, count, first_counts[kind]);
        if (status != TULLE_OK) return status;
    }

    /* the full test */
    size_t const survivor_count = work.survivor_counts[0] + work.survivor_counts[1];
    work.events = ARENA_NEW(scene->scratch, pair_event, survivor_count);
    pair_event *const near_pairs =
        scan->notes_near_pairs ? ARENA_NEW(scene->scratch, pair_event, survivor_count) : NULL;
    if (!work.events || (scan->notes_near_pairs && !near_pairs)) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(survivor_count, SCAN_MOST, scene->threads, measure_chunk, &work);
    if (stop_is_wanted(scene->stop, 0)) return TULLE_ERROR_INTERRUPTED;
    /* keeps the events, and copies what is near */
    for (size_t i = 0; i < survivor_count; i++) {
        pair_event const event = work.events[i];
        result->turning_count += event.time == DROPPED_TURNING;
        if (near_pairs && (event.time >= 0.0 || event.time == DROPPED_NEAR))
            near_pairs[result->near_count++] = event;
        if (event.time >= 0.0) work.events[result->count++] = event;
    }
    result->events = work.events;
    result->near_pairs = near_pairs;
    result->measured_count = survivor_count;
    return TULLE_OK;
}
