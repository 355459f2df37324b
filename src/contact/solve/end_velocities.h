/* contact/solve/end_velocities.h - the laws of impact for velocities at the end of a step.
 *
 * They are needed where contacts rebound, and where the integrator's end velocity is not the mean
 * velocity that rows were solved for. */
#ifndef TULLE_CONTACT_SOLVE_END_VELOCITIES_H
#define TULLE_CONTACT_SOLVE_END_VELOCITIES_H

#include "contact/contact_types.h"

typedef struct end_velocities {
    bool is_inelastic;      /* in: contacts that carry load and do not rebound may not approach at
                               the end. Else they may, as fast as they may in the mean */
    double kinetic_limit;   /* in: [J] after a rebound the kinetic energy is at most this plus the
                               work of obstacles */
    uint64_t rebound_count; /* out: rows that rebound */
    double approach;        /* out: [m/s] the most by which a row misses its end velocity */
} end_velocities;

/* Work [J] that obstacles and pins do along their own motion, through these rows, on what can move:
 * impulses times u of what is held. */
double compute_obstacle_work(const contact_scene *scene, const contact_row *rows, size_t count,
                             const double *u);

/* Whether the row's sides approach at the start faster than those of a contact at rest may. */
bool row_is_impact(const contact_scene *scene, const contact_row *row);

/* Changes v1 so that the rows that carry load after stages 7 and 8 end as the laws of impact and
 * friction say. In: v1 [m/s], 3 * vertex_count, the integrator's velocities at the end of the step,
 * without these laws; u [m/s], the mean velocities of the step. Marks the rows that rebound. If no
 * row rebounds and is_inelastic is false, v1 keeps its bits. Linear momentum is kept between
 * cloths. scene->v0 must be given. */
tulle_status end_contacts(const contact_scene *scene, row_list *list, const double *u, double *v1,
                          end_velocities *ends);

#endif
