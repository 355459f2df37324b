/* render/surface_gap.c - see surface_gap.h.
 *
 * Each piece of cloth and each obstacle has a tree of boxes over its triangles, sorted along a
 * Morton curve and halved. A box carries a second one around the same triangles at rest. It tells
 * the search in the vertex's own piece where all triangles are too near at rest to count. */
#include "render/surface_gap.h"

#include "base/arena.h"
#include "base/error.h"
#include "base/parallel.h"
#include "math/vec3.h"
#include "render/triangle_boxes.h"

#include <stdlib.h>

enum {
    TRIANGLE_MAX = 1 << 30,
    VERTEX_CHUNK = 128, /* vertices that a thread takes at once */
    STACK_SIZE = 64     /* nodes that wait; the tree is under 32 deep */
};
static const double REST_SHARE = 0.5; /* of its distance at rest, under which a place counts */

/* One cloth whose vertices are being measured. */
typedef struct gap_search {
    const render_gap_surface *surfaces;
    const triangle_boxes *trees;
    size_t tree_count;
    size_t surface;
    const uint32_t *vertex_pieces; /* of the surface's vertices; NONE: no triangle */
    double farthest;
    double *gaps;
} gap_search;

/* The vertex in question. */
typedef struct gap_query {
    vec3 now, rest;
    uint32_t vertex;
    bool is_own; /* whether the tree is of the vertex's own piece */
    double best;
} gap_query;

/* Based on: Ericson, Real-Time Collision Detection, 2005, 5.1.5: regions of the triangle by the
 * signs of areas. */
double render_get_triangle_distance(const double p[3], const double corners[9], double weights[3]) {
    vec3 const point = vec3_load(p, 0);
    vec3 const a = vec3_load(corners, 0), b = vec3_load(corners, 1), c = vec3_load(corners, 2);
    vec3 const ab = vec3_sub(b, a), ac = vec3_sub(c, a);
    vec3 const ap = vec3_sub(point, a), bp = vec3_sub(point, b), cp = vec3_sub(point, c);
    double const d1 = vec3_dot(ab, ap), d2 = vec3_dot(ac, ap);
    double const d3 = vec3_dot(ab, bp), d4 = vec3_dot(ac, bp);
    double const d5 = vec3_dot(ab, cp), d6 = vec3_dot(ac, cp);
    double const va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    double v = 0.0, w = 0.0; /* weights of b and c */
    if (d1 <= 0.0 && d2 <= 0.0) {
        v = w = 0.0;
    } else if (d3 >= 0.0 && d4 <= d3) {
        v = 1.0;
    } else if (d6 >= 0.0 && d5 <= d6) {
        w = 1.0;
    } else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        v = d1 / (d1 - d3);
    } else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        w = d2 / (d2 - d6);
    } else if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        v = 1.0 - w;
    } else {
        double const sum = va + vb + vc;
        v = vb / sum;
        w = vc / sum;
    }
    weights[0] = 1.0 - v - w;
    weights[1] = v;
    weights[2] = w;
    return vec3_norm(vec3_sub(ap, vec3_add_scaled(vec3_scale(ab, v), ac, w)));
}

static void test_triangle(const render_gap_surface *surface, uint32_t triangle, gap_query *query) {
    const uint32_t *const corners = surface->mesh.triangles + 3 * (size_t)triangle;
    double now[9], weights[3];
    for (size_t k = 0; k < 3; k++) {
        if (query->is_own && corners[k] == query->vertex) return;
        vec3_store(now, k, vec3_load(surface->mesh.positions, corners[k]));
    }
    double const p[3] = {query->now.x, query->now.y, query->now.z};
    double const distance = render_get_triangle_distance(p, now, weights);
    if (!(distance < query->best)) return;
    if (query->is_own) {
        vec3 place = {0.0, 0.0, 0.0};
        for (size_t k = 0; k < 3; k++)
            place = vec3_add_scaled(place, vec3_load(surface->rest, corners[k]), weights[k]);
        if (!(distance < REST_SHARE * vec3_norm(vec3_sub(place, query->rest)))) return;
    }
    query->best = distance;
}

/* The distance below which nothing of the box can be; INFINITY where nothing of it counts. */
static double bound_box(const triangle_box *box, const gap_query *query) {
    double const least = triangle_box_get_least_distance(box->low, box->high, query->now);
    if (!query->is_own) return least;
    double const most = triangle_box_get_most_distance(box->rest_low, box->rest_high, query->rest);
    return least < REST_SHARE * most ? least : (double)INFINITY;
}

static void search_tree(const render_gap_surface *surface, const triangle_boxes *tree,
                        gap_query *query) {
    uint32_t stack[STACK_SIZE];
    int waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
        uint32_t const index = stack[--waiting];
        const triangle_box *const box = &tree->boxes[index];
        if (!(bound_box(box, query) < query->best)) continue;
        if (box->right == 0) {
            for (uint32_t i = box->first; i < box->first + box->count; i++)
                test_triangle(surface, tree->triangles[i], query);
            continue;
        }
        uint32_t const left = index + 1, right = box->right;
        bool const is_left_nearer =
            bound_box(&tree->boxes[left], query) <= bound_box(&tree->boxes[right], query);
        stack[waiting++] = is_left_nearer ? right : left;
        stack[waiting++] = is_left_nearer ? left : right;
    }
}

