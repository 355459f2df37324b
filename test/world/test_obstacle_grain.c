/* Friction across the grain of an obstacle through the public interface, against closed forms of a
 * rigid block: a patch, or a rigid box, on a large plane that has the grain; gravity is tilted by
 * the slope's angle. The grain goes with the plane's motion and deformation. */
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define GRAVITY 9.81
#define DEGREE 0.017453292519943295
static const double STEP = 1.0 / 90.0; /* [s] */
static const double CONTACT_DISTANCE = 3e-3;
static const double FRICTION = 0.6;
static const double HALF = 0.5; /* factor across */

/* How the plane comes to lie as it does at time 0. */
typedef enum plane_motion {
    PLANE_STANDS,
    PLANE_WAS_TURNED,  /* by 90 degrees about z, by keyframes */
    PLANE_WAS_REFRAMED /* the same by a mesh sequence */
} plane_motion;

typedef struct grain_case {
    double degrees, heading; /* of the slope; of the fall, from x */
    double across;           /* factor of the plane's grain, which is along x at motion zero */
    double cloth_across;     /* factor of the patch's, which is along y */
    plane_motion motion;
    int has_law; /* a law of the pair with half the friction */
    int is_box;  /* a rigid box of 0.2 m instead of the patch */
} grain_case;

static const tulle_mesh *framed_plane;

/* Frame 0: as made, frame 1: turned by 90 degrees. */
static tulle_status read_plane(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    (void)context, (void)error;
    for (size_t v = 0; v < framed_plane->vertex_count; v++) {
        const double *const p = framed_plane->positions + 3 * v;
        positions[3 * v] = frame == 0 ? p[0] : -p[1];
        positions[3 * v + 1] = frame == 0 ? p[1] : p[0];
        positions[3 * v + 2] = p[2];
    }
    return TULLE_OK;
}

static const tulle_keyframe TURNED[2] = {
    {.time = -1.0, .rotation_vector = {0, 0, 0}},
    {.time = 0.0, .rotation_vector = {0.0, 0.0, 1.5707963267948966}}};

static tulle_obstacle_id add_plane(tulle_world *world, const grain_case *c, tulle_motion motion) {
    tulle_mesh plane = small_sheet(6.0, 10, 0.0);
    for (size_t i = 0; i < plane.vertex_count; i++) /* its vertices are not below the patch's */
        plane.positions[3 * i] += 0.013, plane.positions[3 * i + 1] += 0.027;
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_obstacle_id id = {0};
    def.mesh = tulle_mesh_get_view(&plane);
    def.friction = FRICTION;
    def.friction_across = c->across;
    def.grain[0] = 3.0;
    def.motion = motion;
    if (c->motion == PLANE_WAS_TURNED) def.motion = (tulle_motion){.keys = TURNED, .key_count = 2};
    if (c->motion == PLANE_WAS_REFRAMED) {
        framed_plane = &plane;
        def.read_frame = read_plane;
        def.frame_count = 2;
        def.frame_start_time = -1.0;
        def.frame_interval = 1.0;
    }
    tulle_error error = {0};
    if (tulle_world_add_obstacle(world, &def, &id, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    if (c->motion == PLANE_WAS_REFRAMED) /* its frames are read now, while the plane is there */
        assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    tulle_mesh_destroy(&plane);
    return id;
}

static tulle_cloth_id add_patch(tulle_world *world, double across) {
    tulle_mesh patch = small_sheet(0.3, 11, CONTACT_DISTANCE);
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_cloth_id id = {0};
    def.mesh = tulle_mesh_get_view(&patch);
    def.material.friction = FRICTION;
    def.material.air_damping = 0.0;
    def.material.friction_across = across;
    def.grain[0] = 0.0;
    def.grain[1] = 1.0;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, NULL), TULLE_OK);
    tulle_mesh_destroy(&patch);
    return id;
}

static tulle_obstacle_id add_box(tulle_world *world) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 0.2;
    shape.size[2] = 0.05;
    tulle_mesh box = small_shape(shape, 0.0, 0.0, 0.025 + CONTACT_DISTANCE);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_obstacle_id id = {0};
    def.mesh = tulle_mesh_get_view(&box);
    def.friction = FRICTION;
    def.body.is_dynamic = 1;
    def.body.mass = 1.0;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    tulle_mesh_destroy(&box);
    return id;
}

