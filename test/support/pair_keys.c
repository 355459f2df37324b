/* support/pair_keys.c - see pair_keys.h. */
#include "support/pair_keys.h"

#include "base/hash.h"
#include "geom/distance.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

uint64_t make_key(feature_kind kind, feature_pair pair) {
    return (uint64_t)kind << 62 | (uint64_t)pair.first << 31 | pair.second;
}

feature_kind get_key_kind(uint64_t key) { return (feature_kind)(key >> 62); }

static feature_pair get_key_pair(uint64_t key) {
    return (feature_pair){(uint32_t)(key >> 31 & 0x7fffffff), (uint32_t)(key & 0x7fffffff)};
}

void find_pair_vertices(const soup_scene *of, uint64_t key, uint32_t vertices[4]) {
    feature_pair const pair = get_key_pair(key);
    bool const has_edges = get_key_kind(key) == FEATURE_EDGE_EDGE;
    assert_true(pair.first < (has_edges ? of->topo.edge_count : of->topo.vertex_count));
    assert_true(pair.second < (has_edges ? of->topo.edge_count : of->topo.triangle_count));
    feature_pair_vertices(&of->topo, get_key_kind(key), pair, vertices);
}

/* ---- searches ---- */

/* A pair_consumer; context: a key_list for each worker. */
static void collect_keys(void *context, const pair_tables *tables, const pair_batch *batch,
                         int worker) {
    key_list *const list = (key_list *)context + worker;
    if (batch->count == 0 || batch->count > PAIR_BATCH_SIZE) abort();
    for (size_t i = 0; i < batch->count; i++) {
        if (list->count == MAX_PAIRS) abort();
        list->keys[list->count++] = make_key(batch->kind, pair_batch_get(tables, batch, i));
    }
}

