/* detect/pairs/search_pairs.c - stage 7: takes fitted trees, gives all feature pairs whose boxes
 * meet, in batches to a consumer.
 *
 * Starts from the pairs of surfaces that may meet (root_pairs.c), opens their nodes level by level
 * until there are enough pairs of nodes for all workers, and descends from each of those:
 * EXPANDED_PAIRS pairs of the lowest level that has some are opened at a time, so lists stay short
 * and in cache. Of two trees of unequal height the nodes of the higher one are opened alone at
 * first. */
#include "base/parallel.h"
#include "detect/trees/broad_phase_parts.h"

enum {
    WANTED_TASKS = 384, /* pairs of nodes, enough to share out evenly */
    SPLIT_ROUNDS = 12,  /* levels at most, should most of them end early */
    FEWEST_BLOCKS = 32, /* that a worker keeps */
    LEAVES_A_PLACE = 6  /* of all leaves */
};

/* Two trees whose pairs of nodes are opened. */
typedef struct tree_pair {
    const broad_phase *broad;
    const tree_node *trees[2];
    bool is_one_tree;
} tree_pair;

static tree_pair make_tree_pair(const broad_phase *broad, const uint32_t surface[2]) {
    return (tree_pair){
        .broad = broad,
        .trees = {broad->trees[surface[0]].nodes.data, broad->trees[surface[1]].nodes.data},
        .is_one_tree = surface[0] == surface[1]};
}

/* Side k of lane l of a node. */
static bool lane_meets(const tree_node *node, uint32_t lane, const float box[6]) {
    float child[6];
    for (int k = 0; k < 6; k++) child[k] = node->sides[k][lane];
    return boxes_meet(child, box);
}

/* Opens one side only: the children of one node that meet the other node. */
static void open_one_side(const tree_pair *pair, int side, const node_pairs *from, size_t begin,
                          node_pairs *to) {
    for (size_t i = begin; i < from->count; i++) {
        const uint32_t nodes[2] = {from->first[i], from->second[i]};
        const tree_node *const opened = &pair->trees[side][nodes[side]];
        const float *const box = pair->trees[1 - side][nodes[1 - side]].box;
        for (uint32_t c = 0; c < opened->child_count; c++) {
            if (!lane_meets(opened, c, box)) continue;
            to->first[to->count] = side == 0 ? opened->first + c : nodes[0];
            to->second[to->count++] = side == 1 ? opened->first + c : nodes[1];
        }
    }
}

/* Opens the last pairs of a list, whose nodes are of the given levels, into an empty list, and
 * takes them off. */
static void open_pairs(const tree_pair *pair, const uint32_t level[2], node_pairs *from,
                       node_pairs *to) {
    size_t const begin = from->count > EXPANDED_PAIRS ? from->count - EXPANDED_PAIRS : 0;
    to->count = 0;
    if (level[0] != level[1]) {
        open_one_side(pair, level[0] > level[1] ? 0 : 1, from, begin, to);
    } else {
        node_search const search = {.trees = {pair->trees[0], pair->trees[1]},
                                    .label_mask = pair->broad->has_labels ? UINT32_MAX : 0};
        TULLE_PICK_KERNEL(open_node_pairs)
        (&search, from->first + begin, from->second + begin, from->count - begin, to);
    }
    from->count = begin;
}

/* Levels of the pairs that come of opening. */
static void lower_levels(uint32_t level[2]) {
    uint32_t const a = level[0], b = level[1];
    if (a >= b) level[0]--;
    if (b >= a) level[1]--;
}

/* Replaces a task by tasks of children, in the other list. */
static bool split_task(broad_phase *broad, const search_task *task, int to) {
    node_pairs *const from = &broad->lists.data[0], *const found = &broad->lists.data[1];
    tree_pair const pair = make_tree_pair(broad, task->surface);
    from->first[0] = task->node[0];
    from->second[0] = task->node[1];
    from->count = 1;
    search_task child = *task;
    open_pairs(&pair, task->level, from, found);
    lower_levels(child.level);
    if (!ARRAY_RESERVE(broad->heap, &broad->search_tasks[to], found->count)) return false;
    for (size_t i = 0; i < found->count; i++) {
        child.node[0] = found->first[i];
        child.node[1] = found->second[i];
        broad->search_tasks[to].data[broad->search_tasks[to].count++] = child;
    }
    return true;
}

