/* step/bodies/bodies.c - see bodies.h. */
#include "step/bodies/bodies.h"

#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "contact/solve/body_drives.h"
#include "contact/solve/solve_bodies.h"
#include "geom/mass_properties.h"

#include <math.h>
#include <string.h>

/* If the body has locks or a drive, gives the scene's body a drive in the scratch arena and stops
 * motion along locked axes. False: no memory. */
static bool prepare_drive(const step_model *model, motion_state *state, step_work *work,
                          size_t body) {
    const body_control *const control = &model->controls[body];
    if (control->locks == 0 && !control->is_driven) return true;
    body_drive *const drive = ARENA_NEW_ZEROED(&work->scratch, body_drive, 1);
    if (!drive) return false;
    double *const axes = state->velocities + 3 * get_first_slot(model, body);
    for (int k = 0; k < BODY_AXES; k++) {
        drive->is_locked[k] = control->locks >> k & 1u;
        if (drive->is_locked[k]) axes[k] = 0.0;
    }
    work->sub.scene.bodies[body].drive = drive;
    return true;
}

/* Gains, pushes and limits of a drive for the time [s] that forces act on u. */
static void load_drive(const step_model *model, step_work *work, size_t body, double force_time) {
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

/* Notes in state the force and torque of the drive in the substep. */
static void note_drive(const step_model *model, motion_state *state, step_work *work, size_t body) {
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

void step_compute_script_pose(const world_obstacle *obstacle, double time, vec3 *centre,
                              quaternion *orientation) {
    quaternion const turn = motion_compute_pose(&obstacle->motion, time, NULL).rotation;
    double point[3];
    vec3_store(point, 0, obstacle->centre);
    motion_apply(&obstacle->motion, time, point, 1, point);
    *centre = vec3_load(point, 0);
    *orientation = quaternion_normalize(quaternion_multiply(turn, obstacle->axes));
}

bool step_free_bodies(const step_model *model, motion_state *state) {
    bool has_changed = false;
    for (size_t b = 0; b < model->body_count; b++) {
        body_rest *const rest = &state->rests[b];
        bool const is_due = state->time >= get_body(model, b)->body.start_time;
        if (rest->state != BODY_SCRIPTED || !is_due) continue;
        rest->state = BODY_FREE;
        has_changed = true;
    }
    return has_changed;
}

void step_mark_bodies(const step_model *model, const motion_state *state, step_work *work) {
    for (size_t b = 0; b < model->body_count; b++)
        get_body_surface(model, work, b)->is_body = state->rests[b].state != BODY_SCRIPTED;
}

void step_load_bodies(const step_model *model, step_work *work, double share) {
    const cloth_start *const dynamics = &work->sub.dynamics;
    bool const is_bdf2 = work->system.integrator == TULLE_INTEGRATOR_BDF2 && share < 1.0;
    double const c = share, d = 1.0 - c, alpha = c * work->sub.time_step;
    double const gamma = is_bdf2 ? c * alpha : alpha;
    for (size_t b = 0; b < work->sub.scene.body_count; b++) {
        contact_body *const body = &work->sub.scene.bodies[b];
        const rigid_body *const rigid = body->body;
        if (!body->is_free) continue;
        const world_obstacle *const obstacle = get_body(model, b);
        size_t const slot = get_first_slot(model, b);
        double const dampings[2] = {rigid->linear_damping, rigid->angular_damping};
        vec3 starts[2] = {vec3_load(work->sub.scene.v0, slot),
                          vec3_load(work->sub.scene.v0, slot + 1)};
        for (size_t i = 0; i < 2 && is_bdf2; i++) {
            vec3 const mean = vec3_load(dynamics->previous_mean, slot + i);
            vec3 const before = vec3_load(dynamics->previous_velocities, slot + i);
            starts[i] = vec3_add_scaled(vec3_scale(starts[i], c * (2.0 - c)), before, -c * d);
            starts[i] = vec3_add_scaled(starts[i], mean, d + alpha * d * dampings[i]);
        }
        vec3 const pull =
            vec3_add_scaled(work->sub.scene.gravity, obstacle->given_force, 1.0 / rigid->mass);
        vec3 const spin = mat3_multiply_vec3(&body->inertia, starts[1]);
        body->momentum = vec3_scale(vec3_add_scaled(starts[0], pull, gamma), rigid->mass);
        body->spin = vec3_add_scaled(spin, obstacle->given_torque, gamma);
        body->mass_factor = 1.0 + alpha * dampings[0];
        body->inertia_factor = 1.0 + alpha * dampings[1];
        body->has_own_answers =
            body->drive || body->mass_factor != 1.0 || body->inertia_factor != 1.0;
        load_drive(model, work, b, gamma);
        update_body_answers(body);
    }
}

tulle_status step_prepare_bodies(const step_model *model, motion_state *state, step_work *work) {
    contact_scene *const scene = &work->sub.scene;
    scene->body_count = model->body_count;
    scene->surface_bodies = model->surface_bodies;
    scene->bodies = ARENA_NEW(&work->scratch, contact_body, model->body_count);
    if (!scene->bodies) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t b = 0; b < model->body_count; b++) {
        const world_obstacle *const obstacle = get_body(model, b);
        size_t const slot = get_first_slot(model, b), begin = obstacle->vertex_begin;
        size_t const count = obstacle->mesh.vertex_count;
        quaternion const orientation = unpack_orientation(vec3_load(state->positions, slot + 1));
        bool const answers = body_answers(model, work, b);
        contact_body *const body = &scene->bodies[b];
        *body = (contact_body){.body = &obstacle->rigid,
                               .points = obstacle->points,
                               .vertex_begin = obstacle->vertex_begin,
                               .vertex_end = obstacle->vertex_begin + (uint32_t)count,
                               .is_free = answers && state->rests[b].state != BODY_SLEEPS,
                               .mass_factor = 1.0,
                               .inertia_factor = 1.0,
                               .start = {.position = vec3_load(state->positions, slot),
                                         .orientation = orientation,
                                         .velocity = vec3_load(state->velocities, slot)}};
        memcpy(work->targets + 3 * slot, state->positions + 3 * slot, 6 * sizeof(double));
        if (!answers) continue;
        memcpy(work->targets + 3 * begin, state->positions + 3 * begin, 3 * count * sizeof(double));
        body->inertia = rigid_compute_inertia(&obstacle->rigid, orientation);
        if (body->is_free && !prepare_drive(model, state, work, b))
            return TULLE_ERROR_OUT_OF_MEMORY;
        update_body_answers(body);
        body->start.velocity = vec3_load(state->velocities, slot);
    }
    step_load_bodies(model, work, 1.0);
    /* what drives do if nothing is in the way */
    start_bodies(scene, NULL, work->sub.mean_velocity);
    (void)settle_drives(scene, NULL, 0, work->sub.mean_velocity);
    /* the free turn in the step */
    for (size_t b = 0; b < model->body_count; b++) {
        contact_body *const body = &scene->bodies[b];
        if (!body->is_free) continue;
        vec3 const turn_rate =
            vec3_load(work->sub.mean_velocity, (size_t)get_body_slot(scene, b) + 1);
        rigid_state end = body->start;
        bool const is_as_given = !body->drive && body->inertia_factor == 1.0;
        end.spin = is_as_given ? body->spin : mat3_multiply_vec3(&body->inertia, turn_rate);
        body->turn = mat3_identity(1.0);
        body->turn_vector = vec3_make(0.0, 0.0, 0.0);
        if (!drift_body(body, end.velocity, turn_rate, work->sub.time_step, &end)) continue;
        body->turn_vector = vec3_scale(turn_rate, work->sub.time_step);
        body->turn = quaternion_to_matrix(
            quaternion_multiply(end.orientation, quaternion_conjugate(body->start.orientation)));
    }
    return TULLE_OK;
}

/* Slots of a body that follows its script: places at the end of the substep, velocities into
 * `end`. */
static void follow_script(const step_model *model, const motion_state *state, step_work *work,
                          size_t index, double *end) {
    const world_obstacle *const obstacle = get_body(model, index);
    size_t const slot = get_first_slot(model, index);
    double const from = state->time, to = from + work->sub.passed;
    vec3 centre[2];
    quaternion orientation[2];
    step_compute_script_pose(obstacle, from, &centre[0], &orientation[0]);
    step_compute_script_pose(obstacle, to, &centre[1], &orientation[1]);
    vec3_store(work->sub.end, slot, centre[1]);
    vec3_store(work->sub.end, slot + 1, pack_orientation(orientation[1]));
    bool const moves = obstacle->motion.key_count > 0 && work->sub.passed > 0.0;
    if (!moves) return;
    double const rate = 1.0 / work->sub.passed;
    vec3_store(end, slot, vec3_scale(vec3_sub(centre[1], centre[0]), rate));
    /* a substep turns by less than half a turn */
    vec3_store(end, slot + 1,
               vec3_scale(quaternion_find_turn(orientation[0], orientation[1]), rate));
}

void step_finish_bodies(const step_model *model, motion_state *state, step_work *work,
                        double *end) {
    const contact_scene *const scene = &work->sub.scene;
    double *const history[2] = {state->previous_mean, state->previous_velocities};
    state->lost_energy = work->sub.lost_energy;
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b);
        if (!body->is_free) {
            memcpy(end + 3 * slot, scene->v0 + 3 * slot, 6 * sizeof(double));
            note_drive(model, state, work, b);
            if (state->rests[b].state != BODY_SLEEPS) follow_script(model, state, work, b, end);
            if (history[0]) memcpy(history[0] + 3 * slot, end + 3 * slot, 6 * sizeof(double));
            continue;
        }
        quaternion const orientation = unpack_orientation(vec3_load(work->sub.end, slot + 1));
        mat3 inverse = rigid_compute_inverse_inertia(body->body, orientation);
        if (body->drive) {
            mat3 const inertia = rigid_compute_inertia(body->body, orientation);
            inverse = compute_free_inverse(&inertia, body->drive->is_locked + 3);
        }
        double *const turns[3] = {end, history[0], history[1]};
        for (int i = 0; i < 3 && turns[i]; i++) { /* spins stay */
            vec3 const spin = mat3_multiply_vec3(&body->inertia, vec3_load(turns[i], slot + 1));
            vec3_store(turns[i], slot + 1, mat3_multiply_vec3(&inverse, spin));
        }
        note_drive(model, state, work, b);
        double const rate = work->sub.passed > 0.0 ? 1.0 / work->sub.passed : 0.0;
        for (size_t i = 3 * (size_t)body->vertex_begin; i < 3 * (size_t)body->vertex_end; i++)
            end[i] = rate * (work->sub.end[i] - scene->x0[i]);
    }
}

