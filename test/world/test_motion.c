/* Keyframe motions against closed forms: places, easing, rotation about a pivot, changes. */
#include "step/motion.h"

#include "base/hash.h"
#include "support/test_support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <time.h>

#include <cmocka.h>

static const double QUARTER = 1.5707963267948966; /* [rad] of a turn */
static const double SMALL = 1e-14;

static void assert_point(const world_motion *motion, double time, vec3 start, vec3 expected) {
    double point[3], moved[3];
    vec3_store(point, 0, start);
    motion_apply(motion, time, point, 1, moved);
    double const distance = vec3_norm(vec3_sub(vec3_load(moved, 0), expected));
    if (!(distance < SMALL)) {
        fail_msg("at %g s: (%.17g, %.17g, %.17g)", time, moved[0], moved[1], moved[2]);
    }
}

/* From rest to 2 m along x and a quarter turn about z, between 1 s and 3 s, about (1, 0, 0). */
static world_motion make_motion(memory *heap, int is_eased) {
    tulle_keyframe const keys[] = {{1.0, {0, 0, 0}, {0, 0, 0}}, {3.0, {2, 0, 0}, {0, 0, QUARTER}}};
    tulle_motion const source = {keys, 2, {1, 0, 0}, is_eased};
    world_motion motion = {0};
    assert_int_equal(motion_validate(&source, "motion", NULL), TULLE_OK);
    assert_int_equal(motion_copy(heap, &source, &motion), TULLE_OK);
    return motion;
}

/* Where (2, 0, 0) is when the part s of the motion is done: on a circle of 1 m about the pivot. */
static vec3 expect_point(double s) {
    double const angle = s * acos(-1.0) / 2.0;
    return vec3_make(1.0 + cos(angle) + 2.0 * s, sin(angle), 0.0);
}

static void places_are_as_in_closed_form(void **state) {
    (void)state;
    memory heap = memory_default();
    for (int is_eased = 0; is_eased < 2; is_eased++) {
        world_motion motion = make_motion(&heap, is_eased);
        vec3 const start = vec3_make(2.0, 0.0, 0.0);
        assert_point(&motion, -5.0, start, start);
        assert_point(&motion, 1.0, start, start);
        for (int i = 1; i < 8; i++) {
            double const s = i / 8.0;
            double const done = is_eased ? s * s * (3.0 - 2.0 * s) : s;
            assert_point(&motion, 1.0 + 2.0 * s, start, expect_point(done));
        }
        assert_point(&motion, 3.0, start, expect_point(1.0));
        assert_point(&motion, 1e9, start, expect_point(1.0));
        motion_destroy(&heap, &motion);
    }
}

static void no_keys_change_no_bit(void **state) {
    (void)state;
    world_motion const motion = {0};
    double const point[3] = {0.1, -1e300, 3e-308};
    double moved[3];
    motion_apply(&motion, 7.0, point, 1, moved);
    for (int c = 0; c < 3; c++) assert_true(moved[c] == point[c]);
}

/* Angles about one axis go as they were given, by more than a turn, back, and about an axis that is
 * rounded; about two axes the turn goes the shorter way. */
static void angles_go_as_given(void **state) {
    (void)state;
    memory heap = memory_default();
    double const axes[3][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0.1 / 0.7, 0.2, -3.1}};
    double const angles[6] = {0.0, 1.5, 3.0, -3.0, 8.0, 4.0}; /* [quarters] */
    for (int a = 0; a < 3; a++) {
        tulle_keyframe keys[6];
        vec3 const axis = vec3_normalize(vec3_load(axes[a], 0));
        for (int i = 0; i < 6; i++) {
            keys[i] = (tulle_keyframe){i, {0}, {0}};
            vec3_store(keys[i].rotation_vector, 0, vec3_scale(axis, QUARTER * angles[i]));
        }
        tulle_motion const source = {keys, 6, {0, 0, 0}, 0};
        world_motion motion = {0};
        assert_int_equal(motion_copy(&heap, &source, &motion), TULLE_OK);
        double way = 0.0;
        for (int i = 0; i < 5; i++) {
            for (int k = 0; k < 8; k++) {
                double const s = k / 8.0, angle = angles[i] + s * (angles[i + 1] - angles[i]);
                double turned;
                quaternion const q = motion_compute_pose(&motion, i + s, &turned).rotation;
                quaternion const expected =
                    quaternion_from_vector(vec3_scale(axis, QUARTER * angle));
                if (!(vec3_norm(quaternion_find_turn(q, expected)) < 1e-12))
                    fail_msg("axis %d, key %d and %g", a, i, s);
                double const here = way + s * QUARTER * fabs(angles[i + 1] - angles[i]);
                assert_true(fabs(turned - here) < 1e-12);
            }
            way += QUARTER * fabs(angles[i + 1] - angles[i]);
        }
        motion_destroy(&heap, &motion);
    }
    tulle_keyframe const keys[2] = {{0.0, {0}, {0, 0, 3.5 * QUARTER}}, {1.0, {0}, {QUARTER, 0, 0}}};
    tulle_motion const source = {keys, 2, {0, 0, 0}, 0};
    world_motion motion = {0};
    double turned;
    assert_int_equal(motion_copy(&heap, &source, &motion), TULLE_OK);
    (void)motion_compute_pose(&motion, 1.0, &turned);
    /* cos of half the way: cos 45 deg cos 22.5 deg */
    assert_true(fabs(cos(0.5 * turned) - cos(0.5 * QUARTER) * cos(0.25 * QUARTER)) < 1e-12);
    motion_destroy(&heap, &motion);
}

