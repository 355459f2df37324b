/* detect/find_pairs.c - stage 7: takes fitted trees, gives all feature pairs whose boxes meet.
 *
 * Starts from the pairs of surfaces that may meet, splits their nodes until there are enough pairs
 * of nodes for all workers, and descends from each of those. What a worker finds goes to its
 * writer; sorting makes the list the same for any method and number of threads. */
#include "base/parallel.h"
#include "detect/broad_phase_parts.h"

enum {
    WANTED_TASKS = 512, /* pairs of nodes, enough to share out evenly */
    SPLIT_ROUNDS = 12   /* levels at most, should most of them end early */
};

static const tree_node *node_at(const broad_phase *broad, uint32_t surface, uint32_t node) {
    return &broad->trees[surface].nodes.data[node];
}

static const tree_leaf *leaf_at(const broad_phase *broad, uint32_t surface, const tree_node *node) {
    return &broad->leaves[broad->trees[surface].leaf_begin + node->first];
}

/* Of two nodes the inner one, or the one with the longer box, is opened. */
static bool opens_first(const tree_node *a, const tree_node *b) {
    if (a->child_count == 0 || b->child_count == 0) return b->child_count == 0;
    float extent_a = 0.0F, extent_b = 0.0F;
    for (int k = 0; k < 3; k++) {
        extent_a += a->box.high[k] - a->box.low[k];
        extent_b += b->box.high[k] - b->box.low[k];
    }
    return extent_a >= extent_b;
}

/* Labels differ between surfaces. */
static bool is_within_patch(const tree_node *a, const tree_node *b) {
    return a->label != 0 && a->label == b->label;
}

/* Recursion is as deep as both trees together. */
static void descend_pair(const leaf_search *search, node_pair pair) {
    const tree_node *const a = node_at(search->broad, pair.surface[0], pair.node[0]);
    const tree_node *const b = node_at(search->broad, pair.surface[1], pair.node[1]);
    if (is_within_patch(a, b)) return;
    if (a->child_count == 0 && b->child_count == 0) {
        search_leaf_pair(search, leaf_at(search->broad, pair.surface[0], a), &a->box,
                         leaf_at(search->broad, pair.surface[1], b), &b->box);
        return;
    }
    int const opened = opens_first(a, b) ? 0 : 1;
    const tree_node *const parent = opened == 0 ? a : b, *const other = opened == 0 ? b : a;
    for (uint32_t c = 0; c < parent->child_count; c++) {
        node_pair child = pair;
        child.node[opened] = parent->first + c;
        const tree_node *const node =
            node_at(search->broad, pair.surface[opened], child.node[opened]);
        if (boxes_meet(&node->box, &other->box)) descend_pair(search, child);
    }
}

static void descend_self(const leaf_search *search, uint32_t surface, uint32_t index) {
    const tree_node *const node = node_at(search->broad, surface, index);
    if (node->label != 0) return;
    if (node->child_count == 0) {
        search_leaf(search, leaf_at(search->broad, surface, node), &node->box);
        return;
    }
    for (uint32_t i = node->first; i < node->first + node->child_count; i++) {
        const tree_node *const child = node_at(search->broad, surface, i);
        descend_self(search, surface, i);
        for (uint32_t j = i + 1; j < node->first + node->child_count; j++)
            if (boxes_meet(&child->box, &node_at(search->broad, surface, j)->box))
                descend_pair(search, (node_pair){{surface, surface}, {i, j}});
    }
}

static bool is_self(const node_pair *pair) {
    return pair->surface[0] == pair->surface[1] && pair->node[0] == pair->node[1];
}

static bool append_pair(broad_phase *broad, int list, uint32_t surface_a, uint32_t node_a,
                        uint32_t surface_b, uint32_t node_b) {
    const tree_node *const a = node_at(broad, surface_a, node_a);
    const tree_node *const b = node_at(broad, surface_b, node_b);
    if (!boxes_meet(&a->box, &b->box) || is_within_patch(a, b)) return true;
    if (!ARRAY_RESERVE(broad->heap, &broad->node_pairs[list], 1)) return false;
    broad->node_pairs[list].data[broad->node_pairs[list].count++] =
        (node_pair){{surface_a, surface_b}, {node_a, node_b}};
    return true;
}

