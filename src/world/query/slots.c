/* world/query/slots.c - ids: which cloth or obstacle an id names.
 *
 * An object keeps its slot as long as it lives, while its place among the others may change. A slot
 * that has become free is taken again with the next generation, so an id of what was there before
 * names nothing any more. */
#include "world/world_state.h"

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
