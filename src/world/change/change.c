/* world/change/change.c - adds objects to a world that runs, and removes objects: all or nothing
 * (change.h). */
#include "world/change/change.h"

#include "base/error.h"
#include "base/parallel.h"
#include "tulle/objects.h"
#include "world/record/record.h"

#include <string.h>

/* The objects that a world is to have. */
typedef struct object_lists {
    cloth_list cloths;
    obstacle_list obstacles;
    pair_law_list pair_laws;
} object_lists;

/* What is to come or to go. */
typedef struct wanted_change {
    const world_cloth *cloth; /* to be added, or null */
    const world_obstacle *obstacle;
    size_t removed; /* surface, or SIZE_MAX */
} wanted_change;

/* ---- lists ---- */

/* Whether a law names the object that goes; else renumbers what it names. */
static bool renumber_law(world_pair_law *law, size_t removed, size_t cloth_count) {
    bool const is_cloth = removed < cloth_count;
    size_t const gone = is_cloth ? removed : removed - cloth_count;
    size_t *const numbers[2] = {&law->first, &law->second};
    for (int k = 0; k < 2; k++) {
        bool const is_cloth_number =
            law->obstacle_count == 0 || (law->obstacle_count == 1 && k == 0);
        if (is_cloth_number != is_cloth) continue;
        if (*numbers[k] == gone) return true;
        if (*numbers[k] > gone) --*numbers[k];
    }
    return false;
}

/* The laws that were set for pairs of what stays. */
static void keep_laws(const pair_law_list *from, size_t removed, size_t cloth_count,
                      pair_law_list *to) {
    size_t const count = from->count; /* both may be the same list */
    to->count = 0;
    for (size_t i = 0; i < count; i++) {
        world_pair_law law = from->data[i];
        if (removed != SIZE_MAX && renumber_law(&law, removed, cloth_count)) continue;
        to->data[to->count++] = law;
    }
}

static void free_lists(memory *heap, object_lists *lists) {
    ARRAY_FREE(heap, &lists->cloths);
    ARRAY_FREE(heap, &lists->obstacles);
    ARRAY_FREE(heap, &lists->pair_laws);
}

/* What the objects own stays where it is: both lists point to it. */
static bool make_lists(tulle_world *world, const wanted_change *wanted, object_lists *lists) {
    memory *const heap = &world->heap;
    size_t const cloth_count = world->model.cloths.count;
    if (!ARRAY_RESERVE(heap, &lists->cloths, cloth_count + 1) ||
        !ARRAY_RESERVE(heap, &lists->obstacles, world->model.obstacles.count + 1) ||
        !ARRAY_RESERVE(heap, &lists->pair_laws, world->rules.pair_laws.count))
        return false;
    for (size_t i = 0; i < cloth_count; i++)
        if (i != wanted->removed)
            lists->cloths.data[lists->cloths.count++] = world->model.cloths.data[i];
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        if (cloth_count + i != wanted->removed)
            lists->obstacles.data[lists->obstacles.count++] = world->model.obstacles.data[i];
    if (wanted->cloth) lists->cloths.data[lists->cloths.count++] = *wanted->cloth;
    if (wanted->obstacle) lists->obstacles.data[lists->obstacles.count++] = *wanted->obstacle;
    keep_laws(&world->rules.pair_laws, wanted->removed, cloth_count, &lists->pair_laws);
    return true;
}

/* Which surface becomes which. */
static void map_surfaces(const tulle_world *world, const wanted_change *wanted,
                         const object_lists *lists, world_change *change) {
    size_t const before = world->model.cloths.count + world->model.obstacles.count;
    size_t const count = lists->cloths.count + lists->obstacles.count;
    change->added = wanted->cloth      ? (uint32_t)lists->cloths.count - 1
                    : wanted->obstacle ? (uint32_t)count - 1
                                       : TULLE_NONE;
    for (size_t s = 0; s < count; s++) change->sources[s] = TULLE_NONE;
    size_t next = 0;
    for (size_t s = 0; s < before; s++) {
        change->targets[s] = TULLE_NONE;
        if (s == wanted->removed) continue;
        if (next == change->added) next++;
        change->targets[s] = (uint32_t)next;
        change->sources[next++] = (uint32_t)s;
    }
}

/* ---- all or nothing ---- */

