/* step/bodies/bodies_sleep.h - bodies that have come to rest stand still at no cost.
 *
 * A body may sleep if its def has a sleep_speed. It falls asleep when it, and all bodies that
 * touch it directly or over others, have been slower than that for their sleep_time. A sleeper
 * is an obstacle that stands: the solve has no unknowns for it, and it has no pairs with other
 * sleepers or with obstacles that stand.
 *
 * All bodies that fell asleep together wake together:
 * - before a substep in which something on a script moves near them;
 * - when a body that is awake presses on them, or when cloth presses more or less than when they
 *   fell asleep; then the substep is repeated;
 * - when an obstacle appears or leaves;
 * - when the user gives one of them an impulse. */
#ifndef TULLE_STEP_BODIES_BODIES_SLEEP_H
#define TULLE_STEP_BODIES_BODIES_SLEEP_H

#include "step/bodies/bodies.h"

/* Wakes `body` and those that fell asleep with it; wakes all bodies and all cloth. */
void step_wake_body(const step_model *model, motion_state *state, size_t body);
void step_wake_all(const step_model *model, motion_state *state);

/* Called before a substep, when its targets are known: wakes bodies that something on a script
 * comes near, and marks the surfaces of sleepers. Fails when memory is short. */
tulle_status step_wake_near_script(const step_model *model, motion_state *state, step_work *work);
/* Called after resolve_impacts: wakes bodies and cloth that are pressed. Then the substep is
 * repeated. */
tulle_status step_wake_pressed(const step_model *model, motion_state *state, step_work *work,
                               bool *wakes);
/* Called before the rows are stored: puts the contacts that have no row into sub.resting: contacts
 * of sleepers with one another and with obstacles that stand. */
tulle_status step_keep_resting(const step_model *model, motion_state *state, step_work *work);
/* Called at the end of a step: decides which bodies fall asleep. */
tulle_status step_settle_bodies(const step_model *model, motion_state *state, step_work *work);

#endif
