/* The signs of orient2d_sign and orient3d_sign against GMP rationals over the whole range of double
 * and against 128-bit integers on near-degenerate grids, where both are exact. */
#include "geom/exact_predicates.h"

#include "base/hash.h"
#include "base/timer.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <gmp.h>

__extension__ typedef __int128 wide;

static size_t scaled(size_t count) { return getenv("TULLE_TEST_LONG") ? 20 * count : count; }

/* Sign of the determinant of the rows points[1..n] - points[0], by rationals, n = 2 or 3. */
static int rational_sign(double points[4][3], int n) {
    mpq_t m[3][3], t, sum;
    mpq_inits(t, sum, NULL);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) {
            mpq_init(m[r][c]);
            mpq_set_d(m[r][c], points[r + 1][c]);
            mpq_set_d(t, points[0][c]);
            mpq_sub(m[r][c], m[r][c], t);
        }
    static const int permutations[6][4] = {{0, 1, 2, 1},  {1, 2, 0, 1},  {2, 0, 1, 1},
                                           {0, 2, 1, -1}, {2, 1, 0, -1}, {1, 0, 2, -1}};
    for (int p = 0; p < 6; p++) {
        const int *const q = permutations[p];
        if (n == 2 && q[2] != 2) continue;
        mpq_mul(t, m[0][q[0]], m[1][q[1]]);
        if (n == 3) mpq_mul(t, t, m[2][q[2]]);
        if (q[3] > 0)
            mpq_add(sum, sum, t);
        else
            mpq_sub(sum, sum, t);
    }
    int const sign = mpq_sgn(sum);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) mpq_clear(m[r][c]);
    mpq_clears(t, sum, NULL);
    return sign > 0 ? 1 : sign < 0 ? -1 : 0;
}

static void compare_with_rationals(double p[4][3]) {
    int const expected3 = rational_sign(p, 3), expected2 = rational_sign(p, 2);
    int const got3 = orient3d_sign(p[0], p[1], p[2], p[3], NULL);
    int const got2 = orient2d_sign(p[0], p[1], p[2], NULL);
    if (got3 != expected3 || got2 != expected2)
        for (int i = 0; i < 4; i++) print_error("%a %a %a\n", p[i][0], p[i][1], p[i][2]);
    assert_int_equal(got3, expected3);
    assert_int_equal(got2, expected2);
}

static double random_range(uint64_t *state, double low, double high) {
    return low + (high - low) * random_uniform(state);
}

static void random_points_agree(void **unused) {
    (void)unused;
    uint64_t state = 1;
    for (size_t k = 0; k < scaled(30000); k++) {
        double p[4][3];
        for (int i = 0; i < 12; i++) p[i / 3][i % 3] = random_range(&state, -1, 1);
        compare_with_rationals(p);
    }
}

/* The last point is a rounded combination of the others: the sign hangs on the last bits. */
static void nearly_coplanar_points_agree(void **unused) {
    (void)unused;
    uint64_t state = 2;
    size_t zeros = 0, exact = 0;
    for (size_t k = 0; k < scaled(100000); k++) {
        double p[4][3];
        double const s = random_range(&state, -1, 2), t = random_range(&state, -1, 2);
        double const scale = ldexp(1.0, (int)(random_next(&state) % 20) - 10);
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < 3; i++) p[i][c] = scale * random_range(&state, -1, 1);
            p[3][c] = p[0][c] + s * (p[1][c] - p[0][c]) + t * (p[2][c] - p[0][c]);
            if (k % 2) p[2][c] = p[0][c] + t * (p[1][c] - p[0][c]);
        }
        compare_with_rationals(p);
        zeros += orient3d_sign(p[0], p[1], p[2], p[3], &exact) == 0;
    }
    print_message("nearly coplanar: %zu zeros, %zu undecided by the filter\n", zeros, exact);
    assert_true(exact > 1000);
}

static double random_double(uint64_t *state, int kind) {
    double const mantissa = random_range(state, -1, 1);
    switch (kind) {
    case 0: return ldexp(mantissa, (int)(random_next(state) % 2098) - 1074); /* any magnitude */
    case 1: return ldexp(mantissa, -1040 - (int)(random_next(state) % 40));  /* subnormal */
    case 2: return ldexp(mantissa, 1024) * 0.9999;                           /* huge */
    case 3: return 0.0;
    default: return mantissa;
    }
}

