/* step/surface_box.h - the box around the vertices of a surface. */
#ifndef TULLE_STEP_SURFACE_BOX_H
#define TULLE_STEP_SURFACE_BOX_H

#include "detect/surface_set.h"

#include <math.h>
#include <stdbool.h>

/* [m] */
typedef struct surface_box {
    double low[3], high[3];
} surface_box;

/* The box around a surface's vertices at two times; pass the same positions twice for one time. */
static inline surface_box measure_surface_box(const surface_range *range, const double *start,
                                              const double *end) {
    double const most = (double)INFINITY;
    surface_box box = {{most, most, most}, {-most, -most, -most}};
    for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
        for (size_t c = 0; c < 3; c++) {
            box.low[c] = fmin(box.low[c], fmin(start[3 * v + c], end[3 * v + c]));
            box.high[c] = fmax(box.high[c], fmax(start[3 * v + c], end[3 * v + c]));
        }
    }
    return box;
}

static inline bool surface_box_holds(const surface_box *box, const double *point) {
    bool is_inside = true;
    for (size_t c = 0; c < 3; c++)
        is_inside = is_inside && point[c] >= box->low[c] && point[c] <= box->high[c];
    return is_inside;
}

/* [m] From a point to the box; 0 within it. */
static inline double surface_box_distance(const surface_box *box, const double *point) {
    double sum = 0.0;
    for (size_t c = 0; c < 3; c++) {
        double const away = fmax(box->low[c] - point[c], point[c] - box->high[c]);
        sum += away > 0.0 ? away * away : 0.0;
    }
    return sqrt(sum);
}

#endif
