/* detect/pairs/kernels/leaf_pairs.c - feature pairs of two leaves: takes the boxes of their
 * features, gives each vertex/triangle pair and each edge/edge pair whose boxes meet and which
 * shares no vertex.
 *
 * First the features of each leaf that meet the box of the other are marked: most do not. Then each
 * marked one of one leaf is compared with all of the other, one a lane. */
#include "detect/trees/kernels/box_vectors.h"
#include "detect/trees/tree_kernels.h"
#include "math/simd.h"

enum {
    SHIFT = 37,      /* of the places of each KEPT_BLOCKS leaves against those before */
    LEAVES_AHEAD = 3 /* pairs */
};

/* Bits 0, 2, 4, ... of twice sixteen, and 0, 3, 6, ... of three times eight. */
#define EVEN_BITS 0x55555555U
#define THIRD_BITS 0x00249249U

typedef float row_vector __attribute__((vector_size(64)));

/* A leaf of a pair: where its boxes lie, and which of its features meet the box of the other. */
typedef struct leaf_view {
    const float *faces;    /* group of triangles, then vertices */
    const float *edges;    /* one or two groups */
    const float *vertices; /* group of the other vertices */
    uint32_t edge_count, vertex_count;
    uint32_t triangle_begin, vertex_begin, edge_begin;
    uint32_t near_triangles, near_vertices, near_edges; /* bits */
} leaf_view;

/* groups: where the groups of its block begin */
BOX_INLINE leaf_view view_leaf(const tree_leaf *leaf, const float *groups) {
    return (leaf_view){.faces = groups,
                       .edges = groups + GROUP_FLOATS,
                       .vertices = groups + GROUP_FLOATS * (size_t)(1 + count_edge_groups(leaf)),
                       .edge_count = leaf->edge_end - leaf->edge_begin,
                       .vertex_count = leaf->vertex_end - leaf->vertex_begin,
                       .triangle_begin = leaf->triangle_begin,
                       .vertex_begin = leaf->vertex_begin,
                       .edge_begin = leaf->edge_begin};
}

/* Lanes of a group that meet a box. */
BOX_INLINE uint32_t find_near(const float *group, const float box[6]) {
    box_lanes16 const lanes = box_lanes16_load(group, GROUP_LANES);
    return box_lanes16_meet(&lanes, box, 1);
}

BOX_INLINE void mark_near(leaf_view *leaf, const float box[6]) {
    uint32_t const near = find_near(leaf->faces, box);
    leaf->near_triangles = near & 0xffU;
    leaf->near_vertices = near >> LEAF_TRIANGLES;
    leaf->near_edges = find_near(leaf->edges, box);
    if (leaf->edge_count > GROUP_LANES)
        leaf->near_edges |= find_near(leaf->edges + GROUP_FLOATS, box) << GROUP_LANES;
    if (leaf->vertex_count > FACE_VERTICES)
        leaf->near_vertices |= find_near(leaf->vertices, box) << FACE_VERTICES;
}

/* Marks all features of a leaf. */
BOX_INLINE void mark_all(leaf_view *leaf, const tree_leaf *of) {
    leaf->near_triangles = (1U << (of->triangle_end - of->triangle_begin)) - 1;
    leaf->near_vertices = (1U << leaf->vertex_count) - 1;
    leaf->near_edges = (1U << leaf->edge_count) - 1;
}

/* Low x, y, z, high x, y, z. */
BOX_INLINE void write_sides(box_vector box, float sides[8]) {
    box_vector_store(sides, BOX_SHUFFLE(box, -box, 0, 1, 2, 12, 13, 14, 3, 7));
}

/* Copies the groups of a leaf with all boxes widened; by: negative at the low sides. */
BOX_INLINE void widen_groups(const float *from, size_t group_count, const float by[6],
                             float *copy) {
    row_vector const zero = {0.0F};
    row_vector widening[6];
    for (int k = 0; k < 6; k++) widening[k] = zero + by[k];
    for (const float *const end = from + GROUP_FLOATS * group_count; from < end;
         from += GROUP_FLOATS, copy += GROUP_FLOATS)
        for (int k = 0; k < 6; k++) {
            row_vector row;
            memcpy(&row, from + GROUP_LANES * k, sizeof row);
            row += widening[k];
            memcpy(copy + GROUP_LANES * k, &row, sizeof row);
        }
}

