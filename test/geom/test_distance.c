/* Closest points against exact rational arithmetic on random and degenerate families: weights in
 * range, the difference is what the weights say, and the distance is right to rounding. */
#include "geom/distance.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <gmp.h>

/* [coordinates] rounding allowed, in units of the largest coordinate: some 50 ulp. */
static const double TOLERANCE = 1e-14;

typedef struct exact_vec3 {
    mpq_t x[3];
} exact_vec3;

enum { SCRATCH_COUNT = 14 };
static exact_vec3 scratch[SCRATCH_COUNT];
static mpq_t scalar[8];

static void initialise_exact(void) {
    for (int i = 0; i < SCRATCH_COUNT; i++)
        for (int k = 0; k < 3; k++) mpq_init(scratch[i].x[k]);
    for (int i = 0; i < 8; i++) mpq_init(scalar[i]);
}

static void clear_exact(void) {
    for (int i = 0; i < SCRATCH_COUNT; i++)
        for (int k = 0; k < 3; k++) mpq_clear(scratch[i].x[k]);
    for (int i = 0; i < 8; i++) mpq_clear(scalar[i]);
}

static void exact_set(exact_vec3 *a, vec3 b) {
    mpq_set_d(a->x[0], b.x);
    mpq_set_d(a->x[1], b.y);
    mpq_set_d(a->x[2], b.z);
}

static void exact_sub(exact_vec3 *r, const exact_vec3 *a, const exact_vec3 *b) {
    for (int k = 0; k < 3; k++) mpq_sub(r->x[k], a->x[k], b->x[k]);
}

static void exact_dot(mpq_t r, const exact_vec3 *a, const exact_vec3 *b) {
    mpq_t term, sum;
    mpq_inits(term, sum, NULL);
    for (int k = 0; k < 3; k++) {
        mpq_mul(term, a->x[k], b->x[k]);
        mpq_add(sum, sum, term);
    }
    mpq_set(r, sum);
    mpq_clears(term, sum, NULL);
}

/* r = a - s u - t v */
static void exact_sub_scaled(exact_vec3 *r, const exact_vec3 *a, const exact_vec3 *u, mpq_t s,
                             const exact_vec3 *v, mpq_t t) {
    mpq_t term;
    mpq_init(term);
    for (int k = 0; k < 3; k++) {
        mpq_mul(term, s, u->x[k]);
        mpq_sub(r->x[k], a->x[k], term);
        mpq_mul(term, t, v->x[k]);
        mpq_sub(r->x[k], r->x[k], term);
    }
    mpq_clear(term);
}

static void keep_smaller(mpq_t best, const exact_vec3 *difference) {
    mpq_t value;
    mpq_init(value);
    exact_dot(value, difference, difference);
    if (mpq_cmp(value, best) < 0) mpq_set(best, value);
    mpq_clear(value);
}

/* Squared distance of point p and segment a b into `best` where it is smaller. */
static void exact_point_segment(mpq_t best, const exact_vec3 *p, const exact_vec3 *a,
                                const exact_vec3 *b) {
    exact_vec3 *const edge = &scratch[8], *const offset = &scratch[9], *const rest = &scratch[10];
    mpq_ptr const s = scalar[0], zero = scalar[1], length2 = scalar[2];
    exact_sub(offset, p, a);
    keep_smaller(best, offset);
    exact_sub(rest, p, b);
    keep_smaller(best, rest);
    exact_sub(edge, b, a);
    exact_dot(length2, edge, edge);
    if (mpq_sgn(length2) == 0) return;
    exact_dot(s, offset, edge);
    mpq_div(s, s, length2);
    if (mpq_sgn(s) < 0 || mpq_cmp_ui(s, 1, 1) > 0) return;
    mpq_set_ui(zero, 0, 1);
    exact_sub_scaled(rest, offset, edge, s, edge, zero);
    keep_smaller(best, rest);
}

