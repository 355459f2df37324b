/* detect/pairs/root_pairs.c - the start of stage 7: which trees' roots meet.
 *
 * A binary tree over the roots, made anew in each search: boxes are halved along their longest side
 * by the middles of the roots, so that n objects take some n log n steps. Its nodes lie in the
 * order of a walk through it, each with the place where the walk goes on when it skips the node.
 * Pairs come in the order of their surfaces, whatever the tree is. */
#include "base/sort.h"
#include "detect/trees/broad_phase_parts.h"

#include <math.h>

/* From this depth on lists are cut into halves, wherever the middles lie. */
enum { DEEPEST_MIDDLE = 48 };

static const tree_node *get_root(const broad_phase *broad, uint32_t surface) {
    const surface_tree *const tree = &broad->trees[surface];
    return &tree->nodes.data[tree->nodes.count - 1];
}

static float find_middle(const float box[6], int axis) {
    return 0.5F * box[axis] + 0.5F * box[3 + axis];
}

/* Box of all roots, and where their middles lie. */
static void measure_roots(const broad_phase *broad, const uint32_t *surfaces, size_t count,
                          float box[6], float middles[6]) {
    for (int k = 0; k < 3; k++) {
        box[k] = middles[k] = INFINITY;
        box[3 + k] = middles[3 + k] = -INFINITY;
    }
    for (size_t i = 0; i < count; i++) {
        const float *const root = get_root(broad, surfaces[i])->box;
        for (int k = 0; k < 3; k++) {
            float const middle = find_middle(root, k);
            box[k] = fminf(box[k], root[k]);
            box[3 + k] = fmaxf(box[3 + k], root[3 + k]);
            middles[k] = fminf(middles[k], middle);
            middles[3 + k] = fmaxf(middles[3 + k], middle);
        }
    }
}

/* Moves those that lie below the middle of `middles` to the front; how many. */
static size_t part_roots(const broad_phase *broad, uint32_t *surfaces, size_t count,
                         const float middles[6]) {
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (middles[3 + k] - middles[k] > middles[3 + axis] - middles[axis]) axis = k;
    float const cut = find_middle(middles, axis);
    size_t below = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t const surface = surfaces[i];
        if (!(find_middle(get_root(broad, surface)->box, axis) < cut)) continue;
        surfaces[i] = surfaces[below];
        surfaces[below++] = surface;
    }
    return below;
}

/* Appends the node of some roots and all below it. There is room. */
static void append_nodes(broad_phase *broad, uint32_t *surfaces, size_t count, int depth) {
    uint32_t const index = (uint32_t)broad->root_nodes.count++;
    root_node *const node = &broad->root_nodes.data[index];
    float middles[6];
    measure_roots(broad, surfaces, count, node->box, middles);
    node->surface = count == 1 ? surfaces[0] : TULLE_NONE;
    node->last_surface = surfaces[0];
    for (size_t i = 1; i < count; i++)
        if (surfaces[i] > node->last_surface) node->last_surface = surfaces[i];
    if (count > 1) {
        size_t first = depth < DEEPEST_MIDDLE ? part_roots(broad, surfaces, count, middles) : 0;
        if (first == 0 || first == count) first = count / 2;
        append_nodes(broad, surfaces, first, depth + 1);
        append_nodes(broad, surfaces + first, count - first, depth + 1);
    }
    node->end = (uint32_t)broad->root_nodes.count;
}

/* The tree over the roots of all surfaces that are present. */
static bool build_root_tree(broad_phase *broad, const surface_set *set) {
    broad->roots.count = broad->root_nodes.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->roots, set->surface_count) ||
        !ARRAY_RESERVE(broad->heap, &broad->root_nodes, 2 * set->surface_count))
        return false;
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (set->surfaces[s].is_present && broad->trees[s].nodes.count > 0)
            broad->roots.data[broad->roots.count++] = s;
    if (broad->roots.count > 0) append_nodes(broad, broad->roots.data, broad->roots.count, 0);
    return true;
}

static int compare_surfaces(const void *one, const void *two) {
    uint32_t const a = *(const uint32_t *)one, b = *(const uint32_t *)two;
    return (a > b) - (a < b);
}

/* Surfaces from `surface` on whose roots meet its own, ascending, into broad->roots. */
static void find_partners(broad_phase *broad, const surface_set *set, uint32_t surface) {
    const float *const box = get_root(broad, surface)->box;
    broad->roots.count = 0;
    for (uint32_t i = 0; i < broad->root_nodes.count;) {
        const root_node *const node = &broad->root_nodes.data[i];
        bool const is_skipped = node->last_surface < surface || !boxes_meet(node->box, box);
        i = is_skipped ? node->end : i + 1;
        if (is_skipped || node->surface == TULLE_NONE) continue;
        if (surfaces_may_meet(set, surface, node->surface))
            broad->roots.data[broad->roots.count++] = node->surface;
    }
    sort_in_place(broad->roots.data, broad->roots.count, sizeof(uint32_t), compare_surfaces);
}

static search_task make_task(const broad_phase *broad, uint32_t a, uint32_t b) {
    const surface_tree *const first = &broad->trees[a], *const second = &broad->trees[b];
    return (search_task){
        .surface = {a, b},
        .node = {(uint32_t)first->nodes.count - 1, (uint32_t)second->nodes.count - 1},
        .level = {first->level_count, second->level_count}};
}

bool append_roots(broad_phase *broad, const surface_set *set) {
    if (!build_root_tree(broad, set)) return false;
    for (uint32_t s = 0; s < set->surface_count; s++) {
        if (!set->surfaces[s].is_present || broad->trees[s].nodes.count == 0) continue;
        find_partners(broad, set, s);
        if (!ARRAY_RESERVE(broad->heap, &broad->search_tasks[0], broad->roots.count)) return false;
        for (size_t i = 0; i < broad->roots.count; i++)
            broad->search_tasks[0].data[broad->search_tasks[0].count++] =
                make_task(broad, s, broad->roots.data[i]);
    }
    return true;
}
