/* world/untangle/untangle_calm.c - takes the crumples out of the cloth around contours.
 *
 * Contours that pull cloth to and fro fold it, and folded cloth has no room to come apart. Two ways
 * take turns, because neither frees every start: smoothing in attempts 0, 2, ..., from level 2 on,
 * and opening folds towards the rest shape in attempts 1, 3, ..., from level 1 on. Before that, at
 * level 0, only folds around short contours are opened.
 *
 * Based on: Mueller et al., Position based dynamics, 2007 (distances across edges). */
#include "world/untangle/untangle_parts.h"

#include <string.h>

/* Corners on both sides of an edge go apart to this share of their distance in the rest shape. */
static const double UNFOLDED_SHARE = 0.9;
/* For each level of escalation. */
enum { UNFOLD_RINGS = 2, UNFOLD_SWEEPS = 2 };
/* Folds around contours of at most so many crossings are opened after so many rounds without
 * progress. */
enum { SHORT_CROSSINGS = 12, SHORT_ROUNDS = 10 };
enum { SMOOTH_LEVEL = 2, UNFOLD_LEVEL = 1 };

/* region: 1 at contours of at most `longest` crossings, 2 .. rings + 1 in the rings around them,
 * else 0. */
static void mark_surroundings(untangling *work, uint32_t rings, size_t longest) {
    const tulle_world *const world = work->world;
    const adjacency *const around = &work->topo->vertex_neighbours;
    memset(work->region, 0, world->model.vertex_count * sizeof *work->region);
    const surface_crossing *const crossings = work->contours.crossings;
    for (size_t i = 0, begin = 0, end = 0; i < work->contours.count; i++) {
        const surface_crossing *const crossing = &crossings[i];
        if (i == end) { /* the next contour: crossings are sorted by them */
            begin = end++;
            while (end < work->contours.count && crossings[end].contour == crossing->contour) end++;
        }
        if (end - begin > longest) continue;
        for (size_t k = 0; k < 2; k++)
            work->region[work->topo->edges[2 * (size_t)crossing->edge + k]] = 1;
        for (size_t k = 0; k < 3; k++)
            work->region[work->topo->triangles[3 * (size_t)crossing->triangle + k]] = 1;
    }
    for (uint32_t ring = 1; ring <= rings; ring++)
        for (size_t v = 0; v < world->model.cloth_vertex_count; v++) {
            if (work->region[v] != ring) continue;
            for (uint32_t k = around->begin[v]; k < around->begin[v + 1]; k++)
                if (work->region[around->items[k]] == 0) work->region[around->items[k]] = ring + 1;
        }
}

/* Each vertex half way to the mean of its neighbours, `level` sweeps. */
static void smooth_surroundings(untangling *work) {
    const tulle_world *const world = work->world;
    const adjacency *const around = &work->topo->vertex_neighbours;
    double *const smooth = work->shift;
    mark_surroundings(work, (uint32_t)work->level - 1, SIZE_MAX);
    for (int sweep = 0; sweep < work->level; sweep++) {
        for (size_t v = 0; v < world->model.cloth_vertex_count; v++) {
            uint32_t const begin = around->begin[v], end = around->begin[v + 1];
            vec3 const at = vec3_load(work->positions, v);
            vec3_store(smooth, v, at);
            if (work->region[v] == 0 || work->mobility[v] == 0.0 || begin == end) continue;
            vec3 sum = {0.0, 0.0, 0.0};
            for (uint32_t k = begin; k < end; k++)
                sum = vec3_add(sum, vec3_load(work->positions, around->items[k]));
            vec3 const mean = vec3_scale(sum, 1.0 / (double)(end - begin));
            vec3_store(smooth, v, vec3_lerp(at, mean, 0.5));
        }
        memcpy(work->positions, smooth, 3 * world->model.cloth_vertex_count * sizeof *smooth);
    }
}

void calm_surroundings(untangling *work) {
    const tulle_world *const world = work->world;
    const topology *const topo = work->topo;
    bool const unfolds = work->attempt % 2 != 0;
    int strength = 0; /* of unfolding */
    size_t longest = SIZE_MAX;
    if (unfolds && work->level >= UNFOLD_LEVEL) {
        strength = work->level;
    } else if (work->level == 0 && work->stalled >= SHORT_ROUNDS) {
        strength = 1;
        longest = SHORT_CROSSINGS;
    }
    if (!unfolds && work->level >= SMOOTH_LEVEL) smooth_surroundings(work);
    if (strength == 0) return;

    /* Corners on both sides of an edge go apart. */
    uint32_t const edge_end = world->model.cloth_edge_count;
    mark_surroundings(work, UNFOLD_RINGS * (uint32_t)strength, longest);
    for (int sweep = 0; sweep < UNFOLD_SWEEPS * strength; sweep++) {
        for (uint32_t i = 0; i < edge_end; i++) {
            uint32_t const e = sweep % 2 ? edge_end - 1 - i : i;
            const uint32_t *const sides = topo->edge_triangles + 2 * (size_t)e;
            if (work->region[topo->edges[2 * (size_t)e]] == 0 || sides[1] == TULLE_NONE) continue;
            uint32_t const a = topo->edge_opposites[2 * (size_t)e];
            uint32_t const b = topo->edge_opposites[2 * (size_t)e + 1];
            double const rest = vec3_norm(
                vec3_sub(vec3_load(world->model.rest, a), vec3_load(world->model.rest, b)));
            limit_distance(work, a, b, UNFOLDED_SHARE * rest, (double)INFINITY);
        }
    }
}
