/* contact/pairs/near_pairs.c - see near_pairs.h.
 *
 * The list holds all pairs that start nearer than the largest separation distance, but for ignored
 * ones. Two features can approach each other by the sum of their ways. One of them is of cloth or
 * of a free body, since no pair is of two scripted obstacles. So no approach exceeds the longest
 * way of cloth and free bodies plus the longest way of all. If the limit plus this is less than the
 * largest separation distance, no pair outside the list comes under the limit.
 *
 * Otherwise let the margin be the largest separation distance less the limit. A vertex is fast if
 * its way is longer than half the margin. A pair outside the list that has no fast vertex comes
 * nearer by at most the margin, so it stays above the limit. Outside the list only pairs with a
 * fast vertex are taken.
 *
 * Only here safety rests on computed distances. Their error, some roundings of the coordinates, is
 * far below compute_rounding_slack. */
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

/* A feature is fast if one of its vertices is. */
typedef struct fast_features {
    const topology *topo;
    bool *vertices, *triangles, *edges;
} fast_features;

static void mark_triangles(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fast_features *const fast = context;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *const v = fast->topo->triangles + 3 * t;
        fast->triangles[t] = fast->vertices[v[0]] | fast->vertices[v[1]] | fast->vertices[v[2]];
    }
}

static void mark_edges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fast_features *const fast = context;
    for (size_t e = begin; e < end; e++) {
        const uint32_t *const v = fast->topo->edges + 2 * e;
        fast->edges[e] = fast->vertices[v[0]] | fast->vertices[v[1]];
    }
}

typedef struct fast_pick {
    const bool *first, *second; /* marks of the features of a pair */
    const feature_pair *pairs;
    feature_pair *picked; /* PICK_CHUNK for each chunk */
    uint32_t *counts;     /* of each chunk */
} fast_pick;

static void pick_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const fast_pick *const pick = context;
    feature_pair *const picked = pick->picked + chunk * PICK_CHUNK;
    uint32_t count = 0;
    for (size_t i = begin; i < end; i++) {
        picked[count] = pick->pairs[i];
        count += pick->first[pick->pairs[i].first] | pick->second[pick->pairs[i].second];
    }
    pick->counts[chunk] = count;
}

/* Picks all pairs with a fast vertex, and the other pairs of the list. *picked does not change if
 * the limit leaves no room, or too many vertices are fast. */
static tulle_status pick_fast(const contact_scene *scene, const pair_source *source,
                              const double *x1, double limit, pair_list *picked) {
    const near_pair_list *const list = source->near_pairs;
    double const reach = scene->largest_separation * (1.0 - 2.0 * LENGTH_ROUNDING) - limit -
                         compute_rounding_slack(scene, x1);
    const topology *const topo = scene->set->topo;
    fast_features fast = {.topo = topo,
                          .vertices = ARENA_NEW(scene->scratch, bool, scene->vertex_count),
                          .triangles = ARENA_NEW(scene->scratch, bool, topo->triangle_count),
                          .edges = ARENA_NEW(scene->scratch, bool, topo->edge_count)};
    if (!fast.vertices || !fast.triangles || !fast.edges) return TULLE_ERROR_OUT_OF_MEMORY;
    if (!(reach > 0.0)) return TULLE_OK;
    double const most = 0.5 * reach;
    size_t fast_count = 0;
    for (size_t i = 0; i < scene->vertex_count; i++) {
        double const way2 = vec3_norm2(vec3_sub(vec3_load(x1, i), vec3_load(scene->x0, i)));
        fast.vertices[i] = !is_slot(scene, i) && !(way2 <= most * most);
        fast_count += fast.vertices[i];
    }
    if ((double)fast_count > MOST_FAST * (double)scene->vertex_count) return TULLE_OK;

    /* By kind: all pairs, and those that are picked. */
    const feature_pair *const pairs[2] = {source->pairs->vertex_triangle.data,
                                          source->pairs->edge_edge.data};
    size_t const counts[2] = {source->pairs->vertex_triangle.count, source->pairs->edge_edge.count};
    parallel_for(topo->triangle_count, PICK_CHUNK, scene->threads, mark_triangles, &fast);
    parallel_for(topo->edge_count, PICK_CHUNK, scene->threads, mark_edges, &fast);
    fast_pick pick;
    feature_pair *found[2];
    size_t found_counts[2] = {0, 0};
    for (int kind = 0; kind < 2; kind++) {
        size_t const chunk_count = parallel_chunk_count(counts[kind], PICK_CHUNK);
        size_t const room = list->pairs.count + chunk_count * PICK_CHUNK;
        found[kind] = ARENA_NEW(scene->scratch, feature_pair, room);
        pick.counts = ARENA_NEW(scene->scratch, uint32_t, chunk_count);
        if (!found[kind] || !pick.counts) return TULLE_ERROR_OUT_OF_MEMORY;
        bool const is_of_edges = kind == FEATURE_EDGE_EDGE;
        pick.first = is_of_edges ? fast.edges : fast.vertices;
        pick.second = is_of_edges ? fast.edges : fast.triangles;
        pick.pairs = pairs[kind];
        pick.picked = found[kind] + list->pairs.count;
        parallel_for(counts[kind], PICK_CHUNK, scene->threads, pick_chunk, &pick);
        size_t count = 0;
        for (size_t i = 0; i < list->pairs.count; i++) {
            const near_pair *const near = &list->pairs.data[i];
            if (near->kind == (feature_kind)kind && !pick.first[near->pair.first] &&
                !pick.second[near->pair.second])
                found[kind][count++] = near->pair;
        }
        for (size_t chunk = 0; chunk < chunk_count; chunk++) {
            memmove(found[kind] + count, pick.picked + chunk * PICK_CHUNK,
                    pick.counts[chunk] * sizeof *found[kind]);
            count += pick.counts[chunk];
        }
        found_counts[kind] = count;
    }
    *picked = (pair_list){.vertex_triangle = {.data = found[0], .count = found_counts[0]},
                          .edge_edge = {.data = found[1], .count = found_counts[1]}};
    return TULLE_OK;
}

tulle_status pick_pairs(const contact_scene *scene, const pair_source *source, const double *x1,
                        double limit, pair_list *picked) {
    const near_pair_list *const list = source->near_pairs;
    *picked = *source->pairs;
    if (!list) return TULLE_OK;
    /* the longest way of cloth and free bodies, and that of scripted obstacles */
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
