/* world/settings.c - what a host may change while the world runs: gravity and wind, materials,
 * thickness and pins (tulle/live.h), laws of pairs.
 *
 * In: the calls of the host, checked as the defs are. Out: world->def, world->laws, the materials
 * and pins of cloths and the machinery made of them, which steps read. What differs from what was
 * in force at the start is part of the state (state.c). */
#include "tulle/live.h"

#include "base/error.h"
#include "base/hash.h"
#include "step/bodies/bodies_sleep.h"
#include "step/sleep/cloth_sleep.h"
#include "world/change/change.h"
#include "world/defs.h"
#include "world/fields/fields.h"
#include "world/record/record.h"
#include "world/start/start.h"

#include <math.h>
#include <string.h>

/* ---- in force ---- */

static world_settings get_settings(const tulle_world *world) {
    world_settings settings = {.wind = world->model.def.wind};
    memcpy(settings.gravity, world->model.def.gravity, sizeof settings.gravity);
    return settings;
}

static tulle_status check_settings(const tulle_world *world, const world_settings *settings,
                                   tulle_error *error) {
    tulle_world_def def = world->model.def;
    memcpy(def.gravity, settings->gravity, sizeof def.gravity);
    def.wind = settings->wind;
    return world_def_check(&def, error);
}

static void set_settings(tulle_world *world, const world_settings *settings) {
    memcpy(world->model.def.gravity, settings->gravity, sizeof world->model.def.gravity);
    world->model.def.wind = settings->wind;
}

static size_t get_laws_size(const tulle_world *world) {
    return world->model.surface_count * world->model.surface_count * sizeof(contact_law);
}

/* Keeps the laws of the start before one of them changes. */
static tulle_status keep_first_laws(tulle_world *world, tulle_error *error) {
    if (world->first.laws) return TULLE_OK;
    world->first.laws = memory_allocate(&world->heap, get_laws_size(world));
    if (!world->first.laws)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for laws of pairs");
    memcpy(world->first.laws, world->model.laws, get_laws_size(world));
    return TULLE_OK;
}

static size_t get_materials_size(const tulle_world *world) {
    return world->model.cloths.count * sizeof(tulle_material);
}

static size_t get_releases_size(const tulle_world *world) {
    return world->model.pin_count * sizeof(double);
}

static void list_cloths(const tulle_world *world, tulle_material *materials, double *releases) {
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        materials[i] = cloth->material;
        for (size_t p = 0; p < cloth->pin_count; p++) *releases++ = cloth->pins[p].release_time;
    }
}

/* Keeps materials and pins of the start before one of them changes. */
static tulle_status keep_first_cloths(tulle_world *world, tulle_error *error) {
    if (world->first.materials) return TULLE_OK;
    world->first.materials = memory_allocate(&world->heap, get_materials_size(world));
    world->first.releases = memory_allocate(&world->heap, get_releases_size(world));
    if (!world->first.materials || !world->first.releases) {
        memory_release(&world->heap, world->first.materials, get_materials_size(world));
        memory_release(&world->heap, world->first.releases, get_releases_size(world));
        world->first.materials = NULL;
        world->first.releases = NULL;
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for materials");
    }
    list_cloths(world, world->first.materials, world->first.releases);
    return TULLE_OK;
}

void world_release_first_settings(tulle_world *world) {
    memory_release(&world->heap, world->first.laws, get_laws_size(world));
    memory_release(&world->heap, world->first.materials, get_materials_size(world));
    memory_release(&world->heap, world->first.releases, get_releases_size(world));
    world->first.laws = NULL;
    world->first.materials = NULL;
    world->first.releases = NULL;
}

enum setting_part { PART_LAWS = 1, PART_MATERIALS = 2, PART_RELEASES = 4, PARTS_ALL = 7 };

/* A set of setting_part: what is not as at the start. */
static uint64_t list_parts(const tulle_world *world) {
    const first_settings *const first = &world->first;
    const double *release = first->releases;
    bool const differ = first->laws && memcmp(world->model.laws, first->laws, get_laws_size(world));
    uint64_t parts = differ ? PART_LAWS : 0;
    for (size_t i = 0; first->materials && i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        if (memcmp(&cloth->material, &first->materials[i], sizeof cloth->material) != 0)
            parts |= PART_MATERIALS;
        for (size_t p = 0; p < cloth->pin_count; p++)
            if (cloth->pins[p].release_time != *release++) parts |= PART_RELEASES;
    }
    return parts;
}

