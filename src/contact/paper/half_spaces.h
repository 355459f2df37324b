/* contact/paper/half_spaces.h - the nearest point of an intersection of half-spaces in three
 * dimensions.
 */
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
    double low, high; /* offsets count as the nearest value in this range */
    double tolerance; /* what normals are good for: a vector misses a half-space only by more than
                         this part of it, and normals that lie this near to one line or plane are
                         parallel to it; 0: rounding, 2e-14 */
} half_space_rules;
#define OFFSETS_AS_GIVEN ((half_space_rules){-(double)INFINITY, (double)INFINITY, 0.0})

/* Largest amount by which v misses a half-space; 0 when it misses none. */
double measure_violation(const half_space *spaces, size_t count, vec3 v);

/* The point of the intersection that is nearest to v, exact up to the tolerance; v itself where it
 * misses none. False when the intersection is empty; *nearest is then unset. */
bool find_nearest_point(const half_space *spaces, size_t count, half_space_rules rules, vec3 v,
                        vec3 *nearest);

#endif
