/* detect/kernels/fit_boxes.c - boxes of moving vertices, of nodes above leaves, and of the features
 * of a leaf.
 *
 * The box of a vertex holds its path widened by half the margin, rounded outward to floats. All
 * other boxes are unions of those, without rounding. Eight features are united at a time and turned
 * into rows. */
#include "detect/tree_kernels.h"

#include <math.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

/* Rounding of (x - origin) * scale - half, relative to the magnitude of its parts: four roundings
 * of 2^-53 and some room. */
#define FRAME_ROUNDING 1e-15
/* Twice the rounding of a conversion to float, so that it ends outside; and where floats are
 * denormal. */
#define FLOAT_ROUNDING 0x1.0p-23
#define FLOAT_UNDERFLOW 0x1.0p-140
/* Box coordinates beyond this are moved to it, in order, so comparisons stay conservative. */
#define MOST_COORDINATE 3e38

enum { PREFETCH = 16 }; /* vertices ahead */

typedef double lanes4 __attribute__((vector_size(32)));
typedef int64_t bits4 __attribute__((vector_size(32)));
typedef float floats4 __attribute__((vector_size(16)));

static inline lanes4 choose(bits4 mask, lanes4 yes, lanes4 no) {
    return (lanes4)((mask & (bits4)yes) | (~mask & (bits4)no));
}
/* a < b ? a : b and a > b ? a : b. */
static inline lanes4 lesser(lanes4 a, lanes4 b) {
#ifdef __AVX2__
    return (lanes4)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    return choose(a < b, a, b);
#endif
}
static inline lanes4 greater(lanes4 a, lanes4 b) {
#ifdef __AVX2__
    return (lanes4)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    return choose(a > b, a, b);
#endif
}
static inline lanes4 absolute(lanes4 a) { return (lanes4)((bits4)a & INT64_MAX); }
static inline lanes4 spread(double x) { return (lanes4){x, x, x, x}; }
static inline lanes4 clamp(lanes4 x) {
    lanes4 const most = spread(MOST_COORDINATE);
    return greater(-most, lesser(most, x));
}
static inline lanes4 load_point(const double *x, size_t vertex) {
    return (lanes4){x[3 * vertex], x[3 * vertex + 1], x[3 * vertex + 2], 0.0};
}
static inline lanes4 load4(const double *x) {
    lanes4 lanes;
    memcpy(&lanes, x, sizeof lanes);
    return lanes;
}

bool TULLE_KERNEL(fit_vertices)(const vertex_fit *fit, size_t begin, size_t end) {
    lanes4 const origin = load4(fit->origin), scale = load4(fit->scale), half = load4(fit->half);
    lanes4 doubt = spread(0.0); /* becomes NaN with the first value that is not finite */
    for (size_t i = begin; i < end; i++) {
        size_t const vertex = fit->vertices ? fit->vertices[i] : i;
        if (fit->vertices) {
            size_t const ahead = fit->vertices[i + PREFETCH < end ? i + PREFETCH : i];
            __builtin_prefetch(fit->x0 + 3 * ahead);
            __builtin_prefetch(fit->x1 + 3 * ahead);
        }
        lanes4 const start = load_point(fit->x0, vertex), stop = load_point(fit->x1, vertex);
        memcpy(fit->records[i].start, &start, sizeof start);
        memcpy(fit->records[i].end, &stop, sizeof stop);
        doubt += (start - start) + (stop - stop);
        lanes4 const a = clamp((start - origin) * scale), b = clamp((stop - origin) * scale);
        lanes4 const least = lesser(a, b) - half, most = greater(b, a) + half;
        lanes4 const larger = greater(absolute(a), absolute(b));
        lanes4 const rounding = FRAME_ROUNDING * (larger + half) + FLOAT_UNDERFLOW;
        lanes4 const low = clamp(least - (FLOAT_ROUNDING * absolute(least) + rounding));
        lanes4 const high = clamp(most + (FLOAT_ROUNDING * absolute(most) + rounding));
        floats4 const lows = __builtin_convertvector(low, floats4);
        floats4 const highs = __builtin_convertvector(-high, floats4);
        memcpy(fit->boxes[i].sides, &lows, sizeof lows);
        memcpy(fit->boxes[i].sides + 4, &highs, sizeof highs);
    }
    return doubt[0] + doubt[1] + doubt[2] == 0.0;
}

#ifdef __AVX2__

typedef __m256 box_vector;

