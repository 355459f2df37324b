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
/* [rad] The most that keyframes turn something in one substep. Its vertices move along chords: an
 * eighth of a turn leaves the arc by 8 % of the radius, a whole turn would not move them at all. */
static const double SCRIPT_TURN_MAX = 0.7853981633974483;
/* Bits to which a substep's share of the step is found. */
enum { SHARE_BITS = 40 };
/* A contact may give a body this factor times the turn for which the substep was cut. Beyond it
 * the substep is made anew, with a turn that is shorter by the same factor. */
static const double TURN_SLACK = 1.1;

/* [rad] The most that a body may turn in one substep, from its least contact distance with
 * anything. With all obstacles and bodies it has the same. */
static double compute_largest_turn(const tulle_world *world, size_t body) {
    size_t const cloth_count = world->model.cloths.count, count = world->model.set.surface_count;
    size_t const surface = cloth_count + world->model.body_obstacles[body];
    size_t const other = surface == cloth_count ? surface + 1 : cloth_count;
    const contact_law *const laws = world->model.laws + surface * count;
    double least = other < count ? laws[other].contact_distance : (double)INFINITY;
    for (size_t i = 0; i < cloth_count; i++) least = fmin(least, laws[i].contact_distance);
    double const sag = CHORD_SHARE * least;
    return fmin(BODY_TURN_MAX, sqrt(sag / (BODY_CHORD_FACTOR * get_body(world, body)->radius)));
}

/* Cuts *length into equal turns of a script in none of which it turns by more than SCRIPT_TURN_MAX.
 */
static tulle_status limit_script(const step_context *context, const world_motion *motion,
                                 const char *name, double *length) {
    double const now = context->state->time, longest = *length;
    double start, end, low = 0.0, high = 1.0; /* share of the length in which it turns by a part */
    (void)motion_compute_pose(motion, now, &start);
    (void)motion_compute_pose(motion, now + longest, &end);
    double const turn = end - start, part = turn / ceil(turn / SCRIPT_TURN_MAX);
    if (!(turn > SCRIPT_TURN_MAX)) return TULLE_OK;
    if (!(turn <= TURN_SUBSTEPS_MAX * SCRIPT_TURN_MAX))
        return error_set(context->error, TULLE_ERROR_STEP_FAILED,
                         "the keyframes of '%s' turn it by %.6g rad in step %llu; substeps that "
                         "follow it turn by %.3g rad, and a step has at most %g of them; use a "
                         "shorter time step or a slower turn",
                         name, turn, (unsigned long long)context->world->step_count,
                         SCRIPT_TURN_MAX, TURN_SUBSTEPS_MAX);
    for (int i = 0; i < SHARE_BITS; i++) {
        double const middle = 0.5 * (low + high);
        (void)motion_compute_pose(motion, now + middle * longest, &end);
        *(end - start <= part ? &low : &high) = middle;
    }
    *length = high * longest;
    return TULLE_OK;
}

tulle_status world_limit_turns(const step_context *context, double *length) {
    const tulle_world *const world = context->world;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < world->model.obstacles.count && status == TULLE_OK; i++) {
        const surface_range *const range = &world->model.surfaces[world->model.cloths.count + i];
        const world_obstacle *const obstacle = &world->model.obstacles.data[i];
        if (range->is_present && !range->is_body)
            status = limit_script(context, &obstacle->motion, obstacle->name, length);
    }
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t p = 0; p < cloth->pin_count && status == TULLE_OK; p++)
            if (world->now.time < cloth->pins[p].release_time)
                status = limit_script(context, &cloth->pins[p].motion, cloth->name, length);
    }
    if (status != TULLE_OK) return status;
    const double *const velocities = context->state->velocities;
    for (size_t b = 0; b < world->model.body_count; b++) {
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
    for (size_t b = 0; b < world->model.body_count; b++) {
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
