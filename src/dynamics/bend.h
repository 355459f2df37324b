/* dynamics/bend.h - stage 1: bending across edges. */
#ifndef TULLE_DYNAMICS_BEND_H
#define TULLE_DYNAMICS_BEND_H

#include "dynamics/cloth_model.h"

#include <stdbool.h>

/* Hinges that a hinge is coupled with and the places of these couplings in the model, itself first.
 * Returns how many there are. */
static inline size_t bend_list_couplings(const cloth_model *model, size_t hinge,
                                         uint32_t hinges[HINGE_COUPLINGS],
                                         size_t places[HINGE_COUPLINGS]) {
    size_t count = 1, place = HINGE_COUPLINGS * hinge;
    hinges[0] = (uint32_t)hinge;
    places[0] = place++;
    for (int side = 0; side < 2; side++) {
        uint32_t const own = model->hinges[hinge].sides[side];
        for (uint32_t edge = own - own % 3; edge < own - own % 3 + 3; edge++) {
            if (edge == own) continue;
            hinges[count] = model->triangle_hinges[edge];
            places[count] = place++;
            if (hinges[count] != TULLE_NONE) count++;
        }
    }
    return count;
}

/* sum_j couplings_j d_j, from the deviations d of all hinges [N]. */
static inline vec3 bend_get_moment(const cloth_model *model, size_t hinge, const vec3 *deviations) {
    uint32_t hinges[HINGE_COUPLINGS];
    size_t places[HINGE_COUPLINGS];
    size_t const count = bend_list_couplings(model, hinge, hinges, places);
    vec3 moment = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < count; k++)
        moment = vec3_add_scaled(moment, deviations[hinges[k]], model->couplings[places[k]]);
    return moment;
}

/* d = c - curvature * normal of a hinge [m]; c alone where its sides are folded onto each other. */
vec3 bend_get_deviation(const cloth_model *model, size_t hinge, const double *positions);

/* Force [N] on a corner of a hinge that is flat at rest, from the sum of its moments. */
static inline vec3 bend_get_flat_force(const cloth_hinge *hinge, size_t corner, vec3 moment) {
    return vec3_scale(moment, -hinge->weights[corner]);
}

/* Forces [N] on the four corners of any hinge: elastic from bend_get_moment, and what damping adds
 * to it in both of its triangles [N]. The model has hinge_rests. */
typedef struct hinge_moments {
    vec3 elastic, damping;
} hinge_moments;
void bend_get_forces(const cloth_model *model, size_t hinge, const double *positions,
                     hinge_moments moments, vec3 forces[4]);

/* Damping in one triangle, part of the force -sum_ab g_a C_ab (g_b . v): g the gradient of n . c_a,
 * n the triangle's normal. */
typedef struct bend_damping_response {
    vec3 normal;       /* n; zero where the triangle is damped by nothing */
    double moments[3]; /* [N] along n, to the damping moment of the hinge of each edge */
} bend_damping_response;
static inline vec3 bend_get_damping_moment(const bend_damping_response *response, size_t edge) {
    return vec3_scale(response->normal, response->moments[edge]);
}
/* On a corner, from those on corners 1 and 2. */
static inline vec3 bend_get_damping_force(const vec3 forces[2], size_t corner) {
    return corner > 0 ? forces[corner - 1] : vec3_neg(vec3_add(forces[0], forces[1]));
}

typedef struct bend_damping_input {
    const cloth_model *model;
    size_t triangle;
    const double *positions, *velocities; /* of all vertices */
    double time_step;                     /* [s] */
    double triangles_at_a_vertex;         /* most at one of the corners */
} bend_damping_input;
/* The response, and forces [N] on corners 1 and 2 from the turning of n. */
void bend_evaluate_damping(const bend_damping_input *input, bend_damping_response *response,
                           vec3 forces[2]);

#endif
