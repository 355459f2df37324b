/* Gravity, wind and laws of pairs that the host changes while the world runs: closed forms, worlds
 * that have them from the start, and saved states. */
#include "tulle/live.h"

#include "base/hash.h"
#include "support/body_world.h"
#include "support/paper_options.h"
#include "support/pins.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static const double MOON[3] = {0.5, 0.0, -1.625}, EARTH[3] = {0.0, 0.0, -9.8125};

static void expect(tulle_status wanted, tulle_status status, const tulle_error *error) {
    if (status != wanted)
        fail_msg("status %d, not %d: %s", (int)status, (int)wanted, error->message);
}

static void step(tulle_world *world, int count) {
    tulle_error error = {0};
    for (int i = 0; i < count; i++)
        expect(TULLE_OK, tulle_world_step(world, STEP, NULL, &error), &error);
}

static void set_gravity(tulle_world *world, const double gravity[3]) {
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_set_gravity(world, gravity, &error), &error);
}

static void set_wind(tulle_world *world, const tulle_wind *wind) {
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_set_wind(world, wind, &error), &error);
}

static const tulle_contact_law ICE = {0.0, 0.0, 0.0}, RUBBER = {0.9, 0.9, 0.0};

/* Of the sheet and the ground, the first obstacle. */
static void set_law(tulle_world *world, const tulle_contact_law *law) {
    tulle_error error = {0};
    expect(TULLE_OK,
           tulle_world_set_cloth_obstacle_law(world, (tulle_cloth_id){0, 1},
                                              (tulle_obstacle_id){0, 1}, law, &error),
           &error);
}

/* A sheet that hangs by a corner, with a box below that sleeps on the ground. */
static tulle_world *make_world(const double gravity[3], const tulle_wind *wind, bool is_pinned) {
    tulle_world_def def = tulle_world_def_default();
    memcpy(def.gravity, gravity, sizeof def.gravity);
    def.wind = *wind;
    change_paper(&def)->cg_tolerance = 1e-12;
    def.threads = 1;
    tulle_world *world = NULL;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    tulle_mesh sheet = small_sheet(0.25, 7, 2.0);
    uint32_t const corner = 0;
    tulle_pin const pin = make_pin(&corner, 1, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.air_damping = 0.0;
    cloth.pins = &pin;
    cloth.pin_count = is_pinned;
    expect(TULLE_OK, tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    tulle_mesh ground = bodies_make_box(1.0, 1.0, 0.1, (double[]){0, 0, -0.05});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0, 0, 0.055});
    small_add_obstacle(world, &ground);
    tulle_body const body = {
        .is_dynamic = 1, .density = 300.0, .sleep_speed = 0.05, .sleep_time = 0.1};
    bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&box);
    return world;
}

static tulle_wind make_wind(double x, double drag) {
    tulle_wind wind = tulle_world_def_default().wind;
    wind.velocity[0] = x;
    wind.drag_coefficient = drag;
    return wind;
}

static const double *get_positions(const tulle_world *world, size_t *count) {
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, count);
    *count *= 3;
    return x;
}

static void assert_same_cloth(const tulle_world *a, const tulle_world *b) {
    size_t count;
    const double *const x = get_positions(a, &count), *const y = get_positions(b, &count);
    assert_memory_equal(x, y, count * sizeof *x);
}

/* Nothing but gravity acts: the speed is the sum of what each step added. */
static void cloth_falls_as_gravity_says(void **state) {
    (void)state;
    tulle_wind const vacuum = make_wind(0.0, 0.0);
    tulle_world *const world = make_world(EARTH, &vacuum, false);
    step(world, 5);
    set_gravity(world, MOON);
    step(world, 7);
    set_gravity(world, EARTH);
    step(world, 2);
    size_t count;
    const double *const v = tulle_cloth_get_velocities(world, (tulle_cloth_id){0, 1}, &count);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3; k++)
            if (!(fabs(v[3 * i + k] - STEP * (7.0 * EARTH[k] + 7.0 * MOON[k])) < 1e-9))
                fail_msg("%g m/s along %zu", v[3 * i + k], k);
    tulle_world_destroy(world);
}

/* Set before the start it is the def's to the hash; set right after it, it moves the same. */
static void a_change_is_as_if_the_def_had_it(void **state) {
    (void)state;
    tulle_wind const calm = make_wind(0.0, 0.7);
    tulle_wind storm = make_wind(8.0, 1.2);
    storm.gust_strength = 2.0;
    tulle_world *const other = make_world(MOON, &storm, true);
    tulle_world *const before = make_world(EARTH, &calm, true);
    tulle_world *const after = make_world(EARTH, &calm, true);
    tulle_world *const unchanged = make_world(EARTH, &calm, true);
    set_gravity(before, MOON);
    set_wind(before, &storm);
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_start(after, &error), &error);
    uint64_t const hash = tulle_world_get_state_hash(after);
    set_gravity(after, EARTH); /* as it is */
    assert_true(tulle_world_get_state_hash(after) == hash);
    set_gravity(after, MOON);
    assert_true(tulle_world_get_state_hash(after) != hash);
    set_wind(after, &storm);
    for (int i = 0; i < 20; i++) {
        step(other, 1);
        step(before, 1);
        step(after, 1);
        step(unchanged, 1);
        assert_true(tulle_world_get_state_hash(before) == tulle_world_get_state_hash(other));
        assert_same_cloth(after, other);
    }
    size_t count;
    const double *const x = get_positions(after, &count);
    assert_true(memcmp(x, get_positions(unchanged, &count), count * sizeof *x) != 0);
    tulle_world_destroy(other);
    tulle_world_destroy(before);
    tulle_world_destroy(after);
    tulle_world_destroy(unchanged);
}

