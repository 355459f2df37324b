/* world/kinematics.c - scripted and given motion: where obstacles and pinned vertices go, which are
 * there.
 *
 * Takes the defs, what the host gave (given.c) and a time; gives `targets`, the positions that
 * scripted vertices reach at that time, the mask of pinned vertices and inverse masses that are
 * zero for them. Poses are made from the defs' own positions each time, so nothing drifts. */
#include "base/error.h"
#include "math/vec3.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_sleep.h"
#include "world/record/record.h"
#include "world/start/inside.h"
#include "world/surface_box.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Makes sure that frame `number` is in one of the two cached slots; *slot tells which. `keep` is
 * the slot that must not be overwritten, or -1. */
static tulle_status load_frame(tulle_world *world, size_t index, uint32_t number, int keep,
                               int *slot, tulle_error *error) {
    world_obstacle *const obstacle = &world->model.obstacles.data[index];
    for (int i = 0; i < 2; i++) {
        if (obstacle->frame_numbers[i] == number) {
            *slot = i;
            return TULLE_OK;
        }
    }
    *slot = keep == 0 ? 1 : 0;
    obstacle->frame_numbers[*slot] = TULLE_NONE;
    double *const frame = obstacle->frames[*slot];
    tulle_status const status = obstacle->read_frame(obstacle->frame_context, number, frame, error);
    WORLD_RECORD(world, .kind = RECORD_FRAME, .ids = {obstacle->slot, number},
                 .generations = {world->slots.obstacles.data[obstacle->slot].generation},
                 .numbers = {(uint64_t)status},
                 .arrays = {{status == TULLE_OK ? frame : NULL,
                             status == TULLE_OK ? 3 * obstacle->mesh.vertex_count : 0}});
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < 3 * obstacle->mesh.vertex_count; i++) {
        if (!isfinite(frame[i])) {
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "%s: vertex %zu of frame %u is not finite", obstacle->name, i / 3,
                             number);
        }
    }
    obstacle->frame_numbers[*slot] = number;
    return TULLE_OK;
}

