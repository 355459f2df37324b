/* world/bodies/body_access.c - what users read of rigid bodies, and impulses that they give. */
#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_sleep.h"

#include <math.h>
#include <string.h>

/* Number of the body, or TULLE_NONE with an error. */
static uint32_t find_body_number(const tulle_world *world, tulle_obstacle_id id,
                                 tulle_error *error) {
    bool const is_valid = world && id.generation == 1 && id.index < world->obstacles.count;
    if (!is_valid || !world->obstacles.data[id.index].body.is_dynamic) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  is_valid ? "the obstacle is no body" : "the world has no such obstacle");
        return TULLE_NONE;
    }
    if (!world->is_started) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "bodies can be asked and pushed once the world has started");
        return TULLE_NONE;
    }
    return world->surface_bodies[world->cloths.count + id.index];
}

static quaternion get_orientation(const tulle_world *world, size_t slot) {
    return unpack_orientation(vec3_load(world->now.positions, slot + 1));
}

tulle_status tulle_obstacle_get_transform(const tulle_world *world, tulle_obstacle_id id,
                                          tulle_transform *transform, tulle_error *error) {
    if (!transform) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for it");
    uint32_t const body = find_body_number(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const world_obstacle *const obstacle = &world->obstacles.data[id.index];
    size_t const slot = world->cloth_vertex_count + 2 * (size_t)body;
    quaternion const now = get_orientation(world, slot);
    quaternion const turn =
        quaternion_normalize(quaternion_multiply(now, quaternion_conjugate(obstacle->axes)));
    double const rotation[4] = {turn.w, turn.x, turn.y, turn.z};
    mat3 const inertia = rigid_compute_inertia(&obstacle->rigid, now);
    vec3_store(transform->position, 0, vec3_load(world->now.positions, slot));
    memcpy(transform->rotation, rotation, sizeof rotation);
    vec3_store(transform->velocity, 0, vec3_load(world->now.velocities, slot));
    vec3_store(transform->angular_velocity, 0, vec3_load(world->now.velocities, slot + 1));
    vec3_store(transform->centre, 0, obstacle->centre);
    transform->mass = obstacle->rigid.mass;
    memcpy(transform->inertia, &inertia, sizeof transform->inertia);
    return TULLE_OK;
}

tulle_status tulle_obstacle_add_impulse(tulle_world *world, tulle_obstacle_id id,
                                        const double point[3], const double impulse[3],
                                        tulle_error *error) {
    if (!point || !impulse)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the point or the impulse is null");
    uint32_t const body = find_body_number(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const surface_range *const range = &world->surfaces[world->cloths.count + id.index];
    vec3 const at = vec3_load(point, 0), push = vec3_load(impulse, 0);
    if (!isfinite(at.x + at.y + at.z) || !isfinite(push.x + push.y + push.z))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the impulse is not finite");
    if (!range->is_body || !world->now.is_present[id.index]) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "'%s' follows its script or is absent: it takes no impulse",
                         world->obstacles.data[id.index].name);
    }
    world_wake_body(world, &world->now, body);
    const rigid_body *const rigid = &world->obstacles.data[id.index].rigid;
    size_t const slot = world->cloth_vertex_count + 2 * (size_t)body;
    double *const velocities = world->now.velocities;
    mat3 const inverse = rigid_compute_inverse_inertia(rigid, get_orientation(world, slot));
    vec3 const arm = vec3_sub(at, vec3_load(world->now.positions, slot));
    vec3_store(velocities, slot,
               vec3_add_scaled(vec3_load(velocities, slot), push, 1.0 / rigid->mass));
    vec3_store(velocities, slot + 1,
               vec3_add(vec3_load(velocities, slot + 1),
                        mat3_multiply_vec3(&inverse, vec3_cross(arm, push))));
    return TULLE_OK;
}

void world_sum_contact_impulses(const row_list *rows, size_t slot, double impulse[3],
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

tulle_status tulle_obstacle_get_contact_impulse(const tulle_world *world, tulle_obstacle_id id,
                                                double impulse[3], double angular_impulse[3],
                                                tulle_error *error) {
    if (!impulse || !angular_impulse)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for the impulses");
    uint32_t const body = find_body_number(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    size_t const slot = world->cloth_vertex_count + 2 * (size_t)body;
    const body_rest *const rest = &world->now.rests[body];
    if (rest->state == BODY_SLEEPS) {
        memcpy(impulse, rest->impulse, sizeof rest->impulse);
        memcpy(angular_impulse, rest->moment, sizeof rest->moment);
    } else {
        world_sum_contact_impulses(&world->accepted_rows, slot, impulse, angular_impulse);
    }
    return TULLE_OK;
}

int tulle_obstacle_is_asleep(const tulle_world *world, tulle_obstacle_id id) {
    if (!world || !world->is_started) return 0;
    uint32_t const body = find_body_number(world, id, NULL);
    return body != TULLE_NONE && world->now.rests[body].state == BODY_SLEEPS;
}

tulle_status tulle_obstacle_wake(tulle_world *world, tulle_obstacle_id id, tulle_error *error) {
    uint32_t const body = find_body_number(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    world_wake_body(world, &world->now, body);
    return TULLE_OK;
}
