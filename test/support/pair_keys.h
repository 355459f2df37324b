/* support/pair_keys.h - the pairs that searches of the broad phase give, as sorted numbers, for
 * random scenes. */
#ifndef TULLE_TEST_PAIR_KEYS_H
#define TULLE_TEST_PAIR_KEYS_H

#include "detect/trees/broad_phase.h"
#include "support/soup_scene.h"

enum { MAX_THREADS = 8, MAX_PAIRS = 600000 };

/* Pairs: kind << 62 | first << 31 | second. */
typedef struct key_list {
    uint64_t *keys;
    size_t count;
} key_list;

uint64_t make_key(feature_kind kind, feature_pair pair);
feature_kind get_key_kind(uint64_t key);
void find_pair_vertices(const soup_scene *of, uint64_t key, uint32_t vertices[4]);

/* Whether both features belong to triangles of one patch: the triangle of a pair itself, and any
 * around its vertex; any triangle at each edge. */
bool pair_is_within_patch(const soup_scene *of, const uint32_t *labels, uint64_t key);
/* [m] The least distance of a pair at some times on its paths, which end off by `reach` along each
 * axis, both features towards each other. */
double sample_pair_distance(const soup_scene *of, uint64_t key, double reach);

/* All pairs of a streaming search, sorted; each comes once. */
key_list search_keys(broad_phase *broad, const surface_set *set, int threads);
/* The same of find_pairs. */
key_list list_keys(memory *heap, broad_phase *broad, const surface_set *set, int threads);
void assert_same_keys(const key_list *a, const key_list *b);

/* Surfaces of random shapes, all meeting all, themselves too. */
soup_scene *make_scene(memory *heap, uint64_t *seed, size_t most_count);
void free_scene(memory *heap, soup_scene *soup);
/* Built over the paths of the scene, with a margin of 0.02. */
broad_phase *make_trees(memory *heap, const soup_scene *of, broad_phase_method method);

#endif
