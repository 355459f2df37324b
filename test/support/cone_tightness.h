/* support/cone_tightness.h - how much wider than need be the cones of both rules are. */
#ifndef TULLE_TEST_CONE_TIGHTNESS_H
#define TULLE_TEST_CONE_TIGHTNESS_H

#include "detect/patches/normal_cone.h"
#include "support/wide_normals.h"

#include <stdio.h>

/* Half-angle of the smallest cone of sampled normals: from the axis of the Bernstein cone, moved
 * while that helps. */
static inline double search_best_angle(const vec3 start[3], const vec3 end[3]) {
    vec3 axis = normal_cone_of_triangle(CONE_BERNSTEIN, start, end).axis;
    double best = sample_angle(axis, start, end, 32);
    vec3 const side = vec3_normalize(
        vec3_cross(axis, fabs(axis.x) < 0.5 ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0)));
    const vec3 sides[2] = {side, vec3_cross(axis, side)};
    for (double step = 0.5 * best; step > 0.005 * best; step *= 0.5)
        for (int k = 0; k < 8; k++) {
            vec3 const tried =
                vec3_normalize(vec3_add_scaled(axis, sides[k % 2], k / 2 % 2 ? step : -step));
            double const angle = sample_angle(tried, start, end, 32);
            if (angle < best) axis = tried, best = angle;
        }
    return best;
}

typedef struct tightness {
    double paper, bernstein, best; /* [degrees] mean half-angles */
    size_t valid, all;             /* triangles with both cones, and all */
} tightness;

static inline void add_triangle(tightness *to, const vec3 start[3], const vec3 end[3]) {
    normal_cone const paper = normal_cone_of_triangle(CONE_PAPER, start, end);
    normal_cone const bernstein = normal_cone_of_triangle(CONE_BERNSTEIN, start, end);
    to->all++;
    if (!normal_cone_is_valid(paper) || !normal_cone_is_valid(bernstein)) return;
    to->valid++;
    to->paper += paper.half_angle / DEGREE;
    to->bernstein += bernstein.half_angle / DEGREE;
    to->best += search_best_angle(start, end) / DEGREE;
}

static inline void print_tightness_header(void) {
    printf("%-34s %8s %10s %8s %8s\n", "mean half-angle, degrees", "paper", "Bernstein", "best",
           "valid");
}

static inline void finish_row(tightness *row, const char *name) {
    double const count = (double)row->valid;
    row->paper /= count, row->bernstein /= count, row->best /= count;
    printf("%-34s %8.3g %10.3g %8.3g %7.1f%%\n", name, row->paper, row->bernstein, row->best,
           100.0 * count / (double)row->all);
}

#endif
