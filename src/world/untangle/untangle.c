/* world/untangle/untangle.c - the rounds of untangling, see start.h; what it could not
 * free, or does not try to, in words.
 *
 * A round finds the pairs of triangles that cross, joins them to contours, decides which
 * side of each went wrong and moves the cloth a little. It is no motion in time: on the way, cloth
 * may pass through anything. Only the end is judged, exactly. Velocities, rest shapes and obstacles
 * stay.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003; Volino, Magnenat-Thalmann, Resolving
 * surface collisions through intersection contour minimization, 2006. */
#include "world/start/start.h"

#include "base/error.h"
#include "base/timer.h"
#include "world/start/inside.h"
#include "world/untangle/untangle_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what is left, in words ----
 *
 * In: the state with the fewest pairs of triangles that cross. Out: between which surfaces they
 * are, in how many lines of intersection, and pins that keep cloth inside an obstacle. */

/* Pairs of surfaces that a message names. */
enum { NAMED_SURFACES = 3 };

/* Of two surfaces, a < b or the same. */
typedef struct surface_count {
    uint32_t a, b;
    uint32_t pairs;
} surface_count;

static int compare_counts(const void *one, const void *two) {
    const surface_count *const x = one, *const y = two;
    if (x->pairs != y->pairs) return x->pairs > y->pairs ? -1 : 1;
    if (x->a != y->a) return x->a < y->a ? -1 : 1;
    return (x->b > y->b) - (x->b < y->b);
}

/* Writes how many pairs each two surfaces have, most first, of surfaces from `first_surface` on:
 * "3 of 'a' with 'b', 2 of 'b' with itself". */
static tulle_status write_surfaces(tulle_world *world, size_t first_surface, char *text,
                                   size_t size) {
    const intersection_list *const list = &world->intersections;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    surface_count *const counts = ARENA_NEW(&world->work.scratch, surface_count, list->count);
    if (!counts) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t count = 0, length = 0;
    for (size_t i = 0; i < list->count; i++) {
        uint32_t const a = list->data[i].object_a, b = list->data[i].object_b;
        if (a < first_surface || b < first_surface) continue;
        size_t at = 0;
        while (at < count && (counts[at].a != a || counts[at].b != b)) at++;
        if (at == count) counts[count++] = (surface_count){a, b, 0};
        counts[at].pairs++;
    }
    qsort(counts, count, sizeof *counts, compare_counts);
    for (size_t i = 0; i < count && i < NAMED_SURFACES && length < size; i++) {
        bool const is_self = counts[i].a == counts[i].b;
        length += (size_t)snprintf(
            text + length, size - length, "%s%u of '%s' with %s%s%s", i > 0 ? ", " : "",
            counts[i].pairs, world_surface_name(&world->model, counts[i].a), is_self ? "" : "'",
            is_self ? "itself" : world_surface_name(&world->model, counts[i].b),
            is_self ? "" : "'");
    }
    if (count > NAMED_SURFACES && length < size)
        (void)snprintf(text + length, size - length, ", %zu other pair%s of surfaces",
                       count - NAMED_SURFACES, count == NAMED_SURFACES + 1 ? "" : "s");
    arena_release(&world->work.scratch, mark);
    return TULLE_OK;
}

/* What is left in `positions`, as text. */
static tulle_status describe_left(untangling *work, char *text, size_t size) {
    tulle_world *const world = work->world;
    const tulle_untangle_report *const report = &world->untangle_report;
    tulle_status status = make_contours(work, &world->intersections);
    if (status == TULLE_OK) status = decide_sides(work);
    if (status != TULLE_OK) return status;

    const contour_set *const contours = &work->contours;
    size_t lines = contours->loose_count, held = 0; /* held: pinned in a closed obstacle */
    for (size_t i = 0; i < contours->count; i++)
        lines += i == 0 || contours->crossings[i].contour != contours->crossings[i - 1].contour;
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        held += work->is_inside[v] && world->work.is_fixed[v];
    char surfaces[WORLD_MESSAGE_BYTES] = "", pins[128] = "";
    status = write_surfaces(world, 0, surfaces, sizeof surfaces);
    if (held > 0)
        (void)snprintf(pins, sizeof pins,
                       "; %zu pinned vertices lie inside an obstacle, where they stay", held);
    (void)snprintf(
        text, size, "after %u rounds of untangling (%llu at the start; in %zu lines: %s%s)",
        report->rounds, (unsigned long long)report->intersections, lines, surfaces, pins);
    return status;
}

/* The error for bodies that intersect: nothing moves them apart. Sorts the
 * world's list of intersections. */
