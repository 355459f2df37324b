/* support/open_surfaces.h - small surfaces with boundaries, chosen so that normals alone do not
 * keep them from touching themselves: both ends of the motion are made so that parts that lie over
 * one another change places. */
#ifndef TULLE_TEST_OPEN_SURFACES_H
#define TULLE_TEST_OPEN_SURFACES_H

#include "detect/surface_set.h"

enum { OPEN_TRIANGLES = 512, OPEN_VERTICES = 512 };

typedef enum surface_family {
    FAMILY_RAMP,    /* a spiral ramp of more than a turn that is turned upside down */
    FAMILY_C_RING,  /* a ring with a gap that closes */
    FAMILY_TWIST,   /* a closed band that coils three times while it twists by a full turn */
    FAMILY_ANNULUS, /* a closed band that coils twice */
    FAMILY_SLIT,    /* a disc whose slit's sides lie over one another */
    FAMILY_FOLD,    /* a steeply waved, meandering strip whose legs meet */
    FAMILY_COMB,    /* teeth that lean over their neighbours */
    FAMILY_TERRAIN, /* a ragged piece of random terrain, its parts drifting */
    FAMILY_FAN,     /* triangles that wind nearly or more than once around a vertex */
    FAMILY_COUNT
} surface_family;

extern const char *const family_names[FAMILY_COUNT];

typedef struct open_surface {
    uint32_t triangles[3 * OPEN_TRIANGLES];
    double x0[3 * OPEN_VERTICES], x1[3 * OPEN_VERTICES]; /* [m] */
    size_t triangle_count, vertex_count;
    double edge; /* [m] mean length */
    topology topo;
    surface_range range;
    surface_set set; /* the one surface; points into this object */
    /* edges on the way from one vertex to another, 255 at most; rows of vertex_count */
    unsigned char hops[OPEN_VERTICES * OPEN_VERTICES];
} open_surface;

typedef struct surface_wishes {
    bool is_plain; /* no faults of the mesh, no far places, no lattice: the family as it is */
} surface_wishes;

/* A random member of a family; the topology is the caller's to destroy. */
void make_open_surface(memory *heap, surface_family family, surface_wishes wishes, uint64_t *seed,
                       open_surface *to);

#endif
