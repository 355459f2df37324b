/* step/bodies/bodies_turn.c - how long a substep may be if bodies or obstacles turn in it.
 *
 * In a substep vertices move along chords, although they turn on arcs. So the shape that is tested
 * shrinks in the middle of a turn. No substep turns a body so far that a vertex leaves its chord by
 * much of the contact distance. Obstacles on keyframes turn by at most an eighth of a turn. */

#include "contact/pairs/body_paths.h"
#include "step/bodies/bodies.h"

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
 * the substep is repeated, with a turn that is shorter by the same factor. */
static const double TURN_SLACK = 1.1;

/* [rad] The most that a body may turn in one substep, from its least contact distance with
 * anything. With all obstacles and bodies it has the same. */
static double compute_largest_turn(const step_model *model, size_t body) {
    size_t const cloth_count = model->cloths.count, count = model->surface_count;
    size_t const surface = cloth_count + model->body_obstacles[body];
    size_t const other = surface == cloth_count ? surface + 1 : cloth_count;
    const contact_law *const laws = model->laws + surface * count;
    double least = other < count ? laws[other].contact_distance : (double)INFINITY;
    for (size_t i = 0; i < cloth_count; i++) least = fmin(least, laws[i].contact_distance);
    double const sag = CHORD_SHARE * least;
    return fmin(BODY_TURN_MAX, sqrt(sag / (BODY_CHORD_FACTOR * get_body(model, body)->radius)));
}

/* Cuts *length into equal turns of a script in none of which it turns by more than SCRIPT_TURN_MAX.
 */
static tulle_status limit_script(const motion_state *state, step_work *work,
                                 const world_motion *motion, size_t surface, double *length) {
    double const now = state->time, longest = *length;
    double start, end, low = 0.0, high = 1.0; /* share of the length in which it turns by a part */
    (void)motion_compute_pose(motion, now, &start);
    (void)motion_compute_pose(motion, now + longest, &end);
    double const turn = end - start, part = turn / ceil(turn / SCRIPT_TURN_MAX);
    if (!(turn > SCRIPT_TURN_MAX)) return TULLE_OK;
    if (!(turn <= TURN_SUBSTEPS_MAX * SCRIPT_TURN_MAX)) {
        work->failure = (step_finding){.kind = FINDING_SCRIPT_TURNS,
                                       .surface = (uint32_t)surface,
                                       .numbers = {turn, SCRIPT_TURN_MAX, TURN_SUBSTEPS_MAX}};
        return TULLE_ERROR_STEP_FAILED;
    }
    for (int i = 0; i < SHARE_BITS; i++) {
        double const middle = 0.5 * (low + high);
        (void)motion_compute_pose(motion, now + middle * longest, &end);
        *(end - start <= part ? &low : &high) = middle;
    }
    *length = high * longest;
    return TULLE_OK;
}

tulle_status step_limit_turns(const step_model *model, motion_state *state, step_work *work,
                              double *length) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < model->obstacles.count && status == TULLE_OK; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        if (range->is_present && !range->is_body)
            status = limit_script(state, work, &obstacle->motion, model->cloths.count + i, length);
    }
    for (size_t i = 0; i < model->cloths.count; i++) {
        const world_cloth *const cloth = &model->cloths.data[i];
        for (size_t p = 0; p < cloth->pin_count && status == TULLE_OK; p++)
            if (work->start->time < cloth->pins[p].release_time)
                status = limit_script(state, work, &cloth->pins[p].motion, i, length);
    }
    if (status != TULLE_OK) return status;
    const double *const velocities = state->velocities;
    for (size_t b = 0; b < model->body_count; b++) {
        if (!body_answers(model, work, b)) continue;
        double const spin = vec3_norm(vec3_load(velocities, get_first_slot(model, b) + 1));
        double const turn = compute_largest_turn(model, b);
        if (!(spin * work->whole_step <= TURN_SUBSTEPS_MAX * turn)) {
            work->failure =
                (step_finding){.kind = FINDING_BODY_SPINS,
                               .surface = (uint32_t)model->cloths.count + model->body_obstacles[b],
                               .numbers = {spin, turn, TURN_SUBSTEPS_MAX}};
            return TULLE_ERROR_STEP_FAILED;
        }
        if (spin * *length > turn) *length /= ceil(spin * *length / turn); /* equal parts */
    }
    return TULLE_OK;
}

double step_find_turn_time(const step_model *model, const step_work *work) {
    double longest = (double)INFINITY;
    for (size_t b = 0; b < model->body_count; b++) {
        if (!body_answers(model, work, b)) continue;
        double const spin =
            vec3_norm(vec3_load(work->sub.mean_velocity, get_first_slot(model, b) + 1));
        double const turn = compute_largest_turn(model, b);
        if (spin * work->sub.time_step > TURN_SLACK * turn)
            longest = fmin(longest, turn / (TURN_SLACK * spin));
    }
    return longest;
}
