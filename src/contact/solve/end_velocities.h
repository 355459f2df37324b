/* contact/solve/end_velocities.h - velocities at the end of a step where contacts rebound, or where
 * the integrator's end velocity is not the mean velocity that rows were solved for. */
#ifndef TULLE_CONTACT_SOLVE_END_VELOCITIES_H
#define TULLE_CONTACT_SOLVE_END_VELOCITIES_H

#include "contact/contact_types.h"

typedef struct end_velocities {
    bool is_inelastic;      /* in: contacts that carry load and do not rebound may not approach at
                               the end; else they may do so as fast as they may in the mean */
    double kinetic_limit;   /* in: [J] a rebound may lead to no more kinetic energy than this and
                               the work of obstacles */
    uint64_t rebound_count; /* out: rows that rebound */
    double approach;        /* out: [m/s] by how much a row misses its end velocity, the largest */
} end_velocities;

/* Work [J] on cloth that can move of the obstacles and pins that rows hold it by, along their own
 * motion: their impulses times u of what is held. */
double compute_obstacle_work(const contact_scene *scene, const contact_row *rows, size_t count,
                             const double *u);

/* Whether the row's sides come nearer at the start faster than those of a contact at rest may. */
bool row_is_impact(const contact_scene *scene, const contact_row *row);

/* Changes v1 [m/s], 3 * vertex_count, the velocities at the end of the step as far as contact does
 * not know of them, so that rows that carry load (of stages 7 and 8) end as the laws of impact
 * and friction say. Marks the rows that rebound. v1 keeps its bits where no row rebounds and
 * is_inelastic is false. u [m/s]: the mean velocities of the step. Linear momentum is kept between
 * cloths. scene->v0 must be given. */
tulle_status end_contacts(const contact_scene *scene, row_list *list, const double *u, double *v1,
                          end_velocities *ends);

#endif
