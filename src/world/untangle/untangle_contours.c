/* world/untangle/untangle_contours.c - from intersecting triangle pairs to the lines of
 * intersection.
 *
 * In: pairs of triangles that intersect. Out: every edge that passes through the other triangle of
 * its pair, once, with its place on both and the contour to which it belongs. Two pairs are of one
 * contour when they share a crossing. Signs are exact. A point on a plane counts as above it, so
 * that an edge which meets the side between two triangles crosses one of them.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003, section 4; Volino, Magnenat-Thalmann,
 * Resolving surface collisions through intersection contour minimization, 2006 (pull). */
#include "geom/exact_predicates.h"
#include "geom/union_find.h"
#include "world/untangle/untangle_parts.h"

#include <stdlib.h>
#include <string.h>

enum { CROSSINGS_OF_PAIR = 6 };

/* A crossing as one pair sees it. */
typedef struct sighting {
    uint32_t edge, triangle, pair;
} sighting;

static int compare_sightings(const void *a, const void *b) {
    const sighting *const x = a, *const y = b;
    if (x->edge != y->edge) return x->edge < y->edge ? -1 : 1;
    if (x->triangle != y->triangle) return x->triangle < y->triangle ? -1 : 1;
    return (x->pair > y->pair) - (x->pair < y->pair);
}

static int compare_contours(const void *a, const void *b) {
    const surface_crossing *const x = a, *const y = b;
    if (x->contour != y->contour) return x->contour < y->contour ? -1 : 1;
    if (x->edge != y->edge) return x->edge < y->edge ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

/* 1 or -1: on which side of the line a b the line p q passes; antisymmetric in p and q. */
static int compute_passing_side(const double *x, const uint32_t ends[2], uint32_t p, uint32_t q) {
    uint32_t const low = p < q ? p : q, high = p < q ? q : p;
    int const sign = orient3d_sign(x + 3 * (size_t)ends[0], x + 3 * (size_t)ends[1],
                                   x + 3 * (size_t)low, x + 3 * (size_t)high, NULL);
    int const side = sign < 0 ? -1 : 1;
    return p < q ? side : -side;
}

static bool edge_crosses(const untangling *work, uint32_t edge, uint32_t triangle) {
    const double *const x = work->positions;
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)edge;
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)triangle;
    for (int k = 0; k < 3; k++)
        if (corners[k] == ends[0] || corners[k] == ends[1]) return false;
    bool is_below[2]; /* the plane of the triangle */
    for (int k = 0; k < 2; k++)
        is_below[k] = orient3d_sign(x + 3 * (size_t)corners[0], x + 3 * (size_t)corners[1],
                                    x + 3 * (size_t)corners[2], x + 3 * (size_t)ends[k], NULL) < 0;
    if (is_below[0] == is_below[1]) return false;
    int const side = compute_passing_side(x, ends, corners[0], corners[1]);
    return side == compute_passing_side(x, ends, corners[1], corners[2]) &&
           side == compute_passing_side(x, ends, corners[2], corners[0]);
}

/* untangle_contours.c */
static bool triangles_cross(const untangling *work, uint32_t first, uint32_t second) {
    for (size_t k = 0; k < 3; k++) {
        if (edge_crosses(work, work->topo->triangle_edges[3 * (size_t)first + k], second) ||
            edge_crosses(work, work->topo->triangle_edges[3 * (size_t)second + k], first))
            return true;
    }
    return false;
}

