/* world/bodies/bodies.c - see bodies.h. */
#include "world/bodies/bodies.h"

#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "contact/solve/body_drives.h"
#include "contact/solve/solve_bodies.h"
#include "geom/mass_properties.h"
#include "world/bodies/body_control.h"

#include <math.h>
#include <string.h>

tulle_status world_make_body(tulle_world *world, world_obstacle *obstacle, tulle_error *error) {
    const tulle_body *const def = &obstacle->body;
    if (!def->is_dynamic) return TULLE_OK;
    if (!get_response(world->model.def.response)->moves_bodies) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the paper's response knows no rigid bodies that answer; use the "
                         "coupled response",
                         obstacle->name);
    }
    tulle_mesh_view const mesh = {obstacle->mesh.positions, obstacle->mesh.vertex_count,
                                  obstacle->mesh.triangles, obstacle->mesh.triangle_count};
    bool const is_shell = def->area_density > 0.0;
    mass_properties unit;
    tulle_status const status =
        mass_properties_compute(&world->heap, mesh, is_shell ? MASS_ON_SURFACE : MASS_IN_VOLUME,
                                obstacle->name, &unit, error);
    if (status != TULLE_OK) return status;
    double density = is_shell ? def->area_density : def->density;
    if (def->mass > 0.0) density = def->mass / unit.measure;
    obstacle->rigid = (rigid_body){.mass = density * unit.measure,
                                   .moments = vec3_scale(unit.moments, density),
                                   .linear_damping = def->linear_damping,
                                   .angular_damping = def->angular_damping};
    obstacle->centre = unit.centre;
    obstacle->axes = unit.axes;
    vec3 const moments = obstacle->rigid.moments;
    double const least = fmin(moments.x, fmin(moments.y, moments.z));
    if (!isfinite(obstacle->rigid.mass) || !(obstacle->rigid.mass > 0.0) || !(least > 0.0) ||
        !isfinite(moments.x + moments.y + moments.z)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: a mass of %g kg and a moment of inertia of %g kg m^2 cannot be "
                         "computed with; check the mass or density and the mesh's unit",
                         obstacle->name, obstacle->rigid.mass, least);
    }
    size_t const count = obstacle->mesh.vertex_count;
    obstacle->points = memory_allocate(&world->heap, 3 * count * sizeof(double));
    if (!obstacle->points) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for %s", obstacle->name);
    }
    obstacle->radius = 0.0;
    for (size_t i = 0; i < count; i++) {
        vec3 const arm = vec3_sub(vec3_load(mesh.positions, i), unit.centre);
        vec3_store(obstacle->points, i, quaternion_rotate(quaternion_conjugate(unit.axes), arm));
        obstacle->radius = fmax(obstacle->radius, vec3_norm(arm));
    }
    return TULLE_OK;
}

tulle_status world_number_bodies(tulle_world *world) {
    size_t const cloth_count = world->model.cloths.count,
                 surface_count = world->model.set.surface_count;
    world->model.body_count = 0;
    world->model.has_sleep = false;
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        world->model.body_count += world->model.obstacles.data[i].body.is_dynamic != 0;
    if (world->model.body_count == 0) return TULLE_OK;
    world->model.surface_bodies = memory_allocate(&world->heap, surface_count * sizeof(uint32_t));
    world->model.body_obstacles = memory_allocate(
        &world->heap, world->model.body_count * sizeof *world->model.body_obstacles);
    if (!world->model.surface_bodies || !world->model.body_obstacles)
        return TULLE_ERROR_OUT_OF_MEMORY;
    uint32_t number = 0;
    for (size_t s = 0; s < surface_count; s++) {
        bool const is_body =
            s >= cloth_count && world->model.obstacles.data[s - cloth_count].body.is_dynamic;
        world->model.surface_bodies[s] = is_body ? number : TULLE_NONE;
        if (is_body) world->model.body_obstacles[number++] = (uint32_t)(s - cloth_count);
    }
    for (size_t b = 0; b < world->model.body_count; b++)
        world->model.has_sleep |= get_body(world, b)->body.sleep_speed > 0.0;
    return TULLE_OK;
}

/* Centre and orientation as scripted at `time`. */
static void compute_script_pose(const world_obstacle *obstacle, double time, vec3 *centre,
                                quaternion *orientation) {
    quaternion const turn = motion_compute_pose(&obstacle->motion, time, NULL).rotation;
    double point[3];
    vec3_store(point, 0, obstacle->centre);
    motion_apply(&obstacle->motion, time, point, 1, point);
    *centre = vec3_load(point, 0);
    *orientation = quaternion_normalize(quaternion_multiply(turn, obstacle->axes));
}

