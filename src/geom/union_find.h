/* geom/union_find.h - disjoint sets over 0 .. count-1 with path halving; the smaller root wins, so
 * the result depends on the sets alone and not on the order of unions. */
#ifndef TULLE_GEOM_UNION_FIND_H
#define TULLE_GEOM_UNION_FIND_H

#include <stddef.h>
#include <stdint.h>

static inline void union_find_reset(uint32_t *parents, size_t count) {
    for (size_t i = 0; i < count; i++) parents[i] = (uint32_t)i;
}

/* The smallest member of the set of `item`. */
static inline uint32_t union_find_root(uint32_t *parents, uint32_t item) {
    while (parents[item] != item) {
        parents[item] = parents[parents[item]];
        item = parents[item];
    }
    return item;
}

static inline void union_find_join(uint32_t *parents, uint32_t a, uint32_t b) {
    uint32_t const root_a = union_find_root(parents, a), root_b = union_find_root(parents, b);
    if (root_a < root_b)
        parents[root_b] = root_a;
    else
        parents[root_a] = root_b;
}

#endif
