/* detect/pairs/search_pairs.c - the search: takes fitted trees, gives all feature pairs whose boxes
 * meet, in batches to a consumer.
 *
 * It starts from the pairs of surfaces that may meet (root_pairs.c) and opens their nodes level by
 * level until there are enough pairs of nodes for all workers. Workers descend from each of those:
 * they open EXPANDED_PAIRS pairs at a time, of the lowest level that has some, so lists stay short
 * and in cache. Of two trees of unequal height, the nodes of the higher one are opened alone at
 * first. */
#include "base/parallel.h"
#include "detect/trees/broad_phase_parts.h"

enum {
    WANTED_TASKS = 384, /* pairs of nodes, enough to share out evenly */
    SPLIT_ROUNDS = 12,  /* levels at most, should most of them end early */
    FEWEST_BLOCKS = 32, /* that a worker keeps */
    LEAVES_A_PLACE = 6  /* of all leaves */
};

/* Opens the last pairs of a list into an empty list, and takes them off. Their nodes belong to the
 * trees of two surfaces and to the given levels, which become the levels of what is found. */
static void open_pairs(const broad_phase *broad, const uint32_t surface[2], uint32_t level[2],
                       node_pairs *from, node_pairs *to) {
    const tree_node *const trees[2] = {broad->trees[surface[0]].nodes.data,
                                       broad->trees[surface[1]].nodes.data};
    size_t const begin = from->count > EXPANDED_PAIRS ? from->count - EXPANDED_PAIRS : 0;
    to->count = 0;
    if (level[0] == level[1]) {
        node_search const search = {.trees = {trees[0], trees[1]},
                                    .label_mask = broad->has_labels ? UINT32_MAX : 0};
        TULLE_PICK_KERNEL(open_node_pairs)
        (&search, from->first + begin, from->second + begin, from->count - begin, to);
        level[0]--;
        level[1]--;
    } else { /* the higher node alone: its children that meet the other node */
        int const side = level[0] > level[1] ? 0 : 1;
        for (size_t i = begin; i < from->count; i++) {
            uint32_t const nodes[2] = {from->first[i], from->second[i]};
            const tree_node *const opened = &trees[side][nodes[side]];
            const float *const box = trees[1 - side][nodes[1 - side]].box;
            for (uint32_t c = 0; c < opened->child_count; c++) {
                float child[6];
                for (int k = 0; k < 6; k++) child[k] = opened->sides[k][c];
                if (!boxes_meet(child, box)) continue;
                to->first[to->count] = side == 0 ? opened->first + c : nodes[0];
                to->second[to->count++] = side == 1 ? opened->first + c : nodes[1];
            }
        }
        level[side]--;
    }
    from->count = begin;
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
static void search_leaves(const search_context *search, bool is_one_tree, node_pairs *leaves,
                          int worker) {
    broad_phase *const broad = search->broad;
    worker_output *const output = &broad->outputs.data[worker];
    leaf_tables const tables = {.fit = broad->fit,
                                .masks = broad->has_masks ? broad->masks.data : NULL,
                                .has_neighbours = broad->method == BROAD_PHASE_REFIT,
                                .is_one_tree = is_one_tree};
    if (broad->has_all_blocks && broad->slabs && broad_phase_is_straight(broad))
        TULLE_PICK_KERNEL(drop_apart_leaves)(broad->slabs, leaves);
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

/* Descends from each task: depth first, one list of pairs a level. */
static void run_tasks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const search_context *const search = context;
    broad_phase *const broad = search->broad;
    node_pairs *const lists = broad->lists.data + (size_t)worker * broad->list_count;
    if (stop_is_wanted(broad->stop, worker)) return;
    for (size_t i = begin; i < end; i++) {
        const search_task *const task = &broad->search_tasks[search->list].data[i];
        uint32_t levels[MOST_LEVELS + 1][2] = {{task->level[0], task->level[1]}};
        lists[0].first[0] = task->node[0];
        lists[0].second[0] = task->node[1];
        lists[0].count = 1;
        for (size_t depth = 0;;) {
            if (lists[depth].count == 0) {
                if (depth-- == 0) break;
                continue;
            }
            if (atomic_load_explicit(&broad->is_crowded, memory_order_relaxed)) return;
            levels[depth + 1][0] = levels[depth][0];
            levels[depth + 1][1] = levels[depth][1];
            open_pairs(broad, task->surface, levels[depth + 1], &lists[depth], &lists[depth + 1]);
            if (levels[depth + 1][0] == 0)
                search_leaves(search, task->surface[0] == task->surface[1], &lists[depth + 1],
                              worker);
            else
                depth++;
        }
    }
}

/* Makes room for the lists, outputs and caches of the workers, and empties them. */
static bool prepare_workers(broad_phase *broad, int threads) {
    size_t most_levels = 0;
    for (size_t s = 0; s < broad->surface_count; s++)
        if (broad->trees[s].level_count > most_levels) most_levels = broad->trees[s].level_count;
    /* a list for each level and the leaves; voxel trees come to have some levels more or fewer */
    broad->list_count = most_levels + (broad->method == BROAD_PHASE_REFIT ? 1 : 4);
    broad->outputs.count = broad->lists.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->outputs, (size_t)threads) ||
        !ARRAY_RESERVE(broad->heap, &broad->lists, (size_t)threads * broad->list_count))
        return false;
    for (int w = 0; w < threads; w++) {
        worker_output *const output = &broad->outputs.data[w];
        output->counts = (search_counts){0};
        for (int kind = 0; kind < 2; kind++) {
            output->batches[kind].kind = (feature_kind)kind;
            output->batches[kind].count = 0;
        }
    }
    if (broad->has_all_blocks) return true;

    /* Where there are few leaves, caches have fewer places. Room for the block of any leaf is an
     * odd number of cache lines, so that blocks are spread over all parts of a cache. */
    uint32_t place_count = KEPT_BLOCKS;
    size_t const leaf_count = broad->triangle_count / LEAF_TRIANGLES;
    while (place_count > FEWEST_BLOCKS && place_count > leaf_count / LEAVES_A_PLACE)
        place_count /= 2;
    if (broad->block_stride == 0 || broad->method != BROAD_PHASE_REFIT) {
        uint32_t most_groups = 0;
        for (size_t s = 0; s < broad->surface_count; s++) {
            const tree_leaf *const leaves = broad->leaves + broad->trees[s].leaf_begin;
            for (size_t l = 0; l < broad->trees[s].leaf_count; l++) {
                uint32_t const groups = count_groups(&leaves[l]);
                if (groups > most_groups) most_groups = groups;
            }
        }
        broad->block_stride = LEAF_HEADER + GROUP_FLOATS * (size_t)most_groups;
    }
    size_t const size = (place_count + 1) * broad->block_stride;
    broad->kept_blocks.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->kept_blocks, (size_t)threads * size)) return false;
    for (int w = 0; w < threads; w++) {
        leaf_cache *const cache = &broad->outputs.data[w].cache;
        cache->blocks = broad->kept_blocks.data + (size_t)w * size;
        cache->stride = broad->block_stride;
        cache->place_count = place_count;
        for (size_t i = 0; i < place_count; i++) cache->leaves[i] = UINT32_MAX;
    }
    return true;
}