/* Splits all tasks, level by level, until there are enough; those of lowest nodes stay. Returns the
 * list that holds them, or -1 when memory is short. */
static int split_tasks(broad_phase *broad, const surface_set *set) {
    int list = 0;
    broad->search_tasks[0].count = 0;
    if (!append_roots(broad, set)) return -1;
    for (int round = 0; round < SPLIT_ROUNDS; round++) {
        size_t const count = broad->search_tasks[list].count;
        if (count == 0 || count >= WANTED_TASKS) break;
        broad->search_tasks[1 - list].count = 0;
        for (size_t i = 0; i < count; i++) {
            search_task const task = broad->search_tasks[list].data[i];
            if (task.level[0] > 1 || task.level[1] > 1) {
                if (!split_task(broad, &task, 1 - list)) return -1;
                continue;
            }
            if (!ARRAY_RESERVE(broad->heap, &broad->search_tasks[1 - list], 1)) return -1;
            broad->search_tasks[1 - list].data[broad->search_tasks[1 - list].count++] = task;
        }
        list = 1 - list;
    }
    return list;
}

typedef struct search_context {
    broad_phase *broad;
    int list;
    pair_consumer consume;
    void *context;
} search_context;

/* Hands a batch to the consumer and empties it. */
static void send_batch(const search_context *search, int worker, int kind) {
    worker_output *const output = &search->broad->outputs.data[worker];
    pair_batch *const batch = &output->batches[kind];
    output->counts.candidate_count += batch->count;
    if (batch->count > 0) search->consume(search->context, &search->broad->tables, batch, worker);
    batch->count = 0;
}

/* All feature pairs of a list of leaf pairs. */
static void search_leaves(const search_context *search, const tree_pair *pair, node_pairs *leaves,
                          int worker) {
    broad_phase *const broad = search->broad;
    worker_output *const output = &broad->outputs.data[worker];
    leaf_tables const tables = {
        .fit = make_leaf_fit(broad), .masks = broad->masks.data, .is_one_tree = pair->is_one_tree};
    if (find_slabs(broad)) TULLE_PICK_KERNEL(drop_apart_leaves)(find_slabs(broad), leaves);
    output->counts.leaf_pair_count += leaves->count;
    for (size_t done = 0; done < leaves->count;) {
        done =
            TULLE_PICK_KERNEL(pair_leaves)(&tables, &output->cache, leaves, done, output->batches);
        if (done == leaves->count) break;
        for (int kind = 0; kind < 2; kind++)
            if (output->batches[kind].count > PAIR_BATCH_SIZE - LEAF_PAIR_ROOM)
                send_batch(search, worker, kind);
    }
}

static void run_task(const search_context *search, const search_task *task, int worker) {
    broad_phase *const broad = search->broad;
    tree_pair const pair = make_tree_pair(broad, task->surface);
    node_pairs *const lists = broad->lists.data + (size_t)worker * broad->list_count;
    uint32_t levels[MOST_LEVELS + 1][2] = {{task->level[0], task->level[1]}};
    lists[0].first[0] = task->node[0];
    lists[0].second[0] = task->node[1];
    lists[0].count = 1;
    for (size_t depth = 0;;) {
        if (lists[depth].count == 0) {
            if (depth-- == 0) break;
            continue;
        }
        open_pairs(&pair, levels[depth], &lists[depth], &lists[depth + 1]);
        levels[depth + 1][0] = levels[depth][0];
        levels[depth + 1][1] = levels[depth][1];
        lower_levels(levels[depth + 1]);
        if (levels[depth + 1][0] == 0)
            search_leaves(search, &pair, &lists[depth + 1], worker);
        else
            depth++;
    }
}

static void run_tasks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const search_context *const search = context;
    if (stop_is_wanted_by(search->broad->stop, worker)) return;
    for (size_t i = begin; i < end; i++)
        run_task(search, &search->broad->search_tasks[search->list].data[i], worker);
}

/* [floats] Room for the block of any leaf: an odd number of cache lines, so that blocks are spread
 * over all parts of a cache. */
