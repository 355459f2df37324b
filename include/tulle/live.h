/* tulle/live.h - what a host gives and changes while the world runs: motion step by step, for
 * engines and editors that learn the next pose of a character, a gripper or a hand only before they
 * step; gravity and wind; materials, thickness and pins of cloth; its sleep; starts amid a motion.
 *
 * Each step goes on from where things are to what was given for its end. Within the step rigid
 * obstacles move as between two keyframes, all else on straight lines. Friction and impacts see the
 * velocity of that motion, as on a script. What is given nothing stands still: an obstacle at its
 * last pose, pins where they are. What deforms lags behind what is given where that leaves cloth no
 * room (TULLE_ON_PINCH_LAG).
 *
 * What was given is for one step. That step uses it up, also when it fails, and so does
 * tulle_world_load_state when it succeeds. (A call that is refused for its time step is no step.) A
 * saved state holds where things are, not what they are to do next; to roll back, load a state and
 * give the same again. Poses and targets are refused before the start, and where something was
 * given already. examples/live_character.c is a whole program; docs/guide/embed.md tells more. */
#ifndef TULLE_LIVE_H
#define TULLE_LIVE_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- motion ---- */

/* How an obstacle gets to what is given. */
typedef enum tulle_travel {
    /* it moves there during the step, and pushes cloth before it */
    TULLE_TRAVEL_MOVE,
    /* It jumps there before the step, and stands still during it. Cloth in between feels nothing.
     * What the obstacle lands in is treated as by one that appears: the step is refused with
     * TULLE_ERROR_INTERSECTING_START, and nothing has jumped, unless start_intersections is
     * `ignore`. Jumps cost one judgement of the whole world by tulle_check_intersections. */
    TULLE_TRAVEL_JUMP
} tulle_travel;

/* Tells where an obstacle of TULLE_DRIVE_RIGID is at the end of the next step: vertex x of its mesh
 * at translation [m] + R (x - pivot) + pivot, with the unit quaternion `rotation` (w, x, y, z) as R
 * and the pivot of the obstacle's `motion`. Turns take the shorter way. Costs the same for any
 * mesh. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not started, an
 * obstacle that is not driven so or was given a pose already, numbers that are not finite or above
 * 1e100, a length of the quaternion that differs from 1 by over 1e-6); nothing is given then. */
TULLE_API tulle_status tulle_obstacle_set_next_transform(tulle_world *world, tulle_obstacle_id id,
                                                         const double translation[3],
                                                         const double rotation[4],
                                                         tulle_travel travel, tulle_error *error);
/* Tells where the vertices of an obstacle of TULLE_DRIVE_DEFORMING are at the end of the next step:
 * 3 * `vertex_count` `positions` [m], copied, for all vertices of its mesh in their order. Errors
 * as of tulle_obstacle_set_next_transform, and for another count. */
TULLE_API tulle_status tulle_obstacle_set_next_positions(tulle_world *world, tulle_obstacle_id id,
                                                         const double *positions,
                                                         size_t vertex_count, tulle_travel travel,
                                                         tulle_error *error);

/* Tells where the vertices of a pin are at the end of the next step: 3 * `vertex_count` `positions`
 * [m], copied, in the order of tulle_pin.vertices. `pin` is the number of the pin in its cloth's
 * def; it must have no keyframes. Of two pins that hold a vertex the later one counts. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not started, a pin that is not
 * there, follows keyframes, has let go or was given targets already, another count, numbers that
 * are not finite or above 1e100); nothing is given then. */
TULLE_API tulle_status tulle_cloth_set_pin_targets(tulle_world *world, tulle_cloth_id id,
                                                   size_t pin, const double *positions,
                                                   size_t vertex_count, tulle_error *error);

/* ---- settings ---- */

/* Changes `gravity` [m/s^2], -1e6 .. 1e6 along each axis, from the next step on; before the start
 * as if the def had it. Bodies wake. It is part of the state from then on: saved, put back by
 * tulle_world_load_state, and in the hash unless it is as at the start. Costs nothing where it
 * stays as it is. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a number out of range); gravity is as
 * before then. */
TULLE_API tulle_status tulle_world_set_gravity(tulle_world *world, const double gravity[3],
                                               tulle_error *error);
/* Changes `wind`, as tulle_world_set_gravity does gravity; ranges as of tulle_wind. Bodies wake
 * when cloth presses on them otherwise. Gusts go on by the time of the world: the same seed gives
 * the same gust at the same time, whenever it was set. */
TULLE_API tulle_status tulle_world_set_wind(tulle_world *world, const tulle_wind *wind,
                                            tulle_error *error);

/* Changes what a cloth is made of, from the next step on: weight, stiffness, bending and damping.
 * What contact takes from a material stays: friction, its direction and restitution are laws of
 * pairs. Costs what the start of the cloth took; nothing where the material stays as it is. It is
 * part of the state, as gravity is. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world
 * that has not started, values out of range, hysteresis that comes or goes),
 * TULLE_ERROR_OUT_OF_MEMORY; the cloth is as before then. */
TULLE_API tulle_status tulle_cloth_set_material(tulle_world *world, tulle_cloth_id id,
                                                const tulle_material *material, tulle_error *error);
