/* world/start/start_bodies.c - rigid bodies at the start: mass and inertia, numbers, the slots of
 * the first state. */
#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "geom/mass_properties.h"
#include "step/bodies/bodies.h"
#include "world/start/start.h"

#include <math.h>
#include <string.h>

tulle_status world_make_body(tulle_world *world, world_obstacle *obstacle, tulle_error *error) {
    const tulle_body *const def = &obstacle->body;
    if (!def->is_dynamic) return TULLE_OK;
    if (!contact_responses[world->model.paper.response]->moves_bodies) {
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
                 surface_count = world->model.surface_count;
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
        world->model.has_sleep |= get_body(&world->model, b)->body.sleep_speed > 0.0;
    return TULLE_OK;
}

void world_place_bodies(tulle_world *world, const tulle_transform *transforms) {
    motion_state *const state = &world->now;
    (void)step_free_bodies(&world->model, state);
    step_mark_bodies(&world->model, state, &world->work);
    for (size_t b = 0; b < world->model.body_count; b++) {
        const world_obstacle *const obstacle = get_body(&world->model, b);
        size_t const slot = get_first_slot(&world->model, b);
        vec3 velocity = vec3_load(obstacle->body.velocity, 0);
        vec3 spin = vec3_load(obstacle->body.angular_velocity, 0);
        vec3 centre;
        quaternion orientation;
        step_compute_script_pose(obstacle, state->time, &centre, &orientation);
        if (transforms && body_answers(&world->model, &world->work, b)) {
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
