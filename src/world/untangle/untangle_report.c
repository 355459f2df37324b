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

/* "3 of 'a' with 'b', 2 of 'b' with itself"; the length. */
static size_t write_surfaces(const tulle_world *world, const surface_count *counts, size_t count,
                             char *text, size_t size) {
    size_t length = 0;
    for (size_t i = 0; i < count && i < NAMED_SURFACES && length < size; i++) {
        bool const is_self = counts[i].a == counts[i].b;
        length += (size_t)snprintf(
            text + length, size - length, "%s%u of '%s' with %s%s%s", i > 0 ? ", " : "",
            counts[i].pairs, world_surface_name(world, counts[i].a), is_self ? "" : "'",
            is_self ? "itself" : world_surface_name(world, counts[i].b), is_self ? "" : "'");
    }
    if (count > NAMED_SURFACES && length < size)
        length += (size_t)snprintf(text + length, size - length, ", %zu other pairs of surfaces",
                                   count - NAMED_SURFACES);
    return length;
}

/* Pairs by surfaces, most first. */
static size_t count_by_surfaces(const intersection_list *list, surface_count *counts) {
    size_t count = 0;
    for (size_t i = 0; i < list->count; i++) {
        const tulle_intersection *const pair = &list->data[i];
        size_t at = 0;
        while (at < count && (counts[at].a != pair->object_a || counts[at].b != pair->object_b))
            at++;
        if (at == count) counts[count++] = (surface_count){pair->object_a, pair->object_b, 0};
        counts[at].pairs++;
    }
    qsort(counts, count, sizeof *counts, compare_counts);
    return count;
}

tulle_status describe_left(untangling *work, char *text, size_t size) {
    tulle_world *const world = work->world;
    const tulle_untangle_report *const report = &world->untangle_report;
    intersection_list *const left = &world->intersections;
    surface_count *const counts = ARENA_NEW(&world->scratch, surface_count, left->count);
    if (!counts) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t const count = count_by_surfaces(left, counts);
    tulle_status status = make_contours(work, left);
    if (status == TULLE_OK) status = decide_sides(work);
    if (status != TULLE_OK) return status;

    const contour_set *const contours = &work->contours;
    size_t lines = contours->loose_count, held = 0; /* held: pinned in a closed obstacle */
    for (size_t i = 0; i < contours->count; i++)
        lines += i == 0 || contours->crossings[i].contour != contours->crossings[i - 1].contour;
    for (size_t v = 0; v < world->cloth_vertex_count; v++)
        held += work->is_inside[v] && world->is_fixed[v];
    size_t length = (size_t)snprintf(
        text, size,
        "after %u rounds of untangling (%llu at the start; in %zu lines: ", report->rounds,
        (unsigned long long)report->intersections, lines);
    if (length < size) length += write_surfaces(world, counts, count, text + length, size - length);
    if (held > 0 && length < size)
        length +=
            (size_t)snprintf(text + length, size - length,
                             "; %zu pinned vertices lie inside an obstacle, where they stay", held);
    if (length < size) (void)snprintf(text + length, size - length, ")");
    return TULLE_OK;
}

tulle_status refuse_bodies(tulle_world *world, tulle_error *error) {
    char text[WORLD_MESSAGE_BYTES / 2];
    arena_mark const mark = arena_get_mark(&world->scratch);
    intersection_list *const list = &world->intersections;
    surface_count *const counts = ARENA_NEW(&world->scratch, surface_count, list->count);
    if (!counts)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to judge the start");
    size_t const count = count_by_surfaces(list, counts);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (counts[i].a >= world->cloths.count && counts[i].b >= world->cloths.count)
            counts[kept++] = counts[i];
    (void)write_surfaces(world, counts, kept, text, sizeof text);
    arena_release(&world->scratch, mark);
    return world_refuse_bodies(world, text, error);
}
