/* world/settings.c - what a host may change while the world runs: gravity and wind (tulle/live.h),
 * laws of pairs.
 *
 * In: the calls of the host, checked as the defs are. Out: world->def and world->laws, which steps
 * read. What differs from what was in force at the start is part of the state (state.c). */
#include "tulle/live.h"

#include "base/error.h"
#include "base/hash.h"
#include "world/bodies/bodies_sleep.h"
#include "world/defs.h"

#include <string.h>

/* ---- in force ---- */

static world_settings get_settings(const tulle_world *world) {
    world_settings settings = {.wind = world->def.wind};
    memcpy(settings.gravity, world->def.gravity, sizeof settings.gravity);
    return settings;
}

static tulle_status check_settings(const tulle_world *world, const world_settings *settings,
                                   tulle_error *error) {
    tulle_world_def def = world->def;
    memcpy(def.gravity, settings->gravity, sizeof def.gravity);
    def.wind = settings->wind;
    return world_def_check(&def, error);
}

static void set_settings(tulle_world *world, const world_settings *settings) {
    memcpy(world->def.gravity, settings->gravity, sizeof world->def.gravity);
    world->def.wind = settings->wind;
}

static size_t get_laws_size(const tulle_world *world) {
    return world->set.surface_count * world->set.surface_count * sizeof(contact_law);
}

static bool laws_differ(const tulle_world *world) {
    return world->first_laws && memcmp(world->laws, world->first_laws, get_laws_size(world)) != 0;
}

/* Keeps the laws of the start before one of them changes. */
static tulle_status keep_first_laws(tulle_world *world, tulle_error *error) {
    if (world->first_laws) return TULLE_OK;
    world->first_laws = memory_allocate(&world->heap, get_laws_size(world));
    if (!world->first_laws)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for laws of pairs");
    memcpy(world->first_laws, world->laws, get_laws_size(world));
    return TULLE_OK;
}

/* ---- calls ---- */

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
    if (world->is_started) world_wake_all(world, &world->now);
    return TULLE_OK;
}

tulle_status tulle_world_set_wind(tulle_world *world, const tulle_wind *wind, tulle_error *error) {
    if (!world || !wind)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world or the wind is null");
    world_settings settings = get_settings(world);
    settings.wind = *wind;
    tulle_status const status = check_settings(world, &settings, error);
    if (status == TULLE_OK) set_settings(world, &settings);
    return status;
}

tulle_status world_change_law(tulle_world *world, size_t a, size_t b, const tulle_contact_law *law,
                              tulle_error *error) {
    tulle_status const status = keep_first_laws(world, error);
    if (status != TULLE_OK) return status;
    contact_law *const old = &world->laws[a * world->set.surface_count + b];
    contact_law changed = *old;
    changed.static_friction = law->static_friction;
    changed.dynamic_friction =
        law->dynamic_friction < 0.0 ? law->static_friction : law->dynamic_friction;
    changed.restitution = law->restitution;
    if (memcmp(old, &changed, sizeof changed) == 0) return TULLE_OK;
    *old = world->laws[b * world->set.surface_count + a] = changed;
    world_wake_all(world, &world->now);
    return TULLE_OK;
}

/* ---- in a state ---- */

size_t world_get_settings_size(const tulle_world *world) {
    world_settings const settings = get_settings(world);
    bool const has_laws = laws_differ(world);
    if (!has_laws && memcmp(&settings, &world->first_settings, sizeof settings) == 0) return 0;
    return sizeof settings + (has_laws ? get_laws_size(world) : 0);
}

void world_put_settings(const tulle_world *world, void *bytes) {
    world_settings const settings = get_settings(world);
    size_t const laws = laws_differ(world) ? get_laws_size(world) : 0;
    if (laws > 0) memcpy(bytes, world->laws, laws);
    memcpy((unsigned char *)bytes + laws, &settings, sizeof settings);
}

uint64_t world_hash_settings(const tulle_world *world, uint64_t hash) {
    if (world_get_settings_size(world) == 0) return hash;
    world_settings const settings = get_settings(world);
    if (laws_differ(world)) hash = hash_bytes(hash, world->laws, get_laws_size(world));
    return hash_bytes(hash, &settings, sizeof settings);
}

/* Whether a law that was read may stand in the place of `now`: distances never change. */
static bool law_is_valid(const contact_law *law, const contact_law *now) {
    tulle_contact_law const given = {law->static_friction, law->dynamic_friction, law->restitution};
    return memcmp(&law->contact_distance, &now->contact_distance, sizeof(double)) == 0 &&
           memcmp(&law->separation_distance, &now->separation_distance, sizeof(double)) == 0 &&
           law->dynamic_friction >= 0.0 && contact_law_check(&given, "", NULL) == TULLE_OK;
}

tulle_status world_check_settings(tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error) {
    if (size == 0) return TULLE_OK;
    world_settings settings;
    size_t const laws = size > sizeof settings ? get_laws_size(world) : 0;
    bool is_valid = size == laws + sizeof settings;
    if (is_valid) {
        memcpy(&settings, (const unsigned char *)bytes + laws, sizeof settings);
        is_valid = check_settings(world, &settings, NULL) == TULLE_OK;
    }
    for (size_t i = 0; is_valid && i < laws / sizeof(contact_law); i++) {
        contact_law law;
        memcpy(&law, (const unsigned char *)bytes + i * sizeof law, sizeof law);
        is_valid = law_is_valid(&law, &world->laws[i]);
    }
    if (!is_valid)
        return error_set(error, TULLE_ERROR_PARSE,
                         "the saved state has a gravity, a wind or laws that no world has: start "
                         "the run anew");
    return laws > 0 ? keep_first_laws(world, error) : TULLE_OK;
}

void world_take_settings(tulle_world *world, const void *bytes, size_t size) {
    world_settings settings = world->first_settings;
    size_t const laws = size > sizeof settings ? get_laws_size(world) : 0;
    if (size > 0) memcpy(&settings, (const unsigned char *)bytes + laws, sizeof settings);
    set_settings(world, &settings);
    if (world->first_laws)
        memcpy(world->laws, laws > 0 ? bytes : world->first_laws, get_laws_size(world));
}
