/* contact/solve/hard_rows.h - rows that take part in the matrix of the solve.
 *
 * A hard row acts in the solve by  p + K (w - v):  p its multiplier, v its relative velocity, w the
 * velocity at which K does nothing. After a solve that force, as far as contact and friction allow
 * it, is the next multiplier. */
#ifndef TULLE_CONTACT_SOLVE_HARD_ROWS_H
#define TULLE_CONTACT_SOLVE_HARD_ROWS_H

#include "contact/contact_types.h"

/* Penalty and compliance of every row from A's diagonal blocks (9 * get_solved_count). Rows that
 * are violated at the velocities u become hard. */
void prepare_hard_rows(const contact_scene *scene, const double *diagonal, contact_row *rows,
                       size_t count, const double *u);

/* [m/s] A violation that the projection may mend: over ten times what a solve of cloth at rest
 * leaves. Layers that fall together meet with less, and would be tied to each other for nothing. */
static const double LEAST_VIOLATION = 1e-5;

/* Lets a row that is violated by so much be in the matrix, unless its sides are all rigid. */
static inline void harden(contact_row *row, double violation) {
    if (violation > LEAST_VIOLATION && !row->frame.is_without_cloth && row->solve.stiffness > 0.0)
        row->solve.is_hard = true;
}

/* Sets K, solve.pull. If the row was not in the matrix in the round before, its friction begins by
 * the slip of u. */
void make_pull(const contact_settings *settings, contact_row *row, const double *u);

/* [m/s] The tangential part of the row's relative velocity. */
vec3 get_slip(const contact_row *row, const double *u);

/* [m/s] By how much a row failed in the last solve, whose velocities u are: too slow, too fast
 * while it pushed, or held back by a pull. To be called before update_hard_row. */
double measure_row_violation(const contact_row *row, const double *u);

/* The multiplier of a row in the matrix after the solve that gave u, and its state. A row that
 * pulled stops being hard. Returns the misfit of friction [N s]: what it is less what the solve
 * took it for. */
vec3 update_hard_row(contact_row *row, const double *u);

#endif
