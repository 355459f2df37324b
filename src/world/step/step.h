/* world/step/step.h - what one (sub)step carries from stage to stage. */
#ifndef TULLE_WORLD_STEP_STEP_H
#define TULLE_WORLD_STEP_STEP_H

#include "contact/commit/commit_safely.h"
#include "contact/commit/resolve_impacts.h"
#include "contact/response.h"
#include "contact/rows/gather_contacts.h"
#include "contact/solve/solve_motion.h"
#include "world/world_state.h"

/* Stage numbers, in the order of tulle_stage_name. */
typedef enum stage {
    STAGE_COMPUTE_FORCES,
    STAGE_GATHER_CONTACTS,
    STAGE_SOLVE_MOTION,
    STAGE_PROPOSE_PATHS,
    STAGE_BUILD_PATCHES,
    STAGE_BUILD_TREES,
    STAGE_FIND_PAIRS,
    STAGE_TEST_PAIRS,
    STAGE_SELECT_ADMISSIBLE,
    STAGE_RESOLVE_IMPACTS,
    STAGE_COMMIT_SAFELY,
    STAGE_UPDATE_CONTACTS
} stage;

/* Cloth vertices at which a step was blocked or tears cloth. */
typedef struct blocked_place {
    bool is_pair; /* the vertices are a pair that blocked, of this kind */
    feature_kind kind;
    uint32_t vertices[4];
    uint32_t surface; /* a cloth, or the surface of the first vertex */
    vec3 position;    /* [m] of one of them */
} blocked_place;

typedef struct step_context {
    tulle_world *world;
    world_motion_state *state; /* moved on by each substep */
    double time_step;          /* [s] of this substep */
    double shortest_step;      /* [s] a substep this long is taken whatever it stretches */
    bool is_rejected; /* paths give cloth too much energy or stretch, or turn too far: try shorter
                       * ones */
    bool has_gained;  /* they give it far more energy than there is */
    double energy_scale;  /* [J] at work in the substep: what moves, and what gravity gives */
    bool is_cut_by_turns; /* the substep is shorter than it would be else, for bodies turn in it */
    double turn_time;     /* [s] what the next may last, for in this one they turn too far */
    bool has_woken;       /* sleepers woke by its contacts: it is made anew */
    stored_contact *resting; /* of the store, of pairs that have no rows */
    size_t resting_count;
    double damping;           /* of the integrator, see force_options */
    double passed;            /* [s] of it that passed, set by the commit */
    uint32_t substep_limit;   /* substeps after which the step counts as pinched */
    int crawl_count;          /* substeps in a row that hardly moved */
    int retry_count;          /* how often the step was stuck and went on with shorter substeps */
    bool is_rest_skipped;     /* nothing more can move in this step */
    bool is_script_frozen;    /* scripted vertices stand still (on_pinch: slow) */
    bool is_pinched;          /* the step is to be undone, see world_handle_pinch ... */
    bool is_torn;             /* ... for it tears cloth ... */
    blocked_place torn_place; /* ... here */
    int pinch_level;          /* how much the step holds back already */
    double hold_left[HOLDS_MAX];                 /* [m] that each hold keeps from its script */
    char pinch_message[WORLD_MESSAGE_BYTES / 2]; /* of the pinch found last */
    contact_scene scene;
    paper_rules paper; /* of the scene, by the paper's response */
    motion_state dynamics;
    force_terms terms; /* of `dynamics`, where there is room for them */
    pair_source source;
    double *mean_velocity;   /* [m/s] u, all vertices */
    double lost_energy;      /* [J] that this substep loses; only with bodies */
    bool has_settled;        /* the impulses of the last solve have, and it did not end early */
    double *guess;           /* [m/s] u about which springs are linearised */
    double *predicted, *end; /* [m] all vertices */
    elastic_energies end_elastic; /* of the cloths at `end`, where has_end_elastic */
    bool has_end_elastic;
    double *bounds;        /* [m] ends of the paths that the candidate pairs were found for */
    double *certified_end; /* [m] ends of the paths that the patches are certified for */
    commit_report commit;
    commit_report blocked;    /* the last commit of the step that named a blocking pair */
    contact_times nested;     /* [s] since the last end of a stage */
    double search_seconds;    /* [s] the same for stages 5 to 7 */
    affine_map *carrier_maps; /* per surface, of this substep */
    const affine_map **carriers;
    double step_start;       /* [s] of the whole step ... */
    double whole_step;       /* [s] ... and its length */
    affine_map *progress;    /* per obstacle, from there to where it is */
    affine_map *script_maps; /* per obstacle, from there to the end of the substep */
    tulle_step_report *report;
    tulle_error *error;
} step_context;

/* substep.c: moves context->state on by as much of time_step as is safe, through all stages. */
tulle_status world_advance(step_context *context);

/* Adds the time since *start to a stage, but for that of stages inside it, and restarts the clock.
 */
void world_end_stage(step_context *context, stage number, double *start);

/* carriers.c: before the first substep; once targets are set; after a substep is accepted. The maps
 * lie in the world's scratch arena. */
tulle_status world_begin_carriers(step_context *context);
void world_find_carriers(step_context *context);
void world_follow_carriers(step_context *context);

/* solve_step.c: stage 1, about x0 or the guess. */
tulle_status world_compute_forces(step_context *context);

/* solve_step.c: stages 3, 4 and 10, after stage 1; as often as the balance of energy wants it. */
tulle_status world_solve_step(step_context *context, impact_report *impacts, double *start);
/* Whether the substep, ending with u at context->end, gives the cloth far more energy than there
 * is. */
tulle_status world_check_gain(step_context *context, bool *has_gained);

/* energy_balance.c: the kinetic energy of vertices that can move with which the substep may end at
 * context->end, without the work of what rows hold them by. */
typedef struct kinetic_limit {
    double start;  /* [J] kinetic energy at the start */
    double energy; /* [J] */
} kinetic_limit;
tulle_status world_find_kinetic_limit(step_context *context, kinetic_limit *limit);

/* Energies of the cloths in context->state; the elastic ones are measured once for the same
 * positions. */
tulle_status world_measure_state(step_context *context, cloth_energies *energies);

/* Energy [J] that the substep, ending with u at context->end, has beyond what it may and a small
 * slack. */
tulle_status world_measure_gain(step_context *context, double *gain);

/* stretch.c: largest growth of an edge's stretch, beyond a stretch that cloth may have, from the
 * start of the substep to context->end. */
double world_measure_stretch_growth(const step_context *context);
/* stretch.c: whether an edge jumps to over WORLD_TORN_STRETCH times its rest length, which is no
 * motion of cloth. */
#define WORLD_TORN_STRETCH 4.0
bool world_is_torn(const step_context *context);

/* pinch.c: whether obstacles or pins still follow their script, so that they may be what blocks. */
bool world_is_script_moving(const step_context *context);
/* pinch.c: cloth and bodies stand still for the rest of the step. */
void world_skip_rest(step_context *context);
/* pinch.c: what to do when the step is_pinched; see tulle_on_pinch. OK means: undo the step and
 * make it anew with the holds and releases of context->state. */
tulle_status world_handle_pinch(step_context *context);
/* pinch.c: at the end of a step: what is held back no more, and what the world says of it. */
tulle_status world_end_pinch(step_context *context);
/* pinch_sides.c: whether the step, done and measured, tears cloth between obstacles that come
 * nearer to each other; where, into torn_place. */
bool world_tears_squeezed(step_context *context);

/* choose_damping.c: the damping of the integrator in this step, see force_options. */
double world_choose_damping(const step_context *context);

#endif