static tulle_world *make_world(double degrees, double heading) {
    tulle_world_def def = tulle_world_def_default();
    tulle_world *world = NULL;
    def.contact_distance = CONTACT_DISTANCE;
    def.gravity[0] = GRAVITY * sin(degrees * DEGREE) * cos(heading * DEGREE);
    def.gravity[1] = GRAVITY * sin(degrees * DEGREE) * sin(heading * DEGREE);
    def.gravity[2] = -GRAVITY * cos(degrees * DEGREE);
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

/* Mean velocity of a patch [m/s]. */
static void find_velocity(const tulle_world *world, tulle_cloth_id patch, double mean[2]) {
    size_t count;
    const double *const v = tulle_cloth_get_velocities(world, patch, &count);
    mean[0] = mean[1] = 0.0;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 2; k++) mean[k] += v[3 * i + k] / (double)count;
}

/* [m/s^2] Mean acceleration between 0.2 and 0.6 s. */
static void run(const grain_case *c, double acceleration[2]) {
    tulle_world *const world = make_world(c->degrees, c->heading);
    tulle_cloth_id patch = {0};
    tulle_obstacle_id box = {0};
    if (c->is_box)
        box = add_box(world);
    else
        patch = add_patch(world, c->cloth_across);
    tulle_obstacle_id const plane = add_plane(world, c, (tulle_motion){0});
    if (c->has_law)
        assert_int_equal(
            tulle_world_set_cloth_obstacle_law(
                world, patch, plane, &(tulle_contact_law){0.5 * FRICTION, -1.0, 0.0}, NULL),
            TULLE_OK);
    double velocity[2][2] = {{0.0}};
    for (int i = 0; i < 54; i++) {
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, NULL, &error) != TULLE_OK) fail_msg("%s", error.message);
        double *const now = velocity[i >= 18];
        tulle_transform transform;
        if (c->is_box) {
            assert_int_equal(tulle_obstacle_get_transform(world, box, &transform, NULL), TULLE_OK);
            memcpy(now, transform.velocity, 2 * sizeof(double));
        } else {
            find_velocity(world, patch, now);
        }
    }
    for (int k = 0; k < 2; k++) acceleration[k] = (velocity[1][k] - velocity[0][k]) / (36.0 * STEP);
    print_message(
        "%.2f degrees towards %.0f, across %.2f and %.2f, motion %d: (%.5g, %.5g) m/s^2\n",
        c->degrees, c->heading, c->across, c->cloth_across, (int)c->motion, acceleration[0],
        acceleration[1]);
    tulle_world_destroy(world);
}

/* The coefficient in the direction of the fall: along is 1 with the grain, 0 across it. */
static void expect_slide(const grain_case *c, double friction) {
    double a[2];
    run(c, a);
    double const along = a[0] * cos(c->heading * DEGREE) + a[1] * sin(c->heading * DEGREE);
    double const aside = a[1] * cos(c->heading * DEGREE) - a[0] * sin(c->heading * DEGREE);
    double const expected =
        GRAVITY * (sin(c->degrees * DEGREE) - friction * cos(c->degrees * DEGREE));
    if (expected > 0.0)
        assert_true(fabs(along / expected - 1.0) < 0.01 && fabs(aside) < 0.01 * expected);
    else
        assert_true(hypot(along, aside) < 1e-5);
}

/* Critical angles: 30.96 degrees along, 16.70 across. */
static void a_patch_sticks_along_and_slides_across(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        int const is_across = i == 1;
        double const friction = is_across ? HALF * FRICTION : FRICTION;
        grain_case c = {.heading = 90.0 * i, .across = HALF, .cloth_across = 1.0};
        double const critical = atan(friction) / DEGREE;
        double const slopes[] = {critical - 0.3, critical + 0.7, 38.0};
        for (int k = 0; k < 3; k++) {
            c.degrees = slopes[k];
            expect_slide(&c, friction);
        }
    }
}

/* A factor over 1 holds across the grain what slides along it. */
static void a_patch_sticks_across_and_slides_along(void **state) {
    (void)state;
    grain_case c = {.degrees = 38.0, .across = 1.5, .cloth_across = 1.0};
    expect_slide(&c, FRICTION);
    c.heading = 90.0;
    expect_slide(&c, 1.5 * FRICTION);
}

