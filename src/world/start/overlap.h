/* world/start/overlap.h - how deep two triangles lie in each other, and where. */
#ifndef TULLE_WORLD_START_OVERLAP_H
#define TULLE_WORLD_START_OVERLAP_H

#include "math/vec3.h"

typedef struct triangle_overlap {
    double depth; /* [m] length of the shortest move of one triangle that parts it from the other */
    vec3 position; /* [m] middle of the points at which an edge of one passes through the other; the
                      middle of both where no edge does, as in a common plane */
} triangle_overlap;

/* Of triangles that intersect or touch; a depth of 0 where they lie in one plane or only touch. */
triangle_overlap measure_overlap(const vec3 a[3], const vec3 b[3]);

#endif