/* A state brings its gravity and wind along: into the world that has changed them since, and into
 * one that never has. */
static void a_state_has_its_settings(void **state) {
    (void)state;
    tulle_wind const calm = make_wind(0.0, 0.7), storm = make_wind(8.0, 1.2);
    tulle_world *const world = make_world(EARTH, &calm, true);
    tulle_world *const fresh = make_world(EARTH, &calm, true);
    void *plain, *changed;
    size_t plain_count, changed_count;
    tulle_error error = {0};
    step(world, 3);
    expect(TULLE_OK, tulle_world_save_state(world, &plain, &plain_count, &error), &error);
    uint64_t const plain_hash = tulle_world_get_state_hash(world);
    step(world, 4);
    uint64_t const plain_end = tulle_world_get_state_hash(world);
    expect(TULLE_OK, tulle_world_load_state(world, plain, plain_count, &error), &error);
    set_gravity(world, MOON);
    set_wind(world, &storm);
    set_law(world, &ICE);
    expect(TULLE_OK, tulle_world_save_state(world, &changed, &changed_count, &error), &error);
    uint64_t const changed_hash = tulle_world_get_state_hash(world);
    assert_true(changed_hash != plain_hash && changed_count > plain_count);
    step(world, 4);
    uint64_t const changed_end = tulle_world_get_state_hash(world);
    tulle_world *const worlds[] = {world, fresh};
    for (int k = 0; k < 4; k++) {
        tulle_world *const to = worlds[k % 2];
        expect(TULLE_OK, tulle_world_load_state(to, plain, plain_count, &error), &error);
        assert_true(tulle_world_get_state_hash(to) == plain_hash);
        step(to, 4);
        assert_true(tulle_world_get_state_hash(to) == plain_end);
        expect(TULLE_OK, tulle_world_load_state(to, changed, changed_count, &error), &error);
        assert_true(tulle_world_get_state_hash(to) == changed_hash);
        step(to, 4);
        assert_true(tulle_world_get_state_hash(to) == changed_end);
    }
    tulle_world_free_state(world, plain, plain_count);
    tulle_world_free_state(world, changed, changed_count);
    tulle_world_destroy(world);
    tulle_world_destroy(fresh);
}

/* Gravity, wind and laws that no world has are refused, whatever the hash of the state says. */
static void settings_that_are_none_are_refused(void **state) {
    (void)state;
    enum { HASH_AT = 8, HASHED_FROM = 16 };
    tulle_wind const calm = make_wind(0.0, 0.7);
    tulle_world *const world = make_world(EARTH, &calm, true);
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_start(world, &error), &error);
    set_gravity(world, MOON);
    set_law(world, &ICE);
    void *saved;
    size_t count;
    expect(TULLE_OK, tulle_world_save_state(world, &saved, &count, &error), &error);
    unsigned char *const bytes = saved;
    uint64_t const state_hash = tulle_world_get_state_hash(world);
    /* the laws of three surfaces stand before gravity and wind */
    size_t const law_numbers = 9 * sizeof(contact_law) / sizeof(double);
    size_t const numbers = law_numbers + sizeof(world_settings) / sizeof(double);
    for (size_t k = 0; k < numbers; k++) {
        double const bad = (double)NAN;
        double kept;
        unsigned char *const place = bytes + count - (numbers - k) * sizeof kept;
        memcpy(&kept, place, sizeof kept);
        memcpy(place, &bad, sizeof bad);
        uint64_t const hash = hash_block(bytes + HASHED_FROM, count - HASHED_FROM);
        memcpy(bytes + HASH_AT, &hash, sizeof hash);
        bool const is_seed = law_numbers + 3 + offsetof(tulle_wind, seed) / sizeof kept == k;
        expect(is_seed ? TULLE_OK : TULLE_ERROR_PARSE,
               tulle_world_load_state(world, bytes, count, &error), &error);
        memcpy(place, &kept, sizeof kept);
        if (!is_seed) assert_true(tulle_world_get_state_hash(world) == state_hash);
        uint64_t const good = hash_block(bytes + HASHED_FROM, count - HASHED_FROM);
        memcpy(bytes + HASH_AT, &good, sizeof good);
        expect(TULLE_OK, tulle_world_load_state(world, bytes, count, &error), &error);
    }
    tulle_world_free_state(world, saved, count);
    tulle_world_destroy(world);
}

