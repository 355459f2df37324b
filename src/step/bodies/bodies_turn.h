/* step/bodies/bodies_turn.h - how long a substep may be for what turns in it.
 *
 * In a substep vertices move along chords, although they turn on arcs. So the shape that is tested
 * shrinks in the middle of a turn. No substep turns a body so far that a vertex leaves its chord by
 * much of the contact distance, nor anything on keyframes by more than an eighth of a turn. */
#ifndef TULLE_STEP_BODIES_BODIES_TURN_H
#define TULLE_STEP_BODIES_BODIES_TURN_H

#include "step/step_work.h"

/* Cuts *length [s], what the substep may last else, into equal parts in none of which a free body
 * turns too far with the spin it has, nor anything on keyframes. The keyframes hold first. An error
 * names the body or the keyframes for which the step would need too many substeps. */
tulle_status step_limit_turns(const step_model *model, motion_state *state, step_work *work,
                              double *length);

/* [s] What a substep may last in which the contacts of the one that was solved spin a body up so
 * that it turns too far; infinite if none does. */
double step_find_turn_time(const step_model *model, const step_work *work);

#endif
