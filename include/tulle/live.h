/* tulle/live.h - control of a world that runs. A host gives poses of obstacles and pins for the
 * next step. It changes gravity, wind, and materials, thickness, pins and sleep of cloth. It may
 * start a world in the middle of a motion. Engines and editors need it: they know the next pose of
 * a character, a gripper or a hand only just before a step.
 *
 * A step moves things from their present places to the given places. Rigid obstacles move as
 * between two keyframes, all else on straight lines. Friction and impacts see the velocity of that
 * motion, as on a script. Without a given pose an obstacle stands still at its last one, and pins
 * stay where they are. An obstacle that deforms lags behind its given positions where they leave
 * cloth no room (TULLE_ON_PINCH_LAG).
 *
 * Poses and targets are for one step. The step uses them up, even if it fails. A
 * tulle_world_load_state that succeeds discards them. (A call that is refused for its time step
 * does not count as a step.) A saved state holds where things are, not where they are to go; to
 * roll back, load a state and give the same poses again. Poses and targets are refused before the
 * start, and a second time for the same step. examples/live_character.c is a whole program; see
 * docs/guide/embed.md.  */
#ifndef TULLE_LIVE_H
#define TULLE_LIVE_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- motion ---- */

/* How an obstacle gets to its given pose. */
typedef enum tulle_travel {
    /* it moves there during the step, and pushes cloth before it */
    TULLE_TRAVEL_MOVE,
    /* It jumps there before the step, and stands still during it. Cloth in between feels nothing.
     * If the obstacle would land in cloth, the step is refused with TULLE_ERROR_INTERSECTING_START
     * and nothing jumps, unless start_intersections is `ignore`; this is as for an obstacle that
     * appears. A step with jumps costs one judgement of the whole world by
     * tulle_check_intersections. */
    TULLE_TRAVEL_JUMP
} tulle_travel;

/* Sets the pose of an obstacle of TULLE_DRIVE_RIGID at the end of the next step. Vertex x of its
 * mesh is then at translation [m] + R (x - pivot) + pivot. R is the unit quaternion `rotation` (w,
 * x, y, z); the pivot is that in the obstacle's `motion`. Turns take the shorter way. The cost does
 * not depend on the mesh. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has
 * not started, an obstacle with another drive or with a pose already given, numbers that are not
 * finite or above 1e100, a length of the quaternion that differs from 1 by more than 1e-6). After
 * an error no pose is given. */
TULLE_API tulle_status tulle_obstacle_set_next_transform(tulle_world *world, tulle_obstacle_id id,
                                                         const double translation[3],
                                                         const double rotation[4],
                                                         tulle_travel travel, tulle_error *error);
/* Sets the positions of an obstacle of TULLE_DRIVE_DEFORMING at the end of the next step: 3 *
 * `vertex_count` `positions` [m], copied, for all vertices of its mesh in their order. Errors as of
 * tulle_obstacle_set_next_transform, and for another count. */
TULLE_API tulle_status tulle_obstacle_set_next_positions(tulle_world *world, tulle_obstacle_id id,
                                                         const double *positions,
                                                         size_t vertex_count, tulle_travel travel,
                                                         tulle_error *error);

/* Sets the positions of the vertices of a pin at the end of the next step: 3 * `vertex_count`
 * `positions` [m], copied, in the order of tulle_pin.vertices. `pin` is the number of the pin in
 * its cloth's def; it must have no keyframes. If two pins hold a vertex, the later pin counts.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not started, a pin that
 * is not there, follows keyframes, has let go or was given targets already, another count, numbers
 * that are not finite or above 1e100). After an error no target is given. */
TULLE_API tulle_status tulle_cloth_set_pin_targets(tulle_world *world, tulle_cloth_id id,
                                                   size_t pin, const double *positions,
                                                   size_t vertex_count, tulle_error *error);

/* Where a cloth is drawn in the next step. */
typedef struct tulle_cloth_targets {
    const double *positions;     /* [m] 3 * vertex_count */
    const double *departures;    /* [m] 3 * vertex_count: displacements from these; null: none */
    const unsigned char *is_led; /* vertex_count: not 0 where a vertex is led; null: none is */
    size_t vertex_count;         /* of the cloth */
} tulle_cloth_targets;
/* Draws a cloth to targets in the next step. This call and tulle_world_place are experimental: they
 * may change. A vertex sets out at the speed that leads it to its position and departure, whatever
 * its velocity was. A force that holds it off its target stretches a spring of area_density /
 * time_step^2 [N/m^3] for each area at rest. Bending acts on the difference between positions and
 * targets. So the shape of the targets costs nothing, and neighbours depart from it together. A
 * vertex that is led goes straight to its target position, as if pinned. In such a step no cloth is
 * judged by how far its edges stretch, and elastic_energy of the report counts bending as ever. All
 * is copied. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not started,
 * cloth in the world that is bent at rest, targets that were given already, another count, numbers
 * that are not finite or above 1e100), TULLE_ERROR_OUT_OF_MEMORY; nothing is given then. */