/* A sheet on the ground, drawn aside. */
static tulle_world *make_slide(const tulle_contact_law *law) {
    tulle_world_def def = tulle_world_def_default();
    def.gravity[0] = 3.0;
    def.wind.drag_coefficient = 0.0;
    def.threads = 1;
    tulle_world *world = NULL;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    tulle_mesh sheet = small_sheet(0.25, 7, 0.004);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = 2.0, shape.size[1] = 1.0, shape.size[2] = 0.1;
    shape.resolution[0] = 40; /* so that its vertices meet faces of the sheet, too */
    tulle_mesh ground = small_shape(shape, 0.0, 0.0, -0.05);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.air_damping = 0.0;
    expect(TULLE_OK, tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    small_add_obstacle(world, &ground);
    if (law) set_law(world, law);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ground);
    return world;
}

static double find_speed(const tulle_world *world) {
    size_t count;
    const double *const v = tulle_cloth_get_velocities(world, (tulle_cloth_id){0, 1}, &count);
    double mean = 0.0;
    for (size_t i = 0; i < count; i++) mean += v[3 * i] / (double)count;
    return mean;
}

/* A sheet that friction held slides freely on ice, and stops again on rubber. Set before the first
 * step, a law is as one set before the start. */
static void laws_change_while_the_world_runs(void **state) {
    (void)state;
    tulle_world *const world = make_slide(&RUBBER);
    step(world, 32);
    assert_true(fabs(find_speed(world)) < 1e-3);
    uint64_t const hash = tulle_world_get_state_hash(world);
    set_law(world, &RUBBER); /* as it is */
    assert_true(tulle_world_get_state_hash(world) == hash);
    set_law(world, &ICE);
    assert_true(tulle_world_get_state_hash(world) != hash);
    /* whichever of the two comes first in a pair of features */
    assert_memory_equal(&world->model.laws[1], &world->model.laws[2], sizeof *world->model.laws);
    step(world, 16);
    double const free = 3.0 * 16.0 * STEP; /* nothing but gravity acts along the ground */
    if (!(fabs(find_speed(world) - free) < 0.02 * free))
        fail_msg("%g m/s, not %g", find_speed(world), free);
    set_law(world, &RUBBER);
    step(world, 24);
    assert_true(fabs(find_speed(world)) < 0.01 * free);
    tulle_world_destroy(world);

    tulle_world *const before = make_slide(&ICE), *const after = make_slide(NULL);
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_start(after, &error), &error);
    set_law(after, &ICE);
    for (int i = 0; i < 20; i++) {
        step(before, 1);
        step(after, 1);
        assert_same_cloth(before, after);
    }
    tulle_world_destroy(before);
    tulle_world_destroy(after);
}

/* A body that sleeps wakes when gravity or a law changes, not when they are set to what they are.
 */
static void changes_wake_bodies(void **state) {
    (void)state;
    tulle_wind const calm = make_wind(0.0, 0.7);
    tulle_world *const world = make_world(EARTH, &calm, true);
    tulle_obstacle_id const box = {1, 1};
    step(world, 40);
    assert_int_equal(tulle_obstacle_is_asleep(world, box), 1);
    set_gravity(world, EARTH);
    set_wind(world, &calm);
    assert_int_equal(tulle_obstacle_is_asleep(world, box), 1);
    tulle_error error = {0};
    for (int k = 0; k < 2; k++) { /* a law changes once */
        expect(TULLE_OK,
               tulle_world_set_obstacle_obstacle_law(world, (tulle_obstacle_id){0, 1}, box, &RUBBER,
                                                     &error),
               &error);
        assert_int_equal(tulle_obstacle_is_asleep(world, box), k);
        step(world, 40);
        assert_int_equal(tulle_obstacle_is_asleep(world, box), 1);
    }
    static const double up[3] = {0.0, 0.0, 1.0};
    set_gravity(world, up);
    assert_int_equal(tulle_obstacle_is_asleep(world, box), 0);
    double const z = tulle_obstacle_get_positions(world, box, NULL)[2];
    step(world, 16);
    /* 1 m/s^2 for a quarter of a second, by implicit Euler */
    double const way = tulle_obstacle_get_positions(world, box, NULL)[2] - z;
    double const expected = 0.5 * 0.25 * (0.25 + STEP);
    if (!(fabs(way - expected) < 1e-9)) fail_msg("%g m, not %g", way, expected);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_falls_as_gravity_says),
        cmocka_unit_test(a_change_is_as_if_the_def_had_it),
        cmocka_unit_test(a_state_has_its_settings),
        cmocka_unit_test(settings_that_are_none_are_refused),
        cmocka_unit_test(laws_change_while_the_world_runs),
        cmocka_unit_test(changes_wake_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
