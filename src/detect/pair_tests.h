/* detect/pair_tests.h - stage 8: which candidate pairs come near during the step, and when. */
#ifndef TULLE_DETECT_PAIR_TESTS_H
#define TULLE_DETECT_PAIR_TESTS_H

#include "base/arena.h"
#include "detect/surface_set.h"
#include "detect/time_of_impact.h"

/* A pair that is not separated over the whole step: hit, touching at the start or unresolved. */
typedef struct impact_event {
    feature_kind kind;
    feature_pair pair;
    toi_result result;
} impact_event;

/* Vertex/triangle events first, each kind in the order of the pair list. */
typedef struct event_list {
    ARRAY(impact_event) events;
} event_list;

/* The minimum separation [m] >= 0 of one pair; start: its four points at t = 0. Called from several
 * threads at once. */
typedef double (*pair_separation_function)(void *context, feature_kind kind, feature_pair pair,
                                           const vec3 start[4]);

typedef struct pair_test_input {
    const topology *topo;
    const double *x0, *x1; /* [m] 3 * vertex_count: paths x0 + t (x1 - x0) */
    const pair_list *pairs;
    double separation; /* [m] >= 0 of every pair, where the function is null */
    pair_separation_function pair_separation; /* may be null */
    void *separation_context;
    int threads;
} pair_test_input;

typedef struct pair_test_counts {
    uint64_t candidate_count; /* pairs given */
    uint64_t filtered_count;  /* of these shown apart by the cheap filters */
    uint64_t tested_count;    /* given to time_of_impact */
    uint64_t hit_count, touching_count, unresolved_count;
    double lower_bound; /* in [0, 1]: every pair keeps its separation for all t below; 1 without
                           events */
} pair_test_counts;

/* Replaces the contents of `events`, which grows on `heap`; scratch is given back. Every pair that
 * is not proven separated is in `events`. Out of memory leaves `events` empty and returns the
 * error. counts may be null. */
tulle_status test_pairs(const pair_test_input *input, memory *heap, arena *scratch,
                        event_list *events, pair_test_counts *counts);

#endif
