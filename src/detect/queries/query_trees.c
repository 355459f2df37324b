/* detect/queries/query_trees.c - see query_trees.h. */
#include "detect/queries/query_trees.h"

#include "base/parallel.h"
#include "detect/trees/tree_shape.h"

#include <math.h>
#include <string.h>

enum {
    NODES_PER_CHUNK = 32, /* some 200 leaves, some 20 microseconds */
    STACK_ROOM = 96       /* 2^28 leaves have ten levels, each leaves at most seven behind */
};

/* Children of the lowest nodes: so many that all nodes above have eight, but for the root. */
static uint32_t choose_low_children(uint32_t leaf_count) {
    uint32_t children = leaf_count;
    while (children > QUERY_LANES) children /= 2;
    return children;
}

/* Nodes of a tree; with `nodes` also sets their children. */
static uint32_t lay_nodes(uint32_t leaf_count, query_node *nodes) {
    if (leaf_count == 0) return 0;
    uint32_t first = 0, left = leaf_count, children = choose_low_children(leaf_count), count = 0;
    do {
        uint32_t const level = count;
        for (uint32_t i = 0; i < left; i += children, count++) {
            if (!nodes) continue;
            nodes[count].first = first + i;
            nodes[count].child_count = children;
        }
        first = level;
        left /= children;
        children = left < QUERY_LANES ? left : QUERY_LANES;
    } while (left > 1);
    return count;
}

bool query_trees_make(query_trees *trees, memory *heap, const surface_set *set,
                      const broad_phase *broad, const double *rest, size_t triangle_count) {
    *trees = (query_trees){.surface_count = set->surface_count};
    for (size_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        trees->node_count +=
            lay_nodes(choose_leaf_count(range->triangle_end - range->triangle_begin), NULL);
    }
    trees->trees = memory_allocate_zeroed(heap, trees->surface_count, sizeof *trees->trees);
    trees->nodes = memory_allocate_zeroed(heap, trees->node_count, sizeof *trees->nodes);
    trees->order = memory_allocate(heap, triangle_count * sizeof *trees->order);
    if (!trees->trees || !trees->nodes || !trees->order) {
        query_trees_destroy(trees, heap, triangle_count);
        return false;
    }
    const uint32_t *const known = broad_phase_get_order(broad);
    query_node *nodes = trees->nodes;
    for (size_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        query_tree *const tree = &trees->trees[s];
        tree->count = range->triangle_end - range->triangle_begin;
        tree->order = trees->order + range->triangle_begin;
        tree->leaf_count = choose_leaf_count(tree->count);
        tree->nodes = nodes;
        tree->node_count = lay_nodes(tree->leaf_count, nodes);
        if (tree->count == 0) continue;
        tree->low_count = tree->leaf_count / choose_low_children(tree->leaf_count);
        nodes += tree->node_count;
        if (known) {
            memcpy(tree->order, known + range->triangle_begin, tree->count * sizeof *tree->order);
        } else if (!order_triangles(heap, tree->order, range, tree->leaf_count,
                                    set->topo->triangles, rest)) {
            query_trees_destroy(trees, heap, triangle_count);
            return false;
        }
    }
    return true;
}

void query_trees_destroy(query_trees *trees, memory *heap, size_t triangle_count) {
    memory_release(heap, trees->trees, trees->surface_count * sizeof *trees->trees);
    memory_release(heap, trees->nodes, trees->node_count * sizeof *trees->nodes);
    memory_release(heap, trees->order, triangle_count * sizeof *trees->order);
    *trees = (query_trees){0};
}

/* ---- fitting ---- */

static void clear_boxes(query_node *node) {
    for (int k = 0; k < 3; k++)
        for (uint32_t c = 0; c < QUERY_LANES; c++) {
            node->low[k][c] = (double)INFINITY;
            node->high[k][c] = -(double)INFINITY;
        }
}

