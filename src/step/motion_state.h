/* step/motion_state.h - the state, which a step replaces by its working copy when it succeeds. */
#ifndef TULLE_STEP_MOTION_STATE_H
#define TULLE_STEP_MOTION_STATE_H

#include "contact/rows/contact_store.h"
#include "dynamics/compute_forces.h"
#include "math/quaternion.h"
#include "step/motion.h"

/* How an obstacle with a body moves. */
typedef enum body_state { BODY_SCRIPTED, BODY_FREE, BODY_SLEEPS } body_state;

/* What a step knows of a body, apart from its slots (bodies.h). Plain data without padding: saved
 * and hashed as bytes. */
typedef struct body_rest {
    uint32_t state;    /* body_state */
    uint32_t group;    /* lowest of the bodies with which it fell asleep */
    double quiet_time; /* [s] for which it has been slow; while it sleeps, for which it has slept */
    double force[3];   /* [N] of cloth on it when it fell asleep */
    double torque[3];  /* [N m] of that force about the body's centre */
    double impulse[3]; /* [N s] of all its contacts in the last substep before it fell asleep */
    double moment[3];  /* [N m s] of these impulses about the body's centre */
} body_rest;

/* What a step knows of the sleep of a cloth (cloth_sleep.h). Plain data without padding: saved and
 * hashed as bytes. */
typedef struct cloth_rest {
    uint64_t is_asleep; /* 0 or 1 */
    double quiet_time; /* [s] for which it has been slow; while it sleeps, for which it has slept */
    double slept_from; /* [s] start of the step in which it fell asleep; 0 while awake */
} cloth_rest;

/* A place at which a step was pinched; what follows a script around it waits (lag.h). Plain data
 * without padding: saved and hashed as bytes. */
typedef struct still_place {
    double position[3]; /* [m] */
    double radius;      /* [m] may be infinite */
    int32_t wait;       /* steps for which it stands still in all */
    int32_t waiting;    /* that are left; below 0: it is remembered */
} still_place;
enum { STILL_PLACES = 16 };

/* A vertex of cloth that an attachment holds (ties.h). Plain data without padding: saved and hashed
 * as bytes. It describes what holds the vertex: a place over the triangle of `corners`, or, if
 * these are TULLE_NONE, `point`. */
typedef struct world_tie {
    uint32_t number;             /* of the attachment, from 1 */
    uint32_t order, order_count; /* of the vertex in its def, of how many */
    uint32_t vertex;             /* in the world's numbering, as corners are */
    uint32_t corners[3];         /* of a triangle of another surface or of the same cloth */
    uint32_t reserved;           /* 0 */
    double weights[3];           /* barycentric coordinates of the vertex' foot */
    double height;               /* [m] over the triangle */
    double point[3];             /* [m] */
    double stiffness;            /* [N/m] INFINITY: rigid */
    double break_force;          /* [N] */
    double release_time;         /* [s] */
    double force[3];             /* [N] on the vertex in the last substep */
} world_tie;

/* Elastic energies of the cloths, measured once for the same positions. */
typedef struct known_elastic {
    elastic_energies energies;
    bool is_known;
} known_elastic;

/* What a step replaces; there are two, swapped when a step succeeds. */
typedef struct motion_state {
    double *positions;  /* [m] all vertices */
    double *velocities; /* [m/s] all vertices */
    /* [m/s] all vertices; null without BDF2, which alone reads them */
    double *previous_mean;       /* mean velocity u of the last step */
    double *previous_velocities; /* at the start of the last step */
    double previous_time_step;   /* [s] of that step; 0: none, or it was shortened */
    double lost_energy;          /* [J] in the last substep; 0 without bodies */
    known_elastic elastic;       /* of the cloths at `positions`; not saved */
    double *plastic;             /* of sliders (hysteresis.h): world->plastic_count */
    double time;                 /* [s] */
    uint64_t step_count;         /* that led here */
    uint8_t *is_present;         /* per obstacle */
    uint8_t *particles;          /* particle_state of particle_count vertices */
    body_rest *rests;            /* per body */
    cloth_rest *cloth_rests;     /* cloth_rest_count */
    double *drive_forces;        /* [N], [N m] 6 per body: of the last substep; not saved */
    motion_pose *poses;          /* of pose_count obstacles that are driven as a whole */
    still_place still[STILL_PLACES];
    size_t still_count;
    double *lags;              /* [m] of lag_vertex_count vertices, see lag.h */
    double *largest_lags;      /* [m] per obstacle; 0: its lags are zero. Not saved */
    ARRAY(world_tie) ties;     /* by number of attachment, then order */
    uint32_t attachment_count; /* that the world ever had */
    contact_store contacts;
} motion_state;

enum { STATE_VECTORS_MAX = 4 };
/* The vectors over all vertices that a state has, and how many they are. */
static inline size_t step_list_vectors(const motion_state *state,
                                       double *vectors[STATE_VECTORS_MAX]) {
    vectors[0] = state->positions;
    vectors[1] = state->velocities;
    vectors[2] = state->previous_mean;
    vectors[3] = state->previous_velocities;
    return state->previous_mean ? 4 : 2;
}

#endif
