/* math/vec3.h - vectors of three doubles and 3x3 matrices, by value. Layout equals double[3] and
 * double[9] (row-major). */
#ifndef TULLE_MATH_VEC3_H
#define TULLE_MATH_VEC3_H

#include <math.h>
#include <stddef.h>

typedef struct vec3 {
    double x, y, z;
} vec3;
typedef struct mat3 {
    double m[9];
} mat3; /* m[3 * row + column] */

static inline vec3 vec3_make(double x, double y, double z) { return (vec3){x, y, z}; }
/* Vertex `index` of an array of xyz triples. */
static inline vec3 vec3_load(const double *array, size_t index) {
    return (vec3){array[3 * index], array[3 * index + 1], array[3 * index + 2]};
}
static inline void vec3_store(double *array, size_t index, vec3 a) {
    array[3 * index] = a.x;
    array[3 * index + 1] = a.y;
    array[3 * index + 2] = a.z;
}
static inline vec3 vec3_add(vec3 a, vec3 b) { return (vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec3 vec3_sub(vec3 a, vec3 b) { return (vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec3 vec3_scale(vec3 a, double s) { return (vec3){a.x * s, a.y * s, a.z * s}; }
static inline vec3 vec3_neg(vec3 a) { return (vec3){-a.x, -a.y, -a.z}; }
/* a + s b */
static inline vec3 vec3_add_scaled(vec3 a, vec3 b, double s) {
    return (vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
/* (1 - t) a + t b */
static inline vec3 vec3_lerp(vec3 a, vec3 b, double t) {
    return vec3_add_scaled(a, vec3_sub(b, a), t);
}
static inline double vec3_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec3 vec3_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double vec3_norm2(vec3 a) { return vec3_dot(a, a); }
static inline double vec3_norm(vec3 a) { return sqrt(vec3_dot(a, a)); }
/* a / |a|, or zero where |a| is zero. */
static inline vec3 vec3_normalize(vec3 a) {
    double const norm = vec3_norm(a);
    return norm > 0.0 ? vec3_scale(a, 1.0 / norm) : (vec3){0.0, 0.0, 0.0};
}
/* The part of a at right angles to a unit vector. */
static inline vec3 vec3_reject(vec3 a, vec3 unit) {
    return vec3_add_scaled(a, unit, -vec3_dot(unit, a));
}

static inline mat3 mat3_scale(const mat3 *a, double s) {
    mat3 result;
    for (int i = 0; i < 9; i++) result.m[i] = s * a->m[i];
    return result;
}
static inline mat3 mat3_identity(double s) { return (mat3){{s, 0, 0, 0, s, 0, 0, 0, s}}; }
static inline vec3 mat3_multiply_vec3(const mat3 *a, vec3 b) {
    return (vec3){a->m[0] * b.x + a->m[1] * b.y + a->m[2] * b.z,
                  a->m[3] * b.x + a->m[4] * b.y + a->m[5] * b.z,
                  a->m[6] * b.x + a->m[7] * b.y + a->m[8] * b.z};
}
/* s a b^T */
static inline mat3 mat3_outer(vec3 a, vec3 b, double s) {
    return (mat3){{s * a.x * b.x, s * a.x * b.y, s * a.x * b.z, s * a.y * b.x, s * a.y * b.y,
                   s * a.y * b.z, s * a.z * b.x, s * a.z * b.y, s * a.z * b.z}};
}
static inline void mat3_add_scaled(mat3 *a, const mat3 *b, double s) {
    for (int i = 0; i < 9; i++) a->m[i] += s * b->m[i];
}

#endif
