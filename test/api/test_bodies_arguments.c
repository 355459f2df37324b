/* Arguments of the public functions of tulle/bodies.h, against a world that has started, with a
 * body that is free, one that follows its script and an obstacle that is none, and against one that
 * has not started. */
#include "api/arguments.h"
#include "support/body_world.h"

static tulle_world *started, *fresh;
static tulle_obstacle_id fixed, body, scripted;

static tulle_world *make_world(void) {
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh ground = bodies_make_box(2.0, 2.0, 0.1, (double[]){0.0, 0.0, -0.05});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.0, 0.0, 0.2});
    tulle_mesh other = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.5, 0.0, 0.2});
    tulle_body def_body = {.is_dynamic = 1, .mass = 1.0};
    fixed = bodies_add_obstacle(world, &ground, 0.5, NULL);
    body = bodies_add_obstacle(world, &box, 0.5, &def_body);
    def_body.start_time = 10.0;
    scripted = bodies_add_obstacle(world, &other, 0.5, &def_body);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&other);
    return world;
}

static uint64_t first_hash;

static int set_up(void **unused) {
    (void)unused;
    started = make_world();
    fresh = make_world();
    FINE(tulle_world_start(started, &error));
    first_hash = tulle_world_get_state_hash(started);
    return 0;
}

/* Nothing that was refused has changed the world, and no force is waiting in it. */
static int tear_down(void **unused) {
    (void)unused;
    assert_true(tulle_world_get_state_hash(started) == first_hash);
    FINE(tulle_world_step(started, 0.01, NULL, &error));
    FINE(tulle_world_step(fresh, 0.01, NULL, &error));
    assert_true(tulle_world_get_state_hash(started) == tulle_world_get_state_hash(fresh));
    tulle_world_destroy(started);
    tulle_world_destroy(fresh);
    return 0;
}

static const tulle_obstacle_id bad_bodies[] = {{1, 0}, {1, 2}, {3, 1}, {UINT32_MAX, 1}, {0, 1}};
enum { BAD_BODY_COUNT = sizeof bad_bodies / sizeof bad_bodies[0] }; /* the last is no body */
static double const zero[3] = {0.0, 0.0, 0.0};