body_energies step_measure_bodies(const step_model *model, step_work *work, const double *positions,
                                  const double *velocities) {
    body_energies energies = {0};
    vec3 const gravity = vec3_load(model->def.gravity, 0);
    for (size_t b = 0; b < model->body_count; b++) {
        if (!body_answers(model, work, b)) continue;
        const rigid_body *const rigid = &get_body(model, b)->rigid;
        size_t const slot = get_first_slot(model, b);
        quaternion const orientation = unpack_orientation(vec3_load(positions, slot + 1));
        vec3 const turn = vec3_load(velocities, slot + 1);
        energies.kinetic += 0.5 * rigid->mass * vec3_norm2(vec3_load(velocities, slot)) +
                            0.5 * vec3_dot(turn, rigid_compute_spin(rigid, orientation, turn));
        energies.gravity -= rigid->mass * vec3_dot(gravity, vec3_load(positions, slot));
    }
    return energies;
}

void step_sum_contact_impulses(const row_list *rows, size_t slot, double impulse[3],
                               double moment[3]) {
    vec3 sum = {0.0, 0.0, 0.0}, turn = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < rows->rows.count; i++) {
        const contact_row *const row = &rows->rows.data[i];
        for (int side = 0; side < 2 && row->frame.has_body; side++) {
            if (row->frame.slots[side] != slot) continue;
            sum = vec3_add_scaled(sum, row->solve.impulse, side == 0 ? 1.0 : -1.0);
            turn = vec3_add(turn, vec3_cross(row->frame.arms[side], row->solve.impulse));
        }
    }
    vec3_store(impulse, 0, sum);
    vec3_store(moment, 0, turn);
}