/* Minimum of |offset - s u - t v|^2 where the free minimum is unique and admissible. */
static void exact_free_minimum(mpq_t best, const exact_vec3 *offset, const exact_vec3 *u,
                               const exact_vec3 *v, bool is_triangle) {
    mpq_ptr const uu = scalar[0], uv = scalar[1], vv = scalar[2], fu = scalar[3], fv = scalar[4];
    mpq_ptr const det = scalar[5], s = scalar[6], t = scalar[7];
    mpq_t term;
    mpq_init(term);
    exact_dot(uu, u, u);
    exact_dot(uv, u, v);
    exact_dot(vv, v, v);
    exact_dot(fu, offset, u);
    exact_dot(fv, offset, v);
    mpq_mul(det, uu, vv);
    mpq_mul(term, uv, uv);
    mpq_sub(det, det, term);
    if (mpq_sgn(det) != 0) {
        mpq_mul(s, fu, vv);
        mpq_mul(term, fv, uv);
        mpq_sub(s, s, term);
        mpq_div(s, s, det);
        mpq_mul(t, fv, uu);
        mpq_mul(term, fu, uv);
        mpq_sub(t, t, term);
        mpq_div(t, t, det);
        mpq_add(term, s, t);
        bool const is_inside = mpq_sgn(s) >= 0 && mpq_sgn(t) >= 0 &&
                               (is_triangle ? mpq_cmp_ui(term, 1, 1) <= 0
                                            : mpq_cmp_ui(s, 1, 1) <= 0 && mpq_cmp_ui(t, 1, 1) <= 0);
        if (is_inside) {
            exact_sub_scaled(&scratch[11], offset, u, s, v, t);
            keep_smaller(best, &scratch[11]);
        }
    }
    mpq_clear(term);
}

/* The exact distance, rounded; long double keeps what the square root needs. */
static double exact_distance(feature_kind kind, const vec3 points[4]) {
    mpq_t best;
    mpq_init(best);
    mpq_set_d(best, 1e300);
    exact_vec3 *const p = scratch, *const u = &scratch[4], *const v = &scratch[5];
    exact_vec3 *const offset = &scratch[6];
    for (int i = 0; i < 4; i++) exact_set(&p[i], points[i]);
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        for (int k = 0; k < 3; k++)
            exact_point_segment(best, &p[0], &p[1 + k], &p[1 + (k + 1) % 3]);
        exact_sub(u, &p[2], &p[1]);
        exact_sub(v, &p[3], &p[1]);
        exact_sub(offset, &p[0], &p[1]);
        exact_free_minimum(best, offset, u, v, true);
    } else {
        for (int k = 0; k < 2; k++) {
            exact_point_segment(best, &p[k], &p[2], &p[3]);
            exact_point_segment(best, &p[2 + k], &p[0], &p[1]);
        }
        exact_sub(u, &p[1], &p[0]);
        exact_sub(v, &p[2], &p[3]); /* minus the second direction */
        exact_sub(offset, &p[2], &p[0]);
        exact_free_minimum(best, offset, u, v, false);
    }
    /* Scaled by a power of four so that tiny squares do not underflow. */
    mpq_mul_2exp(best, best, 400);
    double const root = sqrt(mpq_get_d(best)) * 0x1p-200;
    mpq_clear(best);
    return root;
}

static double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

static vec3 random_vec3(uint64_t *random) {
    double const x = random_signed(random), y = random_signed(random);
    return vec3_make(x, y, random_signed(random));
}

/* A power of ten between 1e-17 and 1. */
static double random_tiny(uint64_t *random) {
    return pow(10.0, -floor(18.0 * random_uniform(random)));
}