TULLE_API tulle_status tulle_cloth_set_targets(tulle_world *world, tulle_cloth_id id,
                                               const tulle_cloth_targets *targets,
                                               tulle_error *error);
/* Puts cloths and obstacles of TULLE_DRIVE_DEFORMING elsewhere, between two steps: 3 *
 * `vertex_count` `positions` [m] of all cloths, then of all obstacles, each in the order of adding;
 * positions of other obstacles are not read. Everything that was put elsewhere stands still,
 * nothing lags, and all contacts are new. Costs a judgement of the whole world by
 * tulle_check_intersections. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a world that has not
 * started, another count, numbers that are not finite or above 1e100),
 * TULLE_ERROR_INTERSECTING_START, TULLE_ERROR_OUT_OF_MEMORY; then everything stays where it was. */
TULLE_API tulle_status tulle_world_place(tulle_world *world, const double *positions,
                                         size_t vertex_count, tulle_error *error);

/* ---- settings ---- */

/* Changes `gravity` [m/s^2], -1e6 .. 1e6 along each axis, from the next step on. Before the start
 * it replaces the gravity of the def. Bodies wake. From then on gravity is part of the state:
 * saved, restored by tulle_world_load_state, and in the hash unless it equals the gravity at the
 * start. Setting the present gravity costs nothing. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a
 * number out of range); gravity then stays as it was. */
TULLE_API tulle_status tulle_world_set_gravity(tulle_world *world, const double gravity[3],
                                               tulle_error *error);
/* Changes `wind`, as tulle_world_set_gravity does gravity; ranges as of tulle_wind. Bodies wake
 * when cloth presses on them differently. Gusts follow the time of the world: the same seed gives
 * the same gust at the same time, whenever the wind was set. */
TULLE_API tulle_status tulle_world_set_wind(tulle_world *world, const tulle_wind *wind,
                                            tulle_error *error);

/* Changes what a cloth is made of, from the next step on: weight, stiffness, bending and damping.
 * The values for contact stay: friction, its direction and restitution are laws of pairs. A change
 * costs as much as the start of the cloth; setting the present material costs nothing. The material
 * is part of the state, as gravity is. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a
 * world that has not started, values out of range, hysteresis in only one of the old and the new
 * material), TULLE_ERROR_OUT_OF_MEMORY; the cloth then stays as it was. */
TULLE_API tulle_status tulle_cloth_set_material(tulle_world *world, tulle_cloth_id id,
                                                const tulle_material *material, tulle_error *error);
/* Changes the distance [m] at which contact of a cloth acts, from the next step on: from twice the
 * minimum gap up to the largest contact distance of the start. Between two cloths the mean of both
 * counts. Surfaces that are nearer are pushed apart, no faster than 5 cm/s. The thickness is part
 * of the state. Errors: TULLE_ERROR_INVALID_ARGUMENT (a stale id, a world that has not started, out
 * of range), TULLE_ERROR_OUT_OF_MEMORY; the thickness then stays as it was. */
TULLE_API tulle_status tulle_cloth_set_thickness(tulle_world *world, tulle_cloth_id id,
                                                 double thickness, tulle_error *error);
/* Releases a pin for good, from the next step on. Nothing happens if it is released already. `pin`
 * is its number in the cloth's def. The release is part of the state. Cloth bends again where the
 * pin clamped it; that costs as much as the start of the cloth. To hold and release vertices
 * repeatedly, use attachments (tulle/attach.h). Errors: TULLE_ERROR_INVALID_ARGUMENT (a stale id, a
 * world that has not started, no such pin), TULLE_ERROR_OUT_OF_MEMORY; the pin then still holds. */
TULLE_API tulle_status tulle_cloth_release_pin(tulle_world *world, tulle_cloth_id id, size_t pin,
                                               tulle_error *error);

/* ---- sleep ---- */

