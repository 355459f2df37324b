/* Static and dynamic friction, friction across a grain and friction on a moving belt, against
 * closed forms of a rigid block: a 0.3 m patch on a plane, gravity tilted by the slope's angle. */
#include "support/contact_world.h"
#include "support/test_support.h"

#include <stdio.h>
#include <stdlib.h>

#define TIME_STEP (1.0 / 90.0)
#define CONTACT_DISTANCE 3e-3
#define DEGREE 0.017453292519943295
#define GRAVITY 9.81

typedef struct slope_case {
    double degrees; /* of the slope */
    double heading; /* [deg] of the direction of fall in the plane, from x, the grain */
    double static_friction, dynamic_friction;
    double across;      /* factor on friction across the grain */
    double start_speed; /* [m/s] down the slope */
    double belt_speed;  /* [m/s] of the plane along x */
} slope_case;

/* [s] Longer than any run. */
#define BELT_TIME 100.0

static vec3 find_heading(const slope_case *c) {
    return vec3_make(cos(c->heading * DEGREE), sin(c->heading * DEGREE), 0.0);
}

static void start_slope(contact_world *world, const slope_case *c) {
    *world = contact_world_make();
    world->def.contact_distance = CONTACT_DISTANCE;
    world->friction = c->static_friction;
    world->dynamic_friction = c->dynamic_friction;
    vec3 const heading = find_heading(c);
    world->def.gravity[0] = GRAVITY * sin(c->degrees * DEGREE) * heading.x;
    world->def.gravity[1] = GRAVITY * sin(c->degrees * DEGREE) * heading.y;
    world->def.gravity[2] = -GRAVITY * cos(c->degrees * DEGREE);
    world->material.friction_across = c->across;
    world->grain = vec3_make(2.0, 0.0, 0.0);
    tulle_keyframe const belt[2] = {{.rotation_vector = {0, 0, 0}},
                                    {BELT_TIME, {BELT_TIME * c->belt_speed, 0.0, 0.0}, {0, 0, 0}}};
    if (c->belt_speed != 0.0) world->motions[1] = (tulle_motion){.keys = belt, .key_count = 2};
    contact_grid patch = make_contact_grid(12, 12, vec3_make(-0.15, -0.15, CONTACT_DISTANCE),
                                           vec3_make(0.3, 0.0, 0.0), vec3_make(0.0, 0.3, 0.0));
    contact_grid plane = make_contact_grid(10, 9, vec3_make(-4.0, -4.03, 0.0),
                                           vec3_make(8.0, 0.0, 0.0), vec3_make(0.0, 8.0, 0.0));
    add_contact_surface(world, patch.mesh, false);
    add_contact_surface(world, plane.mesh, true);
    start_contact_world(world);
    for (size_t i = 0; i < world->cloth_vertex_count; i++)
        vec3_store(world->velocities, i, vec3_scale(heading, c->start_speed));
    for (size_t i = world->cloth_vertex_count; i < world->vertex_count; i++)
        vec3_store(world->velocities, i, vec3_make(c->belt_speed, 0.0, 0.0));
    free_contact_grid(&patch);
    free_contact_grid(&plane);
}

static vec3 mean_of(const contact_world *world, const double *values) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < world->cloth_vertex_count; i++)
        sum = vec3_add(sum, vec3_load(values, i));
    return vec3_scale(sum, 1.0 / (double)world->cloth_vertex_count);
}

typedef struct slope_result {
    vec3 drift;        /* [m] of the mean position since the start */
    vec3 velocity;     /* [m/s] mean at the end */
    vec3 acceleration; /* [m/s^2] mean of the second half */
} slope_result;

