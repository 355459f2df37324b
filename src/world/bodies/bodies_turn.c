/* world/bodies/bodies_turn.c - see bodies_turn.h. */
#include "world/bodies/bodies_turn.h"

#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "world/bodies/bodies.h"

#include <math.h>

/* A vertex may leave its chord by this share of the contact distance. */
static const double CHORD_SHARE = 0.25;
/* Substeps of one step for its turns, at most. */
static const double TURN_SUBSTEPS_MAX = 4096.0;
/* A contact may give a body this factor times the turn for which the substep was cut. Beyond it
 * the substep is made anew, with a turn that is shorter by the same factor. */
static const double TURN_SLACK = 1.1;

/* [rad] The most that a body may turn in one substep, from its least contact distance with
 * anything. With all obstacles and bodies it has the same. */
static double compute_largest_turn(const tulle_world *world, size_t body) {
    size_t const cloth_count = world->cloths.count, count = world->set.surface_count;
    size_t const surface = cloth_count + world->body_obstacles[body];
    size_t const other = surface == cloth_count ? surface + 1 : cloth_count;
    const contact_law *const laws = world->laws + surface * count;
    double least = other < count ? laws[other].contact_distance : (double)INFINITY;
    for (size_t i = 0; i < cloth_count; i++) least = fmin(least, laws[i].contact_distance);
    double const sag = CHORD_SHARE * least;
    return fmin(BODY_TURN_MAX, sqrt(sag / (BODY_CHORD_FACTOR * get_body(world, body)->radius)));
}

tulle_status world_limit_turns(const step_context *context, double *length) {
    const tulle_world *const world = context->world;
    const double *const velocities = context->state->velocities;
    for (size_t b = 0; b < world->body_count; b++) {
        if (!body_answers(world, b)) continue;
        double const spin = vec3_norm(vec3_load(velocities, get_first_slot(world, b) + 1));
        double const turn = compute_largest_turn(world, b);
        if (!(spin * context->whole_step <= TURN_SUBSTEPS_MAX * turn))
            return error_set(context->error, TULLE_ERROR_STEP_FAILED,
                             "'%s' spins with %.6g rad/s in step %llu, %.6g rad within the step; "
                             "substeps that follow its turn last %.3g s, and a step has at most %g "
                             "of them; use a time step of at most %.3g s, less spin or a larger "
                             "contact distance",
                             get_body(world, b)->name, spin, (unsigned long long)world->step_count,
                             spin * context->whole_step, turn / spin, TURN_SUBSTEPS_MAX,
                             TURN_SUBSTEPS_MAX * turn / spin);
        if (spin * *length > turn) *length /= ceil(spin * *length / turn); /* equal parts */
    }
    return TULLE_OK;
}

bool world_turns_too_far(step_context *context) {
    const tulle_world *const world = context->world;
    double longest = (double)INFINITY;
    for (size_t b = 0; b < world->body_count; b++) {
        if (!body_answers(world, b)) continue;
        double const spin =
            vec3_norm(vec3_load(context->mean_velocity, get_first_slot(world, b) + 1));
        double const turn = compute_largest_turn(world, b);
        if (spin * context->time_step > TURN_SLACK * turn)
            longest = fmin(longest, turn / (TURN_SLACK * spin));
    }
    context->retry.turn_time = longest;
    return isfinite(longest);
}
