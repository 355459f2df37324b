/* dynamics/spring.c - the membrane: springs along the edges, with damping along the spring.
 *
 * A short spring is linear. A long one stiffens, because yarns straighten and jam: stretched by
 * one stiffening strain it pulls twice as hard as a linear spring, by two strains five times as
 * hard.
 *
 * Based on: Provot, Deformation constraints in a mass-spring model, 1995; Choi, Ko, Stable but
 * responsive cloth, 2002 (the stiffness across a compressed spring is dropped, see
 * compute_forces.c). The derivative of the damping force with respect to positions is not used. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

/* The response of a spring at the guess, given its response at x0. The linear system needs a
 * force at x0: it gets the force at the guess, moved back to x0 along its derivative.
 * Crank-Nicolson takes 1 - c of the true force at x0. */
static void linearise_at_guess(const assembly *work, const cloth_spring *spring,
                               spring_response *response) {
    vec3 const at_start = response->elastic_force;
    vec3 const start = spring_get_difference(spring, work->state->positions);
    vec3 const guessed = spring_get_difference(spring, work->guessed_positions);
    vec3 const edge = spring_limit_guess(spring, start, guessed);
    *response =
        spring_evaluate(spring, edge, spring_get_difference(spring, work->state->velocities));
    vec3 const n = response->direction;
    vec3 const drift = vec3_add(
        vec3_scale(spring_get_difference(spring, work->state->guess), work->state->time_step),
        vec3_sub(edge, guessed));
    double const across = response->across > 0.0 ? response->across : 0.0;
    double const along = (response->axial - across) * vec3_dot(n, drift);
    vec3 force = vec3_add_scaled(response->elastic_force, n, -along);
    force = vec3_add_scaled(force, drift, -across);
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    response->elastic_force = is_mean ? vec3_lerp(at_start, force, work->share) : force;
}

/* Takes the drag of both triangles off the block of an edge. */
static void subtract_drags(const assembly *work, size_t edge, symmetric3 *block) {
    for (size_t side = 0; side < 2; side++) {
        uint32_t const triangle = work->model->surface->edge_triangles[2 * edge + side];
        if (triangle == TULLE_NONE) continue;
        vec3 const g = work->terms.triangle_drags[triangle];
        double const squares[6] = {g.x * g.x, g.x * g.y, g.x * g.z,
                                   g.y * g.y, g.y * g.z, g.z * g.z};
        for (int i = 0; i < 6; i++) block->m[i] -= work->alpha * squares[i];
    }
}

static void fill_slots(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    double const alpha = work->alpha, beta = work->beta;
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    bool const needs_start = is_mean || !work->guessed_positions;
    for (size_t s = begin; s < end; s++) {
        const cloth_spring *const spring = &work->model->springs[s];
        spring_response response = {0};
        if (needs_start)
            response =
                spring_evaluate(spring, spring_get_difference(spring, work->state->positions),
                                spring_get_difference(spring, work->state->velocities));
        if (work->guessed_positions) linearise_at_guess(work, spring, &response);
        double const across = beta * (response.across > 0.0 ? response.across : 0.0);
        double const axial = beta * response.axial;
        vec3 const n = response.direction;
        bool const has_length = vec3_norm2(n) > 0.0;
        /* A spring of no length has no direction: its axial stiffness acts in all of them. */
        work->spring_blocks[s] =
            has_length ? symmetric3_make(across, axial - across + alpha * spring->damping, n)
                       : symmetric3_make(axial, 0.0, n);
        if (work->has_wind) subtract_drags(work, s, &work->spring_blocks[s]);
        const double *const ends[2] = {work->padded.starts + 4 * (size_t)spring->vertices[0],
                                       work->padded.starts + 4 * (size_t)spring->vertices[1]};
        double const rate = vec3_dot(n, vec3_sub(vec3_load(ends[1], 0), vec3_load(ends[0], 0)));
        vec3 const force = vec3_add(response.elastic_force, response.damping_force);
        work->spring_sources[s] = vec3_add_scaled(force, n, -spring->damping * rate);
    }
}

bool fill_springs(assembly *work) {
    size_t const count = work->model->edge_count;
    work->spring_blocks = ARENA_NEW(work->scratch, symmetric3, count + 1);
    work->spring_sources = ARENA_NEW(work->scratch, vec3, count + 1);
    if (!work->spring_blocks || !work->spring_sources) return false;
    parallel_for(count, SPRINGS_PER_CHUNK, work->threads, fill_slots, work);
    return true;
}
