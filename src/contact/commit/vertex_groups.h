/* contact/commit/vertex_groups.h - disjoint groups of vertices that grow by joining (union-find).
 */
#ifndef TULLE_CONTACT_COMMIT_VERTEX_GROUPS_H
#define TULLE_CONTACT_COMMIT_VERTEX_GROUPS_H

#include "base/arena.h"

#include <stdbool.h>

/* A group is named by its smallest vertex, so names do not depend on the order of joining. */
typedef struct vertex_groups {
    uint32_t *parents; /* vertex_count, in scratch */
    bool *is_member;   /* vertex_count: was ever joined */
    size_t vertex_count;
} vertex_groups;

/* Makes each vertex a group of its own, and none a member. False when memory is short. */
static inline bool vertex_groups_make(vertex_groups *groups, arena *scratch, size_t vertex_count) {
    groups->vertex_count = vertex_count;
    groups->parents = ARENA_NEW(scratch, uint32_t, vertex_count);
    groups->is_member = ARENA_NEW_ZEROED(scratch, bool, vertex_count);
    if (!groups->parents || !groups->is_member) return false;
    for (size_t i = 0; i < vertex_count; i++) groups->parents[i] = (uint32_t)i;
    return true;
}

/* Returns the name of the vertex's group, and shortens later searches. */
static inline uint32_t find_group(vertex_groups *groups, uint32_t vertex) {
    uint32_t *const parents = groups->parents;
    while (parents[vertex] != vertex) {
        parents[vertex] = parents[parents[vertex]];
        vertex = parents[vertex];
    }
    return vertex;
}

/* Makes both vertices members of one group; returns its name. */
static inline uint32_t join_groups(vertex_groups *groups, uint32_t a, uint32_t b) {
    groups->is_member[a] = groups->is_member[b] = true;
    uint32_t const root_a = find_group(groups, a), root_b = find_group(groups, b);
    uint32_t const low = root_a < root_b ? root_a : root_b;
    groups->parents[root_a] = groups->parents[root_b] = low;
    return low;
}

#endif
