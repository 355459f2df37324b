/* dynamics/spring.c - springs along the edges, with damping along the spring. They are linear while
 * short; stretched by a share s of their length they pull twice, by 2 s five times as hard as
 * linear ones would: yarns straighten and jam.
 *
 * Based on: Provot, Deformation constraints in a mass-spring model, 1995; Choi, Ko, Stable but
 * responsive cloth, 2002 (the stiffness across a compressed spring is dropped, see
 * compute_forces.c). The derivative of the damping force with respect to positions is not used. */
#include "dynamics/spring.h"

/* How far beyond the start a guess is believed [stiffening strains]: landings on spikes take more
 * solves and leave longer edges with 1 and 2. */
static const double GUESS_STRAINS = 0.5;

vec3 spring_limit_guess(const cloth_spring *spring, vec3 start, vec3 guess) {
    if (!(spring->stiffening > 0.0)) return guess;
    double const length = vec3_norm(guess), longest = fmax(vec3_norm(start), spring->rest_length) +
                                                      GUESS_STRAINS / sqrt(spring->stiffening);
    return length > longest ? vec3_scale(guess, longest / length) : guess;
}

spring_response spring_evaluate_edge(const cloth_spring *spring, vec3 edge, vec3 rate) {
    double const length = vec3_norm(edge);
    /* A spring of no length has no direction and exerts no force. */
    if (!(length > 0.0)) return (spring_response){.axial = spring->stiffness};
    vec3 const n = vec3_scale(edge, 1.0 / length);
    spring_law const law = spring_get_law(spring, length - spring->rest_length);
    return (spring_response){
        .elastic_force = vec3_scale(n, law.tension),
        .damping_force = vec3_scale(n, spring->damping * vec3_dot(n, rate)),
        .axial = law.slope,
        .across = law.tension / length,
        .direction = n,
    };
}

spring_response spring_evaluate(const cloth_spring *spring, const double *positions,
                                const double *velocities) {
    size_t const a = spring->vertices[0], b = spring->vertices[1];
    return spring_evaluate_edge(spring, vec3_sub(vec3_load(positions, b), vec3_load(positions, a)),
                                vec3_sub(vec3_load(velocities, b), vec3_load(velocities, a)));
}

double spring_measure_energy(const cloth_spring *spring, const double *positions) {
    double const length = vec3_norm(vec3_sub(vec3_load(positions, spring->vertices[1]),
                                             vec3_load(positions, spring->vertices[0])));
    return spring_get_law(spring, length - spring->rest_length).energy;
}
