/* step/step_context.h - what the stages of a step share, and how a substep may end. */
#ifndef TULLE_STEP_STEP_CONTEXT_H
#define TULLE_STEP_STEP_CONTEXT_H

#include "contact/commit/commit_safely.h"
#include "contact/commit/resolve_impacts.h"
#include "contact/response.h"
#include "contact/rows/gather_rows.h"
#include "contact/solve/solve_motion.h"
#include "step/energy_balance.h"
#include "step/motion_state.h"
#include "step/solve_plan.h"
#include "step/step_work.h"

/* The stages of a substep, in the order in which step.c runs them and of tulle_stage_name. */
typedef enum stage {
    STAGE_PREDICT_PATHS,
    STAGE_UPDATE_PATCHES,
    STAGE_BUILD_TREES,
    STAGE_FIND_PAIRS,
    STAGE_GATHER_ROWS,
    STAGE_COMPUTE_FORCES,
    STAGE_SOLVE_MOTION,
    STAGE_RESOLVE_IMPACTS,
    STAGE_COMMIT_SAFELY,
    STAGE_ACCEPT_STATE
} stage;

/* How a substep ended. The stage that ends it sets this; so may the judgement of its motion,
 * retry.c and, at the end of the step, step.c. retry.c decides what is tried next. */
typedef enum substep_outcome {
    SUBSTEP_RUNS,      /* no stage has ended it yet */
    SUBSTEP_WHOLE,     /* accepted: all of its time passed */
    SUBSTEP_SHORTENED, /* accepted: a part of its time passed */
    SUBSTEP_BLOCKED,   /* no part of its time may pass */
    SUBSTEP_CROWDED,   /* refused: its paths are so long that they have too many candidates */
    SUBSTEP_WAKES,     /* refused: its contacts woke bodies or cloth */
    SUBSTEP_TURNS,     /* refused: a contact makes a body turn too far */
    SUBSTEP_STRETCHES, /* refused: an edge of cloth would grow too much */
    SUBSTEP_GAINS,     /* refused: it would end with far more energy than there is */
    SUBSTEP_PINCHED,   /* the last of the step: obstacles or pins leave cloth no room */
    SUBSTEP_TORN       /* the last of the step; it tears squeezed cloth */
} substep_outcome;

/* Facts for retry.c. The first group lasts for one attempt at the step, the second for a substep.
 */
typedef struct retry_state {
    double remaining; /* [s] of the step that must still pass */
    double wanted;    /* [s] length of the next substep, if no body turns too far in it */
    double turn_time; /* [s] the longest that the next substep may be for a body that turns */
    double shortest;  /* [s] a substep of this length is accepted, however far it stretches cloth */
    bool is_cut_by_turns;   /* the substep is shorter than wanted, because bodies turn in it */
    uint32_t substep_limit; /* after so many substeps the step is stuck */
    int crawl_count;        /* substeps in a row in which next to no time passed */
    int shorter_count;      /* how often a stuck step continued with shorter substeps */

    int solves;            /* of the substep so far */
    solve_history history; /* of them */
    bool is_rough;         /* the next solve need only be rough: springs are linearised about it */
    int linearisations;    /* further linearisations of the springs since the last balance */
    lost_solve lost;       /* of the substep */
    int balances;          /* repeated solves with more rounds, because energy was gained */
    int room_levels;       /* repeated solves with less room between bodies, for the same reason */
    double first_gain, last_gain; /* [J] gains that caused balances: the first, the last */
} retry_state;

/* The data that these files of a step carry from stage to stage: step.c, stages.c, search.c,
 * accept_state.c, retry.c. */
typedef struct step_context {
    const step_model *model;
    motion_state *state; /* a copy of the state of the world; accept_state advances it */
    step_work *work;
    substep *sub; /* of the work */

    substep_outcome outcome;
    retry_state retry;
    pair_source source;

    /* results of the stages of the substep */
    size_t gathered_count; /* gather_rows: rows; those of impacts follow */
    solve_result result;   /* solve_motion, or of the impacts that it foresees */
    linear_excess excess;  /* of the solution, beyond what the linear system predicts */
    impact_report impacts; /* resolve_impacts */
    commit_report commit;

    /* time taken: see step_end_stage */
    double lap;            /* [s] the clock at the end of the last stage */
    double search_seconds; /* [s] since then in stages 2 to 4 */
    arena_mark search_mark;
} step_context;

/* ---- the stages, each a call of run_substep in step.c ---- */

/* stages.c: all that the stages read, and stage 1: where cloth goes without contact and
 * inner forces, x0 + h v0 + h^2 g, into `predicted`. */
tulle_status step_predict_paths(step_context *context);
/* The substep as contact sees it, without bodies. */
contact_scene step_make_scene(step_context *context);

/* search.c: patches certified for x0 -> x1, trees of x0 -> bounds, candidates of these paths. */
tulle_status step_update_patches(step_context *context, const double *x1);
tulle_status step_build_trees(step_context *context, const double *bounds);
tulle_status step_find_pairs(step_context *context, const double *bounds);
/* Source of the candidates of a substep; bounds and certified_end of `sub` have room. */
pair_source step_make_pair_source(step_context *context);

/* stages.c: stages 5 to 9. compute_forces linearises about x0, or about `guess` if that is set. */
tulle_status step_gather_rows(step_context *context);
tulle_status step_compute_forces(step_context *context);
tulle_status step_solve_motion(step_context *context);
tulle_status step_resolve_impacts(step_context *context);
tulle_status step_commit_safely(step_context *context);

/* accept_state.c: the one place where the state moves on. */
tulle_status step_accept_state(step_context *context);

/* Multiplies the impulses of all rows. Before and after the solve they are impulses of the whole
 * step; the solve counts them as its right-hand side does. By implicit Euler both are the same. */
void step_scale_impulses(step_context *context, double factor);

/* Ends a stage: adds the time since the end of the last stage to it, without the searches inside
 * it. Returns the narrowed status. */
tulle_status step_end_stage(step_context *context, stage number, tulle_status status);

/* A stage's status as the step's: out of memory, too many pairs, or failed. */
static inline tulle_status step_narrow(tulle_status status) {
    bool const is_own =
        status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY || status == TULLE_ERROR_LIMIT;
    return is_own ? status : TULLE_ERROR_STEP_FAILED;
}

/* ---- retry.c ---- */

/* Before the first substep; before the first solve of a substep. */
void step_begin_retries(step_context *context);
void step_begin_solves(step_context *context);
/* Chooses the length of the next substep. An error names a body that turns too fast. */
tulle_status step_choose_substep(step_context *context);
/* Whether springs may be linearised once more before the substep is judged. */
bool step_may_linearise(const retry_state *retry, bool is_lost);
/* Moves a lost solution back, see step_temper_solution. */
tulle_status step_temper(step_context *context);
/* Whether stage 7 runs again; stages 7 and 8; how the step continues after a substep; whether the
 * step is undone and runs again. */
bool step_retry_solve(step_context *context, tulle_status *status);
bool step_retry_balance(step_context *context, tulle_status *status);
void step_retry_substep(step_context *context, tulle_status *status);
bool step_retry_whole(step_context *context, tulle_status *status);
/* Whether the step has passed, or is pinched. */
bool step_is_over(const step_context *context);
/* Whether the substep is still long enough that half of it may be tried instead; whether a gain of
 * energy may be a reason for that. */
bool step_may_halve(const step_context *context);
bool step_may_refuse_gain(const step_context *context);

#endif
