/* world/bodies/body_control.c - what the host has bodies do: velocities, forces, locks and drives
 * (tulle/bodies.h).
 *
 * In: the calls of the host, checked. Out: velocities of slots; forces for the next step, of which
 * given.c lets go; locks and drives, which are part of the state; and for each substep what contact
 * solves for (contact/solve/body_drives.h).
 *
 * A drive of stiffness k and damping d gives  F = k (x* - x1) + d (v* - u)  with x1 = x0 + h u.
 * Over the time g in which forces act on u this is the impulse  push - gain u,  with gain = g (d +
 * h k),  push = g (k (x* - x0) + d v*). */

#include "base/error.h"
#include "base/hash.h"
#include "contact/pairs/body_paths.h"
#include "contact/solve/body_drives.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "world/fields/fields.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

/* [m/s], [rad/s]; [N], [N m] and the like; [m] as for meshes */
static const double SPEED_MAX = 1e6, FORCE_MAX = 1e12, COORDINATE_MAX = 1e100;

/* ---- checks ---- */

/* Numbers of a call, and what they may be. */
typedef struct given_numbers {
    const char *what;
    const double *numbers;
    int count;
    double low, high;
} given_numbers;

static tulle_status check_numbers(const char *owner, given_numbers given, tulle_error *error) {
    for (int k = 0; k < given.count; k++)
        if (!(given.numbers[k] >= given.low && given.numbers[k] <= given.high))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "%s: %s[%d] is %g; it must be %g to %g", owner, given.what, k,
                             given.numbers[k], given.low, given.high);
    return TULLE_OK;
}

static tulle_status check_drive(const char *owner, const tulle_body_drive *drive,
                                tulle_error *error) {
    tulle_status const status = fields_check(&body_drive_fields, drive, owner, NULL, error);
    if (status != TULLE_OK) return status;
    double const norm = quaternion_norm(quaternion_load(drive->rotation));
    if (fabs(norm - 1.0) <= QUATERNION_TOLERANCE) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: the rotation has length %g; give a unit quaternion, or begin with "
                     "tulle_body_drive_default",
                     owner, norm);
}

/* Number of a body that is there and answers, or TULLE_NONE with an error. */
static uint32_t find_free_body(const tulle_world *world, tulle_obstacle_id id, tulle_error *error) {
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE || body_answers(&world->model, &world->work, body)) return body;
    error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
              "'%s' follows its script or is absent: it takes no velocities and no forces",
              get_body(&world->model, body)->name);
    return TULLE_NONE;
}

void world_set_body_velocity(tulle_world *world, size_t body, const double *velocities) {
    motion_state *const now = &world->now;
    double given[BODY_AXES];
    memcpy(given, velocities, sizeof given);
    for (int k = 0; k < BODY_AXES; k++) {
        size_t const i = 3 * get_first_slot(&world->model, body) + (size_t)k;
        if (world->model.controls[body].locks >> k & 1u) given[k] = 0.0;
        double const change = given[k] - now->velocities[i];
        if (now->previous_mean) { /* a jump is no acceleration: the history jumps with it */
            now->previous_mean[i] += change;
            now->previous_velocities[i] += change;
        }
        now->velocities[i] = given[k];
    }
}

