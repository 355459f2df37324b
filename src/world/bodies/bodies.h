/* world/bodies/bodies.h - rigid bodies of a world: obstacles that answer contact.
 *
 * Body b has two slots among the vertices, right after those of cloths (contact_body). Their
 * positions are its centre and its orientation, their velocities those of the centre and the
 * angular velocity: a state needs nothing else. Until its start time, and while absent, a body is
 * an obstacle like others, and its slots follow the script. */
#ifndef TULLE_WORLD_BODIES_BODIES_H
#define TULLE_WORLD_BODIES_BODIES_H

#include "world/step/step.h"

/* The obstacle that is a body, its surface, and the first of its two slots. */
static inline world_obstacle *get_body(const tulle_world *world, size_t body) {
    return &world->model.obstacles.data[world->model.body_obstacles[body]];
}
static inline surface_range *get_body_surface(const tulle_world *world, size_t body) {
    return &world->model.surfaces[world->model.cloths.count + world->model.body_obstacles[body]];
}
static inline size_t get_first_slot(const tulle_world *world, size_t body) {
    return world->model.cloth_vertex_count + 2 * body;
}
/* Whether a body is there and answers contact; else it follows its script or is absent. */
static inline bool body_answers(const tulle_world *world, size_t body) {
    const surface_range *const range = get_body_surface(world, body);
    return range->is_body && range->is_present;
}

/* Numbers the bodies. Called before the surfaces are numbered. */
tulle_status world_number_bodies(tulle_world *world);
/* The slots of the bodies in the first state, at its time. `transforms`, or null, has those that
 * are there and free; their vertices follow, the others are where obstacles are. */
void world_place_bodies(tulle_world *world, const tulle_transform *transforms);

/* Frees bodies whose start time has come at the state's time. True when there is one. */
bool world_free_bodies(const tulle_world *world, motion_state *state);
/* Marks the surfaces of the obstacles that are bodies in this state. */
void world_mark_bodies(tulle_world *world, const motion_state *state);

/* What contact reads of the bodies in this substep: context->scene and targets. */
tulle_status world_prepare_bodies(step_context *context);
/* Right-hand sides by the integrator of the cloth's system and its share c; 1: implicit Euler. */
void world_load_bodies(step_context *context, double share);
/* Called after the laws of impact: angular velocities with the inertia at the end, those of the
 * history too, and velocities of the bodies' vertices. Slots of bodies that are not free get what
 * their script says. */
void world_finish_bodies(const step_context *context, double *end);

/* [J] Energies of free bodies, with inertia of `positions`. */
typedef struct body_energies {
    double kinetic, gravity;
} body_energies;
body_energies world_measure_bodies(const tulle_world *world, const double *positions,
                                   const double *velocities);

/* body_access.c: number of a body, or TULLE_NONE with an error. */
uint32_t world_find_body(const tulle_world *world, tulle_obstacle_id id, tulle_error *error);
/* body_control.c: stops a body along what is locked. */
void world_stop_locked(const tulle_world *world, size_t body, double *velocities);
/* body_control.c: gives a body of the state other velocities, three of its centre and three of its
 * turn, zero along what is locked. */
void world_set_body_velocity(tulle_world *world, size_t body, const double *velocities);

/* body_access.c: the impulses [N s] of rows on the body of a slot, and their moments [N m s]. */
void world_sum_contact_impulses(const row_list *rows, size_t slot, double impulse[3],
                                double moment[3]);

#endif
