/* detect/trees/tree_shape.c - the constant tree of one surface: takes rest positions, gives an
 * order of its triangles, equal and nearly full leaves of at most LEAF_TRIANGLES, and a complete
 * tree above them. It is built once; afterwards only its boxes change.
 *
 * A set of triangles is split at the median of its centroids along the longest side of their box,
 * ties by index, and so on down to leaves. On a sheet at rest this gives compact, square pieces,
 * and what is near on the surface stays near when it moves. */
#include "detect/trees/tree_shape.h"

#include "detect/trees/broad_phase_parts.h"

typedef struct shaper {
    uint32_t *order; /* triangles */
    const uint32_t *corners;
    const double *rest;
} shaper;

/* Three times the centroid of a triangle, along an axis. */
static double sum_corners(const shaper *shape, uint32_t triangle, size_t axis) {
    const uint32_t *const corner = shape->corners + 3 * (size_t)triangle;
    return shape->rest[3 * (size_t)corner[0] + axis] + shape->rest[3 * (size_t)corner[1] + axis] +
           shape->rest[3 * (size_t)corner[2] + axis];
}

static bool comes_before(const shaper *shape, size_t axis, uint32_t a, uint32_t b) {
    double const x = sum_corners(shape, a, axis), y = sum_corners(shape, b, axis);
    return x < y || (x == y && a < b);
}

/* Reorders begin .. end - 1 so that the first `middle - begin` come before all others (quickselect
 * of Hoare). The order is total, so no two are equal. */
static void select_middle(const shaper *shape, size_t axis, size_t begin, size_t end,
                          size_t middle) {
    while (end - begin > 1) {
        /* The pivot is the middle one of first, middle and last, against inputs that come sorted.
         */
        uint32_t first = shape->order[begin], pivot = shape->order[begin + (end - begin) / 2];
        uint32_t const last = shape->order[end - 1];
        if (comes_before(shape, axis, pivot, first)) {
            uint32_t const swapped = first;
            first = pivot;
            pivot = swapped;
        }
        if (comes_before(shape, axis, last, first))
            pivot = first;
        else if (comes_before(shape, axis, last, pivot))
            pivot = last;
        size_t low = begin, high = end - 1;
        for (;;) {
            while (comes_before(shape, axis, shape->order[low], pivot)) low++;
            while (comes_before(shape, axis, pivot, shape->order[high])) high--;
            if (low >= high) break;
            uint32_t const swapped = shape->order[low];
            shape->order[low++] = shape->order[high];
            shape->order[high--] = swapped;
            if (low > high) break;
        }
        /* All before `split` are below or at the pivot, all from it on at or above it. */
        size_t const split = low > begin ? low : begin + 1;
        if (middle < split)
            end = split;
        else
            begin = split;
    }
}

/* Splits leaves leaf_begin .. leaf_end - 1 of leaf_count in halves down to single leaves. Triangles
 * of leaf l are count * l / leaf_count on; recursion is log2(leaf_count) deep. */
static void split_triangles(const shaper *shape, size_t count, size_t leaf_count, size_t leaf_begin,
                            size_t leaf_end) {
    if (leaf_end - leaf_begin < 2) return;
    size_t const leaf_middle = (leaf_begin + leaf_end) / 2;
    size_t const begin = count * leaf_begin / leaf_count, end = count * leaf_end / leaf_count;
    size_t longest = 0;
    double most = -1.0;
    for (size_t axis = 0; axis < 3; axis++) {
        double low = sum_corners(shape, shape->order[begin], axis), high = low;
        for (size_t i = begin + 1; i < end; i++) {
            double const x = sum_corners(shape, shape->order[i], axis);
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        if (high - low > most) {
            most = high - low;
            longest = axis;
        }
    }
    select_middle(shape, longest, begin, end, count * leaf_middle / leaf_count);
    split_triangles(shape, count, leaf_count, leaf_begin, leaf_middle);
    split_triangles(shape, count, leaf_count, leaf_middle, leaf_end);
}

void order_triangles(uint32_t *order, const surface_range *range, size_t leaf_count,
                     const uint32_t *corners, const double *rest) {
    size_t const count = range->triangle_end - range->triangle_begin;
    shaper const shape = {.order = order, .corners = corners, .rest = rest};
    for (size_t i = 0; i < count; i++) order[i] = range->triangle_begin + (uint32_t)i;
    split_triangles(&shape, count, leaf_count, 0, leaf_count);
}

tulle_status shape_refit_tree(broad_phase *broad, const surface_set *set, uint32_t surface,
                              const double *rest) {
    const surface_range *const range = &set->surfaces[surface];
    surface_tree *const tree = &broad->trees[surface];
    size_t const count = range->triangle_end - range->triangle_begin;
    if (count == 0) return assign_even_slots(broad, set, surface);
    order_triangles(broad->triangles.features + range->triangle_begin, range, tree->leaf_count,
                    set->topo->triangles, rest);
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
