/* contact/commit/resolve_impacts.h - stage 8: impacts of the proposed paths become rows. */
#ifndef TULLE_CONTACT_COMMIT_RESOLVE_IMPACTS_H
#define TULLE_CONTACT_COMMIT_RESOLVE_IMPACTS_H

#include "contact/pairs/contact_paths.h"

typedef struct impact_report {
    uint32_t rounds;        /* rounds that found something */
    uint64_t tested_pairs;  /* pairs that the cheapest test did not prove apart */
    uint64_t turning_pairs; /* of these: proven apart by a turning plane */
    uint64_t impact_count;  /* rows added */
    bool is_clean;          /* the last test of x0 -> x1 found nothing */
} impact_report;

/* Tests all candidates along x0 -> x1 with the minimum gaps of the pairs, adds a row for each hit,
 * and lets the response answer; all of this at most settings.impact_rounds times. In: u of stage 7
 * and its paths x1. Out: both after the impacts; x1 is always propose_paths of u. */
tulle_status resolve_impacts(const contact_scene *scene, pair_source *source, row_list *list,
                             double *u, double *x1, impact_report *report);

/* Adds a row for each hit along the paths x0 -> x1 of a rough solve. Only pairs are tested that the
 * first search of the substep found, along x0 -> predicted. Nothing answers to these rows before
 * the next solve. Does not say whether x0 -> x1 is clean. */
tulle_status foresee_impacts(const contact_scene *scene, pair_source *source, row_list *list,
                             const double *predicted, const double *x1, impact_report *report);

#endif
