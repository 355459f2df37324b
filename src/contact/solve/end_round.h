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

typedef struct round_result {
    double largest_violation; /* [m/s] of a row */
    bool has_settled;         /* rows miss so little that rounds may end, see contact_settings */
} round_result;

/* Takes the velocities u of a solve of so many iterations; gives the impulses after it. Rows that
 * are violated become hard. `sums`: room for one of each surface. */
tulle_status end_round(const contact_scene *scene, row_list *list, uint32_t iterations,
                       friction_sums *sums, double *u, round_result *result);

#endif