/* Place of the crossing on the edge and in the triangle, clamped against rounding. */
static void place_crossing(const untangling *work, surface_crossing *crossing) {
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    vec3 const a = vec3_load(work->positions, ends[0]), b = vec3_load(work->positions, ends[1]);
    vec3 corner[3];
    for (int k = 0; k < 3; k++) corner[k] = vec3_load(work->positions, corners[k]);
    vec3 const normal = vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0]));
    double const height[2] = {vec3_dot(normal, vec3_sub(a, corner[0])),
                              vec3_dot(normal, vec3_sub(b, corner[0]))};
    double const span = height[0] - height[1];
    crossing->along = span != 0.0 ? fmin(fmax(height[0] / span, 0.0), 1.0) : 0.5;
    vec3 const point = vec3_lerp(a, b, crossing->along);
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        vec3 const side =
            vec3_cross(vec3_sub(corner[(k + 1) % 3], point), vec3_sub(corner[(k + 2) % 3], point));
        crossing->weights[k] = fmax(vec3_dot(normal, side), 0.0);
        sum += crossing->weights[k];
    }
    for (int k = 0; k < 3; k++)
        crossing->weights[k] = sum > 0.0 ? crossing->weights[k] / sum : 1.0 / 3.0;
}

vec3 compute_crossing_point(const untangling *work, const surface_crossing *crossing) {
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
    return vec3_lerp(vec3_load(work->positions, ends[0]), vec3_load(work->positions, ends[1]),
                     crossing->along);
}

/* One crossing for all sightings of it; joins their pairs. first[i]: a crossing of pair i. */
static void join_sightings(untangling *work, const sighting *found, size_t found_count,
                           uint32_t *pair_sets, uint32_t *first) {
    contour_set *const contours = &work->contours;
    for (size_t i = 0; i < found_count; i++) {
        const sighting *const seen = &found[i];
        bool const is_known =
            i > 0 && found[i - 1].edge == seen->edge && found[i - 1].triangle == seen->triangle;
        if (is_known) {
            union_find_join(pair_sets, found[i - 1].pair, seen->pair);
        } else {
            surface_crossing *const added = &contours->crossings[contours->count++];
            *added = (surface_crossing){.edge = seen->edge,
                                        .triangle = seen->triangle,
                                        .contour = seen->pair,
                                        .wrong_end = CROSSING_UNDECIDED};
            place_crossing(work, added);
        }
        uint32_t const here = (uint32_t)contours->count - 1;
        if (first[seen->pair] == TULLE_NONE) {
            first[seen->pair] = here;
            continue;
        }
        surface_crossing *const one = &contours->crossings[first[seen->pair]];
        surface_crossing *const two = &contours->crossings[here];
        vec3 const way = vec3_normalize(
            vec3_sub(compute_crossing_point(work, two), compute_crossing_point(work, one)));
        one->pull = vec3_add(one->pull, way);
        two->pull = vec3_sub(two->pull, way);
    }
}

/* The contour of a pair with one crossing ends at the corner that both triangles share. */
static void pull_to_shared(untangling *work, const intersection_list *pairs, const uint32_t *first,
                           const uint32_t *counts) {
    const surface_range *const surfaces = work->world->work.surfaces;
    for (size_t i = 0; i < pairs->count; i++) {
        if (counts[i] != 1) continue;
        const tulle_intersection *const pair = &pairs->data[i];
        uint32_t const a = surfaces[pair->object_a].triangle_begin + pair->triangle_a;
        uint32_t const b = surfaces[pair->object_b].triangle_begin + pair->triangle_b;
        for (size_t k = 0; k < 9; k++) {
            uint32_t const corner = work->topo->triangles[3 * (size_t)a + k / 3];
            if (corner != work->topo->triangles[3 * (size_t)b + k % 3]) continue;
            surface_crossing *const crossing = &work->contours.crossings[first[i]];
            crossing->pull = vec3_add(
                crossing->pull, vec3_normalize(vec3_sub(vec3_load(work->positions, corner),
                                                        compute_crossing_point(work, crossing))));
            break;
        }
    }
}

