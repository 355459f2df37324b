/* detect/pairs/root_pairs.c - the start of a search: takes the trees of all surfaces, gives the
 * pairs of surfaces whose roots meet.
 *
 * A binary tree over the roots is made anew in each search. A node is cut at the middle of its
 * longest side, so n objects take some n log n steps. Nodes lie in the order of a walk through the
 * tree; each says where the walk goes on when it skips the node. Pairs come in the order of their
 * surfaces, whatever the tree is. */
#include "base/sort.h"
#include "detect/trees/broad_phase_parts.h"

#include <math.h>

/* From this depth on lists are cut into halves, wherever the middles lie. */
enum { DEEPEST_MIDDLE = 48 };

static const tree_node *get_root(const broad_phase *broad, uint32_t surface) {
    const surface_tree *const tree = &broad->trees[surface];
    return &tree->nodes.data[tree->nodes.count - 1];
}

static float compute_middle(const float box[6], int axis) {
    return 0.5F * box[axis] + 0.5F * box[3 + axis];
}

/* Appends the node of some roots and all below it. There is room. */
static void append_nodes(broad_phase *broad, uint32_t *surfaces, size_t count, int depth) {
    uint32_t const index = (uint32_t)broad->root_nodes.count++;
    root_node *const node = &broad->root_nodes.data[index];
    float *const box = node->box;
    float middles[6]; /* box of the middles of the roots */
    for (int k = 0; k < 3; k++) {
        box[k] = middles[k] = INFINITY;
        box[3 + k] = middles[3 + k] = -INFINITY;
    }
    node->surface = count == 1 ? surfaces[0] : TULLE_NONE;
    node->last_surface = surfaces[0];
    for (size_t i = 0; i < count; i++) {
        const float *const root = get_root(broad, surfaces[i])->box;
        for (int k = 0; k < 3; k++) {
            float const middle = compute_middle(root, k);
            box[k] = fminf(box[k], root[k]);
            box[3 + k] = fmaxf(box[3 + k], root[3 + k]);
            middles[k] = fminf(middles[k], middle);
            middles[3 + k] = fmaxf(middles[3 + k], middle);
        }
        if (surfaces[i] > node->last_surface) node->last_surface = surfaces[i];
    }
    if (count > 1) {
        /* Cut along the longest side: roots whose middle lies below the cut move to the front. */
        int axis = 0;
        for (int k = 1; k < 3; k++)
            if (middles[3 + k] - middles[k] > middles[3 + axis] - middles[axis]) axis = k;
        float const cut = compute_middle(middles, axis);
        size_t first = 0;
        for (size_t i = 0; i < count && depth < DEEPEST_MIDDLE; i++) {
            uint32_t const surface = surfaces[i];
            if (!(compute_middle(get_root(broad, surface)->box, axis) < cut)) continue;
            surfaces[i] = surfaces[first];
            surfaces[first++] = surface;
        }
        if (first == 0 || first == count) first = count / 2;
        append_nodes(broad, surfaces, first, depth + 1);
        append_nodes(broad, surfaces + first, count - first, depth + 1);
    }
    node->end = (uint32_t)broad->root_nodes.count;
}

static int compare_surfaces(const void *one, const void *two) {
    uint32_t const a = *(const uint32_t *)one, b = *(const uint32_t *)two;
    return (a > b) - (a < b);
}

bool list_root_pairs(broad_phase *broad, const surface_set *set) {
    broad->roots.count = broad->root_nodes.count = broad->search_tasks[0].count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->roots, set->surface_count) ||
        !ARRAY_RESERVE(broad->heap, &broad->root_nodes, 2 * set->surface_count))
        return false;
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (set->surfaces[s].is_present && broad->trees[s].nodes.count > 0)
            broad->roots.data[broad->roots.count++] = s;
    if (broad->roots.count > 0) append_nodes(broad, broad->roots.data, broad->roots.count, 0);

    for (uint32_t s = 0; s < set->surface_count; s++) {
        const surface_tree *const own = &broad->trees[s];
        if (!set->surfaces[s].is_present || own->nodes.count == 0) continue;

        /* Surfaces from this one on that it may meet and whose roots meet its own, ascending. */
        const float *const box = get_root(broad, s)->box;
        broad->roots.count = 0;
        for (uint32_t i = 0; i < broad->root_nodes.count;) {
            const root_node *const node = &broad->root_nodes.data[i];
            bool const is_skipped = node->last_surface < s || !boxes_meet(node->box, box);
            i = is_skipped ? node->end : i + 1;
            if (is_skipped || node->surface == TULLE_NONE) continue;
            if (surfaces_may_meet(set, s, node->surface))
                broad->roots.data[broad->roots.count++] = node->surface;
        }
        sort_in_place(broad->roots.data, broad->roots.count, sizeof(uint32_t), compare_surfaces);

        if (!ARRAY_RESERVE(broad->heap, &broad->search_tasks[0], broad->roots.count)) return false;
        for (size_t i = 0; i < broad->roots.count; i++) {
            const surface_tree *const other = &broad->trees[broad->roots.data[i]];
            broad->search_tasks[0].data[broad->search_tasks[0].count++] = (search_task){
                .surface = {s, broad->roots.data[i]},
                .node = {(uint32_t)own->nodes.count - 1, (uint32_t)other->nodes.count - 1},
                .level = {own->level_count, other->level_count}};
        }
    }
    return true;
}