/* Puts insides that have not started in the place of the world's. */
static void begin_anew(tulle_world *world, const object_lists *lists, const world_change *change) {
    const tulle_world *const before = change->before;
    *world =
        (tulle_world){.heap = before->heap,
                      .model.def = before->model.def,
                      .model.paper = before->model.paper,
                      .model.cloths = lists->cloths,
                      .model.obstacles = lists->obstacles,
                      .slots.cloths = before->slots.cloths,
                      .slots.obstacles = before->slots.obstacles,
                      .rules.pair_laws = lists->pair_laws,
                      .rules.contact_materials.data = before->rules.contact_materials.data,
                      .rules.contact_materials.count = before->rules.contact_materials.count,
                      .rules.contact_materials.capacity = before->rules.contact_materials.capacity,
                      .rules.material_laws.data = before->rules.material_laws.data,
                      .rules.material_laws.count = before->rules.material_laws.count,
                      .rules.material_laws.capacity = before->rules.material_laws.capacity,
                      .attachments.data = before->attachments.data,
                      .attachments.count = before->attachments.count,
                      .attachments.capacity = before->attachments.capacity,
                      .rules.pair_filter = before->rules.pair_filter,
                      .rules.pair_context = before->rules.pair_context,
                      .work.threads = before->work.threads,
                      .host_tasks = before->host_tasks,
                      .work.tasks = before->work.tasks,
                      .is_in_batch = before->is_in_batch,
                      .work.stop.is_wanted = before->work.stop.is_wanted,
                      .work.stop.context = before->work.stop.context,
                      .work.patch_rules.keeps_all = before->work.patch_rules.keeps_all,
                      .now.step_count = before->now.step_count,
                      .work.step_end = before->work.step_end,
                      .intersections.data = before->intersections.data,
                      .intersections.capacity = before->intersections.capacity,
                      .overlaps.data = before->overlaps.data,
                      .overlaps.capacity = before->overlaps.capacity,
                      .change = change,
                      .recording = before->recording,
                      .untangle_report = before->untangle_report};
    memcpy(world->message, before->message, sizeof world->message);
    world->work.scratch = arena_make(&world->heap);
    world_point_work(world);
    /* as the start had them; world_carry_settings puts back what was changed since */
    memcpy(world->model.def.gravity, before->first.settings.gravity,
           sizeof world->model.def.gravity);
    world->model.def.wind = before->first.settings.wind;
    world->first.def_hash = before->first.def_hash;
    world->now.time = before->now.time;
    world_renumber_slots(world);
}

/* Puts the insides before in their place again. What was found out stays: pairs of triangles with
 * what was to be added, which has the number behind the last one. */
static void go_back(tulle_world *world, tulle_world *before, object_lists *lists) {
    const world_change *const change = world->change;
    uint32_t const behind = (uint32_t)(before->model.cloths.count + before->model.obstacles.count);
    for (size_t i = 0; i < world->intersections.count; i++) {
        tulle_intersection *const pair = &world->intersections.data[i];
        uint32_t *const objects[2] = {&pair->object_a, &pair->object_b};
        for (int k = 0; k < 2; k++) {
            uint32_t const source = change->sources[*objects[k]];
            *objects[k] = source == TULLE_NONE ? behind : source;
        }
    }
    world_release_start(world);
    free_lists(&world->heap, lists);
    before->heap = world->heap;
    before->intersections = world->intersections;
    before->overlaps.data = world->overlaps.data;
    before->overlaps.count = world->overlaps.count;
    before->overlaps.capacity = world->overlaps.capacity;
    before->untangle_report = world->untangle_report;
    *world = *before;
    world_point_work(world);
    world_renumber_slots(world);
}

/* Releases the insides before, and the object that has gone. */
static void let_go(tulle_world *world, tulle_world *before, size_t removed) {
    tulle_world now = *world;
    before->heap = now.heap;
    before->events = NULL; /* they were carried over */
    *world = *before;      /* what is released lies where it was made */
    world_point_work(world);
    size_t const cloth_count = world->model.cloths.count;
    bool const is_cloth = removed < cloth_count;
    world_release_start(world);
    if (is_cloth) world_destroy_cloth(&world->heap, &world->model.cloths.data[removed]);
    if (!is_cloth && removed != SIZE_MAX)
        world_destroy_obstacle(&world->heap, &world->model.obstacles.data[removed - cloth_count]);
    object_lists lists = {world->model.cloths, world->model.obstacles, world->rules.pair_laws};
    free_lists(&world->heap, &lists);
    now.heap = world->heap;
    *world = now;
}

