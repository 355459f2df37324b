/* contact/pairs/pair_rules.h - which distances hold for a pair, and which pairs are ignored. */
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

#endif