tulle_status make_contours(untangling *work, const intersection_list *pairs) {
    arena *const scratch = &work->world->work.scratch;
    size_t const most = CROSSINGS_OF_PAIR * pairs->count;
    contour_set *const contours = &work->contours;
    *contours = (contour_set){.crossings = ARENA_NEW(scratch, surface_crossing, most),
                              .loose = ARENA_NEW(scratch, tulle_intersection, pairs->count)};
    sighting *const found = ARENA_NEW(scratch, sighting, most);
    uint32_t *const pair_sets = ARENA_NEW(scratch, uint32_t, pairs->count);
    uint32_t *const first = ARENA_NEW(scratch, uint32_t, pairs->count);
    uint32_t *const counts = ARENA_NEW_ZEROED(scratch, uint32_t, pairs->count);
    if (!contours->crossings || !contours->loose || !found || !pair_sets || !first || !counts)
        return TULLE_ERROR_OUT_OF_MEMORY;
    union_find_reset(pair_sets, pairs->count);
    for (size_t i = 0; i < pairs->count; i++) first[i] = TULLE_NONE;
    /* All sightings of the pairs; pairs without any are loose. */
    const surface_range *const surfaces = work->world->work.surfaces;
    size_t found_count = 0;
    for (size_t i = 0; i < pairs->count; i++) {
        const tulle_intersection *const pair = &pairs->data[i];
        uint32_t const triangles[2] = {surfaces[pair->object_a].triangle_begin + pair->triangle_a,
                                       surfaces[pair->object_b].triangle_begin + pair->triangle_b};
        for (size_t k = 0; k < CROSSINGS_OF_PAIR; k++) {
            uint32_t const edge = work->topo->triangle_edges[3 * (size_t)triangles[k / 3] + k % 3];
            uint32_t const other = triangles[1 - k / 3];
            if (!edge_crosses(work, edge, other)) continue;
            found[found_count++] = (sighting){edge, other, (uint32_t)i};
            counts[i]++;
        }
        if (counts[i] == 0) contours->loose[contours->loose_count++] = *pair;
    }
    if (found_count == 0) return TULLE_OK;
    qsort(found, found_count, sizeof *found, compare_sightings);
    join_sightings(work, found, found_count, pair_sets, first);
    pull_to_shared(work, pairs, first, counts);
    for (size_t i = 0; i < contours->count; i++)
        contours->crossings[i].contour = union_find_root(pair_sets, contours->crossings[i].contour);
    qsort(contours->crossings, contours->count, sizeof *contours->crossings, compare_contours);
    return TULLE_OK;
}

/* ---- the pairs of triangles that cross ----
 *
 * Triangles are sorted along the axis in which the cloth is longest. Each is compared with those
 * that begin before it ends; where boxes meet, the triangles are tested exactly. This finds
 * every pair in which an edge passes through a triangle. It takes less time than the judge,
 * which alone decides that a state is clean.
 *
 * Based on: Baraff, Dynamic simulation of non-penetrating rigid bodies, 1992 (sort and sweep). */

/* A triangle's box, the axis of the sweep first. */
typedef struct sorted_triangle {
    double low[3], high[3];
    uint32_t triangle, surface;
} sorted_triangle;

static int compare_lows(const void *a, const void *b) {
    const sorted_triangle *const x = a, *const y = b;
    if (x->low[0] != y->low[0]) return x->low[0] < y->low[0] ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

/* Triangles of cloth, or of obstacles, sorted by where they begin along the axis. */
typedef struct sorted_triangles {
    sorted_triangle *boxes;
    size_t count;
} sorted_triangles;

/* Boxes of all triangles that reach into the box of the cloth. */
static void fill_boxes(const untangling *work, sorted_triangles *cloth,
                       sorted_triangles *obstacles) {
    const tulle_world *const world = work->world;
    const double *const x = work->positions;
    /* The box of all cloth, and the axis in which it is longest. */
    double low[3] = {x[0], x[1], x[2]}, high[3] = {x[0], x[1], x[2]};
    for (size_t i = 0; i < 3 * world->model.cloth_vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], x[i]);
        high[i % 3] = fmax(high[i % 3], x[i]);
    }
    size_t axis = 0;
    for (size_t c = 1; c < 3; c++)
        if (high[c] - low[c] > high[axis] - low[axis]) axis = c;

    for (uint32_t s = 0; s < world->model.surface_count; s++) {
        const surface_range *const range = &world->work.surfaces[s];
        sorted_triangles *const list = range->is_obstacle ? obstacles : cloth;
        for (uint32_t t = range->triangle_begin; t < range->triangle_end && range->is_present;
             t++) {
            const uint32_t *const corners = work->topo->triangles + 3 * (size_t)t;
            sorted_triangle box = {.triangle = t, .surface = s};
            bool is_near = true;
            for (size_t c = 0; c < 3; c++) {
                size_t const from = (c + axis) % 3;
                double const a = x[3 * (size_t)corners[0] + from];
                double const b = x[3 * (size_t)corners[1] + from];
                double const d = x[3 * (size_t)corners[2] + from];
                box.low[c] = fmin(a, fmin(b, d));
                box.high[c] = fmax(a, fmax(b, d));
                is_near = is_near && box.low[c] <= high[from] && box.high[c] >= low[from];
            }
            if (is_near) list->boxes[list->count++] = box;
        }
    }
    if (cloth->count > 0) qsort(cloth->boxes, cloth->count, sizeof *cloth->boxes, compare_lows);
    if (obstacles->count > 0)
        qsort(obstacles->boxes, obstacles->count, sizeof *obstacles->boxes, compare_lows);
}

