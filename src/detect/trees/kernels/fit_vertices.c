/* detect/trees/kernels/fit_vertices.c - records of moving vertices, and their boxes at both ends: a
 * point widened by half the margin, rounded outward to floats. */
#include "detect/trees/kernels/box_vectors.h"
#include "detect/trees/tree_kernels.h"
#include "math/simd_double.h"

/* Rounding of (x - origin) * scale - half, relative to the magnitude of its parts: four roundings
 * of 2^-53 and some room. */
static const double FRAME_ROUNDING = 1e-15;
/* Twice the rounding of a conversion to float, so that it ends outside; and where floats are
 * denormal. */
static const double FLOAT_ROUNDING = 0x1.0p-23;
#define FLOAT_UNDERFLOW 0x1.0p-140
/* Box coordinates beyond this are moved to it, in order, so comparisons stay conservative. */
static const double MOST_COORDINATE = 3e38;

enum { PREFETCH = 16 }; /* vertices ahead */

/* Both ends of a path at once, or one after the other: compilers take wider vectors than the
 * processor has apart into single numbers. The same operations on each number. */
#ifdef __AVX512F__
enum { PARTS = 1 };
typedef double8 path_part;
typedef box_vector part_sides;

/* x, y, z and 0 of a vertex at the start, then at the end. */
static inline path_part load_part(const double *start, const double *end, int part) {
    (void)part;
    __m512d const low = _mm512_castpd256_pd512(_mm256_maskz_loadu_pd(7, start));
    return (double8)_mm512_insertf64x4(low, _mm256_maskz_loadu_pd(7, end), 1);
}
static inline path_part lesser(path_part a, path_part b) { return double8_min(a, b); }
static inline path_part greater(path_part a, path_part b) { return double8_max(a, b); }
static inline path_part absolute(path_part a) { return double8_abs(a); }
#else
enum { PARTS = 2 };
typedef double path_part __attribute__((vector_size(32)));
typedef int64_t part_bits __attribute__((vector_size(32)));
typedef float part_sides __attribute__((vector_size(16)));

static inline path_part load_part(const double *start, const double *end, int part) {
    const double *const x = part == 0 ? start : end;
    return (path_part){x[0], x[1], x[2], 0.0};
}
#ifdef __AVX2__
static inline path_part lesser(path_part a, path_part b) {
    return (path_part)_mm256_min_pd((__m256d)a, (__m256d)b);
}
static inline path_part greater(path_part a, path_part b) {
    return (path_part)_mm256_max_pd((__m256d)a, (__m256d)b);
}
#else
static inline path_part choose(part_bits mask, path_part yes, path_part no) {
    return (path_part)((mask & (part_bits)yes) | (~mask & (part_bits)no));
}
static inline path_part lesser(path_part a, path_part b) { return choose(a < b, a, b); }
static inline path_part greater(path_part a, path_part b) { return choose(a > b, a, b); }
#endif
static inline path_part absolute(path_part a) { return (path_part)((part_bits)a & INT64_MAX); }
#endif

static inline path_part load_numbers(const double *from) {
    path_part part;
    memcpy(&part, from, sizeof part);
    return part;
}
static inline path_part clamp(path_part x) {
    path_part const most = MOST_COORDINATE - (path_part){0.0};
    return greater(-most, lesser(most, x));
}

/* Low and -high sides of what is at x in box coordinates. */
static inline void compute_sides(path_part x, path_part half, path_part tiny, part_sides sides[2]) {
    path_part const rounding = FRAME_ROUNDING * (absolute(x) + half) + tiny;
    path_part const least = x - half, most = x + half;
    path_part const low = clamp(least - (FLOAT_ROUNDING * absolute(least) + rounding));
    path_part const high = clamp(most + (FLOAT_ROUNDING * absolute(most) + rounding));
    sides[0] = __builtin_convertvector(low, part_sides);
    sides[1] = __builtin_convertvector(-high, part_sides);
}

static inline void write_sides(part_sides sides[PARTS][2], vertex_box *to) {
#ifdef __AVX512F__
    box_vector const low = sides[0][0], high = sides[0][1];
    box_vector_store(to->start, BOX_SHUFFLE(low, high, 0, 1, 2, 3, 8, 9, 10, 11));
    box_vector_store(to->end, BOX_SHUFFLE(low, high, 4, 5, 6, 7, 12, 13, 14, 15));
#else
    memcpy(to->start, sides[0], sizeof to->start);
    memcpy(to->end, sides[1], sizeof to->end);
#endif
}

/* Sum over the axes of how far a vertex goes. */
static inline double add_motion(path_part x[PARTS]) {
#ifdef __AVX512F__
    __m256d const start = _mm512_castpd512_pd256((__m512d)x[0]);
    __m256d const end = _mm512_extractf64x4_pd((__m512d)x[0], 1);
    __m256d const motion = _mm256_andnot_pd(_mm256_set1_pd(-0.0), _mm256_sub_pd(end, start));
    return motion[0] + motion[1] + motion[2];
#else
    path_part const motion = absolute(x[1] - x[0]);
    return motion[0] + motion[1] + motion[2];
#endif
}

bool TULLE_KERNEL(fit_vertices)(const vertex_fit *fit, size_t begin, size_t end,
                                vertex_sums *sums) {
    static const double smallest[8] = {FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, 0.0,
                                       FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, 0.0};
    path_part const origin = load_numbers(fit->origin), scale = load_numbers(fit->scale);
    path_part const half = load_numbers(fit->half), tiny = load_numbers(smallest);
    path_part doubt = {0.0}; /* becomes NaN with the first value that is not finite */
    path_part most = {0.0};
    double moved = 0.0;
    for (size_t i = begin; i < end; i++) {
        size_t const vertex = fit->vertices ? fit->vertices[i] : i;
        if (fit->vertices) {
            size_t const ahead = fit->vertices[i + PREFETCH < end ? i + PREFETCH : i];
            __builtin_prefetch(fit->x0 + 3 * ahead);
            __builtin_prefetch(fit->x1 + 3 * ahead);
        }
        path_part x[PARTS];
        part_sides sides[PARTS][2];
        for (int part = 0; part < PARTS; part++) {
            path_part const at = load_part(fit->x0 + 3 * vertex, fit->x1 + 3 * vertex, part);
            if (fit->records)
                memcpy((char *)&fit->records[i] + sizeof at * (size_t)part, &at, sizeof at);
            doubt += at - at;
            x[part] = clamp((at - origin) * scale);
            most = greater(most, absolute(x[part]));
            if (fit->points) {
                part_sides const point = __builtin_convertvector(x[part], part_sides);
                memcpy((char *)&fit->points[i] + sizeof point * (size_t)part, &point, sizeof point);
            }
            compute_sides(x[part], half, tiny, sides[part]);
        }
        write_sides(sides, &fit->boxes[i]);
        moved += add_motion(x);
    }
    *sums = (vertex_sums){.motion = moved};
    double sum = 0.0;
    for (size_t k = 0; k < sizeof doubt / sizeof(double); k++) {
        sum += doubt[k];
        if (most[k] > sums->largest) sums->largest = most[k];
    }
    return sum == 0.0;
}
