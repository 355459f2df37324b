/* Cones of moving normals hold normals sampled in long double, and are no wider than they need be.
 */
#include "detect/patches/normal_cone.h"

#include "support/cone_tightness.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
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

static const cone_rule both_rules[] = {CONE_BERNSTEIN, CONE_PAPER};

/* A triangle of some thinness and size on its way; returns how to say which. */
static const char *make_moving_triangle(uint64_t *seed, int round, vec3 start[3], vec3 end[3]) {
    static const double thinnesses[] = {1.0, 0.3, 1e-3, 1e-9, 1e-12};
    static const double motions[] = {0.0, 1e-9, 1e-3, 0.1, 1.0, 100.0};
    static const double sizes[] = {1.0, 1e-6, 1e9, 1e-69, 1e69};
    static char what[120];
    double const thinness = thinnesses[round % 5], motion = motions[round / 5 % 6];
    double const size = sizes[round / 30 % 5];
    (void)snprintf(what, sizeof what, "round %d: thinness %g, motion %g, size %g", round, thinness,
                   motion, size);
    make_triangle(seed, thinness, start);
    move_triangle(seed, motion < 1.0 ? motion * thinness : motion, start, end);
    if (round % 7 == 0) /* the far end of a stretch, a shrinking or a shear */
        for (int k = 0; k < 3; k++)
            end[k] = vec3_scale(start[k], pow(10.0, random_between(seed, -3.0, 3.0)));
    for (int k = 0; k < 3; k++) {
        start[k] = vec3_scale(start[k], size);
        end[k] = vec3_scale(end[k], size);
    }
    return what;
}

static void cones_hold_all_normals(void **state) {
    (void)state;
    uint64_t seed = 5;
    size_t valid[2] = {0}, all = 0;
    for (int round = 0; round < 150 * 100; round++) {
        vec3 start[3], end[3];
        const char *const what = make_moving_triangle(&seed, round, start, end);
        all++;
        for (int r = 0; r < 2; r++) {
            normal_cone const cone = normal_cone_of_triangle(both_rules[r], start, end);
            if (!normal_cone_is_valid(cone)) continue;
            valid[r]++;
            assert_true(cone.half_angle < 90.0 * DEGREE);
            assert_true(fabs(vec3_norm(cone.axis) - 1.0) < 1e-15);
            double const angle = sample_angle(cone.axis, start, end, 1000);
            if (angle > cone.half_angle)
                fail_msg("%s, rule %d: a normal leaves its cone of %.17g by %g rad", what, r,
                         cone.half_angle, angle - cone.half_angle);
        }
    }
    print_message("%zu Bernstein and %zu paper cones of %zu are valid\n", valid[0], valid[1], all);
    assert_true(valid[0] > all / 2 && valid[1] > all / 3);
}

/* What the paper prints, sampled in long double; the axis need not agree. */
static double sample_paper_angle(const vec3 start[3], const vec3 end[3]) {
    int const count = 4000;
    wide3 const first = find_normal(start, end, 0.0L), last = find_normal(start, end, 1.0L);
    long double const a = 1.0L / wide_norm(first), b = 1.0L / wide_norm(last);
    wide3 const zeta = {a * first.x + b * last.x, a * first.y + b * last.y,
                        a * first.z + b * last.z};
    long double least = 1e300L, longest = 0.0L;
    for (int i = 0; i <= count; i++) {
        wide3 const n = find_normal(start, end, (long double)i / (long double)count);
        least = fminl(least, zeta.x * n.x + zeta.y * n.y + zeta.z * n.z);
        longest = fmaxl(longest, wide_norm(n));
    }
    return (double)acosl(least / (wide_norm(zeta) * longest));
}

static void paper_cones_are_those_of_the_paper(void **state) {
    (void)state;
    uint64_t seed = 12;
    size_t valid = 0;
    for (int round = 0; round < 1500; round++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.8, start);
        move_triangle(&seed, 0.4 * random_uniform(&seed), start, end);
        normal_cone const cone = normal_cone_of_triangle(CONE_PAPER, start, end);
        double const printed = sample_paper_angle(start, end);
        if (!normal_cone_is_valid(cone)) {
            assert_true(!(printed < 90.0 * DEGREE - 1e-4));
            continue;
        }
        valid++;
        /* samples 1/4000 apart miss extremes by some 1e-7 of them; 1e-9 of |n_max|^2 is allowed for
         */
        assert_true(fabs(cone.half_angle - printed) < 1e-5 + 1e-6 / fmax(printed, 1e-3));
    }
    assert_true(valid > 1000);
}

