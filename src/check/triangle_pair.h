/* check/triangle_pair.h - whether two triangles intersect, by exact signs alone. */
#ifndef TULLE_CHECK_TRIANGLE_PAIR_H
#define TULLE_CHECK_TRIANGLE_PAIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct check_triangle {
    const double *corners[3];
    uint32_t vertices[3]; /* equal numbers in both triangles of a pair are a shared vertex */
} check_triangle;

/* Whether the triangles have a common point outside the hull of their shared vertices: anywhere if
 * they share none, beyond the vertex or edge if they share one or two. Triangles with the
 * same three vertex numbers always intersect. can_share: false says that equal vertex numbers mean
 * nothing (different bodies). *exact_count grows by the predicates that the filter could not
 * decide. */
bool triangles_intersect(const check_triangle *a, const check_triangle *b, bool can_share,
                         size_t *exact_count);

#endif
