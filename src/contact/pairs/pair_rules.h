/* contact/pairs/pair_rules.h - which distances hold for a pair, which pairs are ignored, and a
 * cheap proof that a pair is apart. */
#ifndef TULLE_CONTACT_PAIRS_PAIR_RULES_H
#define TULLE_CONTACT_PAIRS_PAIR_RULES_H

#include "contact/contact_types.h"
#include "detect/impact/time_of_impact.h"

/* Distances of one pair [m]. Neighbours on a fine mesh rest nearer than the contact distance: they
 * use parts of their rest distance. */
typedef struct pair_distances {
    double contact, separation, minimum;
} pair_distances;

/* Computes the distances of a pair. feature_pair_vertices numbers its vertices: the first belongs
 * to the first feature, the last to the second. rest: the pair's distance [m] in the rest shape,
 * which matters only for pairs of one surface; null: it is computed. */
pair_distances compute_pair_distances(const contact_scene *scene, feature_kind kind,
                                      const uint32_t vertices[4], const double *rest);
const contact_law *get_contact_law(const contact_scene *scene, const uint32_t vertices[4]);
/* See ignored_pair_key. */
bool pair_is_ignored(const contact_scene *scene, feature_kind kind, feature_pair pair);

/* Bound [m] on the rounding of the gap between corners along a direction, over the direction's
 * length, for points of x0 and x1. */
double compute_rounding_slack(const contact_scene *scene, const double *x1);

static inline void load_points(const double *positions, const uint32_t vertices[4],
                               vec3 points[4]) {
    for (int k = 0; k < 4; k++) points[k] = vec3_load(positions, vertices[k]);
}

/* Whether the common normal of both features proves that they are farther apart than `distance`
 * [m], which includes the rounding slack. No two points of theirs are nearer than the gap along the
 * normal: the smallest extent of the first feature less the largest of the second. Where the
 * features lie flat on one another, that gap is all of their distance. */
static inline bool common_normal_separates(feature_kind kind, const vec3 points[4],
                                           double distance) {
    bool const is_vertex = kind == FEATURE_VERTEX_TRIANGLE;
    vec3 const first = vec3_sub(points[is_vertex ? 2 : 1], points[is_vertex ? 1 : 0]);
    vec3 const second = vec3_sub(points[3], points[is_vertex ? 1 : 2]);
    vec3 const normal = vec3_cross(first, second);
    vec3 const across = vec3_sub(points[0], points[3]);
    vec3 const direction = vec3_dot(normal, across) < 0.0 ? vec3_neg(normal) : normal;
    double const a = vec3_dot(direction, points[0]), b = vec3_dot(direction, points[1]);
    double const c = vec3_dot(direction, points[2]), d = vec3_dot(direction, points[3]);
    double const later = c > d ? c : d;
    double const gap = is_vertex ? a - (b > later ? b : later) : (a < b ? a : b) - later;
    return gap > 0.0 && gap * gap > distance * distance * vec3_norm2(direction);
}

#endif
