/* world/given.c - what a host gives for the next step: poses, positions and targets of pins
 * (tulle/live.h).
 *
 * In: the calls of the host, checked. Out: given poses and positions of obstacles and pins, of
 * which kinematics.c makes targets; the two keyframes between which an obstacle goes as a whole.
 * All of it is for one step: world_begin_given takes it up, world_end_given lets go of it. */
#include "tulle/live.h"

#include "base/error.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

/* [m] as for meshes */
static const double COORDINATE_MAX = 1e100;

/* ---- calls ---- */

/* Refuses numbers beyond COORDINATE_MAX, of which each three belong to a vertex. */
static tulle_status check_points(const double *points, size_t count, const char *owner,
                                 tulle_error *error) {
    for (size_t i = 0; i < 3 * count; i++) {
        if (!(fabs(points[i]) <= COORDINATE_MAX))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: coordinate %zu of point %zu is %g; it must be a number of at "
                             "most %g m",
                             owner, i % 3, i / 3, points[i], COORDINATE_MAX);
    }
    return TULLE_OK;
}

/* The obstacle that may be given something of this kind, or null with an error. */
static world_obstacle *find_driven(tulle_world *world, tulle_obstacle_id id, tulle_drive drive,
                                   tulle_error *error) {
    static const char *const wanted[] = {[TULLE_DRIVE_RIGID] = "TULLE_DRIVE_RIGID, for a transform",
                                         [TULLE_DRIVE_DEFORMING] =
                                             "TULLE_DRIVE_DEFORMING, for positions"};
    size_t const index = world_find_obstacle(world, id);
    if (index == SIZE_MAX) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world has no such obstacle");
        return NULL;
    }
    world_obstacle *const obstacle = &world->model.obstacles.data[index];
    const char *const name = obstacle->name;
    if (!world->is_started) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "%s: call tulle_world_start before it is given where to go", name);
    } else if (obstacle->drive != drive) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "%s: it is not driven in this way; add it with the drive %s", name,
                  wanted[drive]);
    } else if (obstacle->given != GIVEN_NOTHING) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "%s: it was already given where to go in the next step", name);
    } else {
        return obstacle;
    }
    return NULL;
}

static tulle_status check_travel(tulle_travel travel, const char *owner, tulle_error *error) {
    if (travel == TULLE_TRAVEL_MOVE || travel == TULLE_TRAVEL_JUMP) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s: there is no travel number %d", owner,
                     (int)travel);
}

tulle_status tulle_obstacle_set_next_transform(tulle_world *world, tulle_obstacle_id id,
                                               const double translation[3],
                                               const double rotation[4], tulle_travel travel,
                                               tulle_error *error) {
    if (!translation || !rotation)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the translation or the rotation is null");
    world_obstacle *const obstacle = find_driven(world, id, TULLE_DRIVE_RIGID, error);
    if (!obstacle) return TULLE_ERROR_INVALID_ARGUMENT;
    tulle_status status = check_travel(travel, obstacle->name, error);
    if (status == TULLE_OK) status = check_points(translation, 1, obstacle->name, error);
    if (status != TULLE_OK) return status;
    quaternion const turn = quaternion_load(rotation);
    double const norm = quaternion_norm(turn);
    if (!(fabs(norm - 1.0) <= QUATERNION_TOLERANCE))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the rotation has length %g; give a unit quaternion", obstacle->name,
                         norm);
    obstacle->given = travel == TULLE_TRAVEL_JUMP ? GIVEN_JUMP : GIVEN_MOVE;
    obstacle->given_pose = (motion_pose){
        vec3_load(translation, 0), {turn.w / norm, turn.x / norm, turn.y / norm, turn.z / norm}};
    if (world->recording)
        world_record(world, &(recorded_call){.kind = RECORD_TRANSFORM,
                                             .ids = {id.index},
                                             .generations = {id.generation},
                                             .numbers = {(uint64_t)travel},
                                             .arrays = {{translation, 3}, {rotation, 4}}});
    return TULLE_OK;
}

tulle_status tulle_obstacle_set_next_positions(tulle_world *world, tulle_obstacle_id id,
                                               const double *positions, size_t vertex_count,
                                               tulle_travel travel, tulle_error *error) {
    if (!positions) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the positions are null");
    world_obstacle *const obstacle = find_driven(world, id, TULLE_DRIVE_DEFORMING, error);
    if (!obstacle) return TULLE_ERROR_INVALID_ARGUMENT;
    if (vertex_count != obstacle->mesh.vertex_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: has %zu vertices and was given positions of %zu", obstacle->name,
                         obstacle->mesh.vertex_count, vertex_count);
    tulle_status status = check_travel(travel, obstacle->name, error);
    if (status == TULLE_OK) status = check_points(positions, vertex_count, obstacle->name, error);
    if (status != TULLE_OK) return status;
    obstacle->given = travel == TULLE_TRAVEL_JUMP ? GIVEN_JUMP : GIVEN_MOVE;
    memcpy(obstacle->given_positions, positions, 3 * vertex_count * sizeof(double));
    if (world->recording)
        world_record(world, &(recorded_call){.kind = RECORD_POSITIONS,
                                             .ids = {id.index},
                                             .generations = {id.generation},
                                             .numbers = {(uint64_t)travel},
                                             .arrays = {{positions, 3 * vertex_count}}});
    return TULLE_OK;
}

