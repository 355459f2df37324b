/* step/motion.c - scripted rigid motion: keyframes to positions.
 *
 * Takes keyframes (time, translation, rotation vector) and a time; gives the pose or moved points.
 * Between keys the translation is linear, and the rotation goes at constant speed about one axis,
 * both over the eased or plain fraction; outside the keys the nearest pose holds. Where both keys
 * turn about one axis, the way is the difference of their angles, of any size; else it is the
 * shorter way.
 * Based on: Shoemake, Animating rotation with quaternion curves, 1985 (spherical interpolation). */
#include "step/motion.h"

#include "base/error.h"
#include "math/quaternion.h"

#include <math.h>
#include <string.h>

/* Two axes are one when the sine between them is at most this: a rounded axis, turned with a copy.
 */
static const double SAME_AXIS_SINE = 1e-12;
/* [rad] An angle up to this has its place in a turn to 1e-10. */
static const double ANGLE_MAX = 1e6;

static tulle_status validate_key(const tulle_motion *motion, size_t i, const char *owner,
                                 tulle_error *error) {
    const tulle_keyframe *const key = &motion->keys[i];
    double const angle = vec3_norm(vec3_load(key->rotation_vector, 0));
    double const sum =
        key->time + key->translation[0] + key->translation[1] + key->translation[2] + angle;
    if (!isfinite(sum)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: keyframe %zu holds a value that is not finite", owner, i);
    }
    if (angle > ANGLE_MAX) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: keyframe %zu turns by %g rad, must be at most %g", owner, i, angle,
                         ANGLE_MAX);
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
    for (size_t i = 0; i < target->key_count; i++) {
        const tulle_keyframe *const from = &source->keys[i];
        motion_key *const key = &target->keys[i];
        vec3 const vector = vec3_load(from->rotation_vector, 0);
        key->time = from->time;
        key->translation = vec3_load(from->translation, 0);
        key->rotation = quaternion_from_vector(vector);
        if (i == 0) continue;
        vec3 const before = vec3_load(from[-1].rotation_vector, 0);
        bool const is_same_axis = vec3_norm(vec3_cross(before, vector)) <=
                                  SAME_AXIS_SINE * vec3_norm(before) * vec3_norm(vector);
        key->turn = is_same_axis ? vec3_sub(vector, before)
                                 : quaternion_find_turn(key[-1].rotation, key->rotation);
        key->turned = key[-1].turned + vec3_norm(key->turn);
    }
    return TULLE_OK;
}

void motion_destroy(memory *heap, world_motion *motion) {
    memory_release(heap, motion->keys, motion->key_count * sizeof *motion->keys);
    motion->keys = NULL;
    motion->key_count = 0;
}

motion_pose motion_compute_pose(const world_motion *motion, double time, double *turned) {
    size_t const count = motion->key_count;
    if (turned) *turned = 0.0;
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
    const motion_key *const from = &motion->keys[next > 0 ? next - 1 : 0];
    if (turned) *turned = from->turned;
    if (next == 0 || next == count) return (motion_pose){from->translation, from->rotation};

    const motion_key *const to = from + 1;
    double s = (time - from->time) / (to->time - from->time);
    if (motion->is_eased) s = s * s * (3.0 - 2.0 * s);
    if (turned) *turned += s * (to->turned - from->turned);
    quaternion const turn = quaternion_from_vector(vec3_scale(to->turn, s));
    return (motion_pose){vec3_lerp(from->translation, to->translation, s),
                         quaternion_normalize(quaternion_multiply(turn, from->rotation))};
}

void motion_apply(const world_motion *motion, double time, const double *source, size_t count,
                  double *target) {
    if (motion->key_count == 0) {
        if (target != source) memcpy(target, source, 3 * count * sizeof(double));
        return;
    }
    motion_pose const pose = motion_compute_pose(motion, time, NULL);
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
    motion_pose const start = motion_compute_pose(motion, from, NULL);
    motion_pose const end = motion_compute_pose(motion, to, NULL);
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
