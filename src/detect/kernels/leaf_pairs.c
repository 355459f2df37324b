/* detect/kernels/leaf_pairs.c - feature pairs of two leaves: takes the boxes of their features,
 * gives each vertex/triangle pair and each edge/edge pair whose boxes meet and which shares no
 * vertex.
 *
 * First the features of each leaf that meet the box of the other are marked: most do not. Then each
 * marked one of one leaf is compared with all of the other, one a lane. */
#include "detect/tree_kernels.h"
#include "math/simd.h"

enum { SHIFT = 37 }; /* of the places of each KEPT_BLOCKS leaves against those before */

/* Bits 0, 2, 4, ... of twice sixteen, and 0, 3, 6, ... of three times eight. */
#define EVEN_BITS 0x55555555U
#define THIRD_BITS 0x00249249U

/* A leaf of a pair: where its boxes lie, and which of its features meet the box of the other. */
typedef struct leaf_view {
    const float *box;
    const float *faces; /* rows of `width`: triangles, then vertices */
    const float *edges; /* rows of edge_count */
    uint32_t triangle_count, width, edge_count;
    uint32_t triangle_begin, vertex_begin, edge_begin;
    uint32_t near_triangles, near_vertices, near_edges; /* bits */
} leaf_view;

static inline leaf_view view_leaf(const tree_leaf *leaf, const float *block) {
    uint32_t const triangle_count = leaf->triangle_end - leaf->triangle_begin;
    uint32_t const width = triangle_count + leaf->vertex_end - leaf->vertex_begin;
    return (leaf_view){.box = block,
                       .faces = block + LEAF_HEADER,
                       .edges = block + LEAF_HEADER + 6 * (size_t)width,
                       .triangle_count = triangle_count,
                       .width = width,
                       .edge_count = leaf->edge_end - leaf->edge_begin,
                       .triangle_begin = leaf->triangle_begin,
                       .vertex_begin = leaf->vertex_begin,
                       .edge_begin = leaf->edge_begin};
}

/* Bits of the `count` lanes of rows that meet a box. */
static inline uint32_t find_near(const float *rows, uint32_t count, const float box[6]) {
    box_lanes16 const lanes = box_lanes16_load(rows, count);
    uint32_t near = box_lanes16_meet(&lanes, box, 1);
    if (count > 16) {
        box_lanes16 const others = box_lanes16_load(rows + 16, count);
        near |= box_lanes16_meet(&others, box, 1) << 16;
    }
    return near & (uint32_t)((UINT64_C(1) << count) - 1);
}

