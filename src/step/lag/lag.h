/* step/lag/lag.h - obstacles that lag behind their path where cloth has no room: how they wait.
 *
 * A script knows nothing of cloth: a press closes to nothing, bodies of animations pass through
 * themselves. Cloth between has no room, whoever moves it. So cloth does not meet an obstacle where
 * its path has it (as drawn), but where it lags. The two are the same wherever there is room. Where
 * the drawn obstacle closes on cloth it stays behind, by a displacement of each vertex (the lag),
 * and it comes back as soon as there is room. What is rigid waits as a whole.
 *
 * An obstacle that deforms makes room before it closes. A rigid one does so with on_pinch: slow,
 * from the first pinch on until its lag is zero again. Where room is not enough, all around the
 * place of the pinch stands still for some steps; with slow pinned vertices, too.
 *
 * The state has the vertices where they lag, and the lags beside them. A world without lags has the
 * bits of on_pinch: stop. */
#ifndef TULLE_STEP_LAG_LAG_H
#define TULLE_STEP_LAG_LAG_H

#include "step/step_work.h"

/* Whether frames or a host move the vertices of an obstacle one by one. */
bool step_deforms(const step_model *model, size_t obstacle);
/* Whether an obstacle may lag in the step that runs. */
bool step_lags_now(const step_model *model, const step_work *work, size_t obstacle);

/* Before the substeps of a try: where all that lags is to be at the end of the step, so that cloth
 * keeps its room. Lies in the scratch arena. */
tulle_status step_begin_lag(const step_model *model, step_work *work);
/* Takes the targets of a substep as the script gives them, and puts what lags on its way. */
void step_lead_lag(const step_model *model, motion_state *state, step_work *work);
/* After the substeps: the lags with which the step ends; the largest goes into the report. */
void step_end_lag(const step_model *model, motion_state *state, step_work *work);
/* After a pinch: more lags when the step is made anew. False when nothing is left that might. */
bool step_lag_more(const step_model *model, step_work *work, const blocked_place *place);

/* Whether an obstacle lags; obstacles.count stands for all that follows a script, pins included. */
bool step_is_held(const step_model *model, const motion_state *state, size_t obstacle);
/* Whether anything waits, or has waited just now. */
bool step_has_lags(const step_model *model, const motion_state *state);
/* Finds the largest lag of each obstacle, when lags were read. */
void step_measure_lags(const step_model *model, motion_state *state);
/* [m] How far a vertex of the state is from where it is drawn. */
vec3 step_get_lag(const step_model *model, const motion_state *state, size_t vertex);
/* Of lags and places that were read. */
bool step_lags_are_valid(const step_model *model, const motion_state *state);

#endif
