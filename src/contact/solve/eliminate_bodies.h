/* contact/solve/eliminate_bodies.h - rigid bodies taken out of the linear system of stage 7.
 *
 * With cloth u and slots V, hard rows join
 *     A + J^T K J   J^T K G        u
 *     G^T K J       M + G^T K G    V,
 * J and G the rows over cloth and over slots. A hard row lies on one body at most, so
 * B = M + G^T K G has a block of 6 x 6 for each, and V = B^-1 (b - G^T K J u) is at hand for any u.
 * A solve then has unknowns of cloth alone. In its matrix rows on bodies pull by
 * K - K G B^-1 G^T K  in place of K: the bodies follow. */
#ifndef TULLE_CONTACT_SOLVE_ELIMINATE_BODIES_H
#define TULLE_CONTACT_SOLVE_ELIMINATE_BODIES_H

#include "contact/contact_types.h"

/* The bodies of one round. */
typedef struct eliminated_bodies {
    const contact_scene *scene;
    contact_row *const *rows; /* hard ones with bodies, and maybe others; none has a tilt */
    size_t row_count;
    const double *right_hand_side, *diagonal; /* of cloth and slots, rows included */
    double *factors; /* 36 of each body, by rows: L of B = L L^T; 1 on locked axes */
    double *answers; /* 6 of each body */
    uint32_t *held;  /* bodies that a row lies on */
    size_t held_count;
    bool is_definite; /* all blocks B are, in spite of rounding; else the bodies must stay */
} eliminated_bodies;

/* Factors the blocks B; all members before the factors are given. Sets is_definite. False: no
 * memory. */
bool factor_bodies(eliminated_bodies *bodies, arena *scratch);
/* Sets the slots in u for its cloth. */
void settle_bodies(const eliminated_bodies *bodies, double *u);
/* Impulses of rows of cloth that moves, 3 a row, from those that they have while bodies are held.
 * Returns how much less their work is, the sum of impulse . velocity. */
double yield_bodies(const eliminated_bodies *bodies, double *impulses);

#endif
