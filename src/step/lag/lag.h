/* step/lag/lag.h - the lagging surface of obstacles that deform: what cloth meets.
 *
 * Bodies of animations pass through themselves. Cloth that is between two parts then has no room,
 * whoever moves it. So cloth does not meet the drawn surface, as the frames have it, but a lagging
 * one. It is the drawn one wherever there is room. Where the drawn one closes on cloth it lags
 * behind, by a way of each vertex (the lag), and it comes back as soon as there is room.
 *
 * The lagging surface is where the state has the obstacle's vertices; the state keeps the lags
 * beside it. A world without lags is that of the drawn surfaces, to the bit. */
#ifndef TULLE_STEP_LAG_LAG_H
#define TULLE_STEP_LAG_LAG_H

#include "step/step_work.h"

/* Whether the world lets an obstacle lag. */
bool step_may_lag(const step_model *model, size_t obstacle);

/* Before the substeps of a step: where the lagging surfaces are to be at its end, so that cloth
 * between parts of them keeps its room. Lies in the scratch arena. */
tulle_status step_begin_lag(const step_model *model, step_work *work);
/* Takes the targets of a substep as the script gives them, and puts lagging surfaces on their way.
 */
void step_lead_lag(const step_model *model, motion_state *state, step_work *work);
/* After the substeps of a step: the lags with which it ends; the largest goes into the report. */
void step_end_lag(const step_model *model, motion_state *state, step_work *work);

/* Whether a step that is stuck is worth another try with more lag at once: what blocked it may lag.
 * Else shorter substeps come first, as for all that is rigid. */
bool step_may_feel(const step_model *model, motion_state *state, step_work *work);
/* After a pinch: what deforms around the place moves less when the step is made anew. False when it
 * stands still already. */
bool step_feel_pinch(const step_model *model, step_work *work, const blocked_place *place);

/* Whether an obstacle of the state lags. */
bool step_has_lags(const step_model *model, const motion_state *state);
/* Finds the largest lag of each obstacle, when lags were read. */
void step_measure_lags(const step_model *model, motion_state *state, step_work *work);
/* [m] How far a vertex of the world's state is from where it is drawn. */
vec3 step_get_lag(const step_model *model, const step_work *work, size_t vertex);

#endif
