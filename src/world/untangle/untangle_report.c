/* world/untangle/untangle_report.c - what untangling could not free, or does not try to, in words.
 *
 * In: the state with the fewest pairs of triangles that cross. Out: between which surfaces they
 * are, in how many lines of intersection, and pins that keep cloth inside an obstacle. */
#include "world/untangle/untangle_parts.h"

#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>

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

tulle_status describe_left(untangling *work, char *text, size_t size) {
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

tulle_status refuse_bodies(tulle_world *world, tulle_error *error) {
    char text[WORLD_MESSAGE_BYTES / 2] = "";
    tulle_status const status = write_surfaces(world, world->model.cloths.count, text, sizeof text);
    if (status != TULLE_OK) return error_set(error, status, "no memory left to judge the start");
    return world_refuse_bodies(world, text, error);
}
