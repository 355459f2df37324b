/* detect/pairs/leaf_masks.c - which features of leaves that share a vertex are to be compared.
 *
 * Takes the slots of refitted trees. Gives masks for each leaf with itself and with its
 * neighbours of higher number; see leaf_tables. They never change. */
#include "detect/trees/broad_phase_parts.h"

#include <string.h>

/* `places` below tells for each record where it stands among the corners of the leaf at hand. */
enum { NOWHERE = LEAF_SLOTS /* not a corner */ };

/* Features around each corner of the leaf at hand, as bits; none at NOWHERE. */
typedef struct corner_bits {
    uint32_t at[LEAF_SLOTS + 1];
} corner_bits;

static corner_bits mark_corners(const uint8_t *places, const slot_list *list, uint32_t begin,
                                uint32_t end) {
    corner_bits bits = {{0}};
    const uint32_t *corner = list->corners + list->corner_count * (size_t)begin;
    for (uint32_t slot = begin; slot < end; slot++)
        for (uint32_t k = 0; k < list->corner_count; k++)
            bits.at[places[*corner++]] |= 1U << (slot - begin);
    bits.at[NOWHERE] = 0;
    return bits;
}

/* Writes the masks of leaf a, whose places are known, against leaf b. For each edge of a and each
 * group of edges of b: which of these share no vertex with it; of the leaf itself only those after
 * the edge. Then for each vertex of a, and of b if that is another leaf: of which triangles of the
 * other it is no corner. */
static void mask_pair(const broad_phase *broad, const uint8_t *places, const tree_leaf *a,
                      const tree_leaf *b, uint16_t *to) {
    const slot_list *const triangles = &broad->triangles;
    corner_bits const edges = mark_corners(places, &broad->edges, b->edge_begin, b->edge_end);
    for (uint32_t edge = a->edge_begin; edge < a->edge_end; edge++) {
        const uint32_t *const ends = broad->edges.corners + 2 * (size_t)edge;
        uint32_t mask = (1U << (b->edge_end - b->edge_begin)) - 1;
        if (a == b) mask &= ~1U << (edge - a->edge_begin);
        for (int k = 0; k < 2; k++) mask &= ~edges.at[places[ends[k]]];
        for (uint32_t group = 0; group < a->mask_groups; group++)
            *to++ = (uint16_t)(mask >> GROUP_LANES * group);
    }
    const tree_leaf *const leaves[2] = {a, b};
    for (int side = 0; side < (a == b ? 1 : 2); side++) {
        const tree_leaf *const own = leaves[side], *const other = leaves[1 - side];
        uint32_t const all = (1U << (other->triangle_end - other->triangle_begin)) - 1;
        corner_bits const around =
            mark_corners(places, triangles, other->triangle_begin, other->triangle_end);
        for (uint32_t v = own->vertex_begin; v < own->vertex_end; v++)
            *to++ = (uint16_t)(all & ~around.at[places[broad->vertices.corners[v]]]);
    }
}

static uint32_t count_neighbours(const tree_leaf *leaf) {
    uint32_t count = 0;
    while (count < LEAF_NEIGHBOURS && leaf->neighbours[count] != 0) count++;
    return count;
}

/* Chooses where the masks of a leaf begin and how many it has; returns where the next ones may. */
static size_t place_masks(const broad_phase *broad, tree_leaf *leaf, size_t begin) {
    uint32_t const count = count_neighbours(leaf);
    uint32_t groups = count_edge_groups(leaf), vertices = 0;
    for (uint32_t i = 0; i < count; i++) {
        const tree_leaf *const other = &broad->leaves[leaf->neighbours[i]];
        uint32_t const own_groups = count_edge_groups(other);
        uint32_t const own_vertices = other->vertex_end - other->vertex_begin;
        if (own_groups > groups) groups = own_groups;
        if (own_vertices > vertices) vertices = own_vertices;
    }
    leaf->mask_begin = (uint32_t)begin;
    leaf->mask_groups = (uint16_t)groups;
    leaf->mask_stride = (uint16_t)((leaf->edge_end - leaf->edge_begin) * groups + leaf->vertex_end -
                                   leaf->vertex_begin + vertices);
    return begin + (size_t)leaf->mask_stride * (count + 1);
}

/* The masks of a leaf. Places are all NOWHERE before and after. */
static void mask_leaf(broad_phase *broad, const tree_leaf *leaf, uint8_t *places) {
    const uint32_t *const corners = broad->leaf_corners.data;
    uint32_t const count = count_neighbours(leaf);
    uint16_t *to = broad->masks.data + leaf->mask_begin;
    for (uint32_t i = leaf->corner_begin; i < leaf->corner_end; i++)
        places[corners[i]] = (uint8_t)(i - leaf->corner_begin);
    mask_pair(broad, places, leaf, leaf, to);
    for (uint32_t i = 0; i < count; i++)
        mask_pair(broad, places, leaf, &broad->leaves[leaf->neighbours[i]],
                  to += leaf->mask_stride);
    for (uint32_t i = leaf->corner_begin; i < leaf->corner_end; i++) places[corners[i]] = NOWHERE;
}

bool make_leaf_masks(broad_phase *broad) {
    /* A leaf that may neighbour any other is compared by vertices. */
    size_t count = 0;
    for (size_t l = 0; l < broad->leaf_capacity; l++)
        if (broad->leaves[l].neighbours[0] != LEAF_ANY)
            count = place_masks(broad, &broad->leaves[l], count);
    uint8_t *const places = memory_allocate(broad->heap, broad->vertex_count);
    bool const has_room = places && ARRAY_RESERVE(broad->heap, &broad->masks, count);
    if (has_room) {
        memset(places, NOWHERE, broad->vertex_count);
        for (size_t l = 0; l < broad->leaf_capacity; l++)
            if (broad->leaves[l].neighbours[0] != LEAF_ANY)
                mask_leaf(broad, &broad->leaves[l], places);
    }
    memory_release(broad->heap, places, broad->vertex_count);
    return has_room;
}
