/* step/pinch/holds.h - what on_pinch: slow holds back, and how it comes back to its script.
 *
 * Two obstacles that pinch cloth are held apart. The hold notes a point of each, the direction
 * across the cloth, and the gap between the points before the pinch. From then on the script moves
 * both as before. Where it would bring the points nearer than the gap, the two are shifted apart by
 * what is missing, in the ratio in which they approached. So obstacles that close stand still, and
 * obstacles that then lift or turn together keep their gap. As soon as the script asks for more
 * than the gap, the shift is zero. The shift follows from the time alone; nothing is tried in
 * between. One obstacle that runs into cloth that cannot give way is held apart from what is fixed
 * in the same way.
 *
 * Where that does not help, the obstacle stands still for some steps and then goes towards its
 * script. After each try that pinches again it waits twice as many steps. At last all that follows
 * a script, pins included, is held like that. */
#ifndef TULLE_STEP_PINCH_HOLDS_H
#define TULLE_STEP_PINCH_HOLDS_H

#include "step/step_work.h"

typedef enum hold_kind {
    HOLD_APART, /* of two obstacles, or of one and what is fixed */
    HOLD_STILL, /* one obstacle */
    HOLD_ALL    /* all that follows a script */
} hold_kind;

/* Before the substeps of a step. */
void step_begin_holds(motion_state *state, step_work *work);
/* Takes the targets of a substep as the script gives them and puts them where the holds let them
 * be.
 */
void step_hold_targets(const step_model *model, motion_state *state, step_work *work);
/* After the substeps of a step: ends holds that hold nothing back any more. */
void step_end_holds(motion_state *state, step_work *work);

/* Adds a hold, or replaces the one of the same kind for the same obstacles. False when there are
 * too many. */
bool step_add_hold(motion_state *state, const world_hold *hold);
/* Makes the holds that are being tried wait again, for longer. False when there are none. */
bool step_delay_holds(motion_state *state);

/* Whether an obstacle is held back or lags. obstacles.count stands for all that follows a script,
 * pins included. */
bool step_is_held(const step_model *model, const motion_state *state, size_t obstacle);

/* Mean of up to four points of `positions`; zero for no obstacle. */
vec3 step_get_hold_point(const world_hold *hold, int side, const double *positions);

/* Of holds that were read: whether they name what is there, with numbers that a hold may have. */
bool step_holds_are_valid(const step_model *model, const motion_state *state,
                          const step_work *work);

#endif
