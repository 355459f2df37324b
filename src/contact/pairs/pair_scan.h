/* contact/pairs/pair_scan.h - runs two tests over all candidate pairs, in parallel and with a
 * result that does not depend on the number of threads. */
#ifndef TULLE_CONTACT_PAIRS_PAIR_SCAN_H
#define TULLE_CONTACT_PAIRS_PAIR_SCAN_H

#include "contact/contact_types.h"
#include "detect/impact/pair_batch.h"

/* A pair that passed both tests. */
typedef struct pair_event {
    feature_kind kind;
    feature_pair pair;
    double time;     /* in [0, 1] */
    double distance; /* [m] at the start; only where the test sets it */
} pair_event;

typedef enum scan_verdict {
    SCAN_DROP,
    SCAN_DROP_TURNING, /* dropped, and counted: proven apart by a plane that turns with the pair */
    SCAN_DROP_NEAR,    /* dropped, but noted among the near pairs */
    SCAN_EVENT
} scan_verdict;
/* Full test of `count` pairs of one kind, SCAN_MOST at most. Sets their verdicts, the times of
 * events, and the distances of near pairs. Runs on several threads. */
enum { SCAN_MOST = 64 };
typedef void (*pair_measure)(const void *context, feature_kind kind, pair_event *events,
                             size_t count, scan_verdict *verdicts);

/* The cheap test drops pairs that the direction between their middles keeps further apart than
 * at_start at the start and than at_end along x0 -> x1 (pair_filter.h). */
typedef struct pair_scan {
    const vertex_record *records; /* paths x0 -> x1 of all vertices, see make_records */
    double at_start, at_end;      /* [m] with rounding slack */
    const bool *has_changed;      /* vertex_count; pairs without a marked vertex are dropped; null:
                                     no pair is */
    pair_measure measure;
    const void *context; /* of measure */
    bool notes_near_pairs;
} pair_scan;

/* Whether a vertex of the pair has a mark. marks: vertex_count. */
static inline bool pair_has_mark(const topology *topo, feature_kind kind, feature_pair pair,
                                 const bool *marks) {
    uint32_t v[4];
    feature_pair_vertices(topo, kind, pair, v);
    return marks[v[0]] | marks[v[1]] | marks[v[2]] | marks[v[3]];
}

typedef struct pair_events {
    pair_event *events; /* in scratch; by (kind, first, second) */
    size_t count;
    uint64_t measured_count;      /* pairs that passed the cheap test */
    uint64_t turning_count;       /* of these SCAN_DROP_TURNING */
    const pair_event *near_pairs; /* events and SCAN_DROP_NEAR, in the same order; in scratch; null
                                     where the scan does not ask for them */
    size_t near_count;
} pair_events;

/* The pairs may be in any order. The events stay in the scene's scratch arena until the caller
 * releases its mark. */
tulle_status scan_pairs(const contact_scene *scene, const pair_list *pairs, const pair_scan *scan,
                        pair_events *result);

#endif