/* Puts machinery for these settings into world->spare. */
static tulle_status prepare_machinery(tulle_world *world, cloth_settings settings,
                                      tulle_error *error) {
    world_release_machinery(world, &world->spare);
    tulle_status const status = world_build_machinery(world, settings, &world->spare, error);
    if (status != TULLE_ERROR_OUT_OF_MEMORY) return status;
    return error_set(error, status, "no memory left for materials");
}

/* Puts what was prepared in force; elastic energies are others then. */
static void use_machinery(tulle_world *world) {
    world_set_machinery(world, &world->spare);
    world->now.elastic.is_known = false;
    step_wake_all(&world->model, &world->now);
}

/* ---- calls ---- */

/* What is set before the start is as if the def had it. */
static void note_def(tulle_world *world) {
    if (!world->is_started) world->first.def_hash = world_def_hash(&world->model.def);
}

tulle_status tulle_world_set_gravity(tulle_world *world, const double gravity[3],
                                     tulle_error *error) {
    if (!world || !gravity)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world or the gravity is null");
    world_settings settings = get_settings(world);
    if (memcmp(settings.gravity, gravity, sizeof settings.gravity) == 0) return TULLE_OK;
    memcpy(settings.gravity, gravity, sizeof settings.gravity);
    tulle_status const status = check_settings(world, &settings, error);
    if (status != TULLE_OK) return status;
    set_settings(world, &settings);
    note_def(world);
    if (world->is_started) step_wake_all(&world->model, &world->now);
    WORLD_RECORD(world, .kind = RECORD_GRAVITY, .arrays = {{gravity, 3}});
    return TULLE_OK;
}

tulle_status tulle_world_set_wind(tulle_world *world, const tulle_wind *wind, tulle_error *error) {
    if (!world || !wind)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world or the wind is null");
    world_settings settings = get_settings(world);
    bool const differs = memcmp(&settings.wind, wind, sizeof *wind) != 0;
    settings.wind = *wind;
    tulle_status const status = check_settings(world, &settings, error);
    if (status != TULLE_OK) return status;
    set_settings(world, &settings);
    note_def(world);
    if (world->is_started && differs) step_wake_cloths(&world->model, &world->now);
    WORLD_RECORD(world, .kind = RECORD_WIND, .def.wind = *wind);
    return TULLE_OK;
}

world_cloth *world_find_started_cloth(tulle_world *world, tulle_cloth_id id, tulle_error *error) {
    size_t const index = world_find_cloth(world, id);
    if (index != SIZE_MAX && world->is_started) return &world->model.cloths.data[index];
    error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
              "the world has no such cloth, or has not started");
    return NULL;
}

static bool has_hysteresis(const tulle_material *m) {
    return m->bend_hysteresis_warp > 0.0 || m->bend_hysteresis_weft > 0.0 ||
           m->shear_hysteresis > 0.0;
}

/* Whether a cloth may take a material while the world runs. What contact takes from it stays. */
static tulle_status check_material(const tulle_world *world, const world_cloth *cloth,
                                   const tulle_material *material, tulle_error *error) {
    tulle_status const status =
        material_check(material, world->model.def.membrane, cloth->name, error);
    if (status != TULLE_OK) return status;
    if (has_hysteresis(material) == has_hysteresis(&cloth->material)) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: cloth with hysteresis cannot become cloth without, nor the other way "
                     "round, while the world runs",
                     cloth->name);
}

