/* world/bodies/body_access.c - what users read of rigid bodies, and impulses that they give. */
#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "contact/solve/body_drives.h"
#include "geom/distance.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "world/record/record.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

uint32_t world_find_body(const tulle_world *world, tulle_obstacle_id id, tulle_error *error) {
    size_t const index = world_find_obstacle(world, id);
    bool const is_valid = index != SIZE_MAX;
    if (!is_valid || !world->model.obstacles.data[index].body.is_dynamic) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  is_valid ? "the obstacle is not a rigid body" : "the world has no such obstacle");
        return TULLE_NONE;
    }
    if (!world->is_started) {
        error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                  "bodies can be asked and pushed once the world has started");
        return TULLE_NONE;
    }
    return world->model.surface_bodies[world->model.cloths.count + index];
}

static quaternion get_orientation(const tulle_world *world, size_t slot) {
    return unpack_orientation(vec3_load(world->now.positions, slot + 1));
}

tulle_status tulle_obstacle_get_transform(const tulle_world *world, tulle_obstacle_id id,
                                          tulle_transform *transform, tulle_error *error) {
    if (!transform) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for it");
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    const world_obstacle *const obstacle = get_body(&world->model, body);
    size_t const slot = world->model.cloth_vertex_count + 2 * (size_t)body;
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
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    vec3 const at = vec3_load(point, 0), push = vec3_load(impulse, 0);
    if (!isfinite(at.x + at.y + at.z) || !isfinite(push.x + push.y + push.z))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the impulse is not finite");
    if (!get_body_surface(&world->model, &world->work, body)->is_body ||
        !world->now.is_present[world->model.body_obstacles[body]]) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "'%s' follows its script or is absent: it takes no impulse",
                         get_body(&world->model, body)->name);
    }
    step_wake_body(&world->model, &world->now, body);
    const rigid_body *const rigid = &get_body(&world->model, body)->rigid;
    size_t const slot = world->model.cloth_vertex_count + 2 * (size_t)body;
    double velocities[BODY_AXES];
    memcpy(velocities, world->now.velocities + 3 * slot, sizeof velocities);
    mat3 inverse = rigid_compute_inverse_inertia(rigid, get_orientation(world, slot));
    uint32_t const locks = world->model.controls[body].locks >> 3; /* of the turn */
    if (locks != 0) {
        mat3 const inertia = rigid_compute_inertia(rigid, get_orientation(world, slot));
        bool const is_locked[3] = {locks & 1u, locks & 2u, locks & 4u};
        inverse = compute_free_inverse(&inertia, is_locked);
    }
    vec3 const arm = vec3_sub(at, vec3_load(world->now.positions, slot));
    vec3_store(velocities, 0, vec3_add_scaled(vec3_load(velocities, 0), push, 1.0 / rigid->mass));
    vec3_store(
        velocities, 1,
        vec3_add(vec3_load(velocities, 1), mat3_multiply_vec3(&inverse, vec3_cross(arm, push))));
    world_set_body_velocity(world, body, velocities);
    WORLD_RECORD(world, .kind = RECORD_IMPULSE, RECORD_ID(id),
                 .arrays = {{point, 3}, {impulse, 3}});
    return TULLE_OK;
}

/* Impulses [N s] on a surface, and their moments [N m s] about a point. */
typedef struct impulse_sum {
    size_t surface;
    vec3 about, impulse, moment;
} impulse_sum;

/* Adds what the contact of a row's frame gives the surface where one side of it lies there: the
 * opposite of what it gives the other side, at the point of that. */
static void add_contact(const tulle_world *world, const row_frame *frame, vec3 impulse,
                        impulse_sum *sum) {
    int const first_count = frame->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    for (int side = 0; side < 2; side++) {
        int const own = side == 0 ? 0 : first_count;
        int const begin = side == 0 ? first_count : 0, end = side == 0 ? 4 : first_count;
        if (world->model.vertex_surface[frame->vertices[own]] != sum->surface) continue;
        vec3 point = {0.0, 0.0, 0.0};
        for (int k = begin; k < end; k++)
            point = vec3_add_scaled(point, vec3_load(world->now.positions, frame->vertices[k]),
                                    fabs(frame->weights[k]));
        vec3 const given = vec3_scale(impulse, side == 0 ? 1.0 : -1.0);
        sum->impulse = vec3_add(sum->impulse, given);
        sum->moment = vec3_add(sum->moment, vec3_cross(vec3_sub(point, sum->about), given));
    }
}

/* Whether an accepted row holds these two surfaces apart. */
static bool has_row(const tulle_world *world, size_t a, size_t b) {
    for (size_t i = 0; i < world->accepted_rows.rows.count; i++) {
        const row_frame *const frame = &world->accepted_rows.rows.data[i].frame;
        size_t const first = world->model.vertex_surface[frame->vertices[0]];
        size_t const second = world->model.vertex_surface[frame->vertices[3]];
        if ((first == a && second == b) || (first == b && second == a)) return true;
    }
    return false;
}