static slope_result run_slope(const slope_case *c, double seconds) {
    contact_world *const world = malloc(sizeof *world);
    assert_non_null(world);
    start_slope(world, c);
    int const steps = (int)(seconds / TIME_STEP + 0.5);
    vec3 const start = mean_of(world, world->x0);
    vec3 half = {0.0, 0.0, 0.0};
    for (int i = 0; i < steps; i++) {
        assert_int_equal(step_contact_world(world, TIME_STEP), TULLE_OK);
        if (i == steps / 2 - 1) half = mean_of(world, world->velocities);
    }
    assert_int_equal(judge_contact_world(world), 0);
    slope_result result = {.drift = vec3_sub(mean_of(world, world->x0), start),
                           .velocity = mean_of(world, world->velocities)};
    result.acceleration =
        vec3_scale(vec3_sub(result.velocity, half), 1.0 / ((steps - steps / 2) * TIME_STEP));
    print_message("%5.2f deg %.1f s, %.2f/%.2f x %.2f, heading %.0f, start %.2f: drift %.3g, speed "
                  "%.5g, acceleration (%.5g, %.5g), rescues %llu\n",
                  c->degrees, seconds, c->static_friction, c->dynamic_friction, c->across,
                  c->heading, c->start_speed, vec3_norm(result.drift), vec3_norm(result.velocity),
                  result.acceleration.x, result.acceleration.y,
                  (unsigned long long)world->rescue_count);
    contact_world_destroy(world);
    free(world);
    return result;
}

static double slide_acceleration(double degrees, double friction) {
    return GRAVITY * (sin(degrees * DEGREE) - friction * cos(degrees * DEGREE));
}

/* Critical angles: atan 0.6 = 30.96, atan 0.4 = 21.80 degrees. */
static void static_friction_holds_what_rests(void **state) {
    (void)state;
    slope_case const held[] = {
        {.degrees = 30.5, .static_friction = 0.6, .dynamic_friction = 0.4, .across = 1.0},
        {.degrees = 30.9, .static_friction = 0.6, .dynamic_friction = 0.4, .across = 1.0},
        {.degrees = 26.0, .static_friction = 0.5, .dynamic_friction = 0.0, .across = 1.0}};
    for (size_t i = 0; i < sizeof held / sizeof held[0]; i++) {
        slope_result const result = run_slope(&held[i], getenv("TULLE_TEST_LONG") ? 60.0 : 3.0);
        assert_true(vec3_norm(result.drift) < 1e-6);
    }
}

static void dynamic_friction_slows_what_slides(void **state) {
    (void)state;
    slope_case c = {
        .degrees = 31.0, .static_friction = 0.6, .dynamic_friction = 0.4, .across = 1.0};
    slope_result result = run_slope(&c, 2.0); /* starts by itself */
    assert_true(fabs(result.acceleration.x / slide_acceleration(31.0, 0.4) - 1.0) < 0.01);
    c.start_speed = 0.2;
    double const angles[] = {22.0, 25.0, 30.0};
    for (int i = 0; i < 3; i++) {
        c.degrees = angles[i];
        result = run_slope(&c, 2.0);
        double const expected = slide_acceleration(angles[i], 0.4);
        assert_true(fabs(result.acceleration.x - expected) < fmax(0.01 * expected, 1e-3));
        assert_true(result.velocity.x > 0.2);
    }
}

/* Deceleration to rest, and then for good: v / a = 0.53 s, v^2 / 2 a = 0.053 m. */
static void what_comes_to_rest_sticks_again(void **state) {
    (void)state;
    slope_case const c = {.degrees = 20.0,
                          .static_friction = 0.6,
                          .dynamic_friction = 0.4,
                          .across = 1.0,
                          .start_speed = 0.2};
    double const expected = -0.5 * 0.2 * 0.2 / slide_acceleration(20.0, 0.4);
    slope_result const result = run_slope(&c, 2.0), later = run_slope(&c, 4.0);
    assert_true(fabs(result.drift.x / expected - 1.0) < 0.03);
    assert_true(vec3_norm(vec3_sub(later.drift, result.drift)) < 1e-9);
    assert_true(vec3_norm(later.velocity) < 1e-12);
}

