/* contact/pairs/apart_pairs.c - see apart_pairs.h. The kernel that takes pairs into the pool of
 * detection leaves those out that it proves apart. */
#include "contact/pairs/apart_pairs.h"

#include "detect/impact/impact_pool.h"

bool make_feature_tables(const contact_scene *scene, const vertex_record *records,
                         pair_tables *tables) {
    const topology *const topo = scene->set->topo;
    uint32_t *const numbers = ARENA_NEW(scene->scratch, uint32_t, scene->vertex_count);
    *tables = (pair_tables){.vertex_corners = numbers,
                            .edge_corners = topo->edges,
                            .triangle_corners = topo->triangles,
                            .records = records};
    for (size_t i = 0; numbers && i < scene->vertex_count; i++) numbers[i] = (uint32_t)i;
    return numbers && records;
}

void mark_apart(const pair_tables *tables, const apart_query *query, bool is_apart[SCAN_MOST]) {
    _Static_assert((int)SCAN_MOST <= (int)IMPACT_POOL_SIZE, "the pool must have room for all");
    uint32_t first[SCAN_MOST], second[SCAN_MOST], odd[SCAN_MOST];
    impact_pool pool;
    pool.count = 0;
    pool.filtered_count = 0;
    for (size_t i = 0; i < query->count; i++) {
        first[i] = query->pairs[i].first;
        second[i] = query->pairs[i].second;
        is_apart[i] = true;
    }
    slot_pairs const pairs = {query->kind, query->count, first, second, query->separations};
    size_t const odd_count = TULLE_PICK_KERNEL(begin_impacts)(tables, &pairs, &pool, odd);
    /* the pool has its pairs in the order of the query */
    for (size_t k = 0, i = 0; k < pool.count; k++) {
        while (first[i] != (uint32_t)pool.rows[ROW_FIRST][k] ||
               second[i] != (uint32_t)pool.rows[ROW_SECOND][k])
            i++;
        is_apart[i] = false;
    }
    for (size_t i = 0; i < odd_count; i++) is_apart[odd[i]] = false;
}