tulle_status tulle_cloth_set_material(tulle_world *world, tulle_cloth_id id,
                                      const tulle_material *material, tulle_error *error) {
    if (!material) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the material is null");
    world_cloth *const cloth = world_find_started_cloth(world, id, error);
    if (!cloth) return TULLE_ERROR_INVALID_ARGUMENT;
    tulle_material changed = *material;
    changed.friction = cloth->material.friction;
    changed.dynamic_friction = cloth->material.dynamic_friction;
    changed.restitution = cloth->material.restitution;
    changed.friction_across = cloth->material.friction_across;
    if (memcmp(&changed, &cloth->material, sizeof changed) == 0) return TULLE_OK;
    tulle_status status = check_material(world, cloth, &changed, error);
    if (status == TULLE_OK) status = keep_first_cloths(world, error);
    if (status != TULLE_OK) return status;
    tulle_material const before = cloth->material;
    cloth->material = changed;
    status = prepare_machinery(world, (cloth_settings){0}, error);
    if (status != TULLE_OK) {
        cloth->material = before;
        return status;
    }
    use_machinery(world);
    WORLD_RECORD(world, .kind = RECORD_MATERIAL, RECORD_ID(id), .def.material = *material);
    return TULLE_OK;
}

tulle_status tulle_cloth_release_pin(tulle_world *world, tulle_cloth_id id, size_t pin,
                                     tulle_error *error) {
    world_cloth *const cloth = world_find_started_cloth(world, id, error);
    if (!cloth) return TULLE_ERROR_INVALID_ARGUMENT;
    if (pin >= cloth->pin_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: has no pin number %zu; it has %zu pins", cloth->name, pin,
                         cloth->pin_count);
    double const before = cloth->pins[pin].release_time, now = world->now.time;
    if (before <= now) return TULLE_OK;
    tulle_status status = keep_first_cloths(world, error);
    if (status != TULLE_OK) return status;
    cloth->pins[pin].release_time = now;
    if (before == (double)INFINITY) { /* it was a clamp */
        status = prepare_machinery(world, (cloth_settings){0}, error);
        if (status != TULLE_OK) {
            cloth->pins[pin].release_time = before;
            return status;
        }
        use_machinery(world);
    }
    cloth->pins[pin].has_targets = false;
    step_wake_cloth(&world->model, &world->now, world_find_cloth(world, id));
    WORLD_RECORD(world, .kind = RECORD_RELEASE_PIN, RECORD_ID(id), .numbers = {pin});
    return TULLE_OK;
}

tulle_status tulle_cloth_set_thickness(tulle_world *world, tulle_cloth_id id, double thickness,
                                       tulle_error *error) {
    world_cloth *const cloth = world_find_started_cloth(world, id, error);
    if (!cloth) return TULLE_ERROR_INVALID_ARGUMENT;
    double const least = 2.0 * world->model.minimum_gap, most = world->model.contact_distance;
    if (!(thickness >= least && thickness <= most))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: a thickness of %g m is asked for; while the world runs it lies "
                         "between %g m, twice the minimum gap, and %g m, the largest contact "
                         "distance of its start",
                         cloth->name, thickness, least, most);
    tulle_status const status = keep_first_laws(world, error);
    if (status != TULLE_OK) return status;
    size_t const count = world->model.surface_count, own = world_find_cloth(world, id);
    for (size_t other = 0; other < count; other++) {
        contact_law *const law = &world->model.laws[own * count + other];
        if (!(law->contact_distance > 0.0)) continue; /* nothing that it meets */
        law->contact_distance = thickness;
        if (other != own && other < world->model.cloths.count)
            law->contact_distance =
                0.5 * (thickness + world->model.laws[other * count + other].contact_distance);
        law->separation_distance = world_get_separation(world, law->contact_distance);
        world->model.laws[other * count + own] = *law;
    }
    step_wake_all(&world->model, &world->now);
    WORLD_RECORD(world, .kind = RECORD_THICKNESS, RECORD_ID(id), .arrays = {{&thickness, 1}});
    return TULLE_OK;
}

int tulle_cloth_is_asleep(const tulle_world *world, tulle_cloth_id id) {
    size_t const cloth = world_find_cloth(world, id);
    return cloth != SIZE_MAX && world->is_started && cloth < world->model.cloth_rest_count &&
           world->now.cloth_rests[cloth].is_asleep;
}

tulle_status tulle_cloth_wake(tulle_world *world, tulle_cloth_id id, tulle_error *error) {
    if (!world_find_started_cloth(world, id, error)) return TULLE_ERROR_INVALID_ARGUMENT;
    step_wake_cloth(&world->model, &world->now, world_find_cloth(world, id));
    WORLD_RECORD(world, .kind = RECORD_WAKE_CLOTH, RECORD_ID(id));
    return TULLE_OK;
}

