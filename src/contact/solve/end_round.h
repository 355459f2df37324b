/* contact/solve/end_round.h - the end of a round of solve_motion: new impulses, how far rows are
 * from what they ask for, and whether that is near enough. */
#ifndef TULLE_CONTACT_SOLVE_END_ROUND_H
#define TULLE_CONTACT_SOLVE_END_ROUND_H

#include "contact/contact_types.h"
#include "contact/solve/solve_plan.h"

/* What friction left after a round: sums over the rows of a surface that are in the matrix. */
typedef struct friction_sums {
    vec3 missed;  /* [N s] friction less what the solve assumed, on obstacles; of cloth in one piece
                   */
    vec3 misfit;  /* [N s] the same of all other rows */
    vec3 slip;    /* [N s] of rows that stick: slip times penalty */
    double held;  /* [kg] of rows that stick: penalties */
    mat3 held_by; /* [kg] what answers a velocity of the whole cloth, see missed_friction.c */
} friction_sums;

typedef struct round_result {
    double largest_violation; /* [m/s] of all rows */
    bool has_settled;         /* violations and misfits are small enough, see contact_settings */
} round_result;

/* Takes the velocities u of a solve and gives the impulses after it. Rows that are violated become
 * hard. The effort: that of the round, see get_round_effort. `sums`: room for one entry of each
 * surface. */
tulle_status end_round(const contact_scene *scene, const solve_effort *effort, row_list *list,
                       friction_sums *sums, double *u, round_result *result);

/* After the last round: moves each cloth without held vertices, as a whole, by sums[].missed where
 * the loaded rows of the matrix hold it by their penalties. Sets `held_by`. */
void give_missed_friction(const contact_scene *scene, const row_list *list, friction_sums *sums,
                          double *u);

#endif
