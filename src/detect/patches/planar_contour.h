/* detect/patches/planar_contour.h - proof that a closed polygon of moving points stays a simple
 * curve. */
#ifndef TULLE_DETECT_PATCHES_PLANAR_CONTOUR_H
#define TULLE_DETECT_PATCHES_PLANAR_CONTOUR_H

#include "detect/patches/certificate.h"
#include "detect/patches/planar_path.h"

#include <stdint.h>

/* Proves that the polygon is star-shaped and counterclockwise about its middle, or that no two of
 * its edges touch. It looks at no more than max_tests pairs of boxes or edges. The points come in
 * the order of the polygon, at least 3; the last is joined to the first. reach: the planar reach of
 * all of them, > 0. scratch: as many of the contour_scratch_size(count) bytes as the points
 * themselves do not take, 8-byte aligned. */
contour_proof prove_planar_contour(const planar_path *points, size_t count, double reach,
                                   size_t max_tests, void *scratch);

#endif
