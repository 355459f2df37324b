/* contact/solve/solve_motion.h - stage 7: finds velocities and impulses that agree. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_MOTION_H
#define TULLE_CONTACT_SOLVE_SOLVE_MOTION_H

#include "contact/contact_types.h"
#include "contact/solve/solve_plan.h"
#include "math/conjugate_gradients.h"
#include "math/single_solve.h"

/* What earlier solves of a substep leave for later ones; zeroed before the first. Whoever changes
 * the matrix clears has_sums. */
typedef struct solve_history {
    uint32_t iterations; /* of all before */
    bool has_sums;       /* aggregates have sums of this matrix */
    bool is_costly;      /* one of fine cloth outlasted its patience */
} solve_history;

/* The implicit step without contact: A u = b over the cloth vertices. A has entries for all of
 * them. The solve masks the rows of vertices with inverse mass 0; their columns act with the
 * prescribed u. */
typedef struct motion_system {
    const double *right_hand_side; /* [N s] 3 * cloth_vertex_count */
    const block_matrix *matrix;    /* A */
    const double *forces; /* [N] f(x0, v0), 3 * cloth_vertex_count; null unless the response
                             needs_forces */
    double force_time;    /* [s] right_hand_side holds force_time f */
    const double *start;  /* [m/s] cloth velocities at the start of the step; null: u */
    nested_aggregates *aggregates; /* of A, to precondition a solve in single precision; null: the
                                      solve is in double precision */
    solve_history *history;        /* of the substep */
    tie_spring *springs;           /* spring_count that pull at x0 + h u; their pull is set */
    size_t spring_count;
} motion_system;

/* What the solve did, for tulle_step_report. */
typedef struct solve_report {
    uint32_t solve_count, cg_iterations;
    double cg_residual; /* largest relative preconditioned residual of solves that are not early */
    bool has_converged; /* no solve stopped at its limit */
    bool has_settled;   /* the impulses of the last round have settled */
    bool is_early;      /* a solve ended above the tolerance, as one that another follows may */
    uint64_t stick_count, slip_count, hard_count;
    double violation; /* [m/s] largest violation of a row right after the last solve */
} solve_report;

/* Solves for u and for the impulses of the rows. Free bodies of the scene take part with their
 * slots; the scene then has v0. `list` may be empty.
 * In: u of cloth vertices is the velocity at the start of the step. It is the first guess, and the
 * force impulse is measured from it. u of slots is the first guess; u of vertices with inverse mass
 * 0 is prescribed. Out: u, and the rows' impulses. */
tulle_status solve_motion(const contact_scene *scene, const motion_system *system,
                          const solve_plan *plan, row_list *list, double *u, solve_report *report);

/* Whether a spring of a tie holds a body. It may be stiffer than its body is heavy by many powers
 * of ten. The diagonal then hides what moves both, from single precision and from late ends. */
static inline bool has_tied_bodies(const tie_spring *springs, size_t count) {
    bool has_any = false;
    for (size_t i = 0; i < count; i++) has_any |= springs[i].row.frame.has_body;
    return has_any;
}

#endif
