/* step/sleep/cloth_sleep.h - cloth that has come to rest stands still at no cost.
 *
 * Cloth may sleep if the world's def has a sleep_speed. It falls asleep when it, and all cloth that
 * touches it directly or over other cloth, has been slow for sleep_time, and no body that is awake
 * touches any of it. A sleeper is held at all of its vertices: it is an obstacle that stands. It
 * has pairs only with cloth and bodies that are awake, because between all others nothing moves.
 * Its contacts stay in the store.
 *
 * It wakes
 * - before a substep in which something on a script moves near it, its holder moves or lets go,
 * gusts blow, or something that touched it has woken;
 * - when a contact with something that is awake carries load; then the substep is repeated;
 * - when an obstacle appears or leaves, or the host changes its surroundings or wakes it. */
#ifndef TULLE_STEP_SLEEP_CLOTH_SLEEP_H
#define TULLE_STEP_SLEEP_CLOTH_SLEEP_H

#include "step/step_work.h"

/* Wakes a cloth; wakes all cloths. Objects that touch them follow in the next step. The time for
 * which they have been slow restarts, also if they are awake. */
void step_wake_cloth(const step_model *model, motion_state *state, size_t cloth);
void step_wake_cloths(const step_model *model, motion_state *state);
/* Wakes the cloth of a vertex, if it is one of cloth. */
void step_wake_cloth_at(const step_model *model, motion_state *state, uint32_t vertex);

/* Stage 1, when the targets of the script are known: wakes cloth by the rules above, and holds the
 * sleepers where they are. */
void step_hold_sleepers(const step_model *model, motion_state *state, step_work *work);
/* After resolve_impacts: wakes cloth whose contacts carry load. True when there is some. */
bool step_wake_loaded(const step_model *model, motion_state *state, step_work *work);
/* At the end of a step, after step_settle_bodies: puts cloths to sleep, if all of the last substep
 * has passed. */
tulle_status step_settle_cloths(const step_model *model, motion_state *state, step_work *work,
                                bool is_whole);

/* Whether all that may move sleeps, and nothing else moves in the step or ends before it. */
bool step_stands_still(const step_model *model, const step_work *work);
/* Makes a step in which only time passes. */
tulle_status step_pass_still(const step_model *model, motion_state *state, step_work *work);

#endif