static bool may_meet(const surface_set *set, uint32_t a, uint32_t b) {
    const surface_range *const first = &set->surfaces[a], *const second = &set->surfaces[b];
    if (a == b && (first->is_obstacle || first->ignores_self)) return false;
    if (first->is_obstacle && second->is_obstacle) return false;
    return !set->collides || set->collides[a * set->surface_count + b];
}

/* Roots of the surfaces that may meet. */
static bool append_roots(broad_phase *broad, const surface_set *set) {
    for (uint32_t a = 0; a < set->surface_count; a++) {
        if (!set->surfaces[a].is_present || broad->trees[a].nodes.count == 0) continue;
        uint32_t const root = (uint32_t)broad->trees[a].nodes.count - 1;
        for (uint32_t b = a; b < set->surface_count; b++) {
            if (!set->surfaces[b].is_present || broad->trees[b].nodes.count == 0) continue;
            if (!may_meet(set, a, b)) continue;
            uint32_t const other = (uint32_t)broad->trees[b].nodes.count - 1;
            if (!append_pair(broad, 0, a, root, b, other)) return false;
        }
    }
    return true;
}

/* Replaces a pair of list `from` by pairs of children in the other list. */
static bool split_pair(broad_phase *broad, node_pair pair, int to) {
    const tree_node *const a = node_at(broad, pair.surface[0], pair.node[0]);
    const tree_node *const b = node_at(broad, pair.surface[1], pair.node[1]);
    uint32_t const sa = pair.surface[0], sb = pair.surface[1];
    if (a->child_count == 0 && b->child_count == 0)
        return append_pair(broad, to, sa, pair.node[0], sb, pair.node[1]);
    if (is_self(&pair)) {
        for (uint32_t i = 0; i < a->child_count; i++)
            for (uint32_t j = i; j < a->child_count; j++)
                if (!append_pair(broad, to, sa, a->first + i, sa, a->first + j)) return false;
        return true;
    }
    bool const opens_a = opens_first(a, b);
    const tree_node *const parent = opens_a ? a : b;
    for (uint32_t c = 0; c < parent->child_count; c++)
        if (!append_pair(broad, to, sa, opens_a ? a->first + c : pair.node[0], sb,
                         opens_a ? pair.node[1] : b->first + c))
            return false;
    return true;
}

/* Splits all pairs, level by level, until there are enough. Returns the list that holds them, or -1
 * when memory is short. */
static int split_tasks(broad_phase *broad, const surface_set *set) {
    int list = 0;
    broad->node_pairs[0].count = 0;
    if (!append_roots(broad, set)) return -1;
    for (int round = 0; round < SPLIT_ROUNDS; round++) {
        size_t const count = broad->node_pairs[list].count;
        if (count == 0 || count >= WANTED_TASKS) break;
        broad->node_pairs[1 - list].count = 0;
        for (size_t i = 0; i < count; i++)
            if (!split_pair(broad, broad->node_pairs[list].data[i], 1 - list)) return -1;
        list = 1 - list;
    }
    return list;
}

typedef struct search_context {
    broad_phase *broad;
    int list;
    bool counts_box_pairs;
} search_context;

static void search_task(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const search_context *const search = context;
    leaf_search const leaves = {.broad = search->broad,
                                .output = &search->broad->outputs.data[worker],
                                .counts_box_pairs = search->counts_box_pairs};
    for (size_t i = begin; i < end; i++) {
        node_pair const pair = search->broad->node_pairs[search->list].data[i];
        if (is_self(&pair))
            descend_self(&leaves, pair.surface[0], pair.node[0]);
        else
            descend_pair(&leaves, pair);
    }
}

static void start_worker(worker_output *output, const pair_tables *tables, pair_consumer consume,
                         void *context, int worker) {
    output->consume = consume;
    output->context = context;
    output->tables = tables;
    output->worker = worker;
    output->candidate_count = output->leaf_pair_count = output->box_pair_count = 0;
    for (int kind = 0; kind < 2; kind++) {
        output->batches[kind].kind = (feature_kind)kind;
        output->batches[kind].count = 0;
    }
}

