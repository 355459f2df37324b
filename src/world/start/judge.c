/* world/start/judge.c - asks the exact judge about the present surfaces, and keeps the list of
 * pairs that are ignored until they come apart. */
#include "base/error.h"
#include "base/sort.h"
#include "math/vec3.h"
#include "tulle/check.h"
#include "world/change/change.h"
#include "world/world_state.h"

#include <string.h>

tulle_status world_find_intersections(tulle_world *world, const double *positions,
                                      intersection_list *list, tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    size_t const surface_count = world->model.surface_count;
    tulle_check_body *const bodies =
        ARENA_NEW(&world->work.scratch, tulle_check_body, surface_count);
    uint32_t *const surface_of = ARENA_NEW(&world->work.scratch, uint32_t, surface_count);
    tulle_check_result result = {0};
    static const char no_memory[] = "no memory left for the judge of intersections";
    tulle_status status = TULLE_OK;
    if (!bodies || !surface_of) {
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, no_memory);
    } else {
        /* Present surfaces are the bodies of the judge. */
        size_t body_count = 0;
        for (size_t s = 0; s < surface_count; s++) {
            const surface_range *const range = &world->work.surfaces[s];
            if (!range->is_present) continue;
            const world_mesh *const mesh = world_surface_mesh(&world->model, s);
            bodies[body_count] = (tulle_check_body){
                .mesh = {positions + 3 * (size_t)range->vertex_begin, mesh->vertex_count,
                         mesh->triangles, mesh->triangle_count},
                .is_obstacle = range->is_obstacle && !range->is_body};
            surface_of[body_count++] = (uint32_t)s;
        }
        status = tulle_check_intersections(bodies, body_count, world->work.threads, &result, error);
    }
    list->count = 0;
    world->overlaps.count = 0;
    if (status == TULLE_OK && !ARRAY_RESERVE(&world->heap, list, result.pair_count))
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, no_memory);
    for (size_t i = 0; status == TULLE_OK && i < result.pair_count; i++) {
        const tulle_check_pair *const pair = &result.pairs[i];
        if (!world_pair_collides(&world->model, surface_of[pair->body_a], surface_of[pair->body_b]))
            continue;
        list->data[list->count++] = (tulle_intersection){
            surface_of[pair->body_a], pair->triangle_a, surface_of[pair->body_b], pair->triangle_b};
    }
    tulle_check_result_destroy(&result);
    arena_release(&world->work.scratch, mark);
    return status;
}

size_t world_count_intersecting_bodies(const tulle_world *world) {
    size_t count = 0;
    for (size_t i = 0; i < world->intersections.count; i++) {
        const tulle_intersection *const pair = &world->intersections.data[i];
        count += pair->object_a >= world->model.cloths.count &&
                 pair->object_b >= world->model.cloths.count;
    }
    return count;
}

/* The ignored pairs as sorted keys of world triangle numbers; room is there already. */
static void refresh_ignored_keys(tulle_world *world) {
    for (size_t i = 0; i < world->ignored.count; i++) {
        const tulle_intersection *const pair = &world->ignored.data[i];
        uint32_t const a = world->work.surfaces[pair->object_a].triangle_begin + pair->triangle_a;
        uint32_t const b = world->work.surfaces[pair->object_b].triangle_begin + pair->triangle_b;
        world->work.ignored_keys.data[i] = ignored_pair_key(a, b);
    }
    world->work.ignored_keys.count = world->ignored.count;
    sort_in_place(world->work.ignored_keys.data, world->work.ignored_keys.count, sizeof(uint64_t),
                  compare_u64);
}

tulle_status world_ignore_intersections(tulle_world *world, tulle_error *error) {
    size_t const count = world->intersections.count;
    if (!ARRAY_RESERVE(&world->heap, &world->ignored, count) ||
        !ARRAY_RESERVE(&world->heap, &world->work.ignored_keys, count)) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for ignored pairs");
    }
    memcpy(world->ignored.data, world->intersections.data, count * sizeof *world->ignored.data);
    world->ignored.count = count;
    refresh_ignored_keys(world);
    return TULLE_OK;
}

/* In the order of the judge. */
static int compare_pairs(const void *one, const void *two) {
    const tulle_intersection *const x = one, *const y = two;
    uint32_t const a[4] = {x->object_a, x->triangle_a, x->object_b, x->triangle_b};
    uint32_t const b[4] = {y->object_a, y->triangle_a, y->object_b, y->triangle_b};
    for (int k = 0; k < 4; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

tulle_status world_carry_ignored(tulle_world *world, tulle_error *error) {
    const world_change *const change = world->change;
    const tulle_world *const before = change->before;
    size_t const most = before->ignored.count + world->intersections.count;
    if (!ARRAY_RESERVE(&world->heap, &world->ignored, most) ||
        !ARRAY_RESERVE(&world->heap, &world->work.ignored_keys, most))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for ignored pairs");
    size_t count = 0;
    for (size_t i = 0; i < before->ignored.count; i++) {
        tulle_intersection pair = before->ignored.data[i];
        pair.object_a = change->targets[pair.object_a];
        pair.object_b = change->targets[pair.object_b];
        if (pair.object_a != TULLE_NONE && pair.object_b != TULLE_NONE)
            world->ignored.data[count++] = pair;
    }
    for (size_t i = 0; i < world->intersections.count; i++)
        world->ignored.data[count++] = world->intersections.data[i];
    world->ignored.count = count;
    sort_in_place(world->ignored.data, count, sizeof *world->ignored.data, compare_pairs);
    refresh_ignored_keys(world);
    return TULLE_OK;
}

tulle_status world_keep_ignored(tulle_world *world, tulle_error *error) {
    size_t const count = world->ignored.count;
    world->ignored_start.count = 0;
    if (count > 0 && !ARRAY_RESERVE(&world->heap, &world->ignored_start, count)) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for ignored pairs");
    }
    if (count > 0) {
        memcpy(world->ignored_start.data, world->ignored.data, count * sizeof *world->ignored.data);
    }
    world->ignored_start.count = count;
    return TULLE_OK;
}

void world_restore_ignored(tulle_world *world) {
    size_t const count = world->ignored_start.count;
    if (count > 0) {
        memcpy(world->ignored.data, world->ignored_start.data, count * sizeof *world->ignored.data);
    }
    world->ignored.count = count;
    refresh_ignored_keys(world);
}

void world_update_ignored(tulle_world *world, const double *positions) {
    size_t kept = 0;
    for (size_t i = 0; i < world->ignored.count; i++) {
        tulle_intersection const pair = world->ignored.data[i];
        const surface_range *const a = &world->work.surfaces[pair.object_a];
        const surface_range *const b = &world->work.surfaces[pair.object_b];
        /* As the judge sees it: of two surfaces, one at least follows no script. */
        bool const has_free = !a->is_obstacle || a->is_body || !b->is_obstacle || b->is_body;
        size_t const first = a->triangle_begin + pair.triangle_a;
        size_t const second = b->triangle_begin + pair.triangle_b;
        if (has_free &&
            tulle_check_triangle_pair(positions, world->model.topo.triangles + 3 * first,
                                      world->model.topo.triangles + 3 * second,
                                      pair.object_a == pair.object_b))
            world->ignored.data[kept++] = pair;
    }
    world->ignored.count = kept;
    refresh_ignored_keys(world);
}