void world_place_bodies(tulle_world *world, const tulle_transform *transforms) {
    motion_state *const state = &world->now;
    (void)world_free_bodies(world, state);
    world_mark_bodies(world, state);
    for (size_t b = 0; b < world->model.body_count; b++) {
        const world_obstacle *const obstacle = get_body(world, b);
        size_t const slot = get_first_slot(world, b);
        vec3 velocity = vec3_load(obstacle->body.velocity, 0);
        vec3 spin = vec3_load(obstacle->body.angular_velocity, 0);
        vec3 centre;
        quaternion orientation;
        compute_script_pose(obstacle, state->time, &centre, &orientation);
        if (transforms && body_answers(world, b)) {
            const double *const q = transforms[b].rotation;
            centre = vec3_load(transforms[b].position, 0);
            orientation = quaternion_normalize(
                quaternion_multiply((quaternion){q[0], q[1], q[2], q[3]}, obstacle->axes));
            velocity = vec3_load(transforms[b].velocity, 0);
            spin = vec3_load(transforms[b].angular_velocity, 0);
            for (size_t i = 0; i < obstacle->mesh.vertex_count; i++) {
                vec3 const arm = quaternion_rotate(orientation, vec3_load(obstacle->points, i));
                vec3_store(state->positions, obstacle->vertex_begin + i, vec3_add(centre, arm));
            }
        }
        vec3_store(state->positions, slot, centre);
        vec3_store(state->positions, slot + 1, pack_orientation(orientation));
        vec3_store(state->velocities, slot, velocity);
        vec3_store(state->velocities, slot + 1, spin);
        for (size_t k = slot; k < slot + 2; k++) {
            vec3_store(world->model.rest, k, obstacle->centre);
            world->model.vertex_surface[k] =
                (uint32_t)(world->model.cloths.count + world->model.body_obstacles[b]);
        }
    }
}

bool world_free_bodies(const tulle_world *world, motion_state *state) {
    bool has_changed = false;
    for (size_t b = 0; b < world->model.body_count; b++) {
        body_rest *const rest = &state->rests[b];
        bool const is_due = state->time >= get_body(world, b)->body.start_time;
        if (rest->state != BODY_SCRIPTED || !is_due) continue;
        rest->state = BODY_FREE;
        has_changed = true;
    }
    return has_changed;
}

void world_mark_bodies(tulle_world *world, const motion_state *state) {
    for (size_t b = 0; b < world->model.body_count; b++)
        get_body_surface(world, b)->is_body = state->rests[b].state != BODY_SCRIPTED;
}

void world_load_bodies(step_context *context, double share) {
    const tulle_world *const world = context->world;
    const cloth_start *const dynamics = &context->dynamics;
    bool const is_bdf2 = world->work.system.integrator == TULLE_INTEGRATOR_BDF2 && share < 1.0;
    double const c = share, d = 1.0 - c, alpha = c * context->time_step;
    double const gamma = is_bdf2 ? c * alpha : alpha;
    for (size_t b = 0; b < context->scene.body_count; b++) {
        contact_body *const body = &context->scene.bodies[b];
        const rigid_body *const rigid = body->body;
        if (!body->is_free) continue;
        const world_obstacle *const obstacle = get_body(world, b);
        size_t const slot = get_first_slot(world, b);
        double const dampings[2] = {rigid->linear_damping, rigid->angular_damping};
        vec3 starts[2] = {vec3_load(context->scene.v0, slot),
                          vec3_load(context->scene.v0, slot + 1)};
        for (size_t i = 0; i < 2 && is_bdf2; i++) {
            vec3 const mean = vec3_load(dynamics->previous_mean, slot + i);
            vec3 const before = vec3_load(dynamics->previous_velocities, slot + i);
            starts[i] = vec3_add_scaled(vec3_scale(starts[i], c * (2.0 - c)), before, -c * d);
            starts[i] = vec3_add_scaled(starts[i], mean, d + alpha * d * dampings[i]);
        }
        vec3 const pull =
            vec3_add_scaled(context->scene.gravity, obstacle->given_force, 1.0 / rigid->mass);
        vec3 const spin = mat3_multiply_vec3(&body->inertia, starts[1]);
        body->momentum = vec3_scale(vec3_add_scaled(starts[0], pull, gamma), rigid->mass);
        body->spin = vec3_add_scaled(spin, obstacle->given_torque, gamma);
        body->mass_factor = 1.0 + alpha * dampings[0];
        body->inertia_factor = 1.0 + alpha * dampings[1];
        body->has_own_answers =
            body->drive || body->mass_factor != 1.0 || body->inertia_factor != 1.0;
        world_load_drive(context, b, gamma);
        update_body_answers(body);
    }
}

