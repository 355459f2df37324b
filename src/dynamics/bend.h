/* dynamics/bend.h - stage 1: bending across edges. */
#ifndef TULLE_DYNAMICS_BEND_H
#define TULLE_DYNAMICS_BEND_H

#include "dynamics/cloth_model.h"

/* d = c - rest_curvature * normal of a hinge [m]; c alone where its sides are folded onto each
 * other. */
vec3 bend_get_deviation(const cloth_hinge *hinge, const double *positions);

/* Forces [N] on the four corners of a hinge: elastic from moment = sum_j couplings_j d_j (row of
 * the hinge), and what damping adds to the moment in both of its triangles [N]. */
void bend_get_forces(const cloth_hinge *hinge, const double *positions, vec3 moment,
                     vec3 damping_moment, vec3 forces[4]);

/* Damping in one triangle, part of the force -sum_ab g_a C_ab (g_b . v): g the gradient of n . c_a,
 * n the triangle's normal. */
typedef struct bend_damping_response {
    vec3 moments[3]; /* [N] to the damping moment of the hinge of each edge */
    vec3 forces[3];  /* [N] on the corners, from the turning of n */
} bend_damping_response;

typedef struct bend_damping_input {
    const cloth_bend_damping *damping;
    const uint32_t *corners;
    const cloth_hinge *hinges;            /* of the model */
    const double *positions, *velocities; /* of all vertices */
    const double *masses;                 /* [kg] */
    double time_step;                     /* [s] */
    double triangles_at_a_vertex;         /* most at one of the corners */
} bend_damping_input;
void bend_evaluate_damping(const bend_damping_input *input, bend_damping_response *response);

#endif
