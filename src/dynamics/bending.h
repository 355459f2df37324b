/* dynamics/bending.h - bending across edges: what one hinge does. */
#ifndef TULLE_DYNAMICS_BENDING_H
#define TULLE_DYNAMICS_BENDING_H

#include "dynamics/cloth_model.h"

#include <stdbool.h>

/* A hinge's vector: the sum of values (3 a vertex) at its corners with its weights. The weights sum
 * to zero; differences from the first corner keep rounding small far from the origin. */
static inline vec3 bend_sum_corners(const cloth_hinge *hinge, const double *values) {
    vec3 const origin = vec3_load(values, hinge->vertices[0]);
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 1; k < 4; k++)
        sum = vec3_add_scaled(sum, vec3_sub(vec3_load(values, hinge->vertices[k]), origin),
                              hinge->weights[k]);
    return sum;
}

/* 1 where the hinge's normal (bending.c) points to the front, which triangles go round to the left;
 * else -1. */
static inline double bend_find_sign(const topology *surface, const cloth_hinge *hinge) {
    return surface->triangles[hinge->sides[0]] == hinge->vertices[0] ? 1.0 : -1.0;
}

/* Lists a hinge and the hinges of its triangles, itself first, and the places of their couplings in
 * side_couplings. Returns how many there are. */
static inline size_t bend_list_sides(const cloth_model *model, size_t hinge,
                                     uint32_t hinges[HINGE_COUPLINGS],
                                     size_t places[HINGE_COUPLINGS]) {
    size_t count = 1, place = HINGE_COUPLINGS * hinge;
    hinges[0] = (uint32_t)hinge;
    places[0] = place++;
    for (int side = 0; side < 2; side++) {
        uint32_t const own = model->hinges[hinge].sides[side];
        for (uint32_t edge = own - own % 3; edge < own - own % 3 + 3; edge++) {
            if (edge == own) continue;
            hinges[count] = model->triangle_hinges[edge];
            places[count] = place++;
            if (hinges[count] != TULLE_NONE) count++;
        }
    }
    return count;
}

/* sum_j couplings_j d_j, from the deviations d of all hinges [N]. */
static inline vec3 bend_compute_moment(const cloth_model *model, size_t hinge,
                                       const vec3 *deviations) {
    vec3 moment = {0.0, 0.0, 0.0};
    if (!model->couplings) {
        uint32_t hinges[HINGE_COUPLINGS];
        size_t places[HINGE_COUPLINGS];
        size_t const count = bend_list_sides(model, hinge, hinges, places);
        for (size_t k = 0; k < count; k++)
            moment =
                vec3_add_scaled(moment, deviations[hinges[k]], model->side_couplings[places[k]]);
        return moment;
    }
    for (size_t k = model->coupling_begin[hinge]; k < model->coupling_begin[hinge + 1]; k++)
        moment =
            vec3_add_scaled(moment, deviations[model->coupling_hinges[k]], model->couplings[k]);
    return moment;
}

/* The frame of a hinge, with a the edge, m the difference of the corners' offsets over twice the
 * rest areas, and c the hinge's vector. Where the sides keep their areas, a x m is the sum of their
 * unit normals. */
typedef struct hinge_frame {
    vec3 edge, across; /* a [m], m [1/m] */
    double length;     /* |v| of the vector v along the normal */
    vec3 normal;       /* unit; zero where there is none */
    /* of sides that are nearly folded onto each other; else zero */
    vec3 sum;         /* unit vector of a x m */
    vec3 fold;        /* that of c, turned to the side of a x m */
    double fold_turn; /* [1/m] how c turns v */
} hinge_frame;
hinge_frame bend_compute_frame(const cloth_hinge *hinge, const double inv_double_areas[2],
                               const double *positions);
/* (dn/dx)^T y of the corners, from the part of y at right angles to n over `length`. */
void bend_turn_normal(const cloth_hinge *hinge, const double inv_double_areas[2],
                      const hinge_frame *frame, vec3 tangential, vec3 turning[4]);

/* A body of parallel_for that computes d = c - curvature * normal [m] of a range of hinges. */
typedef struct deviation_task {
    const cloth_model *model;
    const double *positions;
    vec3 *deviations; /* by hinge */
} deviation_task;
void bend_compute_deviations(void *context, size_t begin, size_t end, size_t chunk, int worker);

#endif
