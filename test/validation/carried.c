/* carried.c - cloth on moving obstacles: friction acts relative to their surface. A lift, a waggon,
 * a conveyor belt, and a sheet pinched by two cylinders. */
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double FRICTION = 0.5;
/* [s] */
static const double FINE_STEP = 1.0 / 360.0;

typedef struct ride {
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id carrier;
} ride;

static ride make_ride(validation_run *run, const tulle_motion *motion, double length) {
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    ride made = {.world = validate_make_world(run, &def)};
    uint32_t const count = validate_options(run)->is_quick ? 9 : 16;
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {0.3, 0.3},
                                            .counts = {count, count},
                                            .middle = {0.0, 0.0, CONTACT_DISTANCE}});
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.material.friction = FRICTION;
    made.cloth = validate_add_cloth(run, made.world, &cloth);
    tulle_mesh *const plane =
        stage_make_sheet(run, (stage_sheet){.size = {length, 1.0},
                                            .counts = {(uint32_t)lround(3.0 * length) + 2, 4},
                                            .middle = {0.013, 0.017, 0.0}});
    tulle_obstacle_def carrier = tulle_obstacle_def_default();
    carrier.mesh = tulle_mesh_get_view(plane);
    carrier.friction = FRICTION;
    carrier.motion = *motion;
    made.carrier = validate_add_obstacle(run, made.world, &carrier);
    return made;
}

/* A place in the frame of the plane that carries the cloth, along its sides from its first vertex.
 */
static void find_place_on_plane(const ride *made, const double place[3], double on_plane[2]) {
    size_t count = 0;
    const double *const x = tulle_obstacle_get_positions(made->world, made->carrier, &count);
    const double *const ends[2] = {x + 3 * (count / 4 - 1), x + 3 * (count - count / 4)};
    for (int a = 0; a < 2; a++) {
        double along = 0.0, length2 = 0.0;
        for (int c = 0; c < 3; c++) {
            along += (place[c] - x[c]) * (ends[a][c] - x[c]);
            length2 += (ends[a][c] - x[c]) * (ends[a][c] - x[c]);
        }
        on_plane[a] = along / sqrt(length2);
    }
}

/* Mean place of the cloth relative to the first vertex of its carrier. */
static void find_place(const ride *made, double place[3]) {
    const double *const carrier = tulle_obstacle_get_positions(made->world, made->carrier, NULL);
    validate_mean_position(made->world, made->cloth, place);
    for (int c = 0; c < 3; c++) place[c] -= carrier[c];
}

/* Rides along eased keys there and back; returns the farthest way [m] along each axis. */
static void ride_along(validation_run *run, double x, double z, double farthest[3]) {
    tulle_keyframe const keys[4] = {stage_key(0.3, 0.0, 0.0, 0.0), stage_key(2.3, x, 0.0, z),
                                    stage_key(2.6, x, 0.0, z), stage_key(4.6, 0.0, 0.0, 0.0)};
    tulle_motion const motion = {.keys = keys, .key_count = 4, .is_eased = 1};
    ride const made = make_ride(run, &motion, 2.0);
    validate_simulate(run, made.world, 0.2);
    double start[3];
    find_place(&made, start);
    for (int c = 0; c < 3; c++) farthest[c] = 0.0;
    for (int i = 0; i < 430; i++) {
        validate_step(run, made.world, VALIDATION_STEP);
        double place[3];
        find_place(&made, place);
        for (int c = 0; c < 3; c++) farthest[c] = fmax(farthest[c], fabs(place[c] - start[c]));
    }
}

static void goes_with_lift(validation_run *run) {
    double farthest[3];
    ride_along(run, 0.0, 2.0, farthest);
    validate_row(run, "lift, 2 m up and down at up to 3 m/s^2: farthest off it, up", farthest[2],
                 "m", at_most(1e-4), "under g it stays in contact");
    validate_row(run, "the same, sideways", hypot(farthest[0], farthest[1]), "m", at_most(1e-6),
                 "nothing pulls that way");
}

