/* support/tangled.h - seeded starts that intersect: crumpled and folded cloth, cloth through
 * obstacles, cloths through one another. Each has TANGLED_PAIRS_MIN .. TANGLED_PAIRS_MAX pairs of
 * triangles that intersect, by the exact judge. */
#ifndef TULLE_TEST_TANGLED_H
#define TULLE_TEST_TANGLED_H

#include "tulle/tulle.h"

enum { TANGLED_PAIRS_MIN = 10, TANGLED_PAIRS_MAX = 1000, TANGLED_BODIES_MAX = 2 };

typedef enum tangled_family {
    TANGLED_CRUMPLE,     /* random smooth displacement through itself */
    TANGLED_LOOP,        /* rolled up through itself */
    TANGLED_SPHERE_RIM,  /* a border or corner thrust into a sphere */
    TANGLED_BOX_RIM,     /* into a box of a few large triangles */
    TANGLED_LUMP_RIM,    /* into a shape that is not convex */
    TANGLED_INTERLEAVED, /* two wavy cloths that change places */
    TANGLED_CORNERS,     /* corners of a cloth poked through another */
    TANGLED_THRUST,      /* a wrinkled cloth thrust through another */
    TANGLED_SUNK,        /* a crumpled cloth sunk into a lump from above */
    TANGLED_SLAB,        /* a border through a thin plate */
    TANGLED_FAMILY_COUNT
} tangled_family;

typedef struct tangled_start {
    tangled_family family;
    tulle_mesh cloths[TANGLED_BODIES_MAX]; /* as they start */
    double *rest[TANGLED_BODIES_MAX];      /* [m] flat */
    size_t cloth_count;
    tulle_mesh obstacle; /* no vertices: none */
    size_t pair_count;   /* that intersect */
} tangled_start;

/* vertices_per_side: 9 or more, of each cloth. Fails the test when a shape cannot be made. */
tangled_start tangled_make(tangled_family family, uint64_t seed, unsigned vertices_per_side);
void tangled_destroy(tangled_start *start);
const char *tangled_family_name(tangled_family family);

/* A world of the start, with def's start_intersections and so on, not started. */
tulle_world *tangled_make_world(const tangled_start *start, const tulle_world_def *def);
/* Pairs that intersect in the world now. */
size_t tangled_judge(const tangled_start *start, const tulle_world *world);

#endif