tulle_status tulle_cloth_set_pin_targets(tulle_world *world, tulle_cloth_id id, size_t pin,
                                         const double *positions, size_t vertex_count,
                                         tulle_error *error) {
    if (!positions) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the positions are null");
    size_t const index = world_find_cloth(world, id);
    if (index == SIZE_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world has no such cloth");
    const world_cloth *const cloth = &world->model.cloths.data[index];
    if (pin >= cloth->pin_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: has no pin number %zu; it has %zu pins", cloth->name, pin,
                         cloth->pin_count);
    world_pin *const driven = &cloth->pins[pin];
    const char *reason = NULL;
    if (!world->is_started)
        reason = "takes targets once tulle_world_start was called";
    else if (!driven->targets)
        reason = "follows its keyframes";
    else if (world->now.time >= driven->release_time)
        reason = "has let go";
    else if (driven->has_targets)
        reason = "was already given targets for the next step";
    if (reason)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s: pin %zu %s", cloth->name, pin,
                         reason);
    if (vertex_count != driven->vertex_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: pin %zu has %zu vertices and was given positions of %zu", cloth->name,
                         pin, driven->vertex_count, vertex_count);
    tulle_status const status = check_points(positions, vertex_count, cloth->name, error);
    if (status != TULLE_OK) return status;
    memcpy(driven->targets, positions, 3 * vertex_count * sizeof(double));
    driven->has_targets = true;
    if (world->recording)
        world_record(world, &(recorded_call){.kind = RECORD_PIN_TARGETS,
                                             .ids = {id.index},
                                             .generations = {id.generation},
                                             .numbers = {pin},
                                             .arrays = {{positions, 3 * vertex_count}}});
    return TULLE_OK;
}

/* ---- the step ---- */

void world_begin_given(tulle_world *world) {
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        world_obstacle *const obstacle = &world->model.obstacles.data[i];
        bool const jumps = obstacle->given == GIVEN_JUMP;
        if (obstacle->drive == TULLE_DRIVE_RIGID) {
            motion_pose const last = world->now.poses[i];
            motion_pose const to = obstacle->given == GIVEN_NOTHING ? last : obstacle->given_pose;
            motion_pose const poses[2] = {jumps ? to : last, to};
            double const times[2] = {world->now.time, world->work.step_end};
            for (int k = 0; k < 2; k++) {
                motion_key *const key = &obstacle->motion.keys[k];
                *key = (motion_key){.time = times[k],
                                    .translation = poses[k].translation,
                                    .rotation = poses[k].rotation};
                if (k == 0) continue;
                key->turn = quaternion_find_turn(poses[0].rotation, poses[1].rotation);
                key->turned = vec3_norm(key->turn);
            }
            if (jumps)
                motion_apply(&obstacle->motion, world->work.step_end, obstacle->mesh.positions,
                             obstacle->mesh.vertex_count, obstacle->given_positions);
        }
        if (!jumps) continue;
        double *const here = world->now.positions + 3 * (size_t)obstacle->vertex_begin;
        double *const there = obstacle->given_positions;
        for (size_t k = 0; k < 3 * obstacle->mesh.vertex_count; k++) {
            double const old = here[k];
            here[k] = there[k];
            there[k] = old;
        }
        obstacle->has_jumped = true;
        obstacle->was_present = world->now.is_present[i] != 0;
        world->now.is_present[i] = 0;
    }
}

void world_end_given(tulle_world *world, bool has_failed) {
    if (has_failed) world->has_queries = false;
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        world_obstacle *const obstacle = &world->model.obstacles.data[i];
        if (has_failed && obstacle->has_jumped) {
            memcpy(world->now.positions + 3 * (size_t)obstacle->vertex_begin,
                   obstacle->given_positions, 3 * obstacle->mesh.vertex_count * sizeof(double));
            world->now.is_present[i] = obstacle->was_present;
        }
        bool const has_pose =
            obstacle->drive == TULLE_DRIVE_RIGID && obstacle->given != GIVEN_NOTHING;
        if (has_pose && !has_failed) world->now.poses[i] = obstacle->given_pose;
        obstacle->given = GIVEN_NOTHING;
        obstacle->given_force = obstacle->given_torque = vec3_make(0.0, 0.0, 0.0);
        obstacle->has_jumped = false;
    }
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t p = 0; p < cloth->pin_count; p++) cloth->pins[p].has_targets = false;
    }
}
