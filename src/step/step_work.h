/* step/step_work.h - the tools of a step, which need not be kept: trees, patches, pairs, rows, the
 * linear system, scratch memory. It may be dropped between two steps. */
#ifndef TULLE_STEP_STEP_WORK_H
#define TULLE_STEP_STEP_WORK_H

#include "base/arena.h"
#include "base/stop.h"
#include "contact/commit/commit_safely.h"
#include "contact/contact_types.h"
#include "contact/response.h"
#include "contact/solve/solve_motion.h"
#include "detect/patches/kept_patches.h"
#include "detect/queries/query_trees.h"
#include "detect/trees/broad_phase.h"
#include "dynamics/compute_forces.h"
#include "math/nested_aggregates.h"
#include "step/findings.h"
#include "step/lag/lag_work.h"
#include "step/motion_state.h"
#include "step/step_model.h"
#include "tulle/world.h"

/* A rest of the step under this share of it is rounding, and no substep follows. */
static const double REMAINDER_SHARE = 1e-9;

/* The motion of scripted obstacles as affine maps. */
typedef struct carrier_work {
    affine_map *maps;        /* per surface, of this substep */
    const affine_map **used; /* per surface; null: it has none */
    affine_map *progress;    /* per obstacle, from the start of the step to where it is */
    affine_map *script;      /* per obstacle, from there to the end of the substep */
} carrier_work;

/* The substep that runs, or ran last. Its arrays lie in the scratch arena. */
typedef struct substep {
    double time_step; /* [s] its length */
    double passed;    /* [s] of it that passed, set by commit_safely */

    /* input of the stages */
    contact_scene scene;
    tie_spring *springs; /* ties that pull, in the order of the state's ties */
    size_t spring_count;
    paper_rules paper; /* of the scene, by the paper's response */
    cloth_start dynamics;
    force_terms terms; /* of `dynamics`, if there is memory for them */
    double damping;    /* of the integrator, see force_options */

    /* results of the stages */
    double *predicted;         /* [m] predict_paths: ends of the paths to expect, all vertices */
    double *bounds;            /* [m] find_pairs: ends of the paths that the pairs are for */
    double *certified_end;     /* [m] update_patches: ends that the patches are certified for */
    double *guess;             /* [m/s] u about which springs are linearised */
    double *mean_velocity;     /* [m/s] solve_motion: u of all vertices */
    double *end;               /* [m] solve_motion: ends x0 + h u of the paths */
    known_elastic end_elastic; /* of the cloths at `end` */
    double gain;             /* [J] energy by which the paths exceed the limit and a small slack */
    double energy_scale;     /* [J] energy at work in the substep: of motion, and of the fall */
    double lost_energy;      /* [J] that the substep loses; only with bodies */
    stored_contact *resting; /* contacts of the store whose pairs have no rows */
    size_t resting_count;
} substep;

/* Hears of each frame of an obstacle that was read; `positions` are null if reading failed. */
typedef struct frame_listener {
    void (*tell)(void *context, size_t obstacle, uint32_t frame, const double *positions,
                 tulle_status status); /* null: nobody listens */
    void *context;
} frame_listener;

/* Cloth vertices and triangles of sleepers; null if none may sleep. */
typedef struct idle_marks {
    uint8_t *vertices, *triangles;
    size_t vertex_count, triangle_count;
} idle_marks;

typedef struct step_work {
    memory *heap;
    const motion_state *start; /* the state at the start of the step */
    int threads;
    const tulle_tasks *tasks;     /* of the host, or null: threads of the library */
    stop_poll stop;               /* of the caller */
    tulle_step_progress progress; /* of the step that is under way */
    arena scratch;

    surface_range *surfaces; /* some may be absent, asleep or bodies now */
    surface_set set;
    linear_system system;
    nested_aggregates *aggregates; /* preconditioner of the solve; null for small cloth */
    broad_phase *broad;
    kept_patches *patches;   /* null for methods without */
    patch_rules patch_rules; /* set by the start, but for keeps_all */
    double hold_reach;       /* [m] with which patches hold for the paths of stages 8 and 9 */

    query_trees queries; /* of `start`, when has_queries */
    bool has_queries;
    ARRAY(uint64_t) ignored_keys; /* of the pairs that the world ignores, ascending */

    /* of the step that runs, or ran last */
    double whole_step; /* [s] its length */
    double step_end;   /* [s] time at its end */
    tulle_step_report *report;
    tulle_error *error;   /* for readers of frames */
    step_finding failure; /* why it fails, if the status alone does not say it */
    step_finding broken;  /* attachments */
    frame_listener frames;
    uint8_t *is_fixed;             /* cloth vertices: pinned */
    double *active_inverse_masses; /* [1/kg] 0 where pinned */
    double *targets;               /* [m] where scripted vertices go */
    pair_list pairs;
    ARRAY(unsigned char) kept_patch_bytes; /* the patches at its start */
    carrier_work carriers;
    lag_work lag;

    /* of the substep that runs, or ran last */
    substep sub;
    row_list rows;
    idle_marks idle;
} step_work;

#endif
