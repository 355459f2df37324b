/* world/bodies/bodies_sleep.h - bodies that have come to rest stand still at no cost.
 *
 * A body whose def has a sleep_speed falls asleep when it, and all bodies that touch it directly or
 * over others, have been slower than that for their sleep_time. Asleep it is an obstacle that
 * stands: no unknown of the solve, and without pairs with others that sleep or stand. It wakes with
 * all that fell asleep with it: before a substep in which something on a script moves near it;
 * when a body that is awake presses on it, or cloth by more or less than when it fell asleep, and
 * the substep is then made anew; when an obstacle appears or leaves; by an impulse of the user. */
#ifndef TULLE_WORLD_BODIES_BODIES_SLEEP_H
#define TULLE_WORLD_BODIES_BODIES_SLEEP_H

#include "world/bodies/bodies.h"

/* Wakes those that fell asleep with `body`; all. */
void world_wake_body(const tulle_world *world, world_motion_state *state, size_t body);
void world_wake_all(const tulle_world *world, world_motion_state *state);

/* Before a substep, with its targets: wakes what something scripted moves near to, and says which
 * surfaces meet. */
void world_wake_near_script(step_context *context);
/* After stage 8: wakes what is pressed; the outcome is then SUBSTEP_WAKES. */
tulle_status world_wake_pressed(step_context *context);
/* Before the rows are stored: the contacts of sleepers with one another and with what stands, of
 * which no row tells, into context->resting. */
tulle_status world_keep_resting(step_context *context);
/* At the end of a step: who falls asleep. */
tulle_status world_settle_bodies(step_context *context, double time_step);

#endif
