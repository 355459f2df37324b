/* step/bodies/body_drive.c - see body_drive.h. */
#include "step/bodies/body_drive.h"

#include "contact/solve/body_drives.h"
#include "step/bodies/bodies.h"

#include <math.h>
#include <string.h>

/* ---- velocities and forces ---- */

void step_stop_locked(const step_model *model, size_t body, double *velocities) {
    double *const axes = velocities + 3 * get_first_slot(model, body);
    for (int k = 0; k < BODY_AXES; k++)
        if (model->controls[body].locks >> k & 1u) axes[k] = 0.0;
}

/* ---- in a substep ---- */

bool step_prepare_drive(const step_model *model, motion_state *state, step_work *work,
                        size_t body) {
    const body_control *const control = &model->controls[body];
    if (control->locks == 0 && !control->is_driven) return true;
    body_drive *const drive = ARENA_NEW_ZEROED(&work->scratch, body_drive, 1);
    if (!drive) return false;
    for (int k = 0; k < BODY_AXES; k++) drive->is_locked[k] = control->locks >> k & 1u;
    step_stop_locked(model, body, state->velocities);
    work->sub.scene.bodies[body].drive = drive;
    return true;
}

void step_load_drive(const step_model *model, step_work *work, size_t body, double force_time) {
    contact_body *const moved = &work->sub.scene.bodies[body];
    const body_control *const control = &model->controls[body];
    if (!moved->drive) return;
    if (!control->is_driven) return;
    const tulle_body_drive *const given = &control->drive;
    quaternion const target = quaternion_multiply(
        quaternion_normalize(quaternion_load(given->rotation)), get_body(model, body)->axes);
    double ways[BODY_AXES];
    vec3_store(ways, 0, vec3_sub(vec3_load(given->position, 0), moved->start.position));
    vec3_store(ways, 1, quaternion_find_turn(moved->start.orientation, target));
    for (int k = 0; k < BODY_AXES; k++) {
        bool const turns = k >= 3;
        int const axis = k % 3;
        double const stiffness = (turns ? given->angular_stiffness : given->stiffness)[axis];
        double const damping = (turns ? given->angular_damping : given->damping)[axis];
        double const speed = (turns ? given->angular_velocity : given->velocity)[axis];
        double const limit = (turns ? given->torque_limit : given->force_limit)[axis];
        if (moved->drive->is_locked[k]) continue;
        moved->drive->gains[k] = force_time * (damping + work->sub.time_step * stiffness);
        moved->drive->pushes[k] = force_time * (stiffness * ways[k] + damping * speed);
        moved->drive->limits[k] = force_time * limit;
    }
}

void step_note_drive(const step_model *model, motion_state *state, step_work *work, size_t body) {
    const body_control *const control = &model->controls[body];
    const body_drive *const drive = work->sub.scene.bodies[body].drive;
    double *const forces = state->drive_forces + BODY_AXES * body;
    memset(forces, 0, BODY_AXES * sizeof *forces);
    double const time = work->system.force_time;
    for (int k = 0; drive && control->is_driven && k < BODY_AXES; k++) {
        double const limit =
            k < 3 ? control->drive.force_limit[k] : control->drive.torque_limit[k - 3];
        forces[k] = fmax(-limit, fmin(limit, drive->impulses[k] / time));
    }
}

double step_measure_control_work(const step_model *model, motion_state *state, step_work *work) {
    double const whole = work->sub.time_step / work->system.force_time;
    double sum = 0.0;
    for (size_t b = 0; b < model->body_count; b++) {
        const world_obstacle *const obstacle = get_body(model, b);
        size_t const slot = get_first_slot(model, b);
        const double *const u = work->sub.mean_velocity + 3 * slot;
        const body_drive *const drive = work->sub.scene.bodies[b].drive;
        if (!work->sub.scene.bodies[b].is_free) continue;
        for (int k = 0; drive && k < BODY_AXES; k++) sum += whole * drive->impulses[k] * u[k];
        vec3 const way =
            vec3_sub(vec3_load(work->sub.end, slot), vec3_load(state->positions, slot));
        sum += vec3_dot(obstacle->given_force, way) +
               work->sub.time_step * vec3_dot(obstacle->given_torque, vec3_load(u, 1));
    }
    return sum;
}
