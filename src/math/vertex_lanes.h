/* math/vertex_lanes.h - for kernels: three numbers of a vertex in one vector, and some of them
 * turned into as many of each. The same bits on every vector width. */
#ifndef TULLE_MATH_VERTEX_LANES_H
#define TULLE_MATH_VERTEX_LANES_H

#include "math/simd_wide.h"
#include "math/vec3.h"

#include <stdbool.h>

/* Four doubles. Of three numbers the last lane is whatever follows. */
typedef double lanes4 __attribute__((vector_size(32)));
typedef double lanes2 __attribute__((vector_size(16)));
/* Four at any address of a double. */
typedef double lanes4_anywhere __attribute__((vector_size(32), aligned(8), may_alias));

/* Arrays of three numbers an item. Four are read, and the last item has none after it; but where
 * they are padded, each item has a fourth. */
typedef struct lane_source {
    const double *values;
    size_t last;
    double last_item[4];
    bool is_padded;
} lane_source;

static inline lane_source lane_source_make(const double *values, size_t count) {
    lane_source source = {.values = values};
    if (count == 0) return source;
    source.last = count - 1;
    memcpy(source.last_item, values + 3 * source.last, 3 * sizeof(double));
    return source;
}

static inline lane_source lane_source_pad(const double *values) {
    return (lane_source){.values = values, .is_padded = true};
}

SIMD_INLINE lanes4 lanes4_load(const double *from) { return *(const lanes4_anywhere *)from; }

SIMD_INLINE lanes4 lanes4_get(const lane_source *source, size_t item) {
    if (source->is_padded) return lanes4_load(source->values + 4 * item);
    return lanes4_load(item == source->last ? source->last_item : source->values + 3 * item);
}

/* The first three lanes. */
SIMD_INLINE void lanes4_store3(double *to, lanes4 a) {
    for (int i = 0; i < 3; i++) to[i] = a[i];
}

typedef struct wide_turned {
    wide at[4];
} wide_turned;

#define SHUFFLE __builtin_shufflevector

/* lanes4_turn: lane i of row k becomes lane k of number i. lanes4_turn_back: the other way round.
 */
#if defined __AVX512F__
SIMD_INLINE wide lanes4_join(lanes4 a, lanes4 b) {
    return (wide)_mm512_insertf64x4(_mm512_castpd256_pd512((__m256d)a), (__m256d)b, 1);
}