/* Half-angle of the best of many axes around a cone's: none is better by more than rounding. */
static void cones_are_the_smallest_of_their_coefficients(void **state) {
    (void)state;
    uint64_t seed = 6;
    for (int round = 0; round < 2000; round++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.8, start);
        move_triangle(&seed, 0.3, start, end);
        normal_cone const cone = normal_cone_of_triangle(CONE_BERNSTEIN, start, end);
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

/* ---- how tight the two rules are ---- */

typedef enum motion_kind { MOTION_STRETCH, MOTION_SHIFT, MOTION_NOISE, MOTION_TURN } motion_kind;

/* Normal distribution, from 12 uniform ones. */
static double random_normal(uint64_t *seed, double deviation) {
    double sum = -6.0;
    for (int i = 0; i < 12; i++) sum += random_uniform(seed);
    return deviation * sum;
}

static vec3 random_noise(uint64_t *seed, double deviation) {
    double const x = random_normal(seed, deviation), y = random_normal(seed, deviation);
    return vec3_make(x, y, random_normal(seed, deviation));
}

/* Half a square of edge 1; noise of deviation 1% on each coordinate at both ends. */
static tightness measure_tightness(const char *name, motion_kind kind) {
    tightness row = {0};
    uint64_t seed = 7;
    for (int i = 0; i < 1000; i++) {
        vec3 start[3], end[3];
        make_triangle(&seed, 0.866, start);
        start[2] = vec3_add_scaled(
            start[2], vec3_sub(start[1], start[0]),
            0.5 - vec3_dot(vec3_sub(start[2], start[0]), vec3_sub(start[1], start[0])));
        vec3 const hinge = vec3_sub(start[1], start[0]);
        vec3 const up = vec3_normalize(vec3_cross(hinge, vec3_sub(start[2], start[0])));
        for (int k = 0; k < 3; k++) {
            end[k] = start[k];
            if (kind == MOTION_STRETCH) end[k] = vec3_scale(start[k], 1.01);
            if (kind == MOTION_SHIFT) end[k] = vec3_add(start[k], vec3_make(3.0, -2.0, 1.0));
            if (kind == MOTION_NOISE)
                end[k] = vec3_add(start[k],
                                  vec3_sub(random_noise(&seed, 0.01), random_noise(&seed, 0.01)));
        }
        if (kind == MOTION_TURN) end[2] = vec3_add_scaled(start[2], up, 0.866 * tan(20.0 * DEGREE));
        add_triangle(&row, start, end);
    }
    finish_row(&row, name);
    return row;
}

static void stretch_and_noise_hardly_widen_a_cone(void **state) {
    (void)state;
    print_tightness_header();
    tightness const stretch = measure_tightness("stretch in its plane by 1%", MOTION_STRETCH);
    tightness const shift = measure_tightness("shift", MOTION_SHIFT);
    tightness const noise = measure_tightness("noise of 1% of the edge", MOTION_NOISE);
    tightness const turn = measure_tightness("turn about an edge by 20 degrees", MOTION_TURN);
    assert_true(fabs(stretch.paper - 11.39) < 0.02); /* acos(1.01^-2) */
    assert_true(stretch.bernstein < 1e-6);
    assert_true(shift.paper < 1e-3 && shift.bernstein < 1e-6);
    assert_true(fabs(noise.paper - 11.6) < 0.5); /* the figures that decided for Bernstein */
    assert_true(fabs(noise.best - 0.75) < 0.05);
    assert_true(noise.bernstein < 1.02 * noise.best);
    assert_true(fabs(turn.bernstein - 10.0) < 1e-6 && fabs(turn.best - 10.0) < 1e-3);
    assert_true(turn.paper > 1.5 * turn.bernstein);
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
    /* Its plane stays; the middle coefficient points up, the last one straight down. */
    vec3 const mirrored[3] = {{0, 0, 0}, {3, 0, 0}, {0, -1, 0}};
    const vec3 *const others[] = {flipped, mirrored, line, broken, endless, huge, tiny};
    for (int r = 0; r < 2; r++) {
        cone_rule const rule = both_rules[r];
        assert_true(normal_cone_is_valid(normal_cone_of_triangle(rule, start, start)));
        assert_true(normal_cone_is_valid(normal_cone_of_triangle(rule, start, upright)));
        for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
            assert_false(normal_cone_is_valid(normal_cone_of_triangle(rule, start, others[i])));
            assert_false(normal_cone_is_valid(normal_cone_of_triangle(rule, others[i], start)));
        }
        assert_false(normal_cone_is_valid(normal_cone_of_triangle(rule, line, line)));
    }
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
        /* it holds both, to the rim that is farthest from its axis, with some room for rounding */
        assert_true(angle_between(wide(merged.axis), wide(a.axis)) + a.half_angle <
                    merged.half_angle + 1e-14);
        assert_true(angle_between(wide(merged.axis), wide(b.axis)) + b.half_angle <
                    merged.half_angle + 1e-14);
        for (int k = 0; k < 8; k++) {
            wide3 const rim = make_rim(&seed, k % 2 ? &a : &b);
            /* 1e-14: a rim is made of a rounded axis and side */
            assert_true(angle_between(wide(merged.axis), rim) <= merged.half_angle + 1e-14);
        }
    }
    assert_true(merged_count > 10000);
}

/* A cone that just holds another, with the slack for rounding, stays as it is. */
static void a_cone_that_holds_another_is_kept(void **state) {
    (void)state;
    double const slack = 1e-9; /* [rad] of every angle that was computed */
    normal_cone const narrow = {{0.0, 0.0, 1.0}, 0.5}, wide = {{0.0, 0.0, 1.0}, slack + 0.5};
    for (int i = 0; i < 2; i++) {
        normal_cone merged = {{0.0, 0.0, 0.0}, 0.0};
        assert_true(normal_cone_merge(i ? &wide : &narrow, i ? &narrow : &wide, 0.6, &merged));
        assert_memory_equal(&merged, &wide, sizeof wide);
    }
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
        cmocka_unit_test(paper_cones_are_those_of_the_paper),
        cmocka_unit_test(cones_are_the_smallest_of_their_coefficients),
        cmocka_unit_test(stretch_and_noise_hardly_widen_a_cone),
        cmocka_unit_test(turning_over_has_no_cone),
        cmocka_unit_test(merged_cones_hold_both),
        cmocka_unit_test(a_cone_that_holds_another_is_kept),
        cmocka_unit_test(cones_near_a_right_angle_hold_both),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