/* Positions of a mesh sequence at `time`, linear between its frames, still outside them. */
static tulle_status sample_sequence(tulle_world *world, size_t index, double time, double *target,
                                    tulle_error *error) {
    const world_obstacle *const obstacle = &world->model.obstacles.data[index];
    double const last = (double)(obstacle->frame_count - 1);
    double const position = (time - obstacle->frame_start_time) / obstacle->frame_interval;
    /* What is off a frame only by the rounding that the sum of the steps has gathered is that
     * frame. A live reader may not have the next one yet. */
    double const whole = round(position), share = (double)(world->step_count + 8) * DBL_EPSILON;
    double const rounding = share * (fabs(time) / obstacle->frame_interval + fabs(position));
    bool const is_whole = fabs(position - whole) <= rounding;
    double const clamped = fmin(fmax(is_whole ? whole : position, 0.0), last);
    uint32_t const from = (uint32_t)clamped;
    double const fraction = clamped - (double)from;
    int slot_from, slot_to;
    tulle_status status = load_frame(world, index, from, -1, &slot_from, error);
    if (status != TULLE_OK) return status;
    if (fraction == 0.0) {
        memcpy(target, obstacle->frames[slot_from],
               3 * obstacle->mesh.vertex_count * sizeof(double));
        return TULLE_OK;
    }
    status = load_frame(world, index, from + 1, slot_from, &slot_to, error);
    if (status != TULLE_OK) return status;
    const double *const a = obstacle->frames[slot_from], *const b = obstacle->frames[slot_to];
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

tulle_status world_place_obstacle(tulle_world *world, size_t index, double *positions,
                                  tulle_error *error) {
    const world_obstacle *const obstacle = &world->model.obstacles.data[index];
    double const time = world->now.time;
    if (obstacle->read_frame) return sample_sequence(world, index, time, positions, error);
    motion_apply(&obstacle->motion, time, obstacle->mesh.positions, obstacle->mesh.vertex_count,
                 positions);
    return TULLE_OK;
}

tulle_status world_script_targets(tulle_world *world, double time, double end_time,
                                  tulle_error *error) {
    double const length =
        world->work.step_end - world->now.time; /* of the step that runs, or the last */
    double const share = length > 0.0 ? (end_time - world->now.time) / length : 0.0;
    memset(world->work.is_fixed, 0, world->model.cloth_vertex_count);
    memcpy(world->work.active_inverse_masses, world->model.inverse_masses,
           world->model.vertex_count * sizeof(double));
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t k = 0; cloth->is_drawn && k < cloth->mesh.vertex_count; k++) {
            size_t const vertex = cloth->vertex_begin + k;
            if (cloth->targets[6 * cloth->mesh.vertex_count + k] == 0.0) continue;
            world->work.is_fixed[vertex] = 1;
            world->work.active_inverse_masses[vertex] = 0.0;
            go_towards(world->now.positions + 3 * vertex, cloth->targets + 3 * k, share, 3,
                       world->work.targets + 3 * vertex);
        }
        for (size_t p = 0; p < cloth->pin_count; p++) {
            const world_pin *const pin = &cloth->pins[p];
            if (time >= pin->release_time) continue;
            for (size_t k = 0; k < pin->vertex_count; k++) {
                size_t const local = pin->vertices[k], vertex = cloth->vertex_begin + local;
                world->work.is_fixed[vertex] = 1;
                world->work.active_inverse_masses[vertex] = 0.0;
                double *const target = world->work.targets + 3 * vertex;
                const double *const start = cloth->mesh.positions + 3 * local;
                const double *const from =
                    world->is_started ? world->now.positions + 3 * vertex : start;
                if (pin->motion.key_count > 0)
                    motion_apply(&pin->motion, end_time, start, 1, target);
                else
                    go_towards(from, pin->has_targets ? pin->targets + 3 * k : from, share, 3,
                               target);
            }
        }
    }
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        world_obstacle *const obstacle = &world->model.obstacles.data[i];
        double *const target = world->work.targets + 3 * (size_t)obstacle->vertex_begin;
        if (obstacle->read_frame) {
            tulle_status const status = sample_sequence(world, i, end_time, target, error);
            if (status != TULLE_OK) return status;
        } else if (obstacle->drive == TULLE_DRIVE_DEFORMING) {
            const double *const from =
                world->is_started ? world->now.positions + 3 * (size_t)obstacle->vertex_begin
                                  : obstacle->mesh.positions;
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

/* Judges obstacles that have just appeared (all others are clean already). */
static tulle_status judge_appearance(tulle_world *world, const motion_state *state,
                                     tulle_error *error) {
    const intersection_list *const list = &world->intersections;
    size_t const cloth_count = world->model.cloths.count;
    bool const is_ignored = world->model.def.start_intersections == TULLE_START_IGNORE;
    char when[WORLD_NAME_BYTES + 64];
    tulle_status const status =
        world_find_intersections(world, state->positions, &world->intersections, error);
    if (status != TULLE_OK || (list->count == 0 && is_ignored)) return status;
    if (list->count == 0) {
        snprintf(when, sizeof when, "when one of them appears or comes free at %.6g s",
                 state->time);
        return world_refuse_inside(world, state->positions,
                                   (inside_question){.when = when, .is_late = true}, error);
    }
    if (is_ignored) {
        /* a message that names the first obstacle that appears in something, and in what */
        size_t count = 0;
        uint32_t caught = 0, late = 0;
        for (size_t i = 0; i < list->count; i++) {
            uint32_t const a = list->data[i].object_a, b = list->data[i].object_b;
            bool const is_new_a = a >= cloth_count && !world->now.is_present[a - cloth_count];
            bool const is_new_b = b >= cloth_count && !world->now.is_present[b - cloth_count];
            if (!is_new_a && !is_new_b) continue;
            if (count++ > 0) continue;
            caught = is_new_b ? a : b;
            late = is_new_b ? b : a;
        }
        if (count > 0)
            snprintf(world->message, sizeof world->message,
                     "'%s' is caught at %.6g s in '%s', which appears there: %zu pairs of "
                     "triangles intersect and are let be until they come apart "
                     "(start_intersections: ignore)",
                     world_surface_name(world, caught), state->time,
                     world_surface_name(world, late), count);
        return world_ignore_intersections(world, error);
    }
    /* "at 0.8 s, when 'late' appears": the first obstacle of the pairs that is new */
    snprintf(when, sizeof when, "at %.6g s, when a body comes free", state->time);
    bool is_named = false;
    for (size_t i = 0; i < 2 * list->count && !is_named; i++) {
        const tulle_intersection *const pair = &list->data[i / 2];
        uint32_t const object = i % 2 == 0 ? pair->object_a : pair->object_b;
        is_named = object >= cloth_count && !world->now.is_present[object - cloth_count];
        if (is_named)
            snprintf(when, sizeof when, "at %.6g s, when '%s' appears", state->time,
                     world_surface_name(world, object));
    }
    return world_refuse_intersections(world, state->positions, when, error);
}

tulle_status world_update_presence(tulle_world *world, motion_state *state, tulle_error *error) {
    bool has_appeared = false, has_changed = false;
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        const world_obstacle *const obstacle = &world->model.obstacles.data[i];
        bool const is_present =
            state->time >= obstacle->appear_time && state->time < obstacle->disappear_time;
        has_appeared = has_appeared || (is_present && !state->is_present[i]);
        has_changed |= is_present != (state->is_present[i] != 0);
        state->is_present[i] = is_present;
        world->model.surfaces[world->model.cloths.count + i].is_present = is_present;
    }
    if (has_changed) world_wake_all(world, state);
    has_appeared |= world_free_bodies(world, state);
    world_mark_bodies(world, state);
    return has_appeared ? judge_appearance(world, state, error) : TULLE_OK;
}
