/* io/animation/matrix.h - matrices of 4 x 4, columns one behind the other, as glTF has them; USD
 * writes its rows, which act from the right, in the same order. And what a mirror does. */
#ifndef TULLE_IO_ANIMATION_MATRIX_H
#define TULLE_IO_ANIMATION_MATRIX_H

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

#endif
