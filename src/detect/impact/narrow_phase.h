/* detect/impact/narrow_phase.h - tests of candidates in batches: takes candidate pairs as they
 * come, gives events.
 *
 * A pair goes through axes and diagonals in floats (where there are points), the coplanarity filter
 * (separation 0), the fixed-direction filters (axes, the closest direction at the start, that at
 * the end), and conservative advancement, several pairs at a time, one a lane. Every step is a
 * proof with outward rounding; lanes do not touch one another, so the result of a pair depends
 * neither on the batch it came in nor on the vector width. The states and bounds are those of
 * time_of_impact.h. */
#ifndef TULLE_DETECT_IMPACT_NARROW_PHASE_H
#define TULLE_DETECT_IMPACT_NARROW_PHASE_H

#include "detect/impact/pair_batch.h"
#include "detect/impact/time_of_impact.h"

/* What a worker keeps of a pair that is not separated. */
typedef struct raw_event {
    uint64_t key;  /* first << 32 | second */
    double time;   /* safe lower bound */
    uint8_t kind;  /* feature_kind */
    uint8_t state; /* toi_state */
} raw_event;

typedef struct narrow_phase_input {
    const surface_set *set;
    const double *separations;      /* [m] surface_count^2, row-major, symmetric; >= 0 */
    const uint32_t *vertex_surface; /* surface of each vertex record; null: all are of surface 0 */
    bool only_earliest;             /* only the events of the smallest time; the counts may then
                                       depend on the threads */
    int threads;                    /* workers are 0 .. threads - 1 */
} narrow_phase_input;

typedef struct narrow_phase_counts {
    uint64_t candidate_count;              /* pairs given */
    uint64_t pooled_count;                 /* of these not shown apart by the coplanarity filter, an
                                              axis, a diagonal or the direction at the start */
    uint64_t filtered_count;               /* pairs given that were shown apart by any filter */
    uint64_t tested_count;                 /* the others: not shown apart by the direction at the
                                              end either; through conservative advancement */
    double filter_seconds, impact_seconds; /* summed over workers */
} narrow_phase_counts;

typedef struct narrow_phase narrow_phase;

tulle_status narrow_phase_create(memory *heap, narrow_phase **result);
void narrow_phase_destroy(narrow_phase *narrow);

/* One pass: start, then consume_pairs (a pair_consumer) by any worker, then, in a parallel loop
 * over workers, flush, then finish. finish is true when the events are complete; else room was made
 * (or *status says that memory is short) and the pass must be repeated from start. */
tulle_status narrow_phase_start(narrow_phase *narrow, const narrow_phase_input *input);
void consume_pairs(void *narrow, const pair_tables *tables, const pair_batch *batch, int worker);
void narrow_phase_flush(narrow_phase *narrow, const pair_tables *tables, int worker);
bool narrow_phase_finish(narrow_phase *narrow, tulle_status *status);

/* Sorted by (kind, key); valid until the next start. */
const raw_event *narrow_phase_get_events(const narrow_phase *narrow, size_t *count);
narrow_phase_counts narrow_phase_get_counts(const narrow_phase *narrow);

#endif