static inline box_vector load_box(const vertex_box *box) { return _mm256_loadu_ps(box->sides); }
static inline box_vector unite(box_vector a, box_vector b) { return _mm256_min_ps(a, b); }

/* Writes lane l of rows 0 .. 5 (low x, y, z, high x, y, z) from boxes[l]. */
static inline void write_rows(const box_vector boxes[8], float *rows, size_t width) {
    __m256 pairs[8], fours[8];
    for (int i = 0; i < 4; i++) {
        pairs[2 * i] = _mm256_unpacklo_ps(boxes[2 * i], boxes[2 * i + 1]);
        pairs[2 * i + 1] = _mm256_unpackhi_ps(boxes[2 * i], boxes[2 * i + 1]);
    }
    /* fours[4 h + k]: side k in the lower half, 4 + k in the upper, of boxes 4 h .. 4 h + 3 */
    for (int h = 0; h < 2; h++) {
        const __m256 *const p = pairs + 4 * h;
        fours[4 * h] = _mm256_shuffle_ps(p[0], p[2], 0x44);
        fours[4 * h + 1] = _mm256_shuffle_ps(p[0], p[2], 0xee);
        fours[4 * h + 2] = _mm256_shuffle_ps(p[1], p[3], 0x44);
    }
    __m256 const sign = _mm256_set1_ps(-0.0F);
    for (size_t k = 0; k < 3; k++) {
        __m256 const low = _mm256_permute2f128_ps(fours[k], fours[4 + k], 0x20);
        _mm256_storeu_ps(rows + k * width, low);
        pairs[k] = _mm256_xor_ps(_mm256_permute2f128_ps(fours[k], fours[4 + k], 0x31), sign);
    }
    for (size_t k = 0; k < 3; k++) _mm256_storeu_ps(rows + (3 + k) * width, pairs[k]);
}

static inline void write_box(box_vector box, float *to) {
    float sides[8];
    _mm256_storeu_ps(sides, box);
    for (int k = 0; k < 3; k++) {
        to[k] = sides[k];
        to[3 + k] = -sides[4 + k];
    }
}

#else

typedef vertex_box box_vector;

static inline box_vector load_box(const vertex_box *box) { return *box; }
static inline box_vector unite(box_vector a, box_vector b) {
    for (int k = 0; k < 8; k++)
        if (b.sides[k] < a.sides[k]) a.sides[k] = b.sides[k];
    return a;
}
static inline void write_rows(const box_vector boxes[8], float *rows, size_t width) {
    for (size_t k = 0; k < 3; k++)
        for (size_t l = 0; l < 8; l++) rows[k * width + l] = boxes[l].sides[k];
    for (size_t k = 0; k < 3; k++)
        for (size_t l = 0; l < 8; l++) rows[(3 + k) * width + l] = -boxes[l].sides[4 + k];
}
static inline void write_box(box_vector box, float *to) {
    for (int k = 0; k < 3; k++) {
        to[k] = box.sides[k];
        to[3 + k] = -box.sides[4 + k];
    }
}

#endif

/* Rows long enough for the triangles and vertices, or the edges, of any leaf. */
enum { WIDE_ROW = LEAF_TRIANGLES + LEAF_SLOTS + 8 };

/* Unions of the corners of `count` >= 1 features in eight lanes of wide rows, the last repeated. */
static inline box_vector fit_lanes(const leaf_fit *fit, const uint32_t *corners,
                                   size_t corner_count, size_t count, float *wide) {
    box_vector boxes[8];
    for (size_t l = 0; l < 8; l++) {
        const uint32_t *const corner = corners + corner_count * (l < count ? l : count - 1);
        boxes[l] = load_box(&fit->vertex_boxes[corner[0]]);
        for (size_t k = 1; k < corner_count; k++)
            boxes[l] = unite(boxes[l], load_box(&fit->vertex_boxes[corner[k]]));
    }
    write_rows(boxes, wide, WIDE_ROW);
    box_vector all = boxes[0];
    for (size_t l = 1; l < 8; l++) all = unite(all, boxes[l]);
    return all;
}

/* Features begin .. end - 1. */
static inline void fit_features(const leaf_fit *fit, const uint32_t *corners, size_t corner_count,
                                uint32_t begin, uint32_t end, float *wide) {
    for (uint32_t at = begin; at < end; at += 8)
        fit_lanes(fit, corners + corner_count * at, corner_count, end - at, wide + (at - begin));
}

/* Copies rows of at most 32, one after another, so that what is written beyond one is overwritten
 * by the next. */