static void every_magnitude_agrees(void **unused) {
    (void)unused;
    uint64_t state = 3;
    for (size_t k = 0; k < scaled(20000); k++) {
        double p[4][3];
        int const same_kind = k % 3 == 0 ? (int)(random_next(&state) % 3) : -1;
        for (int i = 0; i < 12; i++)
            p[i / 3][i % 3] =
                random_double(&state, same_kind >= 0 ? same_kind : (int)(random_next(&state) % 5));
        if (k % 4 == 0) memcpy(p[3], p[1], sizeof p[3]);
        if (k % 4 == 1) p[3][1] = nextafter(p[1][1], 1.0), p[3][0] = p[1][0], p[3][2] = p[1][2];
        compare_with_rationals(p);
    }
    double extreme[4][3] = {{-DBL_MAX, -DBL_MAX, -DBL_MAX},
                            {DBL_MAX, DBL_MAX, DBL_MAX},
                            {0, 0, 0x1p-1074},
                            {DBL_MAX, -0x1p-1074, DBL_MAX}};
    compare_with_rationals(extreme);
}

/* Points base + k 2^-52, 0 <= k < 16: all differences are small multiples of the last bit, so that
 * ordinary integers know the sign. */
static void tiny_grid_agrees(void **unused) {
    (void)unused;
    uint64_t state = 4;
    size_t exact = 0;
    size_t const count = scaled(1000000);
    double const start = timer_now();
    for (size_t k = 0; k < count; k++) {
        double p[4][3];
        wide q[4][3];
        uint64_t const bits = random_next(&state);
        for (int i = 0; i < 12; i++) {
            int const step = (int)(bits >> (5 * i) & 15);
            p[i / 3][i % 3] = 1.0 + step * 0x1p-52;
            q[i / 3][i % 3] = step;
        }
        for (int i = 1; i < 4; i++)
            for (int c = 0; c < 3; c++) q[i][c] -= q[0][c];
        wide const plane = q[1][0] * q[2][1] - q[1][1] * q[2][0];
        wide const space = plane * q[3][2] + (q[2][0] * q[3][1] - q[2][1] * q[3][0]) * q[1][2] +
                           (q[3][0] * q[1][1] - q[3][1] * q[1][0]) * q[2][2];
        if (orient3d_sign(p[0], p[1], p[2], p[3], &exact) != (space > 0) - (space < 0))
            fail_msg("orient3d is wrong in case %zu", k);
        if (orient2d_sign(p[0], p[1], p[2], &exact) != (plane > 0) - (plane < 0))
            fail_msg("orient2d is wrong in case %zu", k);
    }
    print_message("tiny grid: %zu cases, %zu undecided by the filter, %.3g us a case\n", count,
                  exact, 1e6 * (timer_now() - start) / (double)count);
}

/* 27-bit integers: determinants up to 2^85 with frequent zeros by repeated and collinear points. */
static void large_integers_agree(void **unused) {
    (void)unused;
    uint64_t state = 5;
    size_t const count = scaled(1000000);
    for (size_t k = 0; k < count; k++) {
        double p[4][3];
        wide q[4][3];
        for (int i = 0; i < 12; i++)
            q[i / 3][i % 3] = (wide)(random_next(&state) >> 38) - (1 << 25);
        for (int c = 0; c < 3; c++) {
            if (k % 3 == 0) q[3][c] = 2 * q[1][c] - q[0][c] + (c == 0 ? (int)(k / 3 % 3) - 1 : 0);
            if (k % 5 == 0) q[2][c] = 3 * q[1][c] - 2 * q[0][c];
            for (int i = 0; i < 4; i++) p[i][c] = (double)q[i][c];
        }
        for (int i = 1; i < 4; i++)
            for (int c = 0; c < 3; c++) q[i][c] -= q[0][c];
        wide const plane = q[1][0] * q[2][1] - q[1][1] * q[2][0];
        wide const space = plane * q[3][2] + (q[2][0] * q[3][1] - q[2][1] * q[3][0]) * q[1][2] +
                           (q[3][0] * q[1][1] - q[3][1] * q[1][0]) * q[2][2];
        if (orient3d_sign(p[0], p[1], p[2], p[3], NULL) != (space > 0) - (space < 0))
            fail_msg("orient3d is wrong in case %zu", k);
        if (orient2d_sign(p[0], p[1], p[2], NULL) != (plane > 0) - (plane < 0))
            fail_msg("orient2d is wrong in case %zu", k);
    }
}

static void sign_convention_holds(void **unused) {
    (void)unused;
    double const o[3] = {0, 0, 0}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
    assert_int_equal(orient2d_sign(o, x, y, NULL), 1);
    assert_int_equal(orient2d_sign(o, y, x, NULL), -1);
    assert_int_equal(orient3d_sign(o, x, y, z, NULL), 1);
    assert_int_equal(orient3d_sign(o, y, x, z, NULL), -1);
    assert_int_equal(orient3d_sign(o, x, y, x, NULL), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sign_convention_holds),
        cmocka_unit_test(random_points_agree),
        cmocka_unit_test(nearly_coplanar_points_agree),
        cmocka_unit_test(every_magnitude_agrees),
        cmocka_unit_test(tiny_grid_agrees),
        cmocka_unit_test(large_integers_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