/* Compares a box with those of the list from `begin` that begin before it ends, and adds the pairs
 * that cross. False when memory is short. */
static bool sweep(untangling *work, const sorted_triangle *box, const sorted_triangles *list,
                  size_t begin, intersection_list *found) {
    tulle_world *const world = work->world;
    for (size_t i = begin; i < list->count && list->boxes[i].low[0] <= box->high[0]; i++) {
        const sorted_triangle *const other = &list->boxes[i];
        bool is_near = true;
        for (size_t c = 1; c < 3; c++)
            is_near = is_near && box->low[c] <= other->high[c] && other->low[c] <= box->high[c];
        if (!is_near || !surfaces_may_meet(&world->work.set, box->surface, other->surface) ||
            !triangles_cross(work, box->triangle, other->triangle))
            continue;
        if (!ARRAY_RESERVE(&world->heap, found, 1)) return false;
        bool const is_ordered = box->triangle < other->triangle; /* as their surfaces are */
        const sorted_triangle *const first = is_ordered ? box : other;
        const sorted_triangle *const second = is_ordered ? other : box;
        found->data[found->count++] = (tulle_intersection){
            first->surface, first->triangle - world->work.surfaces[first->surface].triangle_begin,
            second->surface,
            second->triangle - world->work.surfaces[second->surface].triangle_begin};
    }
    return true;
}

tulle_status find_crossing_pairs(untangling *work, intersection_list *list) {
    arena *const scratch = &work->world->work.scratch;
    arena_mark const mark = arena_get_mark(scratch);
    size_t const most = work->topo->triangle_count;
    sorted_triangles cloth = {ARENA_NEW(scratch, sorted_triangle, most), 0};
    sorted_triangles obstacles = {ARENA_NEW(scratch, sorted_triangle, most), 0};
    bool has_memory = cloth.boxes && obstacles.boxes;
    list->count = 0;
    if (has_memory) fill_boxes(work, &cloth, &obstacles);
    /* Cloth with cloth and obstacles that begin later. */
    for (size_t i = 0, first = 0; i < cloth.count && has_memory; i++) {
        const sorted_triangle *const box = &cloth.boxes[i];
        while (first < obstacles.count && obstacles.boxes[first].low[0] < box->low[0]) first++;
        has_memory =
            sweep(work, box, &cloth, i + 1, list) && sweep(work, box, &obstacles, first, list);
    }
    /* Obstacles with cloth that begins later; equal beginnings were met above. */
    for (size_t i = 0, first = 0; i < obstacles.count && has_memory; i++) {
        const sorted_triangle *const box = &obstacles.boxes[i];
        while (first < cloth.count && cloth.boxes[first].low[0] <= box->low[0]) first++;
        has_memory = sweep(work, box, &cloth, first, list);
    }
    arena_release(scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
