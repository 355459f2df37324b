/* world/pair_laws.c - laws of contact that the user sets before the start, for pairs of objects and
 * for pairs of contact materials. A contact material is the name that an object gives what it is
 * made of. */
#include "base/error.h"
#include "world/defs.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <stdio.h>
#include <string.h>

static world_pair_law *find_entry(const tulle_world *world, const world_pair_law *wanted) {
    for (size_t i = 0; i < world->rules.pair_laws.count; i++) {
        world_pair_law *const entry = &world->rules.pair_laws.data[i];
        if (entry->first == wanted->first && entry->second == wanted->second &&
            entry->obstacle_count == wanted->obstacle_count)
            return entry;
    }
    return NULL;
}

static uint32_t find_material(const tulle_world *world, const char *name) {
    for (size_t i = 0; i < world->rules.contact_materials.count; i++)
        if (strcmp(world->rules.contact_materials.data[i].name, name) == 0) return (uint32_t)i;
    return TULLE_NONE;
}

uint32_t world_add_contact_material(tulle_world *world, const char *name) {
    if (!name) return TULLE_NONE;
    uint32_t const known = find_material(world, name);
    if (known != TULLE_NONE) return known;
    size_t const count = world->rules.contact_materials.count++;
    world_contact_material *const added = &world->rules.contact_materials.data[count];
    snprintf(added->name, sizeof added->name, "%s", name);
    return (uint32_t)count;
}

static world_material_law *find_material_law(const tulle_world *world, uint32_t a, uint32_t b) {
    if (a == TULLE_NONE || b == TULLE_NONE) return NULL;
    uint32_t const low = a < b ? a : b, high = a < b ? b : a;
    for (size_t i = 0; i < world->rules.material_laws.count; i++) {
        world_material_law *const entry = &world->rules.material_laws.data[i];
        if (entry->first == low && entry->second == high) return entry;
    }
    return NULL;
}

const tulle_contact_law *world_find_pair_law(const tulle_world *world, size_t a, size_t b) {
    size_t const surfaces[2] = {a < b ? a : b, a < b ? b : a},
                 cloth_count = world->model.cloths.count;
    size_t numbers[2]; /* among the cloths or among the obstacles */
    uint32_t materials[2];
    int obstacle_count = 0;
    for (int i = 0; i < 2; i++) {
        bool const is_cloth = surfaces[i] < cloth_count;
        numbers[i] = is_cloth ? surfaces[i] : surfaces[i] - cloth_count;
        materials[i] = is_cloth ? world->model.cloths.data[numbers[i]].contact_material
                                : world->model.obstacles.data[numbers[i]].contact_material;
        obstacle_count += !is_cloth;
    }
    world_pair_law const wanted = {
        .first = numbers[0], .second = numbers[1], .obstacle_count = obstacle_count};
    const world_pair_law *const entry = find_entry(world, &wanted);
    if (entry) return &entry->law;
    const world_material_law *const material = find_material_law(world, materials[0], materials[1]);
    return material ? &material->law : NULL;
}

static tulle_status refuse(tulle_error *error, const char *why) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "law of a pair: %s", why);
}

static tulle_status check_law(const tulle_contact_law *law, tulle_error *error) {
    if (!law) return refuse(error, "the law is null");
    return contact_law_check(law, "law of a pair", error);
}

static tulle_status set_law(tulle_world *world, world_pair_law entry, const tulle_contact_law *law,
                            tulle_error *error) {
    tulle_status const status = check_law(law, error);
    if (status != TULLE_OK) return status;
    size_t const cloth_count = world->model.cloths.count;
    if (world->is_started)
        return world_change_law(world, entry.first + (entry.obstacle_count > 1 ? cloth_count : 0),
                                entry.second + (entry.obstacle_count > 0 ? cloth_count : 0), law,
                                error);
    entry.law = *law;
    world_pair_law *const earlier = find_entry(world, &entry);
    if (earlier) {
        *earlier = entry;
        return TULLE_OK;
    }
    if (!ARRAY_RESERVE(&world->heap, &world->rules.pair_laws, 1))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for the law of a pair");
    world->rules.pair_laws.data[world->rules.pair_laws.count++] = entry;
    return TULLE_OK;
}

/* Sets the law that a call gave, and records the call by the indices that it named. */
static tulle_status set_called_law(tulle_world *world, world_pair_law entry,
                                   const tulle_contact_law *law, recorded_call call,
                                   tulle_error *error) {
    tulle_status const status = set_law(world, entry, law, error);
    if (status != TULLE_OK || !world->recording) return status;
    call.def.law = *law;
    world_record(world, &call);
    return status;
}

/* The entry of a pair, by the lower index first. */
static world_pair_law make_entry(size_t first, size_t second, int obstacle_count) {
    bool const is_ordered = obstacle_count == 1 || first < second;
    return (world_pair_law){.first = is_ordered ? first : second,
                            .second = is_ordered ? second : first,
                            .obstacle_count = obstacle_count};
}

