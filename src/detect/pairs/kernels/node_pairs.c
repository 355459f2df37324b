/* detect/pairs/kernels/node_pairs.c - opens pairs of nodes: takes pairs whose boxes meet, gives the
 * pairs of their children whose boxes meet.
 *
 * Of the first node, each child that meets the second node's box is compared with all children of
 * the second at once. A node with itself gives each child with itself and with those after it.
 * Pairs of leaves are then looked at once more, along more directions and at each end alone. */
#include "detect/trees/kernels/box_vectors.h"
#include "detect/trees/tree_kernels.h"
#include "math/simd.h"

static size_t open_pair(const tree_node *a, const tree_node *b, bool is_same, uint32_t label_mask,
                        node_pairs *to, size_t count) {
    box_lanes8 const lanes_a = box_lanes8_load(a->sides[0], NODE_LANES);
    box_lanes8 const lanes_b = box_lanes8_load(b->sides[0], NODE_LANES);
    uint32_t near_a = box_lanes8_meet(&lanes_a, b->box, 1);
    uint32_t const near_b = box_lanes8_meet(&lanes_b, a->box, 1);
    uint32_t const labelled = ~lanes8_equal(b->labels, 0);
    while (near_a) {
        uint32_t const child = first_lane(near_a);
        near_a &= near_a - 1;
        uint32_t mask = near_b & box_lanes8_meet(&lanes_b, a->sides[0] + child, NODE_LANES);
        mask &= ~(labelled & lanes8_equal(b->labels, a->labels[child]) & label_mask);
        mask &= is_same ? 0xffU << child : 0xffU;
        lanes8_compress(mask, b->first, to->second + count);
        for (size_t l = 0; l < NODE_LANES; l++) to->first[count + l] = a->first + child;
        count += count_lanes(mask);
    }
    return count;
}

void TULLE_KERNEL(open_node_pairs)(const node_search *search, const uint32_t *first,
                                   const uint32_t *second, size_t count, node_pairs *to) {
    bool const is_one_tree = search->trees[0] == search->trees[1];
    size_t found = to->count;
    for (size_t i = 0; i < count; i++)
        found = open_pair(&search->trees[0][first[i]], &search->trees[1][second[i]],
                          is_one_tree && first[i] == second[i], search->label_mask, to, found);
    to->count = found;
}

/* Whether a direction keeps two leaves apart at both ends. */
static inline uint32_t are_apart(const leaf_slabs *a, const leaf_slabs *b) {
    box_vector gaps[2][2];
    for (int end = 0; end < 2; end++) {
        gaps[0][end] = box_vector_load(a->low[end]) + box_vector_load(b->high[end]);
        gaps[1][end] = box_vector_load(a->high[end]) + box_vector_load(b->low[end]);
    }
    return box_vector_positive(box_vector_most(box_vector_least(gaps[0][0], gaps[0][1]),
                                               box_vector_least(gaps[1][0], gaps[1][1]))) != 0;
}

void TULLE_KERNEL(drop_apart_leaves)(const leaf_slabs *slabs, node_pairs *pairs) {
    size_t kept = 0;
    for (size_t i = 0; i < pairs->count; i++) {
        uint32_t const first = pairs->first[i], second = pairs->second[i];
        pairs->first[kept] = first;
        pairs->second[kept] = second;
        kept += !are_apart(&slabs[first], &slabs[second]);
    }
    pairs->count = kept;
}
