/* dynamics/bend.h - stage 1: bending across edges. */
#ifndef TULLE_DYNAMICS_BEND_H
#define TULLE_DYNAMICS_BEND_H

#include "dynamics/cloth_model.h"

#include <stdbool.h>

/* d = c - rest_curvature * normal of a hinge [m]; c alone where its sides are folded onto each
 * other. */
vec3 bend_get_deviation(const cloth_hinge *hinge, const double *positions);

/* Force [N] on a corner of a hinge that is flat at rest, from the sum of its moments. */
static inline vec3 bend_get_flat_force(const cloth_hinge *hinge, size_t corner, vec3 moment) {
    return vec3_scale(moment, -hinge->weights[corner]);
}

/* Forces [N] on the four corners of any hinge: elastic from moment = sum_j couplings_j d_j (row of
 * the hinge), and what damping adds to the moment in both of its triangles [N]. */
void bend_get_forces(const cloth_hinge *hinge, const double *positions, vec3 moment,
                     vec3 damping_moment, vec3 forces[4]);

/* Damping in one triangle, part of the force -sum_ab g_a C_ab (g_b . v): g the gradient of n . c_a,
 * n the triangle's normal. */
typedef struct bend_damping_response {
    vec3 normal;       /* n; zero where the triangle is damped by nothing */
    double moments[3]; /* [N] along n, to the damping moment of the hinge of each edge */
    vec3 forces[2];    /* [N] on corners 1 and 2, from the turning of n */
} bend_damping_response;
static inline vec3 bend_get_damping_moment(const bend_damping_response *response, size_t edge) {
    return vec3_scale(response->normal, response->moments[edge]);
}
static inline vec3 bend_get_damping_force(const bend_damping_response *response, size_t corner) {
    if (corner > 0) return response->forces[corner - 1];
    bool const has_any = vec3_norm2(response->normal) > 0.0;
    return has_any ? vec3_scale(vec3_add(response->forces[0], response->forces[1]), -1.0)
                   : (vec3){0.0, 0.0, 0.0};
}

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
