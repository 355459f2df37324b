/* contact/solve/hard_rows.h - rows that take part in the matrix of the solve.
 *
 * In the solve a hard row gives the impulse  p + K (w - v).  p is its multiplier, v its relative
 * velocity, and w the velocity at which K does nothing. After the solve that impulse is bounded by
 * what contact and friction can give; the result is the next multiplier. */
#ifndef TULLE_CONTACT_SOLVE_HARD_ROWS_H
#define TULLE_CONTACT_SOLVE_HARD_ROWS_H

#include "contact/contact_types.h"

/* Sets penalty and compliance of every row from the diagonal blocks of A, 9 * get_solved_count.
 * Rows that are violated at the velocities u become hard. */
void prepare_hard_rows(const contact_scene *scene, const double *diagonal, contact_row *rows,
                       size_t count, const double *u);

/* [m/s] The projection of impulses may mend a violation up to this. It is over ten times what a
 * solve of cloth at rest leaves. Layers that fall together meet with less; hard rows would tie them
 * to each other for nothing. */
static const double LEAST_VIOLATION = 1e-5;

/* K of a row [kg] by its state: how its impulse answers a velocity. */
mat3 get_pull(const contact_row *row);

/* Sets K, solve.pull. The friction of a row that was not in the matrix in the round before begins
 * by the slip of u. */
void make_pull(const contact_settings *settings, contact_row *row, const double *u);

/* Returns the violation [m/s] of a row, by how much it failed in the solve that gave u: too slow,
 * too fast while it pushed, or held back by a pull. If that is over LEAST_VIOLATION the row becomes
 * hard, unless both of its sides are rigid. Call it before update_hard_row. */
double harden_if_violated(contact_row *row, const double *u);

/* Sets multiplier and state of a row in the matrix after the solve that gave u. A row that pulled
 * stops being hard. Returns the misfit of friction [N s]: the new friction less the one that the
 * solve assumed. */
vec3 update_hard_row(contact_row *row, const double *u);

#endif
