/* step/bodies/bodies_turn.h - how long a substep may be if bodies or obstacles turn in it.
 *
 * In a substep vertices move along chords, although they turn on arcs. So the shape that is tested
 * shrinks in the middle of a turn. No substep turns a body so far that a vertex leaves its chord by
 * much of the contact distance. Obstacles on keyframes turn by at most an eighth of a turn. */
#ifndef TULLE_STEP_BODIES_BODIES_TURN_H
#define TULLE_STEP_BODIES_BODIES_TURN_H

#include "step/step_work.h"

/* Cuts *length [s], the length that the substep would have, into equal parts. In none of them a
 * body with its present spin, or an obstacle on keyframes, turns too far. Keyframes come first. An
 * error names the body or the keyframes for which the step would need too many substeps. */
tulle_status step_limit_turns(const step_model *model, motion_state *state, step_work *work,
                              double *length);

/* [s] Length of a substep that is short enough for bodies which the solved contacts spin up too
 * much; infinite if there are none. */
double step_find_turn_time(const step_model *model, const step_work *work);

#endif
