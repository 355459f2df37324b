/* world/bodies/bodies_turn.h - how long a substep may be for what turns in it.
 *
 * In a substep vertices move along chords, although they turn on arcs. So the shape that is tested
 * shrinks in the middle of a turn. No substep turns a body so far that a vertex leaves its chord by
 * much of the contact distance, nor anything on keyframes by more than an eighth of a turn. */
#ifndef TULLE_WORLD_BODIES_BODIES_TURN_H
#define TULLE_WORLD_BODIES_BODIES_TURN_H

#include "world/step/step.h"

/* Cuts *length [s], what the substep may last else, into equal parts in none of which a free body
 * turns too far with the spin it has, nor anything on keyframes. The keyframes hold first. An error
 * names the body or the keyframes for which the step of context would need too many substeps. */
tulle_status world_limit_turns(const step_context *context, double *length);

/* Whether a contact of the substep that was solved spins a body up so that it turns too far; then
 * context->retry.turn_time [s] is what the substep may last. */
bool world_turns_too_far(step_context *context);

#endif