static size_t find_block_stride(const broad_phase *broad) {
    uint32_t most = 0;
    for (size_t s = 0; s < broad->surface_count; s++) {
        const surface_tree *const tree = &broad->trees[s];
        for (size_t l = 0; l < tree->leaf_count; l++) {
            uint32_t const count = count_groups(&broad->leaves[tree->leaf_begin + l]);
            most = count > most ? count : most;
        }
    }
    return LEAF_HEADER + GROUP_FLOATS * (size_t)most;
}

/* Places of a cache: fewer where there are few leaves. */
static uint32_t find_place_count(const broad_phase *broad) {
    size_t const leaves = broad->triangle_count / LEAF_TRIANGLES;
    uint32_t count = KEPT_BLOCKS;
    while (count > FEWEST_BLOCKS && count > leaves / LEAVES_A_PLACE) count /= 2;
    return count;
}

static bool reserve_caches(broad_phase *broad, int threads) {
    if (broad->has_all_blocks) return true;
    if (broad->block_stride == 0 || broad->method != BROAD_PHASE_REFIT)
        broad->block_stride = find_block_stride(broad);
    uint32_t const place_count = find_place_count(broad);
    size_t const stride = broad->block_stride, size = (place_count + 1) * stride;
    broad->kept_blocks.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->kept_blocks, (size_t)threads * size)) return false;
    for (int w = 0; w < threads; w++) {
        leaf_cache *const cache = &broad->outputs.data[w].cache;
        cache->blocks = broad->kept_blocks.data + (size_t)w * size;
        cache->stride = stride;
        cache->place_count = place_count;
        for (size_t i = 0; i < place_count; i++) cache->leaves[i] = UINT32_MAX;
    }
    return true;
}

/* Lists and outputs of the workers. */
static bool reserve_workers(broad_phase *broad, int threads) {
    size_t most_levels = 0;
    for (size_t s = 0; s < broad->surface_count; s++)
        if (broad->trees[s].level_count > most_levels) most_levels = broad->trees[s].level_count;
    /* a list for each level and the leaves; voxel trees come to have some levels more or fewer */
    broad->list_count = most_levels + (broad->method == BROAD_PHASE_REFIT ? 1 : 4);
    broad->outputs.count = broad->lists.count = 0;
    return ARRAY_RESERVE(broad->heap, &broad->outputs, (size_t)threads) &&
           ARRAY_RESERVE(broad->heap, &broad->lists, (size_t)threads * broad->list_count);
}

tulle_status search_pairs(broad_phase *broad, const surface_set *set, int threads,
                          pair_consumer consume, void *context, search_counts *counts) {
    if (!broad->is_built || set->surface_count != broad->surface_count)
        return TULLE_ERROR_INVALID_ARGUMENT;
    if (threads < 1) threads = 1;
    if (!reserve_workers(broad, threads) || !reserve_caches(broad, threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    search_context search = {.broad = broad, .consume = consume, .context = context};
    search.list = split_tasks(broad, set);
    if (search.list < 0) return TULLE_ERROR_OUT_OF_MEMORY;
    for (int w = 0; w < threads; w++) {
        worker_output *const output = &broad->outputs.data[w];
        output->counts = (search_counts){0};
        for (int kind = 0; kind < 2; kind++) {
            output->batches[kind].kind = (feature_kind)kind;
            output->batches[kind].count = 0;
        }
    }
    parallel_for(broad->search_tasks[search.list].count, 1, threads, run_tasks, &search);
    search_counts total = {0};
    for (int w = 0; w < threads; w++) {
        for (int kind = 0; kind < 2; kind++) send_batch(&search, w, kind);
        total.leaf_pair_count += broad->outputs.data[w].counts.leaf_pair_count;
        total.candidate_count += broad->outputs.data[w].counts.candidate_count;
    }
    for (uint32_t s = 0; s < set->surface_count; s++) {
        if (set->surfaces[s].is_present && surfaces_may_meet(set, s, s))
            total.near_pair_count += broad->trees[s].near_pair_count;
    }
    if (counts) *counts = total;
    return stop_is_wanted(broad->stop) ? TULLE_ERROR_INTERRUPTED : TULLE_OK;
}