typedef struct fit_context {
    query_tree *tree;
    const uint32_t *corners; /* of all triangles */
    const double *positions;
} fit_context;

static void fit_low_nodes(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fit_context *const fit = context;
    const query_tree *const tree = fit->tree;
    for (size_t n = begin; n < end; n++) {
        query_node *const node = &tree->nodes[n];
        clear_boxes(node);
        for (uint32_t c = 0; c < node->child_count; c++) {
            size_t const leaf = node->first + c;
            size_t const last = tree->count * (leaf + 1) / tree->leaf_count;
            for (size_t i = tree->count * leaf / tree->leaf_count; i < last; i++) {
                const uint32_t *const corners = fit->corners + 3 * (size_t)tree->order[i];
                for (int corner = 0; corner < 3; corner++) {
                    const double *const x = fit->positions + 3 * (size_t)corners[corner];
                    for (int k = 0; k < 3; k++) {
                        if (x[k] < node->low[k][c]) node->low[k][c] = x[k];
                        if (x[k] > node->high[k][c]) node->high[k][c] = x[k];
                    }
                }
            }
        }
    }
}

static void fit_high_nodes(query_tree *tree) {
    for (uint32_t n = tree->low_count; n < tree->node_count; n++) {
        query_node *const node = &tree->nodes[n];
        clear_boxes(node);
        for (uint32_t c = 0; c < node->child_count; c++) {
            const query_node *const child = &tree->nodes[node->first + c];
            for (int k = 0; k < 3; k++)
                for (uint32_t i = 0; i < child->child_count; i++) {
                    if (child->low[k][i] < node->low[k][c]) node->low[k][c] = child->low[k][i];
                    if (child->high[k][i] > node->high[k][c]) node->high[k][c] = child->high[k][i];
                }
        }
    }
}

void query_trees_fit(query_trees *trees, const surface_set *set, const double *positions,
                     int threads) {
    for (size_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        query_tree *const tree = &trees->trees[s];
        if (!range->is_present || (range->is_static && tree->is_fitted)) continue;
        fit_context context = {tree, set->topo->triangles, positions};
        parallel_for(tree->low_count, NODES_PER_CHUNK, threads, fit_low_nodes, &context);
        fit_high_nodes(tree);
        tree->is_fitted = true;
    }
}

/* ---- visiting ---- */

typedef struct waiting_node {
    double distance;
    uint32_t node;
} waiting_node;

static void visit_leaf(const query_tree *tree, tree_query *query, size_t leaf) {
    size_t const end = tree->count * (leaf + 1) / tree->leaf_count;
    for (size_t i = tree->count * leaf / tree->leaf_count; i < end; i++)
        query->visit(query, tree->order[i]);
}

void query_tree_visit(const query_tree *tree, tree_query *query) {
    if (tree->node_count == 0) return;
    waiting_node stack[STACK_ROOM];
    size_t count = 1;
    stack[0] = (waiting_node){-(double)INFINITY, tree->node_count - 1};
    while (count > 0) {
        waiting_node const next = stack[--count];
        if (next.distance > query->reach) continue;
        const query_node *const node = &tree->nodes[next.node];
        double distances[QUERY_LANES];
        query->measure(query, node, distances);
        /* the children within reach, the farthest first */
        waiting_node *const children = stack + count;
        size_t child_count = 0;
        for (uint32_t c = 0; c < node->child_count; c++) {
            if (!(distances[c] <= query->reach) || distances[c] == (double)INFINITY) continue;
            size_t at = child_count++;
            for (; at > 0 && children[at - 1].distance < distances[c]; at--)
                children[at] = children[at - 1];
            children[at] = (waiting_node){distances[c], node->first + c};
        }
        if (next.node >= tree->low_count) {
            count += child_count;
            continue;
        }
        while (child_count-- > 0)
            if (children[child_count].distance <= query->reach)
                visit_leaf(tree, query, children[child_count].node);
    }
}
