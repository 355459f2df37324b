/* dynamics/spring.h - stage 1: the springs along edges. */
#ifndef TULLE_DYNAMICS_SPRING_H
#define TULLE_DYNAMICS_SPRING_H

#include "dynamics/cloth_model.h"

/* A symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz. */
typedef struct symmetric3 {
    double m[6];
} symmetric3;

/* a I + b n n^T */
static inline symmetric3 symmetric3_make(double a, double b, vec3 n) {
    return (symmetric3){{a + b * n.x * n.x, b * n.x * n.y, b * n.x * n.z, a + b * n.y * n.y,
                         b * n.y * n.z, a + b * n.z * n.z}};
}
static inline void symmetric3_add(symmetric3 *a, const symmetric3 *b) {
    for (int i = 0; i < 6; i++) a->m[i] += b->m[i];
}

/* What one spring does at its first end; the second end gets the opposite. */
typedef struct spring_response {
    vec3 elastic_force;   /* [N] tension times n */
    vec3 damping_force;   /* [N] c (n . (v1 - v0)) n */
    double axial, across; /* [N/m] stiffness -df/dx = axial n n^T + across (I - n n^T), unclamped */
    vec3 direction;       /* n, from the first end to the second; zero for a spring of no length */
} spring_response;

/* Tension [N] of a spring that is longer than at rest by `extension` [m]: k e (1 + c e^2), c its
 * stiffening; one that is shorter has k e. */
static inline double spring_get_tension(const cloth_spring *spring, double extension) {
    double const e = extension, more = e > 0.0 ? spring->stiffening * e * e : 0.0;
    return spring->stiffness * e * (1.0 + more);
}
/* [N/m] derivative of the tension */
static inline double spring_get_slope(const cloth_spring *spring, double extension) {
    double const e = extension, more = e > 0.0 ? spring->stiffening * e * e : 0.0;
    return spring->stiffness * (1.0 + 3.0 * more);
}
/* [J] its integral */
static inline double spring_get_energy(const cloth_spring *spring, double extension) {
    double const e = extension, more = e > 0.0 ? spring->stiffening * e * e : 0.0;
    return 0.5 * spring->stiffness * e * e * (1.0 + 0.5 * more);
}

/* Evaluates one spring at positions x and velocities v (the difference v1 - v0 is what counts). */
spring_response spring_evaluate(const cloth_spring *spring, const double *positions,
                                const double *velocities);

/* [J] elastic energy at positions x */
double spring_measure_energy(const cloth_spring *spring, const double *positions);

#endif
