/* support/exact_approach.c - see exact_approach.h.
 *
 * No corner moves faster, relative to a corner of the other feature, than some speed v; so neither
 * does the distance change faster. A pair that is farther than s + v h / 2 apart in the middle of
 * an interval of length h is farther than s all through it. Else the interval is halved. Without a
 * separation exact_pair_touches decides, and its time is found by bisection. */
#include "support/exact_approach.h"

#include "support/exact_ccd.h"

#include <math.h>

/* A bound on the speed of every corner relative to those of the other feature, rounded upward. */
static double bound_speed(feature_kind kind, const moving_pair *pair) {
    int const first_count = kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    double most = 0.0;
    for (int a = 0; a < first_count; a++)
        for (int b = first_count; b < 4; b++) {
            vec3 const start = vec3_sub(pair->start[a], pair->start[b]);
            vec3 const end = vec3_sub(pair->end[a], pair->end[b]);
            vec3 const way = vec3_sub(end, start);
            double const size = fabs(start.x) + fabs(start.y) + fabs(start.z) + fabs(end.x) +
                                fabs(end.y) + fabs(end.z); /* of what was rounded */
            most = fmax(most, hypot(hypot(way.x, way.y), way.z) + 0x1p-50 * size);
        }
    return nextafter(most * (1.0 + 0x1p-40), INFINITY);
}

typedef struct approach_search {
    feature_kind kind;
    const moving_pair *pair;
    double separation, speed;
} approach_search;

static bool is_farther(const approach_search *own, double t, double by) {
    double const distance = own->separation + by;
    return exact_pair_is_farther(own->kind, own->pair, t,
                                 by > 0.0 ? nextafter(distance, INFINITY) : distance);
}

/* Within [begin, end]; the pair is farther than the separation at the beginning. */
static approach search(const approach_search *own, double begin, double end, int depth) {
    double const middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
    if (is_farther(own, middle, nextafter(own->speed * half, INFINITY)))
        return (approach){APPROACH_APART, end, end};
    if (depth == 0)
        return is_farther(own, end, 0.0) ? (approach){APPROACH_OPEN, begin, end}
                                         : (approach){APPROACH_NEAR, begin, end};
    approach const first = search(own, begin, middle, depth - 1);
    if (first.verdict == APPROACH_NEAR) return first;
    if (!is_farther(own, middle, 0.0)) /* where only the middle is near */
        return (approach){APPROACH_NEAR, fmin(first.from, middle), middle};
    approach second = search(own, middle, end, depth - 1);
    if (first.verdict == APPROACH_APART) return second;
    second.from = first.from;
    if (second.verdict == APPROACH_APART) second.verdict = APPROACH_OPEN;
    return second;
}

/* A time by which the pair has touched, within 2^-depth; it touches by 1. */
static double find_touch(feature_kind kind, const moving_pair *pair, int depth) {
    double from = 0.0, by = 1.0;
    for (int i = 0; i < depth; i++) {
        double const middle = 0.5 * (from + by);
        *(exact_pair_touches(kind, pair, middle) ? &by : &from) = middle;
    }
    return by;
}

approach find_approach(feature_kind kind, const moving_pair *pair, double separation, int depth) {
    approach_search const own = {kind, pair, separation, bound_speed(kind, pair)};
    if (!is_farther(&own, 0.0, 0.0)) return (approach){APPROACH_NEAR, 0.0, 0.0};
    approach found = {APPROACH_OPEN, 0.0, 1.0};
    if (separation > 0.0) found = search(&own, 0.0, 1.0, depth);
    if (found.verdict != APPROACH_OPEN) return found;
    if (exact_pair_touches(kind, pair, 1.0)) {
        found.verdict = APPROACH_NEAR;
        found.by = find_touch(kind, pair, depth);
        if (separation == 0.0) found.from = fmax(found.by - ldexp(1.0, -depth), 0.0);
    } else if (separation == 0.0) {
        found = (approach){APPROACH_APART, 1.0, 1.0};
    }
    return found;
}