tulle_status search_pairs(broad_phase *broad, const surface_set *set, int threads,
                          pair_consumer consume, void *context, search_counts *counts) {
    if (!broad->is_built || set->surface_count != broad->surface_count)
        return TULLE_ERROR_INVALID_ARGUMENT;
    if (threads < 1) threads = 1;
    if (!prepare_workers(broad, threads) || !list_root_pairs(broad, set))
        return TULLE_ERROR_OUT_OF_MEMORY;

    /* Split all tasks, level by level, until there are enough; those of lowest nodes stay. */
    node_pairs *const opened = &broad->lists.data[0], *const found = &broad->lists.data[1];
    int list = 0;
    for (int round = 0; round < SPLIT_ROUNDS; round++) {
        size_t const count = broad->search_tasks[list].count;
        if (count == 0 || count >= WANTED_TASKS) break;
        broad->search_tasks[1 - list].count = 0;
        for (size_t i = 0; i < count; i++) {
            search_task task = broad->search_tasks[list].data[i];
            bool const is_lowest = task.level[0] <= 1 && task.level[1] <= 1;
            node_pairs *const own = is_lowest ? found : opened;
            own->first[0] = task.node[0];
            own->second[0] = task.node[1];
            own->count = 1;
            if (!is_lowest) open_pairs(broad, task.surface, task.level, opened, found);
            if (!ARRAY_RESERVE(broad->heap, &broad->search_tasks[1 - list], found->count))
                return TULLE_ERROR_OUT_OF_MEMORY;
            for (size_t k = 0; k < found->count; k++) {
                task.node[0] = found->first[k];
                task.node[1] = found->second[k];
                broad->search_tasks[1 - list].data[broad->search_tasks[1 - list].count++] = task;
            }
        }
        list = 1 - list;
    }

    search_context search = {broad, list, consume, context};
    atomic_store(&broad->is_crowded, false);
    parallel_for(broad->search_tasks[list].count, 1, threads, run_tasks, &search);
    search_counts total = {0};
    for (int w = 0; w < threads; w++) {
        for (int kind = 0; kind < 2; kind++) send_batch(&search, w, kind);
        total.leaf_pair_count += broad->outputs.data[w].counts.leaf_pair_count;
        total.candidate_count += broad->outputs.data[w].counts.candidate_count;
    }
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (surface_meets_itself(set, s)) total.near_pair_count += broad->trees[s].near_pair_count;
    if (counts) *counts = total;
    return stop_is_wanted(broad->stop, 0) ? TULLE_ERROR_INTERRUPTED : TULLE_OK;
}
