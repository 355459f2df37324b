/* detect/leaf_pairs.c - feature pairs of two leaves: takes the boxes of their slots, writes each
 * vertex/triangle pair and each edge/edge pair whose boxes meet and which shares no vertex.
 *
 * Every box of one leaf that meets the box of the other is compared with all of the other's, lane
 * by lane over the arrays, so that the compiler turns it into vector compares. */
#include "detect/broad_phase_parts.h"

enum { LEAF_SLOTS = 3 * LEAF_TRIANGLES }; /* most edges, or vertices, that a leaf owns */

/* A run of slots of one list. */
typedef struct slot_run {
    const slot_list *list;
    size_t begin, end;
} slot_run;

static slot_run triangles_of(const broad_phase *broad, const tree_leaf *leaf) {
    return (slot_run){&broad->triangles, leaf->triangle_begin, leaf->triangle_end};
}
static slot_run vertices_of(const broad_phase *broad, const tree_leaf *leaf) {
    return (slot_run){&broad->vertices, leaf->vertex_begin, leaf->vertex_end};
}
static slot_run edges_of(const broad_phase *broad, const tree_leaf *leaf) {
    return (slot_run){&broad->edges, leaf->edge_begin, leaf->edge_end};
}

/* meets[j] is not 0 where the box of slot `slot` meets that of slot begin + j of `others`. */
static void compare_boxes(const slot_list *list, size_t slot, const slot_list *others, size_t begin,
                          size_t count, int32_t *meets) {
    float const low_x = list->sides[0][slot], high_x = list->sides[3][slot];
    float const low_y = list->sides[1][slot], high_y = list->sides[4][slot];
    float const low_z = list->sides[2][slot], high_z = list->sides[5][slot];
    const float *const x0 = others->sides[0] + begin, *const x1 = others->sides[3] + begin;
    const float *const y0 = others->sides[1] + begin, *const y1 = others->sides[4] + begin;
    const float *const z0 = others->sides[2] + begin, *const z1 = others->sides[5] + begin;
    for (size_t j = 0; j < count; j++)
        meets[j] = (x0[j] <= high_x) & (low_x <= x1[j]) & (y0[j] <= high_y) & (low_y <= y1[j]) &
                   (z0[j] <= high_z) & (low_z <= z1[j]);
}

static void pair_edges(const slot_run *a, const slot_run *b, bool is_same, pair_writer *writer) {
    int32_t meets[LEAF_SLOTS];
    for (size_t i = a->begin; i < a->end; i++) {
        size_t const begin = is_same ? i + 1 : b->begin, count = b->end - begin;
        compare_boxes(a->list, i, b->list, begin, count, meets);
        const uint32_t *const ends = a->list->corners + 2 * i;
        uint32_t const edge = a->list->features[i];
        for (size_t j = 0; j < count; j++) {
            const uint32_t *const others = b->list->corners + 2 * (begin + j);
            bool const shares = (ends[0] == others[0]) | (ends[0] == others[1]) |
                                (ends[1] == others[0]) | (ends[1] == others[1]);
            if (!meets[j] | shares) continue;
            uint32_t const other = b->list->features[begin + j];
            pair_writer_add(writer, edge < other ? edge : other, edge < other ? other : edge);
        }
    }
}

static void pair_vertices(const slot_run *vertices, const slot_run *triangles,
                          pair_writer *writer) {
    int32_t meets[LEAF_SLOTS];
    size_t const count = triangles->end - triangles->begin;
    for (size_t i = vertices->begin; i < vertices->end; i++) {
        compare_boxes(vertices->list, i, triangles->list, triangles->begin, count, meets);
        uint32_t const vertex = vertices->list->features[i];
        for (size_t j = 0; j < count; j++) {
            const uint32_t *const corners = triangles->list->corners + 3 * (triangles->begin + j);
            bool const shares =
                (vertex == corners[0]) | (vertex == corners[1]) | (vertex == corners[2]);
            if (!meets[j] | shares) continue;
            pair_writer_add(writer, vertex, triangles->list->features[triangles->begin + j]);
        }
    }
}

static uint64_t count_triangle_pairs(const slot_run *a, const slot_run *b, bool is_same) {
    int32_t meets[LEAF_SLOTS];
    uint64_t total = 0;
    for (size_t i = a->begin; i < a->end; i++) {
        size_t const begin = is_same ? i + 1 : b->begin;
        compare_boxes(a->list, i, b->list, begin, b->end - begin, meets);
        for (size_t j = 0; j < b->end - begin; j++) total += meets[j] != 0;
    }
    return total;
}

void search_leaf(const leaf_search *search, const tree_leaf *leaf) {
    slot_run const triangles = triangles_of(search->broad, leaf);
    slot_run const vertices = vertices_of(search->broad, leaf);
    slot_run const edges = edges_of(search->broad, leaf);
    pair_vertices(&vertices, &triangles, &search->output->writers[FEATURE_VERTEX_TRIANGLE]);
    pair_edges(&edges, &edges, true, &search->output->writers[FEATURE_EDGE_EDGE]);
    if (search->counts_box_pairs)
        search->output->box_pair_count += count_triangle_pairs(&triangles, &triangles, true);
}

void search_leaf_pair(const leaf_search *search, const tree_leaf *a, const tree_leaf *b) {
    const broad_phase *const broad = search->broad;
    slot_run const triangles_a = triangles_of(broad, a), triangles_b = triangles_of(broad, b);
    slot_run const vertices_a = vertices_of(broad, a), vertices_b = vertices_of(broad, b);
    slot_run const edges_a = edges_of(broad, a), edges_b = edges_of(broad, b);
    pair_writer *const writer = &search->output->writers[FEATURE_VERTEX_TRIANGLE];
    pair_vertices(&vertices_a, &triangles_b, writer);
    pair_vertices(&vertices_b, &triangles_a, writer);
    pair_edges(&edges_a, &edges_b, false, &search->output->writers[FEATURE_EDGE_EDGE]);
    if (search->counts_box_pairs)
        search->output->box_pair_count += count_triangle_pairs(&triangles_a, &triangles_b, false);
}