/* The even bits, side by side. */
static uint32_t gather_even(uint32_t bits) {
#ifdef __BMI2__
    return _pext_u32(bits, EVEN_BITS);
#else
    bits &= EVEN_BITS;
    bits = (bits | bits >> 1) & 0x33333333U;
    bits = (bits | bits >> 2) & 0x0f0f0f0fU;
    bits = (bits | bits >> 4) & 0x00ff00ffU;
    return (bits | bits >> 8) & 0x0000ffffU;
#endif
}

/* Every third bit, eight in all, side by side. */
static uint32_t gather_third(uint32_t bits) {
#ifdef __BMI2__
    return _pext_u32(bits, THIRD_BITS);
#else
    uint32_t gathered = 0;
    for (uint32_t i = 0; i < 8; i++) gathered |= (bits >> 3 * i & 1U) << i;
    return gathered;
#endif
}

/* Which of sixteen edges share a vertex with an edge. */
static uint32_t find_sharing_edges(const uint32_t corners[2], const uint32_t *others) {
    uint32_t const low = lanes16_equal(others, corners[0]) | lanes16_equal(others, corners[1]);
    uint32_t const high =
        lanes16_equal(others + 16, corners[0]) | lanes16_equal(others + 16, corners[1]);
    uint32_t const bits = low | high << 16;
    return gather_even(bits | bits >> 1);
}

/* Which of eight triangles have the vertex as a corner. */
static uint32_t find_sharing_triangles(uint32_t vertex, const uint32_t *corners) {
    uint32_t const bits = lanes16_equal(corners, vertex) | lanes8_equal(corners + 16, vertex) << 16;
    return gather_third(bits | bits >> 1 | bits >> 2);
}

/* How pairs that share a vertex are left out. */
typedef enum sharing {
    SHARING_NONE, /* the leaves share none */
    SHARING_MASKED,
    SHARING_COMPARED
} sharing;

typedef struct view_pair {
    const leaf_tables *tables;
    sharing sharing;
    const uint16_t *masks; /* of SHARING_MASKED: next ones */
    uint32_t mask_groups;
} view_pair;

/* Compares marked edges of `a` with one group of `b`. */
BOX_INLINE void pair_edge_lanes(const view_pair *pair, const leaf_view *a, const leaf_view *b,
                                uint32_t group, pair_batch *batch) {
    box_lanes16 const lanes = box_lanes16_load(b->edges + GROUP_FLOATS * group, GROUP_LANES);
    uint32_t const base = b->edge_begin + GROUP_LANES * group;
    uint32_t const near_b = b->near_edges >> GROUP_LANES * group & 0xffffU;
    const uint32_t *const corners = pair->tables->fit.edge_corners;
    uint32_t *first = batch->first + batch->count, *second = batch->second + batch->count;
    for (uint32_t near_a = near_b ? a->near_edges : 0; near_a; near_a &= near_a - 1) {
        uint32_t const edge = first_lane(near_a), slot = a->edge_begin + edge;
        const float *const box =
            a->edges + edge + (GROUP_FLOATS - GROUP_LANES) * (edge / GROUP_LANES);
        uint32_t mask = near_b & box_lanes16_meet(&lanes, box, GROUP_LANES);
        if (pair->sharing == SHARING_MASKED) mask &= pair->masks[pair->mask_groups * edge + group];
        if (pair->sharing == SHARING_COMPARED) {
            mask &= ~find_sharing_edges(corners + 2 * (size_t)slot, corners + 2 * (size_t)base);
            if (a->edge_begin == b->edge_begin)
                mask &= (uint32_t)(~UINT64_C(1) << edge >> GROUP_LANES * group);
        }
        lanes16_compress(mask, base, second);
        lanes16_fill(slot, first);
        uint32_t const count = count_lanes(mask);
        first += count;
        second += count;
    }
    batch->count = (size_t)(first - batch->first);
}

BOX_INLINE void pair_edges(const view_pair *pair, const leaf_view *a, const leaf_view *b,
                           pair_batch *batch) {
    bool const swaps =
        pair->sharing != SHARING_MASKED && count_lanes(b->near_edges) < count_lanes(a->near_edges);
    const leaf_view *const few = swaps ? b : a, *const many = swaps ? a : b;
    pair_edge_lanes(pair, few, many, 0, batch);
    if (many->near_edges >> GROUP_LANES) pair_edge_lanes(pair, few, many, 1, batch);
}

