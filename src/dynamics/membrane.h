/* dynamics/membrane.h - the membrane of woven cloth: finite elements, one a triangle.
 *
 * With u and v the directions of warp and weft in the rest shape, F_u and F_v are what becomes of a
 * unit length along them: F_a = sum_i D_ia x_i over the triangle's corners, D constant. From these
 * come the strains e_a = |F_a| - 1 and the shear s = F_u . F_v, and the energy per rest area
 *
 *     psi_u(e_u) + psi_v(e_v) + psi_s(s) + c e_u e_v.
 *
 * Each psi is that of a membrane_curve. Yarns carry what is along them and shear what turns them
 * against each other, so the constants of a tensile test and of a shear test enter as they are. A
 * factor on the stiffness of a triangle multiplies its energy, as more area would. */
#ifndef TULLE_DYNAMICS_MEMBRANE_H
#define TULLE_DYNAMICS_MEMBRANE_H

#include "math/kernel_target.h"
#include "math/vec3.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Tension by strain e: k e while slack; taut, k e (1 + (e / knee)^2) up to the limit, and from
 * there on straight, with the slope at the limit. */
typedef struct membrane_curve {
    double stiffness;  /* k [N/m] > 0 */
    double inv_knee2;  /* 1 / knee^2; 0: straight everywhere */
    double limit;      /* > 0 */
    double guess_room; /* how far a guess may go beyond the start, see membrane_kernel.c */
} membrane_curve;

enum { YARN_WARP, YARN_WEFT, YARN_COUNT };

typedef struct membrane_fabric {
    membrane_curve yarns[YARN_COUNT];
    membrane_curve shear; /* the same for both signs of s */
    double coupling;      /* c [N/m]; |c| < the root of the product of the yarns' stiffness */
    double damping;       /* [s] damping over stiffness, of yarns and shear */
} membrane_fabric;

typedef struct membrane_element {
    double gradients[2]
                    [YARN_COUNT]; /* [1/m] D of corners 1 and 2; D of corner 0 is minus their sum */
    double area;                  /* [m^2] at rest, times the factor on its stiffness */
    uint32_t corners[3], fabric;
} membrane_element;

/* A symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz. */
typedef struct symmetric3 {
    double m[6];
} symmetric3;

typedef struct membrane_motion {
    const membrane_element *elements;
    const membrane_fabric *fabrics;
    size_t element_count; /* of fill_membrane alone */
    size_t vertex_count;
    /* Three numbers a vertex; fill_membrane takes four, of which the last means nothing. */
    const double *positions, *velocities; /* x0 [m], v0 [m/s] */
    const double *start_velocities;       /* w [m/s] */
    const double *guess;                  /* [m/s] linearised about x0 + h guess; null: about x0 */
    double time_step;                     /* h [s] */
    double alpha, beta;                   /* of the matrix */
    double mean_share;                    /* the force of the system is so much that at the guess */
    const vec3 *drags;                    /* g by element, see force_terms; null: none */
    /* What elements bring, three of each, with room for a multiple of eight elements. A block is
     * -(alpha (D + g g^T) + beta K) of the two corners of an edge; edge k joins corners k and k
     * + 1. */
    symmetric3 *blocks; /* null: they are not wanted */
    vec3 *sources;      /* [N] on corners, f - D w of the linear system, without drags */
} membrane_motion;

/* A body of parallel_for over elements, whose context is the motion. */
TULLE_DECLARE_KERNEL(void, fill_membrane,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))

/* Of springs or elements that go d from where they are linearised. */
typedef struct way_energies {
    double excess;    /* [J] their energy at the end less the expected one */
    double curvature; /* [J] d . K d of the expected one */
} way_energies;

/* The sums over these elements, which go to x0 + h mean. */
TULLE_DECLARE_KERNEL(way_energies, sum_membrane_excess,
                     (const membrane_motion *motion, const double *mean, size_t begin, size_t end))

/* Of these elements, see cloth_measure_yarn_growth. */
TULLE_DECLARE_KERNEL(double, find_yarn_growth,
                     (const membrane_motion *motion, const double *ends, size_t begin, size_t end))

typedef struct membrane_energy {
    double energy;        /* [J] */
    double max_stretch;   /* largest length over rest length of a yarn */
    size_t overstretched; /* elements with a yarn beyond its limit */
} membrane_energy;
/* Of these elements at x0. */
TULLE_DECLARE_KERNEL(membrane_energy, sum_membrane_energy,
                     (const membrane_motion *motion, size_t begin, size_t end))

#endif
