/* app/mend/solve.h - one move of the cloth: a world that has just one step.
 *
 * The cloth of the world is made of springs that are next to nothing, and bends. Vertices that are
 * not free are pinned and led to their targets on straight lines, as the bodies are. Free ones are
 * drawn to u = pull * before, departures from the targets, each with the weight of its area; what
 * differs between neighbours is smoothed (plate.h). What contact does not let through stays out: so
 * the step's promise is that of the result. */
#ifndef TULLE_APP_MEND_SOLVE_H
#define TULLE_APP_MEND_SOLVE_H

#include "app/mend/input.h"
#include "app/mend/plate.h"

typedef struct mend_solver {
    const mend_input *input;
    double scale;            /* from the files' unit to that of worlds: a power of two, so exact */
    double contact_distance; /* in the files' unit */
    double minimum_gap;      /* the same */
    double least_distance;   /* the same: a contact distance that rounding to float leaves open */
    double reach;            /* [edges] over which a departure is smoothed */
    int threads;
    double *rest;       /* of the cloth in the world's unit */
    mend_plate plate;   /* of the same */
    double *scaled;     /* scratch: all vertices, twice, and the cloth's six times */
    uint32_t *vertices; /* scratch of the cloth: free ones, then pinned ones */
} mend_solver;

/* `first`: positions of all vertices in the first frame. Release with mend_solver_close, also after
 * a failure. */
tulle_status mend_solver_open(const mend_input *input, const double *first, mend_solver *solver,
                              tulle_error *error);
void mend_solver_close(mend_solver *solver);

/* A start without a step: `now` (all vertices) is untangled where it intersects, and refused where
 * cloth lies wholly inside a body. */
tulle_status mend_solver_start(mend_solver *solver, double *now, tulle_error *error);

typedef struct mend_move {
    const double *now;            /* all vertices; nothing intersects */
    const double *targets;        /* all vertices */
    const double *departures;     /* of the cloth: where a vertex would be if nothing smoothed it */
    const unsigned char *is_free; /* by vertex of the cloth */
    uint32_t solve_limit;         /* solves after which the move fails; 0: none */
} mend_move;

typedef struct mend_moved {
    double *end;            /* all vertices */
    unsigned char *pressed; /* by vertex of the cloth: pinned, and contact presses on it */
    size_t pressed_count;
} mend_moved;

/* The fields end and pressed are the caller's memory. Errors: those of tulle_world_step;
 * TULLE_ERROR_STEP_FAILED also at the limit of solves. */
tulle_status mend_solver_move(mend_solver *solver, const mend_move *move, mend_moved *moved,
                              tulle_error *error);

#endif
