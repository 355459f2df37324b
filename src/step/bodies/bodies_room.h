/* step/bodies/bodies_room.h - bodies that are too near make room only as far as there is energy
 * for it.
 *
 * A row inside the contact distance asks for speed apart. If the row carries load, that speed lifts
 * the objects that hang or stand there, as between the rings of a chain or below a stack on a
 * sheet. No force does that work. So rows of bodies may only use energy that the steps lose anyway,
 * by impact, friction and the integrator. */
#ifndef TULLE_STEP_BODIES_BODIES_ROOM_H
#define TULLE_STEP_BODIES_BODIES_ROOM_H

#include "step/step_work.h"

/* Called before the first solve of a substep: limits the speeds that rows ask for to a share of the
 * energy that the last substep lost. */
void step_share_room(motion_state *state, step_work *work);
/* Called after a solve that gained energy: rows ask for less. With `level` 0 they keep their
 * present room, with 1 they ask for no speed apart. False when no such row carries load and asked
 * for more. */
bool step_ask_less_room(step_work *work, int level);
/* Called after the last solve, when its gain is known: notes the energy that this substep loses
 * without making room. */
void step_note_loss(step_work *work);

#endif