enum { FAMILY_COUNT = 13 };
static void make_family(int family, uint64_t *random, vec3 p[4]) {
    for (int i = 0; i < 4; i++) p[i] = random_vec3(random);
    double const tiny = random_tiny(random);
    double const s = random_signed(random) * 2.0, t = random_signed(random) * 2.0;
    int const i = (int)(4.0 * random_uniform(random)), j = (int)(4.0 * random_uniform(random));
    switch (family) {
    case 0: break;
    case 1: /* parallel edges up to a tiny angle; a thin triangle's two long sides */
        p[3] = vec3_add_scaled(vec3_add(p[2], vec3_scale(vec3_sub(p[1], p[0]), s)),
                               random_vec3(random), tiny);
        break;
    case 2: /* flat triangle p1 p2 p3, corner anywhere on the line */
        p[3] = vec3_add_scaled(vec3_lerp(p[1], p[2], s), random_vec3(random), tiny);
        break;
    case 3: /* flat, and the point above it at a like distance */
        p[3] = vec3_add_scaled(vec3_lerp(p[1], p[2], s), random_vec3(random), tiny);
        p[0] = vec3_add_scaled(vec3_lerp(p[1], p[2], t), random_vec3(random), random_tiny(random));
        break;
    case 4: p[i] = p[j]; break; /* repeated points */
    case 5: p[i] = p[(i + 1) % 4] = p[(i + 2) % 4]; break;
    case 6: p[1] = p[2] = p[3] = p[0]; break;
    case 7: /* touching: the point in the face's plane */
        p[0] = vec3_lerp(p[1], vec3_lerp(p[2], p[3], fabs(s)), fabs(t));
        p[0] = vec3_add_scaled(p[0], random_vec3(random), tiny);
        break;
    case 8: /* edges on one line */
        p[2] = vec3_add_scaled(vec3_lerp(p[0], p[1], s), random_vec3(random), tiny);
        p[3] = vec3_add_scaled(vec3_lerp(p[0], p[1], t), random_vec3(random), tiny);
        break;
    case 9: /* small integers: every coincidence there is */
        for (int k = 0; k < 4; k++)
            p[k] =
                vec3_make(floor(3.0 * random_uniform(random)), floor(3.0 * random_uniform(random)),
                          floor(2.0 * random_uniform(random)));
        break;
    case 10: /* lengths that differ by many orders */
        p[i] = vec3_add_scaled(p[j], random_vec3(random), tiny);
        for (int k = 0; k < 4; k++) p[k] = vec3_scale(p[k], 1e6);
        break;
    case 11: /* other units */
        for (int k = 0; k < 4; k++) p[k] = vec3_scale(p[k], s > 0.0 ? 1e80 : 1e-80);
        break;
    default: /* far from the origin */
        for (int k = 0; k < 4; k++)
            p[k] = vec3_add(vec3_scale(p[k], tiny), vec3_make(3.0, -5.0, 7.0));
        break;
    }
}

static double get_largest_coordinate(const vec3 p[4]) {
    double largest = 0.0;
    for (int i = 0; i < 4; i++)
        largest = fmax(largest, fmax(fabs(p[i].x), fmax(fabs(p[i].y), fabs(p[i].z))));
    return largest;
}

static void check_weights(feature_kind kind, const double w[4]) {
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        assert_true(w[0] == 1.0);
        for (int k = 1; k < 4; k++) assert_true(w[k] <= 0.0 && w[k] >= -1.0);
        assert_true(fabs(w[1] + w[2] + w[3] + 1.0) <= 4e-16);
    } else {
        assert_true(w[0] >= 0.0 && w[1] >= 0.0 && w[2] <= 0.0 && w[3] <= 0.0);
        assert_true(fabs(w[0] + w[1] - 1.0) <= 2.3e-16 && fabs(w[2] + w[3] + 1.0) <= 2.3e-16);
    }
}

static void check_pair(feature_kind kind, const vec3 p[4]) {
    double const scale = get_largest_coordinate(p);
    closest_points const found = closest_of_pair(kind, p);
    check_weights(kind, found.weights);
    assert_true(isfinite(found.distance2));
    assert_true(found.distance2 == vec3_norm2(found.difference));
    vec3 sum = {0.0, 0.0, 0.0};
    for (int i = 0; i < 4; i++) sum = vec3_add_scaled(sum, p[i], found.weights[i]);
    assert_true(vec3_norm(vec3_sub(sum, found.difference)) <= TOLERANCE * scale);
    double const exact = exact_distance(kind, p), distance = sqrt(found.distance2);
    if (fabs(distance - exact) > TOLERANCE * scale) {
        for (int i = 0; i < 4; i++) print_message("%a %a %a\n", p[i].x, p[i].y, p[i].z);
        fail_msg("kind %d: distance %.17g, exact %.17g, scale %g", (int)kind, distance, exact,
                 scale);
    }
}

static void distances_match_rationals(void **state) {
    (void)state;
    initialise_exact();
    uint64_t random = 7;
    int const rounds = getenv("TULLE_TEST_LONG") ? 40000 : 1500;
    for (int round = 0; round < rounds; round++) {
        for (int family = 0; family < FAMILY_COUNT; family++) {
            vec3 p[4];
            make_family(family, &random, p);
            check_pair(FEATURE_VERTEX_TRIANGLE, p);
            check_pair(FEATURE_EDGE_EDGE, p);
        }
    }
    clear_exact();
}

