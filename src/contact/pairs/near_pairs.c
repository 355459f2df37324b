/* contact/pairs/near_pairs.c - see near_pairs.h. Two features approach each other by at most the
 * longest ways of their surfaces. What starts further apart than the largest separation distance
 * and will not touch is in no list: that distance less the approach bounds what a list can answer.
 * Where some vertices go further than half of what that leaves, pairs of these are taken from all
 * pairs. Here alone safety rests on distances as they are computed; their error is some roundings
 * of the coordinates, far below compute_rounding_slack. */
#include "contact/pairs/near_pairs.h"

#include "base/parallel.h"
#include "contact/pairs/pair_rules.h"

#include <math.h>
#include <string.h>

/* Over the relative rounding of distances and ways. */
static const double LENGTH_ROUNDING = 1e-9;
/* Where more than this part of all vertices is fast, all pairs are taken: a pair has four, so
 * hardly any would be left out. */
static const double MOST_FAST = 0.5;

enum { PICK_CHUNK = 4096 /* pairs; some 10 microseconds */ };

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

typedef struct fast_pick {
    const contact_scene *scene;
    const bool *is_fast; /* vertex_count */
    feature_kind kind;
    const feature_pair *pairs; /* of that kind */
    feature_pair *picked;      /* PICK_CHUNK for each chunk */
    uint32_t *counts;          /* of each chunk */
} fast_pick;

static bool has_fast_vertex(const fast_pick *pick, feature_kind kind, feature_pair pair) {
    uint32_t v[4];
    feature_pair_vertices(pick->scene->set->topo, kind, pair, v);
    return pick->is_fast[v[0]] | pick->is_fast[v[1]] | pick->is_fast[v[2]] | pick->is_fast[v[3]];
}

static void pick_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const fast_pick *const pick = context;
    feature_pair *const picked = pick->picked + chunk * PICK_CHUNK;
    uint32_t count = 0;
    for (size_t i = begin; i < end; i++) {
        picked[count] = pick->pairs[i];
        count += has_fast_vertex(pick, pick->kind, pick->pairs[i]);
    }
    pick->counts[chunk] = count;
}

/* Pairs of one kind with a fast vertex, and the near ones without. Null when memory is short. */
static feature_pair *pick_kind(fast_pick *pick, const near_pair_list *list, size_t pair_count,
                               size_t *count) {
    const contact_scene *const scene = pick->scene;
    size_t const chunk_count = parallel_chunk_count(pair_count, PICK_CHUNK);
    feature_pair *const all =
        ARENA_NEW(scene->scratch, feature_pair, list->pairs.count + chunk_count * PICK_CHUNK);
    pick->counts = ARENA_NEW(scene->scratch, uint32_t, chunk_count);
    if (!all || !pick->counts) return NULL;
    pick->picked = all + list->pairs.count;
    parallel_for(pair_count, PICK_CHUNK, scene->threads, pick_chunk, pick);
    *count = 0;
    for (size_t i = 0; i < list->pairs.count; i++) {
        const near_pair *const near = &list->pairs.data[i];
        if (near->kind == pick->kind && !has_fast_vertex(pick, near->kind, near->pair))
            all[(*count)++] = near->pair;
    }
    for (size_t chunk = 0; chunk < chunk_count; chunk++) {
        memmove(all + *count, pick->picked + chunk * PICK_CHUNK, pick->counts[chunk] * sizeof *all);
        *count += pick->counts[chunk];
    }
    return all;
}

/* Those that may come nearer than `limit` [m] where some vertices are fast; *picked stays what it
 * is where that is no help. */
static tulle_status pick_fast(const contact_scene *scene, const pair_source *source,
                              const double *x1, double limit, pair_list *picked) {
    double const reach = scene->largest_separation * (1.0 - 2.0 * LENGTH_ROUNDING) - limit -
                         compute_rounding_slack(scene, x1);
    bool *const is_fast = ARENA_NEW(scene->scratch, bool, scene->vertex_count);
    fast_pick pick = {.scene = scene, .is_fast = is_fast};
    if (!is_fast) return TULLE_ERROR_OUT_OF_MEMORY;
    if (!(reach > 0.0)) return TULLE_OK;
    double const most = 0.5 * reach;
    size_t fast_count = 0;
    for (size_t i = 0; i < scene->vertex_count; i++) {
        double const way2 = vec3_norm2(vec3_sub(vec3_load(x1, i), vec3_load(scene->x0, i)));
        is_fast[i] = !is_slot(scene, i) && !(way2 <= most * most);
        fast_count += is_fast[i];
    }
    if ((double)fast_count > MOST_FAST * (double)scene->vertex_count) return TULLE_OK;
    pair_list found = {0};
    pick.kind = FEATURE_VERTEX_TRIANGLE;
    pick.pairs = source->pairs->vertex_triangle.data;
    found.vertex_triangle.data =
        pick_kind(&pick, source->near_pairs, source->pairs->vertex_triangle.count,
                  &found.vertex_triangle.count);
    pick.kind = FEATURE_EDGE_EDGE;
    pick.pairs = source->pairs->edge_edge.data;
    found.edge_edge.data = pick_kind(&pick, source->near_pairs, source->pairs->edge_edge.count,
                                     &found.edge_edge.count);
    if (!found.vertex_triangle.data || !found.edge_edge.data) return TULLE_ERROR_OUT_OF_MEMORY;
    *picked = found;
    return TULLE_OK;
}

tulle_status pick_pairs(const contact_scene *scene, const pair_source *source, const double *x1,
                        double limit, pair_list *picked) {
    const near_pair_list *const list = source->near_pairs;
    *picked = *source->pairs;
    if (!list) return TULLE_OK;
    /* no pair is of two scripted obstacles: the longest ways of what moves and of anything else */
    double moved2 = 0.0, scripted2 = 0.0;
    for (size_t i = 0; i < scene->vertex_count; i++) {
        if (is_slot(scene, i)) continue;
        double const way2 = vec3_norm2(vec3_sub(vec3_load(x1, i), vec3_load(scene->x0, i)));
        bool const is_moved =
            i < scene->cloth_vertex_count || find_body(scene, (uint32_t)i) != TULLE_NONE;
        double *const longest2 = is_moved ? &moved2 : &scripted2;
        if (way2 > *longest2) *longest2 = way2;
    }
    double const ways = sqrt(moved2) + sqrt(fmax(moved2, scripted2));
    double const approach = ways * (1.0 + LENGTH_ROUNDING) + compute_rounding_slack(scene, x1);
    double const distance = (limit + approach) * (1.0 + LENGTH_ROUNDING);
    if (!(distance < scene->largest_separation)) return pick_fast(scene, source, x1, limit, picked);
    *picked = (pair_list){0};
    picked->vertex_triangle.data = ARENA_NEW(scene->scratch, feature_pair, list->pairs.count);
    picked->edge_edge.data = ARENA_NEW(scene->scratch, feature_pair, list->pairs.count);
    if (!picked->vertex_triangle.data || !picked->edge_edge.data) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < list->pairs.count; i++) {
        const near_pair *const near = &list->pairs.data[i];
        if (near->distance > distance) continue;
        if (near->kind == FEATURE_VERTEX_TRIANGLE)
            picked->vertex_triangle.data[picked->vertex_triangle.count++] = near->pair;
        else
            picked->edge_edge.data[picked->edge_edge.count++] = near->pair;
    }
    return TULLE_OK;
}

/* No pair that is further apart than the nearest of the start will be at x1. */
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
