/* world/pair_laws.c - laws of contact that are set for pairs of objects before the start. */
#include "base/error.h"
#include "world/defs.h"
#include "world/world_state.h"

static world_pair_law *find_entry(const tulle_world *world, const world_pair_law *wanted) {
    for (size_t i = 0; i < world->pair_laws.count; i++) {
        world_pair_law *const entry = &world->pair_laws.data[i];
        if (entry->first == wanted->first && entry->second == wanted->second &&
            entry->obstacle_count == wanted->obstacle_count)
            return entry;
    }
    return NULL;
}

const tulle_contact_law *world_find_pair_law(const tulle_world *world, size_t a, size_t b) {
    size_t const cloth_count = world->cloths.count, low = a < b ? a : b, high = a < b ? b : a;
    bool const is_obstacle[2] = {low >= cloth_count, high >= cloth_count};
    world_pair_law const wanted = {.first = is_obstacle[0] ? low - cloth_count : low,
                                   .second = is_obstacle[1] ? high - cloth_count : high,
                                   .obstacle_count = is_obstacle[0] + is_obstacle[1]};
    world_pair_law const *const entry = find_entry(world, &wanted);
    return entry ? &entry->law : NULL;
}

static tulle_status refuse(tulle_error *error, const char *why) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "law of a pair: %s", why);
}

static tulle_status set_law(tulle_world *world, world_pair_law entry, const tulle_contact_law *law,
                            tulle_error *error) {
    if (world->is_started) return refuse(error, "the world has started; set it before");
    if (!law) return refuse(error, "the law is null");
    tulle_status const status = contact_law_check(law, "law of a pair", error);
    if (status != TULLE_OK) return status;
    entry.law = *law;
    world_pair_law *const earlier = find_entry(world, &entry);
    if (earlier) {
        *earlier = entry;
        return TULLE_OK;
    }
    if (!ARRAY_RESERVE(&world->heap, &world->pair_laws, 1))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for the law of a pair");
    world->pair_laws.data[world->pair_laws.count++] = entry;
    return TULLE_OK;
}

static bool has_cloth(const tulle_world *world, tulle_cloth_id id) {
    return id.generation == 1 && id.index < world->cloths.count;
}

static bool has_obstacle(const tulle_world *world, tulle_obstacle_id id) {
    return id.generation == 1 && id.index < world->obstacles.count;
}

tulle_status tulle_world_set_cloth_cloth_law(tulle_world *world, tulle_cloth_id a, tulle_cloth_id b,
                                             const tulle_contact_law *law, tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    if (!has_cloth(world, a) || !has_cloth(world, b))
        return refuse(error, "the world has no such cloth");
    if (a.index == b.index) return refuse(error, "the same cloth is named twice");
    bool const is_ordered = a.index < b.index;
    world_pair_law const entry = {.first = is_ordered ? a.index : b.index,
                                  .second = is_ordered ? b.index : a.index};
    return set_law(world, entry, law, error);
}

tulle_status tulle_world_set_cloth_obstacle_law(tulle_world *world, tulle_cloth_id cloth,
                                                tulle_obstacle_id obstacle,
                                                const tulle_contact_law *law, tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    if (!has_cloth(world, cloth)) return refuse(error, "the world has no such cloth");
    if (!has_obstacle(world, obstacle)) return refuse(error, "the world has no such obstacle");
    world_pair_law const entry = {
        .first = cloth.index, .second = obstacle.index, .obstacle_count = 1};
    return set_law(world, entry, law, error);
}

tulle_status tulle_world_set_obstacle_obstacle_law(tulle_world *world, tulle_obstacle_id a,
                                                   tulle_obstacle_id b,
                                                   const tulle_contact_law *law,
                                                   tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    if (!has_obstacle(world, a) || !has_obstacle(world, b))
        return refuse(error, "the world has no such obstacle");
    if (a.index == b.index) return refuse(error, "the same obstacle is named twice");
    world_obstacle const *const obstacles = world->obstacles.data;
    if (!obstacles[a.index].body.is_dynamic && !obstacles[b.index].body.is_dynamic)
        return refuse(error, "neither obstacle is a rigid body, so they do not touch");
    bool const is_ordered = a.index < b.index;
    world_pair_law const entry = {.first = is_ordered ? a.index : b.index,
                                  .second = is_ordered ? b.index : a.index,
                                  .obstacle_count = 2};
    return set_law(world, entry, law, error);
}
