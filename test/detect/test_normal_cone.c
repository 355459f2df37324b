/* Cones of moving normals hold normals sampled in long double, and are no wider than they need be.
 */
#include "detect/normal_cone.h"

#include "support/wide_normals.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A triangle of height `thinness` over an edge of length 1, anywhere. */
static void make_triangle(uint64_t *seed, double thinness, vec3 points[3]) {
    vec3 const u = vec3_normalize(random_vector(seed, 1.0));
    vec3 const across = vec3_normalize(vec3_cross(u, random_vector(seed, 1.0)));
    points[0] = random_vector(seed, 1.0);
    points[1] = vec3_add(points[0], u);
    points[2] =
        vec3_add_scaled(vec3_add_scaled(points[0], u, random_uniform(seed)), across, thinness);
}

static void move_triangle(uint64_t *seed, double motion, const vec3 start[3], vec3 end[3]) {
    vec3 const shift = random_vector(seed, random_uniform(seed) < 0.5 ? 0.0 : 10.0);
    for (int k = 0; k < 3; k++)
        end[k] = vec3_add(vec3_add(start[k], shift), random_vector(seed, motion));
}

/* ---- cones ---- */

static void cones_hold_all_normals(void **state) {
    (void)state;
    static const double thinnesses[] = {1.0, 0.3, 1e-3, 1e-9, 1e-12};
    static const double motions[] = {0.0, 1e-9, 1e-3, 0.1, 1.0, 100.0};
    static const double sizes[] = {1.0, 1e-6, 1e9};
    uint64_t seed = 5;
    size_t valid = 0, all = 0;
    for (int round = 0; round < 90 * 150; round++) {
        double const thinness = thinnesses[round % 5], motion = motions[round / 5 % 6];
        double const size = sizes[round / 30 % 3];
        vec3 start[3], end[3];
        make_triangle(&seed, thinness, start);
        move_triangle(&seed, motion < 1.0 ? motion * thinness : motion, start, end);
        for (int k = 0; k < 3; k++) {
            start[k] = vec3_scale(start[k], size);
            end[k] = vec3_scale(end[k], size);
        }
        normal_cone const cone = normal_cone_of_triangle(start, end);
        all++;
        if (!normal_cone_is_valid(cone)) continue;
        valid++;
        double const angle = sample_angle(cone.axis, start, end, round % 50 ? 40 : 1000);
        if (angle > cone.half_angle)
            fail_msg("a normal leaves its cone of %.17g by %g rad (thinness %g, motion %g)",
                     cone.half_angle, angle - cone.half_angle, thinness, motion);
    }
    print_message("%zu of %zu cones are valid\n", valid, all);
    assert_true(valid > all / 2);
}

/* Half-angle of the best of many axes around a cone's: none is better by more than rounding. */
static void cones_are_the_smallest_of_their_coefficients(void **state) {
    (void)state;
    uint64_t seed = 6;
    for (int round = 0; round < 2000; round++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.8, start);
        move_triangle(&seed, 0.3, start, end);
        normal_cone const cone = normal_cone_of_triangle(start, end);
        if (!normal_cone_is_valid(cone)) continue;
        vec3 const u0 = vec3_sub(start[1], start[0]), v0 = vec3_sub(start[2], start[0]);
        vec3 const u1 = vec3_sub(end[1], end[0]), v1 = vec3_sub(end[2], end[0]);
        wide3 const hull[3] = {wide(vec3_cross(u0, v0)), wide(vec3_cross(u1, v1)),
                               wide(vec3_add(vec3_cross(u0, v1), vec3_cross(u1, v0)))};
        for (int i = 0; i < 60; i++) {
            double const size = i % 2 ? 1e-3 : 0.1;
            wide3 const axis = wide(vec3_add(cone.axis, random_vector(&seed, size)));
            double widest = 0.0;
            for (int k = 0; k < 3; k++) widest = fmax(widest, angle_between(axis, hull[k]));
            assert_true(widest >= cone.half_angle - 3e-9);
        }
    }
}

static void stretch_and_noise_hardly_widen_a_cone(void **state) {
    (void)state;
    uint64_t seed = 7;
    double sum = 0.0;
    int const count = 2000;
    for (int i = 0; i < count; i++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.866, start);
        for (int k = 0; k < 3; k++) end[k] = vec3_scale(start[k], 1.01);
        assert_true(normal_cone_of_triangle(start, end).half_angle < 1e-8);
        for (int k = 0; k < 3; k++) end[k] = vec3_add(start[k], vec3_make(3.0, -2.0, 1.0));
        assert_true(normal_cone_of_triangle(start, end).half_angle < 1e-8);
        for (int k = 0; k < 3; k++) end[k] = vec3_add(start[k], random_vector(&seed, 0.01));
        sum += normal_cone_of_triangle(start, end).half_angle;
    }
    print_message("noise of 1%% of the edge: %.3g degrees\n", sum / count / DEGREE);
    assert_true(sum / count < 1.0 * DEGREE);
}