tulle_status world_change_law(tulle_world *world, size_t a, size_t b, const tulle_contact_law *law,
                              tulle_error *error) {
    tulle_status const status = keep_first_laws(world, error);
    if (status != TULLE_OK) return status;
    contact_law *const old = &world->model.laws[a * world->model.surface_count + b];
    contact_law changed = *old;
    changed.static_friction = law->static_friction;
    changed.dynamic_friction =
        law->dynamic_friction < 0.0 ? law->static_friction : law->dynamic_friction;
    changed.restitution = law->restitution;
    if (memcmp(old, &changed, sizeof changed) == 0) return TULLE_OK;
    *old = world->model.laws[b * world->model.surface_count + a] = changed;
    step_wake_all(&world->model, &world->now);
    return TULLE_OK;
}

/* ---- in a state ---- */

/* [bytes] of the parts that a set of setting_part names, in their order. */
static size_t get_parts_size(const tulle_world *world, uint64_t parts) {
    return (parts & PART_LAWS ? get_laws_size(world) : 0) +
           (parts & PART_MATERIALS ? get_materials_size(world) : 0) +
           (parts & PART_RELEASES ? get_releases_size(world) : 0);
}

size_t world_get_settings_size(const tulle_world *world) {
    world_settings const settings = get_settings(world);
    uint64_t const parts = list_parts(world);
    if (parts == 0 && memcmp(&settings, &world->first.settings, sizeof settings) == 0) return 0;
    return sizeof settings + get_parts_size(world, parts);
}

void world_put_settings(const tulle_world *world, void *bytes) {
    world_settings settings = get_settings(world);
    unsigned char *to = bytes;
    settings.parts = list_parts(world);
    if (settings.parts & PART_LAWS) memcpy(to, world->model.laws, get_laws_size(world));
    to += get_parts_size(world, settings.parts & PART_LAWS);
    for (size_t i = 0; settings.parts & PART_MATERIALS && i < world->model.cloths.count; i++) {
        memcpy(to, &world->model.cloths.data[i].material, sizeof(tulle_material));
        to += sizeof(tulle_material);
    }
    for (size_t i = 0; settings.parts & PART_RELEASES && i < world->model.cloths.count; i++)
        for (size_t p = 0; p < world->model.cloths.data[i].pin_count; p++, to += sizeof(double))
            memcpy(to, &world->model.cloths.data[i].pins[p].release_time, sizeof(double));
    memcpy(to, &settings, sizeof settings);
}

uint64_t world_hash_settings(const tulle_world *world, uint64_t hash) {
    if (world_get_settings_size(world) == 0) return hash;
    world_settings settings = get_settings(world);
    settings.parts = list_parts(world);
    if (settings.parts & PART_LAWS)
        hash = hash_bytes(hash, world->model.laws, get_laws_size(world));
    for (size_t i = 0; settings.parts & PART_MATERIALS && i < world->model.cloths.count; i++)
        hash = hash_bytes(hash, &world->model.cloths.data[i].material, sizeof(tulle_material));
    for (size_t i = 0; settings.parts & PART_RELEASES && i < world->model.cloths.count; i++)
        for (size_t p = 0; p < world->model.cloths.data[i].pin_count; p++)
            hash =
                hash_bytes(hash, &world->model.cloths.data[i].pins[p].release_time, sizeof(double));
    return hash_bytes(hash, &settings, sizeof settings);
}

/* The parts of settings that were read; null where they are as at the start. */
typedef struct read_settings {
    world_settings settings;
    const unsigned char *laws, *materials, *releases;
} read_settings;

/* False where the sizes do not fit. */
static bool split_settings(const tulle_world *world, const void *bytes, size_t size,
                           read_settings *split) {
    *split = (read_settings){.settings = world->first.settings};
    if (size == 0) return true;
    const unsigned char *const from = bytes;
    if (size < sizeof split->settings) return false;
    memcpy(&split->settings, from + size - sizeof split->settings, sizeof split->settings);
    uint64_t const parts = split->settings.parts;
    if (parts > PARTS_ALL || size != sizeof split->settings + get_parts_size(world, parts))
        return false;
    if (parts & PART_LAWS) split->laws = from;
    if (parts & PART_MATERIALS) split->materials = from + get_parts_size(world, parts & PART_LAWS);
    if (parts & PART_RELEASES)
        split->releases = from + get_parts_size(world, parts & (PART_LAWS | PART_MATERIALS));
    return true;
}

