/* contact/commit/commit_safely.h - stage 9: an end of the step that is proven free of
 * intersection. */
#ifndef TULLE_CONTACT_COMMIT_COMMIT_SAFELY_H
#define TULLE_CONTACT_COMMIT_COMMIT_SAFELY_H

#include "contact/pairs/contact_paths.h"

typedef enum commit_outcome {
    COMMIT_CLEAN,     /* x1 is safe at the end of the full time step */
    COMMIT_SHORTENED, /* x1 is safe at `fraction` of the time step, obstacles included */
    COMMIT_BLOCKED    /* no fraction over MINIMUM_FRACTION is safe: x1 equals x0; `blocking` names
                         the first pair */
} commit_outcome;

typedef struct commit_report {
    commit_outcome outcome;
    double fraction;        /* of the time step that passed: 1, less, or 0 when blocked */
    uint64_t tested_pairs;  /* pairs that the cheapest test did not prove apart */
    uint64_t turning_pairs; /* of these: proven apart by a turning plane */
    uint64_t impact_zones, component_scalings, global_scalings;
    double smallest_gap; /* [m] over all candidates at x1, INFINITY if none is nearer than the
                            largest separation distance */
    feature_kind smallest_kind;
    feature_pair smallest_pair;
    bool has_blocking; /* a pair stopped the whole scene (outcome not COMMIT_CLEAN) */
    feature_kind blocking_kind;
    feature_pair blocking_pair;
} commit_report;

/* In: u and x1 of stage 8; is_clean, its verdict on exactly these x1. Out: x1 that is safe, and u:
 * for vertices that were held back it is their displacement over the time that passed.
 * When time was shortened, vertices with inverse mass 0 are at x0 + fraction (target - x0). The
 * caller sets its obstacles there and continues with the rest of the step. If the outcome is
 * COMMIT_CLEAN or COMMIT_SHORTENED, the last test covered every candidate along x0 -> x1, with
 * exactly the doubles that are returned. */
tulle_status commit_safely(const contact_scene *scene, pair_source *source, bool is_clean,
                           double *u, double *x1, commit_report *report);

#endif
