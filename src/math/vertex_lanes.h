/* math/vertex_lanes.h - for kernels: three numbers of a vertex in one vector, and eight of them
 * turned into vectors of eight. The same bits on every vector width. */
#ifndef TULLE_MATH_VERTEX_LANES_H
#define TULLE_MATH_VERTEX_LANES_H

#include "math/simd_double.h"
#include "math/vec3.h"

/* Four doubles. Of three numbers the last lane is whatever follows. */
typedef double lanes4 __attribute__((vector_size(32)));
typedef double lanes2 __attribute__((vector_size(16)));
/* Four at any address of a double. */
typedef double lanes4_anywhere __attribute__((vector_size(32), aligned(8), may_alias));

/* Arrays of three numbers an item. Four are read, and the last item has none after it. */
typedef struct lane_source {
    const double *values;
    size_t last;
    double last_item[4];
} lane_source;

static inline lane_source lane_source_make(const double *values, size_t count) {
    lane_source source = {.values = values};
    if (count == 0) return source;
    source.last = count - 1;
    memcpy(source.last_item, values + 3 * source.last, 3 * sizeof(double));
    return source;
}

SIMD_INLINE lanes4 lanes4_load(const double *from) { return *(const lanes4_anywhere *)from; }

SIMD_INLINE lanes4 lanes4_get(const lane_source *source, size_t item) {
    return lanes4_load(item == source->last ? source->last_item : source->values + 3 * item);
}

/* The first three lanes. */
SIMD_INLINE void lanes4_store3(double *to, lanes4 a) {
    for (int i = 0; i < 3; i++) to[i] = a[i];
}

typedef struct double8x4 {
    double8 at[4];
} double8x4;

/* Lane i of row k becomes lane k of number i. */
SIMD_INLINE double8x4 lanes4_turn(const lanes4 rows[DOUBLE_LANES]) {
    lanes4 turned[2][4];
    for (int half = 0; half < 2; half++) {
        const lanes4 *const row = rows + 4 * half;
        lanes4 const even01 = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6);
        lanes4 const odd01 = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
        lanes4 const even23 = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6);
        lanes4 const odd23 = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
        turned[half][0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
        turned[half][1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
        turned[half][2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
        turned[half][3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
    }
    double8x4 result;
    for (int i = 0; i < 4; i++)
        result.at[i] = __builtin_shufflevector(turned[0][i], turned[1][i], 0, 1, 2, 3, 4, 5, 6, 7);
    return result;
}

SIMD_INLINE vec3x8 lanes4_turn3(const lanes4 rows[DOUBLE_LANES]) {
    double8x4 const turned = lanes4_turn(rows);
    return (vec3x8){turned.at[0], turned.at[1], turned.at[2]};
}

/* The other way round. */
SIMD_INLINE void lanes4_turn_back(double8 a, double8 b, double8 c, double8 d,
                                  lanes4 rows[DOUBLE_LANES]) {
    double8 const all[4] = {a, b, c, d};
    lanes4 halves[2][4];
    for (int i = 0; i < 4; i++) {
        halves[0][i] = __builtin_shufflevector(all[i], all[i], 0, 1, 2, 3);
        halves[1][i] = __builtin_shufflevector(all[i], all[i], 4, 5, 6, 7);
    }
    for (int half = 0; half < 2; half++) {
        const lanes4 *const column = halves[half];
        lanes4 *const row = rows + 4 * half;
        lanes4 const even01 = __builtin_shufflevector(column[0], column[1], 0, 4, 2, 6);
        lanes4 const odd01 = __builtin_shufflevector(column[0], column[1], 1, 5, 3, 7);
        lanes4 const even23 = __builtin_shufflevector(column[2], column[3], 0, 4, 2, 6);
        lanes4 const odd23 = __builtin_shufflevector(column[2], column[3], 1, 5, 3, 7);
        row[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
        row[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
        row[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
        row[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
    }
}

#endif
