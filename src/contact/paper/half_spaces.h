/* contact/paper/half_spaces.h - the nearest point of an intersection of half-spaces in space. */
#ifndef TULLE_CONTACT_PAPER_HALF_SPACES_H
#define TULLE_CONTACT_PAPER_HALF_SPACES_H

#include "math/vec3.h"

#include <stdbool.h>

/* {v : normal . v >= offset} */
typedef struct half_space {
    vec3 normal; /* unit */
    double offset;
} half_space;

/* How half-spaces are read. */
typedef struct half_space_rules {
    double low, high; /* an offset counts as the nearest value in this range */
    /* How exact normals are. A vector outside a half-space by up to this part of its size counts
     * as inside. A normal that lies this near to a line or plane is parallel to it. 0: up to
     * rounding, 2e-14 */
    double tolerance;
} half_space_rules;
#define OFFSETS_AS_GIVEN ((half_space_rules){-(double)INFINITY, (double)INFINITY, 0.0})

/* By how much v misses the half-space; negative where v lies inside. */
double measure_missing(const half_space *space, half_space_rules rules, vec3 v);

/* Finds the point of the intersection that is nearest to v, exact up to the tolerance. It is v
 * itself if v misses no half-space. False when the intersection is empty; *nearest is then unset.
 */
bool find_nearest_point(const half_space *spaces, size_t count, half_space_rules rules, vec3 v,
                        vec3 *nearest);

#endif
