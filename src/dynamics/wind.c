/* dynamics/wind.c - wind drag and seeded gusts.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 5 (drag -k_f |w| (n . w) n per area, w relative to the air). The gusts are value
 * noise after Perlin, An image synthesizer, 1985: random vectors on a lattice in space and time,
 * blended smoothly. Departure: the blend is divided by the root of the sum of squared weights, so
 * the standard deviation is the same everywhere and not smaller between lattice points. */
#include "dynamics/wind.h"

#include "base/hash.h"

#include <math.h>

/* Lattice spacing over correlation length: makes the mean correlation 1/e at that distance. */
static const double SPACING_PER_LENGTH = 1.215;

/* A value of mean 0 and variance 1 within [-3, 3]: the sum of three uniform ones in [-1, 1]. */
static double get_lattice_value(uint64_t key) {
    uint64_t const bits = hash_mix(key);
    double sum = 0.0;
    for (int part = 0; part < 3; part++)
        sum += (double)((bits >> (21 * part)) & 0x1fffff) * (2.0 / 0x1fffff) - 1.0;
    return sum;
}

static void fill_cell(uint64_t seed, const int64_t corner[4], gust_cell *cell) {
    cell->is_filled = true;
    for (int axis = 0; axis < 4; axis++) cell->corner[axis] = corner[axis];
    for (int point = 0; point < 16; point++) {
        uint64_t key = hash_mix(seed + UINT64_C(0x9e3779b97f4a7c15));
        for (int axis = 0; axis < 4; axis++)
            key = hash_mix(key ^ ((uint64_t)(corner[axis] + ((point >> axis) & 1)) +
                                  UINT64_C(0x9e3779b97f4a7c15) * (uint64_t)(axis + 1)));
        for (int i = 0; i < 3; i++)
            cell->values[point][i] = get_lattice_value(key + (uint64_t)i + 1);
    }
}

/* Splits a coordinate into lattice point and smoothed fraction 3 s^2 - 2 s^3. Places beyond 2^53
 * spacings have no fraction left; they are held inside the range of the integer. */
static double split_coordinate(double value, int64_t *point) {
    double const above = value > -9e15 ? value : -9e15, limited = above < 9e15 ? above : 9e15;
    double const whole = (double)(int64_t)limited, base = whole > limited ? whole - 1.0 : whole;
    double const s = limited - base;
    *point = (int64_t)base;
    return s * s * (3.0 - 2.0 * s);
}

vec3 wind_get_velocity(const tulle_wind *wind, vec3 place, double time, gust_cell *cell) {
    vec3 const mean = {wind->velocity[0], wind->velocity[1], wind->velocity[2]};
    if (!(wind->gust_strength > 0.0)) return mean;
    double const spacing = SPACING_PER_LENGTH * wind->gust_length;
    double const coordinates[4] = {place.x / spacing, place.y / spacing, place.z / spacing,
                                   time / (SPACING_PER_LENGTH * wind->gust_time)};
    int64_t corner[4];
    double fractions[4];
    bool is_same = cell->is_filled;
    for (int axis = 0; axis < 4; axis++) {
        fractions[axis] = split_coordinate(coordinates[axis], &corner[axis]);
        is_same = is_same && corner[axis] == cell->corner[axis];
    }
    if (!is_same) fill_cell(wind->seed, corner, cell);
    vec3 sum = {0.0, 0.0, 0.0};
    double squares = 0.0;
    double parts[4][2];
    for (int axis = 0; axis < 4; axis++) {
        parts[axis][0] = 1.0 - fractions[axis];
        parts[axis][1] = fractions[axis];
    }
    double const sides[4] = {parts[0][0] * parts[1][0], parts[0][1] * parts[1][0],
                             parts[0][0] * parts[1][1], parts[0][1] * parts[1][1]};
    for (int point = 0; point < 16; point++) {
        double const weight = sides[point & 3] * parts[2][point >> 2 & 1] * parts[3][point >> 3];
        sum = vec3_add_scaled(sum, vec3_load(cell->values[point], 0), weight);
        squares += weight * weight;
    }
    return vec3_add_scaled(mean, sum, wind->gust_strength / sqrt(squares));
}
