/* dynamics/spring.c - springs along the edges, with damping along the spring. They are linear while
 * short; stretched by a share s of their length they pull twice, by 2 s five times as hard as
 * linear ones would: yarns straighten and jam.
 *
 * Based on: Provot, Deformation constraints in a mass-spring model, 1995; Choi, Ko, Stable but
 * responsive cloth, 2002 (the stiffness across a compressed spring is dropped, see
 * compute_forces.c). The derivative of the damping force with respect to positions is not used. */
#include "dynamics/spring.h"

spring_edge spring_shorten_guess(const cloth_spring *spring, vec3 start, spring_edge guess) {
    double const longest =
        fmax(vec3_norm(start), spring->rest_length) + GUESS_STRAINS / sqrt(spring->stiffening);
    if (!(guess.length > longest)) return guess;
    return spring_make_edge(vec3_scale(guess.edge, longest / guess.length));
}

double spring_measure_energy(const cloth_spring *spring, const double *positions) {
    double const length = vec3_norm(vec3_sub(vec3_load(positions, spring->vertices[1]),
                                             vec3_load(positions, spring->vertices[0])));
    return spring_get_law(spring, length - spring->rest_length).energy;
}
