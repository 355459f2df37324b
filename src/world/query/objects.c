/* world/query/objects.c - cloths and obstacles as objects: what they are, what the host keeps with
 * them, and which pairs of them collide (tulle/query.h). */
#include "base/error.h"
#include "world/change/change.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <string.h>

/* ---- ids: which cloth or obstacle an id names ----
 *
 * An object keeps its slot as long as it lives, while its place among the others may change. A slot
 * that has become free is taken again with the next generation, so an id of what was there before
 * names nothing any more. */

size_t world_find_cloth(const tulle_world *world, tulle_cloth_id id) {
    if (!world || id.index >= world->slots.cloths.count) return SIZE_MAX;
    const object_slot *const slot = &world->slots.cloths.data[id.index];
    return slot->generation == id.generation ? slot->index : SIZE_MAX;
}

size_t world_find_obstacle(const tulle_world *world, tulle_obstacle_id id) {
    if (!world || id.index >= world->slots.obstacles.count) return SIZE_MAX;
    const object_slot *const slot = &world->slots.obstacles.data[id.index];
    return slot->generation == id.generation ? slot->index : SIZE_MAX;
}

tulle_cloth_id world_get_cloth_id(const tulle_world *world, size_t cloth) {
    uint32_t const slot = world->model.cloths.data[cloth].slot;
    return (tulle_cloth_id){slot, world->slots.cloths.data[slot].generation};
}

tulle_obstacle_id world_get_obstacle_id(const tulle_world *world, size_t obstacle) {
    uint32_t const slot = world->model.obstacles.data[obstacle].slot;
    return (tulle_obstacle_id){slot, world->slots.obstacles.data[slot].generation};
}

/* A slot whose generations are used up stays free. */
uint32_t world_find_free_slot(const slot_list *slots) {
    size_t k = 0;
    while (k < slots->count &&
           (slots->data[k].index != SIZE_MAX || slots->data[k].generation == UINT32_MAX))
        k++;
    return (uint32_t)k;
}

tulle_obstacle_id world_find_next_obstacle(const tulle_world *world) {
    const slot_list *const slots = &world->slots.obstacles;
    uint32_t const slot = world_find_free_slot(slots);
    return (tulle_obstacle_id){slot, slot < slots->count ? slots->data[slot].generation + 1 : 1};
}

void world_take_slot(slot_list *slots, uint32_t slot, size_t index) {
    if (slot == slots->count) slots->data[slots->count++].generation = 0;
    slots->data[slot].generation++;
    slots->data[slot].index = index;
}

void world_return_slot(slot_list *slots, uint32_t slot) {
    slots->data[slot].index = SIZE_MAX;
    if (--slots->data[slot].generation == 0) slots->count--;
}

void world_renumber_slots(tulle_world *world) {
    for (size_t i = 0; i < world->slots.cloths.count; i++)
        world->slots.cloths.data[i].index = SIZE_MAX;
    for (size_t i = 0; i < world->slots.obstacles.count; i++)
        world->slots.obstacles.data[i].index = SIZE_MAX;
    for (size_t i = 0; i < world->model.cloths.count; i++)
        world->slots.cloths.data[world->model.cloths.data[i].slot].index = i;
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        world->slots.obstacles.data[world->model.obstacles.data[i].slot].index = i;
}

/* ---- objects ---- */

tulle_object_id tulle_object_from_cloth(tulle_cloth_id id) {
    if (id.generation == 0) return (tulle_object_id){0};
    return (tulle_object_id){TULLE_OBJECT_CLOTH, id.index, id.generation};
}

tulle_object_id tulle_object_from_obstacle(tulle_obstacle_id id) {
    if (id.generation == 0) return (tulle_object_id){0};
    return (tulle_object_id){TULLE_OBJECT_OBSTACLE, id.index, id.generation};
}

tulle_object_id tulle_world_get_object(const tulle_world *world, uint32_t number) {
    size_t const cloth_count = world ? world->model.cloths.count : 0;
    size_t const count = world ? cloth_count + world->model.obstacles.count : 0;
    if (number >= count) return (tulle_object_id){0};
    bool const is_cloth = number < cloth_count;
    uint32_t const slot = is_cloth ? world->model.cloths.data[number].slot
                                   : world->model.obstacles.data[number - cloth_count].slot;
    const slot_list *const slots = is_cloth ? &world->slots.cloths : &world->slots.obstacles;
    return (tulle_object_id){is_cloth ? TULLE_OBJECT_CLOTH : TULLE_OBJECT_OBSTACLE, slot,
                             slots->data[slot].generation};
}

size_t world_find_object(const tulle_world *world, tulle_object_id id, tulle_error *error) {
    size_t cloth = SIZE_MAX, obstacle = SIZE_MAX;
    if (id.kind == TULLE_OBJECT_CLOTH)
        cloth = world_find_cloth(world, (tulle_cloth_id){id.index, id.generation});
    if (id.kind == TULLE_OBJECT_OBSTACLE)
        obstacle = world_find_obstacle(world, (tulle_obstacle_id){id.index, id.generation});
    if (cloth != SIZE_MAX) return cloth;
    if (obstacle != SIZE_MAX) return world->model.cloths.count + obstacle;
    error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world has no such object");
    return SIZE_MAX;
}

