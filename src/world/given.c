/* world/given.c - what a host gives for the next step, and new places for all (tulle/live.h).
 *
 * In: the calls of the host, checked. Out: of what step/script.c makes targets; the two keyframes
 * between which an obstacle goes as a whole; the shape from which cloth bends. All of it is for one
 * step: world_begin_given takes it up, world_end_given lets go of it. */
#include "tulle/live.h"

#include "base/error.h"
#include "step/lag/lag.h"
#include "step/sleep/cloth_sleep.h"
#include "step/step.h"
#include "world/record/record.h"

#include <math.h>
#include <string.h>

/* [m] as for meshes */
static const double COORDINATE_MAX = 1e100;

/* ---- calls ---- */

/* Refuses another count than that of the owner's vertices, and numbers beyond COORDINATE_MAX. */
static tulle_status check_points(const double *points, size_t count, size_t vertex_count,
                                 const char *owner, tulle_error *error) {
    if (count != vertex_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: has %zu vertices and was given positions of %zu", owner, vertex_count,
                         count);
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
                  "%s: call tulle_world_start before you give it a pose", name);
    } else if (obstacle->drive != drive) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "%s: it has another drive; add it with the drive %s", name, wanted[drive]);
    } else if (obstacle->given != GIVEN_NOTHING) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "%s: it already has a pose for the next step", name);
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
    if (status == TULLE_OK) status = check_points(translation, 1, 1, obstacle->name, error);
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
    WORLD_RECORD(world, .kind = RECORD_TRANSFORM, RECORD_ID(id), .numbers = {(uint64_t)travel},
                 .arrays = {{translation, 3}, {rotation, 4}});
    return TULLE_OK;
}

tulle_status tulle_obstacle_set_next_positions(tulle_world *world, tulle_obstacle_id id,
                                               const double *positions, size_t vertex_count,
                                               tulle_travel travel, tulle_error *error) {
    if (!positions) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the positions are null");
    world_obstacle *const obstacle = find_driven(world, id, TULLE_DRIVE_DEFORMING, error);
    if (!obstacle) return TULLE_ERROR_INVALID_ARGUMENT;
    tulle_status status = check_travel(travel, obstacle->name, error);
    if (status == TULLE_OK)
        status = check_points(positions, vertex_count, obstacle->mesh.vertex_count, obstacle->name,
                              error);
    if (status != TULLE_OK) return status;
    obstacle->given = travel == TULLE_TRAVEL_JUMP ? GIVEN_JUMP : GIVEN_MOVE;
    memcpy(obstacle->given_positions, positions, 3 * vertex_count * sizeof(double));
    WORLD_RECORD(world, .kind = RECORD_POSITIONS, RECORD_ID(id), .numbers = {(uint64_t)travel},
                 .arrays = {{positions, 3 * vertex_count}});
    return TULLE_OK;
}

tulle_status tulle_cloth_set_pin_targets(tulle_world *world, tulle_cloth_id id, size_t pin,
                                         const double *positions, size_t vertex_count,
                                         tulle_error *error) {
    if (!positions) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the positions are null");
    const world_cloth *const cloth = world_find_started_cloth(world, id, error);
    if (!cloth) return TULLE_ERROR_INVALID_ARGUMENT;
    if (pin >= cloth->pin_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: has no pin number %zu; it has %zu pins", cloth->name, pin,
                         cloth->pin_count);
    world_pin *const driven = &cloth->pins[pin];
    const char *reason = NULL;
    if (!driven->targets)
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
    tulle_status const status =
        check_points(positions, vertex_count, vertex_count, cloth->name, error);
    if (status != TULLE_OK) return status;
    memcpy(driven->targets, positions, 3 * vertex_count * sizeof(double));
    driven->has_targets = true;
    WORLD_RECORD(world, .kind = RECORD_PIN_TARGETS, RECORD_ID(id), .numbers = {pin},
                 .arrays = {{positions, 3 * vertex_count}});
    return TULLE_OK;
}