SIMD_INLINE wide_turned lanes4_turn(const lanes4 rows[WIDE_LANES]) {
    /* Rows in such an order that pairs of lanes end up in theirs. */
    wide const a = lanes4_join(rows[0], rows[2]), b = lanes4_join(rows[1], rows[3]);
    wide const c = lanes4_join(rows[4], rows[6]), d = lanes4_join(rows[5], rows[7]);
    wide const even_ab = SHUFFLE(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    wide const even_cd = SHUFFLE(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
    wide const odd_ab = SHUFFLE(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    wide const odd_cd = SHUFFLE(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
    return (wide_turned){{SHUFFLE(even_ab, even_cd, 0, 1, 4, 5, 8, 9, 12, 13),
                          SHUFFLE(odd_ab, odd_cd, 0, 1, 4, 5, 8, 9, 12, 13),
                          SHUFFLE(even_ab, even_cd, 2, 3, 6, 7, 10, 11, 14, 15),
                          SHUFFLE(odd_ab, odd_cd, 2, 3, 6, 7, 10, 11, 14, 15)}};
}

SIMD_INLINE void lanes4_turn_back(wide a, wide b, wide c, wide d, lanes4 rows[WIDE_LANES]) {
    wide const left[2] = {SHUFFLE(a, b, 0, 8, 2, 10, 4, 12, 6, 14),
                          SHUFFLE(a, b, 1, 9, 3, 11, 5, 13, 7, 15)};
    wide const right[2] = {SHUFFLE(c, d, 0, 8, 2, 10, 4, 12, 6, 14),
                           SHUFFLE(c, d, 1, 9, 3, 11, 5, 13, 7, 15)};
    for (int i = 0; i < 2; i++) {
        wide const low = SHUFFLE(left[i], right[i], 0, 1, 8, 9, 2, 3, 10, 11);
        wide const high = SHUFFLE(left[i], right[i], 4, 5, 12, 13, 6, 7, 14, 15);
        rows[i] = (lanes4)_mm512_castpd512_pd256((__m512d)low);
        rows[2 + i] = (lanes4)_mm512_extractf64x4_pd((__m512d)low, 1);
        rows[4 + i] = (lanes4)_mm512_castpd512_pd256((__m512d)high);
        rows[6 + i] = (lanes4)_mm512_extractf64x4_pd((__m512d)high, 1);
    }
}
#elif defined __AVX2__
SIMD_INLINE wide_turned lanes4_turn(const lanes4 rows[WIDE_LANES]) {
    lanes4 const even01 = SHUFFLE(rows[0], rows[1], 0, 4, 2, 6);
    lanes4 const odd01 = SHUFFLE(rows[0], rows[1], 1, 5, 3, 7);
    lanes4 const even23 = SHUFFLE(rows[2], rows[3], 0, 4, 2, 6);
    lanes4 const odd23 = SHUFFLE(rows[2], rows[3], 1, 5, 3, 7);
    return (wide_turned){{SHUFFLE(even01, even23, 0, 1, 4, 5), SHUFFLE(odd01, odd23, 0, 1, 4, 5),
                          SHUFFLE(even01, even23, 2, 3, 6, 7), SHUFFLE(odd01, odd23, 2, 3, 6, 7)}};
}

SIMD_INLINE void lanes4_turn_back(wide a, wide b, wide c, wide d, lanes4 rows[WIDE_LANES]) {
    lanes4 const columns[WIDE_LANES] = {a, b, c, d};
    wide_turned const turned = lanes4_turn(columns);
    for (int k = 0; k < WIDE_LANES; k++) rows[k] = turned.at[k];
}
#else
SIMD_INLINE wide_turned lanes4_turn(const lanes4 rows[WIDE_LANES]) {
    return (wide_turned){{SHUFFLE(rows[0], rows[1], 0, 4), SHUFFLE(rows[0], rows[1], 1, 5),
                          SHUFFLE(rows[0], rows[1], 2, 6), SHUFFLE(rows[0], rows[1], 3, 7)}};
}

SIMD_INLINE void lanes4_turn_back(wide a, wide b, wide c, wide d, lanes4 rows[WIDE_LANES]) {
    for (int k = 0; k < WIDE_LANES; k++) rows[k] = (lanes4){a[k], b[k], c[k], d[k]};
}
#endif

#undef SHUFFLE

SIMD_INLINE wide3 lanes4_turn3(const lanes4 rows[WIDE_LANES]) {
    wide_turned const turned = lanes4_turn(rows);
    return (wide3){turned.at[0], turned.at[1], turned.at[2]};
}

/* Three vectors for each of some triangles, one behind the other. */
typedef struct corner_rows {
    lanes4 at[3][WIDE_LANES];
} corner_rows;

SIMD_INLINE corner_rows corner_rows_make(const wide3 corners[3]) {
    corner_rows rows;
    for (int k = 0; k < 3; k++)
        lanes4_turn_back(corners[k].x, corners[k].y, corners[k].z, corners[k].z, rows.at[k]);
    return rows;
}

/* The fourth number of a vector goes where the next one begins, which is written after it. */
SIMD_INLINE void corner_rows_store(const corner_rows *rows, vec3 *to) {
    for (size_t k = 0; k + 1 < WIDE_LANES; k++)
        for (size_t i = 0; i < 3; i++) *(lanes4_anywhere *)&to[3 * k + i].x = rows->at[i][k];
    vec3 *const last = to + 3 * (WIDE_LANES - 1);
    for (size_t i = 0; i < 2; i++) *(lanes4_anywhere *)&last[i].x = rows->at[i][WIDE_LANES - 1];
    lanes4_store3(&last[2].x, rows->at[2][WIDE_LANES - 1]);
}

#endif