/* Compares marked vertices of `a` with marked triangles of `b`. */
BOX_INLINE void pair_vertices(const view_pair *pair, const leaf_view *a, const leaf_view *b,
                              const uint16_t *masks, pair_batch *batch) {
    const leaf_fit *const fit = &pair->tables->fit;
    box_lanes8 const lanes = box_lanes8_load(b->faces, GROUP_LANES);
    uint32_t *first = batch->first + batch->count, *second = batch->second + batch->count;
    for (uint32_t near_a = b->near_triangles ? a->near_vertices : 0; near_a; near_a &= near_a - 1) {
        uint32_t const vertex = first_lane(near_a), slot = a->vertex_begin + vertex;
        const float *const box = vertex < FACE_VERTICES ? a->faces + LEAF_TRIANGLES + vertex
                                                        : a->vertices + vertex - FACE_VERTICES;
        uint32_t mask = b->near_triangles & box_lanes8_meet(&lanes, box, GROUP_LANES);
        if (pair->sharing == SHARING_MASKED) mask &= masks[vertex];
        if (pair->sharing == SHARING_COMPARED)
            mask &= ~find_sharing_triangles(fit->vertex_corners[slot],
                                            fit->triangle_corners + 3 * (size_t)b->triangle_begin);
        lanes8_compress(mask, b->triangle_begin, second);
        lanes8_fill(slot, first);
        uint32_t const count = count_lanes(mask);
        first += count;
        second += count;
    }
    batch->count = (size_t)(first - batch->first);
}

BOX_INLINE void pair_views(view_pair pair, const leaf_view *a, const leaf_view *b, bool is_same,
                           pair_batch *batches) {
    bool const is_masked = pair.sharing == SHARING_MASKED;
    const uint16_t *const of_a = is_masked ? pair.masks + pair.mask_groups * a->edge_count : NULL;
    const uint16_t *const of_b = is_masked ? of_a + a->vertex_count : NULL;
    pair_batch *const faces = &batches[FEATURE_VERTEX_TRIANGLE];
    pair_vertices(&pair, a, b, of_a, faces);
    if (!is_same) pair_vertices(&pair, b, a, of_b, faces);
    pair_edges(&pair, a, b, &batches[FEATURE_EDGE_EDGE]);
}

/* The place of a leaf in a cache. Leaves side by side get places side by side; leaves of equal
 * trees one after another get different ones. */
BOX_INLINE uint32_t choose_place(const leaf_cache *cache, uint32_t leaf) {
    return (leaf + leaf / KEPT_BLOCKS * SHIFT) & (cache->place_count - 1);
}

/* The block of a leaf, which is fitted unless the cache has it. taken: a place that must stay as it
 * is, or UINT32_MAX. */
BOX_INLINE const float *get_block(const leaf_fit *fit, leaf_cache *cache, uint32_t leaf,
                                  uint32_t taken) {
    if (fit->blocks) return fit->blocks + compute_block_begin(&fit->leaves[leaf], leaf);
    uint32_t place = choose_place(cache, leaf);
    if (cache->leaves[place] == leaf) return cache->blocks + place * cache->stride;
    if (place == taken)
        place = cache->place_count;
    else
        cache->leaves[place] = leaf;
    float *const block = cache->blocks + place * cache->stride;
    TULLE_KERNEL(fit_block)(fit, &fit->leaves[leaf], block);
    return block;
}

/* How pairs of two leaves of one tree that share a vertex are left out; masks: where. */
BOX_INLINE sharing choose_sharing(const leaf_tables *tables, const tree_leaf *leaf, uint32_t first,
                                  uint32_t second, const uint16_t **masks) {
    if (!tables->has_neighbours || leaf->neighbours[0] == LEAF_ANY) return SHARING_COMPARED;
    uint32_t const found = lanes8_equal(leaf->neighbours, second);
    if (first != second && !found) return SHARING_NONE;
    if (!tables->masks) return SHARING_COMPARED;
    uint32_t const index = first == second ? 0 : 1 + first_lane(found);
    *masks = tables->masks + leaf->mask_begin + (size_t)index * leaf->mask_stride;
    return SHARING_MASKED;
}

/* Two leaves and their blocks. */
typedef struct leaf_pair {
    const tree_leaf *leaves[2];
    const float *blocks[2];
} leaf_pair;

/* How much the drifts of both leaves widen the boxes of the first, as a box to add: low, -high;
 * each <= 0. */
BOX_INLINE box_vector compute_widening(const float *const blocks[2]) {
    box_vector const a = box_vector_load(blocks[0] + 8), b = box_vector_load(blocks[1] + 8);
    return box_vector_least(a + BOX_SHUFFLE(b, b, 4, 5, 6, 7, 0, 1, 2, 3), box_vector_fill(0.0F));
}

