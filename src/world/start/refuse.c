/* world/start/refuse.c - says why a start, or an obstacle that appears, is refused: how deep the
 * triangles lie in each other, where, which they are, and what can be done about it.
 *
 * In: world->intersections and the positions they were found in. Out: the error; the pairs sorted
 * by depth, and world->overlaps beside them. */
#include "base/error.h"
#include "base/sort.h"
#include "world/start/start.h"

#include <stdio.h>
#include <string.h>

/* ---- how deep two triangles lie in each other ----
 *
 * Two convex shapes are parted soonest along the normal of a face or across an edge of each. So the
 * depth is the least overlap of the triangles' shadows on these eleven axes.
 *
 * Based on: Ericson, Real-Time Collision Detection, 2005, 5.2.1 (separating axes). */

/* Below this share of its sides' lengths, a cross product is rounding and no axis. */
static const double PARALLEL_SHARE = 1e-12;

/* [m] Overlap of the shadows on an axis that is the cross product of two sides; INFINITY where the
 * sides are parallel. */
static double measure_shadow(const vec3 a[3], const vec3 b[3], vec3 side, vec3 other_side) {
    vec3 const axis = vec3_cross(side, other_side);
    double const length = vec3_norm(axis);
    if (!(length > PARALLEL_SHARE * vec3_norm(side) * vec3_norm(other_side)))
        return (double)INFINITY;
    double low[2] = {(double)INFINITY, (double)INFINITY};
    double high[2] = {-(double)INFINITY, -(double)INFINITY};
    for (int k = 0; k < 3; k++) {
        /* seen from a corner, so that a scene far from the origin loses no digits */
        double const at[2] = {vec3_dot(vec3_sub(a[k], a[0]), axis) / length,
                              vec3_dot(vec3_sub(b[k], a[0]), axis) / length};
        for (int i = 0; i < 2; i++) {
            low[i] = fmin(low[i], at[i]);
            high[i] = fmax(high[i], at[i]);
        }
    }
    return fmin(high[0] - low[1], high[1] - low[0]);
}

/* Adds the points at which edges of `a` pass through `b`; how many. */
static int add_crossings(const vec3 a[3], const vec3 b[3], vec3 *sum) {
    vec3 const normal = vec3_cross(vec3_sub(b[1], b[0]), vec3_sub(b[2], b[0]));
    int count = 0;
    for (int k = 0; k < 3; k++) {
        vec3 const begin = a[k], end = a[(k + 1) % 3];
        double const above = vec3_dot(vec3_sub(begin, b[0]), normal);
        double const below = vec3_dot(vec3_sub(end, b[0]), normal);
        if ((above > 0.0) == (below > 0.0)) continue;
        vec3 const point = vec3_lerp(begin, end, above / (above - below));
        bool is_inside = true;
        for (int i = 0; i < 3; i++) {
            vec3 const side = vec3_sub(b[(i + 1) % 3], b[i]);
            is_inside &= vec3_dot(vec3_cross(side, vec3_sub(point, b[i])), normal) >= 0.0;
        }
        if (!is_inside) continue;
        *sum = vec3_add(*sum, point);
        count++;
    }
    return count;
}

triangle_overlap measure_overlap(const vec3 a[3], const vec3 b[3]) {
    vec3 sides[2][3];
    for (int k = 0; k < 3; k++) {
        sides[0][k] = vec3_sub(a[(k + 1) % 3], a[k]);
        sides[1][k] = vec3_sub(b[(k + 1) % 3], b[k]);
    }
    double depth = fmin(measure_shadow(a, b, sides[0][0], sides[0][1]),
                        measure_shadow(a, b, sides[1][0], sides[1][1]));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            depth = fmin(depth, measure_shadow(a, b, sides[0][i], sides[1][j]));
    vec3 sum = {0.0, 0.0, 0.0};
    int count = add_crossings(a, b, &sum) + add_crossings(b, a, &sum);
    if (count == 0) {
        for (int k = 0; k < 3; k++) sum = vec3_add(sum, vec3_add(a[k], b[k]));
        count = 6;
    }
    return (triangle_overlap){fmax(depth, 0.0), vec3_scale(sum, 1.0 / count)};
}