/* If the world's def has a sleep_speed, cloth falls asleep after it has been slow for sleep_time.
 * Slow means that no vertex is faster than sleep_speed and that the centre of mass is not faster
 * than a tenth of it. All cloth that touches it or is tied to it, directly or through other cloth,
 * must be slow, too; and no body that is awake may touch it. A sleeping cloth keeps its exact
 * position and acts as an obstacle. A step of a world in which everything sleeps costs next to
 * nothing; tulle_world_get_contacts then still gives the contacts of the last step in which
 * something was awake. In other steps the contacts between a sleeping cloth and things that stand
 * or sleep are not listed, nor are they in the forces on its vertices. A cloth wakes
 *   - when an obstacle on a script or driven by the host moves within the separation distance of
 *     its box;
 * - when cloth or a body that is awake presses on it;
 *   - when a pin or an attachment that holds it moves, lets go or is made;
 *   - when a neighbour that it touches wakes: at once, or in the next step if a call of the host
 *     woke the neighbour;
 *   - when an obstacle appears or leaves by its times (appear_time, disappear_time), when gravity,
 *     wind, a material, a law or a thickness changes, and by tulle_cloth_wake.
 *
 * While wind has gusts, no cloth falls asleep. A sleep_speed of 1 mm/s and a sleep_time of 0.5 s
 * suit most scenes: the remaining swing is then less than a millimetre. Sleep is part of the state.
 */

/* 1 while a cloth sleeps; 0 for a stale id and for a null world. */
TULLE_API int tulle_cloth_is_asleep(const tulle_world *world, tulle_cloth_id id);
/* Wakes a cloth. Objects that touch it wake in the next step. The time for which it must be slow
 * starts again from 0. Error: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not
 * started). */
TULLE_API tulle_status tulle_cloth_wake(tulle_world *world, tulle_cloth_id id, tulle_error *error);

/* ---- starts in the middle of a motion ---- */

/* The state of motion at a time, for example a frame of another run. */
typedef struct tulle_moment {
    double time;              /* [s] >= 0 */
    uint64_t step_count;      /* steps made before; tulle_world_get_step_count counts on from it */
    const double *positions;  /* [m] 3 * vertex_count: of all cloths in the order of adding */
    const double *velocities; /* [m/s] 3 * vertex_count, in the same order */
    size_t vertex_count;      /* of all cloths together */
    /* position, rotation and velocities of each rigid body, in the order of adding; the other
     * members are not read; null: no body */
    const tulle_transform *bodies;
    size_t body_count; /* of all rigid bodies of the world */
} tulle_moment;
/* Starts the world as tulle_world_start does, but at a later time. Cloth and rigid bodies are where
 * `moment` has them. Obstacles are where their scripts have them at that time; so are bodies before
 * their start time and bodies that are absent. This state is judged as a start. Rest shapes come
 * from the defs, and pins follow their motion. Attachments hold the places that follow from the
 * objects' places in the defs. Pins without keyframes hold vertices where `moment` has them.
 * Nothing else is carried over: contacts are new, so none sticks yet; hysteresis is as if the cloth
 * had moved there from its rest shape; everything is awake; nothing has broken. Errors as of
 * tulle_world_start; TULLE_ERROR_INVALID_ARGUMENT also for null, numbers that are not finite,
 * another vertex_count or body_count, a quaternion whose length differs from 1 by more than 1e-6,
 * and a world that has started. After an error the world can still be started. */
TULLE_API tulle_status tulle_world_start_at(tulle_world *world, const tulle_moment *moment,
                                            tulle_error *error);

/* ---- rollback ---- */

/* [bytes] Size of the state as tulle_world_save_state_into would save it now. It changes from step
 * to step with the contacts. As a rule, twice the size after some contact is enough for a buffer. 0
 * for null and before the start. Takes a microsecond or less. */
TULLE_API size_t tulle_world_get_state_size(const tulle_world *world);
/* Saves the state into `bytes`, memory of the caller of `capacity` bytes and of any alignment.
 * `byte_count` gets how many bytes were written. They equal the bytes of tulle_world_save_state;
 * tulle_world_load_state takes both. Nothing is allocated. Obstacles that never move are left out.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, not started, capacity below
 * tulle_world_get_state_size); nothing is written then. */
TULLE_API tulle_status tulle_world_save_state_into(const tulle_world *world, void *bytes,
                                                   size_t capacity, size_t *byte_count,
                                                   tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
