/* world/bodies/bodies_turn.c - see bodies_turn.h. */
#include "world/bodies/bodies_turn.h"

#include "base/error.h"
#include "contact/pairs/body_paths.h"

#include <math.h>

/* A vertex may leave its chord by this share of the contact distance. */
static const double CHORD_SHARE = 0.25;
/* Substeps of one step for its turns, at most. */
static const double TURN_SUBSTEPS_MAX = 4096.0;
/* A contact may give a body this times the turn that the substep was cut for; beyond it the substep
 * is made anew, with a turn shorter by the same factor. */
static const double TURN_SLACK = 1.1;

static const world_obstacle *get_free_body(const tulle_world *world, size_t body) {
    uint32_t const obstacle = world->body_obstacles[body];
    surface_range const *const range = &world->surfaces[world->cloths.count + obstacle];
    return range->is_body && range->is_present ? &world->obstacles.data[obstacle] : NULL;
}

static double get_spin(const tulle_world *world, const double *velocities, size_t body) {
    return vec3_norm(vec3_load(velocities, world->cloth_vertex_count + 2 * body + 1));
}

/* [m] The least contact distance that a body has with anything; all obstacles and bodies have one
 * with it. */
static double find_least_distance(const tulle_world *world, const world_obstacle *body) {
    size_t const cloth_count = world->cloths.count, count = world_surface_count(world);
    size_t const surface = cloth_count + (size_t)(body - world->obstacles.data);
    size_t const other = surface == cloth_count ? surface + 1 : cloth_count;
    contact_law const *const laws = world->laws + surface * count;
    double least = other < count ? laws[other].contact_distance : (double)INFINITY;
    for (size_t i = 0; i < cloth_count; i++) least = fmin(least, laws[i].contact_distance);
    return least;
}

/* [rad] Turn of a body in one substep, at most. */
static double find_largest_turn(const tulle_world *world, const world_obstacle *body) {
    double const sag = CHORD_SHARE * find_least_distance(world, body);
    return fmin(BODY_TURN_MAX, sqrt(sag / (BODY_CHORD_FACTOR * body->radius)));
}

static tulle_status fail_turn(const step_context *context, const world_obstacle *body, double spin,
                              double turn) {
    return error_set(context->error, TULLE_ERROR_STEP_FAILED,
                     "'%s' spins with %.6g rad/s in step %llu, %.6g rad within the step; substeps "
                     "that follow its turn last %.3g s, and a step has at most %g of them; use a "
                     "time step of at most %.3g s, less spin or a larger contact distance",
                     body->name, spin, (unsigned long long)context->world->step_count,
                     spin * context->whole_step, turn / spin, TURN_SUBSTEPS_MAX,
                     TURN_SUBSTEPS_MAX * turn / spin);
}

tulle_status world_limit_turns(const step_context *context, double *length) {
    tulle_world const *const world = context->world;
    for (size_t b = 0; b < world->body_count; b++) {
        world_obstacle const *const body = get_free_body(world, b);
        if (!body) continue;
        double const spin = get_spin(world, context->state->velocities, b);
        double const turn = find_largest_turn(world, body);
        if (!(spin * context->whole_step <= TURN_SUBSTEPS_MAX * turn))
            return fail_turn(context, body, spin, turn);
        /* equal parts */
        if (spin * *length > turn) *length /= ceil(spin * *length / turn);
    }
    return TULLE_OK;
}

bool world_turns_too_far(step_context *context) {
    tulle_world const *const world = context->world;
    double longest = (double)INFINITY;
    for (size_t b = 0; b < world->body_count; b++) {
        world_obstacle const *const body = get_free_body(world, b);
        if (!body) continue;
        double const spin = get_spin(world, context->mean_velocity, b);
        double const turn = find_largest_turn(world, body);
        if (spin * context->time_step > TURN_SLACK * turn)
            longest = fmin(longest, turn / (TURN_SLACK * spin));
    }
    context->turn_time = longest;
    return isfinite(longest);
}