tulle_status world_prepare_bodies(step_context *context) {
    tulle_world *const world = context->world;
    const motion_state *const state = context->state;
    contact_scene *const scene = &context->scene;
    scene->body_count = world->model.body_count;
    scene->surface_bodies = world->model.surface_bodies;
    scene->bodies = ARENA_NEW(&world->work.scratch, contact_body, world->model.body_count);
    if (!scene->bodies) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t b = 0; b < world->model.body_count; b++) {
        const world_obstacle *const obstacle = get_body(world, b);
        size_t const slot = get_first_slot(world, b), begin = obstacle->vertex_begin;
        size_t const count = obstacle->mesh.vertex_count;
        quaternion const orientation = unpack_orientation(vec3_load(state->positions, slot + 1));
        bool const answers = body_answers(world, b);
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
        memcpy(world->work.targets + 3 * slot, state->positions + 3 * slot, 6 * sizeof(double));
        if (!answers) continue;
        memcpy(world->work.targets + 3 * begin, state->positions + 3 * begin,
               3 * count * sizeof(double));
        body->inertia = rigid_compute_inertia(&obstacle->rigid, orientation);
        if (body->is_free && !world_prepare_drive(context, b)) return TULLE_ERROR_OUT_OF_MEMORY;
        update_body_answers(body);
        body->start.velocity = vec3_load(state->velocities, slot);
    }
    world_load_bodies(context, 1.0);
    /* what drives do if nothing is in the way */
    start_bodies(scene, NULL, context->mean_velocity);
    (void)settle_drives(scene, NULL, 0, context->mean_velocity);
    /* the free turn in the step */
    for (size_t b = 0; b < world->model.body_count; b++) {
        contact_body *const body = &scene->bodies[b];
        if (!body->is_free) continue;
        vec3 const turn_rate =
            vec3_load(context->mean_velocity, (size_t)get_body_slot(scene, b) + 1);
        rigid_state end = body->start;
        bool const is_as_given = !body->drive && body->inertia_factor == 1.0;
        end.spin = is_as_given ? body->spin : mat3_multiply_vec3(&body->inertia, turn_rate);
        body->turn = mat3_identity(1.0);
        body->turn_vector = vec3_make(0.0, 0.0, 0.0);
        if (!drift_body(body, end.velocity, turn_rate, context->time_step, &end)) continue;
        body->turn_vector = vec3_scale(turn_rate, context->time_step);
        body->turn = quaternion_to_matrix(
            quaternion_multiply(end.orientation, quaternion_conjugate(body->start.orientation)));
    }
    return TULLE_OK;
}

/* Slots of a body that follows its script: places at the end of the substep, velocities into
 * `end`. */
static void follow_script(const step_context *context, size_t index, double *end) {
    const tulle_world *const world = context->world;
    const world_obstacle *const obstacle = get_body(world, index);
    size_t const slot = get_first_slot(world, index);
    double const from = context->state->time, to = from + context->passed;
    vec3 centre[2];
    quaternion orientation[2];
    compute_script_pose(obstacle, from, &centre[0], &orientation[0]);
    compute_script_pose(obstacle, to, &centre[1], &orientation[1]);
    vec3_store(context->end, slot, centre[1]);
    vec3_store(context->end, slot + 1, pack_orientation(orientation[1]));
    bool const moves = obstacle->motion.key_count > 0 && context->passed > 0.0;
    if (!moves) return;
    double const rate = 1.0 / context->passed;
    vec3_store(end, slot, vec3_scale(vec3_sub(centre[1], centre[0]), rate));
    /* a substep turns by less than half a turn */
    vec3_store(end, slot + 1,
               vec3_scale(quaternion_find_turn(orientation[0], orientation[1]), rate));
}

void world_finish_bodies(const step_context *context, double *end) {
    const contact_scene *const scene = &context->scene;
    double *const history[2] = {context->state->previous_mean, context->state->previous_velocities};
    context->state->lost_energy = context->lost_energy;
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b);
        if (!body->is_free) {
            memcpy(end + 3 * slot, scene->v0 + 3 * slot, 6 * sizeof(double));
            world_note_drive(context, b);
            if (context->state->rests[b].state != BODY_SLEEPS) follow_script(context, b, end);
            if (history[0]) memcpy(history[0] + 3 * slot, end + 3 * slot, 6 * sizeof(double));
            continue;
        }
        quaternion const orientation = unpack_orientation(vec3_load(context->end, slot + 1));
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
        world_note_drive(context, b);
        double const rate = context->passed > 0.0 ? 1.0 / context->passed : 0.0;
        for (size_t i = 3 * (size_t)body->vertex_begin; i < 3 * (size_t)body->vertex_end; i++)
            end[i] = rate * (context->end[i] - scene->x0[i]);
    }
}

body_energies world_measure_bodies(const tulle_world *world, const double *positions,
                                   const double *velocities) {
    body_energies energies = {0};
    vec3 const gravity = vec3_load(world->model.def.gravity, 0);
    for (size_t b = 0; b < world->model.body_count; b++) {
        if (!body_answers(world, b)) continue;
        const rigid_body *const rigid = &get_body(world, b)->rigid;
        size_t const slot = get_first_slot(world, b);
        quaternion const orientation = unpack_orientation(vec3_load(positions, slot + 1));
        vec3 const turn = vec3_load(velocities, slot + 1);
        energies.kinetic += 0.5 * rigid->mass * vec3_norm2(vec3_load(velocities, slot)) +
                            0.5 * vec3_dot(turn, rigid_compute_spin(rigid, orientation, turn));
        energies.gravity -= rigid->mass * vec3_dot(gravity, vec3_load(positions, slot));
    }
    return energies;
}
