/* world/step/step.h - a step of the world: what its stages share, and how a substep may end. */
#ifndef TULLE_WORLD_STEP_STEP_H
#define TULLE_WORLD_STEP_STEP_H

#include "contact/commit/commit_safely.h"
#include "contact/commit/resolve_impacts.h"
#include "contact/response.h"
#include "contact/rows/gather_rows.h"
#include "contact/solve/solve_motion.h"
#include "world/world_state.h"

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

/* How a substep ended. What ends it says so: a stage, the judgement of its motion, retry.c or, at
 * the end of the step, step.c. retry.c decides what is tried next. */
typedef enum substep_outcome {
    SUBSTEP_RUNS,      /* no stage has ended it yet */
    SUBSTEP_WHOLE,     /* accepted: all of its time passed */
    SUBSTEP_SHORTENED, /* accepted: a part of its time passed */
    SUBSTEP_BLOCKED,   /* no part of its time may pass */
    SUBSTEP_CROWDED,   /* refused: its paths are so long that too much comes near to them */
    SUBSTEP_WAKES,     /* refused: its contacts woke bodies or cloth */
    SUBSTEP_TURNS,     /* refused: a contact makes a body turn too far */
    SUBSTEP_STRETCHES, /* refused: an edge of cloth would grow too much */
    SUBSTEP_GAINS,     /* refused: it would end with far more energy than there is */
    SUBSTEP_PINCHED,   /* the last of the step: obstacles or pins leave cloth no room */
    SUBSTEP_TORN       /* the last of the step, which tears squeezed cloth */
} substep_outcome;

/* Cloth vertices at which a step was blocked or tears cloth. */
typedef struct blocked_place {
    bool is_pair; /* the vertices are a pair that blocked, of this kind */
    feature_kind kind;
    uint32_t vertices[4];
    uint32_t surface; /* a cloth, or the surface of the first vertex */
    vec3 position;    /* [m] of one of them */
} blocked_place;

/* A place around which what deforms stands still in a step that was pinched there. */
typedef struct still_place {
    vec3 position; /* [m] */
    double radius; /* [m] */
} still_place;
enum { STILL_PLACES = 16, STILL_TRIES = 24 };

/* What retry.c decides by. The first group lasts for one go at the step, the second for a substep.
 */
typedef struct retry_state {
    double remaining;       /* [s] of the step that must still pass */
    double wanted;          /* [s] length of the next substep, if no body turns too far in it */
    double turn_time;       /* [s] the longest that the next substep may be for a body that turns */
    double shortest;        /* [s] a substep of this length is taken whatever it stretches */
    bool is_cut_by_turns;   /* the substep is shorter than wanted, for bodies turn in it */
    uint32_t substep_limit; /* after so many substeps the step is stuck */
    int crawl_count;        /* substeps in a row in which next to no time passed */
    int shorter_count;      /* how often a step that was stuck went on with shorter substeps */

    int solves;            /* of the substep so far */
    solve_history history; /* of them */
    bool is_rough;         /* the next solve need only be rough: springs are linearised about it */
    int linearisations;    /* of the springs anew, since the last balance */
    bool is_lost;          /* a solution of the substep took far more energy than there is */
    bool is_tempered; /* the last one still did, and no other follows: u went back on its way */
    int balances;     /* solves anew with more rounds, for a gain of energy */
    int room_levels;  /* solves anew with less room between bodies, for the same */
    double first_gain, last_gain; /* [J] that balances were for: the first, the one before */
} retry_state;