static void a_turned_plane_brings_its_grain(void **state) {
    (void)state;
    plane_motion const motions[] = {PLANE_WAS_TURNED, PLANE_WAS_REFRAMED};
    for (int i = 0; i < 2; i++) {
        grain_case c = {.degrees = 25.0, .across = HALF, .cloth_across = 1.0};
        c.motion = motions[i];
        expect_slide(&c, HALF * FRICTION); /* along x, across the grain now */
        c.heading = 90.0;
        expect_slide(&c, FRICTION);
    }
}

/* Factors of both sides and the law of a pair multiply: the patch's grain is along y. */
static void factors_multiply(void **state) {
    (void)state;
    grain_case c = {.degrees = 20.0, .heading = 90.0, .across = HALF, .cloth_across = 1.0};
    c.has_law = 1;
    expect_slide(&c, 0.5 * HALF * FRICTION);
    c.has_law = 0;
    c.cloth_across = 0.25; /* counts along x only */
    expect_slide(&c, HALF * FRICTION);
    c.heading = 0.0;
    expect_slide(&c, 0.25 * FRICTION);
}

static void a_rigid_box_slides_across(void **state) {
    (void)state;
    grain_case c = {.degrees = 25.0, .across = HALF, .is_box = 1};
    expect_slide(&c, FRICTION);
    c.heading = 90.0;
    expect_slide(&c, HALF * FRICTION);
}

/* The plane turns under a slope of 24 degrees and takes the patch along until its grain has turned
 * so far from the fall that friction there is less than the pull: t = tan 24 degrees = mu /
 * sqrt(cos^2 + sin^2 / HALF^2). The turn is slow: what swings the patch is under 0.3% of gravity.
 */
static void a_patch_lets_go_when_the_grain_has_turned(void **state) {
    (void)state;
    double const pull = tan(24.0 * DEGREE), ratio = FRICTION / pull;
    double const sine = sqrt((ratio * ratio - 1.0) / (1.0 / (HALF * HALF) - 1.0));
    double const expected = asin(sine) / DEGREE;
    tulle_keyframe const keys[2] = {
        {.time = 0.0, .rotation_vector = {0, 0, 0}},
        {.time = 8.0, .rotation_vector = {0.0, 0.0, 1.5707963267948966}}};
    grain_case const c = {.degrees = 24.0, .across = HALF, .cloth_across = 1.0};
    tulle_world *const world = make_world(c.degrees, c.heading);
    tulle_cloth_id const patch = add_patch(world, c.cloth_across);
    add_plane(world, &c, (tulle_motion){.keys = keys, .key_count = 2, .is_eased = 1});
    double found = 0.0, velocity[2];
    for (int i = 0; i < 720 && !(found > 0.0); i++) {
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        find_velocity(world, patch, velocity);
        double const s = 0.125 * tulle_world_get_time(world);
        if (velocity[0] > 1e-3) found = 90.0 * s * s * (3.0 - 2.0 * s);
    }
    print_message("lets go at %.2f degrees, expected %.2f\n", found, expected);
    assert_true(fabs(found - expected) < 2.0);
    tulle_world_destroy(world);
}

static void a_grain_without_direction_is_refused(void **state) {
    (void)state;
    tulle_world *const world = make_world(0.0, 0.0);
    tulle_mesh plane = small_sheet(1.0, 3, 0.0);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_obstacle_id id;
    tulle_error error = {0};
    def.mesh = tulle_mesh_get_view(&plane);
    double const grains[][3] = {
        {0.0, 0.0, 0.0}, {0.0, 0.0, 2.0}, {(double)NAN, 0.0, 0.0}, {0.0, 1e-5, 1.0}};
    for (int i = 0; i < 4; i++) {
        memcpy(def.grain, grains[i], sizeof def.grain);
        def.friction_across = 0.5;
        int const is_refused = tulle_world_add_obstacle(world, &def, &id, &error) != TULLE_OK;
        assert_int_equal(is_refused, i < 3);
        if (is_refused) assert_non_null(strstr(error.message, "grain"));
    }
    def.friction_across = -0.1;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "friction_across is -0.1"));
    tulle_mesh_destroy(&plane);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_patch_sticks_along_and_slides_across),
        cmocka_unit_test(a_patch_sticks_across_and_slides_along),
        cmocka_unit_test(a_turned_plane_brings_its_grain),
        cmocka_unit_test(factors_multiply),
        cmocka_unit_test(a_rigid_box_slides_across),
        cmocka_unit_test(a_patch_lets_go_when_the_grain_has_turned),
        cmocka_unit_test(a_grain_without_direction_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
