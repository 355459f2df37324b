/* support/patch_judge.h - whether features of one patch touch, or come near, during a step:
 * rational arithmetic for what a plain separating direction does not settle. Shares no code with
 * what it judges but the closest points, which only suggest directions. */
#ifndef TULLE_TEST_PATCH_JUDGE_H
#define TULLE_TEST_PATCH_JUDGE_H

#include "support/exact_ccd.h"
#include "support/open_surfaces.h"

typedef struct patch_pair {
    feature_kind kind;
    feature_pair pair;
    uint32_t vertices[4], label;
} patch_pair;

typedef struct patch_verdict {
    uint64_t pair_count;      /* pairs within patches that share no vertex */
    uint64_t exact_count;     /* of these judged in rational arithmetic */
    uint64_t violation_count; /* touch, or come within 2 reach at a sampled instant */
    patch_pair violation;     /* the first */
    patch_pair nearest;       /* among pairs at least 3 edges apart on the surface; label 0: none */
    double nearest_distance;  /* [m] at the sampled instants; huge without */
    double nearest_time;
} patch_verdict;

/* labels: 0 for triangles outside patches. reach [m] >= 0. */
patch_verdict judge_patches(const open_surface *of, const uint32_t *labels, uint32_t label_count,
                            double reach);

void load_moving_pair(const open_surface *of, const uint32_t vertices[4], moving_pair *pair);

/* Whether separating directions in long double prove that the pair keeps more than `distance` [m].
 * Needs no rationals; false proves nothing. */
bool is_pair_surely_apart(feature_kind kind, const moving_pair *pair, double distance);

#endif
