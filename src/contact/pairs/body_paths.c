/* contact/pairs/body_paths.c - see body_paths.h.
 *
 * Impulses of a step act at its start: u holds the velocity and the angular velocity w after them,
 * and the spin is I w with the inertia at x0. From there the body moves freely, so a body that
 * nothing touches keeps its spin and energy but for rounding. */
#include "contact/pairs/body_paths.h"

#include <math.h>
#include <string.h>

vec3 pack_orientation(quaternion q) {
    double const sign = q.w < 0.0 ? -1.0 : 1.0, scale = sign / (1.0 + fabs(q.w));
    return vec3_make(scale * q.x, scale * q.y, scale * q.z);
}

quaternion unpack_orientation(vec3 p) {
    double const square = vec3_norm2(p), scale = 2.0 / (1.0 + square);
    return (quaternion){(1.0 - square) / (1.0 + square), scale * p.x, scale * p.y, scale * p.z};
}

bool drift_body(const contact_body *body, vec3 velocity, vec3 turn_rate, double time,
                rigid_state *state) {
    const body_drive *const drive = body->drive;
    if (!drive || !(drive->is_locked[3] || drive->is_locked[4] || drive->is_locked[5]))
        return rigid_drift(body->body, velocity, time, state);
    rigid_body even = *body->body; /* turns evenly */
    even.moments = vec3_make(1.0, 1.0, 1.0);
    state->spin = turn_rate;
    return rigid_drift(&even, velocity, time, state);
}

void place_bodies(const contact_scene *scene, const double *u, double share, double *x1) {
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b), begin = body->vertex_begin;
        size_t const count = body->vertex_end - begin;
        if (!body->is_free) {
            memcpy(x1 + 3 * slot, scene->x0 + 3 * slot, 6 * sizeof(double));
            continue;
        }
        rigid_state state = body->start;
        vec3 const turn_rate = vec3_load(u, slot + 1);
        state.spin = mat3_multiply_vec3(&body->inertia, turn_rate);
        vec3 const velocity = vec3_load(u, slot);
        if (!drift_body(body, velocity, turn_rate, share * scene->time_step, &state)) {
            for (size_t i = 0; i < 6; i++) x1[3 * slot + i] = NAN;
            for (size_t i = 0; i < 3 * count; i++) x1[3 * begin + i] = NAN;
            continue;
        }
        vec3_store(x1, slot, state.position);
        vec3_store(x1, slot + 1, pack_orientation(state.orientation));
        /* what stands still keeps its bits */
        bool const stands = body->drive && vec3_norm2(turn_rate) == 0.0;
        if (stands) memcpy(x1 + 3 * (slot + 1), scene->x0 + 3 * (slot + 1), 3 * sizeof(double));
        if (stands && vec3_norm2(velocity) == 0.0)
            memcpy(x1 + 3 * begin, scene->x0 + 3 * begin, 3 * count * sizeof(double));
        else
            rigid_place(&state, body->points, count, x1 + 3 * begin);
    }
}
