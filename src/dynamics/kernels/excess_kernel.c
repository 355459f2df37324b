/* dynamics/kernels/excess_kernel.c - sum_excess for eight springs at a time; the sum itself is in
 * the order of springs. */
#include "dynamics/excess_kernel.h"
#include "math/simd_double.h"

/* Springs whose numbers are gathered at once. */
enum { BATCH = 32 };

typedef struct spring_batch {
    double start[3][BATCH], guess[3][BATCH], mean[3][BATCH]; /* differences of x0 and velocities */
    double stiffness[BATCH], stiffening[BATCH], rest[BATCH];
    double excess[BATCH], curvature[BATCH];
} spring_batch;

/* Differences of values at the springs' ends. */
SIMD_INLINE void gather_differences(const cloth_spring *springs, size_t count, const double *values,
                                    double to[3][BATCH]) {
    for (size_t k = 0; k < count; k++) {
        const double *const a = values + 3 * (size_t)springs[k].vertices[0];
        const double *const b = values + 3 * (size_t)springs[k].vertices[1];
        for (int i = 0; i < 3; i++) to[i][k] = b[i] - a[i];
    }
}

static void gather(const cloth_spring *springs, size_t count, const excess_motion *motion,
                   spring_batch *batch) {
    gather_differences(springs, count, motion->positions, batch->start);
    gather_differences(springs, count, motion->mean, batch->mean);
    if (motion->guess) gather_differences(springs, count, motion->guess, batch->guess);
    for (size_t k = 0; k < count; k++) {
        batch->stiffness[k] = springs[k].stiffness;
        batch->stiffening[k] = springs[k].stiffening;
        batch->rest[k] = springs[k].rest_length;
    }
}

SIMD_INLINE vec3x8 load_lanes(double from[3][BATCH], size_t begin) {
    return (vec3x8){double8_load(from[0] + begin), double8_load(from[1] + begin),
                    double8_load(from[2] + begin)};
}

SIMD_INLINE double8 get_length(vec3x8 a) { return double8_sqrt(vec3x8_dot(a, a)); }

SIMD_INLINE double8 get_positive(double8 a) {
    double8 const zero = double8_fill(0.0);
    return double8_select(double8_greater(a, zero), a, zero);
}

/* spring_compute_law. */
typedef struct law_lanes {
    double8 tension, slope, energy;
} law_lanes;

SIMD_INLINE law_lanes get_law(double8 k, double8 c, double8 extension) {
    double8 const zero = double8_fill(0.0);
    double8 const most = double8_fill(STIFFENING_STRAINS_MAX * STIFFENING_STRAINS_MAX);
    bool8 const is_past = bool8_and(double8_greater(extension, zero),
                                    double8_greater(c * extension * extension, most));
    double8 e = extension;
    if (bool8_bits(is_past))
        e = double8_select(is_past, double8_fill(STIFFENING_STRAINS_MAX) / double8_sqrt(c), e);
    double8 const more = double8_select(double8_greater(e, zero), c * e * e, zero);
    double8 const beyond = extension - e;
    law_lanes law = {.tension = k * e * (1.0 + more),
                     .slope = k * (1.0 + 3.0 * more),
                     .energy = 0.5 * k * e * e * (1.0 + 0.5 * more)};
    law.energy += (law.tension + 0.5 * law.slope * beyond) * beyond;
    law.tension += law.slope * beyond;
    return law;
}

/* spring_limit_guess: lanes that may be too long are rare and shortened one by one. */
SIMD_INLINE vec3x8 limit_guess(const cloth_spring *springs, const spring_batch *batch, size_t begin,
                               size_t count, vec3x8 start, vec3x8 guess) {
    double8 const extension =
        (1.0 + GUESS_LENGTH_ROUNDING) * get_length(guess) - double8_load(batch->rest + begin);
    double8 const strains2 = double8_load(batch->stiffening + begin) * extension * extension;
    double8 const few = double8_fill((1.0 - GUESS_STRAIN_ROUNDING) * GUESS_STRAINS * GUESS_STRAINS);
    lane_mask which = bool8_bits(
        bool8_and(double8_greater(extension, double8_fill(0.0)), double8_greater(strains2, few)));
    for (; which; which &= which - 1) {
        size_t const k = (size_t)__builtin_ctz(which);
        if (begin + k >= count) continue;
        vec3 const given = {guess.x[k], guess.y[k], guess.z[k]};
        vec3 const edge = spring_limit_guess(springs + begin + k,
                                             (vec3){start.x[k], start.y[k], start.z[k]}, given);
        guess.x[k] = edge.x, guess.y[k] = edge.y, guess.z[k] = edge.z;
    }
    return guess;
}

/* Eight springs' excess; NaN or infinite where a spring has no length to start with. */
SIMD_INLINE void measure_lanes(const cloth_spring *springs, spring_batch *batch, size_t begin,
                               size_t count, bool has_guess, double h) {
    double8 const step = double8_fill(h), rest = double8_load(batch->rest + begin);
    double8 const k = double8_load(batch->stiffness + begin);
    double8 const c = double8_load(batch->stiffening + begin);
    vec3x8 const start = load_lanes(batch->start, begin);
    vec3x8 from = start;
    if (has_guess) {
        vec3x8 const guess = vec3x8_add_scaled(start, load_lanes(batch->guess, begin), step);
        from = limit_guess(springs, batch, begin, count, start, guess);
    }
    vec3x8 const to = vec3x8_add_scaled(start, load_lanes(batch->mean, begin), step);
    vec3x8 const d = vec3x8_sub(to, from);
    double8 const length = get_length(from), along = vec3x8_dot(from, d) / length;
    double8 const across2 = get_positive(vec3x8_dot(d, d) - along * along);
    law_lanes const law = get_law(k, c, length - rest);
    double8 const curvature =
        law.slope * along * along + get_positive(law.tension / length) * across2;
    double8 const reckoned = law.energy + law.tension * along + 0.5 * curvature;
    double8 const excess = get_law(k, c, get_length(to) - rest).energy - reckoned;
    bool8 const has_length = double8_greater(length, double8_fill(0.0));
    double8 const none = double8_fill(0.0);
    double8_store(batch->excess + begin, double8_select(has_length, excess, none));
    double8_store(batch->curvature + begin, double8_select(has_length, curvature, none));
}

way_energies TULLE_KERNEL(sum_excess)(const cloth_spring *springs, size_t count,
                                      const excess_motion *motion) {
    spring_batch batch = {0};
    way_energies sum = {0.0, 0.0};
    for (size_t begin = 0; begin < count; begin += BATCH) {
        size_t const batch_count = count - begin < BATCH ? count - begin : BATCH;
        gather(springs + begin, batch_count, motion, &batch);
        for (size_t k = 0; k < batch_count; k += DOUBLE_LANES)
            measure_lanes(springs + begin, &batch, k, batch_count, motion->guess != NULL,
                          motion->time_step);
        for (size_t k = 0; k < batch_count; k++) {
            sum.excess += batch.excess[k];
            sum.curvature += batch.curvature[k];
        }
    }
    return sum;
}