/* Whether a law that was read may stand in the place of `now`. */
static bool law_is_valid(const tulle_world *world, const contact_law *law, const contact_law *now) {
    tulle_contact_law const given = {law->static_friction, law->dynamic_friction, law->restitution};
    bool const meets = now->contact_distance > 0.0;
    bool const has_distance = meets
                                  ? law->contact_distance >= 2.0 * world->model.minimum_gap &&
                                        law->contact_distance <= world->model.contact_distance &&
                                        law->separation_distance >= law->contact_distance &&
                                        law->separation_distance <= world->model.separation_distance
                                  : law->contact_distance == now->contact_distance &&
                                        law->separation_distance == now->separation_distance;
    return has_distance && law->dynamic_friction >= 0.0 &&
           contact_law_check(&given, "", NULL) == TULLE_OK;
}

static bool settings_are_valid(const tulle_world *world, const read_settings *split) {
    bool is_valid = check_settings(world, &split->settings, NULL) == TULLE_OK;
    size_t const law_count = split->laws ? get_laws_size(world) / sizeof(contact_law) : 0;
    for (size_t i = 0; is_valid && i < law_count; i++) {
        contact_law law;
        memcpy(&law, split->laws + i * sizeof law, sizeof law);
        is_valid = law_is_valid(world, &law, &world->model.laws[i]);
    }
    for (size_t i = 0; is_valid && split->materials && i < world->model.cloths.count; i++) {
        tulle_material material;
        memcpy(&material, split->materials + i * sizeof material, sizeof material);
        is_valid = check_material(world, &world->model.cloths.data[i], &material, NULL) == TULLE_OK;
    }
    for (size_t i = 0; is_valid && split->releases && i < world->model.pin_count; i++) {
        double release;
        memcpy(&release, split->releases + i * sizeof release, sizeof release);
        is_valid = !isnan(release);
    }
    return is_valid;
}

/* Prepares machinery where materials or pins are to be others than now. Room for both lies in
 * scratch. */
static tulle_status prepare_cloths(tulle_world *world, const read_settings *split,
                                   tulle_error *error) {
    size_t const material_size = get_materials_size(world), release_size = get_releases_size(world);
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    tulle_material *const materials = arena_allocate(&world->work.scratch, 2, material_size);
    double *const releases = arena_allocate(&world->work.scratch, 2, release_size);
    tulle_status status = TULLE_OK;
    if (!materials || !releases) {
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for materials");
    } else {
        tulle_material *const now = materials + world->model.cloths.count;
        double *const pins_now = releases + world->model.pin_count;
        list_cloths(world, now, pins_now);
        memcpy(materials,
               split->materials         ? (const void *)split->materials
               : world->first.materials ? world->first.materials
                                        : now,
               material_size);
        if (release_size > 0)
            memcpy(releases,
                   split->releases         ? (const void *)split->releases
                   : world->first.releases ? world->first.releases
                                           : pins_now,
                   release_size);
        bool const differs = memcmp(materials, now, material_size) != 0 ||
                             (release_size > 0 && memcmp(releases, pins_now, release_size) != 0);
        world_release_machinery(world, &world->spare);
        if (differs) status = keep_first_cloths(world, error);
        if (differs && status == TULLE_OK)
            status = prepare_machinery(world, (cloth_settings){materials, releases}, error);
    }
    arena_release(&world->work.scratch, mark);
    return status;
}

tulle_status world_check_settings(tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error) {
    read_settings split;
    if (!split_settings(world, bytes, size, &split) || !settings_are_valid(world, &split))
        return error_set(error, TULLE_ERROR_PARSE,
                         "the saved state has a gravity, a wind, laws, materials or pins that no "
                         "world has: start the run again");
    tulle_status const status = split.laws ? keep_first_laws(world, error) : TULLE_OK;
    return status == TULLE_OK ? prepare_cloths(world, &split, error) : status;
}

