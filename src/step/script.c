/* step/script.c - scripted and given motion: where obstacles and pinned vertices go.
 *
 * Takes the defs, what the host gave and a time; gives `targets`, the positions that scripted
 * vertices reach at that time, the mask of pinned vertices and inverse masses that are zero for
 * them. Poses are made from the defs' own positions each time, so nothing drifts. The rescue gets
 * the affine maps by which scripted obstacles go. */
#include "step/script.h"

#include "base/error.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Makes sure that frame `number` is in one of the two cached slots; *slot says which. `keep` is
 * the slot that must not be overwritten, or -1. */
static tulle_status load_frame(const step_model *model, step_work *work, size_t index,
                               uint32_t number, int keep, int *slot) {
    const world_obstacle *const obstacle = &model->obstacles.data[index];
    frame_cache *const frames = obstacle->frames;
    for (int i = 0; i < 2; i++) {
        if (frames->numbers[i] == number) {
            *slot = i;
            return TULLE_OK;
        }
    }
    *slot = keep == 0 ? 1 : 0;
    frames->numbers[*slot] = TULLE_NONE;
    double *const frame = frames->positions[*slot];
    tulle_status const status =
        obstacle->read_frame(obstacle->frame_context, number, frame, work->error);
    if (work->frames.tell)
        work->frames.tell(work->frames.context, index, number, status == TULLE_OK ? frame : NULL,
                          status);
    if (status != TULLE_OK) work->failure = (step_finding){.kind = FINDING_FRAME};
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < 3 * obstacle->mesh.vertex_count; i++) {
        if (!isfinite(frame[i])) {
            work->failure = (step_finding){.kind = FINDING_FRAME};
            return error_set(work->error, TULLE_ERROR_INVALID_MESH,
                             "%s: vertex %zu of frame %u is not finite", obstacle->name, i / 3,
                             number);
        }
    }
    frames->numbers[*slot] = number;
    return TULLE_OK;
}

/* Positions of a mesh sequence at `time`, linear between its frames, still outside them. */
static tulle_status sample_sequence(const step_model *model, step_work *work, size_t index,
                                    double time, double *target) {
    const world_obstacle *const obstacle = &model->obstacles.data[index];
    double const last = (double)(obstacle->frame_count - 1);
    double const position = (time - obstacle->frame_start_time) / obstacle->frame_interval;
    /* What is off a frame only by the rounding that the sum of the steps has gathered is that
     * frame. A live reader may not have the next one yet. */
    double const whole = round(position),
                 share = (double)(work->start->step_count + 8) * DBL_EPSILON;
    double const rounding = share * (fabs(time) / obstacle->frame_interval + fabs(position));
    bool const is_whole = fabs(position - whole) <= rounding;
    double const clamped = fmin(fmax(is_whole ? whole : position, 0.0), last);
    uint32_t const from = (uint32_t)clamped;
    double const fraction = clamped - (double)from;
    int slot_from, slot_to;
    tulle_status status = load_frame(model, work, index, from, -1, &slot_from);
    if (status != TULLE_OK) return status;
    if (fraction == 0.0) {
        memcpy(target, obstacle->frames->positions[slot_from],
               3 * obstacle->mesh.vertex_count * sizeof(double));
        return TULLE_OK;
    }
    status = load_frame(model, work, index, from + 1, slot_from, &slot_to);
    if (status != TULLE_OK) return status;
    const double *const a = obstacle->frames->positions[slot_from], *const b =
                                                                        obstacle->frames
                                                                            ->positions[slot_to];
    for (size_t i = 0; i < 3 * obstacle->mesh.vertex_count; i++) {
        target[i] = a[i] + fraction * (b[i] - a[i]);
    }
    return TULLE_OK;
}

/* Part of the way of `count` numbers. All of it leads to `to` without rounding. */
static void go_towards(const double *from, const double *to, double share, size_t count,
                       double *target) {
    for (size_t i = 0; i < count; i++)
        target[i] = share < 1.0 ? from[i] + share * (to[i] - from[i]) : to[i];
}