/* Whether a surface slept through the last step: then its contacts with `other`, which stands, are
 * in the store alone. */
static bool has_slept(const tulle_world *world, size_t surface, size_t other) {
    bool is_asleep =
        surface < world->model.cloth_rest_count && world->now.cloth_rests[surface].is_asleep;
    uint32_t const body =
        world->model.surface_bodies ? world->model.surface_bodies[surface] : TULLE_NONE;
    if (body != TULLE_NONE) is_asleep = world->now.rests[body].state == BODY_SLEEPS;
    return is_asleep && !has_row(world, surface, other);
}

/* Adds what the store has of the contacts of a sleeper with the surface of the sum. */
static void add_stored(const tulle_world *world, size_t sleeper, impulse_sum *sum) {
    const contact_store *const store = &world->now.contacts;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        row_frame frame = {.kind = (feature_kind)contact->kind};
        feature_pair_vertices(&world->model.topo, frame.kind,
                              (feature_pair){contact->first, contact->second}, frame.vertices);
        size_t const first = world->model.vertex_surface[frame.vertices[0]];
        size_t const second = world->model.vertex_surface[frame.vertices[3]];
        bool const is_meant = (first == sum->surface && second == sleeper) ||
                              (second == sum->surface && first == sleeper);
        if (!is_meant) continue;
        vec3 points[4];
        for (int k = 0; k < 4; k++) points[k] = vec3_load(world->now.positions, frame.vertices[k]);
        closest_points const closest = closest_of_pair(frame.kind, points);
        memcpy(frame.weights, closest.weights, sizeof frame.weights);
        add_contact(world, &frame, vec3_load(contact->impulse, 0), sum);
    }
}

/* The sum for what follows a script or stands. */
static void sum_scripted_impulses(const tulle_world *world, impulse_sum *sum) {
    for (size_t i = 0; i < world->accepted_rows.rows.count; i++) {
        const contact_row *const row = &world->accepted_rows.rows.data[i];
        add_contact(world, &row->frame, row->solve.impulse, sum);
    }
    for (size_t s = 0; world->model.has_sleep && s < world->model.surface_count; s++)
        if (has_slept(world, s, sum->surface)) add_stored(world, s, sum);
}

tulle_status tulle_obstacle_get_contact_impulse(const tulle_world *world, tulle_obstacle_id id,
                                                double impulse[3], double angular_impulse[3],
                                                tulle_error *error) {
    if (!impulse || !angular_impulse)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no place for the impulses");
    size_t const index = world_find_obstacle(world, id);
    bool const is_valid = index != SIZE_MAX;
    if (!is_valid || !world->is_started)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         is_valid ? "the world has not started: nothing touches anything yet"
                                  : "the world has no such obstacle");
    size_t const surface = world->model.cloths.count + index;
    uint32_t const body =
        world->model.surface_bodies ? world->model.surface_bodies[surface] : TULLE_NONE;
    uint32_t const state = body == TULLE_NONE ? BODY_SCRIPTED : world->now.rests[body].state;
    impulse_sum sum = {.surface = surface};
    if (body != TULLE_NONE)
        sum.about = vec3_load(world->now.positions, get_first_slot(&world->model, body));
    if (state == BODY_SLEEPS) {
        memcpy(impulse, world->now.rests[body].impulse, 3 * sizeof(double));
        memcpy(angular_impulse, world->now.rests[body].moment, 3 * sizeof(double));
    } else if (state == BODY_FREE) {
        step_sum_contact_impulses(&world->accepted_rows, get_first_slot(&world->model, body),
                                  impulse, angular_impulse);
    } else {
        sum_scripted_impulses(world, &sum);
        vec3_store(impulse, 0, sum.impulse);
        vec3_store(angular_impulse, 0, sum.moment);
    }
    return TULLE_OK;
}

int tulle_obstacle_is_asleep(const tulle_world *world, tulle_obstacle_id id) {
    if (!world || !world->is_started) return 0;
    uint32_t const body = world_find_body(world, id, NULL);
    return body != TULLE_NONE && world->now.rests[body].state == BODY_SLEEPS;
}

tulle_status tulle_obstacle_wake(tulle_world *world, tulle_obstacle_id id, tulle_error *error) {
    uint32_t const body = world_find_body(world, id, error);
    if (body == TULLE_NONE) return TULLE_ERROR_INVALID_ARGUMENT;
    step_wake_body(&world->model, &world->now, body);
    WORLD_RECORD(world, .kind = RECORD_WAKE, RECORD_ID(id));
    return TULLE_OK;
}
