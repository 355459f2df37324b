/* world/lag/lag.h - the lagging surface of obstacles that deform: what cloth meets.
 *
 * Bodies of animations pass through themselves. Cloth that is between two parts then has no room,
 * whoever moves it. So cloth does not meet the drawn surface, as the frames have it, but a lagging
 * one. It is the drawn one wherever there is room. Where the drawn one closes on cloth it lags
 * behind, by a way of each vertex (the lag), and it comes back as soon as there is room.
 *
 * The lagging surface is where the state has the obstacle's vertices; the state keeps the lags
 * beside it. A world without lags is that of the drawn surfaces, to the bit. */
#ifndef TULLE_WORLD_LAG_LAG_H
#define TULLE_WORLD_LAG_LAG_H

#include "world/step/step.h"

/* Whether the world lets an obstacle lag. */
bool world_may_lag(const tulle_world *world, size_t obstacle);

/* Before the substeps of a step: where the lagging surfaces are to be at its end, so that cloth
 * between parts of them keeps its room. Lies in the scratch arena. */
tulle_status world_begin_lag(step_context *context);
/* Takes the targets of a substep as the script gives them, and puts lagging surfaces on their way.
 */
void world_lead_lag(step_context *context);
/* After the substeps of a step: the lags with which it ends; the largest goes into the report. */
void world_end_lag(step_context *context);

/* Whether a step that is stuck is worth another try with more lag at once: what blocked it may lag.
 * Else shorter substeps come first, as for all that is rigid. */
bool world_may_feel(const step_context *context);
/* After a pinch: what deforms around the place moves less when the step is made anew. False when it
 * stands still already. */
bool world_feel_pinch(step_context *context, const blocked_place *place);

/* Whether an obstacle of the state lags. */
bool world_has_lags(const tulle_world *world, const motion_state *state);
/* Finds the largest lag of each obstacle, when lags were read. */
void world_measure_lags(const tulle_world *world, motion_state *state);
/* [m] How far a vertex of the world's state is from where it is drawn. */
vec3 world_get_lag(const tulle_world *world, size_t vertex);

#endif
