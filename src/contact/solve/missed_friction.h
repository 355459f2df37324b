/* contact/solve/missed_friction.h - what friction on obstacles missed in the last round goes to the
 * cloths that it acts on. */
#ifndef TULLE_CONTACT_SOLVE_MISSED_FRICTION_H
#define TULLE_CONTACT_SOLVE_MISSED_FRICTION_H

#include "contact/solve/end_round.h"

/* Moves each cloth without held vertices, as a whole, as sums[].missed of end_round moves it where
 * the loaded rows of the matrix hold it by their penalties. `sums`: of each surface;
 * `held_by` is set here. */
void give_missed_friction(const contact_scene *scene, const row_list *list, friction_sums *sums,
                          double *u);

#endif
