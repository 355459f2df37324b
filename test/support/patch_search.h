/* support/patch_search.h - a search for motions in which a patch touches itself although a rule
 * says that it cannot: random open surfaces, their vertices moved by simulated annealing towards
 * self-contact while the rule goes on accepting, or towards acceptance while they go on colliding.
 * The same seed gives the same search. */
#ifndef TULLE_TEST_PATCH_SEARCH_H
#define TULLE_TEST_PATCH_SEARCH_H

#include "support/patch_judge.h"

/* Who says which triangles form patches that cannot touch themselves. */
typedef enum patch_rule {
    /* wrong; by these the search is tested */
    RULE_CONE,          /* whatever one cone holds */
    RULE_WITHOUT_REACH, /* discs as below, proven without the reach by which they are judged */
    RULE_ENDS_ONLY,     /* discs whose contour is proven for both ends, not in between */
    /* right */
    RULE_CONTOURS,  /* discs grown here at random about random axes, certificate.h */
    RULE_KEPT,      /* kept_patches.h, patches kept through the search */
    RULE_KEPT_ANEW, /* the same, grown for every motion */
    RULE_HELD       /* the same, grown for a motion and used as long as patches_hold */
} patch_rule;

typedef enum search_drive {
    DRIVE_TO_CONTACT,   /* nearer, while accepted */
    DRIVE_TO_ACCEPTANCE /* facing one way with a simple contour, while one pair goes on touching */
} search_drive;

typedef struct search_plan {
    surface_family family;
    patch_rule rule;
    search_drive drive;
    uint64_t seed;
    int steps;
    surface_wishes wishes;
} search_plan;

typedef struct search_outcome {
    bool is_found;
    int step;               /* where it was found, or the last */
    uint64_t motion_count;  /* judged */
    uint64_t pair_count;    /* within patches, over all motions */
    uint64_t exact_count;   /* of these judged in rational arithmetic */
    uint64_t patched_count; /* triangles in patches, over all motions */
    uint64_t triangle_count;
    double nearest;  /* [mean edges] in an accepted motion, 3 edges apart on the surface */
    patch_pair pair; /* the violation */
    double reach;    /* [m] */
} search_outcome;

/* One restart. The surface stays as the search left it, at the violation if one was found; its
 * topology is the caller's to destroy. */
search_outcome search_patches(memory *heap, const search_plan *plan, open_surface *of);

#endif