/* No sampled pair of points is closer: an oracle that shares no formula. */
static void no_sample_is_closer(void **state) {
    (void)state;
    uint64_t random = 11;
    for (int round = 0; round < 300; round++) {
        vec3 p[4];
        make_family(round % FAMILY_COUNT, &random, p);
        double const scale = get_largest_coordinate(p);
        double const triangle = sqrt(closest_vertex_triangle(p).distance2);
        double const edges = sqrt(closest_edge_edge(p).distance2);
        for (int i = 0; i <= 20; i++) {
            for (int j = 0; j <= 20; j++) {
                double const s = i / 20.0, t = j / 20.0;
                vec3 const on_triangle = vec3_lerp(p[1], vec3_lerp(p[2], p[3], t), s);
                assert_true(triangle <= vec3_norm(vec3_sub(p[0], on_triangle)) + TOLERANCE * scale);
                vec3 const between = vec3_sub(vec3_lerp(p[0], p[1], s), vec3_lerp(p[2], p[3], t));
                assert_true(edges <= vec3_norm(between) + TOLERANCE * scale);
            }
        }
    }
}

/* Moving the points changes the distance by difference . sum w dp / distance. */
static void weights_are_the_gradient(void **state) {
    (void)state;
    uint64_t random = 13;
    double const step = 1e-6;
    for (int round = 0; round < 2000; round++) {
        feature_kind const kind = round % 2 ? FEATURE_EDGE_EDGE : FEATURE_VERTEX_TRIANGLE;
        vec3 p[4], forward[4], backward[4], shift = {0.0, 0.0, 0.0};
        make_family(0, &random, p);
        closest_points const here = closest_of_pair(kind, p);
        double const distance = sqrt(here.distance2);
        if (distance < 0.2) continue;
        for (int i = 0; i < 4; i++) {
            vec3 const direction = random_vec3(&random);
            forward[i] = vec3_add_scaled(p[i], direction, step);
            backward[i] = vec3_add_scaled(p[i], direction, -step);
            shift = vec3_add_scaled(shift, direction, here.weights[i]);
        }
        double const slope = (sqrt(closest_of_pair(kind, forward).distance2) -
                              sqrt(closest_of_pair(kind, backward).distance2)) /
                             (2.0 * step);
        /* The distance has curvature jumps where the region changes, hence not 1e-9. */
        assert_true(fabs(slope - vec3_dot(shift, here.difference) / distance) < 2e-4);
    }
}

/* Where squares underflow or nearly overflow, results are finite and weights in range. */
static void extremes_are_finite(void **state) {
    (void)state;
    uint64_t random = 19;
    double const scales[] = {1e149, 1e-149, 1e-160, 1e-200, 1e-307};
    for (int round = 0; round < 20000; round++) {
        vec3 p[4];
        make_family(round % 11, &random, p);
        if (round % 11 == 10) continue; /* a million times larger already */
        for (int i = 0; i < 4; i++) p[i] = vec3_scale(p[i], 0.1 * scales[round % 5]);
        for (int kind = 0; kind < 2; kind++) {
            closest_points const found = closest_of_pair((feature_kind)kind, p);
            check_weights((feature_kind)kind, found.weights);
            assert_true(isfinite(found.distance2) && isfinite(found.difference.x));
            assert_true(isfinite(found.difference.y) && isfinite(found.difference.z));
        }
    }
}

static void corners_are_exact(void **state) {
    (void)state;
    vec3 const p[4] = {{0.1, 0.7, 5.3}, {0.1, 0.7, 0.3}, {2.1, 0.9, 0.2}, {1.3, 3.7, 0.1}};
    closest_points const found = closest_vertex_triangle(p);
    assert_true(found.weights[1] == -1.0 && found.weights[2] == 0.0 && found.weights[3] == 0.0);
    assert_true(found.difference.z == 5.3 - 0.3 && found.difference.x == 0.0);
    vec3 const q[4] = {{0.1, 0.2, 0.3}, {0.7, 0.1, 0.3}, {2.3, 0.4, 0.5}, {1.9, 0.1, 0.4}};
    closest_points const edges = closest_edge_edge(q);
    assert_true(edges.weights[0] == 0.0 && edges.weights[1] == 1.0);
    assert_true(edges.weights[2] == 0.0 && edges.weights[3] == -1.0);
    assert_true(edges.difference.x == 0.7 - 1.9 && edges.difference.z == 0.3 - 0.4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_match_rationals), cmocka_unit_test(no_sample_is_closer),
        cmocka_unit_test(weights_are_the_gradient),  cmocka_unit_test(extremes_are_finite),
        cmocka_unit_test(corners_are_exact),
    };
    return cmocka_run_group_tests_name("geom.distance", tests, NULL, NULL);
}
