/* subdivision/loop_subdivision_level.c - how vertices, edges, triangles and their rules pass from
 * one level to the next; see loop_subdivision.h for the numbering. O(triangles), no search. */
#include "subdivision/loop_subdivision.h"

static uint32_t *new_indices(memory *heap, size_t count) {
    return memory_allocate(heap, count * sizeof(uint32_t));
}

bool subdivision_level_create(memory *heap, size_t vertex_count, size_t edge_count,
                              size_t triangle_count, subdivision_level *level) {
    *level = (subdivision_level){.vertex_count = vertex_count,
                                 .edge_count = edge_count,
                                 .triangle_count = triangle_count,
                                 .triangles = new_indices(heap, 3 * triangle_count),
                                 .triangle_edges = new_indices(heap, 3 * triangle_count),
                                 .edges = new_indices(heap, 2 * edge_count),
                                 .edge_opposites = new_indices(heap, 2 * edge_count),
                                 .spoke_rules = new_indices(heap, 2 * edge_count),
                                 .edge_is_sharp = memory_allocate(heap, edge_count),
                                 .vertex_rules = memory_allocate(heap, vertex_count)};
    if (level->triangles && level->triangle_edges && level->edges && level->edge_opposites &&
        level->spoke_rules && level->edge_is_sharp && level->vertex_rules)
        return true;
    subdivision_level_destroy(heap, level);
    return false;
}

void subdivision_level_destroy(memory *heap, subdivision_level *level) {
    memory_release(heap, level->triangles, 3 * level->triangle_count * sizeof(uint32_t));
    memory_release(heap, level->triangle_edges, 3 * level->triangle_count * sizeof(uint32_t));
    memory_release(heap, level->edges, 2 * level->edge_count * sizeof(uint32_t));
    memory_release(heap, level->edge_opposites, 2 * level->edge_count * sizeof(uint32_t));
    memory_release(heap, level->spoke_rules, 2 * level->edge_count * sizeof(uint32_t));
    memory_release(heap, level->edge_is_sharp, level->edge_count);
    memory_release(heap, level->vertex_rules, level->vertex_count);
    *level = (subdivision_level){0};
}

static void refine_vertices(const subdivision_level *coarse, subdivision_level *fine) {
    for (size_t v = 0; v < coarse->vertex_count; v++)
        fine->vertex_rules[v] = coarse->vertex_rules[v];
    for (size_t e = 0; e < coarse->edge_count; e++)
        fine->vertex_rules[coarse->vertex_count + e] =
            coarse->edge_is_sharp[e] ? VERTEX_CREASE : VERTEX_SMOOTH;
}

/* The two halves of every edge. */
static void refine_edges(const subdivision_level *coarse, subdivision_level *fine) {
    for (size_t e = 0; e < coarse->edge_count; e++) {
        for (size_t end = 0; end < 2; end++) {
            size_t const half = 2 * e + end;
            fine->edges[2 * half + end] = coarse->edges[2 * e + end];
            fine->edges[2 * half + 1 - end] = (uint32_t)(coarse->vertex_count + e);
            fine->spoke_rules[2 * half + end] = coarse->spoke_rules[2 * e + end];
            fine->spoke_rules[2 * half + 1 - end] = 0;
            fine->edge_is_sharp[half] = coarse->edge_is_sharp[e];
            fine->edge_opposites[2 * half] = fine->edge_opposites[2 * half + 1] = TULLE_NONE;
        }
    }
}

static void add_opposite(subdivision_level *fine, uint32_t edge, uint32_t vertex) {
    uint32_t *const opposites = fine->edge_opposites + 2 * (size_t)edge;
    if (opposites[0] == TULLE_NONE)
        opposites[0] = vertex;
    else if (opposites[1] == TULLE_NONE)
        opposites[1] = vertex;
}

/* The triangle at corner k, with the edge that cuts it off. middle: the midpoints of the edges. */
static void refine_corner(const subdivision_level *coarse, size_t t, size_t k,
                          const uint32_t middle[3], subdivision_level *fine) {
    size_t const next = (k + 1) % 3, prev = (k + 2) % 3;
    uint32_t const vertex = coarse->triangles[3 * t + k];
    uint32_t halves[2]; /* of the edges that leave and reach the corner */
    for (int side = 0; side < 2; side++) {
        uint32_t const edge = coarse->triangle_edges[3 * t + (side == 0 ? k : prev)];
        halves[side] = 2 * edge + (coarse->edges[2 * (size_t)edge] != vertex);
    }
    size_t const cut = 2 * coarse->edge_count + 3 * t + k;
    fine->edges[2 * cut] = middle[k];
    fine->edges[2 * cut + 1] = middle[prev];
    fine->edge_opposites[2 * cut] = vertex;
    fine->edge_opposites[2 * cut + 1] = middle[next];
    fine->spoke_rules[2 * cut] = fine->spoke_rules[2 * cut + 1] = 0;
    fine->edge_is_sharp[cut] = 0;

    uint32_t *const corners = fine->triangles + 3 * (4 * t + k);
    uint32_t *const edges = fine->triangle_edges + 3 * (4 * t + k);
    corners[k] = vertex;
    corners[next] = middle[k];
    corners[prev] = middle[prev];
    edges[k] = halves[0];
    edges[next] = (uint32_t)cut;
    edges[prev] = halves[1];
    add_opposite(fine, halves[0], middle[prev]);
    add_opposite(fine, halves[1], middle[k]);
}

static void refine_triangle(const subdivision_level *coarse, size_t t, subdivision_level *fine) {
    uint32_t middle[3];
    for (size_t k = 0; k < 3; k++)
        middle[k] = (uint32_t)coarse->vertex_count + coarse->triangle_edges[3 * t + k];
    for (size_t k = 0; k < 3; k++) {
        refine_corner(coarse, t, k, middle, fine);
        fine->triangles[3 * (4 * t + 3) + k] = middle[k];
        fine->triangle_edges[3 * (4 * t + 3) + k] =
            (uint32_t)(2 * coarse->edge_count + 3 * t + (k + 1) % 3);
    }
}

bool subdivision_level_refine(memory *heap, const subdivision_level *coarse,
                              subdivision_level *fine) {
    if (!subdivision_level_create(heap, coarse->vertex_count + coarse->edge_count,
                                  2 * coarse->edge_count + 3 * coarse->triangle_count,
                                  4 * coarse->triangle_count, fine))
        return false;
    fine->depth = coarse->depth + 1;
    refine_vertices(coarse, fine);
    refine_edges(coarse, fine);
    for (size_t t = 0; t < coarse->triangle_count; t++) refine_triangle(coarse, t, fine);
    return true;
}
