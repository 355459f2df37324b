/* detect/trees/tree_shape.c - the constant tree of one surface: takes rest positions, gives an
 * order of its triangles, equal and nearly full leaves of at most LEAF_TRIANGLES, and a complete
 * tree above them. It is built once; afterwards only its boxes change.
 *
 * A set of triangles is split at the median of its centroids along the longest side of their box,
 * ties by index, and so on down to leaves. On a sheet at rest this gives compact, square pieces,
 * and what is near on the surface stays near when it moves. */
#include "detect/trees/tree_shape.h"

#include "detect/trees/broad_phase_parts.h"

enum { PIVOT_SAMPLES = 9 };

/* A triangle on its way to its leaf, with three times its centroid. */
typedef struct placed_triangle {
    double sum[3]; /* [m] of its corners */
    uint32_t triangle;
} placed_triangle;

/* Without a branch: which comes first is anyone's guess. */
static inline bool comes_before(const placed_triangle *a, const placed_triangle *b, size_t axis) {
    double const x = a->sum[axis], y = b->sum[axis];
    return (x < y) | ((x == y) & (a->triangle < b->triangle));
}

/* The one in the middle of three. */
static size_t choose_middle(const placed_triangle *triangles, size_t axis, size_t a, size_t b,
                            size_t c) {
    bool const ab = comes_before(&triangles[a], &triangles[b], axis);
    bool const bc = comes_before(&triangles[b], &triangles[c], axis);
    if (ab == bc) return b;
    return comes_before(&triangles[a], &triangles[c], axis) == ab ? c : a;
}

/* Near the middle, as a rule: the middle one of three, or of the middle ones of three times three,
 * from all over the range. */
static size_t choose_pivot(const placed_triangle *triangles, size_t axis, size_t begin,
                           size_t end) {
    size_t const step = (end - begin) / PIVOT_SAMPLES, middle = begin + (end - begin) / 2;
    if (step == 0) return choose_middle(triangles, axis, begin, middle, end - 1);
    size_t thirds[3];
    for (size_t k = 0; k < 3; k++) {
        size_t const at = begin + step / 2 + 3 * step * k;
        thirds[k] = choose_middle(triangles, axis, at, at + step, at + 2 * step);
    }
    return choose_middle(triangles, axis, thirds[0], thirds[1], thirds[2]);
}

static inline void swap_triangles(placed_triangle *a, placed_triangle *b) {
    placed_triangle const swapped = *a;
    *a = *b;
    *b = swapped;
}

/* Reorders begin .. end - 1 so that the first `middle - begin` come before all others (quickselect
 * of Hoare, partitions of Lomuto). The order is total, so no two are equal. */
static void select_middle(placed_triangle *triangles, size_t axis, size_t begin, size_t end,
                          size_t middle) {
    while (end - begin > 1) {
        swap_triangles(&triangles[choose_pivot(triangles, axis, begin, end)], &triangles[end - 1]);
        placed_triangle const pivot = triangles[end - 1];
        size_t split = begin;
        for (size_t i = begin; i + 1 < end; i++) {
            bool const is_before = comes_before(&triangles[i], &pivot, axis);
            swap_triangles(&triangles[i], &triangles[split]);
            split += is_before;
        }
        swap_triangles(&triangles[split], &triangles[end - 1]);
        if (middle == split) return;
        if (middle < split)
            end = split;
        else
            begin = split + 1;
    }
}

/* Splits leaves leaf_begin .. leaf_end - 1 of leaf_count in halves down to single leaves. Triangles
 * of leaf l are count * l / leaf_count on; recursion is log2(leaf_count) deep. */