tulle_status tulle_cloth_set_targets(tulle_world *world, tulle_cloth_id id,
                                     const tulle_cloth_targets *targets, tulle_error *error) {
    if (!targets || !targets->positions)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the targets are null");
    world_cloth *const cloth = world_find_started_cloth(world, id, error);
    if (!cloth) return TULLE_ERROR_INVALID_ARGUMENT;
    const double *const to = targets->positions, *const departures = targets->departures;
    size_t const count = cloth->mesh.vertex_count;
    bool const is_flat = world->model.cloth_model->bends_by_matrix;
    const char *const reason = cloth->is_drawn ? "it was already given targets for the next step"
                               : is_flat       ? NULL
                                               : "targets need has_flat_rest of all cloth";
    tulle_status status =
        reason ? error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s: %s", cloth->name, reason)
               : check_points(to, targets->vertex_count, count, cloth->name, error);
    if (status == TULLE_OK && departures)
        status = check_points(departures, count, count, cloth->name, error);
    if (status != TULLE_OK) return status;
    if (!cloth->targets) cloth->targets = memory_allocate(&world->heap, 7 * count * sizeof(double));
    if (!cloth->targets)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "%s: no memory left", cloth->name);
    for (size_t i = 0; i < 3 * count; i++) {
        cloth->targets[i] = to[i];
        cloth->targets[3 * count + i] = to[i] + (departures ? departures[i] : 0.0);
        if (i < count) cloth->targets[6 * count + i] = targets->is_led && targets->is_led[i];
    }
    cloth->is_drawn = true;
    step_wake_cloth(&world->model, &world->now, (size_t)(cloth - world->model.cloths.data));
    WORLD_RECORD(world, .kind = RECORD_TARGETS, RECORD_ID(id),
                 .arrays = {{to, 3 * count}, {departures, departures ? 3 * count : 0}},
                 .def.state = {targets->is_led, targets->is_led ? count : 0});
    return TULLE_OK;
}

tulle_status tulle_world_place(tulle_world *world, const double *positions, size_t vertex_count,
                               tulle_error *error) {
    if (!world || !positions || !world->is_started)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the world is null or has not started, or the positions are null");
    motion_state *const next = &world->next;
    size_t const slots = 2 * world->model.body_count, count = world->model.vertex_count - slots;
    tulle_status status = check_points(positions, vertex_count, count, "the world", error);
    bool has_appeared; /* all is judged */
    if (status == TULLE_OK &&
        step_copy_start(&world->model, next, &world->work, &has_appeared) != TULLE_OK)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    if (status != TULLE_OK) return status;
    for (size_t v = 0; v < count; v++) {
        size_t const to = v < world->model.cloth_vertex_count ? v : v + slots;
        size_t const obstacle = world->model.vertex_surface[to] - world->model.cloths.count;
        if (v >= world->model.cloth_vertex_count &&
            world->model.obstacles.data[obstacle].drive != TULLE_DRIVE_DEFORMING)
            continue;
        vec3_store(next->positions, to, vec3_load(positions, v));
        vec3_store(next->velocities, to, vec3_make(0.0, 0.0, 0.0));
    }
    memset(next->lags, 0, 3 * world->model.lag_vertex_count * sizeof(double));
    step_measure_lags(&world->model, next);
    next->still_count = 0;
    next->previous_time_step = 0.0;
    next->elastic.is_known = false;
    next->contacts.contacts.count = 0;
    status = world_find_intersections(world, next->positions, &world->intersections, error);
    if (status == TULLE_OK && world->intersections.count > 0)
        status = world_refuse_intersections(world, next->positions, "where all is placed", error);
    if (status != TULLE_OK) return status;
    step_wake_cloths(&world->model, next);
    motion_state const old = world->now;
    world->now = *next;
    world->next = old;
    world->accepted_rows.rows.count = 0;
    world->has_contacts = world->work.has_queries = false;
    WORLD_RECORD(world, .kind = RECORD_PLACE, .arrays = {{positions, 3 * vertex_count}});
    return TULLE_OK;
}

/* ---- the step ---- */

tulle_status world_begin_given(tulle_world *world, tulle_error *error) {
    double *shape = NULL;
    size_t const n = 3 * world->model.cloth_vertex_count;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        if (!cloth->is_drawn) continue;
        if (!shape) shape = ARENA_NEW_ZEROED(&world->work.scratch, double, n);
        if (!shape) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for shapes");
        memcpy(shape + 3 * (size_t)cloth->vertex_begin, cloth->targets,
               3 * cloth->mesh.vertex_count * sizeof(double));
        world->model.cloth_model->shape = shape;
    }
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
    return TULLE_OK;
}

void world_end_given(tulle_world *world, bool has_failed) {
    if (has_failed) world->work.has_queries = false;
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
        world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t p = 0; p < cloth->pin_count; p++) cloth->pins[p].has_targets = false;
        cloth->is_drawn = false;
        world->model.cloth_model->shape = NULL;
    }
}
