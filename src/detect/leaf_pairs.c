/* detect/leaf_pairs.c - feature pairs of two leaves: takes the boxes of their slots, writes each
 * vertex/triangle pair and each edge/edge pair whose boxes meet and which shares no vertex.
 *
 * First the slots of each leaf that meet the box of the other leaf are copied together: most do
 * not. Then each of one is compared with all of the other, lane by lane over the copied arrays, so
 * that the compiler turns it into vector compares. */
#include "detect/broad_phase_parts.h"

enum { LEAF_SLOTS = 3 * LEAF_TRIANGLES }; /* most edges, or vertices, that a leaf owns */

/* Copies of some slots of one list. */
typedef struct near_slots {
    float sides[6][LEAF_SLOTS];
    uint32_t corners[3][LEAF_SLOTS];
    uint32_t slots[LEAF_SLOTS];
    size_t count;
} near_slots;

/* Slots begin .. end - 1 whose boxes meet `box`. Copies every slot and keeps the place of those
 * that do not count: no branch to guess. */
static void gather_near(const slot_list *list, size_t begin, size_t end, const tree_box *box,
                        near_slots *to) {
    size_t const corner_count = list->corner_count;
    size_t count = 0;
    for (size_t slot = begin; slot < end; slot++) {
        float side[6];
        for (int k = 0; k < 6; k++) to->sides[k][count] = side[k] = list->sides[k][slot];
        for (size_t k = 0; k < corner_count; k++)
            to->corners[k][count] = list->corners[corner_count * slot + k];
        to->slots[count] = (uint32_t)slot;
        count += (side[0] <= box->high[0]) & (box->low[0] <= side[3]) & (side[1] <= box->high[1]) &
                 (box->low[1] <= side[4]) & (side[2] <= box->high[2]) & (box->low[2] <= side[5]);
    }
    to->count = count;
}

/* meets[j] is 1 where the box of slot i of `a` meets that of slot first + j of `b`, else 0. */
static void compare_boxes(const near_slots *a, size_t i, const near_slots *b, size_t first,
                          int32_t *meets) {
    float const low_x = a->sides[0][i], high_x = a->sides[3][i];
    float const low_y = a->sides[1][i], high_y = a->sides[4][i];
    float const low_z = a->sides[2][i], high_z = a->sides[5][i];
    for (size_t j = first; j < b->count; j++)
        meets[j - first] = (b->sides[0][j] <= high_x) & (low_x <= b->sides[3][j]) &
                           (b->sides[1][j] <= high_y) & (low_y <= b->sides[4][j]) &
                           (b->sides[2][j] <= high_z) & (low_z <= b->sides[5][j]);
}

/* Clears meets[j] where one of the corners of slot first + j of `b` is `vertex`. */
static void exclude_vertex(uint32_t vertex, const near_slots *b, size_t corner_count, size_t first,
                           int32_t *meets) {
    for (size_t k = 0; k < corner_count; k++)
        for (size_t j = first; j < b->count; j++) meets[j - first] &= b->corners[k][j] != vertex;
}

/* Hands a batch on. */
static void flush_batch(worker_output *output, feature_kind kind) {
    pair_batch *const batch = &output->batches[kind];
    output->candidate_count += batch->count;
    output->consume(output->context, output->tables, batch, output->worker);
    batch->count = 0;
}

void finish_batches(worker_output *output) {
    for (int kind = 0; kind < 2; kind++)
        if (output->batches[kind].count > 0) flush_batch(output, (feature_kind)kind);
}

/* Room for the pairs of one slot. */
static pair_batch *make_room(worker_output *output, feature_kind kind) {
    pair_batch *const batch = &output->batches[kind];
    if (batch->count + LEAF_SLOTS > PAIR_BATCH_SIZE) flush_batch(output, kind);
    return batch;
}

/* Adds the pairs of `slot` with those of the other leaf that it meets. */
static void add_pairs(pair_batch *batch, uint32_t slot, const near_slots *others, size_t first,
                      const int32_t *meets) {
    size_t count = batch->count;
    for (size_t j = first; j < others->count; j++) {
        batch->first[count] = slot;
        batch->second[count] = others->slots[j];
        count += (size_t)meets[j - first];
    }
    batch->count = count;
}

static void pair_edges(const near_slots *a, const near_slots *b, worker_output *output) {
    int32_t meets[LEAF_SLOTS];
    for (size_t i = 0; i < a->count; i++) {
        size_t const first = a == b ? i + 1 : 0;
        compare_boxes(a, i, b, first, meets);
        exclude_vertex(a->corners[0][i], b, 2, first, meets);
        exclude_vertex(a->corners[1][i], b, 2, first, meets);
        add_pairs(make_room(output, FEATURE_EDGE_EDGE), a->slots[i], b, first, meets);
    }
}

static void pair_vertices(const near_slots *vertices, const near_slots *triangles,
                          worker_output *output) {
    int32_t meets[LEAF_SLOTS];
    for (size_t i = 0; i < vertices->count; i++) {
        compare_boxes(vertices, i, triangles, 0, meets);
        exclude_vertex(vertices->corners[0][i], triangles, 3, 0, meets);
        add_pairs(make_room(output, FEATURE_VERTEX_TRIANGLE), vertices->slots[i], triangles, 0,
                  meets);
    }
}

static uint64_t count_pairs(const near_slots *a, const near_slots *b) {
    int32_t meets[LEAF_SLOTS];
    uint64_t total = 0;
    for (size_t i = 0; i < a->count; i++) {
        size_t const first = a == b ? i + 1 : 0;
        compare_boxes(a, i, b, first, meets);
        for (size_t j = first; j < b->count; j++) total += meets[j - first] != 0;
    }
    return total;
}

/* What of one leaf is near a box. */
typedef struct near_leaf {
    near_slots triangles, vertices, edges;
} near_leaf;

static void gather_leaf(const broad_phase *broad, const tree_leaf *leaf, const tree_box *box,
                        near_leaf *to) {
    gather_near(&broad->triangles, leaf->triangle_begin, leaf->triangle_end, box, &to->triangles);
    gather_near(&broad->vertices, leaf->vertex_begin, leaf->vertex_end, box, &to->vertices);
    gather_near(&broad->edges, leaf->edge_begin, leaf->edge_end, box, &to->edges);
}

void search_leaf(const leaf_search *search, const tree_leaf *leaf, const tree_box *box) {
    near_leaf all;
    gather_leaf(search->broad, leaf, box, &all);
    search->output->leaf_pair_count++;
    pair_vertices(&all.vertices, &all.triangles, search->output);
    pair_edges(&all.edges, &all.edges, search->output);
    if (search->counts_box_pairs)
        search->output->box_pair_count += count_pairs(&all.triangles, &all.triangles);
}

void search_leaf_pair(const leaf_search *search, const tree_leaf *a, const tree_box *box_a,
                      const tree_leaf *b, const tree_box *box_b) {
    near_leaf near_a, near_b;
    gather_leaf(search->broad, a, box_b, &near_a);
    gather_leaf(search->broad, b, box_a, &near_b);
    search->output->leaf_pair_count++;
    pair_vertices(&near_a.vertices, &near_b.triangles, search->output);
    pair_vertices(&near_b.vertices, &near_a.triangles, search->output);
    pair_edges(&near_a.edges, &near_b.edges, search->output);
    if (search->counts_box_pairs)
        search->output->box_pair_count += count_pairs(&near_a.triangles, &near_b.triangles);
}
