/* contact/solve/end_round.h - the end of a round of solve_motion: new impulses, what rows still
 * miss, and whether that is little enough. */
#ifndef TULLE_CONTACT_SOLVE_END_ROUND_H
#define TULLE_CONTACT_SOLVE_END_ROUND_H

#include "contact/contact_types.h"

/* What friction of a surface's rows in the matrix left after a round. */
typedef struct friction_sums {
    vec3 misfit; /* [N s] */
    vec3 slip;   /* [N s] of the rows that hold: what they slip, times their penalties */
    double held; /* [kg] sum of these penalties */
} friction_sums;

/* What a round leaves to do. */
typedef struct round_result {
    double violation, misfit; /* [m/s] root mean squares over the rows */
    double largest_violation; /* [m/s] */
    double largest_misfit;    /* [m/s] */
    bool may_drift;           /* the misfit would give a cloth as a whole speed that counts, or rows
                                 that hold it let it slip as a whole */
} round_result;

/* Takes the velocities u of a solve; gives the impulses after it. Rows that are violated become
 * hard. `sums`: room for one of each surface. */
tulle_status end_round(const contact_scene *scene, row_list *list, friction_sums *sums, double *u,
                       round_result *result);

/* Whether rounds may end after one of so many iterations. */
bool round_has_settled(const contact_settings *settings, const round_result *result,
                       uint32_t iterations);

#endif
