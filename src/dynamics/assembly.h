/* dynamics/assembly.h - what the files of the forces share while the linear system is filled.
 *
 * A force has a function fill_...: its elements compute what they bring, in parallel, each into a
 * slot of its own. Then one vertex adds the slots around it to its row, in a fixed order: see
 * row_kernel.h. Arrays of slots end with one more, which is read together with the last. */
#ifndef TULLE_DYNAMICS_ASSEMBLY_H
#define TULLE_DYNAMICS_ASSEMBLY_H

#include "dynamics/bending.h"
#include "dynamics/compute_forces.h"
#include "dynamics/hysteresis.h"
#include "dynamics/spring.h"
#include "dynamics/wind.h"

/* Items of a chunk, about 50 microseconds of work each. */
enum {
    SPRINGS_PER_CHUNK = 1024,
    ELEMENTS_PER_CHUNK = 512,
    TRIANGLES_PER_CHUNK = 1024,
    VERTICES_PER_CHUNK = 256,
    HINGES_PER_CHUNK = 512
};

typedef struct assembly {
    const cloth_model *model;
    const motion_state *state;
    const environment *surroundings;
    linear_system *system;
    arena *scratch;
    int threads;
    double alpha, beta, gamma, share; /* of the table in compute_forces.c; share is its c */
    bool has_wind, is_bdf2;
    bool is_renewed;                /* the terms are complete, and so are the forces */
    const double *start_velocities; /* w of that table, 3 a vertex */
    double *later_starts;           /* the same with BDF2; else null, and w is v0 */
    double *guessed_positions;      /* x0 + h guess, 3 a vertex; null where nothing needs it */
    force_terms terms;              /* those of the state, or slots of this stage alone */
    /* What the pass over the vertices that runs brings to the rows. */
    bool begins_rows; /* the matrix; gravity, air damping, springs */
    bool ends_rows;   /* bending and its damping, wind; the right-hand side */
    /* Slots of springs. */
    symmetric3 *spring_blocks; /* alpha D + beta K, negated, of the first end by the first end */
    vec3 *spring_forces, *spring_sources; /* f and f - D w at the first end; no f when renewed */
    /* Slots of elements, by 3 * triangle + corner or edge: see membrane_motion. */
    symmetric3 *membrane_blocks;
    vec3 *membrane_forces, *membrane_sources;
    /* Slots of bending. */
    vec3 *hinge_vectors;                  /* c [m]; see cloth_hinge */
    vec3 *hinge_rates;                    /* of c [m/s]; null without bending damping */
    vec3 *hinge_deviations;               /* from rest; hinge_vectors where all are flat at rest */
    bend_damping_response *bend_dampings; /* by triangle; null without bending damping */
    slider_slots sliders;                 /* of hysteresis; nulls without any */
    /* Slots of the wind. */
    vec3 *triangle_forces; /* per corner; null when renewed */
} assembly;

/* Gives slots room from `scratch` unless they have some. False: no memory. */
static inline bool provide_slots(vec3 **slots, size_t count, arena *scratch) {
    if (!*slots) *slots = ARENA_NEW(scratch, vec3, count);
    return *slots != NULL;
}

/* Each false: no memory. */
bool fill_springs(assembly *work);
bool fill_elements(assembly *work);
bool fill_bending(assembly *work);
bool fill_wind(assembly *work);

/* hysteresis_forces.c: room that outlives the passes; then what sliders bring, of shear to the
 * slots of elements, of bending to slots of their own; then those of bending to the rows of a range
 * of vertices: to the matrix once its rows are begun, and to the sums before they end. */
bool provide_slider_slots(assembly *work);
bool fill_sliders(assembly *work);
void add_slider_blocks(const assembly *work, size_t begin, size_t end);
void gather_sliders(const assembly *work, size_t begin, size_t end);

/* bending.c: gives the terms of bending room, as provide_slots does. */
bool provide_bending_terms(const cloth_model *model, force_terms *terms, arena *scratch);

#endif
