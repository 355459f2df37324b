/* detect/pairs/leaf_masks.c - which features of leaves that share a vertex are to be compared.
 *
 * Takes the slots of one refitted tree. Gives masks for each leaf with itself and with its
 * neighbours of higher number; see leaf_tables. They never change. */
#include "detect/trees/broad_phase_parts.h"

static bool share_vertex(const uint32_t *a, uint32_t a_count, const uint32_t *b, uint32_t b_count) {
    for (uint32_t i = 0; i < a_count; i++)
        for (uint32_t j = 0; j < b_count; j++)
            if (a[i] == b[j]) return true;
    return false;
}

/* Writes the masks of leaf a against leaf b. For each edge of a and each group of edges of b: which
 * of these share no vertex with it; of the leaf itself only those after the edge. Then for each
 * vertex of a, and of b if that is another leaf: of which triangles of the other it is no corner.
 */
static void mask_pair(const broad_phase *broad, const tree_leaf *a, const tree_leaf *b,
                      uint16_t *to) {
    const uint32_t *const corners = broad->edges.corners;
    for (uint32_t edge = a->edge_begin; edge < a->edge_end; edge++) {
        for (uint32_t group = 0; group < a->mask_groups; group++) {
            uint32_t const begin = b->edge_begin + GROUP_LANES * group;
            uint32_t mask = 0;
            for (uint32_t l = 0; l < GROUP_LANES && begin + l < b->edge_end; l++) {
                uint32_t const other = begin + l;
                if (a == b && other <= edge) continue;
                bool const shares =
                    share_vertex(corners + 2 * (size_t)edge, 2, corners + 2 * (size_t)other, 2);
                mask |= (uint32_t)!shares << l;
            }
            *to++ = (uint16_t)mask;
        }
    }
    const tree_leaf *const leaves[2] = {a, b};
    for (int side = 0; side < (a == b ? 1 : 2); side++) {
        const tree_leaf *const own = leaves[side], *const other = leaves[1 - side];
        for (uint32_t v = own->vertex_begin; v < own->vertex_end; v++) {
            uint32_t mask = 0;
            for (uint32_t t = other->triangle_begin; t < other->triangle_end; t++) {
                bool const shares = share_vertex(&broad->vertices.corners[v], 1,
                                                 broad->triangles.corners + 3 * (size_t)t, 3);
                mask |= (uint32_t)!shares << (t - other->triangle_begin);
            }
            *to++ = (uint16_t)mask;
        }
    }
}

tulle_status mask_leaves(broad_phase *broad, const surface_tree *tree) {
    for (uint32_t l = tree->leaf_begin; l < tree->leaf_begin + tree->leaf_count; l++) {
        tree_leaf *const leaf = &broad->leaves[l];
        if (leaf->neighbours[0] == LEAF_ANY) continue; /* is compared by vertices */
        uint32_t count = 0, groups = count_edge_groups(leaf), vertices = 0;
        for (; count < LEAF_NEIGHBOURS && leaf->neighbours[count] != 0; count++) {
            const tree_leaf *const other = &broad->leaves[leaf->neighbours[count]];
            uint32_t const own_groups = count_edge_groups(other);
            uint32_t const own_vertices = other->vertex_end - other->vertex_begin;
            if (own_groups > groups) groups = own_groups;
            if (own_vertices > vertices) vertices = own_vertices;
        }
        leaf->mask_groups = (uint16_t)groups;
        leaf->mask_stride = (uint16_t)((leaf->edge_end - leaf->edge_begin) * groups +
                                       leaf->vertex_end - leaf->vertex_begin + vertices);
        size_t const room = (size_t)leaf->mask_stride * (count + 1);
        if (!ARRAY_RESERVE(broad->heap, &broad->masks, room)) return TULLE_ERROR_OUT_OF_MEMORY;
        leaf->mask_begin = (uint32_t)broad->masks.count;
        for (uint32_t i = 0; i <= count; i++) {
            const tree_leaf *const other = i == 0 ? leaf : &broad->leaves[leaf->neighbours[i - 1]];
            mask_pair(broad, leaf, other, broad->masks.data + broad->masks.count);
            broad->masks.count += leaf->mask_stride;
        }
    }
    return TULLE_OK;
}
