/* detect/kernels/fit_vertices.c - records of moving vertices, and their boxes at both ends: a point
 * widened by half the margin, rounded outward to floats. */
#include "detect/kernels/box_vectors.h"
#include "detect/tree_kernels.h"
#include "math/simd_double.h"

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

/* x, y, z and 0 of a vertex at the start, then at the end. */
static inline double8 load_path(const double *start, const double *end) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
    __m512d const low = _mm512_castpd256_pd512(_mm256_maskz_loadu_pd(7, start));
    return (double8)_mm512_insertf64x4(low, _mm256_maskz_loadu_pd(7, end), 1);
#else
    return (double8){start[0], start[1], start[2], 0.0, end[0], end[1], end[2], 0.0};
#endif
}

static inline double8 clamp(double8 x) {
    double8 const most = double8_fill(MOST_COORDINATE);
    return double8_max(-most, double8_min(most, x));
}

bool TULLE_KERNEL(fit_vertices)(const vertex_fit *fit, size_t begin, size_t end) {
    double8 const origin = double8_load(fit->origin), scale = double8_load(fit->scale);
    double8 const half = double8_load(fit->half);
    double8 const least_rounding = {FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, 0.0,
                                    FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, FLOAT_UNDERFLOW, 0.0};
    double8 doubt = double8_fill(0.0); /* becomes NaN with the first value that is not finite */
    for (size_t i = begin; i < end; i++) {
        size_t const vertex = fit->vertices ? fit->vertices[i] : i;
        if (fit->vertices) {
            size_t const ahead = fit->vertices[i + PREFETCH < end ? i + PREFETCH : i];
            __builtin_prefetch(fit->x0 + 3 * ahead);
            __builtin_prefetch(fit->x1 + 3 * ahead);
        }
        double8 const path = load_path(fit->x0 + 3 * vertex, fit->x1 + 3 * vertex);
        memcpy(&fit->records[i], &path, sizeof path);
        doubt += path - path;
        double8 const x = clamp((path - origin) * scale);
        double8 const rounding = FRAME_ROUNDING * (double8_abs(x) + half) + least_rounding;
        double8 const least = x - half, most = x + half;
        double8 const low = clamp(least - (FLOAT_ROUNDING * double8_abs(least) + rounding));
        double8 const high = clamp(most + (FLOAT_ROUNDING * double8_abs(most) + rounding));
        box_vector const lows = __builtin_convertvector(low, box_vector);
        box_vector const highs = __builtin_convertvector(-high, box_vector);
        box_vector_store(fit->boxes[i].start, BOX_SHUFFLE(lows, highs, 0, 1, 2, 3, 8, 9, 10, 11));
        box_vector_store(fit->boxes[i].end, BOX_SHUFFLE(lows, highs, 4, 5, 6, 7, 12, 13, 14, 15));
    }
    double sum = 0.0;
    for (int k = 0; k < DOUBLE_LANES; k++) sum += doubt[k];
    return sum == 0.0;
}
