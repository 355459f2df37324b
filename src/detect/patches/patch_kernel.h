/* detect/patches/patch_kernel.h - what every kept patch runs through at each step; see
 * planar_path.h. */
#ifndef TULLE_DETECT_PATCHES_PATCH_KERNEL_H
#define TULLE_DETECT_PATCHES_PATCH_KERNEL_H

#include "detect/patches/planar_path.h"
#include "math/kernel_target.h"

#include <stdint.h>

/* Projects the paths x0 -> x1 of the vertices and returns their size, as project_path does; what is
 * not finite makes it infinite or NaN. */
TULLE_DECLARE_KERNEL(double, project_paths,
                     (const planar_map *map, const uint32_t *vertices, size_t count,
                      const double *x0, const double *x1, planar_path *points))

/* Whether all triangles, three points each, turn to the left for the whole step, with the planar
 * reach. */
TULLE_DECLARE_KERNEL(bool, patch_turns_left,
                     (const planar_path *points, const uint32_t *corners, size_t count,
                      double reach))

#endif
