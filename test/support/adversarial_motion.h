/* support/adversarial_motion.h - small scenes for detectors whose motions aim at what is hard to
 * decide: ties, exact touches, distances that are the separation to the last bit, tiny numbers. */
#ifndef TULLE_TEST_ADVERSARIAL_MOTION_H
#define TULLE_TEST_ADVERSARIAL_MOTION_H

#include "support/detect_scene.h"

typedef enum adversary {
    ADVERSARY_SLIDING,  /* sheets slide along each other at about the separation */
    ADVERSARY_PARALLEL, /* a sheet comes down on another, edge along edge */
    ADVERSARY_COPLANAR, /* sheets of one plane move into one another in it */
    ADVERSARY_SHARED,   /* sheets folded about edges that both sides share */
    ADVERSARY_GRAZING,  /* triangles pass by with a corner, an edge, a face */
    ADVERSARY_TURNING,  /* a sheet turns over through another */
    ADVERSARY_RESTING,  /* nothing moves; all lies at the separation */
    ADVERSARY_LATTICE,  /* corners go from point to point of a small lattice */
    ADVERSARY_COUNT
} adversary;
extern const char *const adversary_names[ADVERSARY_COUNT];

/* Where and how large the scene is. */
typedef enum adversary_place {
    ADVERSARY_AT_ORIGIN,
    ADVERSARY_FAR,      /* moved by 2^20 m, and rounded */
    ADVERSARY_FARTHER,  /* moved by 2^40 m: all lies on a coarse lattice */
    ADVERSARY_DENORMAL, /* numbers without leading bits */
    ADVERSARY_TINY,     /* squares underflow */
    ADVERSARY_HUGE,     /* squares overflow */
    ADVERSARY_PLACE_COUNT
} adversary_place;
extern const char *const adversary_place_names[ADVERSARY_PLACE_COUNT];

/* How two sheets belong to surfaces. */
typedef enum adversary_sides {
    ADVERSARY_ONE_CLOTH,
    ADVERSARY_TWO_CLOTHS,
    ADVERSARY_STILL_OBSTACLE,
    ADVERSARY_MOVING_OBSTACLE,
    ADVERSARY_SIDES_COUNT
} adversary_sides;

/* Makes a scene of about `triangle_count` triangles; thickness and separation are among what is
 * chosen at random. */
void adversarial_scene_make(detect_scene *scene, adversary family, adversary_place place,
                            adversary_sides sides, unsigned triangle_count, uint64_t *seed);

#endif