tulle_status tulle_obstacle_set_velocity(tulle_world *world, tulle_obstacle_id id,
                                         const double velocity[3], const double angular_velocity[3],
                                         tulle_error *error) {
    uint32_t const body = find_free_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const char *const name = get_body(&world->model, body)->name;
    const double *const given[2] = {velocity, angular_velocity};
    static const char *const whats[2] = {"velocity", "angular_velocity"};
    for (int i = 0; i < 2; i++) {
        tulle_status const status =
            given[i]
                ? check_numbers(name, (given_numbers){whats[i], given[i], 3, -SPEED_MAX, SPEED_MAX},
                                error)
                : TULLE_OK;
        if (status != TULLE_OK) return status;
    }
    step_wake_body(&world->model, &world->now, body);
    double velocities[BODY_AXES];
    memcpy(velocities, world->now.velocities + 3 * get_first_slot(&world->model, body),
           sizeof velocities);
    for (size_t i = 0; i < 2; i++)
        if (given[i]) memcpy(velocities + 3 * i, given[i], 3 * sizeof(double));
    world_set_body_velocity(world, body, velocities);
    WORLD_RECORD(
        world, .kind = RECORD_VELOCITY, RECORD_ID(id),
        .arrays = {{velocity, velocity ? 3 : 0}, {angular_velocity, angular_velocity ? 3 : 0}});
    return TULLE_OK;
}

/* Adds to what the body is given for the next step. */
static tulle_status give(tulle_world *world, uint32_t body, vec3 force, vec3 torque,
                         tulle_error *error) {
    world_obstacle *const obstacle = get_body(&world->model, body);
    double sums[BODY_AXES];
    vec3_store(sums, 0, vec3_add(obstacle->given_force, force));
    vec3_store(sums, 1, vec3_add(obstacle->given_torque, torque));
    tulle_status const status = check_numbers(
        obstacle->name,
        (given_numbers){"the sum of forces and torques", sums, BODY_AXES, -FORCE_MAX, FORCE_MAX},
        error);
    if (status != TULLE_OK) return status;
    obstacle->given_force = vec3_load(sums, 0);
    obstacle->given_torque = vec3_load(sums, 1);
    step_wake_body(&world->model, &world->now, body);
    return TULLE_OK;
}

tulle_status tulle_obstacle_add_force(tulle_world *world, tulle_obstacle_id id,
                                      const double point[3], const double force[3],
                                      tulle_error *error) {
    if (!force) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the force is null");
    uint32_t const body = find_free_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const char *const name = get_body(&world->model, body)->name;
    tulle_status status =
        check_numbers(name, (given_numbers){"force", force, 3, -FORCE_MAX, FORCE_MAX}, error);
    if (status == TULLE_OK && point)
        status = check_numbers(
            name, (given_numbers){"point", point, 3, -COORDINATE_MAX, COORDINATE_MAX}, error);
    if (status != TULLE_OK) return status;
    vec3 const centre = vec3_load(world->now.positions, get_first_slot(&world->model, body));
    vec3 const at = point ? vec3_load(point, 0) : centre, pull = vec3_load(force, 0);
    status = give(world, body, pull, vec3_cross(vec3_sub(at, centre), pull), error);
    if (status == TULLE_OK && world->recording)
        world_record(world, &(recorded_call){.kind = RECORD_FORCE,
                                             .ids = {id.index},
                                             .generations = {id.generation},
                                             .arrays = {{point, point ? 3 : 0}, {force, 3}}});
    return status;
}

tulle_status tulle_obstacle_add_torque(tulle_world *world, tulle_obstacle_id id,
                                       const double torque[3], tulle_error *error) {
    if (!torque) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the torque is null");
    uint32_t const body = find_free_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const char *const name = get_body(&world->model, body)->name;
    tulle_status status =
        check_numbers(name, (given_numbers){"torque", torque, 3, -FORCE_MAX, FORCE_MAX}, error);
    if (status != TULLE_OK) return status;
    status = give(world, body, vec3_make(0.0, 0.0, 0.0), vec3_load(torque, 0), error);
    if (status == TULLE_OK && world->recording)
        world_record(world, &(recorded_call){.kind = RECORD_TORQUE,
                                             .ids = {id.index},
                                             .generations = {id.generation},
                                             .arrays = {{torque, 3}}});
    return status;
}

/* ---- locks and drives ---- */

