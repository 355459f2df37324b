/* contact/solve/solve_plan.h - how exact a solve of stage 7 is. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_PLAN_H
#define TULLE_CONTACT_SOLVE_SOLVE_PLAN_H

#include "tulle/world.h"

#include <stdbool.h>

/* How far solves go that cost much. */
typedef struct solve_effort {
    double late_factor;   /* after its patience a solve ends at so many times the tolerance, but not
                             above a part of the net impulse */
    int patience;         /* iterations; 0: a solve always ends at the tolerance */
    int cheap_iterations; /* a round of more is costly */
    double looseness;     /* costly rounds end at so many times the limits of contact_settings */
    double slip_share;    /* and where a cloth slips by this share of its speed, if that is more */
    double most_violation; /* [m/s] root mean square above which rounds go on whatever the limits */
} solve_effort;

/* One a quality, as tulle_quality numbers them. */
extern const solve_effort solve_efforts[TULLE_QUALITY_EXACT + 1];
/* Rounds that are cheap: they go on until no row is violated. */
extern const solve_effort cheap_effort;
/* Cloth that is stiff on average. */
extern const solve_effort stiff_effort;

static inline const solve_effort *get_round_effort(const solve_effort *effort,
                                                   uint32_t iterations) {
    return iterations <= (uint32_t)effort->cheap_iterations ? &cheap_effort : effort;
}

/* What a solve is to do, from step/solve_plan.c. Small net impulses tighten it in solve_motion.c.
 */
typedef struct solve_plan {
    int rounds_least;    /* solves of motion and impulses */
    int rounds_most;     /* while the impulses have not settled */
    int rounds_settled;  /* impulses after fewer of them do not count as settled */
    int iterations_most; /* of conjugate gradients in a round */
    double tolerance;    /* preconditioned residual over that of the step's force impulse */
    /* A rough solve, which another one follows, may end at this part of its first residual, but not
     * above that tolerance; 0: it is not rough */
    double early_share, early_tolerance;
    /* Iterations before a solve may end late. Those of earlier solves of the substep count, down to
     * the least. 0: it does not end late */
    int patience, patience_least;
    bool is_fine; /* once a solve of fine cloth outlasts its patience, all rounds are costly */
    const solve_effort *effort;
} solve_plan;

#endif
