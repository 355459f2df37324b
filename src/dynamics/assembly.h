/* dynamics/assembly.h - what the files of the forces share while the linear system is filled.
 *
 * A force has two functions. fill_...: its elements compute what they bring, in parallel, each into
 * a slot of its own. gather_...: one vertex adds the slots around it to its row, in a fixed order.
 * compute_forces.c calls both. */
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
    bool is_renewed;           /* the terms are complete, and so are the forces */
    double *start_velocities;  /* w of that table, 3 a vertex */
    double *guessed_positions; /* x0 + h guess, 3 a vertex; null without a guess */
    force_terms terms;         /* those of the state, or slots of this stage alone */
    /* What the pass over the vertices that runs brings to the rows. */
    bool begins_rows; /* the matrix; gravity, air damping, springs */
    bool ends_rows;   /* bending and its damping, wind; the right-hand side */
    /* Slots of springs. */
    symmetric3 *spring_blocks; /* alpha D + beta K, negated, of the first end by the first end */
    vec3 *spring_forces, *spring_sources; /* f and f - D w at the first end; no f when renewed */
    membrane_slot *membrane_slots;        /* of elements, by triangle; null with springs */
    /* Slots of bending. */
    vec3 *hinge_deviations;
    bend_damping_response *bend_dampings; /* by triangle; null without bending damping */
    slider_slots sliders;                 /* of hysteresis; nulls without any */
    /* Slots of the wind. */
    vec3 *triangle_forces; /* per corner; null when renewed */
} assembly;

/* What a vertex gathers. */
typedef struct vertex_sum {
    vec3 force, source; /* f and f - D w */
} vertex_sum;

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
 * slots of elements, of bending to slots of their own and to the matrix. */
bool provide_slider_slots(assembly *work);
bool fill_sliders(assembly *work);
void gather_sliders(const assembly *work, uint32_t vertex, vertex_sum *sum);

/* What springs or elements bring to the block of both ends of an edge. */
symmetric3 gather_edge_block(const assembly *work, uint32_t edge);
void gather_elements(const assembly *work, uint32_t vertex, vertex_sum *sum);
void gather_bending(const assembly *work, uint32_t vertex, vertex_sum *sum);
void gather_wind(const assembly *work, uint32_t vertex, vertex_sum *sum);

/* bending.c: gives the terms of bending room, as provide_slots does. */
bool provide_bending_terms(const cloth_model *model, force_terms *terms, arena *scratch);
/* bending_damping.c: damping in a range of triangles, a body of parallel_for; and what a vertex
 * gathers of it. */
void fill_bending_damping(void *context, size_t begin, size_t end, size_t chunk, int worker);
void gather_bending_damping(const assembly *work, uint32_t vertex, vertex_sum *sum);

#endif
