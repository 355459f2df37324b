/* render/sampling.h - points that fill the unit square evenly, and what they are bent into: a pixel
 * filter, a disc, a hemisphere. Everything is a function of its arguments, on every machine.
 *
 * Each pair of dimensions of a pixel gets the first two dimensions of Sobol's sequence, its order
 * and its digits scrambled by hashes of the pixel and of the pair. Any aligned run of 2^m samples
 * then has one point in each of the 2^m boxes of equal shape and area, whatever their aspect.
 *
 * Based on: Art Owen, Randomly permuted (t,m,s)-nets and (t,s)-sequences, 1995; Samuli Laine and
 *           Tero Karras, Stratified sampling for stochastic transparency, 2011 (a scramble of all
 *           digits by multiplications); Brent Burley, Practical hash-based Owen scrambling, 2020
 *           (shuffled pairs of dimensions).
 * Departures: constants of our own; the second dimension's digits come from the subset sums of the
 *           index, Lucas' rule for Pascal's triangle modulo 2, in five steps without a table. */
#ifndef TULLE_RENDER_SAMPLING_H
#define TULLE_RENDER_SAMPLING_H

#include "math/vec3.h"

#include <stdint.h>

static inline uint32_t sampling_reverse_bits(uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/* A well-mixed value of two integers. */
static inline uint32_t sampling_hash(uint32_t a, uint32_t b) {
    uint32_t x = a * 0x9e3779b1u + b;
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

/* A permutation in which each bit depends on itself and on lower bits only: with the digits in
 * reverse, one of Owen's scrambles. Odd factors, even factors under xor, and sums carry upwards
 * only. */
static inline uint32_t sampling_permute_upward(uint32_t x, uint32_t seed) {
    x ^= x * 0x6c50b47cu;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x *= 0x8d22f6e5u;
    x ^= x * 0x2c1b3c6eu;
    return x;
}

/* Sample `index` of pair `pair` of the pixel whose hash is pixel_seed: two numbers in [0, 1). */
static inline void sampling_get_pair(uint32_t index, uint32_t pixel_seed, uint32_t pair,
                                     double point[2]) {
    uint32_t const seed = sampling_hash(pixel_seed, pair);
    uint32_t const shuffled =
        sampling_reverse_bits(sampling_permute_upward(sampling_reverse_bits(index), seed));
    /* The digits of both dimensions, last one first. */
    uint32_t const first = shuffled;
    uint32_t second = shuffled;
    second ^= (second >> 1) & 0x55555555u;
    second ^= (second >> 2) & 0x33333333u;
    second ^= (second >> 4) & 0x0f0f0f0fu;
    second ^= (second >> 8) & 0x00ff00ffu;
    second ^= (second >> 16) & 0x0000ffffu;
    point[0] =
        sampling_reverse_bits(sampling_permute_upward(first, sampling_hash(seed, 0x68bc21ebu))) *
        0x1p-32;
    point[1] =
        sampling_reverse_bits(sampling_permute_upward(second, sampling_hash(seed, 0x02e5be93u))) *
        0x1p-32;
}

/* A tent over -1 .. 1 from a number in [0, 1). */
static inline double sampling_get_tent(double u) {
    return u < 0.5 ? sqrt(2.0 * u) - 1.0 : 1.0 - sqrt(2.0 - 2.0 * u);
}

/* A point of the unit disc, uniform by area; neighbours stay neighbours.
 * Based on: Peter Shirley and Kenneth Chiu, A low distortion map between disk and square, 1997. */
static inline void sampling_get_disc(const double point[2], double disc[2]) {
    double const quarter_pi = 0.78539816339744831;
    double const a = 2.0 * point[0] - 1.0, b = 2.0 * point[1] - 1.0;
    if (a == 0.0 && b == 0.0) {
        disc[0] = disc[1] = 0.0;
    } else if (fabs(a) > fabs(b)) {
        double const angle = quarter_pi * (b / a);
        disc[0] = a * cos(angle);
        disc[1] = a * sin(angle);
    } else {
        double const angle = quarter_pi * (a / b);
        disc[0] = b * sin(angle);
        disc[1] = b * cos(angle);
    }
}

/* Two unit vectors at right angles to a unit vector and to each other. */
static inline void sampling_make_frame(vec3 normal, vec3 *tangent, vec3 *bitangent) {
    vec3 const axis = fabs(normal.z) < 0.9 ? vec3_make(0.0, 0.0, 1.0) : vec3_make(1.0, 0.0, 0.0);
    *tangent = vec3_normalize(vec3_cross(axis, normal));
    *bitangent = vec3_cross(normal, *tangent);
}

/* A direction about a unit normal, as likely as its cosine is large. */
static inline vec3 sampling_get_hemisphere(const double point[2], vec3 normal) {
    double disc[2];
    sampling_get_disc(point, disc);
    double const up2 = 1.0 - disc[0] * disc[0] - disc[1] * disc[1];
    vec3 tangent, bitangent;
    sampling_make_frame(normal, &tangent, &bitangent);
    vec3 const flat = vec3_add_scaled(vec3_scale(tangent, disc[0]), bitangent, disc[1]);
    return vec3_add_scaled(flat, normal, up2 > 0.0 ? sqrt(up2) : 0.0);
}

#endif