/* What a step carries from stage to stage. */
typedef struct step_context {
    tulle_world *world;
    motion_state *state; /* a copy of the world's; accept_state moves it on */
    tulle_step_report *report;
    tulle_error *error;
    double step_start; /* [s] of the whole step */
    double whole_step; /* [s] its length */

    /* of the substep */
    double time_step; /* [s] its length */
    double passed;    /* [s] of it that passed, set by commit_safely */
    substep_outcome outcome;
    retry_state retry;

    /* what the stages read */
    contact_scene scene;
    tie_spring *springs; /* ties that pull, in the order of the state's ties */
    size_t spring_count;
    paper_rules paper; /* of the scene, by the paper's response */
    cloth_start dynamics;
    force_terms terms; /* of `dynamics`, where there is room for them */
    pair_source source;
    double damping; /* of the integrator, see force_options */

    /* what they write */
    double *predicted;         /* [m] predict_paths: ends of the paths to expect, all vertices */
    double *bounds;            /* [m] find_pairs: ends of the paths that the pairs are for */
    double *certified_end;     /* [m] update_patches: ends that the patches are certified for */
    double *guess;             /* [m/s] u about which springs are linearised */
    size_t gathered_count;     /* gather_rows: rows; those of impacts follow */
    double *mean_velocity;     /* [m/s] solve_motion: u of all vertices */
    double *end;               /* [m] solve_motion: ends x0 + h u of the paths */
    bool is_stretched;         /* the cloth takes more energy than the system reckons with */
    bool is_nearly_linear;     /* but hardly any more, once springs are linearised anew */
    linear_excess excess;      /* of the solution, over what the system reckons with */
    bool has_settled;          /* the impulses of a full solve no longer change */
    impact_report impacts;     /* resolve_impacts */
    double gain;               /* [J] that the paths give beyond what there is and a small slack */
    double energy_scale;       /* [J] at work in the substep: motion, and what falls */
    double lost_energy;        /* [J] that the substep loses; only with bodies */
    known_elastic end_elastic; /* of the cloths at `end` */
    commit_report commit;
    commit_report blocked;   /* the last commit of the step that named a blocking pair */
    stored_contact *resting; /* contacts of the store whose pairs have no rows */
    size_t resting_count;

    /* time taken: see world_end_stage */
    double lap;            /* [s] the clock at the end of the last stage */
    double search_seconds; /* [s] since then in stages 2 to 4 */
    arena_mark search_mark;

    /* carriers.c: the motion of scripted obstacles */
    affine_map *carrier_maps; /* per surface, of this substep */
    const affine_map **carriers;
    affine_map *progress;    /* per obstacle, from the start of the step to where it is */
    affine_map *script_maps; /* per obstacle, from there to the end of the substep */

    /* pinch/ */
    bool is_script_frozen;       /* all that follows a script stands still (on_pinch: slow) */
    double hold_left[HOLDS_MAX]; /* [m] that each hold keeps from its script */
    int pinch_level;             /* how much the step holds back already */
    blocked_place torn_place;    /* where the step tears squeezed cloth */
    double *lagging, *drawn; /* [m] all vertices: where lagging surfaces are to be at the end of the
                             step, null: as drawn; where they are drawn (lag.h) */
    still_place still[STILL_PLACES];
    size_t still_count;
    char pinch_message[WORLD_MESSAGE_BYTES / 2]; /* of the pinch found last */
} step_context;

/* ---- the stages, each a call of run_substep in step.c ---- */

/* predict_paths.c: all that the stages read, and stage 1: where cloth goes without contact and
 * inner forces, x0 + h v0 + h^2 g, into `predicted`. */
tulle_status world_predict_paths(step_context *context);
/* The substep as contact sees it, without bodies. */
contact_scene world_make_scene(step_context *context);

/* search.c: patches certified for x0 -> x1, trees of x0 -> bounds, the candidates of these. */
tulle_status world_update_patches(step_context *context, const double *x1);
tulle_status world_build_trees(step_context *context, const double *bounds);
tulle_status world_find_pairs(step_context *context, const double *bounds);

/* stages.c: stages 5 to 9. compute_forces is about x0, or about `guess` where that is set. */
tulle_status world_gather_rows(step_context *context);
tulle_status world_compute_forces(step_context *context);
tulle_status world_solve_motion(step_context *context);
tulle_status world_resolve_impacts(step_context *context);
tulle_status world_commit_safely(step_context *context);

/* accept_state.c: the one place where the state moves on. */
tulle_status world_accept_state(step_context *context);

/* Multiplies the impulses of all rows. Before the solve and after it they are those of the whole
 * step; the solve counts them as its right-hand side does. By implicit Euler both are the same. */
void world_scale_impulses(step_context *context, double factor);

/* Ends a stage: adds the time since the last end to it, without that of searches inside it, and
 * gives a status that is no success its message. Returns the status. */
tulle_status world_end_stage(step_context *context, stage number, tulle_status status);

/* Gives a status that is no success its message. Returns the status. */
tulle_status world_tell_failure(const step_context *context, tulle_status status);

/* ---- retry.c ---- */

