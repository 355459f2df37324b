/* contact/solve/project_impulses.h - projected Gauss-Seidel over contact rows, in the metric of the
 * true masses. */
#ifndef TULLE_CONTACT_SOLVE_PROJECT_IMPULSES_H
#define TULLE_CONTACT_SOLVE_PROJECT_IMPULSES_H

#include "contact/rows/row_motion.h"

/* Sweeps forward and backward over the rows, but for those in the matrix of the solve. Total
 * impulses are projected on the Coulomb cone (they may shrink); u of vertices with mass changes
 * with them, so that linear momentum is kept between cloths. Serial and in the order of the rows: a
 * fixed result. Returns TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status project_impulses(const contact_scene *scene, contact_row *rows, size_t count,
                              double *u);

/* Normal speed that a row asks for [m/s]. Where it starts inside the contact distance it asks the
 * less to be pushed out the more it carries, so that the impulses of rows that cannot all have
 * their way, as where cloth is pinched, come to an end. */
static inline double get_wanted_speed(const contact_row *row) {
    double const bias = row->law.bias;
    if (!(bias > 0.0)) return bias;
    return fmax(bias - row->solve.compliance * get_normal_impulse(row), 0.0);
}

#endif
