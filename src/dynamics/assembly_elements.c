/* dynamics/assembly_elements.c - what springs, hinges and triangles bring to the system, each into
 * its own slots. */
#include "dynamics/assembly.h"

#include <math.h>

static inline vec3 get_difference(const cloth_spring *spring, const double *values) {
    return vec3_sub(vec3_load(values, spring->vertices[1]), vec3_load(values, spring->vertices[0]));
}

/* What a spring does about the guess. The elastic force is the one that the linear system takes as
 * its start: the force at the guess, drawn back along its derivative to x0. Crank-Nicolson takes
 * 1 - c of the true force at x0. */
static void linearise_at_guess(const assembly *work, const cloth_spring *spring,
                               spring_response *response) {
    vec3 const at_start = response->elastic_force;
    vec3 const guessed = get_difference(spring, work->guessed_positions);
    spring_edge const edge =
        spring_limit_guess(spring, get_difference(spring, work->state->positions), guessed);
    *response = spring_evaluate_edge(spring, edge, get_difference(spring, work->state->velocities));
    vec3 const n = response->direction;
    vec3 const drift =
        vec3_add(vec3_scale(get_difference(spring, work->state->guess), work->state->time_step),
                 vec3_sub(edge.edge, guessed));
    double const across = response->across > 0.0 ? response->across : 0.0;
    double const along = (response->axial - across) * vec3_dot(n, drift);
    vec3 force = vec3_add_scaled(response->elastic_force, n, -along);
    force = vec3_add_scaled(force, drift, -across);
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    response->elastic_force = is_mean ? vec3_lerp(at_start, force, work->factor.share) : force;
}

void assembly_fill_springs(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    coefficients const factor = work->factor;
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    bool const needs_start = work->spring_forces || is_mean || !work->guessed_positions;
    for (size_t s = begin; s < end; s++) {
        const cloth_spring *const spring = &work->model->springs[s];
        spring_response response = {0};
        if (needs_start) {
            response = spring_evaluate(spring, work->state->positions, work->state->velocities);
            if (work->spring_forces)
                work->spring_forces[s] = vec3_add(response.elastic_force, response.damping_force);
        }
        if (work->guessed_positions) linearise_at_guess(work, spring, &response);
        double const across = factor.beta * (response.across > 0.0 ? response.across : 0.0);
        double const axial = factor.beta * response.axial;
        bool const has_length = vec3_norm2(response.direction) > 0.0;
        /* Without a direction the axial stiffness acts in all of them. */
        work->spring_blocks[s] =
            has_length ? symmetric3_make(across, axial - across + factor.alpha * spring->damping,
                                         response.direction)
                       : symmetric3_make(axial, 0.0, response.direction);
        vec3 const n = response.direction;
        double const rate =
            vec3_dot(n, vec3_sub(vec3_load(work->start_velocities, spring->vertices[1]),
                                 vec3_load(work->start_velocities, spring->vertices[0])));
        vec3 const force = vec3_add(response.elastic_force, response.damping_force);
        work->spring_sources[s] = vec3_add_scaled(force, n, -spring->damping * rate);
    }
}

void assembly_evaluate_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    for (size_t h = begin; h < end; h++)
        work->hinge_deviations[h] = bend_get_deviation(work->model, h, work->state->positions);
}

void assembly_damp_bending(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_model *const model = work->model;
    const uint32_t *const uses = model->surface->vertex_triangles.begin;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *const corners = cloth_get_corners(model, t);
        uint32_t most = 0;
        for (int k = 0; k < 3; k++) {
            uint32_t const count = uses[corners[k] + 1] - uses[corners[k]];
            if (count > most) most = count;
        }
        bend_damping_input const input = {.model = model,
                                          .triangle = t,
                                          .positions = work->state->positions,
                                          .velocities = work->state->velocities,
                                          .time_step = work->state->time_step,
                                          .triangles_at_a_vertex = most};
        bend_evaluate_damping(&input, &work->bend_dampings[t], work->terms.bend_forces + 2 * t);
    }
}

void assembly_fill_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_model *const model = work->model;
    for (size_t h = begin; h < end; h++) {
        const cloth_hinge *const hinge = &model->hinges[h];
        hinge_moments moments = {.elastic = bend_get_moment(model, h, work->hinge_deviations)};
        for (int side = 0; side < 2 && work->bend_dampings; side++) {
            uint32_t const place = hinge->sides[side];
            moments.damping =
                vec3_add(moments.damping,
                         bend_get_damping_moment(&work->bend_dampings[place / 3], place % 3));
        }
        if (work->terms.hinge_forces)
            bend_get_forces(model, h, work->state->positions, moments,
                            work->terms.hinge_forces + 4 * h);
        else
            work->terms.hinge_moments[h] = vec3_add(moments.elastic, moments.damping);
    }
}

void assembly_sample_wind(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    gust_cell cell = {0};
    for (size_t v = begin; v < end; v++)
        work->terms.air_velocities[v] =
            wind_get_velocity(&work->surroundings->wind, vec3_load(work->state->positions, v),
                              work->state->time, &cell);
}

void assembly_fill_triangles(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    double const third = 1.0 / 3.0;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *const vertices = cloth_get_corners(work->model, t);
        vec3 corners[3], relative = {0.0, 0.0, 0.0}, start = {0.0, 0.0, 0.0};
        for (int k = 0; k < 3; k++) {
            corners[k] = vec3_load(work->state->positions, vertices[k]);
            relative = vec3_add(relative, vec3_sub(vec3_load(work->state->velocities, vertices[k]),
                                                   work->terms.air_velocities[vertices[k]]));
            start = vec3_add(start, vec3_load(work->start_velocities, vertices[k]));
        }
        wind_response const response = wind_evaluate(work->surroundings->wind.drag_coefficient,
                                                     corners, vec3_scale(relative, third));
        work->triangle_forces[t] = vec3_scale(response.force, third);
        vec3 const g = vec3_scale(response.normal, third * sqrt(response.drag));
        work->terms.triangle_drags[t] = g;
        work->terms.triangle_sources[t] =
            vec3_add_scaled(work->triangle_forces[t], g, vec3_dot(g, start));
    }
}
