/* contact/solve/solve_bodies.h - the part of rigid bodies in the linear system of stage 7.
 *
 * Each body has two slots after the cloth vertices, with one diagonal block each: its mass and its
 * inertia. Only hard rows join them to each other and to cloth. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_BODIES_H
#define TULLE_CONTACT_SOLVE_SOLVE_BODIES_H

#include "contact/contact_types.h"

/* Fills the entries of slots: b and the diagonal blocks of A; 0 and 1 for bodies that are not free.
 */
void fill_body_system(const contact_scene *scene, double *right_hand_side, double *diagonal);
/* First guess of u of slots. A body that a row of the list presses keeps its velocities of the
 * start of the step; others move as if nothing held them. Zero for bodies that are not free. `list`
 * may be null: no body is pressed. */
void start_bodies(const contact_scene *scene, const row_list *list, double *u);
/* y = A x for slots. */
void apply_bodies(const contact_scene *scene, const double *x, double *y);
/* z = D^-1 r for slots, D their diagonal blocks; 0 for bodies that are not free. */
void precondition_bodies(const contact_scene *scene, const double *diagonal, const double *r,
                         double *z);

#endif
