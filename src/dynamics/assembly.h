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
    PATCHES_PER_CHUNK = 512, /* a multiple of PATCH_LANES */
    HINGES_PER_CHUNK = 512
};

/* Of vertices, with a fourth number behind each three that means nothing. */
typedef struct padded_vertices {
    double *positions, *velocities; /* x0, v0 */
    double *bent;                   /* x0 less the model's shape; may be the positions */
    double *starts;                 /* w of the table in compute_forces.c; may be the velocities */
    double *guess;                  /* null: there is none */
} padded_vertices;

typedef struct assembly {
    const cloth_model *model;
    const cloth_start *state;
    const environment *surroundings;
    linear_system *system;
    arena *scratch;
    int threads;
    double alpha, beta, gamma, share; /* of the table in compute_forces.c; share is its c */
    bool has_wind, is_bdf2;
    bool is_renewed;           /* the terms are complete */
    bool finds_forces;         /* sums are f(x0, v0): w is zero, and the matrix is of no use */
    double *sums;              /* the right-hand side, or these forces */
    double *guessed_positions; /* x0 + h guess, 3 a vertex; null where nothing needs it */
    padded_vertices padded;
    force_terms terms; /* those of the state, or slots of this stage alone */
    /* Slots of patches (kernels/drag_kernel.c), by 3 * triangle + corner or edge; null without
     * wind and damping of bending, and without the latter. */
    vec3 *corner_sources, *far_sources;
    vec3 *hinge_forces; /* [N] 4 a hinge; null where all are flat at rest, or nothing bends */
    /* Slots of springs. A block is minus that of both ends in the system. */
    symmetric3 *spring_blocks;
    vec3 *spring_sources; /* f - D w at the first end */
    /* Slots of elements, by 3 * triangle + corner or edge: see membrane_motion. Blocks end with a
     * zero one. */
    symmetric3 *membrane_blocks;
    vec3 *membrane_sources;
    slider_slots sliders; /* of hysteresis; nulls without any */
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
bool fill_air(assembly *work);

/* hysteresis_forces.c: room that outlives the passes; then what sliders bring, of shear to the
 * slots of elements, of bending to slots of their own; then, as a body of parallel_for, those of
 * bending to the filled rows of vertices. */
bool provide_slider_slots(assembly *work);
bool fill_sliders(assembly *work);
void add_sliders(void *context, size_t begin, size_t end, size_t chunk, int worker);

#endif