static tulle_status refuse_bodies(tulle_world *world, tulle_error *error) {
    char text[WORLD_MESSAGE_BYTES / 2] = "";
    tulle_status const status = write_surfaces(world, world->model.cloths.count, text, sizeof text);
    if (status != TULLE_OK) return error_set(error, status, "no memory left to judge the start");
    return world_refuse_bodies(world, text, error);
}

/* ---- the rounds ---- */

/* Rounds without fewer pairs before the next level of escalation. */
enum { STALLED_ROUNDS = 40, LEVEL_MAX = 3 };
/* A stalled state with over so many times the fewest pairs of its attempt goes back to the state
 * that had the fewest. */
enum { WORSE_FACTOR = 3 };
/* A clean state waits so many rounds for its gaps to open. */
enum { GAP_ROUNDS = 60 };

/* Gives a status of a part that sets no text of its own its message. Returns the status. */
static tulle_status tell_failure(tulle_error *error, tulle_status status) {
    if (status == TULLE_OK) return status;
    if (status == TULLE_ERROR_OUT_OF_MEMORY)
        return error_set(error, status, "no memory left to untangle the start");
    return error_set(error, status, "the start cannot be untangled: %s", tulle_status_text(status));
}

/* Allocates all arrays and measures the start: lengths and areas that the cloth is to keep. */
static tulle_status begin_work(untangling *work) {
    tulle_world *const world = work->world;
    arena *const scratch = &world->work.scratch;
    size_t const n = world->model.vertex_count, edge_count = work->topo->edge_count;
    work->positions = ARENA_NEW(scratch, double, 3 * n);
    work->best = ARENA_NEW(scratch, double, 3 * n);
    work->recent = ARENA_NEW(scratch, double, 3 * n);
    work->mobility = ARENA_NEW_ZEROED(scratch, double, n);
    work->lengths = ARENA_NEW(scratch, double, edge_count);
    work->areas = ARENA_NEW_ZEROED(scratch, double, n);
    work->is_closed = ARENA_NEW(scratch, bool, world->model.obstacles.count);
    work->is_inside = ARENA_NEW(scratch, bool, n);
    work->is_astray = ARENA_NEW(scratch, bool, n);
    work->shift = ARENA_NEW(scratch, double, 6 * n);
    work->votes = ARENA_NEW(scratch, double, n);
    work->region = ARENA_NEW(scratch, uint32_t, n);
    work->queue = ARENA_NEW(scratch, uint32_t, n);
    work->cut = ARENA_NEW(scratch, uint32_t, edge_count);
    work->cut_along = ARENA_NEW(scratch, double, edge_count);
    work->sets = ARENA_NEW(scratch, uint32_t, n);
    work->grown = ARENA_NEW(scratch, uint32_t, n);
    work->set_areas = ARENA_NEW(scratch, double, n);
    bool const has_all = work->positions && work->best && work->recent && work->mobility &&
                         work->lengths && work->areas && work->is_closed && work->is_inside &&
                         work->is_astray && work->shift && work->votes && work->region &&
                         work->queue && work->cut && work->cut_along && work->sets && work->grown &&
                         work->set_areas;
    if (!has_all || broad_phase_create(&world->heap, &world->work.set, world->model.rest,
                                       BROAD_PHASE_REFIT, &work->broad) != TULLE_OK)
        return TULLE_ERROR_OUT_OF_MEMORY;

    memcpy(work->positions, world->now.positions, 3 * n * sizeof(double));
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        work->mobility[v] = world->work.is_fixed[v] ? 0.0 : 1.0;
    for (size_t e = 0; e < edge_count; e++)
        work->lengths[e] =
            vec3_norm(vec3_sub(vec3_load(work->positions, work->topo->edges[2 * e]),
                               vec3_load(work->positions, work->topo->edges[2 * e + 1])));
    for (size_t t = 0; t < work->topo->triangle_count; t++) {
        const uint32_t *const corners = work->topo->triangles + 3 * t;
        vec3 const a = vec3_load(work->positions, corners[0]);
        vec3 const normal = vec3_cross(vec3_sub(vec3_load(work->positions, corners[1]), a),
                                       vec3_sub(vec3_load(work->positions, corners[2]), a));
        for (int k = 0; k < 3; k++) work->areas[corners[k]] += vec3_norm(normal) / 6.0;
    }
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        work->is_closed[i] =
            surface_is_closed(work->topo, &world->work.surfaces[world->model.cloths.count + i]);
    return TULLE_OK;
}

/* Keeps the state with the fewest pairs, counts rounds without progress and escalates. True when it
 * puts other positions in the place of those that have `pair_count` pairs. */
