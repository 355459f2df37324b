/* detect/pairs/find_pairs.c - the candidates as a list: takes fitted trees, gives all feature pairs
 * whose boxes meet. Each worker of the search writes into blocks of its own in the stores; sorting
 * makes the list the same for any number of threads. */
#include "base/parallel.h"
#include "detect/trees/broad_phase_parts.h"

enum { SPARE_BLOCKS = 16 /* beyond what is needed */ };

/* A pair_consumer; context: the broad phase. */
static void write_pairs(void *context, const pair_tables *tables, const pair_batch *batch,
                        int worker) {
    broad_phase *const broad = context;
    pair_writer *const writer = &broad->writers.data[2 * worker + (int)batch->kind];
    pair_store *const store = writer->store;
    for (size_t i = 0; i < batch->count;) {
        if (writer->cursor == writer->end) { /* claim the next block */
            size_t const block =
                atomic_fetch_add_explicit(&store->block_count, 1, memory_order_relaxed);
            if (block > broad->most_blocks) atomic_store(&broad->is_crowded, true);
            bool const fits = (block + 1) * KEY_BLOCK <= store->keys.capacity;
            writer->cursor = fits ? store->keys.data + block * KEY_BLOCK : writer->lost;
            writer->end = writer->cursor + KEY_BLOCK;
        }
        size_t const room = (size_t)(writer->end - writer->cursor), left = batch->count - i;
        size_t const end = i + (left < room ? left : room);
        for (; i < end; i++) {
            feature_pair const pair = pair_batch_get(tables, batch, i);
            *writer->cursor++ = (uint64_t)pair.first << writer->shift | pair.second;
        }
    }
}

typedef struct copy_task {
    const pair_store *stores;
    feature_pair *lists[2];
    size_t found[2];
} copy_task;

static void copy_kinds(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    copy_task *const task = context;
    for (size_t kind = begin; kind < end; kind++)
        task->found[kind] = pair_store_copy(&task->stores[kind], task->lists[kind]);
}

tulle_status find_pairs(broad_phase *broad, const surface_set *set, int threads, pair_order order,
                        pair_list *pairs, search_counts *counts) {
    if (threads < 1) threads = 1;
    pairs->vertex_triangle.count = pairs->edge_edge.count = 0;
    broad->writers.count = 0;
    /* Of the blocks that a store has claimed each writer may still fill one. */
    uint64_t const most = broad->most_candidates ? broad->most_candidates : UINT64_MAX;
    uint64_t const most_blocks = most / KEY_BLOCK + (uint64_t)threads;
    broad->most_blocks = most_blocks < SIZE_MAX ? (size_t)most_blocks : SIZE_MAX;
    search_counts own_counts;
    if (!counts) counts = &own_counts;
    if (!ARRAY_RESERVE(broad->heap, &broad->writers, 2 * (size_t)threads))
        return TULLE_ERROR_OUT_OF_MEMORY;

    /* Search until the stores hold all pairs. */
    for (bool is_complete = false; !is_complete;) {
        for (int kind = 0; kind < 2; kind++) atomic_store(&broad->stores[kind].block_count, 0);
        for (int w = 0; w < 2 * threads; w++) {
            pair_writer *const writer = &broad->writers.data[w];
            writer->store = &broad->stores[w % 2];
            writer->cursor = writer->end = writer->lost;
            writer->shift = writer->store->shift;
        }
        tulle_status const status = search_pairs(broad, set, threads, write_pairs, broad, counts);
        for (int w = 0; w < 2 * threads; w++) {
            pair_writer *const writer = &broad->writers.data[w];
            while (writer->cursor != writer->end) *writer->cursor++ = KEY_NONE;
        }
        if (status != TULLE_OK) return status;
        if (atomic_load(&broad->is_crowded) || counts->candidate_count > most)
            return TULLE_ERROR_LIMIT;

        /* A store that was too small gets room for a repeat. Next time each writer but one may
         * leave a block unfinished that is full this time. */
        is_complete = true;
        for (int kind = 0; kind < 2; kind++) {
            pair_store *const store = &broad->stores[kind];
            size_t const needed = atomic_load(&store->block_count) + (size_t)threads - 1;
            if (needed * KEY_BLOCK <= store->keys.capacity) continue;
            is_complete = false;
            size_t const room = needed + needed / 4 + SPARE_BLOCKS;
            if (!ARRAY_RESERVE(broad->heap, &store->keys, room * KEY_BLOCK))
                return TULLE_ERROR_OUT_OF_MEMORY;
        }
    }

    /* The list has room for all that the stores may hold. */
    if (!ARRAY_RESERVE(broad->heap, &pairs->vertex_triangle,
                       broad->stores[FEATURE_VERTEX_TRIANGLE].keys.capacity) ||
        !ARRAY_RESERVE(broad->heap, &pairs->edge_edge,
                       broad->stores[FEATURE_EDGE_EDGE].keys.capacity))
        return TULLE_ERROR_OUT_OF_MEMORY;
    copy_task task = {.stores = broad->stores,
                      .lists = {[FEATURE_VERTEX_TRIANGLE] = pairs->vertex_triangle.data,
                                [FEATURE_EDGE_EDGE] = pairs->edge_edge.data}};
    if (order == PAIRS_UNSORTED) parallel_for(2, 1, threads, copy_kinds, &task);
    for (int kind = 0; order != PAIRS_UNSORTED && kind < 2; kind++) {
        tulle_status const status = pair_store_sort(&broad->stores[kind], broad->heap, threads,
                                                    task.lists[kind], &task.found[kind]);
        if (status != TULLE_OK) return status;
    }
    pairs->vertex_triangle.count = task.found[FEATURE_VERTEX_TRIANGLE];
    pairs->edge_edge.count = task.found[FEATURE_EDGE_EDGE];
    return TULLE_OK;
}
