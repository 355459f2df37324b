/* tulle/paper.h - for studies of the method, as in Wong & Baciu 2005: how a world
 * detects, answers contact and solves, how fine a mesh is, what an integrator damps, the patches of
 * the detector. Simulations need none of it. */
#ifndef TULLE_PAPER_H
#define TULLE_PAPER_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a world finds the pairs of features that come near each other. The choices differ in time.
 * With a certificate every choice keeps the promise, and all lead to the same states, bit for bit,
 * but for extreme speeds (docs/method/update_patches.md). */
typedef struct tulle_world_detection {
    tulle_detect_method method; /* trees, with patches or without */
    tulle_detect_cone cone;     /* bound on the normals of a moving triangle, for patches */
    /* [rad] > 0 .. 1.570795, default pi / 4: widest cone in which a patch grows (alpha_max). A
     * certified patch that is merged with another or kept may be wider. */
    double max_angle;
    /* default 1: a search skips only the inside of patches that are proven not to touch themselves.
     * 0: it skips the inside of every patch, as the paper does. This is an exception to the
     * promise, which then holds only for pairs that do not lie within one patch. */
    int has_certificate;
    /* 1: every search grows patches again. 0: patches are kept from step to step and checked again.
     * TULLE_DETECT_PAPER always grows them. */
    int grows_patches_anew;
} tulle_world_detection;

/* How a world answers contact. The safe commit at the end of a step guards both ways alike. */
typedef enum tulle_response {
    TULLE_RESPONSE_COUPLED, /* contact impulses with friction are part of the implicit solve */
    /* Wong & Baciu 2005, 4 and 5.2: forces are projected before the solve, velocities after it,
     * vertex by vertex */
    TULLE_RESPONSE_PAPER
} tulle_response;
/* The velocities that a vertex in contact may have, for TULLE_RESPONSE_PAPER. */
typedef enum tulle_motion_space {
    /* the paper's: the widest circular cone inside the half-spaces of the contacts, which are fixed
     * in space */
    TULLE_MOTION_SPACE_CONE,
    TULLE_MOTION_SPACE_POLYHEDRAL /* the whole intersection of the half-spaces, which move along */
} tulle_motion_space;

/* Choices of method and numbers of the solver. Made by tulle_paper_options_default; the member
 * `paper` of tulle_world_def takes them. Simulations need none of them: tulle_quality says how
 * exact they are. */
typedef struct tulle_paper_options {
    uint32_t cookie;                 /* set by tulle_paper_options_default, checked on use */
    tulle_world_detection detection; /* default: certified patches that are kept */
    tulle_response response;         /* default TULLE_RESPONSE_COUPLED */
    /* default TULLE_MOTION_SPACE_POLYHEDRAL; of TULLE_RESPONSE_PAPER */
    tulle_motion_space motion_space;
    double cg_tolerance;   /* 1e-12 .. 0.1, default 1e-4: relative preconditioned residual */
    int cg_max_iterations; /* 1 .. 1e6, default 5000: limit of a linear solve */
    int solve_rounds;      /* 1 .. 20, default 1: fewest solves of motion and impulses a step */
    int impulse_sweeps;    /* 1 .. 1000, default 10: projected Gauss-Seidel sweeps a round */
    int impact_rounds;     /* 0 .. 100, default 5: rounds of impacts before the rescues */
} tulle_paper_options;
/* What a world has where its def gives no options. */
TULLE_API tulle_paper_options tulle_paper_options_default(void);
/* What a world has: the options of its def, or the default; for null the default. */
TULLE_API tulle_paper_options tulle_world_get_paper_options(const tulle_world *world);

/* How fine the mesh of a cloth is compared with the folds of its fabric. Edges should be at most
 * half the bending length; where cloth curves in two directions at once, as a table cloth does, a
 * third. Coarser cells hold cloth up. */
typedef struct tulle_fineness {
    double mean_edge; /* [m] mean length of the edges between rest positions; 0: not known */
    /* [m] (B / (area density * gravity))^(1/3), B: the smaller bending rigidity of warp and weft;
     * 0: B or gravity is 0. Source: Peirce 1930. */
    double bending_length;
} tulle_fineness;
/* Gives the fineness of a cloth. All zero before the start, for null and for a stale id. */
TULLE_API tulle_fineness tulle_cloth_get_fineness(const tulle_world *world, tulle_cloth_id id);

/* Gives the numerical damping of the world's integrator, without the damping of materials: the
 * damping ratio (1: critical) of a free motion with this `period` [s], solved in steps of
 * `time_step` [s]. For implicit Euler it is about pi time_step / period. 0 if `world` is null or
 * one of the two is not finite and > 0. */
TULLE_API double tulle_world_get_numerical_damping(const tulle_world *world, double time_step,
                                                   double period);

/* Which patches to give. A zeroed struct asks for patches of the present shape. */
typedef struct tulle_patch_options {
    double time_step; /* [s] length of the coming step, 0 .. 1; 0: patches of the present shape */
    double max_angle; /* [rad] alpha_max, > 0 and < pi/2; 0: pi/3 */
    /* 1: the patches that the last step used, whatever the other options say; none before the first
     * step and for methods without patches */
    int is_in_use;
} tulle_patch_options;
/* Finds the patches of a cloth: triangles connected over edges whose normals all stay within
 * max_angle of one axis, while each vertex moves for time_step with its present velocity. Detection
 * skips the pairs within one patch if it also finds a certificate for it (is_in_use); only cones
 * are tested here.
 *
 * `labels` gets a number for each triangle: 1 .. `*patch_count`, or 0 for an isolated triangle,
 * whose own normal turns too far. The world must have started; it does not change. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, not started, options),
 * TULLE_ERROR_OUT_OF_MEMORY.
 *
 * Based on: Wong & Baciu 2005, 3.1 to 3.3, the (zeta, alpha, I)-surfaces.   */
TULLE_API tulle_status tulle_cloth_get_patches(tulle_world *world, tulle_cloth_id id,
                                               const tulle_patch_options *options, uint32_t *labels,
                                               size_t *patch_count, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