tulle_status step_place_obstacle(const step_model *model, step_work *work, size_t index,
                                 double *positions, tulle_error *error) {
    work->error = error;
    const world_obstacle *const obstacle = &model->obstacles.data[index];
    double const time = work->start->time;
    if (obstacle->read_frame) return sample_sequence(model, work, index, time, positions);
    motion_apply(&obstacle->motion, time, obstacle->mesh.positions, obstacle->mesh.vertex_count,
                 positions);
    return TULLE_OK;
}

tulle_status step_script_targets(const step_model *model, step_work *work, double time,
                                 double end_time, tulle_error *error) {
    work->error = error;
    double const length =
        work->step_end - work->start->time; /* of the step that runs, or the last */
    double const share = length > 0.0 ? (end_time - work->start->time) / length : 0.0;
    memset(work->is_fixed, 0, model->cloth_vertex_count);
    memcpy(work->active_inverse_masses, model->inverse_masses,
           model->vertex_count * sizeof(double));
    for (size_t i = 0; i < model->cloths.count; i++) {
        const world_cloth *const cloth = &model->cloths.data[i];
        for (size_t k = 0; cloth->is_drawn && k < cloth->mesh.vertex_count; k++) {
            size_t const vertex = cloth->vertex_begin + k;
            if (cloth->targets[6 * cloth->mesh.vertex_count + k] == 0.0) continue;
            work->is_fixed[vertex] = 1;
            work->active_inverse_masses[vertex] = 0.0;
            go_towards(work->start->positions + 3 * vertex, cloth->targets + 3 * k, share, 3,
                       work->targets + 3 * vertex);
        }
        for (size_t p = 0; p < cloth->pin_count; p++) {
            const world_pin *const pin = &cloth->pins[p];
            if (time >= pin->release_time) continue;
            for (size_t k = 0; k < pin->vertex_count; k++) {
                size_t const local = pin->vertices[k], vertex = cloth->vertex_begin + local;
                work->is_fixed[vertex] = 1;
                work->active_inverse_masses[vertex] = 0.0;
                double *const target = work->targets + 3 * vertex;
                const double *const start = cloth->mesh.positions + 3 * local;
                const double *const from = work->start->positions + 3 * vertex;
                if (pin->motion.key_count > 0)
                    motion_apply(&pin->motion, end_time, start, 1, target);
                else
                    go_towards(from, pin->has_targets ? pin->targets + 3 * k : from, share, 3,
                               target);
            }
        }
    }
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        double *const target = work->targets + 3 * (size_t)obstacle->vertex_begin;
        if (obstacle->read_frame) {
            tulle_status const status = sample_sequence(model, work, i, end_time, target);
            if (status != TULLE_OK) return status;
        } else if (obstacle->drive == TULLE_DRIVE_DEFORMING) {
            const double *const from = work->start->positions + 3 * (size_t)obstacle->vertex_begin;
            bool const moves = obstacle->given == GIVEN_MOVE;
            go_towards(from, moves ? obstacle->given_positions : from, share,
                       3 * obstacle->mesh.vertex_count, target);
        } else {
            motion_apply(&obstacle->motion, end_time, obstacle->mesh.positions,
                         obstacle->mesh.vertex_count, target);
        }
    }
    return TULLE_OK;
}

/* ---- carriers ----
 *
 * Carriers are the affine maps by which scripted obstacles go through a substep, for the rescue
 * that lets cloth ride on moving obstacles. A step begins with obstacles on their script. Vertices
 * move on straight lines to where the script has them at the end of the substep; when time is
 * shortened on the way they stop on their chords, where a turning obstacle is a little smaller than
 * itself. So the map of a substep is not the script's alone: from the start of the step to now the
 * obstacle has gone through P, to the end of the substep it goes through the script's S, and the
 * substep's map is S P^-1. */

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
