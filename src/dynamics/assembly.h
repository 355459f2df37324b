/* dynamics/assembly.h - what the passes of compute_forces share, and these passes: bodies of
 * parallel_for over an assembly. */
#ifndef TULLE_DYNAMICS_ASSEMBLY_H
#define TULLE_DYNAMICS_ASSEMBLY_H

#include "dynamics/bend.h"
#include "dynamics/compute_forces.h"
#include "dynamics/spring.h"
#include "dynamics/wind.h"

typedef struct coefficients {
    double alpha, beta, gamma, share; /* share: c of the table in compute_forces.c */
} coefficients;

/* All of the stage: inputs, and slots of springs, hinges and triangles. */
typedef struct assembly {
    const cloth_model *model;
    const motion_state *state;
    const environment *surroundings;
    coefficients factor;
    linear_system *system;
    double *start_velocities; /* w of that table, 3 a vertex */
    force_terms terms;        /* those of the state, or slots of this stage alone */
    bool is_renewed;          /* the terms are complete, and so are the forces */
    /* Of the wind. */
    vec3 *triangle_forces; /* per corner; null when renewed */
    /* Of springs. */
    double *guessed_positions; /* x0 + h guess, 3 a vertex; null without a guess */
    symmetric3 *spring_blocks; /* alpha D + beta K, negated, of the first end by the first end */
    vec3 *spring_forces, *spring_sources; /* f and f - D w at the first end; no f when renewed */
    /* Of hinges. */
    vec3 *hinge_deviations;
    bend_damping_response *bend_dampings; /* by triangle; null without bending damping */
    bool has_wind, is_bdf2;
} assembly;

/* assembly_elements.c: slots of a range of springs, hinges or triangles. Hinges are evaluated all
 * and the damping of bending in triangles before any fills its slots, the wind sampled at all
 * vertices before any triangle. */
void assembly_fill_springs(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_evaluate_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_damp_bending(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_fill_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_sample_wind(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_fill_triangles(void *context, size_t begin, size_t end, size_t chunk, int worker);

/* assembly_rows.c: rows of a range of vertices, after all slots of a kind. Until the last pass the
 * forces of the system are those so far, and the right-hand side has their sources, f - D w. */
void assembly_gather_springs(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_gather_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker);
void assembly_finish_rows(void *context, size_t begin, size_t end, size_t chunk, int worker);
/* All of it at once, but the forces, from complete terms and slots of springs. */
void assembly_renew_rows(void *context, size_t begin, size_t end, size_t chunk, int worker);

#endif