void world_take_settings(tulle_world *world, const void *bytes, size_t size) {
    read_settings split;
    (void)split_settings(world, bytes, size, &split); /* world_check_settings has seen them */
    set_settings(world, &split.settings);
    if (world->first.laws)
        memcpy(world->model.laws, split.laws ? (const void *)split.laws : world->first.laws,
               get_laws_size(world));
    const unsigned char *materials =
        split.materials ? split.materials : (const unsigned char *)world->first.materials;
    const unsigned char *releases =
        split.releases ? split.releases : (const unsigned char *)world->first.releases;
    for (size_t i = 0; world->first.materials && i < world->model.cloths.count; i++) {
        world_cloth *const cloth = &world->model.cloths.data[i];
        memcpy(&cloth->material, materials + i * sizeof cloth->material, sizeof cloth->material);
        for (size_t p = 0; p < cloth->pin_count; p++, releases += sizeof(double))
            memcpy(&cloth->pins[p].release_time, releases, sizeof(double));
    }
    if (world->spare.model) world_set_machinery(world, &world->spare);
}

/* ---- objects that come and go ---- */

tulle_status world_carry_first_cloths(tulle_world *world, tulle_error *error) {
    const world_change *const change = world->change;
    const tulle_world *const before = change->before;
    if (!before->first.materials) return TULLE_OK;
    tulle_status const status = keep_first_cloths(world, error);
    if (status != TULLE_OK) return status;
    double *release = world->first.releases;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        size_t const pin_count = world->model.cloths.data[i].pin_count;
        uint32_t const source = change->sources[i];
        if (source != TULLE_NONE) {
            const double *first = before->first.releases;
            for (size_t k = 0; k < source; k++) first += before->model.cloths.data[k].pin_count;
            world->first.materials[i] = before->first.materials[source];
            if (pin_count > 0) memcpy(release, first, pin_count * sizeof *release);
        }
        release += pin_count;
    }
    return TULLE_OK;
}

/* What the host has changed of a law; a distance goes into the limits that hold now. */
static void carry_law(const tulle_world *world, const contact_law *first, const contact_law *last,
                      contact_law *law) {
    if (last->static_friction != first->static_friction ||
        last->dynamic_friction != first->dynamic_friction ||
        last->restitution != first->restitution) {
        law->static_friction = last->static_friction;
        law->dynamic_friction = last->dynamic_friction;
        law->restitution = last->restitution;
    }
    if (last->contact_distance == first->contact_distance) return;
    double const least = 2.0 * world->model.minimum_gap, most = world->model.contact_distance;
    law->contact_distance = fmin(fmax(last->contact_distance, least), most);
    law->separation_distance = world_get_separation(world, law->contact_distance);
}

static tulle_status carry_laws(tulle_world *world, tulle_error *error) {
    const world_change *const change = world->change;
    const tulle_world *const before = change->before;
    if (!(list_parts(before) & PART_LAWS)) return TULLE_OK;
    tulle_status const status = keep_first_laws(world, error);
    if (status != TULLE_OK) return status;
    size_t const count = world->model.surface_count, count_before = before->model.surface_count;
    for (size_t i = 0; i < count * count; i++) {
        uint32_t const a = change->sources[i / count], b = change->sources[i % count];
        if (a == TULLE_NONE || b == TULLE_NONE) continue;
        size_t const old = (size_t)a * count_before + b;
        carry_law(world, &before->first.laws[old], &before->model.laws[old], &world->model.laws[i]);
    }
    return TULLE_OK;
}

tulle_status world_carry_settings(tulle_world *world, tulle_error *error) {
    tulle_status status = carry_laws(world, error);
    if (status == TULLE_OK && list_parts(world) & (PART_MATERIALS | PART_RELEASES)) {
        status = prepare_machinery(world, (cloth_settings){0}, error);
        if (status == TULLE_OK) world_set_machinery(world, &world->spare);
    }
    if (status != TULLE_OK) return status;
    world_settings const settings = get_settings(world->change->before);
    set_settings(world, &settings);
    return TULLE_OK;
}
