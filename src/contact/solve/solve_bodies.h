/* contact/solve/solve_bodies.h - the part of rigid bodies in the linear system of stage 7: two
 * slots each, after the cloth vertices, with blocks of their own (mass and inertia) and nothing
 * between them but hard rows. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_BODIES_H
#define TULLE_CONTACT_SOLVE_SOLVE_BODIES_H

#include "contact/contact_types.h"

/* Entries of slots: b and the diagonal blocks of A, 0 and 1 for bodies that are not free. */
void fill_body_system(const contact_scene *scene, double *right_hand_side, double *diagonal);
/* u of slots where nothing holds the bodies; zero for those that are not free. */
void start_bodies(const contact_scene *scene, double *u);
/* u of slots at the start of the step instead, for bodies that a row of the list presses. */
void start_pressed_bodies(const contact_scene *scene, const row_list *list, double *u);
/* y = A x for slots. */
void apply_bodies(const contact_scene *scene, const double *x, double *y);
/* z = D^-1 r for slots, D their diagonal blocks; 0 for bodies that are not free. */
void precondition_bodies(const contact_scene *scene, const double *diagonal, const double *r,
                         double *z);
/* shift of slots: each body by its own residual, or all with `velocity` when it is given. */
void shift_bodies(const contact_scene *scene, const double *residual, const vec3 *velocity,
                  double *shift);

#endif