static bool follow_progress(untangling *work, size_t pair_count) {
    size_t const bytes = 3 * work->world->model.vertex_count * sizeof(double);
    if (pair_count < work->best_count) {
        work->best_count = pair_count;
        memcpy(work->best, work->positions, bytes);
    }
    if (pair_count < work->recent_count) {
        work->recent_count = pair_count;
        memcpy(work->recent, work->positions, bytes);
        work->stalled = 0;
        if (work->level > 0) work->level--;
        return false;
    }
    if (++work->stalled < STALLED_ROUNDS) return false;
    work->stalled = 0;
    if (work->level >= LEVEL_MAX) {
        /* Begins anew: from the start, with another reach of displacements. */
        work->attempt++;
        work->level = 0;
        work->recent_count = SIZE_MAX;
        memcpy(work->positions, work->world->now.positions, bytes);
        return true;
    }
    work->level++;
    if (pair_count <= WORSE_FACTOR * work->recent_count) return false;
    memcpy(work->positions, work->recent, bytes);
    return true;
}

/* Rounds of judge, contours, sides and motion, until the state is clean and its gaps are open or
 * have had their time. */
static tulle_status run_rounds(untangling *work, tulle_error *error) {
    tulle_world *const world = work->world;
    intersection_list *const found = &world->intersections;
    uint32_t const limit = (uint32_t)world->model.def.untangle_limit;
    uint32_t clean_rounds = 0;
    for (uint32_t round = 0; round < limit; round++) {
        if (stop_is_wanted(&world->work.stop, 0))
            return error_set(error, TULLE_ERROR_INTERRUPTED,
                             "interrupted after %u rounds of untangling", round);
        tulle_status status = tell_failure(error, find_crossing_pairs(work, found));
        if (status == TULLE_OK && found->count == 0)
            status = world_find_intersections(world, work->positions, found, error);
        if (status != TULLE_OK) return status;
        if (follow_progress(work, found->count)) {
            work->history.sides.count = 0; /* of other positions */
        } else {
            arena_mark const mark = arena_get_mark(&world->work.scratch);
            status = make_contours(work, found);
            if (status == TULLE_OK) status = decide_sides(work);
            if (status == TULLE_OK) status = move_apart(work);
            arena_release(&world->work.scratch, mark);
        }
        if (tell_failure(error, status) != TULLE_OK) return status;
        world->untangle_report.rounds = round + 1;
        world->untangle_report.left = work->best_count;
        if (found->count > 0) continue;
        if (work->has_gap) {
            world->untangle_report.keeps_minimum_gap = 1;
            memcpy(work->best, work->positions, 3 * world->model.vertex_count * sizeof(double));
            return TULLE_OK;
        }
        if (++clean_rounds >= GAP_ROUNDS) return TULLE_OK;
    }
    return TULLE_OK;
}

/* The best state becomes the start, or is the reason of an error. */
static tulle_status accept_best(untangling *work, tulle_error *error) {
    tulle_world *const world = work->world;
    tulle_status status = world_find_intersections(world, work->best, &world->intersections, error);
    if (status != TULLE_OK) return status;
    tulle_untangle_report *const report = &world->untangle_report;
    if (world->intersections.count > 0) {
        char when[WORLD_MESSAGE_BYTES];
        memcpy(work->positions, work->best, 3 * world->model.vertex_count * sizeof(double));
        status = tell_failure(error, describe_left(work, when, sizeof when));
        if (status != TULLE_OK) return status;
        return world_refuse_intersections(world, work->best, when, error);
    }
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++) {
        vec3 const moved = vec3_sub(vec3_load(work->best, v), vec3_load(world->now.positions, v));
        report->largest_displacement = fmax(report->largest_displacement, vec3_norm(moved));
        if (vec3_norm2(moved) > 0.0) report->moved_vertices++;
    }
    memcpy(world->now.positions, work->best, 3 * world->model.cloth_vertex_count * sizeof(double));
    return TULLE_OK;
}

tulle_status world_untangle(tulle_world *world, tulle_error *error) {
    if (world_count_intersecting_bodies(world) > 0) return refuse_bodies(world, error);
    double const start = timer_now();
    world->untangle_report = (tulle_untangle_report){.intersections = world->intersections.count,
                                                     .left = world->intersections.count};
    untangling work = {.world = world,
                       .topo = &world->model.topo,
                       .mean_edge = world->model.edge_length,
                       .best_count = SIZE_MAX,
                       .recent_count = SIZE_MAX};
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    tulle_status status = tell_failure(error, begin_work(&work));
    if (status == TULLE_OK) status = run_rounds(&work, error);
    if (status == TULLE_OK) status = accept_best(&work, error);
    if (work.broad) broad_phase_destroy(work.broad);
    ARRAY_FREE(&world->heap, &work.history.sides);
    ARRAY_FREE(&world->heap, &work.pairs.vertex_triangle);
    ARRAY_FREE(&world->heap, &work.pairs.edge_edge);
    arena_release(&world->work.scratch, mark);
    world->untangle_report.seconds = timer_now() - start;
    return status;
}