static void split_triangles(placed_triangle *triangles, size_t count, size_t leaf_count,
                            size_t leaf_begin, size_t leaf_end) {
    if (leaf_end - leaf_begin < 2) return;
    size_t const leaf_middle = (leaf_begin + leaf_end) / 2;
    size_t const begin = count * leaf_begin / leaf_count, end = count * leaf_end / leaf_count;
    placed_triangle low = triangles[begin], high = low;
    for (size_t i = begin + 1; i < end; i++)
        for (int axis = 0; axis < 3; axis++) {
            double const x = triangles[i].sum[axis];
            low.sum[axis] = x < low.sum[axis] ? x : low.sum[axis];
            high.sum[axis] = x > high.sum[axis] ? x : high.sum[axis];
        }
    size_t longest = 0;
    for (size_t axis = 1; axis < 3; axis++)
        if (high.sum[axis] - low.sum[axis] > high.sum[longest] - low.sum[longest]) longest = axis;
    select_middle(triangles, longest, begin, end, count * leaf_middle / leaf_count);
    split_triangles(triangles, count, leaf_count, leaf_begin, leaf_middle);
    split_triangles(triangles, count, leaf_count, leaf_middle, leaf_end);
}

bool order_triangles(memory *heap, uint32_t *order, const surface_range *range, size_t leaf_count,
                     const uint32_t *corners, const double *rest) {
    size_t const count = range->triangle_end - range->triangle_begin;
    placed_triangle *const triangles = memory_allocate(heap, count * sizeof *triangles);
    if (!triangles) return false;
    for (size_t i = 0; i < count; i++) {
        uint32_t const triangle = range->triangle_begin + (uint32_t)i;
        const uint32_t *const corner = corners + 3 * (size_t)triangle;
        placed_triangle *const placed = &triangles[i];
        placed->triangle = triangle;
        for (size_t axis = 0; axis < 3; axis++)
            placed->sum[axis] = rest[3 * (size_t)corner[0] + axis] +
                                rest[3 * (size_t)corner[1] + axis] +
                                rest[3 * (size_t)corner[2] + axis];
    }
    split_triangles(triangles, count, leaf_count, 0, leaf_count);
    for (size_t i = 0; i < count; i++) order[i] = triangles[i].triangle;
    memory_release(heap, triangles, count * sizeof *triangles);
    return true;
}

tulle_status shape_refit_tree(broad_phase *broad, const surface_set *set, uint32_t surface,
                              const double *rest) {
    const surface_range *const range = &set->surfaces[surface];
    surface_tree *const tree = &broad->trees[surface];
    size_t const count = range->triangle_end - range->triangle_begin;
    if (count == 0) return assign_even_slots(broad, set, surface);
    if (!order_triangles(broad->heap, broad->triangles.features + range->triangle_begin, range,
                         tree->leaf_count, set->topo->triangles, rest))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t l = 0; l < tree->leaf_count; l++) {
        tree_leaf *const leaf = &broad->leaves[tree->leaf_begin + l];
        leaf->triangle_begin = range->triangle_begin + (uint32_t)(count * l / tree->leaf_count);
        leaf->triangle_end = range->triangle_begin + (uint32_t)(count * (l + 1) / tree->leaf_count);
    }

    /* Levels up to the root: the lowest nodes take `children` leaves, the others NODE_LANES, the
     * root what is left. */
    uint32_t first = tree->leaf_begin, left = tree->leaf_count, children = left;
    while (children > NODE_LANES) children /= 2;
    if (!ARRAY_RESERVE(broad->heap, &tree->nodes, left / children * 8 / 7 + 2))
        return TULLE_ERROR_OUT_OF_MEMORY;
    do {
        tree->level_begin[tree->level_count++] = (uint32_t)tree->nodes.count;
        for (uint32_t i = 0; i < left; i += children)
            tree->nodes.data[tree->nodes.count++] =
                (tree_node){.first = first + i, .child_count = children};
        first = tree->level_begin[tree->level_count - 1];
        left /= children;
        children = left < NODE_LANES ? left : NODE_LANES;
    } while (left > 1);
    tree->level_begin[tree->level_count] = (uint32_t)tree->nodes.count;
    return assign_even_slots(broad, set, surface);
}
