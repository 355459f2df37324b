/* world/motion.c - scripted rigid motion: keyframes to positions.
 *
 * Takes keyframes (time, translation, unit quaternion) and a time; gives the pose or moved points.
 * Between keys the translation is linear and the rotation spherical-linear, both over the eased or
 * plain fraction; outside the keys the nearest pose holds.
 * Based on: Shoemake, Animating rotation with quaternion curves, 1985 (spherical interpolation). */
#include "world/motion.h"

#include "base/error.h"
#include "math/quaternion.h"

#include <math.h>
#include <string.h>

/* Under this sine of the angle between two rotations the linear blend is exact to rounding. */
static const double SLERP_LINEAR_SINE = 1e-8;

static tulle_status validate_key(const tulle_motion *motion, size_t i, const char *owner,
                                 tulle_error *error) {
    const tulle_keyframe *const key = &motion->keys[i];
    double const norm = quaternion_norm(quaternion_load(key->rotation));
    double const sum =
        key->time + key->translation[0] + key->translation[1] + key->translation[2] + norm;
    if (!isfinite(sum)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: keyframe %zu holds a value that is not finite", owner, i);
    }
    if (fabs(norm - 1.0) > QUATERNION_TOLERANCE) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the rotation of keyframe %zu has length %g; give a unit quaternion",
                         owner, i, norm);
    }
    if (i > 0 && !(key->time > motion->keys[i - 1].time)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: keyframe %zu at %g s must come after the one before it at %g s",
                         owner, i, key->time, motion->keys[i - 1].time);
    }
    return TULLE_OK;
}

tulle_status motion_validate(const tulle_motion *motion, const char *owner, tulle_error *error) {
    if (motion->key_count > 0 && !motion->keys)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: its motion has %zu keyframes, but their array is null", owner,
                         motion->key_count);
    for (size_t i = 0; i < motion->key_count; i++) {
        tulle_status const status = validate_key(motion, i, owner, error);
        if (status != TULLE_OK) return status;
    }
    if (!isfinite(motion->pivot[0] + motion->pivot[1] + motion->pivot[2])) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: the pivot of its motion is not finite", owner);
    }
    return TULLE_OK;
}

tulle_status motion_copy(memory *heap, const tulle_motion *source, world_motion *target) {
    memset(target, 0, sizeof *target);
    memcpy(target->pivot, source->pivot, sizeof target->pivot);
    target->is_eased = source->is_eased;
    if (source->key_count == 0) return TULLE_OK;
    target->keys = memory_allocate_zeroed(heap, source->key_count, sizeof *target->keys);
    if (!target->keys) return TULLE_ERROR_OUT_OF_MEMORY;
    target->key_count = source->key_count;
    memcpy(target->keys, source->keys, source->key_count * sizeof *target->keys);
    for (size_t i = 0; i < target->key_count; i++) {
        double const norm = quaternion_norm(quaternion_load(target->keys[i].rotation));
        for (int c = 0; c < 4; c++) target->keys[i].rotation[c] /= norm;
    }
    return TULLE_OK;
}

void motion_destroy(memory *heap, world_motion *motion) {
    memory_release(heap, motion->keys, motion->key_count * sizeof *motion->keys);
    motion->keys = NULL;
    motion->key_count = 0;
}

/* Spherical interpolation from a to b along the shorter arc. */
static quaternion slerp(quaternion a, quaternion b, double s) {
    double const signed_dot = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
    double const sign = signed_dot < 0.0 ? -1.0 : 1.0;
    double const dot = fmin(signed_dot * sign, 1.0);
    double const sine = sqrt(fmax(0.0, 1.0 - dot * dot));
    double weight_a = 1.0 - s, weight_b = s;
    if (sine > SLERP_LINEAR_SINE) {
        double const angle = atan2(sine, dot);
        weight_a = sin((1.0 - s) * angle) / sine;
        weight_b = sin(s * angle) / sine;
    }
    weight_b = sign * weight_b;
    return quaternion_normalize(
        (quaternion){weight_a * a.w + weight_b * b.w, weight_a * a.x + weight_b * b.x,
                     weight_a * a.y + weight_b * b.y, weight_a * a.z + weight_b * b.z});
}

motion_pose motion_compute_pose(const world_motion *motion, double time) {
    size_t const count = motion->key_count;
    if (count == 0) return (motion_pose){.rotation = {.w = 1.0}};

    /* the first key after `time`; outside the keys the nearest pose holds */
    size_t next = 0, past = count;
    while (next < past) {
        size_t const middle = next + (past - next) / 2;
        if (motion->keys[middle].time <= time)
            next = middle + 1;
        else
            past = middle;
    }
    const tulle_keyframe *const to = &motion->keys[next < count ? next : count - 1];
    motion_pose const end = {vec3_load(to->translation, 0), quaternion_load(to->rotation)};
    if (next == 0 || next == count) return end;

    const tulle_keyframe *const from = &motion->keys[next - 1];
    double s = (time - from->time) / (to->time - from->time);
    if (motion->is_eased) s = s * s * (3.0 - 2.0 * s);
    return (motion_pose){vec3_lerp(vec3_load(from->translation, 0), end.translation, s),
                         slerp(quaternion_load(from->rotation), end.rotation, s)};
}

void motion_apply(const world_motion *motion, double time, const double *source, size_t count,
                  double *target) {
    if (motion->key_count == 0) {
        if (target != source) memcpy(target, source, 3 * count * sizeof(double));
        return;
    }
    motion_pose const pose = motion_compute_pose(motion, time);
    mat3 const r = quaternion_to_matrix(pose.rotation);
    vec3 const pivot = vec3_load(motion->pivot, 0);
    vec3 const shift = vec3_add(pose.translation, pivot);
    for (size_t i = 0; i < count; i++) {
        vec3 const arm = vec3_sub(vec3_load(source, i), pivot);
        vec3_store(target, i, vec3_add(mat3_multiply_vec3(&r, arm), shift));
    }
}

void motion_compute_change(const world_motion *motion, double from, double to, mat3 *matrix,
                           vec3 *offset) {
    motion_pose const start = motion_compute_pose(motion, from);
    motion_pose const end = motion_compute_pose(motion, to);
    mat3 const r0 = quaternion_to_matrix(start.rotation), r1 = quaternion_to_matrix(end.rotation);
    /* R1 R0^T, and the offset that takes pivot + t0 to pivot + t1 */
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++) {
            double sum = 0.0;
            for (int k = 0; k < 3; k++) sum += r1.m[3 * row + k] * r0.m[3 * column + k];
            matrix->m[3 * row + column] = sum;
        }
    }
    vec3 const pivot = vec3_load(motion->pivot, 0);
    vec3 const centre = vec3_add(pivot, start.translation);
    *offset = vec3_sub(vec3_add(pivot, end.translation), mat3_multiply_vec3(matrix, centre));
}
