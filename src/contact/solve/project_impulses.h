/* contact/solve/project_impulses.h - projected Gauss-Seidel over contact rows, in the metric of the
 * true masses. */
#ifndef TULLE_CONTACT_SOLVE_PROJECT_IMPULSES_H
#define TULLE_CONTACT_SOLVE_PROJECT_IMPULSES_H

#include "contact/rows/row_motion.h"

/* Sweeps forward and backward, so often at most, over the rows that are not in the matrix of the
 * solve. Projects total impulses on the Coulomb cone; they may shrink. u of what has mass changes
 * with them, so linear momentum is kept between cloths. Sweeps are serial and in the order of the
 * rows, so the result is fixed. Returns TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status project_impulses(const contact_scene *scene, int sweep_count, contact_row *rows,
                              size_t count, double *u);

/* The normal speed that a row asks for [m/s]. A row that starts inside the contact distance asks to
 * be pushed out; the more it carries, the less it asks. Else the impulses of rows that cannot all
 * have their way, as where cloth is pinched, would grow without end. */
static inline double get_wanted_speed(const contact_row *row) {
    double const bias = row->law.bias;
    if (!(bias > 0.0)) return bias;
    double const speed = bias - row->solve.compliance * get_normal_impulse(row);
    return speed > 0.0 ? speed : 0.0;
}

#endif
