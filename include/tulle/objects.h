/* tulle/objects.h - objects come and go: what happens when cloth, obstacles and bodies are added to
 * a world that runs, and removed from one.
 *
 * tulle_world_add_cloth and tulle_world_add_obstacle add to a world that has started, too. What is
 * added is as in its def, at the time of the world: velocities are those that it has now,
 * keyframes, frames, pins and times of appearing count from the start of the world. Whom it
 * collides with is asked of the pair filter (tulle/query.h), for pairs with it alone; its category
 * is 1 and its mask all. Where it lies in or around something start_intersections decides, as at
 * the start: it is refused with TULLE_ERROR_INTERSECTING_START, ignored until it has come apart, or
 * untangled, which may move all cloth. tulle_world_get_intersections then gives the pairs that it
 * was refused for, and calls it by the number behind the last object.
 *
 * All that stays keeps its state to the bit: positions, velocities, contacts, attachments, bodies
 * that sleep, ignored pairs, what on_pinch holds back, settings, user data, what is watched and
 * what was given for the next step. Distances that the world derives are those that it would have
 * with these objects from its start on; a thickness that no longer lies within their limits goes to
 * the nearest one that does. Room that the contact distance leaves (tulle_world_def) is kept, and
 * looked for about what is added as it is then, not as it would have been at the start: where there
 * is such room, a state loads in a world with other rooms, and the steps that follow may differ.
 * What has gone takes along its contacts, its attachments and those to it, its laws, and its events
 * that were not polled; bodies that touched it wake. The next step tells of attachments that have
 * ended, where they are watched.
 *
 * A call costs what tulle_world_start costs with the objects that there are then, and for its time
 * twice the memory. After an error - those of the start, and TULLE_ERROR_INVALID_ARGUMENT - the
 * world is as it was; only tulle_world_get_intersections may differ. A saved state loads where the
 * same objects are in the same order, however they came; else it is refused. Arrays that the world
 * has handed out are gone, and tulle_world_get_contacts gives none until the next step.
 *
 * Ids: that of what was removed is stale for ever. What comes later may get its index, with the
 * next generation. The numbers by which tulle_contact, tulle_event and tulle_intersection call
 * objects are places in the order of adding, so they move up when an object before them goes;
 * tulle_world_get_object gives the id. docs/guide/embed.md tells more. */
#ifndef TULLE_OBJECTS_H
#define TULLE_OBJECTS_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Removes a cloth, before the start or later. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale
 * id, distances that do not fit what stays), TULLE_ERROR_OUT_OF_MEMORY; the world is as it was
 * then.
 */
TULLE_API tulle_status tulle_world_remove_cloth(tulle_world *world, tulle_cloth_id id,
                                                tulle_error *error);
/* Removes an obstacle or a rigid body, as tulle_world_remove_cloth does a cloth. Its frame reader
 * is called no more. */
TULLE_API tulle_status tulle_world_remove_obstacle(tulle_world *world, tulle_obstacle_id id,
                                                   tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
