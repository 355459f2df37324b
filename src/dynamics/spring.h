/* dynamics/spring.h - one spring: its law, its response, and the guess about which it is
 * linearised. */
#ifndef TULLE_DYNAMICS_SPRING_H
#define TULLE_DYNAMICS_SPRING_H

#include "dynamics/cloth_model.h"

#include <math.h>
#include <stdbool.h>

/* a I + b n n^T */
static inline symmetric3 symmetric3_make(double a, double b, vec3 n) {
    return (symmetric3){{a + b * n.x * n.x, b * n.x * n.y, b * n.x * n.z, a + b * n.y * n.y,
                         b * n.y * n.z, a + b * n.z * n.z}};
}

/* Difference of the values (3 a vertex) at the second end and at the first. */
static inline vec3 spring_get_difference(const cloth_spring *spring, const double *values) {
    return vec3_sub(vec3_load(values, spring->vertices[1]), vec3_load(values, spring->vertices[0]));
}

/* What one spring does at its first end; the second end gets the opposite. */
typedef struct spring_response {
    vec3 elastic_force;   /* [N] tension times n */
    vec3 damping_force;   /* [N] c (n . (v1 - v0)) n */
    double axial, across; /* [N/m] stiffness -df/dx = axial n n^T + across (I - n n^T), unclamped */
    vec3 direction;       /* n, from the first end to the second; zero for a spring of no length */
} spring_response;

/* Beyond so many stiffening strains a spring is linear again, with the slope that it has there:
 * then the yarns themselves stretch. */
static const double STIFFENING_STRAINS_MAX = 3.0;

/* Tension [N] of a spring that is longer than at rest by `extension` [m], and its derivative and
 * integral: with e the extension, c the stiffening and q = c e^2, k e (1 + q) while stretched. */
typedef struct spring_law {
    double tension; /* [N] */
    double slope;   /* [N/m] */
    double energy;  /* [J] */
} spring_law;
static inline spring_law spring_compute_law(const cloth_spring *spring, double extension) {
    double const k = spring->stiffness, c = spring->stiffening;
    double const most = STIFFENING_STRAINS_MAX * STIFFENING_STRAINS_MAX;
    bool const is_past = extension > 0.0 && c * extension * extension > most;
    double const e = is_past ? STIFFENING_STRAINS_MAX / sqrt(c) : extension;
    double const more = e > 0.0 ? c * e * e : 0.0, beyond = extension - e;
    spring_law law = {.tension = k * e * (1.0 + more),
                      .slope = k * (1.0 + 3.0 * more),
                      .energy = 0.5 * k * e * e * (1.0 + 0.5 * more)};
    law.energy += (law.tension + 0.5 * law.slope * beyond) * beyond;
    law.tension += law.slope * beyond;
    return law;
}

/* [stiffening strains] How far a guess may exceed the start. With 1 or 2, landings on spikes
 * take more solves and leave longer edges. */
static const double GUESS_STRAINS = 0.5;
/* Margins for rounding of lengths and of squares of strains. */
static const double GUESS_LENGTH_ROUNDING = 1e-9;
static const double GUESS_STRAIN_ROUNDING = 1e-6;

/* The difference vector about which a spring is linearised: `guess`, shortened to half a
 * stiffening strain beyond what it has at the start, `start`. Guesses can be far off: contact may
 * have stopped a vertex whose neighbours still move. The spring's tangent at such a high tension
 * would push its ends apart, although the spring turns out to be only a little shorter. */
static inline vec3 spring_limit_guess(const cloth_spring *spring, vec3 start, vec3 guess) {
    double const length = vec3_norm(guess);
    /* Few springs are so much longer than at rest. The margins only cost time. */
    double const extension = (1.0 + GUESS_LENGTH_ROUNDING) * length - spring->rest_length;
    bool const may_be_long =
        extension > 0.0 && spring->stiffening * extension * extension >
                               (1.0 - GUESS_STRAIN_ROUNDING) * GUESS_STRAINS * GUESS_STRAINS;
    if (!may_be_long) return guess;
    double const longest =
        fmax(vec3_norm(start), spring->rest_length) + GUESS_STRAINS / sqrt(spring->stiffening);
    return length > longest ? vec3_scale(guess, longest / length) : guess;
}

/* Evaluates a spring with this difference vector, whose ends differ in velocity by `rate`. */
static inline spring_response spring_evaluate(const cloth_spring *spring, vec3 edge, vec3 rate) {
    double const length = vec3_norm(edge);
    /* A spring of no length has no direction and exerts no force. */
    if (!(length > 0.0)) return (spring_response){.axial = spring->stiffness};
    vec3 const n = vec3_scale(edge, 1.0 / length);
    spring_law const law = spring_compute_law(spring, length - spring->rest_length);
    return (spring_response){
        .elastic_force = vec3_scale(n, law.tension),
        .damping_force = vec3_scale(n, spring->damping * vec3_dot(n, rate)),
        .axial = law.slope,
        .across = law.tension / length,
        .direction = n,
    };
}

#endif