static tulle_status change_objects(tulle_world *world, const wanted_change *wanted,
                                   tulle_error *error) {
    memory *const heap = &world->heap;
    size_t const count = world->model.cloths.count + world->model.obstacles.count;
    object_lists lists = {0};
    world_change change = {0};
    tulle_world before;
    change.sources = memory_allocate(heap, (count + 1) * sizeof *change.sources);
    change.targets = memory_allocate(heap, (count + 1) * sizeof *change.targets);
    tulle_status status =
        change.sources && change.targets && make_lists(world, wanted, &lists)
            ? TULLE_OK
            : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to change the objects");
    if (status != TULLE_OK) {
        free_lists(heap, &lists);
    } else {
        map_surfaces(world, wanted, &lists, &change);
        before = *world;
        world_point_work(&before);
        change.before = &before;
        begin_anew(world, &lists, &change);
        const tulle_tasks *const tasks = parallel_use(world->work.tasks);
        status = world_start_changed(world, error);
        (void)parallel_use(tasks);
        if (status == TULLE_OK) {
            world->is_started = true;
            let_go(world, &before, wanted->removed);
            world->change = NULL;
            world_release_first_cloth(world);
        } else {
            go_back(world, &before, &lists);
        }
    }
    memory_release(heap, change.sources, (count + 1) * sizeof *change.sources);
    memory_release(heap, change.targets, (count + 1) * sizeof *change.targets);
    return status;
}

tulle_status world_add_late(tulle_world *world, const world_cloth *cloth,
                            const world_obstacle *obstacle, tulle_error *error) {
    wanted_change const wanted = {cloth, obstacle, SIZE_MAX};
    return change_objects(world, &wanted, error);
}

/* ---- calls ---- */

/* Before the start there is nothing but the lists. */
static void remove_early(tulle_world *world, size_t removed) {
    size_t const cloth_count = world->model.cloths.count;
    keep_laws(&world->rules.pair_laws, removed, cloth_count, &world->rules.pair_laws);
    if (removed < cloth_count) {
        world_cloth *const gone = &world->model.cloths.data[removed];
        world_destroy_cloth(&world->heap, gone);
        memmove(gone, gone + 1, (--world->model.cloths.count - removed) * sizeof *gone);
    } else {
        world_obstacle *const gone = &world->model.obstacles.data[removed - cloth_count];
        world_destroy_obstacle(&world->heap, gone);
        memmove(gone, gone + 1,
                (--world->model.obstacles.count - (removed - cloth_count)) * sizeof *gone);
    }
    world_renumber_slots(world);
}

/* Removes a surface in a call that is recorded. */
static tulle_status remove_surface(tulle_world *world, size_t surface, const recorded_call *call,
                                   tulle_error *error) {
    tulle_status status = world_begin_call(world, call, error);
    if (status != TULLE_OK) return status;
    if (world->is_started) {
        wanted_change const wanted = {NULL, NULL, surface};
        status = change_objects(world, &wanted, error);
    } else {
        remove_early(world, surface);
    }
    world_end_call(world, status);
    return status;
}

tulle_status tulle_world_remove_cloth(tulle_world *world, tulle_cloth_id id, tulle_error *error) {
    size_t const index = world_find_cloth(world, id);
    if (index == SIZE_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world has no such cloth");
    return remove_surface(world, index,
                          &(recorded_call){.kind = RECORD_REMOVE_CLOTH,
                                           .ids = {id.index},
                                           .generations = {id.generation}},
                          error);
}

tulle_status tulle_world_remove_obstacle(tulle_world *world, tulle_obstacle_id id,
                                         tulle_error *error) {
    size_t const index = world_find_obstacle(world, id);
    if (index == SIZE_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world has no such obstacle");
    return remove_surface(world, world->model.cloths.count + index,
                          &(recorded_call){.kind = RECORD_REMOVE_OBSTACLE,
                                           .ids = {id.index},
                                           .generations = {id.generation}},
                          error);
}
