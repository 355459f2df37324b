/* io/animation/matrix.h - matrices of 4 x 4, columns one behind the other, as glTF has them; USD
 * writes its rows, which act from the right, in the same order. And what a mirror does. */
#ifndef TULLE_IO_ANIMATION_MATRIX_H
#define TULLE_IO_ANIMATION_MATRIX_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static const double MATRIX_IDENTITY[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static inline bool matrix_is_identity(const double *matrix) {
    for (int i = 0; i < 16; i++)
        if (matrix[i] != MATRIX_IDENTITY[i]) return false;
    return true;
}

/* a b: first b, then a. The product may be either of them. */
static inline void matrix_multiply(const double *a, const double *b, double *product) {
    double made[16];
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            made[4 * column + row] = 0.0;
            for (int k = 0; k < 4; k++)
                made[4 * column + row] += a[4 * k + row] * b[4 * column + k];
        }
    memcpy(product, made, sizeof made);
}

/* A point where the matrix moves it; may be moved in place. */
static inline void matrix_transform(const double *matrix, const double *point, double *moved) {
    double const x = point[0], y = point[1], z = point[2];
    for (int row = 0; row < 3; row++)
        moved[row] = matrix[row] * x + matrix[4 + row] * y + matrix[8 + row] * z + matrix[12 + row];
}

/* Below 0 where the matrix mirrors. */
static inline double matrix_get_determinant(const double *matrix) {
    const double *const a = matrix, *const b = matrix + 4, *const c = matrix + 8;
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Turns triangles round: what faced outwards in a mirror does so again. */
static inline void turn_triangles(uint32_t *triangles, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t const second = triangles[3 * i + 1];
        triangles[3 * i + 1] = triangles[3 * i + 2];
        triangles[3 * i + 2] = second;
    }
}

/* Translation t, after the rotation of the unit quaternion q = x, y, z, w, after the scale s. */
static inline void matrix_make(const double *t, const double *q, const double *s, double *matrix) {
    double const x = q[0], y = q[1], z = q[2], w = q[3];
    double const rows[3][3] = {
        {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)},
        {2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)},
        {2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)}};
    memcpy(matrix, MATRIX_IDENTITY, sizeof MATRIX_IDENTITY);
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++) matrix[4 * column + row] = rows[row][column] * s[column];
    memcpy(matrix + 12, t, 3 * sizeof(double));
}

/* Columns whose angle has a cosine as small are at right angles: texts of six digits are. */
static const double MATRIX_RIGHT_ANGLE = 1e-5;

/* Finds what matrix_make makes a matrix of; the first scale is negative in a mirror. False where
 * it shears or flattens. */
static inline bool matrix_split(const double *matrix, double *t, double *q, double *s) {
    double r[3][3]; /* columns of the rotation */
    for (int c = 0; c < 3; c++) {
        const double *const column = matrix + 4 * c;
        s[c] = sqrt(column[0] * column[0] + column[1] * column[1] + column[2] * column[2]);
        if (!(s[c] > 0.0 && isfinite(s[c]))) return false;
        if (c == 0 && matrix_get_determinant(matrix) < 0.0) s[c] = -s[c];
        for (int row = 0; row < 3; row++) r[c][row] = column[row] / s[c];
    }
    for (int c = 0; c < 3; c++) {
        const double *const a = r[c], *const b = r[(c + 1) % 3];
        if (fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) > MATRIX_RIGHT_ANGLE) return false;
    }
    memcpy(t, matrix + 12, 3 * sizeof(double));
    double const trace = r[0][0] + r[1][1] + r[2][2];
    int i = 0; /* the axis with the largest number on the diagonal */
    for (int k = 1; k < 3; k++)
        if (r[k][k] > r[i][i]) i = k;
    int const j = (i + 1) % 3, k = (i + 2) % 3;
    if (trace > r[i][i]) {
        q[3] = 1.0 + trace;
        for (int a = 0; a < 3; a++)
            q[a] = r[(a + 1) % 3][(a + 2) % 3] - r[(a + 2) % 3][(a + 1) % 3];
    } else {
        q[i] = 1.0 + r[i][i] - r[j][j] - r[k][k];
        q[j] = r[i][j] + r[j][i];
        q[k] = r[i][k] + r[k][i];
        q[3] = r[j][k] - r[k][j];
    }
    double const length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int a = 0; a < 4; a++) q[a] /= length;
    return true;
}

#endif