static inline void close_rows(const float *wide, float *rows, size_t width) {
    for (size_t k = 0; k < 6; k++) {
        memcpy(rows + k * width, wide + k * WIDE_ROW, 16 * sizeof *rows);
        if (width > 16) memcpy(rows + k * width + 16, wide + k * WIDE_ROW + 16, 16 * sizeof *rows);
    }
}

void TULLE_KERNEL(fit_block)(const leaf_fit *fit, const tree_leaf *leaf, float *block) {
    float wide[6 * WIDE_ROW];
    size_t const triangles = leaf->triangle_end - leaf->triangle_begin;
    size_t const width = triangles + leaf->vertex_end - leaf->vertex_begin;
    const uint32_t *const corners = fit->triangle_corners + 3 * (size_t)leaf->triangle_begin;
    write_box(fit_lanes(fit, corners, 3, triangles, wide), block);
    fit_features(fit, fit->vertex_corners, 1, leaf->vertex_begin, leaf->vertex_end,
                 wide + triangles);
    close_rows(wide, block + LEAF_HEADER, width);
    fit_features(fit, fit->edge_corners, 2, leaf->edge_begin, leaf->edge_end, wide);
    close_rows(wide, block + LEAF_HEADER + 6 * width, leaf->edge_end - leaf->edge_begin);
}

/* A block that nothing is written beyond. */
static void fit_block_alone(const leaf_fit *fit, const tree_leaf *leaf) {
    enum { LONGEST = LEAF_HEADER + 6 * (LEAF_TRIANGLES + 2 * LEAF_SLOTS) };
    float block[LONGEST + BLOCK_SPARE];
    TULLE_KERNEL(fit_block)(fit, leaf, block);
    size_t const count = (leaf->triangle_end - leaf->triangle_begin) +
                         (leaf->vertex_end - leaf->vertex_begin) +
                         (leaf->edge_end - leaf->edge_begin);
    memcpy(fit->blocks + leaf->block, block, (LEAF_HEADER + 6 * count) * sizeof *block);
}

/* The last two blocks are made alone: what follows them may be in use by another worker, and one
 * block, of a single triangle that owns none of its corners and edges, is shorter than
 * BLOCK_SPARE. */
void TULLE_KERNEL(fit_leaves)(const leaf_fit *fit, size_t begin, size_t end) {
    _Static_assert(2 * (LEAF_HEADER + 6) >= BLOCK_SPARE, "two blocks take what one is in excess");
    for (size_t l = begin; l < end; l++)
        if (l + 2 < end)
            TULLE_KERNEL(fit_block)(fit, &fit->leaves[l], fit->blocks + fit->leaves[l].block);
        else
            fit_block_alone(fit, &fit->leaves[l]);
}

/* Around all triangles, so around all features. */
static inline box_vector unite_leaf(const leaf_fit *fit, const tree_leaf *leaf) {
    const uint32_t *corner = fit->triangle_corners + 3 * (size_t)leaf->triangle_begin;
    const uint32_t *const end = fit->triangle_corners + 3 * (size_t)leaf->triangle_end;
    box_vector a = load_box(&fit->vertex_boxes[corner[0]]), b = a, c = a;
    for (; corner < end; corner += 3) {
        a = unite(a, load_box(&fit->vertex_boxes[corner[0]]));
        b = unite(b, load_box(&fit->vertex_boxes[corner[1]]));
        c = unite(c, load_box(&fit->vertex_boxes[corner[2]]));
    }
    return unite(unite(a, b), c);
}

void TULLE_KERNEL(fit_lowest_nodes)(const leaf_fit *fit, tree_node *nodes, size_t begin,
                                    size_t end) {
    vertex_box nothing;
    for (size_t k = 0; k < 8; k++) nothing.sides[k] = INFINITY;
    for (size_t i = begin; i < end; i++) {
        tree_node *const node = &nodes[i];
        box_vector boxes[NODE_LANES];
        for (size_t c = 0; c < node->child_count; c++)
            boxes[c] = unite_leaf(fit, &fit->leaves[node->first + c]);
        for (size_t c = node->child_count; c < NODE_LANES; c++) boxes[c] = load_box(&nothing);
        write_rows(boxes, node->sides[0], NODE_LANES);
        box_vector all = boxes[0];
        for (size_t c = 1; c < NODE_LANES; c++) all = unite(all, boxes[c]);
        write_box(all, node->box);
    }
}