/* ---- the refusal ---- */

enum { NAMED_PAIRS = 3 }; /* pairs that a message describes */

typedef struct deep_pair {
    tulle_overlap overlap;
    tulle_intersection pair;
} deep_pair;

/* Deepest first; pairs of the same depth by their numbers. */
static int compare_depths(const void *one, const void *two) {
    const deep_pair *const x = one, *const y = two;
    if (x->overlap.depth != y->overlap.depth) return x->overlap.depth > y->overlap.depth ? -1 : 1;
    uint32_t const a[4] = {x->pair.object_a, x->pair.triangle_a, x->pair.object_b,
                           x->pair.triangle_b};
    uint32_t const b[4] = {y->pair.object_a, y->pair.triangle_a, y->pair.object_b,
                           y->pair.triangle_b};
    for (int k = 0; k < 4; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

/* Measures every pair and puts the deepest first. */
static tulle_status measure_overlaps(tulle_world *world, const double *positions,
                                     tulle_error *error) {
    size_t const count = world->intersections.count;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    deep_pair *const pairs = ARENA_NEW(&world->work.scratch, deep_pair, count);
    if (!pairs || !ARRAY_RESERVE(&world->heap, &world->overlaps, count)) {
        arena_release(&world->work.scratch, mark);
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to judge the start");
    }
    for (size_t i = 0; i < count; i++) {
        tulle_intersection const pair = world->intersections.data[i];
        uint32_t const triangles[2] = {
            world->work.surfaces[pair.object_a].triangle_begin + pair.triangle_a,
            world->work.surfaces[pair.object_b].triangle_begin + pair.triangle_b};
        vec3 corners[2][3];
        for (size_t k = 0; k < 6; k++) {
            uint32_t const corner =
                world->model.topo.triangles[3 * (size_t)triangles[k / 3] + k % 3];
            corners[k / 3][k % 3] = vec3_load(positions, corner);
        }
        triangle_overlap const overlap = measure_overlap(corners[0], corners[1]);
        pairs[i] = (deep_pair){.overlap.depth = overlap.depth, .pair = pair};
        vec3_store(pairs[i].overlap.position, 0, overlap.position);
    }
    sort_in_place(pairs, count, sizeof *pairs, compare_depths);
    for (size_t i = 0; i < count; i++) {
        world->overlaps.data[i] = pairs[i].overlap;
        world->intersections.data[i] = pairs[i].pair;
    }
    world->overlaps.count = count;
    arena_release(&world->work.scratch, mark);
    return TULLE_OK;
}

/* "0.004 m deep at (0.1, 0.2, 0.3), triangle 7 of 'sheet' (vertices 1, 2, 9) with triangle 3 of
 * 'ball' (vertices 4, 5, 6)"; the length. */
static size_t describe_pair(const tulle_world *world, size_t index, char *text, size_t size) {
    const tulle_intersection *const pair = &world->intersections.data[index];
    const tulle_overlap *const overlap = &world->overlaps.data[index];
    const uint32_t *const a =
        world_surface_mesh(&world->model, pair->object_a)->triangles + 3 * (size_t)pair->triangle_a;
    const uint32_t *const b =
        world_surface_mesh(&world->model, pair->object_b)->triangles + 3 * (size_t)pair->triangle_b;
    return (size_t)snprintf(
        text, size,
        "%.3g m deep at (%.6g, %.6g, %.6g), triangle %u of '%s' (vertices %u, %u, %u) with "
        "triangle %u "
        "of '%s' (vertices %u, %u, %u)",
        overlap->depth, overlap->position[0], overlap->position[1], overlap->position[2],
        pair->triangle_a, world_surface_name(&world->model, pair->object_a), a[0], a[1], a[2],
        pair->triangle_b, world_surface_name(&world->model, pair->object_b), b[0], b[1], b[2]);
}

tulle_status world_refuse_intersections(tulle_world *world, const double *positions,
                                        const char *when, tulle_error *error) {
    tulle_status const status = measure_overlaps(world, positions, error);
    if (status != TULLE_OK) return status;
    char text[sizeof error->message];
    size_t const size = sizeof text;
    size_t const count = world->intersections.count;
    size_t length = 0;
    text[0] = '\0';
    for (size_t i = 0; i < count && i < NAMED_PAIRS && length < size; i++) {
        length += (size_t)snprintf(text + length, size - length, "\n  ");
        if (length < size) length += describe_pair(world, i, text + length, size - length);
    }
    if (count > NAMED_PAIRS && length < size)
        (void)snprintf(text + length, size - length, "\n  and %zu more", count - NAMED_PAIRS);
    bool const is_untangled = world->model.def.start_intersections == TULLE_START_UNTANGLE;
    bool const is_late = world->is_started; /* only the start is untangled */
    size_t doubled = 0;                     /* pairs of one cloth that have corners in one place */
    for (size_t i = 0; i < count; i++) {
        const tulle_intersection *const pair = &world->intersections.data[i];
        const surface_range *const surface = &world->work.surfaces[pair->object_a];
        const uint32_t *const all =
            world->model.topo.triangles + 3 * (size_t)surface->triangle_begin;
        bool is_doubled = false;
        for (size_t k = 0; k < 9 && pair->object_a == pair->object_b; k++) {
            uint32_t const a = all[3 * (size_t)pair->triangle_a + k / 3];
            uint32_t const b = all[3 * (size_t)pair->triangle_b + k % 3];
            is_doubled |= a != b && memcmp(positions + 3 * (size_t)a, positions + 3 * (size_t)b,
                                           3 * sizeof *positions) == 0;
        }
        doubled += is_doubled;
    }
    const char *advice = "move them apart, or set start_intersections to untangle, or to ignore";
    if (world_count_intersecting_bodies(world) > 0)
        advice = "move them apart (untangling moves cloth only), or set start_intersections to "
                 "ignore";
    if (is_untangled)
        advice = "move them apart, raise untangle_limit, or set start_intersections to ignore";
    if (is_late)
        advice = "let it appear elsewhere or at another time, or set start_intersections to ignore";
    return error_set(
        error, TULLE_ERROR_INTERSECTING_START,
        "%zu pairs of triangles intersect %s:%s\n"
        "To mend it, %s%s (an exception to the promise: an ignored pair counts once it "
        "has come apart)",
        count, when, text,
        doubled > 0 ? "join vertices that are in one place ('tulle convert IN OUT "
                      "--repair' joins boundary vertices), or "
                    : "",
        advice);
}

tulle_status world_refuse_bodies(tulle_world *world, const char *what, tulle_error *error) {
    tulle_status const status = measure_overlaps(world, world->now.positions, error);
    if (status != TULLE_OK) return status;
    char text[sizeof error->message / 2] = "";
    for (size_t i = 0; i < world->intersections.count && !text[0]; i++) {
        const tulle_intersection *const pair = &world->intersections.data[i];
        if (pair->object_a >= world->model.cloths.count &&
            pair->object_b >= world->model.cloths.count)
            (void)describe_pair(world, i, text, sizeof text);
    }
    return error_set(error, TULLE_ERROR_INTERSECTING_START,
                     "%zu pairs of triangles intersect at the start in which no cloth takes part "
                     "(%s), and untangling moves cloth only; move the objects apart, or set "
                     "start_intersections to ignore (an exception to the promise: an ignored pair "
                     "counts once it has come apart). The deepest:\n  %s",
                     world_count_intersecting_bodies(world), what, text);
}