tulle_counts tulle_world_get_counts(const tulle_world *world) {
    tulle_counts counts = {0};
    if (!world) return counts;
    counts.cloths = world->model.cloths.count;
    counts.obstacles = world->model.obstacles.count;
    for (size_t i = 0; i < counts.cloths + counts.obstacles; i++) {
        const world_mesh *const mesh = world_surface_mesh(&world->model, i);
        bool const is_cloth = i < counts.cloths;
        *(is_cloth ? &counts.cloth_vertices : &counts.obstacle_vertices) += mesh->vertex_count;
        *(is_cloth ? &counts.cloth_triangles : &counts.obstacle_triangles) += mesh->triangle_count;
    }
    return counts;
}

tulle_object_info tulle_object_get_info(const tulle_world *world, tulle_object_id id) {
    size_t const object = world_find_object(world, id, NULL);
    if (object == SIZE_MAX) return (tulle_object_info){0};
    const world_mesh *const mesh = world_surface_mesh(&world->model, object);
    const world_label *const label = world_get_label(&world->model, object);
    bool const is_static =
        object >= world->model.cloths.count &&
        world->model.obstacles.data[object - world->model.cloths.count].is_static;
    return (tulle_object_info){.name = world_surface_name(&world->model, object),
                               .vertex_count = mesh->vertex_count,
                               .triangle_count = mesh->triangle_count,
                               .triangles = mesh->triangles,
                               .category = label->category,
                               .mask = label->mask,
                               .is_static = is_static};
}

tulle_status tulle_object_set_user_data(tulle_world *world, tulle_object_id id, void *user_data,
                                        tulle_error *error) {
    size_t const object = world_find_object(world, id, error);
    if (object == SIZE_MAX) return TULLE_ERROR_INVALID_ARGUMENT;
    world_get_label(&world->model, object)->user_data = user_data;
    return TULLE_OK;
}

void *tulle_object_get_user_data(const tulle_world *world, tulle_object_id id) {
    size_t const object = world_find_object(world, id, NULL);
    return object == SIZE_MAX ? NULL : world_get_label(&world->model, object)->user_data;
}

/* ---- which pairs collide ---- */

static tulle_status refuse_started(tulle_error *error) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "choose which objects collide before the world starts");
}

tulle_status tulle_object_set_filter(tulle_world *world, tulle_object_id id, uint32_t category,
                                     uint32_t mask, tulle_error *error) {
    size_t const object = world_find_object(world, id, error);
    if (object == SIZE_MAX) return TULLE_ERROR_INVALID_ARGUMENT;
    if (world->is_started) return refuse_started(error);
    world_label *const label = world_get_label(&world->model, object);
    label->category = category;
    label->mask = mask;
    WORLD_RECORD(world, .kind = RECORD_FILTER, .ids = {id.index, (uint32_t)id.kind},
                 .generations = {id.generation}, .numbers = {category, mask});
    return TULLE_OK;
}

tulle_status tulle_world_set_pair_filter(tulle_world *world, tulle_pair_filter filter,
                                         void *context, tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (world->is_started) return refuse_started(error);
    world->rules.pair_filter = filter;
    world->rules.pair_context = context;
    WORLD_RECORD(world, .kind = RECORD_PAIR_FILTER, .numbers = {filter != NULL});
    return TULLE_OK;
}

bool world_choose_pairs(tulle_world *world) {
    const world_change *const change = world->change; /* what was there before stays as it is */
    size_t const cloth_count = world->model.cloths.count,
                 count = cloth_count + world->model.obstacles.count;
    for (size_t a = 0; a < count; a++) {
        for (size_t b = a + 1; b < count; b++) {
            const world_label *const first = world_get_label(&world->model, a);
            const world_label *const second = world_get_label(&world->model, b);
            bool const may_meet = a < cloth_count ||
                                  world->model.obstacles.data[a - cloth_count].body.is_dynamic ||
                                  world->model.obstacles.data[b - cloth_count].body.is_dynamic;
            bool collides = (first->category & second->mask) && (second->category & first->mask);
            bool const is_known =
                change && change->sources[a] != TULLE_NONE && change->sources[b] != TULLE_NONE;
            if (is_known)
                collides = world_pair_collides(&change->before->model, change->sources[a],
                                               change->sources[b]);
            if (collides && may_meet && world->rules.pair_filter && !is_known) {
                collides =
                    world->rules.pair_filter(world->rules.pair_context, world,
                                             tulle_world_get_object(world, (uint32_t)a),
                                             tulle_world_get_object(world, (uint32_t)b)) != 0;
                WORLD_RECORD(world, .kind = RECORD_ANSWER, .numbers = {collides});
            }
            if (collides || !may_meet) continue;
            if (!world->model.collides) {
                world->model.collides = memory_allocate(&world->heap, count * count);
                if (!world->model.collides) return false;
                memset(world->model.collides, 1, count * count);
            }
            world->model.collides[a * count + b] = world->model.collides[b * count + a] = 0;
        }
    }
    world->work.set.collides = world->model.collides;
    return true;
}
