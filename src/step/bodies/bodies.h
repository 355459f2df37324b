/* step/bodies/bodies.h - rigid bodies of a world: obstacles that answer contact.
 *
 * Body b has two slots among the vertices, right after those of cloths (contact_body). Their
 * positions are its centre and its orientation, their velocities are the velocity of the centre and
 * the angular velocity: a state needs nothing else. Until its start time, and while absent, a body
 * is an obstacle like others, and its slots follow the script. */
#ifndef TULLE_STEP_BODIES_BODIES_H
#define TULLE_STEP_BODIES_BODIES_H

#include "step/step_work.h"

/* The obstacle that is a body, its surface, and the first of its two slots. */
static inline world_obstacle *get_body(const step_model *model, size_t body) {
    return &model->obstacles.data[model->body_obstacles[body]];
}
static inline surface_range *get_body_surface(const step_model *model, const step_work *work,
                                              size_t body) {
    return &work->surfaces[model->cloths.count + model->body_obstacles[body]];
}
static inline size_t get_first_slot(const step_model *model, size_t body) {
    return model->cloth_vertex_count + 2 * body;
}
/* Whether a body is present and answers contact; otherwise it follows its script. */
static inline bool body_answers(const step_model *model, const step_work *work, size_t body) {
    const surface_range *const range = get_body_surface(model, work, body);
    return range->is_body && range->is_present;
}

/* Frees bodies whose start time has come at the state's time. True when there is one. */
bool step_free_bodies(const step_model *model, motion_state *state);
/* Marks the surfaces of the obstacles that are bodies in this state. */
void step_mark_bodies(const step_model *model, const motion_state *state, step_work *work);

/* Fills in sub.scene and targets, from which contact reads the bodies in this substep. */
tulle_status step_prepare_bodies(const step_model *model, motion_state *state, step_work *work);
/* Right-hand sides by the integrator of the cloth's system and its share c; 1: implicit Euler. */
void step_load_bodies(const step_model *model, step_work *work, double share);
/* Called after the laws of impact: computes angular velocities with the inertia at the end, also of
 * the history, and velocities of the bodies' vertices. Slots of bodies that are not free follow
 * their script. */
void step_finish_bodies(const step_model *model, motion_state *state, step_work *work, double *end);

/* [J] Energies of free bodies, with inertia of `positions`. */
typedef struct body_energies {
    double kinetic, gravity;
} body_energies;
body_energies step_measure_bodies(const step_model *model, step_work *work, const double *positions,
                                  const double *velocities);

/* The impulses [N s] of rows on the body of a slot, and their moments [N m s]. */
void step_sum_contact_impulses(const row_list *rows, size_t slot, double impulse[3],
                               double moment[3]);

/* Centre and orientation of a body as scripted at `time` [s]. */
void step_compute_script_pose(const world_obstacle *obstacle, double time, vec3 *centre,
                              quaternion *orientation);

/* [J] Work of drives and of forces that the host added, in the solved substep. */
double step_measure_control_work(const step_model *model, motion_state *state, step_work *work);

/* bodies_turn.c: cuts *length [s], the length that the substep would have, into equal parts. In
 * none of them a body with its present spin, or an obstacle on keyframes, turns too far. Keyframes
 * come first. An error names the body or the keyframes for which the step would need too many
 * substeps. */
tulle_status step_limit_turns(const step_model *model, motion_state *state, step_work *work,
                              double *length);

/* bodies_turn.c: [s] length of a substep that is short enough for bodies which the solved contacts
 * spin up too much; infinite if there are none. */
double step_find_turn_time(const step_model *model, const step_work *work);

#endif
