/* tulle/objects.h - adding cloth, obstacles and bodies to a world that runs, and removing them.
 *
 * tulle_world_add_cloth and tulle_world_add_obstacle also work after the start. The new object is
 * as in its def, at the time of the world: its velocities are its velocities now; keyframes,
 * frames, pins and times of appearing count from the start of the world. The pair filter
 * (tulle/query.h) is asked for each pair with the new object. Its category is 1, its mask all. If
 * the new object intersects another one, start_intersections decides, as at the start. Either it is
 * refused with TULLE_ERROR_INTERSECTING_START, or the pairs are ignored until they come apart, or
 * the cloth is untangled, which may move all cloth. After a refusal, tulle_world_get_intersections
 * gives the pairs; the new object has the number behind the last object.
 *
 * The state of all other objects stays bit for bit: positions, velocities, contacts, attachments,
 * sleeping bodies, ignored pairs, obstacles that on_pinch holds back, settings, user data, watches,
 * and poses given for the next step. The world derives its distances as if these objects had been
 * there from its start on. A thickness outside the new limits becomes the nearest value inside
 * them. The contact distance leaves room where surfaces start close together (tulle_world_def).
 * That room is kept. For a new object it is measured when the object is added, not at the start of
 * the world. So a world with the same objects, added at other times, may have other rooms. A state
 * still loads there, but the steps that follow may differ. Removing an object also removes its
 * contacts, its laws, all attachments from and to it, and its unread events. Bodies that touched it
 * wake. The next step gives the events of attachments that ended, if they are watched.
 *
 * A call costs as much as tulle_world_start with the new set of objects. While it runs, it needs
 * twice the memory. It has the errors of the start and TULLE_ERROR_INVALID_ARGUMENT. After an error
 * the world is as it was; only tulle_world_get_intersections may differ. A saved state loads into
 * any world that has the same objects in the same order; otherwise it is refused. Arrays that the
 * world handed out before the call are invalid, and tulle_world_get_contacts gives none until the
 * next step.
 *
 * The id of a removed object stays stale for ever. A later object may get the same index with the
 * next generation. tulle_contact, tulle_event and tulle_intersection number objects by their place
 * in the order of adding. When an object is removed, the numbers of later objects decrease by 1.
 * tulle_world_get_object gives the id for a number. See docs/guide/embed.md.     */
#ifndef TULLE_OBJECTS_H
#define TULLE_OBJECTS_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Removes a cloth, before the start or later. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale
 * id, distances that do not fit the other objects), TULLE_ERROR_OUT_OF_MEMORY; the world is then as
 * it was. */
TULLE_API tulle_status tulle_world_remove_cloth(tulle_world *world, tulle_cloth_id id,
                                                tulle_error *error);
/* Removes an obstacle or a rigid body, as tulle_world_remove_cloth does a cloth. Its frame reader
 * is not called again. */
TULLE_API tulle_status tulle_world_remove_obstacle(tulle_world *world, tulle_obstacle_id id,
                                                   tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