/* Before the first substep; before the first solve of a substep. */
void world_begin_retries(step_context *context);
void world_begin_solves(step_context *context);
/* Chooses the length of the next substep. An error names a body that turns too fast. */
tulle_status world_choose_substep(step_context *context);
/* Whether springs may be linearised once more before the substep is judged. */
bool world_may_linearise(const step_context *context);
/* Whether stage 7 runs again; stages 7 and 8; how the step goes on after a substep; whether the
 * step, undone, runs again. */
bool world_retry_solve(step_context *context, tulle_status *status);
bool world_retry_balance(step_context *context, tulle_status *status);
void world_retry_substep(step_context *context, tulle_status *status);
bool world_retry_step(step_context *context, tulle_status *status);
/* Whether the step has passed, or is pinched. */
bool world_is_step_over(const step_context *context);
/* Whether the substep is still long enough that half of it may be tried instead; whether that may
 * be for a gain of energy. */
bool world_may_halve(const step_context *context);
bool world_may_refuse_gain(const step_context *context);

/* ---- undo.c: a step works on a copy of the state, all or nothing ---- */

/* Keeps what undo puts back. */
tulle_status world_keep_start(tulle_world *world, tulle_error *error);
/* Makes the copy on which the step works. */
tulle_status world_copy_start(tulle_world *world, tulle_error *error);
/* Undoes what a step changed outside its copy. */
void world_undo_step(tulle_world *world);
/* Puts the copy in the place of the state. */
tulle_status world_swap_states(tulle_world *world, tulle_error *error);

/* ---- what stages ask ---- */

/* carriers.c: before the first substep; once targets are set; after a substep is accepted. The maps
 * lie in the world's scratch arena. */
tulle_status world_begin_carriers(step_context *context);
void world_compute_carriers(step_context *context);
void world_follow_carriers(step_context *context);

/* energy_balance.c: whether a substep must not gain energy. Other integrators than implicit Euler
 * let it go up and down about its value, and the paper's response has no such rule. */
bool world_keeps_balance(const step_context *context);
/* Whether the gain is so large, or the solve so lost, that the substep is better tried at half its
 * length. */
bool world_gains_too_much(const step_context *context);

/* energy_balance.c: takes a solution that stretches cloth by far more energy than there is back on
 * the way to it, and sets `guess`. From then on so it takes all of the substep that have more. */
tulle_status world_temper_solution(step_context *context);

/* energy_balance.c: the kinetic energy of vertices that can move with which the substep may end at
 * context->end, without the work of what rows hold them by. */
typedef struct kinetic_limit {
    double start;  /* [J] kinetic energy at the start */
    double energy; /* [J] */
} kinetic_limit;
tulle_status world_compute_kinetic_limit(step_context *context, kinetic_limit *limit);

/* Energies of the cloths at `positions` with the velocities of context->state. The elastic ones are
 * those in *elastic where they are known, else they are measured into it. */
tulle_status world_measure_cloths(const step_context *context, const double *positions,
                                  known_elastic *elastic, cloth_energies *energies);

/* Sets `gain`: the energy that the substep, ending with u at `end`, has beyond what it may and a
 * small slack; 0 where it need not keep a balance. */
tulle_status world_measure_gain(step_context *context);

/* stretch.c: ends the substep where edges, or yarns of woven cloth, grow by over `most` times what
 * is too much, from its start to context->end: then the solve has not carried a hard landing into
 * the cloth, and vertices stop while their neighbours fly on. */
tulle_status world_judge_stretch(step_context *context, double most);
/* stretch.c: an error where an edge jumps to over four times its rest length, which is no motion of
 * cloth. */
tulle_status world_check_torn(const step_context *context);

/* pinch.c: whether obstacles or pins still follow their script, so that they may be what blocks. */
bool world_is_script_moving(const step_context *context);
/* pinch.c: cloth and bodies stand still for the rest of the step. */
void world_stand_still(step_context *context);
/* pinch.c: what to do when the step is pinched or torn; see tulle_on_pinch. OK means: undo the step
 * and make it anew with the holds and releases of context->state. */
tulle_status world_handle_pinch(step_context *context);
/* pinch.c: at the end of a step: what is held back no more, and what the world says of it. */
tulle_status world_end_pinch(step_context *context);
/* pinch_sides.c: whether the step, done and measured, tears cloth between obstacles that come
 * nearer to each other; where, into torn_place. */
bool world_tears_squeezed(step_context *context);

/* choose_damping.c: the damping of the integrator in this step, see force_options. */
double world_choose_damping(const step_context *context);

#endif
