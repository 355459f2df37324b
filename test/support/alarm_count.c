/* support/alarm_count.c - see alarm_count.h.
 *
 * A detector without patches makes a pass; then the search over its trees is repeated, on one
 * thread, and each candidate judged. The events come from the same kernels as for everybody, the
 * truth from exact_ccd.h, which shares nothing with them; pairs that long double with an
 * error bound shows never coplanar, or apart, need no rationals. */
#include "support/alarm_count.h"

#include "detect/detector/detector_parts.h"
#include "support/exact_ccd.h"
#include "support/patch_judge.h"

#include <math.h>
#include <stdlib.h>

typedef struct judge {
    const raw_event *events; /* sorted by (kind, key) */
    size_t event_count;
    alarm_counts counts;
} judge;

static bool comes_before(const raw_event *event, feature_kind kind, uint64_t key) {
    return event->kind != (uint8_t)kind ? event->kind < (uint8_t)kind : event->key < key;
}

static bool is_reported(const judge *of, feature_kind kind, uint64_t key) {
    size_t begin = 0, end = of->event_count;
    while (begin < end) {
        size_t const middle = begin + (end - begin) / 2;
        if (comes_before(&of->events[middle], kind, key))
            begin = middle + 1;
        else
            end = middle;
    }
    return begin < of->event_count && of->events[begin].key == key &&
           of->events[begin].kind == (uint8_t)kind;
}

static moving_pair load_pair(const pair_tables *tables, const pair_batch *batch, size_t index) {
    uint32_t const first = batch->first[index], second = batch->second[index];
    moving_pair pair;
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t record;
        if (batch->kind == FEATURE_VERTEX_TRIANGLE)
            record = k == 0 ? tables->vertex_corners[first]
                            : tables->triangle_corners[3 * (size_t)second + k - 1];
        else
            record = tables->edge_corners[2 * (size_t)(k < 2 ? first : second) + k % 2];
        pair.start[k] = vec3_load(tables->records[record].start, 0);
        pair.end[k] = vec3_load(tables->records[record].end, 0);
    }
    return pair;
}

/* p[a] - p[b] at the start and the end. */
static void subtract(const moving_pair *pair, int a, int b, long double to[2][3]) {
    for (int end = 0; end < 2; end++) {
        const vec3 *const p = end ? pair->end : pair->start;
        to[end][0] = (long double)p[a].x - p[b].x;
        to[end][1] = (long double)p[a].y - p[b].y;
        to[end][2] = (long double)p[a].z - p[b].z;
    }
}

static long double find_determinant(const long double a[3], const long double b[3],
                                    const long double c[3]) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The four points are never in one plane. The polar form of the determinant of the three edges
 * gives 1, 3, 3, 1 times its Bernstein coefficients; each is a sum of at most 18 products of three
 * edges with some 8 roundings of 2^-64 each. */
static bool is_never_coplanar(const moving_pair *pair) {
    static const long double ERROR = 1e-16L;
    long double edges[3][2][3], most = 0.0L, coefficients[4] = {0};
    for (int i = 0; i < 3; i++) {
        subtract(pair, i + 1, 0, edges[i]);
        for (int k = 0; k < 6; k++) most = fmaxl(most, fabsl(edges[i][k / 3][k % 3]));
    }
    for (int ends = 0; ends < 8; ends++)
        coefficients[(ends & 1) + (ends >> 1 & 1) + (ends >> 2)] +=
            find_determinant(edges[0][ends & 1], edges[1][ends >> 1 & 1], edges[2][ends >> 2]);
    long double const error = ERROR * most * most * most;
    if (!(most > 1e-90L && most < 1e90L)) return false;
    bool are_positive = true, are_negative = true;
    for (int k = 0; k < 4; k++) {
        are_positive = are_positive && coefficients[k] > error;
        are_negative = are_negative && coefficients[k] < -error;
    }
    return are_positive || are_negative;
}

static void judge_batch(void *context, const pair_tables *tables, const pair_batch *batch,
                        int worker) {
    (void)worker;
    judge *const own = context;
    for (size_t i = 0; i < batch->count; i++) {
        moving_pair const pair = load_pair(tables, batch, i);
        feature_pair const features = pair_batch_get(tables, batch, i);
        uint64_t const key = (uint64_t)features.first << 32 | features.second;
        bool const touches = !is_never_coplanar(&pair) &&
                             !is_pair_surely_apart(batch->kind, &pair, 0.0) &&
                             exact_pair_touches(batch->kind, &pair, 1.0);
        bool const reported = is_reported(own, batch->kind, key);
        own->counts.coplanar += !pair_cannot_cross(batch->kind, &pair);
        own->counts.touching += touches;
        own->counts.false_alarms += reported && !touches;
        own->counts.missed += touches && !reported;
    }
}

static tulle_status count_pass(tulle_detector *detector, const double *start, const double *end,
                               alarm_counts *counts, tulle_error *error) {
    tulle_detect_result result;
    tulle_status status = tulle_detector_find_events(detector, start, end, &result, error);
    if (status != TULLE_OK) return status;
    judge own = {.counts = *counts};
    own.events = narrow_phase_get_events(detector->narrow, &own.event_count);
    search_counts searched;
    status = search_pairs(detector->broad, &detector->set, 1, judge_batch, &own, &searched);
    if (status != TULLE_OK) return status;
    own.counts.candidates += searched.candidate_count;
    own.counts.filtered += result.statistics.filtered_pairs;
    own.counts.tested += result.statistics.tested_pairs;
    own.counts.events += result.event_count;
    *counts = own.counts;
    return TULLE_OK;
}

tulle_status alarm_count_add(const tulle_detect_def *def, const double *start, const double *end,
                             alarm_counts *counts, tulle_error *error) {
    tulle_detect_def own = *def;
    own.method = TULLE_DETECT_REFIT;
    tulle_detector *detector = NULL;
    tulle_status status = tulle_detector_create(&own, &detector, error);
    if (status == TULLE_OK) status = count_pass(detector, start, end, counts, error);
    tulle_detector_destroy(detector);
    return status;
}

double alarm_count_share(const alarm_counts *counts) {
    return counts->tested > 0 ? 100.0 * (double)counts->false_alarms / (double)counts->tested : 0.0;
}
