/* geom/exact_predicates.c - see exact_predicates.h.
 *
 * The filter. Let u = 2^-53 and each computed operation be the exact one times (1 + e), |e| <= u,
 * as long as nothing underflows. Written out, the 3x3 determinant is a sum of six terms, each a
 * product of three coordinate differences. A computed term carries at most eight such factors:
 * three from its differences, one from the product of two of them, one from the subtraction of the
 * two products, one from the product with the third, two from the additions. So the computed
 * determinant differs from the exact one by at most ((1 + u)^8 - 1) S, S the sum of the terms'
 * magnitudes. The permanent P, the same formula with every term made positive, is computed with the
 * same factors, so S <= P / (1 - u)^8, and the error is below (8 u + 100 u^2) P < 9 u P. The bound
 * used is 10 u P, which also covers the rounding of that product itself.
 *
 * Underflow: sums and differences are exact there; a product that underflows is off by at most
 * 2^-1075. A product of two coordinates' differences has that error multiplied by the third
 * difference, so all of it together stays below 2^-1070 (1 + sum of the |third differences|). The
 * far larger 2^-1000 is added instead, because it is a normal number (arithmetic with subnormal
 * ones is slow). Overflow makes P infinite or NaN; no comparison with it succeeds, and the integers
 * decide.
 */
#include "geom/exact_predicates.h"

#include "geom/big_integer.h"

#include <math.h>

static const double FILTER = 10.0 * 0x1p-53;     /* relative to the permanent; derived above */
static const double UNDERFLOW_BOUND = 0x1p-1000; /* above any sum of underflow errors */

/* The sign of the determinant of these points, by integers. */
static int sign_exact(const double *a, const double *b, const double *c, const double *d) {
    static const int next[3] = {1, 2, 0};
    big_integer difference[3][3], left, right, minor, term[3], partial; /* difference[axis][bcd] */
    for (int axis = 0; axis < 3; axis++)
        big_integer_set_differences(difference[axis],
                                    (double[]){a[axis], b[axis], c[axis], d[axis]}, 4);
    for (int k = 0; k < 3; k++) { /* term[k] = (x[i] y[j] - x[j] y[i]) z[k] */
        int const i = next[k], j = next[i];
        big_integer_multiply(&left, &difference[0][i], &difference[1][j]);
        big_integer_multiply(&right, &difference[0][j], &difference[1][i]);
        big_integer_add(&minor, &left, &right, -1);
        big_integer_multiply(&term[k], &minor, &difference[2][k]);
    }
    big_integer_add(&partial, &term[0], &term[1], 1);
    big_integer_add(&left, &partial, &term[2], 1);
    return left.sign;
}

int orient3d_sign(const double a[3], const double b[3], const double c[3], const double d[3],
                  size_t *exact_count) {
    double const bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
    double const cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
    double const dx = d[0] - a[0], dy = d[1] - a[1], dz = d[2] - a[2];
    double const cxdy = cx * dy, dxcy = dx * cy;
    double const dxby = dx * by, bxdy = bx * dy;
    double const bxcy = bx * cy, cxby = cx * by;
    double const determinant = bz * (cxdy - dxcy) + cz * (dxby - bxdy) + dz * (bxcy - cxby);
    double const permanent = fabs(bz) * (fabs(cxdy) + fabs(dxcy)) +
                             fabs(cz) * (fabs(dxby) + fabs(bxdy)) +
                             fabs(dz) * (fabs(bxcy) + fabs(cxby));
    double const bound =
        FILTER * permanent + UNDERFLOW_BOUND * (1.0 + fabs(bz) + fabs(cz) + fabs(dz));
    if (determinant > bound) return 1;
    if (-determinant > bound) return -1;
    /* A difference is zero exactly when the coordinates are equal: all in one axis-aligned plane.
     */
    if ((bz == 0.0 && cz == 0.0 && dz == 0.0) || (by == 0.0 && cy == 0.0 && dy == 0.0) ||
        (bx == 0.0 && cx == 0.0 && dx == 0.0))
        return 0;
    if (exact_count) (*exact_count)++;
    return sign_exact(a, b, c, d);
}

int orient2d_sign(const double a[2], const double b[2], const double c[2], size_t *exact_count) {
    /* With a fourth point at height 1 over a, the determinant in space is that in the plane. */
    return orient3d_sign((double[3]){a[0], a[1], 0.0}, (double[3]){b[0], b[1], 0.0},
                         (double[3]){c[0], c[1], 0.0}, (double[3]){a[0], a[1], 1.0}, exact_count);
}