static void goes_with_waggon(validation_run *run) {
    double farthest[3];
    ride_along(run, 2.0, 0.0, farthest);
    validate_row(run, "waggon, 2 m at up to 3 m/s^2: farthest off its place",
                 hypot(farthest[0], farthest[1]), "m", at_most(1e-4), "mu g = 4.9 m/s^2 holds it");
}

/* A plane that turns about an axis in it, by less than the critical angle and back: what lies on it
 * at a distance turns with it and does not go along it. */
static void goes_with_tilt(validation_run *run) {
    double const angle = 20.0 * VALIDATION_DEGREE;
    tulle_keyframe keys[5];
    for (int i = 0; i < 5; i++) {
        keys[i] = stage_key(0.3 + 0.5 * i, 0.0, 0.0, 0.0);
        keys[i].rotation_vector[1] = i % 2 ? angle : 0.0;
    }
    tulle_motion const motion = {.keys = keys, .key_count = 5, .is_eased = 1};
    ride const made = make_ride(run, &motion, 1.0);
    validate_simulate(run, made.world, 0.2);
    double place[3], start[2], now[2], farthest = 0.0;
    validate_mean_position(made.world, made.cloth, place);
    find_place_on_plane(&made, place, start);
    for (int i = 0; i < 225; i++) {
        validate_step(run, made.world, VALIDATION_STEP);
        validate_mean_position(made.world, made.cloth, place);
        find_place_on_plane(&made, place, now);
        farthest = fmax(farthest, hypot(now[0] - start[0], now[1] - start[1]));
    }
    validate_row(run, "plane that tilts by 20 degrees and back: farthest off its place", farthest,
                 "m", at_most(5e-6), "tan 20 < mu; the gap times the angle is 1.0e-3 m");
}

/* A belt that runs at `speed` from the start on. */
static void is_taken_by_belt(validation_run *run) {
    double const speed = 2.0, drive = FRICTION * VALIDATION_GRAVITY;
    tulle_keyframe const keys[2] = {stage_key(0.0, 0.0, 0.0, 0.0),
                                    stage_key(10.0, 10.0 * speed, 0.0, 0.0)};
    tulle_motion const motion = {.keys = keys, .key_count = 2};
    ride const made = make_ride(run, &motion, 20.0);
    double start[3], place[3], velocity[3];
    find_place(&made, start);
    long const half = lround(0.5 * speed / drive / FINE_STEP);
    for (long i = 0; i < half; i++) validate_step(run, made.world, FINE_STEP);
    validate_mean_velocity(made.world, made.cloth, velocity);
    validate_row(run, "belt of 2 m/s: acceleration of a cloth put on it",
                 velocity[0] / ((double)half * FINE_STEP), "m/s^2", within(drive, 0.01), "mu g");
    for (long i = 0; i < 3 * half; i++) validate_step(run, made.world, FINE_STEP);
    find_place(&made, place);
    validate_mean_velocity(made.world, made.cloth, velocity);
    validate_row(run, "way that it slips", start[0] - place[0], "m",
                 within(0.5 * speed * speed / drive, 0.02), "v^2 / (2 mu g)");
    validate_row(run, "its speed afterwards less the belt's", fabs(velocity[0] - speed), "m/s",
                 at_most(1e-6), "it rides");
    start[0] = place[0];
    for (long i = 0; i < 360; i++) validate_step(run, made.world, FINE_STEP);
    find_place(&made, place);
    validate_row(run, "its drift on the belt in 1 s more", fabs(place[0] - start[0]), "m",
                 at_most(1e-6), "it sticks");
}

const experiment carried_experiments[] = {
    {"carried.lift", "a cloth on a lift goes with it", goes_with_lift, false},
    {"carried.waggon", "a cloth on a waggon that accelerates under mu g goes with it",
     goes_with_waggon, false},
    {"carried.tilt", "a cloth on a plane that tilts goes with it", goes_with_tilt, false},
    {"carried.belt", "a conveyor belt takes a cloth along by friction", is_taken_by_belt, false},
    {0},
};
