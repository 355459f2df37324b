/* app/mend/solve.h - the world in which the cloth is moved.
 *
 * Its cloth follows targets (tulle_cloth_set_targets). Vertices that are not free are led to them
 * on straight lines, as the bodies are. Free ones are drawn to u = pull * before, departures from
 * the targets, each with the weight of its area; what differs between neighbours is smoothed by
 * bending. What contact does not let through stays out: so the step's promise is that of the
 * result. Bodies that leave the cloth no room lag. */
#ifndef TULLE_APP_MEND_SOLVE_H
#define TULLE_APP_MEND_SOLVE_H

#include "app/mend/input.h"

#include "tulle/world.h"

typedef struct mend_follow_options {
    double strength; /* > 0; of a departure 1 - sqrt(s / (1 + s)) is left after a frame */
    double reach;    /* [edges] > 0: over which a departure is smoothed */
    double gap;      /* contact distance in the files' unit; 0: a twentieth of a mean edge */
    int threads;
    bool may_lag; /* bodies that leave the cloth no room */
} mend_follow_options;

typedef struct mend_solver {
    const mend_input *input;
    double scale; /* from the files' unit to that of the world: a power of two, so exact */
    double contact_distance; /* [m] in the world */
    double *scaled;          /* scratch: all vertices, twice, and the cloth's */
    tulle_world *world;
    uint32_t solve_limit; /* solves after which a move fails; 0: none */
    bool is_over;         /* it had more */
} mend_solver;

/* Starts the world with `now`, all vertices in the first frame: it is untangled where it
 * intersects, and refused where cloth lies wholly inside a body. Release with mend_solver_close,
 * also after a failure; the solver must stay where it is. */
tulle_status mend_solver_open(const mend_input *input, const mend_follow_options *options,
                              double *now, mend_solver *solver, tulle_error *error);
void mend_solver_close(mend_solver *solver);

typedef struct mend_move {
    const double *now;            /* all vertices; nothing intersects */
    const double *targets;        /* all vertices */
    const double *departures;     /* of the cloth: where a vertex would be if nothing smoothed it */
    const unsigned char *is_free; /* by vertex of the cloth */
} mend_move;

typedef struct mend_moved {
    double *end;            /* all vertices */
    unsigned char *pressed; /* by vertex of the cloth: led, and contact presses on it */
    size_t pressed_count;
} mend_moved;

/* The fields end and pressed are the caller's memory. Errors: those of tulle_world_step;
 * TULLE_ERROR_STEP_FAILED also at the limit of solves. */
tulle_status mend_solver_move(mend_solver *solver, const mend_move *move, mend_moved *moved,
                              tulle_error *error);

#endif
