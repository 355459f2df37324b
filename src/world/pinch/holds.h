/* world/pinch/holds.h - what on_pinch: slow holds back, and how it comes back to its script.
 *
 * Two obstacles that pinch cloth are held apart: a point of each is noted, the direction across the
 * cloth, and the gap between the points before the pinch. From then on the script moves both as
 * before, but for what would bring the points nearer than that gap: that much the two are shifted
 * apart, as they approached. So what closes stands still, what then lifts or turns as a whole does
 * so with its gap kept, and as soon as the script asks for more than the gap the shift is zero. It
 * follows from the time alone; nothing is tried in between. One obstacle that runs into cloth that
 * cannot give way is held apart from what is fixed in the same way.
 *
 * Where that does not help the obstacle stands still for some steps and then goes towards its
 * script, twice as many steps later after each try that pinches again; at last all that follows a
 * script, pins included. */
#ifndef TULLE_WORLD_PINCH_HOLDS_H
#define TULLE_WORLD_PINCH_HOLDS_H

#include "world/step/step.h"

typedef enum hold_kind {
    HOLD_APART, /* of two obstacles, or of one and what is fixed */
    HOLD_STILL, /* one obstacle */
    HOLD_ALL    /* all that follows a script */
} hold_kind;

/* Before the substeps of a step. */
void world_begin_holds(step_context *context);
/* Once the targets of a substep are where the script has them: puts them where holds let them be.
 */
void world_hold_targets(step_context *context);
/* After the substeps of a step: ends holds that have come to nothing. */
void world_end_holds(step_context *context);

/* Adds a hold, or puts it in the place of the same kind for the same obstacles; false when there
 * are too many. */
bool world_add_hold(world_motion_state *state, const world_hold *hold);
/* Makes those that are being tried wait again, longer; false when there are none. */
bool world_delay_holds(world_motion_state *state);

/* Whether an obstacle, or with obstacles.count anything else, is held back. */
bool world_is_held(const tulle_world *world, const world_motion_state *state, size_t obstacle);

/* Whether an obstacle may be held by itself: bodies may not. */
bool world_may_hold(const tulle_world *world, size_t obstacle);

/* Mean of up to four points of `positions`; zero for no obstacle. */
vec3 world_get_hold_point(const world_hold *hold, int side, const double *positions);

/* Of holds that were read: whether they name what is there. */
bool world_holds_are_valid(const tulle_world *world, const world_motion_state *state);

#endif
