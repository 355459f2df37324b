/* contact/near_pairs.c - see near_pairs.h. Two features approach each other by at most the longest
 * ways of their surfaces. What starts further apart than the largest separation distance and will
 * not touch is in no list: that distance less the approach bounds what a list can answer. Here
 * alone safety rests on distances as they are computed; their error is some roundings of the
 * coordinates, far below find_rounding_slack. */
#include "contact/near_pairs.h"

#include "contact/pair_rules.h"

#include <math.h>

/* Over the relative rounding of distances and ways. */
#define LENGTH_ROUNDING 1e-9

tulle_status note_near_pairs(const contact_scene *scene, const pair_events *found,
                             near_pair_list *list) {
    list->pairs.count = list->nearest = 0;
    if (!ARRAY_RESERVE(scene->heap, &list->pairs, found->near_count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < found->near_count; i++) {
        const pair_event *const event = &found->near_pairs[i];
        list->pairs.data[list->pairs.count++] =
            (near_pair){event->kind, event->pair, event->distance};
        if (event->distance < list->pairs.data[list->nearest].distance) list->nearest = i;
    }
    return TULLE_OK;
}

void near_pair_list_destroy(near_pair_list *list, memory *heap) { ARRAY_FREE(heap, &list->pairs); }

/* No pair is of two scripted obstacles. */
static double find_longest_approach(const contact_scene *scene, const double *x1) {
    double moved2 = 0.0, scripted2 = 0.0;
    for (size_t i = 0; i < scene->vertex_count; i++) {
        if (is_slot(scene, i)) continue;
        double const way2 = vec3_norm2(vec3_sub(vec3_load(x1, i), vec3_load(scene->x0, i)));
        bool const is_moved =
            i < scene->cloth_vertex_count || find_body(scene, (uint32_t)i) != TULLE_NONE;
        double *const longest2 = is_moved ? &moved2 : &scripted2;
        if (way2 > *longest2) *longest2 = way2;
    }
    double const approach = sqrt(moved2) + sqrt(fmax(moved2, scripted2));
    return approach * (1.0 + LENGTH_ROUNDING) + find_rounding_slack(scene, x1);
}

static tulle_status pick_under(const contact_scene *scene, const near_pair_list *list,
                               double distance, pair_list *picked) {
    double const limit = distance * (1.0 + LENGTH_ROUNDING);
    size_t const count = list->pairs.count;
    *picked = (pair_list){0};
    picked->vertex_triangle.data = ARENA_NEW(scene->scratch, feature_pair, count);
    picked->edge_edge.data = ARENA_NEW(scene->scratch, feature_pair, count);
    if (!picked->vertex_triangle.data || !picked->edge_edge.data) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < count; i++) {
        const near_pair *const near = &list->pairs.data[i];
        if (near->distance > limit) continue;
        if (near->kind == FEATURE_VERTEX_TRIANGLE)
            picked->vertex_triangle.data[picked->vertex_triangle.count++] = near->pair;
        else
            picked->edge_edge.data[picked->edge_edge.count++] = near->pair;
    }
    return TULLE_OK;
}

tulle_status pick_pairs(const contact_scene *scene, const pair_source *source, const double *x1,
                        double limit, pair_list *picked) {
    *picked = *source->pairs;
    if (!source->near_pairs) return TULLE_OK;
    double const distance = limit + find_longest_approach(scene, x1);
    if (!(distance * (1.0 + LENGTH_ROUNDING) < scene->largest_separation)) return TULLE_OK;
    return pick_under(scene, source->near_pairs, distance, picked);
}

/* No pair that is further apart than the nearest of now will be then. */
tulle_status pick_pairs_for_nearest(const contact_scene *scene, const pair_source *source,
                                    const double *x1, double *limit, pair_list *picked) {
    const near_pair_list *const list = source->near_pairs;
    *picked = *source->pairs;
    if (!list || list->pairs.count == 0) return TULLE_OK;
    const near_pair *const nearest = &list->pairs.data[list->nearest];
    uint32_t vertices[4];
    vec3 points[4];
    feature_pair_vertices(scene->set->topo, nearest->kind, nearest->pair, vertices);
    load_points(x1, vertices, points);
    double const distance = sqrt(closest_of_pair(nearest->kind, points).distance2);
    *limit = fmin(*limit, nextafter(distance, (double)INFINITY));
    return pick_pairs(scene, source, x1, distance, picked);
}