ARGUMENTS_OF(tulle_obstacle_set_velocity) {
    REFUSED(tulle_obstacle_set_velocity(NULL, body, zero, zero, &error));
    REFUSED(tulle_obstacle_set_velocity(fresh, body, zero, zero, &error));
    REFUSED(tulle_obstacle_set_velocity(started, scripted, zero, zero, &error));
    for (int i = 0; i < BAD_BODY_COUNT; i++)
        REFUSED(tulle_obstacle_set_velocity(started, bad_bodies[i], zero, zero, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 3; k++) {
            double numbers[3] = {1.0, 1.0, 1.0};
            numbers[k] = no_numbers[i];
            REFUSED(tulle_obstacle_set_velocity(started, body, numbers, NULL, &error));
            REFUSED(tulle_obstacle_set_velocity(started, body, zero, numbers, &error));
        }
    FINE(tulle_obstacle_set_velocity(started, body, NULL, NULL, &error));
    assert_int_equal(tulle_obstacle_set_velocity(NULL, body, NULL, NULL, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
}

ARGUMENTS_OF(tulle_obstacle_add_force) {
    REFUSED(tulle_obstacle_add_force(NULL, body, zero, zero, &error));
    REFUSED(tulle_obstacle_add_force(started, body, zero, NULL, &error));
    REFUSED(tulle_obstacle_add_force(fresh, body, zero, zero, &error));
    REFUSED(tulle_obstacle_add_force(started, scripted, zero, zero, &error));
    for (int i = 0; i < BAD_BODY_COUNT; i++)
        REFUSED(tulle_obstacle_add_force(started, bad_bodies[i], zero, zero, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 3; k++) {
            double numbers[3] = {1.0, 1.0, 1.0};
            numbers[k] = no_numbers[i];
            REFUSED(tulle_obstacle_add_force(started, body, NULL, numbers, &error));
            REFUSED(tulle_obstacle_add_force(started, body, numbers, zero, &error));
        }
    /* what is right by itself, with too long an arm or too large a sum */
    double const far[3] = {1e99, 0.0, 0.0}, up[3] = {0.0, 0.0, 0.9e12};
    REFUSED(tulle_obstacle_add_force(started, body, far, up, &error));
    FINE(tulle_obstacle_add_force(started, body, NULL, up, &error));
    REFUSED(tulle_obstacle_add_force(started, body, NULL, up, &error));
    FINE(tulle_obstacle_add_force(started, body, NULL, (double[]){0, 0, -0.9e12}, &error));
    FINE(tulle_obstacle_add_force(started, body, zero, zero, &error));
}

ARGUMENTS_OF(tulle_obstacle_add_torque) {
    REFUSED(tulle_obstacle_add_torque(NULL, body, zero, &error));
    REFUSED(tulle_obstacle_add_torque(started, body, NULL, &error));
    REFUSED(tulle_obstacle_add_torque(fresh, body, zero, &error));
    REFUSED(tulle_obstacle_add_torque(started, scripted, zero, &error));
    for (int i = 0; i < BAD_BODY_COUNT; i++)
        REFUSED(tulle_obstacle_add_torque(started, bad_bodies[i], zero, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        for (int k = 0; k < 3; k++) {
            double numbers[3] = {1.0, 1.0, 1.0};
            numbers[k] = no_numbers[i];
            REFUSED(tulle_obstacle_add_torque(started, body, numbers, &error));
        }
    FINE(tulle_obstacle_add_torque(started, body, zero, &error));
}

ARGUMENTS_OF(tulle_obstacle_set_locks) {
    REFUSED(tulle_obstacle_set_locks(NULL, body, 1, 1, &error));
    REFUSED(tulle_obstacle_set_locks(fresh, body, 1, 1, &error));
    for (int i = 0; i < BAD_BODY_COUNT; i++)
        REFUSED(tulle_obstacle_set_locks(started, bad_bodies[i], 1, 1, &error));
    unsigned const none[] = {8, 15, 64, UINT_MAX};
    for (int i = 0; i < 4; i++) {
        REFUSED(tulle_obstacle_set_locks(started, body, none[i], 0, &error));
        REFUSED(tulle_obstacle_set_locks(started, body, 0, none[i], &error));
    }
    FINE(tulle_obstacle_set_locks(started, scripted, 7, 7, &error)); /* for when it comes free */
    FINE(tulle_obstacle_set_locks(started, scripted, 0, 0, &error));
}

ARGUMENTS_OF(tulle_body_drive_default) {
    tulle_body_drive const drive = tulle_body_drive_default();
    FINE(tulle_obstacle_set_drive(started, body, &drive, &error));
}

ARGUMENTS_OF(tulle_obstacle_set_drive) {
    tulle_body_drive drive = tulle_body_drive_default();
    REFUSED(tulle_obstacle_set_drive(NULL, body, &drive, &error));
    REFUSED(tulle_obstacle_set_drive(fresh, body, &drive, &error));
    for (int i = 0; i < BAD_BODY_COUNT; i++)
        REFUSED(tulle_obstacle_set_drive(started, bad_bodies[i], &drive, &error));
    static const double no_rotations[][4] = {
        {0.0, 0.0, 0.0, 0.0}, {0.0, 2.0, 0.0, 0.0}, {1.0, 2e-3, 0.0, 0.0}, {(double)NAN, 0, 0, 0}};
    for (int i = 0; i < 4; i++) {
        memcpy(drive.rotation, no_rotations[i], sizeof no_rotations[i]);
        REFUSED(tulle_obstacle_set_drive(started, body, &drive, &error));
    }
    FINE(tulle_obstacle_set_drive(started, scripted, NULL, &error));
    FINE(tulle_obstacle_set_drive(started, body, NULL, &error));
}

ARGUMENTS_OF(tulle_obstacle_get_drive_force) {
    double force[3], torque[3];
    REFUSED(tulle_obstacle_get_drive_force(NULL, body, force, torque, &error));
    REFUSED(tulle_obstacle_get_drive_force(fresh, body, force, torque, &error));
    REFUSED(tulle_obstacle_get_drive_force(started, body, NULL, torque, &error));
    REFUSED(tulle_obstacle_get_drive_force(started, body, force, NULL, &error));
    for (int i = 0; i < BAD_BODY_COUNT; i++)
        REFUSED(tulle_obstacle_get_drive_force(started, bad_bodies[i], force, torque, &error));
    FINE(tulle_obstacle_get_drive_force(started, body, force, torque, &error));
    for (int k = 0; k < 3; k++) assert_true(force[k] == 0.0 && torque[k] == 0.0);
}

int main(void) { return run_arguments(HEADERS("tulle/bodies.h"), set_up, tear_down); }
