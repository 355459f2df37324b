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
#define DROPPED (-1.0)
#define DROPPED_TURNING (-2.0)
#define DROPPED_NEAR (-3.0)

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

/* Copies the pairs of which a vertex has changed; returns how many. */
static size_t pick_changed(const scan_work *work, const feature_pair *pairs, size_t count,
                           feature_pair *picked) {
    const bool *const changed = work->scan->has_changed;
    size_t picked_count = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t v[4];
        feature_pair_vertices(work->filter.topo, work->kind, pairs[i], v);
        picked[picked_count] = pairs[i];
        picked_count += changed[v[0]] | changed[v[1]] | changed[v[2]] | changed[v[3]];
    }
    return picked_count;
}

static void filter_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    scan_work *const work = context;
    feature_pair *const kept = work->kept + chunk * FILTER_CHUNK;
    size_t kept_count = 0;
    work->kept_counts[chunk] = 0;
    if (stop_is_wanted_by(work->stop, worker)) return;
    for (size_t i = begin; i < end; i += FILTER_PART) {
        const feature_pair *part = work->pairs + i;
        size_t count = end - i < FILTER_PART ? end - i : FILTER_PART;
        feature_pair picked[FILTER_PART];
        if (work->scan->has_changed) {
            count = pick_changed(work, part, count, picked);
            part = picked;
        }
        kept_count += TULLE_PICK_KERNEL(filter_pairs)(&work->filter, work->kind, part, count,
                                                      kept + kept_count);
    }
    work->kept_counts[chunk] = (uint32_t)kept_count;
}

/* Survivors begin .. end - 1 of one kind, whose events are from `event` on. */
static void measure_kind(const scan_work *work, feature_kind kind, size_t begin, size_t end,
                         pair_event *event) {
    scan_verdict verdicts[SCAN_MOST];
    size_t const count = end - begin;
    for (size_t i = 0; i < count; i++) {
        event[i].kind = kind;
        event[i].pair = work->survivors[kind][begin + i];
    }
    work->scan->measure(work->scan->context, kind, event, count, verdicts);
    for (size_t i = 0; i < count; i++) {
        if (verdicts[i] == SCAN_DROP) event[i].time = DROPPED;
        if (verdicts[i] == SCAN_DROP_TURNING) event[i].time = DROPPED_TURNING;
        if (verdicts[i] == SCAN_DROP_NEAR) event[i].time = DROPPED_NEAR;
    }
}

/* Vertices and triangles come first. */
static void measure_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    scan_work *const work = context;
    if (stop_is_wanted_by(work->stop, worker)) return;
    size_t const first_edge = work->survivor_counts[FEATURE_VERTEX_TRIANGLE];
    size_t const middle = end < first_edge ? end : begin > first_edge ? begin : first_edge;
    if (begin < middle)
        measure_kind(work, FEATURE_VERTEX_TRIANGLE, begin, middle, work->events + begin);
    if (middle < end)
        measure_kind(work, FEATURE_EDGE_EDGE, middle - first_edge, end - first_edge,
                     work->events + middle);
}

/* Moves together what the chunks kept; returns how many. */
static size_t join_chunks(const scan_work *work, size_t chunk_count) {
    size_t count = 0;
    for (size_t chunk = 0; chunk < chunk_count; chunk++) {
        memmove(work->kept + count, work->kept + chunk * FILTER_CHUNK,
                work->kept_counts[chunk] * sizeof *work->kept);
        count += work->kept_counts[chunk];
    }
    return count;
}

/* Survivors of one kind, sorted. */
static tulle_status filter_kind(const contact_scene *scene, scan_work *work, feature_kind kind,
                                size_t pair_count) {
    size_t const chunk_count = parallel_chunk_count(pair_count, FILTER_CHUNK);
    work->kind = kind;
    work->kept = ARENA_NEW(scene->scratch, feature_pair, chunk_count * FILTER_CHUNK);
    work->kept_counts = ARENA_NEW(scene->scratch, uint32_t, chunk_count);
    if (!work->kept || !work->kept_counts) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(pair_count, FILTER_CHUNK, scene->threads, filter_chunk, work);
    size_t const count = join_chunks(work, chunk_count);
    work->survivors[kind] = work->kept;
    work->survivor_counts[kind] = count;
    return sort_pairs(scene->scratch, scene->threads, work->kept, count,
                      kind == FEATURE_VERTEX_TRIANGLE ? scene->vertex_count
                                                      : scene->set->topo->edge_count);
}

static tulle_status filter_all(const contact_scene *scene, const pair_list *pairs,
                               scan_work *work) {
    const pair_scan *const scan = work->scan;
    work->filter = (pair_filter){scene->set->topo, scan->records, scan->at_start, scan->at_end};
    tulle_status status = TULLE_OK;
    for (int kind = 0; kind < 2 && status == TULLE_OK; kind++) {
        bool const is_edge_edge = kind == FEATURE_EDGE_EDGE;
        work->pairs = is_edge_edge ? pairs->edge_edge.data : pairs->vertex_triangle.data;
        status = filter_kind(scene, work, (feature_kind)kind,
                             is_edge_edge ? pairs->edge_edge.count : pairs->vertex_triangle.count);
    }
    return status;
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
    scan_work work = {.scan = scan, .stop = scene->stop};
    *result = (pair_events){0};
    if (pair_count >= UINT32_MAX) return TULLE_ERROR_LIMIT;
    tulle_status const status = filter_all(scene, pairs, &work);
    if (status != TULLE_OK) return status;
    size_t const survivor_count = work.survivor_counts[0] + work.survivor_counts[1];
    work.events = ARENA_NEW(scene->scratch, pair_event, survivor_count);
    pair_event *const near_pairs =
        scan->notes_near_pairs ? ARENA_NEW(scene->scratch, pair_event, survivor_count) : NULL;
    if (!work.events || (scan->notes_near_pairs && !near_pairs)) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(survivor_count, SCAN_MOST, scene->threads, measure_chunk, &work);
    if (stop_is_wanted(scene->stop)) return TULLE_ERROR_INTERRUPTED;
    result->events = work.events;
    result->measured_count = survivor_count;
    result->count = survivor_count;
    compact_events(near_pairs, result);
    return TULLE_OK;
}
