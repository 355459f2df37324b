/* step/carriers.c - the affine map by which each scripted obstacle goes through a substep,
 * for the rescue that lets cloth ride on moving obstacles.
 *
 * A step begins with obstacles on their script. Vertices move on straight lines to where the script
 * has them at the end of the substep; when time is shortened on the way they stop on their chords,
 * where a turning obstacle is a little smaller than itself. So the map of a substep is not the
 * script's alone: from the start of the step to now the obstacle has gone through P, to the end of
 * the substep it goes through the script's S, and the substep's map is S P^-1. */
#include "step/carriers.h"

#include "step/step_work.h"

#include <math.h>
#include <string.h>

/* A map that misses a vertex's target by more than this share of the minimum gap is not used. It
 * misses when a pinch has held the obstacle back. */
static const double CARRIER_ERROR_SHARE = 1e-3;
/* An obstacle whose chords leave less than this share of its volume has no map. It has turned by
 * over a right angle in one substep. */
static const double VOLUME_LEFT_MIN = 0.1;

static const affine_map IDENTITY = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}}, {0, 0, 0}};

tulle_status step_begin_carriers(const step_model *model, step_work *work) {
    size_t const count = model->obstacles.count;
    work->carriers.progress = ARENA_NEW(&work->scratch, affine_map, count);
    work->carriers.script = ARENA_NEW(&work->scratch, affine_map, count);
    if (!work->carriers.progress || !work->carriers.script) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < count; i++)
        work->carriers.progress[i] = work->carriers.script[i] = IDENTITY;
    return TULLE_OK;
}

/* map = whole part^-1; false where `part` leaves too little. */
static bool divide_maps(const affine_map *whole, const affine_map *part, affine_map *map) {
    const double *const p = part->matrix.m, *const w = whole->matrix.m;
    vec3 const a = {p[0], p[3], p[6]}, b = {p[1], p[4], p[7]}, c = {p[2], p[5], p[8]};
    double const volume = vec3_dot(a, vec3_cross(b, c));
    if (!(volume >= VOLUME_LEFT_MIN)) return false;
    mat3 sum = mat3_outer((vec3){w[0], w[3], w[6]}, vec3_cross(b, c), 1.0 / volume);
    mat3 const second = mat3_outer((vec3){w[1], w[4], w[7]}, vec3_cross(c, a), 1.0 / volume);
    mat3 const third = mat3_outer((vec3){w[2], w[5], w[8]}, vec3_cross(a, b), 1.0 / volume);
    mat3_add_scaled(&sum, &second, 1.0);
    mat3_add_scaled(&sum, &third, 1.0);
    map->matrix = sum;
    map->offset = vec3_sub(whole->offset, mat3_multiply_vec3(&sum, part->offset));
    return true;
}

void step_compute_carriers(const step_model *model, motion_state *state, step_work *work) {
    double const to = state->time + work->sub.time_step;
    memset(work->carriers.used, 0, model->surface_count * sizeof *work->carriers.used);
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const world_motion *const motion = &model->obstacles.data[i].motion;
        if (motion->key_count == 0) continue;
        size_t const surface = model->cloths.count + i;
        affine_map *const map = &work->carriers.maps[surface];
        affine_map *const script = &work->carriers.script[i];
        motion_compute_change(motion, work->start->time, to, &script->matrix, &script->offset);
        bool fits = divide_maps(script, &work->carriers.progress[i], map);
        const surface_range *const range = &work->surfaces[surface];
        for (uint32_t v = range->vertex_begin; fits && v < range->vertex_end; v++) {
            vec3 const moved = vec3_add(
                mat3_multiply_vec3(&map->matrix, vec3_load(state->positions, v)), map->offset);
            vec3 const error = vec3_sub(moved, vec3_load(work->targets, v));
            fits = vec3_norm(error) <= CARRIER_ERROR_SHARE * model->minimum_gap;
        }
        if (fits) work->carriers.used[surface] = map;
    }
}

void step_follow_carriers(const step_model *model, step_work *work) {
    double const share = work->sub.passed / work->sub.time_step;
    for (size_t i = 0; i < model->obstacles.count; i++) {
        affine_map *const map = &work->carriers.progress[i], *const whole =
                                                                 &work->carriers.script[i];
        for (size_t k = 0; k < 9; k++)
            map->matrix.m[k] += share * (whole->matrix.m[k] - map->matrix.m[k]);
        map->offset = vec3_lerp(map->offset, whole->offset, share);
    }
}