static inline void mark_near(leaf_view *leaf, const float box[6]) {
    uint32_t const near = find_near(leaf->faces, leaf->width, box);
    leaf->near_triangles = near & ((1U << leaf->triangle_count) - 1);
    leaf->near_vertices = near >> leaf->triangle_count;
    leaf->near_edges = find_near(leaf->edges, leaf->edge_count, box);
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

/* Compares marked edges of `a` with sixteen of `b` from `chunk` on. */
static inline void pair_edge_lanes(const leaf_view *a, const leaf_view *b, uint32_t chunk,
                                   const uint32_t *corners, pair_batch *batch) {
    box_lanes16 const lanes = box_lanes16_load(b->edges + chunk, b->edge_count);
    uint32_t const base = b->edge_begin + chunk, near_b = b->near_edges >> chunk & 0xffffU;
    uint32_t *first = batch->first + batch->count, *second = batch->second + batch->count;
    for (uint32_t near_a = a->near_edges; near_a; near_a &= near_a - 1) {
        uint32_t const edge = first_lane(near_a), slot = a->edge_begin + edge;
        uint32_t mask = near_b & box_lanes16_meet(&lanes, a->edges + edge, a->edge_count);
        if (corners) {
            mask &= ~find_sharing_edges(corners + 2 * (size_t)slot, corners + 2 * (size_t)base);
            if (a == b) mask &= (uint32_t)(~UINT64_C(1) << edge >> chunk);
        }
        lanes16_compress(mask, base, second);
        lanes16_fill(slot, first);
        uint32_t const count = count_lanes(mask);
        first += count;
        second += count;
    }
    batch->count = (size_t)(first - batch->first);
}

/* corners: of edges, where the leaves may share vertices; else null. */
static inline void pair_edges(const leaf_view *a, const leaf_view *b, const uint32_t *corners,
                              pair_batch *batch) {
    bool const swaps = count_lanes(b->near_edges) < count_lanes(a->near_edges);
    const leaf_view *const few = swaps ? b : a, *const many = swaps ? a : b;
    pair_edge_lanes(few, many, 0, corners, batch);
    if (many->near_edges >> 16) pair_edge_lanes(few, many, 16, corners, batch);
}

/* Compares marked vertices of `a` with marked triangles of `b`. corners: of triangles, where the
 * leaves may share vertices; else null. */
static inline void pair_vertices(const leaf_tables *tables, const leaf_view *a, const leaf_view *b,
                                 const uint32_t *corners, pair_batch *batch) {
    box_lanes8 const lanes = box_lanes8_load(b->faces, b->width);
    const float *const rows = a->faces + a->triangle_count;
    uint32_t *first = batch->first + batch->count, *second = batch->second + batch->count;
    for (uint32_t near_a = b->near_triangles ? a->near_vertices : 0; near_a; near_a &= near_a - 1) {
        uint32_t const vertex = first_lane(near_a), slot = a->vertex_begin + vertex;
        uint32_t mask = b->near_triangles & box_lanes8_meet(&lanes, rows + vertex, a->width);
        if (corners)
            mask &= ~find_sharing_triangles(tables->fit.vertex_corners[slot],
                                            corners + 3 * (size_t)b->triangle_begin);
        lanes8_compress(mask, b->triangle_begin, second);
        lanes8_fill(slot, first);
        uint32_t const count = count_lanes(mask);
        first += count;
        second += count;
    }
    batch->count = (size_t)(first - batch->first);
}

static inline void pair_views(const leaf_tables *tables, const leaf_view *a, const leaf_view *b,
                              bool may_share, pair_batch *batches) {
    const uint32_t *const triangles = may_share ? tables->fit.triangle_corners : NULL;
    pair_batch *const faces = &batches[FEATURE_VERTEX_TRIANGLE];
    pair_vertices(tables, a, b, triangles, faces);
    if (a != b) pair_vertices(tables, b, a, triangles, faces);
    pair_edges(a, b, may_share ? tables->fit.edge_corners : NULL, &batches[FEATURE_EDGE_EDGE]);
}

static inline bool may_share_vertex(const tree_leaf *leaf, uint32_t other) {
    return lanes8_equal(leaf->neighbours, other) != 0 || leaf->neighbours[0] == LEAF_ANY;
}

/* Leaves side by side have places side by side, those of equal trees one after another have not the
 * same. */
static inline uint32_t find_place(uint32_t leaf) {
    return (leaf + leaf / KEPT_BLOCKS * SHIFT) % KEPT_BLOCKS;
}

/* The block of a leaf, fitted unless it is there. taken: a place that stays as it is, or
 * KEPT_BLOCKS. */
static inline const float *find_block(const leaf_fit *fit, leaf_cache *cache, uint32_t leaf,
                                      uint32_t taken) {
    if (fit->blocks) return fit->blocks + fit->leaves[leaf].block;
    uint32_t place = find_place(leaf);
    if (cache->leaves[place] == leaf) return cache->blocks + place * cache->stride;
    if (place == taken)
        place = KEPT_BLOCKS;
    else
        cache->leaves[place] = leaf;
    float *const block = cache->blocks + place * cache->stride;
    TULLE_KERNEL(fit_block)(fit, &fit->leaves[leaf], block);
    return block;
}

static inline void pair_two(const leaf_tables *tables, leaf_cache *cache, uint32_t first,
                            uint32_t second, pair_batch *batches) {
    const tree_leaf *const leaf = &tables->fit.leaves[first];
    leaf_view a = view_leaf(leaf, find_block(&tables->fit, cache, first, KEPT_BLOCKS));
    if (tables->is_one_tree && first == second) {
        mark_near(&a, a.box);
        pair_views(tables, &a, &a, true, batches);
        return;
    }
    leaf_view b = view_leaf(&tables->fit.leaves[second],
                            find_block(&tables->fit, cache, second, find_place(first)));
    mark_near(&a, b.box);
    mark_near(&b, a.box);
    if (tables->is_one_tree && may_share_vertex(leaf, second))
        pair_views(tables, &a, &b, true, batches);
    else
        pair_views(tables, &a, &b, false, batches);
}

size_t TULLE_KERNEL(pair_leaves)(const leaf_tables *tables, leaf_cache *cache,
                                 const node_pairs *pairs, size_t begin, pair_batch *batches) {
    size_t i = begin;
    for (; i < pairs->count; i++) {
        size_t const vertices = batches[FEATURE_VERTEX_TRIANGLE].count;
        size_t const edges = batches[FEATURE_EDGE_EDGE].count;
        if ((vertices > edges ? vertices : edges) > PAIR_BATCH_SIZE - LEAF_PAIR_ROOM) break;
        pair_two(tables, cache, pairs->first[i], pairs->second[i], batches);
    }
    return i;
}