static tulle_status search_all(broad_phase *broad, const surface_set *set, int threads,
                               pair_consumer consume, void *consumer_context,
                               uint64_t *box_pair_count, search_counts *counts) {
    *counts = (search_counts){0};
    if (!broad->is_built || set->surface_count != broad->surface_count)
        return TULLE_ERROR_INVALID_ARGUMENT;
    broad->outputs.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->outputs, (size_t)threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    search_context search = {.broad = broad, .counts_box_pairs = box_pair_count != NULL};
    search.list = split_tasks(broad, set);
    if (search.list < 0) return TULLE_ERROR_OUT_OF_MEMORY;
    for (int w = 0; w < threads; w++)
        start_worker(&broad->outputs.data[w], &broad->tables, consume, consumer_context, w);
    parallel_for(broad->node_pairs[search.list].count, 1, threads, search_task, &search);
    if (box_pair_count) *box_pair_count = 0;
    for (int w = 0; w < threads; w++) {
        worker_output *const output = &broad->outputs.data[w];
        finish_batches(output);
        counts->leaf_pair_count += output->leaf_pair_count;
        counts->candidate_count += output->candidate_count;
        if (box_pair_count) *box_pair_count += output->box_pair_count;
    }
    return TULLE_OK;
}

tulle_status search_pairs(broad_phase *broad, const surface_set *set, int threads,
                          pair_consumer consume, void *context, search_counts *counts) {
    search_counts unused;
    return search_all(broad, set, threads < 1 ? 1 : threads, consume, context, NULL,
                      counts ? counts : &unused);
}

/* ---- the sorted list ---- */

static void store_batch(void *context, const pair_tables *tables, const pair_batch *batch,
                        int worker) {
    pair_writer *const writers = context;
    pair_writer *const writer = &writers[2 * worker + (int)batch->kind];
    for (size_t begin = 0; begin < batch->count; begin += KEY_BLOCK) {
        size_t const left = batch->count - begin, count = left < KEY_BLOCK ? left : KEY_BLOCK;
        pair_writer_make_room(writer, count);
        for (size_t i = begin; i < begin + count; i++) {
            feature_pair const pair = pair_batch_get(tables, batch, i);
            pair_writer_add_if(writer, pair.first, pair.second, 1);
        }
    }
}

/* One search; what does not fit into the stores is only counted. */
static tulle_status store_all(broad_phase *broad, const surface_set *set, int threads,
                              uint64_t *box_pair_count) {
    search_counts counts;
    pair_writer *const writers = broad->writers.data;
    for (int kind = 0; kind < 2; kind++) pair_store_clear(&broad->stores[kind]);
    for (int w = 0; w < 2 * threads; w++) pair_writer_start(&writers[w], &broad->stores[w % 2]);
    tulle_status const status =
        search_all(broad, set, threads, store_batch, writers, box_pair_count, &counts);
    for (int w = 0; w < 2 * threads; w++) pair_writer_finish(&writers[w]);
    return status;
}

static bool reserve_results(broad_phase *broad, pair_list *pairs) {
    for (int kind = 0; kind < 2; kind++)
        if (!pair_store_reserve_sorting(broad->heap, &broad->stores[kind])) return false;
    return ARRAY_RESERVE(broad->heap, &pairs->vertex_triangle,
                         broad->stores[FEATURE_VERTEX_TRIANGLE].keys.capacity) &&
           ARRAY_RESERVE(broad->heap, &pairs->edge_edge,
                         broad->stores[FEATURE_EDGE_EDGE].keys.capacity);
}

tulle_status find_pairs(broad_phase *broad, const surface_set *set, int threads, pair_list *pairs,
                        uint64_t *box_pair_count) {
    pairs->vertex_triangle.count = pairs->edge_edge.count = 0;
    if (threads < 1) threads = 1;
    broad->writers.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->writers, 2 * (size_t)threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    bool is_complete = false;
    while (!is_complete) {
        tulle_status status = store_all(broad, set, threads, box_pair_count);
        if (status != TULLE_OK) return status;
        is_complete = true;
        for (int kind = 0; kind < 2; kind++) {
            if (!pair_store_is_complete(broad->heap, &broad->stores[kind], &status))
                is_complete = false;
            if (status != TULLE_OK) return status;
        }
    }
    if (!reserve_results(broad, pairs)) return TULLE_ERROR_OUT_OF_MEMORY;
    pairs->vertex_triangle.count = pair_store_sort(&broad->stores[FEATURE_VERTEX_TRIANGLE], threads,
                                                   pairs->vertex_triangle.data);
    pairs->edge_edge.count =
        pair_store_sort(&broad->stores[FEATURE_EDGE_EDGE], threads, pairs->edge_edge.data);
    return TULLE_OK;
}