tulle_status tulle_obstacle_set_locks(tulle_world *world, tulle_obstacle_id id,
                                      unsigned translations, unsigned rotations,
                                      tulle_error *error) {
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    if (translations > TULLE_LOCK_ALL || rotations > TULLE_LOCK_ALL)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the locks are %u and %u; each must be a sum of TULLE_LOCK_X, _Y, _Z",
                         get_body(&world->model, body)->name, translations, rotations);
    world->model.controls[body].locks = translations | rotations << 3;
    if (body_answers(&world->model, &world->work, body))
        world_set_body_velocity(world, body,
                                world->now.velocities + 3 * get_first_slot(&world->model, body));
    step_wake_body(&world->model, &world->now, body);
    WORLD_RECORD(world, .kind = RECORD_LOCKS, RECORD_ID(id), .numbers = {translations, rotations});
    return TULLE_OK;
}

tulle_body_drive tulle_body_drive_default(void) {
    tulle_body_drive drive;
    fields_set_defaults(&body_drive_fields, &drive);
    return drive;
}

tulle_status tulle_obstacle_set_drive(tulle_world *world, tulle_obstacle_id id,
                                      const tulle_body_drive *drive, tulle_error *error) {
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    tulle_status const status =
        drive ? check_drive(get_body(&world->model, body)->name, drive, error) : TULLE_OK;
    if (status != TULLE_OK) return status;
    bool is_driven = false;
    for (int k = 0; drive && k < 3; k++)
        is_driven |= drive->stiffness[k] > 0.0 || drive->damping[k] > 0.0 ||
                     drive->angular_stiffness[k] > 0.0 || drive->angular_damping[k] > 0.0;
    body_control *const control = &world->model.controls[body];
    memset(&control->drive, 0, sizeof control->drive);
    if (is_driven) control->drive = *drive;
    control->is_driven = is_driven;
    step_wake_body(&world->model, &world->now, body);
    WORLD_RECORD(world, .kind = RECORD_DRIVE, RECORD_ID(id), .numbers = {drive != NULL},
                 .def.drive = drive ? *drive : control->drive);
    return TULLE_OK;
}

tulle_status tulle_obstacle_get_drive_force(const tulle_world *world, tulle_obstacle_id id,
                                            double force[3], double torque[3], tulle_error *error) {
    if (!force || !torque)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for the force");
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const double *const forces = world->now.drive_forces + BODY_AXES * (size_t)body;
    memcpy(force, forces, 3 * sizeof(double));
    memcpy(torque, forces + 3, 3 * sizeof(double));
    return TULLE_OK;
}

/* ---- in a state ---- */

size_t world_get_controls_size(const tulle_world *world) {
    bool has_any = false;
    for (size_t b = 0; b < world->model.body_count; b++)
        has_any |= world->model.controls[b].locks != 0 || world->model.controls[b].is_driven;
    return has_any ? world->model.body_count * sizeof *world->model.controls : 0;
}

uint64_t world_hash_controls(const tulle_world *world, uint64_t hash) {
    size_t const size = world_get_controls_size(world);
    return size > 0 ? hash_bytes(hash, world->model.controls, size) : hash;
}

tulle_status world_check_controls(const tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error) {
    bool is_valid = true;
    for (size_t b = 0; b < size / sizeof(body_control) && is_valid; b++) {
        body_control control;
        memcpy(&control, (const unsigned char *)bytes + b * sizeof control, sizeof control);
        is_valid = control.locks < 1u << BODY_AXES && control.is_driven <= 1 &&
                   (!control.is_driven || check_drive("", &control.drive, NULL) == TULLE_OK);
    }
    (void)world;
    if (is_valid) return TULLE_OK;
    return error_set(error, TULLE_ERROR_PARSE,
                     "the saved state has locks or drives that no body has: start the run again");
}

void world_take_controls(tulle_world *world, const void *bytes, size_t size) {
    if (world->model.body_count > 0)
        memset(world->model.controls, 0, world->model.body_count * sizeof *world->model.controls);
    if (size > 0) memcpy(world->model.controls, bytes, size);
}
