/* world/change/change.h - objects that come and go while a world runs.
 *
 * A change starts new insides of the world with other objects, and carries over the state of the
 * objects that stay. The old insides are kept until it has succeeded, so an error puts them back.
 * Vertices, triangles, edges and bodies get other numbers, in the same order. */
#ifndef TULLE_WORLD_CHANGE_CHANGE_H
#define TULLE_WORLD_CHANGE_CHANGE_H

#include "world/world_state.h"

struct world_change {
    const tulle_world *before; /* the insides before */
    uint32_t *sources;         /* by surface: its number before, or TULLE_NONE */
    uint32_t *targets;         /* by surface before: its number, or TULLE_NONE */
    uint32_t added;            /* surface that is new, or TULLE_NONE */
};

/* start_changed.c: the start of a world with a change. */
tulle_status world_start_changed(tulle_world *world, tulle_error *error);

/* carry.c: clocks, and the state of the vertices, obstacles and bodies that stay. Called once there
 * is room for it, and new objects have their own state. */
void world_carry_state(tulle_world *world);
/* carry.c: contacts, attachments and holds, without those of removed objects; wakes the bodies that
 * touched these. */
tulle_status world_carry_contacts(tulle_world *world, tulle_error *error);
/* carry.c: plastic parts of cloth that stays. */
void world_carry_plastic(tulle_world *world);
/* carry.c: marks vertices that untangling may not move. */
void world_mark_held(tulle_world *world);

/* judge.c: the pairs that are ignored, with those of world->intersections. */
tulle_status world_carry_ignored(tulle_world *world, tulle_error *error);

/* settings.c: materials and pins as at the start, in world->first_materials and so on where one has
 * changed since. */
tulle_status world_carry_first_cloths(tulle_world *world, tulle_error *error);
/* settings.c: settings that the host has changed since the start. */
tulle_status world_carry_settings(tulle_world *world, tulle_error *error);

/* events.c: the watch. Takes it from the old insides, so nothing may fail afterwards. */
tulle_status world_carry_events(tulle_world *world, tulle_error *error);

/* change.c: adds the copy of a def to a world that runs, or takes an object out of one. */
tulle_status world_add_late(tulle_world *world, const world_cloth *cloth,
                            const world_obstacle *obstacle, tulle_error *error);

#endif
