/* world/untangle/untangle_search.c - the pairs of triangles that cross, round after round.
 *
 * Triangles are sorted along the axis in which the cloth is longest. Each is compared with those
 * that begin before it ends; where boxes meet, the triangles are tested exactly. This finds
 * every pair in which an edge passes through a triangle. It takes less time than the judge,
 * which alone decides that a state is clean.
 *
 * Based on: Baraff, Dynamic simulation of non-penetrating rigid bodies, 1992 (sort and sweep). */
#include "world/untangle/untangle_parts.h"

#include <stdlib.h>

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
