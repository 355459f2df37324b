/* world/bodies/bodies_room.h - bodies that come too near to one another or to cloth make room only
 * as far as the step has energy for it.
 *
 * A row inside the contact distance asks for speed apart. Where it carries load, as between the
 * rings of a chain or below a stack on a sheet, that lifts what hangs or stands there: work that no
 * force does. So rows of bodies share what the steps lose anyway, by impact, friction and the
 * integrator. */
#ifndef TULLE_WORLD_BODIES_BODIES_ROOM_H
#define TULLE_WORLD_BODIES_BODIES_ROOM_H

#include "world/step/step.h"

/* Before the first solve of a substep: rows ask for what a part of the energy pays that the substep
 * before lost. */
void world_share_room(step_context *context);
/* After a solve that gained energy: such rows ask for less, at first for no more room than they
 * have, with `level` 1 for no speed apart. False when none of them carries load and asked for more.
 */
bool world_ask_less_room(step_context *context, int level);
/* After the last solve, with its gain: what this substep loses without them. */
void world_note_loss(step_context *context);

#endif
