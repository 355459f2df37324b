/* detect/pair_tests.c - stage 8, see pair_tests.h.
 *
 * Takes candidate pairs and paths. First all pairs go through the cheap filters, in fixed chunks;
 * each chunk notes its survivors in its own part of one array. Then the survivors, moved together,
 * go through time_of_impact, and what is not separated becomes an event, in the order of the list.
 * So neither the events nor their order depend on the number of threads. */
#include "detect/pair_tests.h"

#include "base/parallel.h"

#include <string.h>

enum {
    FILTER_CHUNK = 1024, /* pairs; some 50 microseconds of work */
    IMPACT_CHUNK = 64    /* pairs; some 50 microseconds of work */
};

typedef struct pair_test {
    const pair_test_input *input;
    uint32_t *survivors;       /* one slot a candidate: its index, see candidate_at */
    uint32_t *survivor_counts; /* one a filter chunk */
    toi_result *results;       /* one a survivor */
} pair_test;

/* Candidates are numbered through: vertex/triangle pairs, then edge/edge pairs. */
static feature_pair candidate_at(const pair_list *pairs, size_t index, feature_kind *kind) {
    size_t const vertex_triangle_count = pairs->vertex_triangle.count;
    bool const is_vertex_triangle = index < vertex_triangle_count;
    *kind = is_vertex_triangle ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
    return is_vertex_triangle ? pairs->vertex_triangle.data[index]
                              : pairs->edge_edge.data[index - vertex_triangle_count];
}

static moving_pair load_paths(const pair_test_input *input, feature_kind kind, feature_pair pair) {
    uint32_t vertices[4];
    feature_pair_vertices(input->topo, kind, pair, vertices);
    moving_pair paths;
    for (int k = 0; k < 4; k++) {
        paths.start[k] = vec3_load(input->x0, vertices[k]);
        paths.end[k] = vec3_load(input->x1, vertices[k]);
    }
    return paths;
}

static double find_separation(const pair_test_input *input, feature_kind kind, feature_pair pair,
                              const moving_pair *paths) {
    return input->pair_separation
               ? input->pair_separation(input->separation_context, kind, pair, paths->start)
               : input->separation;
}

static void filter_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    pair_test *const test = context;
    uint32_t count = 0;
    for (size_t i = begin; i < end; i++) {
        feature_kind kind;
        feature_pair const pair = candidate_at(test->input->pairs, i, &kind);
        moving_pair const paths = load_paths(test->input, kind, pair);
        double const separation = find_separation(test->input, kind, pair, &paths);
        if (separation == 0.0 && pair_cannot_cross(kind, &paths)) continue;
        if (pair_stays_apart(kind, &paths, separation)) continue;
        test->survivors[begin + count++] = (uint32_t)i;
    }
    test->survivor_counts[chunk] = count;
}

static void impact_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    pair_test *const test = context;
    for (size_t i = begin; i < end; i++) {
        feature_kind kind;
        feature_pair const pair = candidate_at(test->input->pairs, test->survivors[i], &kind);
        moving_pair const paths = load_paths(test->input, kind, pair);
        test->results[i] =
            time_of_impact(kind, &paths, find_separation(test->input, kind, pair, &paths));
    }
}

/* Moves the survivors of all chunks together, in order; returns how many there are. */
static size_t compact_survivors(pair_test *test, size_t candidate_count) {
    size_t count = 0;
    size_t const chunk_count = parallel_chunk_count(candidate_count, FILTER_CHUNK);
    for (size_t chunk = 0; chunk < chunk_count; chunk++) {
        memmove(test->survivors + count, test->survivors + chunk * FILTER_CHUNK,
                test->survivor_counts[chunk] * sizeof *test->survivors);
        count += test->survivor_counts[chunk];
    }
    return count;
}

static void count_state(pair_test_counts *counts, const toi_result *result) {
    counts->hit_count += result->state == TOI_HIT;
    counts->touching_count += result->state == TOI_TOUCHING_AT_START;
    counts->unresolved_count += result->state == TOI_UNRESOLVED;
    if (result->state != TOI_SEPARATED && result->lower_bound < counts->lower_bound)
        counts->lower_bound = result->lower_bound;
}

static bool gather_events(const pair_test *test, size_t survivor_count, memory *heap,
                          event_list *list, pair_test_counts *counts) {
    for (size_t i = 0; i < survivor_count; i++) count_state(counts, &test->results[i]);
    size_t const event_count =
        (size_t)(counts->hit_count + counts->touching_count + counts->unresolved_count);
    if (!ARRAY_RESERVE(heap, &list->events, event_count)) return false;
    for (size_t i = 0; i < survivor_count; i++) {
        if (test->results[i].state == TOI_SEPARATED) continue;
        impact_event *const event = &list->events.data[list->events.count++];
        event->pair = candidate_at(test->input->pairs, test->survivors[i], &event->kind);
        event->result = test->results[i];
    }
    return true;
}

static bool run_tests(pair_test *test, memory *heap, arena *scratch, event_list *events,
                      pair_test_counts *counts) {
    size_t const candidate_count = (size_t)counts->candidate_count;
    size_t const chunk_count = parallel_chunk_count(candidate_count, FILTER_CHUNK);
    test->survivors = ARENA_NEW(scratch, uint32_t, candidate_count);
    test->survivor_counts = ARENA_NEW(scratch, uint32_t, chunk_count);
    if (!test->survivors || !test->survivor_counts) return false;
    parallel_for(candidate_count, FILTER_CHUNK, test->input->threads, filter_chunk, test);
    size_t const survivor_count = compact_survivors(test, candidate_count);
    counts->tested_count = survivor_count;
    counts->filtered_count = candidate_count - survivor_count;
    test->results = ARENA_NEW(scratch, toi_result, survivor_count);
    if (!test->results) return false;
    parallel_for(survivor_count, IMPACT_CHUNK, test->input->threads, impact_chunk, test);
    return gather_events(test, survivor_count, heap, events, counts);
}

tulle_status test_pairs(const pair_test_input *input, memory *heap, arena *scratch,
                        event_list *events, pair_test_counts *counts) {
    size_t const candidate_count =
        input->pairs->vertex_triangle.count + input->pairs->edge_edge.count;
    pair_test_counts found = {.candidate_count = candidate_count, .lower_bound = 1.0};
    pair_test test = {.input = input};
    events->events.count = 0;
    if (candidate_count >= UINT32_MAX) return TULLE_ERROR_LIMIT;
    arena_mark const mark = arena_get_mark(scratch);
    bool const is_done = run_tests(&test, heap, scratch, events, &found);
    arena_release(scratch, mark);
    if (counts) *counts = found;
    return is_done ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
