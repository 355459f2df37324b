/* support/pair_keys.c - see pair_keys.h. */
#include "support/pair_keys.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t make_key(feature_kind kind, feature_pair pair) {
    return (uint64_t)kind << 62 | (uint64_t)pair.first << 31 | pair.second;
}

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
    assert_int_equal(find_pairs(broad, set, threads, &pairs, NULL), TULLE_OK);
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