static void search_vertices(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    (void)worker;
    const gap_search *const self = context;
    const render_gap_surface *const surface = &self->surfaces[self->surface];
    for (size_t vertex = begin; vertex < end; vertex++) {
        gap_query query = {.now = vec3_load(surface->mesh.positions, vertex),
                           .rest = vec3_load(surface->rest, vertex),
                           .vertex = (uint32_t)vertex,
                           .best = self->farthest};
        for (size_t i = 0; i < self->tree_count; i++) {
            const triangle_boxes *const tree = &self->trees[i];
            query.is_own =
                tree->surface == self->surface && tree->piece == self->vertex_pieces[vertex];
            search_tree(&self->surfaces[tree->surface], tree, &query);
        }
        self->gaps[vertex] = query.best;
    }
}

/* ---- the trees ---- */

/* Triangles of a cloth sorted by piece: starts[p] .. starts[p + 1] of `sorted`. */
static bool sort_by_piece(arena *scratch, const render_gap_surface *surface, uint32_t **sorted,
                          size_t **starts) {
    size_t const count = surface->mesh.triangle_count;
    *sorted = ARENA_NEW(scratch, uint32_t, count + 1);
    *starts = ARENA_NEW_ZEROED(scratch, size_t, surface->piece_count + 2);
    if (!*sorted || !*starts) return false;
    size_t *const next = *starts + 1; /* one ahead: becomes the starts once all are placed */
    for (size_t t = 0; t < count; t++)
        if (surface->pieces[t] + 1 < surface->piece_count) next[surface->pieces[t] + 1]++;
    for (size_t p = 1; p <= surface->piece_count; p++) next[p] += next[p - 1];
    for (size_t t = 0; t < count; t++) (*sorted)[next[surface->pieces[t]]++] = (uint32_t)t;
    return true;
}

static bool build_trees(arena *scratch, const render_gap_surface *surfaces, size_t surface,
                        triangle_boxes *trees, size_t *tree_count) {
    const render_gap_surface *const from = &surfaces[surface];
    if (from->mesh.triangle_count == 0) return true;
    triangle_source source = {.mesh = from->mesh, .rest = from->rest};
    uint32_t *sorted = NULL;
    size_t *starts = NULL;
    bool is_good = true;
    if (!from->rest) {
        source.count = from->mesh.triangle_count;
        trees[*tree_count] = (triangle_boxes){.surface = surface, .piece = TULLE_NONE};
        return triangle_boxes_build(scratch, &source, &trees[(*tree_count)++]);
    }
    if (!sort_by_piece(scratch, from, &sorted, &starts)) return false;
    for (size_t piece = 0; piece < from->piece_count && is_good; piece++) {
        source.triangles = sorted + starts[piece];
        source.count = starts[piece + 1] - starts[piece];
        trees[*tree_count] = (triangle_boxes){.surface = surface, .piece = (uint32_t)piece};
        is_good = triangle_boxes_build(scratch, &source, &trees[(*tree_count)++]);
    }
    return is_good;
}

static uint32_t *find_vertex_pieces(arena *scratch, const render_gap_surface *surface) {
    uint32_t *const pieces = ARENA_NEW(scratch, uint32_t, surface->mesh.vertex_count + 1);
    if (!pieces) return NULL;
    for (size_t i = 0; i < surface->mesh.vertex_count; i++) pieces[i] = TULLE_NONE;
    for (size_t i = 0; i < 3 * surface->mesh.triangle_count; i++)
        pieces[surface->mesh.triangles[i]] = surface->pieces[i / 3];
    return pieces;
}

static bool measure_all(arena *scratch, gap_search *search, size_t surface_count, int threads,
                        double *const *gaps) {
    size_t most_trees = 0;
    for (size_t i = 0; i < surface_count; i++)
        most_trees += search->surfaces[i].rest ? search->surfaces[i].piece_count : 1;
    triangle_boxes *const trees = ARENA_NEW(scratch, triangle_boxes, most_trees + 1);
    if (!trees) return false;
    search->trees = trees;
    for (size_t i = 0; i < surface_count; i++)
        if (!build_trees(scratch, search->surfaces, i, trees, &search->tree_count)) return false;
    for (size_t i = 0; i < surface_count; i++) {
        if (!search->surfaces[i].rest) continue;
        search->surface = i;
        search->gaps = gaps[i];
        search->vertex_pieces = find_vertex_pieces(scratch, &search->surfaces[i]);
        if (!search->vertex_pieces) return false;
        parallel_for(search->surfaces[i].mesh.vertex_count, VERTEX_CHUNK, threads, search_vertices,
                     search);
    }
    return true;
}

tulle_status render_measure_gaps(memory *heap, const render_gap_def *def, double *const *gaps,
                                 tulle_error *error) {
    size_t triangle_count = 0;
    for (size_t i = 0; i < def->surface_count; i++)
        triangle_count += def->surfaces[i].mesh.triangle_count;
    if (triangle_count > TRIANGLE_MAX)
        return error_set(error, TULLE_ERROR_LIMIT, "%zu triangles; gaps are measured among 2^30",
                         triangle_count);
    arena scratch = arena_make(heap);
    gap_search search = {.surfaces = def->surfaces, .farthest = def->farthest};
    bool const is_good = measure_all(&scratch, &search, def->surface_count,
                                     parallel_resolve_threads(def->threads), gaps);
    arena_destroy(&scratch);
    return is_good ? TULLE_OK
                   : error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                               "out of memory for the gaps between %zu triangles", triangle_count);
}