/* What takes every point from its place at one time to that at another. */
static void changes_lead_from_place_to_place(void **state) {
    (void)state;
    memory heap = memory_default();
    world_motion motion = make_motion(&heap, 1);
    uint64_t random = 5;
    for (int i = 0; i < 200; i++) {
        double const from = 4.0 * random_uniform(&random), to = 4.0 * random_uniform(&random);
        double const point[3] = {random_uniform(&random), random_uniform(&random),
                                 random_uniform(&random)};
        double before[3], after[3];
        motion_apply(&motion, from, point, 1, before);
        motion_apply(&motion, to, point, 1, after);
        mat3 matrix;
        vec3 offset;
        motion_compute_change(&motion, from, to, &matrix, &offset);
        vec3 const moved = vec3_add(mat3_multiply_vec3(&matrix, vec3_load(before, 0)), offset);
        assert_true(vec3_norm(vec3_sub(moved, vec3_load(after, 0))) < SMALL);
    }
    motion_destroy(&heap, &motion);
}

/* The pose late in a script of days costs no more than an early one, and is found among all keys:
 * at key i and halfway to the next. */
static void a_long_script_costs_no_more(void **state) {
    (void)state;
    enum { KEY_COUNT = 200000 };
    static tulle_keyframe keys[KEY_COUNT];
    memory heap = memory_default();
    for (int i = 0; i < KEY_COUNT; i++)
        keys[i] = (tulle_keyframe){0.5 * i, {i % 7, 0.0, 0.0}, {0, 0, 0}};
    tulle_motion const source = {keys, KEY_COUNT, {0.0, 0.0, 0.0}, 0};
    world_motion motion = {0};
    assert_int_equal(motion_copy(&heap, &source, &motion), TULLE_OK);
    clock_t const begin = clock();
    for (int i = 0; i + 1 < KEY_COUNT; i++) {
        double const here = keys[i].translation[0], next = keys[i + 1].translation[0];
        assert_true(motion_compute_pose(&motion, 0.5 * i, NULL).translation.x == here);
        assert_true(motion_compute_pose(&motion, 0.5 * i + 0.25, NULL).translation.x ==
                    0.5 * (here + next));
    }
    double const seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    if (seconds > 1.0 * TULLE_TIME_FACTOR) fail_msg("%.2f s for 400000 poses", seconds);
    motion_destroy(&heap, &motion);
}

static void bad_keys_are_refused(void **state) {
    (void)state;
    tulle_keyframe keys[] = {{1.0, {0, 0, 0}, {0, 0, 0}}, {3.0, {2, 0, 0}, {0, 0, 0}}};
    tulle_motion const source = {keys, 2, {0, 0, 0}, 0};
    assert_int_equal(motion_validate(&source, "motion", NULL), TULLE_OK);
    keys[1].time = 1.0;
    assert_int_equal(motion_validate(&source, "motion", NULL), TULLE_ERROR_INVALID_ARGUMENT);
    keys[1].time = 3.0;
    keys[1].translation[1] = (double)NAN;
    assert_int_equal(motion_validate(&source, "motion", NULL), TULLE_ERROR_INVALID_ARGUMENT);
    keys[1].translation[1] = 0.0;
    keys[0].rotation_vector[0] = 1.1e6; /* an angle without a place in its turn */
    assert_int_equal(motion_validate(&source, "motion", NULL), TULLE_ERROR_INVALID_ARGUMENT);
    keys[0].rotation_vector[0] = (double)INFINITY;
    assert_int_equal(motion_validate(&source, "motion", NULL), TULLE_ERROR_INVALID_ARGUMENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_as_in_closed_form),
        cmocka_unit_test(no_keys_change_no_bit),
        cmocka_unit_test(angles_go_as_given),
        cmocka_unit_test(changes_lead_from_place_to_place),
        cmocka_unit_test(a_long_script_costs_no_more),
        cmocka_unit_test(bad_keys_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
