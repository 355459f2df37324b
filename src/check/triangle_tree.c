/* check/triangle_tree.c - see triangle_tree.h. */
#include "check/triangle_tree.h"

#include <string.h>

typedef struct sort_key {
    double value;
    uint32_t item;
} sort_key;

/* What the build needs and drops: for each axis the items in the order of their centres. */
typedef struct tree_builder {
    const check_box *boxes;
    uint32_t *order[3];
    uint32_t *scratch; /* count */
    uint8_t *is_left;  /* for every triangle number */
    sort_key *keys;    /* 2 * count */
    triangle_tree *tree;
} tree_builder;

static double compute_centre(const check_box *box, int axis) {
    return 0.5 * box->low[axis] + 0.5 * box->high[axis];
}

/* Merge sort, stable; sorts keys[0 .. count-1] with the help of keys[count .. 2 count-1]. Returns
 * where the sorted run lies. */
static const sort_key *sort_keys(sort_key *keys, size_t count) {
    sort_key *from = keys, *to = keys + count;
    for (size_t width = 1; width < count; width *= 2) {
        for (size_t begin = 0; begin < count; begin += 2 * width) {
            size_t const middle = begin + width < count ? begin + width : count;
            size_t const end = middle + width < count ? middle + width : count;
            size_t left = begin, right = middle;
            for (size_t i = begin; i < end; i++) {
                bool const take_left =
                    left < middle && (right == end || from[left].value <= from[right].value);
                to[i] = take_left ? from[left++] : from[right++];
            }
        }
        sort_key *const swap = from;
        from = to;
        to = swap;
    }
    return from;
}

/* The node of items begin .. end-1 and all below it. Recursion is as deep as the tree: at most
 * TREE_DEPTH_LIMIT. */
static void build_node(tree_builder *builder, size_t begin, size_t end) {
    triangle_tree *const tree = builder->tree;
    size_t const index = tree->node_count++;
    tree_node *const node = &tree->nodes[index];
    node->box = builder->boxes[builder->order[0][begin]];
    node->highest_item = 0;
    for (size_t i = begin; i < end; i++) {
        uint32_t const item = builder->order[0][i];
        const check_box *const box = &builder->boxes[item];
        if (item > node->highest_item) node->highest_item = item;
        for (int axis = 0; axis < 3; axis++) {
            if (box->low[axis] < node->box.low[axis]) node->box.low[axis] = box->low[axis];
            if (box->high[axis] > node->box.high[axis]) node->box.high[axis] = box->high[axis];
        }
    }
    if (end - begin <= TREE_LEAF_SIZE) {
        node->right = (uint32_t)begin;
        node->leaf_count = (uint32_t)(end - begin);
        return;
    }

    /* The axis along which the centres spread widest. */
    int widest = 0;
    double widest_spread = -1.0;
    for (int axis = 0; axis < 3; axis++) {
        const uint32_t *const order = builder->order[axis];
        double const spread = compute_centre(&builder->boxes[order[end - 1]], axis) -
                              compute_centre(&builder->boxes[order[begin]], axis);
        if (spread > widest_spread) {
            widest = axis;
            widest_spread = spread;
        }
    }
    /* Parts the other two orders at its median, stably. */
    size_t const middle = begin + (end - begin) / 2;
    for (size_t i = begin; i < end; i++) builder->is_left[builder->order[widest][i]] = i < middle;
    for (int axis = 0; axis < 3; axis++) {
        if (axis == widest) continue;
        uint32_t *const order = builder->order[axis];
        size_t left = begin, right = 0;
        for (size_t i = begin; i < end; i++) {
            if (builder->is_left[order[i]])
                order[left++] = order[i];
            else
                builder->scratch[right++] = order[i];
        }
        memcpy(order + left, builder->scratch, right * sizeof *order);
    }
    node->leaf_count = 0;
    build_node(builder, begin, middle);
    node->right = (uint32_t)tree->node_count;
    build_node(builder, middle, end);
}

void triangle_tree_destroy(memory *heap, triangle_tree *tree) {
    memory_release(heap, tree->nodes, (tree->item_count + 1) * sizeof *tree->nodes);
    memory_release(heap, tree->items, tree->item_count * sizeof *tree->items);
    *tree = (triangle_tree){0};
}

bool triangle_tree_build(memory *heap, const check_box *boxes, const uint8_t *kinds, uint8_t kind,
                         size_t count, triangle_tree *tree) {
    *tree = (triangle_tree){0};
    size_t members = 0;
    for (size_t i = 0; i < count; i++) members += kinds[i] == kind;
    if (members == 0) return true;

    tree_builder builder = {.boxes = boxes, .tree = tree};
    tree->item_count = members;
    /* Halving stops at 4 items or fewer, so every leaf has at least 2 unless it is the root. */
    tree->nodes = memory_allocate(heap, (members + 1) * sizeof *tree->nodes);
    tree->items = memory_allocate(heap, members * sizeof *tree->items);
    uint32_t *const orders = memory_allocate(heap, 3 * members * sizeof *orders);
    builder.scratch = memory_allocate(heap, members * sizeof *builder.scratch);
    builder.is_left = memory_allocate(heap, count);
    builder.keys = memory_allocate(heap, 2 * members * sizeof *builder.keys);
    bool const has_memory =
        tree->nodes && tree->items && orders && builder.scratch && builder.is_left && builder.keys;
    if (has_memory) {
        size_t next = 0;
        for (size_t i = 0; i < count; i++)
            if (kinds[i] == kind) tree->items[next++] = (uint32_t)i;
        for (int axis = 0; axis < 3; axis++) {
            for (size_t i = 0; i < members; i++) {
                uint32_t const item = tree->items[i];
                builder.keys[i] = (sort_key){compute_centre(&boxes[item], axis), item};
            }
            const sort_key *const sorted = sort_keys(builder.keys, members);
            builder.order[axis] = orders + (size_t)axis * members;
            for (size_t i = 0; i < members; i++) builder.order[axis][i] = sorted[i].item;
        }
        build_node(&builder, 0, members);
        memcpy(tree->items, builder.order[0], members * sizeof *tree->items);
    }
    memory_release(heap, builder.keys, 2 * members * sizeof *builder.keys);
    memory_release(heap, builder.is_left, count);
    memory_release(heap, builder.scratch, members * sizeof *builder.scratch);
    memory_release(heap, orders, 3 * members * sizeof *orders);
    if (!has_memory) triangle_tree_destroy(heap, tree);
    return has_memory;
}
