/* world/settings.c - what a host may change while the world runs: gravity and wind (tulle/live.h).
 *
 * In: the calls of the host, checked as the def is. Out: world->def, which steps read. What differs
 * from the def as it was at the start is part of the state (state.c). */
#include "tulle/live.h"

#include "base/error.h"
#include "world/bodies/bodies_sleep.h"
#include "world/defs.h"

#include <string.h>

world_settings world_get_settings(const tulle_world *world) {
    world_settings settings = {.wind = world->def.wind};
    memcpy(settings.gravity, world->def.gravity, sizeof settings.gravity);
    return settings;
}

tulle_status world_check_settings(const tulle_world *world, const world_settings *settings,
                                  tulle_error *error) {
    tulle_world_def def = world->def;
    memcpy(def.gravity, settings->gravity, sizeof def.gravity);
    def.wind = settings->wind;
    return world_def_check(&def, error);
}

void world_set_settings(tulle_world *world, const world_settings *settings) {
    memcpy(world->def.gravity, settings->gravity, sizeof world->def.gravity);
    world->def.wind = settings->wind;
}

bool world_settings_differ(const tulle_world *world) {
    world_settings const settings = world_get_settings(world);
    return memcmp(&settings, &world->first_settings, sizeof settings) != 0;
}

tulle_status tulle_world_set_gravity(tulle_world *world, const double gravity[3],
                                     tulle_error *error) {
    if (!world || !gravity)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world or the gravity is null");
    world_settings settings = world_get_settings(world);
    if (memcmp(settings.gravity, gravity, sizeof settings.gravity) == 0) return TULLE_OK;
    memcpy(settings.gravity, gravity, sizeof settings.gravity);
    tulle_status const status = world_check_settings(world, &settings, error);
    if (status != TULLE_OK) return status;
    world_set_settings(world, &settings);
    if (world->is_started) world_wake_all(world, &world->now);
    return TULLE_OK;
}

tulle_status tulle_world_set_wind(tulle_world *world, const tulle_wind *wind, tulle_error *error) {
    if (!world || !wind)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world or the wind is null");
    world_settings settings = world_get_settings(world);
    settings.wind = *wind;
    tulle_status const status = world_check_settings(world, &settings, error);
    if (status == TULLE_OK) world_set_settings(world, &settings);
    return status;
}
