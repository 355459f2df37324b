/* detect/pairs/find_pairs.c - stage 7 as a list: takes fitted trees, gives the list of all feature
 * pairs whose boxes meet. What the search finds goes to the writers of its workers; sorting makes
 * the list the same for any number of threads. */
#include "detect/trees/broad_phase_parts.h"

/* A pair_consumer; context: the broad phase. */
static void write_pairs(void *context, const pair_tables *tables, const pair_batch *batch,
                        int worker) {
    const broad_phase *const broad = context;
    pair_writer *const writer = &broad->writers.data[2 * worker + (int)batch->kind];
    for (size_t i = 0; i < batch->count;) {
        size_t const room = pair_writer_make_room(writer), left = batch->count - i;
        size_t const end = i + (left < room ? left : room);
        for (; i < end; i++) {
            feature_pair const pair = pair_batch_get(tables, batch, i);
            pair_writer_add(writer, pair.first, pair.second);
        }
    }
}

/* One search; what does not fit into the stores is only counted. */
static tulle_status search_once(broad_phase *broad, const surface_set *set, int threads,
                                search_counts *counts) {
    for (int kind = 0; kind < 2; kind++) pair_store_clear(&broad->stores[kind]);
    for (int w = 0; w < 2 * threads; w++)
        pair_writer_start(&broad->writers.data[w], &broad->stores[w % 2]);
    tulle_status const status = search_pairs(broad, set, threads, write_pairs, broad, counts);
    for (int w = 0; w < 2 * threads; w++) pair_writer_finish(&broad->writers.data[w]);
    return status;
}

static bool reserve_results(broad_phase *broad, pair_list *pairs) {
    return ARRAY_RESERVE(broad->heap, &pairs->vertex_triangle,
                         broad->stores[FEATURE_VERTEX_TRIANGLE].keys.capacity) &&
           ARRAY_RESERVE(broad->heap, &pairs->edge_edge,
                         broad->stores[FEATURE_EDGE_EDGE].keys.capacity);
}

/* Searches until the stores hold all, and empties the list. */
static tulle_status fill_stores(broad_phase *broad, const surface_set *set, int threads,
                                pair_list *pairs, search_counts *counts) {
    pairs->vertex_triangle.count = pairs->edge_edge.count = 0;
    broad->writers.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->writers, 2 * (size_t)threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    bool is_complete = false;
    while (!is_complete) {
        tulle_status status = search_once(broad, set, threads, counts);
        if (status != TULLE_OK) return status;
        is_complete = true;
        for (int kind = 0; kind < 2; kind++) {
            if (!pair_store_is_complete(broad->heap, &broad->stores[kind], threads, &status))
                is_complete = false;
            if (status != TULLE_OK) return status;
        }
    }
    return reserve_results(broad, pairs) ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status find_unsorted_pairs(broad_phase *broad, const surface_set *set, int threads,
                                 pair_list *pairs, search_counts *counts) {
    tulle_status const status = fill_stores(broad, set, threads < 1 ? 1 : threads, pairs, counts);
    if (status != TULLE_OK) return status;
    pairs->vertex_triangle.count =
        pair_store_copy(&broad->stores[FEATURE_VERTEX_TRIANGLE], pairs->vertex_triangle.data);
    pairs->edge_edge.count =
        pair_store_copy(&broad->stores[FEATURE_EDGE_EDGE], pairs->edge_edge.data);
    return TULLE_OK;
}

tulle_status find_pairs(broad_phase *broad, const surface_set *set, int threads, pair_list *pairs,
                        search_counts *counts) {
    if (threads < 1) threads = 1;
    tulle_status const status = fill_stores(broad, set, threads, pairs, counts);
    if (status != TULLE_OK) return status;
    for (int kind = 0; kind < 2; kind++)
        if (!pair_store_reserve_sorting(broad->heap, &broad->stores[kind]))
            return TULLE_ERROR_OUT_OF_MEMORY;
    pairs->vertex_triangle.count = pair_store_sort(&broad->stores[FEATURE_VERTEX_TRIANGLE], threads,
                                                   pairs->vertex_triangle.data);
    pairs->edge_edge.count =
        pair_store_sort(&broad->stores[FEATURE_EDGE_EDGE], threads, pairs->edge_edge.data);
    return TULLE_OK;
}
