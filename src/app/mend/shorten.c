/* app/mend/shorten.c - see shorten.h. As docs/method/commit_safely.md does with components. */
#include "app/mend/shorten.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Part of the way to the first hit that is gone. */
static const double SAFE_PART = 0.9;
/* From this round on what is hit stands; components grow until no more are hit. */
enum { STOP_ROUND = 6, ROUNDS_MAX = 40 };

/* Components of vertices that hits join. */
typedef struct components {
    uint32_t *parents; /* by vertex; a root is its own */
    double *parts;     /* by vertex, of its way; those of roots count */
} components;

static uint32_t find_root(const components *joined, uint32_t vertex) {
    while (joined->parents[vertex] != vertex) {
        joined->parents[vertex] = joined->parents[joined->parents[vertex]];
        vertex = joined->parents[vertex];
    }
    return vertex;
}

/* The smaller number becomes the root; it goes as far as the one that went less far. */
static uint32_t join(components *joined, uint32_t a, uint32_t b) {
    uint32_t const first = find_root(joined, a), second = find_root(joined, b);
    uint32_t const root = first < second ? first : second, other = first < second ? second : first;
    joined->parts[root] = fmin(joined->parts[root], joined->parts[other]);
    joined->parents[other] = root;
    return root;
}

/* Joins what an event is about; TULLE_NONE where it is about bodies alone. */
static uint32_t join_event(const mend_way *way, const tulle_detect_event *event,
                           components *joined) {
    uint32_t root = TULLE_NONE;
    for (size_t k = 0; k < 4; k++)
        if (event->vertices[k] < way->cloth_count)
            root = root == TULLE_NONE ? find_root(joined, event->vertices[k])
                                      : join(joined, root, event->vertices[k]);
    return root;
}

/* `times`: by vertex, 1 between calls. */
static void shorten_hit(const mend_way *way, const tulle_detect_result *result, int round,
                        components *joined, double *times) {
    for (size_t i = 0; i < result->event_count; i++)
        (void)join_event(way, &result->events[i], joined);
    for (size_t i = 0; i < result->event_count; i++) {
        uint32_t const root = join_event(way, &result->events[i], joined);
        if (root != TULLE_NONE) times[root] = fmin(times[root], result->events[i].time);
    }
    for (size_t i = 0; i < result->event_count; i++) {
        uint32_t const root = join_event(way, &result->events[i], joined);
        if (root == TULLE_NONE || times[root] == 1.0) continue;
        joined->parts[root] *= round < STOP_ROUND ? SAFE_PART * times[root] : 0.0;
        times[root] = 1.0;
    }
}

static void place(const mend_way *way, const components *joined, const double *whole) {
    for (uint32_t v = 0; v < way->cloth_count; v++) {
        double const part = joined->parts[find_root(joined, v)];
        for (size_t i = 3 * (size_t)v; i < 3 * (size_t)v + 3 && part < 1.0; i++) {
            double const end = way->begin[i] + part * (whole[i] - way->begin[i]);
            way->end[i] = way->is_float ? (double)(float)end : end;
        }
    }
}

tulle_status mend_shorten(const mend_way *way, bool *is_clean, tulle_error *error) {
    size_t const count = way->cloth_count;
    components joined = {calloc(count, sizeof(uint32_t)), calloc(count, sizeof(double))};
    double *const times = calloc(count, sizeof *times);
    double *const whole = calloc(count, 3 * sizeof *whole);
    tulle_status status = TULLE_OK;
    *is_clean = false;
    if (!joined.parents || !joined.parts || !times || !whole)
        status =
            error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices", count);
    if (status == TULLE_OK) memcpy(whole, way->end, 3 * count * sizeof *whole);
    for (uint32_t v = 0; v < count && status == TULLE_OK; v++) {
        joined.parents[v] = v;
        joined.parts[v] = times[v] = 1.0;
    }
    for (int round = 0; round < ROUNDS_MAX && status == TULLE_OK && !*is_clean; round++) {
        tulle_detect_result result;
        status = tulle_detector_find_events(way->detector, way->begin, way->end, &result, error);
        if (status != TULLE_OK) break;
        *is_clean = result.event_count == 0;
        if (*is_clean) break;
        shorten_hit(way, &result, round, &joined, times);
        place(way, &joined, whole);
    }
    free(joined.parents);
    free(joined.parts);
    free(times);
    free(whole);
    return status;
}