/* Changes the distance [m] at which contact of a cloth acts, from the next step on: from twice the
 * minimum gap up to the largest contact distance of the start. Between two cloths the mean of both
 * counts. What is nearer is pushed out, no faster than 5 cm/s. It is part of the state. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (a stale id, a world that has not started, out of range),
 * TULLE_ERROR_OUT_OF_MEMORY; the thickness is as before then. */
TULLE_API tulle_status tulle_cloth_set_thickness(tulle_world *world, tulle_cloth_id id,
                                                 double thickness, tulle_error *error);
/* Lets go of a pin for good, from the next step on; nothing happens where it has let go. `pin` is
 * its number in the cloth's def. It is part of the state. Cloth bends again where a pin clamped it;
 * that costs what the start of the cloth took. What is to be held and let go again and again is an
 * attachment (tulle/attach.h). Errors: TULLE_ERROR_INVALID_ARGUMENT (a stale id, a world that has
 * not started, a pin that is not there), TULLE_ERROR_OUT_OF_MEMORY; the pin holds on then. */
TULLE_API tulle_status tulle_cloth_release_pin(tulle_world *world, tulle_cloth_id id, size_t pin,
                                               tulle_error *error);

/* ---- sleep ---- */

/* Cloth falls asleep where the world's def has a sleep_speed, once it has been slow for sleep_time:
 * no vertex faster than sleep_speed, and its centre of mass not faster than a tenth of that; the
 * same holds for all cloth that touches or is tied to it, directly or over others, and no body that
 * is awake does. A sleeping cloth stands still to the bit and is an obstacle for what moves. A step
 * of a world in which all sleeps costs next to nothing; tulle_world_get_contacts then goes on to
 * give the contacts of the last step in which something was awake, beside which contacts of a
 * sleeper with what stands or sleeps are not listed, nor in the forces of its vertices. It wakes
 *   - when something on a script or given moves within its box, widened by the separation distance,
 *     or a contact with cloth or a body that is awake presses on it;
 *   - when a pin or an attachment that holds it moves or lets go, or one is made;
 *   - with what it touches: at once, or in the next step where a call of the host woke that;
 *   - when an obstacle appears or leaves by its times (appear_time, disappear_time), when gravity,
 * wind, a material, a law or a thickness changes, and by tulle_cloth_wake. While wind has gusts,
 * none falls asleep. sleep_speed of 1 mm/s and sleep_time of 0.5 s suit most scenes: what is left
 * then swings by less than a millimetre. Sleep is part of the state. */

/* 1 while a cloth sleeps; 0 for a stale id and for a null world. */
TULLE_API int tulle_cloth_is_asleep(const tulle_world *world, tulle_cloth_id id);
/* Wakes a cloth; what touches it follows in the next step. The time for which it must be slow
 * begins anew. Error: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not
 * started). */
TULLE_API tulle_status tulle_cloth_wake(tulle_world *world, tulle_cloth_id id, tulle_error *error);

/* ---- starts amid a motion ---- */

/* Where what moves in a world is at a time, as a frame of another run has it. */
typedef struct tulle_moment {
    double time;              /* [s] >= 0 */
    uint64_t step_count;      /* steps that led there; tulle_world_get_step_count goes on from it */
    const double *positions;  /* [m] 3 * vertex_count: of all cloths in the order of adding */
    const double *velocities; /* [m/s] 3 * vertex_count, in the same order */
    size_t vertex_count;      /* of all cloths together */
    const tulle_transform *bodies; /* position, rotation and velocities of each rigid body, in the
                                    * order of adding; the rest of it is not read; null: there is
                                    * none */
    size_t body_count;             /* of all rigid bodies of the world */
} tulle_moment;
/* Starts the world as tulle_world_start does, but at a later time: cloth and rigid bodies are where
 * `moment` has them, obstacles are where their scripts have them then, as bodies before their start
 * time and such as are absent, and that is judged. What holds at the start
 * holds still: rest shapes, pins by their motion, and attachments, which hold the places that they
 * take where the defs have the objects. Nothing else is carried over: contacts begin anew, so
 * friction knows no rest; hysteresis is that of cloth that was brought there from its rest shape;
 * all is awake; nothing has broken. Pins without keyframes hold vertices where `moment` has them.
 * Errors as of tulle_world_start; TULLE_ERROR_INVALID_ARGUMENT also for null, numbers that are not
 * finite, another vertex_count or body_count, a rotation that is no unit quaternion to 1e-6, and a
 * world that has started. The world can be started in another way then. */
TULLE_API tulle_status tulle_world_start_at(tulle_world *world, const tulle_moment *moment,
                                            tulle_error *error);

/* ---- rollback ---- */

/* [bytes] Size of the state as tulle_world_save_state_into would save it now. It changes from step
 * to step with the contacts; a buffer of twice the size after some contact is enough as a rule. 0
 * for null and before the start. Takes a microsecond or less. */
TULLE_API size_t tulle_world_get_state_size(const tulle_world *world);
/* Saves the state into `bytes`, memory of the caller of `capacity` bytes and of any alignment, and
 * tells in `byte_count` how many it took. The bytes are those of tulle_world_save_state;
 * tulle_world_load_state takes both. Nothing is allocated. What never changes is left out: a static
 * obstacle costs nothing. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, not started, capacity below
 * tulle_world_get_state_size); nothing is written then. */
TULLE_API tulle_status tulle_world_save_state_into(const tulle_world *world, void *bytes,
                                                   size_t capacity, size_t *byte_count,
                                                   tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
