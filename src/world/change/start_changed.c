/* world/change/start_changed.c - the start of a world whose objects have changed (change.h): the
 * stages of start.c, with what stays in the place of its first state, and a judgement of what is
 * new. */
#include "base/error.h"
#include "dynamics/hysteresis.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/script.h"
#include "world/change/change.h"
#include "world/start/inside.h"
#include "world/start/start.h"

#include <stdio.h>
#include <string.h>

/* What is new as its def has it, what stays as it was. */
static void fill_arrays(tulle_world *world) {
    const world_change *const change = world->change;
    const tulle_world *const before = change->before;
    for (size_t s = 0; s < world->model.surface_count; s++) {
        uint32_t const source = change->sources[s];
        if (source == TULLE_NONE) {
            world_fill_surface(world, s);
            continue;
        }
        const surface_range *const range = &world->work.surfaces[s];
        size_t const from = before->work.surfaces[source].vertex_begin;
        memcpy(world->model.rest + 3 * (size_t)range->vertex_begin, before->model.rest + 3 * from,
               3 * (size_t)(range->vertex_end - range->vertex_begin) * sizeof(double));
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++)
            world->model.vertex_surface[v] = (uint32_t)s;
    }
    world_place_bodies(world, NULL);
    world_carry_state(world);
}

/* What an obstacle that was just added has at the time of the world. */
static tulle_status place_added(tulle_world *world, tulle_error *error) {
    uint32_t const added = world->change->added;
    tulle_status status = TULLE_OK;
    if (added != TULLE_NONE && added >= world->model.cloths.count) {
        size_t const index = added - world->model.cloths.count;
        const world_obstacle *const obstacle = &world->model.obstacles.data[index];
        double *const place = world->now.positions + 3 * (size_t)obstacle->vertex_begin;
        status = step_place_obstacle(&world->model, &world->work, index, place, error);
        world->now.is_present[index] =
            world->now.time >= obstacle->appear_time && world->now.time < obstacle->disappear_time;
    }
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        world->work.surfaces[world->model.cloths.count + i].is_present = world->now.is_present[i];
    size_t const offset = 3 * (world->model.cloth_vertex_count + 2 * world->model.body_count);
    memcpy(world->next.positions + offset, world->now.positions + offset,
           (3 * world->model.vertex_count - offset) * sizeof(double));
    return status;
}

/* The judgement of what is new. All else has been judged before. */
static tulle_status judge_added(tulle_world *world, tulle_error *error) {
    uint32_t const added = world->change->added;
    intersection_list *const list = &world->intersections;
    list->count = world->overlaps.count = 0;
    if (added == TULLE_NONE) return world_carry_ignored(world, error);
    tulle_status status = world_find_intersections(world, world->now.positions, list, error);
    if (status != TULLE_OK) return status;
    size_t count = 0;
    for (size_t i = 0; i < list->count; i++)
        if (list->data[i].object_a == added || list->data[i].object_b == added)
            list->data[count++] = list->data[i];
    list->count = count;
    if (world->model.def.start_intersections == TULLE_START_IGNORE)
        return world_carry_ignored(world, error);
    char when[WORLD_NAME_BYTES + 32];
    snprintf(when, sizeof when, "when '%s' is added", world_surface_name(&world->model, added));
    if (count > 0 && world->model.def.start_intersections == TULLE_START_REFUSE)
        return world_refuse_intersections(world, world->now.positions, when, error);
    if (count > 0) {
        world_mark_held(world);
        status = world_untangle(world, error);
        step_wake_all(&world->model, &world->now);
    }
    inside_question const question = {.when = when, .has_added = true, .added = added};
    return status == TULLE_OK ? world_refuse_inside(world, world->now.positions, question, error)
                              : status;
}

/* All up to the judgement. Leaves it to the caller to say that memory is short. */
static tulle_status make_arrays(tulle_world *world, tulle_error *error) {
    tulle_status status = world_join_surfaces(world, error);
    if (status == TULLE_OK && !world_allocate_start(world)) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status != TULLE_OK) return status;
    fill_arrays(world);
    if (!world_choose_pairs(world)) return TULLE_ERROR_OUT_OF_MEMORY;
    status = world_carry_first_cloths(world, error);
    if (status == TULLE_OK) status = world_build_model(world, error);
    if (status == TULLE_OK) status = world_derive_distances(world, error);
    return status == TULLE_OK ? world_set_grains(world) : status;
}

/* All behind it. */
static tulle_status finish_arrays(tulle_world *world) {
    slider_state const state = {world->now.positions, world->work.threads, &world->work.scratch};
    tulle_status status = TULLE_OK;
    if (world->model.plastic_count > 0)
        status = hysteresis_start(world->model.cloth_model, state, world->now.plastic);
    if (status != TULLE_OK) return status;
    world_carry_plastic(world);
    return world_finish_start(world);
}

tulle_status world_start_changed(tulle_world *world, tulle_error *error) {
    static const char no_memory[] = "no memory left to change the objects of the world";
    tulle_status status = make_arrays(world, error);
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return error_set(error, status, no_memory);
    if (status == TULLE_OK) status = place_added(world, error);
    if (status != TULLE_OK) return status;
    status = world_find_rooms(world, error);
    if (status == TULLE_ERROR_LIMIT) return status;
    if (status == TULLE_OK) {
        status = judge_added(world, error);
        if (status != TULLE_OK) return status;
        status = finish_arrays(world);
    }
    if (status == TULLE_ERROR_OUT_OF_MEMORY) return error_set(error, status, no_memory);
    if (status != TULLE_OK)
        return error_set(error, status, "the meshes have positions that are not finite");
    status = world_carry_contacts(world, error);
    if (status == TULLE_OK) status = world_carry_settings(world, error);
    return status == TULLE_OK ? world_carry_events(world, error) : status;
}