static int compare_keys(const void *a, const void *b) {
    uint64_t const x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

key_list search_keys(broad_phase *broad, const surface_set *set, int threads) {
    key_list lists[MAX_THREADS] = {{0}};
    for (int w = 0; w < threads; w++) {
        lists[w].keys = malloc(MAX_PAIRS * sizeof *lists[w].keys);
        assert_non_null(lists[w].keys);
    }
    search_counts counts;
    assert_int_equal(search_pairs(broad, set, threads, collect_keys, lists, &counts), TULLE_OK);
    key_list all = lists[0];
    for (int w = 1; w < threads; w++) {
        assert_true(all.count + lists[w].count <= MAX_PAIRS);
        memcpy(all.keys + all.count, lists[w].keys, lists[w].count * sizeof *all.keys);
        all.count += lists[w].count;
        free(lists[w].keys);
    }
    assert_int_equal(all.count, counts.candidate_count);
    qsort(all.keys, all.count, sizeof *all.keys, compare_keys);
    for (size_t i = 1; i < all.count; i++) assert_true(all.keys[i - 1] < all.keys[i]);
    return all;
}

key_list list_keys(memory *heap, broad_phase *broad, const surface_set *set, int threads) {
    pair_list pairs = {0};
    assert_int_equal(find_pairs(broad, set, threads, PAIRS_SORTED, &pairs, NULL), TULLE_OK);
    key_list all = {.keys = malloc(MAX_PAIRS * sizeof *all.keys)};
    assert_non_null(all.keys);
    assert_true(pairs.vertex_triangle.count + pairs.edge_edge.count <= MAX_PAIRS);
    for (size_t i = 0; i < pairs.vertex_triangle.count; i++)
        all.keys[all.count++] = make_key(FEATURE_VERTEX_TRIANGLE, pairs.vertex_triangle.data[i]);
    for (size_t i = 0; i < pairs.edge_edge.count; i++)
        all.keys[all.count++] = make_key(FEATURE_EDGE_EDGE, pairs.edge_edge.data[i]);
    ARRAY_FREE(heap, &pairs.vertex_triangle);
    ARRAY_FREE(heap, &pairs.edge_edge);
    qsort(all.keys, all.count, sizeof *all.keys, compare_keys);
    return all;
}

void assert_same_keys(const key_list *a, const key_list *b) {
    assert_int_equal(a->count, b->count);
    if (a->count) assert_memory_equal(a->keys, b->keys, a->count * sizeof *a->keys);
}

soup_scene *make_scene(memory *heap, uint64_t *seed, size_t most_count) {
    soup_scene *const soup = calloc(1, sizeof *soup);
    assert_non_null(soup);
    size_t const surface_count = 1 + random_next(seed) % 3;
    for (size_t s = 0; s < surface_count; s++) {
        soup_shape const shape = (soup_shape)(random_next(seed) % SOUP_SHAPE_COUNT);
        soup_scene_add(soup, shape, 1 + random_next(seed) % most_count, 0.05, seed);
    }
    soup_scene_finish(heap, soup);
    return soup;
}

void free_scene(memory *heap, soup_scene *soup) {
    topology_destroy(heap, &soup->topo);
    free(soup);
}

broad_phase *make_trees(memory *heap, const soup_scene *of, broad_phase_method method) {
    broad_phase *broad;
    assert_int_equal(broad_phase_create(heap, &of->set, of->x0, method, &broad), TULLE_OK);
    assert_int_equal(build_trees(broad, &of->set, of->x0, of->x1, 0.02, 2), TULLE_OK);
    return broad;
}

/* ---- what may be left out ---- */

static bool triangle_has(const soup_scene *of, size_t triangle, uint32_t vertex) {
    const uint32_t *const corners = of->topo.triangles + 3 * triangle;
    return corners[0] == vertex || corners[1] == vertex || corners[2] == vertex;
}

/* Whether the patch `label` has a triangle with these vertices. */
static bool patch_has(const soup_scene *of, const uint32_t *labels, uint32_t label,
                      const uint32_t *vertices, int count) {
    const adjacency *const around = &of->topo.vertex_triangles;
    for (uint32_t i = around->begin[vertices[0]]; i < around->begin[vertices[0] + 1]; i++) {
        uint32_t const triangle = around->items[i];
        if (labels[triangle] == label && triangle_has(of, triangle, vertices[count - 1]))
            return true;
    }
    return false;
}

bool pair_is_within_patch(const soup_scene *of, const uint32_t *labels, uint64_t key) {
    uint32_t v[4];
    find_pair_vertices(of, key, v);
    if (get_key_kind(key) == FEATURE_VERTEX_TRIANGLE) {
        uint32_t const label = labels[get_key_pair(key).second];
        return label != 0 && patch_has(of, labels, label, v, 1);
    }
    const adjacency *const around = &of->topo.vertex_triangles;
    for (uint32_t i = around->begin[v[0]]; i < around->begin[v[0] + 1]; i++) {
        uint32_t const triangle = around->items[i], label = labels[triangle];
        if (label != 0 && triangle_has(of, triangle, v[1]) &&
            patch_has(of, labels, label, v + 2, 2))
            return true;
    }
    return false;
}

/* Ends of the paths of a pair, each within a box of `reach` around that of now: both features
 * towards each other. */
static void bend_ends(feature_kind kind, double reach, vec3 ends[4]) {
    int const own = kind == FEATURE_EDGE_EDGE ? 2 : 1; /* points of the first feature */
    vec3 middles[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int k = 0; k < 4; k++)
        middles[k >= own] =
            vec3_add(middles[k >= own], vec3_scale(ends[k], 1.0 / (k < own ? own : 4 - own)));
    vec3 const way = vec3_sub(middles[1], middles[0]);
    vec3 const bend = {copysign(reach, way.x), copysign(reach, way.y), copysign(reach, way.z)};
    for (int k = 0; k < 4; k++) ends[k] = vec3_add_scaled(ends[k], bend, k < own ? 1.0 : -1.0);
}

double sample_pair_distance(const soup_scene *of, uint64_t key, double reach) {
    enum { TIMES = 33 };
    feature_kind const kind = get_key_kind(key);
    uint32_t v[4];
    vec3 ends[4];
    find_pair_vertices(of, key, v);
    for (int k = 0; k < 4; k++) ends[k] = vec3_load(of->x1, v[k]);
    bend_ends(kind, reach, ends);
    double least = INFINITY;
    for (int i = 0; i < TIMES; i++) {
        vec3 points[4];
        for (int k = 0; k < 4; k++)
            points[k] = vec3_lerp(vec3_load(of->x0, v[k]), ends[k], (double)i / (TIMES - 1));
        closest_points const closest = kind == FEATURE_VERTEX_TRIANGLE
                                           ? closest_vertex_triangle(points)
                                           : closest_edge_edge(points);
        least = fmin(least, vec3_norm(closest.difference));
    }
    return least;
}