static void turning_over_has_no_cone(void **state) {
    (void)state;
    vec3 const start[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    vec3 const flipped[3] = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}};
    vec3 const upright[3] = {{0, 0, 0}, {1, 0, 0}, {0, 0.01, 1}};
    vec3 const line[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    vec3 const broken[3] = {{0, 0, 0}, {1, 0, 0}, {0, (double)NAN, 0}};
    vec3 const endless[3] = {{0, 0, 0}, {1, 0, 0}, {0, (double)INFINITY, 0}};
    vec3 const huge[3] = {{0, 0, 0}, {1e200, 0, 0}, {0, 1e200, 0}};
    vec3 const tiny[3] = {{0, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}};
    assert_true(normal_cone_is_valid(normal_cone_of_triangle(start, start)));
    assert_true(normal_cone_is_valid(normal_cone_of_triangle(start, upright)));
    /* Its plane stays; the middle coefficient points up, the last one straight down. */
    vec3 const mirrored[3] = {{0, 0, 0}, {3, 0, 0}, {0, -1, 0}};
    const vec3 *const others[] = {flipped, mirrored, line, broken, endless, huge, tiny};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        assert_false(normal_cone_is_valid(normal_cone_of_triangle(start, others[i])));
        assert_false(normal_cone_is_valid(normal_cone_of_triangle(others[i], start)));
    }
    assert_false(normal_cone_is_valid(normal_cone_of_triangle(line, line)));
}

/* A vector that leaves the axis by just the cone's half-angle. */
static wide3 make_rim(uint64_t *seed, const normal_cone *cone) {
    vec3 const side = vec3_normalize(vec3_cross(cone->axis, random_vector(seed, 1.0)));
    long double const c = cosl(cone->half_angle), s = sinl(cone->half_angle);
    return (wide3){c * cone->axis.x + s * side.x, c * cone->axis.y + s * side.y,
                   c * cone->axis.z + s * side.z};
}

static void merged_cones_hold_both(void **state) {
    (void)state;
    static const double spreads[] = {0.0, 1e-16, 1e-10, 1e-9, 1e-8, 1e-3, 0.5, 3.0};
    static const double limits[] = {0.5, 1.0, 89.9 * DEGREE};
    uint64_t seed = 8;
    size_t merged_count = 0;
    for (int round = 0; round < 60000; round++) {
        double const limit = limits[round / 8 % 3];
        normal_cone a = {vec3_normalize(random_vector(&seed, 1.0)), 0.0}, b = a, merged = a;
        b.axis = vec3_normalize(vec3_add(b.axis, random_vector(&seed, spreads[round % 8])));
        a.half_angle = limit * random_uniform(&seed) * (round % 5 ? 1.0 : 1e-9);
        b.half_angle = round % 7 ? limit * random_uniform(&seed) * 0.5 : a.half_angle;
        double const ideal =
            fmax(0.5 * (angle_between(wide(a.axis), wide(b.axis)) + a.half_angle + b.half_angle),
                 fmax(a.half_angle, b.half_angle));
        bool const is_merged = normal_cone_merge(&a, &b, limit, &merged);
        if (!is_merged) assert_true(ideal > limit - 3e-9);
        if (!is_merged) continue;
        merged_count++;
        assert_true(merged.half_angle <= limit);
        assert_true(merged.half_angle <= ideal + 4e-9);
        assert_true(fabs(vec3_norm(merged.axis) - 1.0) < 1e-15);
        for (int k = 0; k < 8; k++) {
            wide3 const rim = make_rim(&seed, k % 2 ? &a : &b);
            /* 1e-14: a rim is made of a rounded axis and side */
            assert_true(angle_between(wide(merged.axis), rim) <= merged.half_angle + 1e-14);
        }
    }
    assert_true(merged_count > 10000);
}

/* Near a half turn between the axes the axis of the merged cone is a difference of near opposites.
 */
static void cones_near_a_right_angle_hold_both(void **state) {
    (void)state;
    uint64_t seed = 9;
    size_t merged_count = 0;
    for (int round = 0; round < 20000; round++) {
        double const spread = pow(10.0, -8.0 + 7.0 * random_uniform(&seed));
        normal_cone a = {vec3_normalize(random_vector(&seed, 1.0)), 0.0}, b = a, merged = a;
        b.axis = vec3_normalize(vec3_add(vec3_neg(a.axis), random_vector(&seed, spread)));
        if (!normal_cone_merge(&a, &b, 90.0 * DEGREE - 1e-12, &merged)) continue;
        merged_count++;
        assert_true(angle_between(wide(merged.axis), wide(a.axis)) <= merged.half_angle);
        assert_true(angle_between(wide(merged.axis), wide(b.axis)) <= merged.half_angle);
    }
    assert_true(merged_count > 10000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cones_hold_all_normals),
        cmocka_unit_test(cones_are_the_smallest_of_their_coefficients),
        cmocka_unit_test(stretch_and_noise_hardly_widen_a_cone),
        cmocka_unit_test(turning_over_has_no_cone),
        cmocka_unit_test(merged_cones_hold_both),
        cmocka_unit_test(cones_near_a_right_angle_hold_both),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