tulle_status tulle_world_set_cloth_cloth_law(tulle_world *world, tulle_cloth_id a, tulle_cloth_id b,
                                             const tulle_contact_law *law, tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    size_t const first = world_find_cloth(world, a), second = world_find_cloth(world, b);
    if (first == SIZE_MAX || second == SIZE_MAX)
        return refuse(error, "the world has no such cloth");
    if (first == second) return refuse(error, "the same cloth is named twice");
    return set_called_law(world, make_entry(first, second, 0), law,
                          (recorded_call){.kind = RECORD_CLOTH_CLOTH_LAW,
                                          .ids = {a.index, b.index},
                                          .generations = {a.generation, b.generation}},
                          error);
}

tulle_status tulle_world_set_cloth_obstacle_law(tulle_world *world, tulle_cloth_id cloth,
                                                tulle_obstacle_id obstacle,
                                                const tulle_contact_law *law, tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    size_t const first = world_find_cloth(world, cloth);
    size_t const second = world_find_obstacle(world, obstacle);
    if (first == SIZE_MAX) return refuse(error, "the world has no such cloth");
    if (second == SIZE_MAX) return refuse(error, "the world has no such obstacle");
    return set_called_law(world, make_entry(first, second, 1), law,
                          (recorded_call){.kind = RECORD_CLOTH_OBSTACLE_LAW,
                                          .ids = {cloth.index, obstacle.index},
                                          .generations = {cloth.generation, obstacle.generation}},
                          error);
}

tulle_status tulle_world_set_obstacle_obstacle_law(tulle_world *world, tulle_obstacle_id a,
                                                   tulle_obstacle_id b,
                                                   const tulle_contact_law *law,
                                                   tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    size_t const first = world_find_obstacle(world, a), second = world_find_obstacle(world, b);
    if (first == SIZE_MAX || second == SIZE_MAX)
        return refuse(error, "the world has no such obstacle");
    if (first == second) return refuse(error, "the same obstacle is named twice");
    const world_obstacle *const obstacles = world->model.obstacles.data;
    if (!obstacles[first].body.is_dynamic && !obstacles[second].body.is_dynamic)
        return refuse(error, "neither obstacle is a rigid body, so they do not touch");
    return set_called_law(world, make_entry(first, second, 2), law,
                          (recorded_call){.kind = RECORD_OBSTACLE_OBSTACLE_LAW,
                                          .ids = {a.index, b.index},
                                          .generations = {a.generation, b.generation}},
                          error);
}

static bool is_preset(const char *name) {
    tulle_material unused;
    return tulle_material_preset(name, &unused) == TULLE_OK;
}

/* Appends to the list of names; cuts what does not fit. */
static void list_name(char *list, size_t size, const char *name) {
    size_t const used = strlen(list);
    snprintf(list + used, size - used, "%s%s", used > 0 ? ", " : "", name);
}

static tulle_status refuse_material(const tulle_world *world, const char *name,
                                    tulle_error *error) {
    char list[1000] = "";
    for (size_t i = 0; i < world->rules.contact_materials.count; i++)
        list_name(list, sizeof list, world->rules.contact_materials.data[i].name);
    const char *preset;
    for (size_t i = 0; (preset = tulle_material_preset_name(i)); i++)
        if (find_material(world, preset) == TULLE_NONE) list_name(list, sizeof list, preset);
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "law of a pair: '%.100s' is the contact material of no cloth or obstacle and "
                     "no preset; there are %s",
                     name, list);
}

tulle_status tulle_world_set_material_law(tulle_world *world, const char *a, const char *b,
                                          const tulle_contact_law *law, tulle_error *error) {
    if (!world) return refuse(error, "the world is null");
    if (!a || !b) return refuse(error, "the name of a contact material is null");
    if (world->is_started) return refuse(error, "the world has started; set it before");
    tulle_status const status = check_law(law, error);
    if (status != TULLE_OK) return status;
    const char *const names[2] = {a, b};
    for (int i = 0; i < 2; i++)
        if (find_material(world, names[i]) == TULLE_NONE && !is_preset(names[i]))
            return refuse_material(world, names[i], error);
    if (!ARRAY_RESERVE(&world->heap, &world->rules.contact_materials, 2) ||
        !ARRAY_RESERVE(&world->heap, &world->rules.material_laws, 1))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for the law of a pair");
    uint32_t const first = world_add_contact_material(world, a);
    uint32_t const second = world_add_contact_material(world, b);
    if (world->recording)
        world_record(
            world, &(recorded_call){.kind = RECORD_MATERIAL_LAW, .texts = {a, b}, .def.law = *law});
    world_material_law *const earlier = find_material_law(world, first, second);
    if (earlier) {
        earlier->law = *law;
        return TULLE_OK;
    }
    world->rules.material_laws.data[world->rules.material_laws.count++] =
        (world_material_law){.first = first < second ? first : second,
                             .second = first < second ? second : first,
                             .law = *law};
    return TULLE_OK;
}
