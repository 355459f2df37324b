/* contact/pair_scan.c - see pair_scan.h. The filter runs over fixed chunks; each notes its
 * survivors in its own part of one index array. The survivors, moved together, go through the full
 * test; what passes is moved together again. */
#include "contact/pair_scan.h"

#include "base/parallel.h"

#include <string.h>

enum {
    FILTER_CHUNK = 2048, /* pairs; some 40 microseconds */
    MEASURE_CHUNK = 64   /* pairs; some 20 to 50 microseconds */
};
/* Times of pairs that are dropped. */
#define DROPPED (-1.0)
#define DROPPED_TURNING (-2.0)
#define DROPPED_NEAR (-3.0)

typedef struct scan_work {
    const pair_list *pairs;
    const pair_scan *scan;
    uint32_t *survivors; /* indices over vertex/triangle, then edge/edge pairs */
    uint32_t *survivor_counts;
    pair_event *events;
    stop_poll *stop;
} scan_work;

static feature_pair get_pair(const pair_list *pairs, size_t index, feature_kind *kind) {
    size_t const vertex_count = pairs->vertex_triangle.count;
    *kind = index < vertex_count ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
    return index < vertex_count ? pairs->vertex_triangle.data[index]
                                : pairs->edge_edge.data[index - vertex_count];
}

static void filter_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    scan_work *const work = context;
    uint32_t count = 0;
    work->survivor_counts[chunk] = 0;
    if (stop_is_wanted_by(work->stop, worker)) return;
    for (size_t i = begin; i < end; i++) {
        feature_kind kind;
        feature_pair const pair = get_pair(work->pairs, i, &kind);
        if (work->scan->filter(work->scan->context, kind, pair))
            work->survivors[begin + count++] = (uint32_t)i;
    }
    work->survivor_counts[chunk] = count;
}

static void measure_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    scan_work *const work = context;
    if (stop_is_wanted_by(work->stop, worker)) return;
    for (size_t i = begin; i < end; i++) {
        pair_event *const event = &work->events[i];
        event->pair = get_pair(work->pairs, work->survivors[i], &event->kind);
        scan_verdict const verdict = work->scan->measure(work->scan->context, event);
        if (verdict == SCAN_DROP) event->time = DROPPED;
        if (verdict == SCAN_DROP_TURNING) event->time = DROPPED_TURNING;
        if (verdict == SCAN_DROP_NEAR) event->time = DROPPED_NEAR;
    }
}

static size_t compact_survivors(scan_work *work, size_t pair_count) {
    size_t count = 0;
    for (size_t chunk = 0; chunk < parallel_chunk_count(pair_count, FILTER_CHUNK); chunk++) {
        memmove(work->survivors + count, work->survivors + chunk * FILTER_CHUNK,
                work->survivor_counts[chunk] * sizeof *work->survivors);
        count += work->survivor_counts[chunk];
    }
    return count;
}

/* Keeps the events, and copies what is near. */
static void compact_events(pair_event *near_pairs, pair_events *result) {
    size_t kept = 0;
    for (size_t i = 0; i < result->count; i++) {
        pair_event const event = result->events[i];
        result->turning_count += event.time == DROPPED_TURNING;
        if (near_pairs && (event.time >= 0.0 || event.time == DROPPED_NEAR))
            near_pairs[result->near_count++] = event;
        if (event.time >= 0.0) result->events[kept++] = event;
    }
    result->near_pairs = near_pairs;
    result->count = kept;
}

tulle_status scan_pairs(const contact_scene *scene, const pair_list *pairs, const pair_scan *scan,
                        pair_events *result) {
    size_t const pair_count = pairs->vertex_triangle.count + pairs->edge_edge.count;
    scan_work work = {.pairs = pairs, .scan = scan, .stop = scene->stop};
    *result = (pair_events){0};
    if (pair_count >= UINT32_MAX) return TULLE_ERROR_LIMIT;
    work.survivors = ARENA_NEW(scene->scratch, uint32_t, pair_count);
    work.survivor_counts =
        ARENA_NEW(scene->scratch, uint32_t, parallel_chunk_count(pair_count, FILTER_CHUNK));
    if (!work.survivors || !work.survivor_counts) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(pair_count, FILTER_CHUNK, scene->threads, filter_chunk, &work);
    size_t const survivor_count = compact_survivors(&work, pair_count);
    work.events = ARENA_NEW(scene->scratch, pair_event, survivor_count);
    pair_event *const near_pairs =
        scan->notes_near_pairs ? ARENA_NEW(scene->scratch, pair_event, survivor_count) : NULL;
    if (!work.events || (scan->notes_near_pairs && !near_pairs)) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(survivor_count, MEASURE_CHUNK, scene->threads, measure_chunk, &work);
    if (stop_is_wanted(scene->stop)) return TULLE_ERROR_INTERRUPTED;
    result->events = work.events;
    result->measured_count = survivor_count;
    result->count = survivor_count;
    compact_events(near_pairs, result);
    return TULLE_OK;
}