/* Onset: the pull per weight, tan of the slope's angle, reaches the ellipse's radius in its
 * direction. */
static void grain_decides_when_a_patch_slides(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        double const heading = 45.0 * i, c = cos(heading * DEGREE), s = sin(heading * DEGREE);
        double const radius = 0.6 / sqrt(c * c + 4.0 * s * s); /* across: half */
        double const critical = atan(radius) / DEGREE;
        slope_case held = {.degrees = critical - 0.3,
                           .heading = heading,
                           .static_friction = 0.6,
                           .dynamic_friction = 0.6,
                           .across = 0.5};
        assert_true(vec3_norm(run_slope(&held, 1.5).drift) < 1e-6);
        held.degrees = critical + 0.5;
        assert_true(vec3_norm(run_slope(&held, 1.0).velocity) > 0.02);
    }
}

/* Slip along n from rest meets friction g cos (a^2 n_x, b^2 n_y) / |(a n_x, b n_y)|; its direction
 * keeps when n is parallel to the acceleration. Solved here by bisection over the angle of n. */
static vec3 slide_across_grain(const slope_case *c) {
    double const a = c->dynamic_friction, b = a * c->across;
    vec3 const pull = vec3_scale(find_heading(c), GRAVITY * sin(c->degrees * DEGREE));
    double low = 0.0, high = 1.5707963267948966;
    vec3 acceleration = pull;
    for (int i = 0; i < 100; i++) {
        double const middle = 0.5 * (low + high), x = cos(middle), y = sin(middle);
        double const scale = GRAVITY * cos(c->degrees * DEGREE) / hypot(a * x, b * y);
        acceleration = vec3_sub(pull, vec3_make(scale * a * a * x, scale * b * b * y, 0.0));
        if (acceleration.x * y - acceleration.y * x > 0.0)
            high = middle;
        else
            low = middle;
    }
    return acceleration;
}

static void grain_turns_the_slide(void **state) {
    (void)state;
    double const headings[] = {0.0, 30.0, 60.0, 90.0, 30.0, 70.0};
    for (int i = 0; i < 6; i++) {
        slope_case const c = {.degrees = 40.0,
                              .heading = headings[i],
                              .static_friction = 0.6,
                              .dynamic_friction = 0.6,
                              .across = i < 4 ? 0.5 : 0.1};
        vec3 const expected = slide_across_grain(&c);
        slope_result const result = run_slope(&c, 0.8);
        vec3 const error = vec3_sub(result.acceleration, expected);
        print_message("expected (%.5g, %.5g)\n", expected.x, expected.y);
        assert_true(vec3_norm(error) < 0.01 * vec3_norm(expected));
    }
}

/* On a level belt: acceleration mu_d g up to the belt's speed, then along with it. */
static void a_belt_takes_cloth_along(void **state) {
    (void)state;
    slope_case const c = {
        .static_friction = 0.5, .dynamic_friction = 0.3, .across = 1.0, .belt_speed = 1.5};
    slope_result const early = run_slope(&c, 0.4), late = run_slope(&c, 1.5);
    assert_true(fabs(early.acceleration.x / (0.3 * GRAVITY) - 1.0) < 0.01);
    assert_true(fabs(early.velocity.x / (0.4 * 0.3 * GRAVITY) - 1.0) < 0.01);
    assert_true(fabs(late.velocity.x - 1.5) < 1e-9);
    double const catch_up = 1.5 / (0.3 * GRAVITY);
    double const way = 1.5 * 1.5 - 0.5 * 1.5 * catch_up;
    assert_true(fabs(late.drift.x / way - 1.0) < 0.01);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(static_friction_holds_what_rests),
        cmocka_unit_test(dynamic_friction_slows_what_slides),
        cmocka_unit_test(what_comes_to_rest_sticks_again),
        cmocka_unit_test(grain_decides_when_a_patch_slides),
        cmocka_unit_test(grain_turns_the_slide),
        cmocka_unit_test(a_belt_takes_cloth_along),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