BOX_INLINE void compare_leaves(const leaf_pair *pair, view_pair how, bool is_same,
                               pair_batch *batches) {
    float copy[MOST_GROUPS * GROUP_FLOATS] __attribute__((aligned(64))), by[8], box[8];
    const float *groups = pair->blocks[0] + LEAF_HEADER;
    box_vector widening = box_vector_fill(0.0F);
    if (how.tables->fit.is_straight) {
        widening = compute_widening(pair->blocks);
        write_sides(widening, by);
        widen_groups(groups, count_groups(pair->leaves[0]), by, copy);
        groups = copy;
    }
    leaf_view a = view_leaf(pair->leaves[0], groups);
    leaf_view b = view_leaf(pair->leaves[1], pair->blocks[1] + LEAF_HEADER);
    if (is_same) {
        mark_all(&a, pair->leaves[0]);
        mark_all(&b, pair->leaves[0]);
    } else {
        write_sides(box_vector_load(pair->blocks[1]), box);
        mark_near(&a, box);
        write_sides(box_vector_load(pair->blocks[0]) + widening, box);
        mark_near(&b, box);
    }
    pair_views(how, &a, &b, is_same, batches);
}

/* Compares in a way of leaving out pairs that the compiler knows: three times the code, but no
 * question in the loops. */
BOX_INLINE void compare_by(const leaf_pair *pair, const view_pair *how, bool is_same,
                           pair_batch *batches) {
    view_pair known = {.tables = how->tables};
    if (how->sharing == SHARING_NONE && !is_same) {
        known.sharing = SHARING_NONE;
        compare_leaves(pair, known, false, batches);
    } else if (how->sharing == SHARING_MASKED) {
        known.sharing = SHARING_MASKED;
        known.masks = how->masks;
        known.mask_groups = how->mask_groups;
        compare_leaves(pair, known, is_same, batches);
    } else {
        known.sharing = SHARING_COMPARED;
        compare_leaves(pair, known, is_same, batches);
    }
}

BOX_INLINE void pair_two(const leaf_tables *tables, leaf_cache *cache, uint32_t first,
                         uint32_t second, pair_batch *batches) {
    const tree_leaf *const leaf = &tables->fit.leaves[first];
    leaf_pair pair = {{leaf, &tables->fit.leaves[second]}, {NULL, NULL}};
    view_pair how = {.tables = tables, .mask_groups = leaf->mask_groups};
    pair.blocks[0] = get_block(&tables->fit, cache, first, UINT32_MAX);
    if (tables->is_one_tree && first == second) {
        pair.blocks[1] = pair.blocks[0];
        how.sharing = choose_sharing(tables, leaf, first, second, &how.masks);
        compare_by(&pair, &how, true, batches);
        return;
    }
    pair.blocks[1] = get_block(&tables->fit, cache, second, choose_place(cache, first));
    if (tables->is_one_tree) how.sharing = choose_sharing(tables, leaf, first, second, &how.masks);
    compare_by(&pair, &how, false, batches);
}

/* Prefetches the block of the second leaf of the next pair, and the leaf of a pair after it. */
BOX_INLINE void call_block(const leaf_tables *tables, const node_pairs *pairs, size_t index) {
    if (!tables->fit.blocks || index >= pairs->count) return;
    size_t const later = index + LEAVES_AHEAD < pairs->count ? index + LEAVES_AHEAD : index;
    __builtin_prefetch(&tables->fit.leaves[pairs->second[later]]);
    uint32_t const leaf = pairs->second[index];
    const float *const block =
        tables->fit.blocks + compute_block_begin(&tables->fit.leaves[leaf], leaf);
    for (size_t line = 0; line < 13; line++) __builtin_prefetch(block + 16 * line);
}

size_t TULLE_KERNEL(pair_leaves)(const leaf_tables *tables, leaf_cache *cache,
                                 const node_pairs *pairs, size_t begin, pair_batch *batches) {
    size_t i = begin;
    for (; i < pairs->count; i++) {
        size_t const vertices = batches[FEATURE_VERTEX_TRIANGLE].count;
        size_t const edges = batches[FEATURE_EDGE_EDGE].count;
        if ((vertices > edges ? vertices : edges) > PAIR_BATCH_SIZE - LEAF_PAIR_ROOM) break;
        call_block(tables, pairs, i + 1);
        pair_two(tables, cache, pairs->first[i], pairs->second[i], batches);
    }
    return i;
}
