/* dynamics/bend.h - stage 1: bending across edges. */
#ifndef TULLE_DYNAMICS_BEND_H
#define TULLE_DYNAMICS_BEND_H

#include "dynamics/cloth_model.h"

/* State of one hinge. */
typedef struct hinge_state {
    vec3 deviation;          /* d = c - rest_curvature * normal [m] */
    double rate;             /* time derivative of normal . c [m/s] */
    vec3 normal;             /* zero where the two sides are folded onto each other */
    vec3 rate_directions[4]; /* gradient of normal . c by the four corners */
} hinge_state;

/* Evaluates a hinge; needs_rate fills rate and rate_directions, which are zero otherwise. */
void bend_evaluate(const cloth_hinge *hinge, const double *positions, const double *velocities,
                   bool needs_rate, hinge_state *state);

/* Forces on the four corners of a hinge: elastic from moment = sum_j couplings_j d_j (row of the
 * hinge), damping from the same sum of rates with damping couplings [N]. */
void bend_get_forces(const cloth_hinge *hinge, const double *positions, const hinge_state *state,
                     vec3 moment, double damping_moment, vec3 forces[4]);

#endif
