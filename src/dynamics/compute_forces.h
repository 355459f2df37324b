/* dynamics/compute_forces.h - the stage compute_forces: forces at the start of the step and the
 * linear system A u = b of the chosen integrator.
 *
 * The unknown is the same for every integrator: u [m/s], the mean velocity of the step,
 * x1 = x0 + h u, so that contact rows act on u whatever the integrator. Every A is normalised to
 * M + ..., so an impulse J [N s] simply adds to b. */
#ifndef TULLE_DYNAMICS_COMPUTE_FORCES_H
#define TULLE_DYNAMICS_COMPUTE_FORCES_H

#include "base/arena.h"
#include "dynamics/cloth_model.h"

#include <stdbool.h>

/* What compute_forces computes without the guess, wherever the membrane is linearised. */
typedef struct force_terms {
    vec3 *sums;           /* [N] by vertex: f - D w of all forces but the membrane's and sliders' */
    vec3 *air_velocities; /* [m/s] of the air at each vertex; null without gusts */
    vec3
        *triangle_drags; /* g by triangle: D of a corner by a corner is -g g^T; null without wind */
    bool is_complete;
} force_terms;

/* Where the cloth is at the start of the step; arrays of 3 * vertex_count, borrowed. */
typedef struct cloth_start {
    const double *positions;           /* x0 [m] */
    const double *velocities;          /* v0 [m/s] */
    const double *previous_mean;       /* u of the last step [m/s]; null: there was none */
    const double *previous_velocities; /* v at the start of the last step [m/s]; null: none */
    double time_step;                  /* h [s] > 0 */
    double previous_time_step;         /* [s]; 0: none */
    double time;                       /* [s] at the start of the step; gusts depend on it */
    const double *guess;   /* [m/s] springs are linearised about x0 + h guess; null: about x0 */
    const double *plastic; /* of sliders, see hysteresis.h; null: none act */
    force_terms *terms;    /* kept from the first linearisation to the next; null: none are */
} cloth_start;

typedef struct environment {
    vec3 gravity; /* [m/s^2] */
    tulle_wind wind;
} environment;

typedef struct linear_system {
    block_matrix matrix;     /* A [kg] */
    double *right_hand_side; /* b [kg m/s], 3 * vertex_count */
    double *forces;    /* f(x0, v0) [N], 3 * vertex_count, all forces with damping and wind, once
                          force_options.finds_forces asked for them; null without room for forces */
    double force_time; /* [s] b holds force_time times the forces: h for implicit Euler */
    tulle_integrator integrator; /* used: BDF2 falls back to implicit Euler without history */
    double
        *slider_scalars; /* scalars of the matrix with those of sliders; null: no bending has any */
    double share; /* c of the integrator: v1 = (u - (1 - c) v0) / c, with the last u in BDF2 */
    size_t vertex_count, scalar_count;
} linear_system;

/* Allocates a system with the model's pattern, which is borrowed, and room for forces if it
 * has_forces. Values are undefined until compute_forces. */
tulle_status linear_system_build(memory *heap, const cloth_model *model, bool has_forces,
                                 linear_system *system);
void linear_system_destroy(memory *heap, linear_system *system);

/* Fills the system. Bits do not depend on `threads`. BDF2 needs previous_mean,
 * previous_velocities and an unchanged time step.
 *
 * Scratch comes from the arena and is released, except for the state's terms where these are not
 * complete; a steady step makes no heap call. With complete terms, of the same state but for its
 * guess, and of the same surroundings, integrator and damping, only what depends on the guess is
 * computed, and no forces are found.
 *
 * Returns TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. */
typedef struct force_options {
    tulle_integrator integrator;
    int threads;
    double damping;    /* 0 .. 1: from the integrator itself to implicit Euler */
    bool finds_forces; /* system->forces are wanted, which takes as long again */
} force_options;
tulle_status compute_forces(const cloth_model *model, const cloth_start *state,
                            const environment *surroundings, force_options options, arena *scratch,
                            linear_system *system);

/* [bytes] of scratch that the terms of a state take. */
size_t measure_force_terms(const cloth_model *model, const tulle_wind *wind);

/* How far the linear system is from the truth. `springs` is the springs' energy at x0 + h u less
 * the energy that the system expects there; `inertia` is the energy that a step of implicit
 * Euler always takes. If `springs` is larger than `inertia`, the step may feed energy to the
 * cloth. */
typedef struct linear_excess {
    double springs;   /* [J] may be negative */
    double inertia;   /* [J] half of (u - v0) M (u - v0) */
    double curvature; /* [J] d . (M + h^2 K) d of masses and springs by implicit Euler, d being the
                         way from where they are linearised; without a guess K alone counts */
} linear_excess;
tulle_status measure_linear_excess(const cloth_model *model, const cloth_start *state,
                                   const double *mean, int threads, arena *scratch,
                                   linear_excess *excess);
/* 0.05 .. 1: how much of the way from the guess to u lowers the energy of masses and springs most,
 * by implicit Euler. */
double choose_descent(const linear_excess *excess);

/* Work [J] that the wind does on the cloth in a step with the mean velocity u, according to the
 * linear system. */
typedef struct wind_work_options {
    const tulle_wind *wind;
    int threads;
} wind_work_options;
tulle_status measure_wind_work(const cloth_model *model, const cloth_start *state,
                               const double *mean, wind_work_options options, arena *scratch,
                               double *work);

/* The most that a yarn of woven cloth grows from one state to another, as a share of its limit:
 * where it is longer than two fifths of the limit, and than it was. Returns TULLE_OK or
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status cloth_measure_yarn_growth(const cloth_model *model, const double *starts,
                                       const double *ends, int threads, arena *scratch,
                                       double *growth);

/* Velocities v1 at the end of the step from the mean velocity u, of the first `vertex_count`
 * vertices; `mean` and `velocities` may be the same array. Without damping v1 is u for implicit
 * Euler, 2 u - v0 for Crank-Nicolson, and 3/2 u - 1/2 previous u for BDF2; see `share` of
 * linear_system. The integrator is that of linear_system. */
void finish_velocities(const linear_system *system, const cloth_start *state, size_t vertex_count,
                       const double *mean, double *velocities);

typedef struct elastic_energies {
    double stretch, bend; /* [J] */
    double max_stretch;   /* largest length over rest length, of an edge or a yarn */
    size_t overstretched; /* triangles with a yarn beyond its limit; 0 with springs */
} elastic_energies;
typedef struct cloth_energies {
    double kinetic, gravity; /* [J]; gravity is zero at the origin */
    elastic_energies elastic;
} cloth_energies;
typedef struct energy_options {
    vec3 gravity; /* [m/s^2] */
    int threads;
    const double *plastic; /* of sliders, see hysteresis.h; null: they hold no energy */
    bool is_elastic_known; /* `energies` holds the elastic ones, which depend on positions alone */
} energy_options;
/* Energies of a state. Sums run over fixed blocks: bits do not depend on `threads`. Returns
 * TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status compute_energies(const cloth_model *model, const double *positions,
                              const double *velocities, energy_options options, arena *scratch,
                              cloth_energies *energies);

#endif
