/* step/pinch/holds.c - see holds.h.
 *
 * In: the targets that the script gives, and the holds of the state. Out: the targets that scripted
 * vertices reach. Several holds may share an obstacle: projected Gauss-Seidel then finds the
 * amounts by which they hold back. */
#include "step/pinch/holds.h"

#include <math.h>
#include <string.h>

/* Sweeps over several holds; one is exact after the first. */
enum { HOLD_SWEEPS = 32 };
/* Steps for which a hold waits before its obstacle moves again: at first, at most. */
enum { WAIT_FIRST = 8, WAIT_MOST = 64 };
/* An obstacle on the way back to its script loses its lag at this speed [m/s], or at this rate
 * [1/s] where that is faster: as fast as a hand moves. */
static const double RETURN_SPEED = 0.5, RETURN_RATE = 4.0;

/* [m/s] Obstacles whose gap is smaller than the cloth needs part at this speed. Contact pushes out
 * what is too near at the same speed. */
static const double OPENING_SPEED = 0.05;

vec3 step_get_hold_point(const world_hold *hold, int side, const double *positions) {
    vec3 point = {0, 0, 0};
    if (hold->obstacles[side] == TULLE_NONE) return point;
    for (int k = 0; k < 4; k++)
        point = vec3_add(
            point, vec3_scale(vec3_load(positions, hold->points[side][k]), hold->weights[side][k]));
    return point;
}

/* ---- the list ---- */

bool step_add_hold(motion_state *state, const world_hold *hold) {
    size_t k = 0;
    for (; k < state->hold_count; k++) {
        const world_hold *const old = &state->holds[k];
        if (old->kind == hold->kind && old->obstacles[0] == hold->obstacles[0] &&
            old->obstacles[1] == hold->obstacles[1])
            break;
    }
    if (k == HOLDS_MAX) return false;
    uint32_t const wait = k < state->hold_count ? 2 * state->holds[k].wait : WAIT_FIRST;
    if (k == state->hold_count) state->hold_count++;
    state->holds[k] = *hold;
    if (hold->kind == HOLD_APART) return true;
    state->holds[k].wait = state->holds[k].waiting = wait < WAIT_MOST ? wait : WAIT_MOST;
    return true;
}

static bool is_tried(const world_hold *hold) {
    return hold->kind != HOLD_APART && hold->waiting == 0;
}

bool step_delay_holds(motion_state *state) {
    bool has_any = false;
    for (size_t k = 0; k < state->hold_count; k++) {
        if (!is_tried(&state->holds[k])) continue;
        world_hold const hold = state->holds[k];
        has_any |= step_add_hold(state, &hold);
    }
    return has_any;
}

bool step_is_held(const step_model *model, const motion_state *state, size_t obstacle) {
    if (obstacle < model->obstacles.count && state->largest_lags[obstacle] > 0.0) return true;
    for (size_t k = 0; k < state->hold_count; k++) {
        const world_hold *const hold = &state->holds[k];
        if (hold->kind == HOLD_ALL
                ? obstacle == model->obstacles.count
                : hold->obstacles[0] == obstacle ||
                      (hold->kind == HOLD_APART && hold->obstacles[1] == obstacle))
            return true;
    }
    return false;
}

/* What never follows a script has no share: trees over static obstacles are fitted once. */
static bool side_is_valid(const step_model *model, const step_work *work, const world_hold *hold,
                          int side, double share) {
    uint32_t const obstacle = hold->obstacles[side];
    if (obstacle == TULLE_NONE) return side == 1 || hold->kind == HOLD_ALL;
    if (obstacle >= model->obstacles.count) return false;
    const surface_range *const range = &work->surfaces[model->cloths.count + obstacle];
    bool const has_script = !range->is_static && !model->obstacles.data[obstacle].body.is_dynamic;
    if (hold->kind == HOLD_APART && !has_script && share != 0.0) return false;
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = hold->points[side][k];
        if (vertex < range->vertex_begin || vertex >= range->vertex_end ||
            !isfinite(hold->weights[side][k]))
            return false;
    }
    return true;
}

bool step_holds_are_valid(const step_model *model, const motion_state *state,
                          const step_work *work) {
    for (size_t k = 0; k < state->hold_count; k++) {
        const world_hold *const hold = &state->holds[k];
        double const sum = hold->normal[0] + hold->normal[1] + hold->normal[2] + hold->gap +
                           hold->wanted_gap + hold->lag;
        if (hold->kind > HOLD_ALL || !(hold->share >= 0.0 && hold->share <= 1.0) ||
            hold->cloth >= model->surface_count || !isfinite(sum) || hold->waiting > hold->wait ||
            hold->wait > WAIT_MOST || !side_is_valid(model, work, hold, 0, hold->share) ||
            !side_is_valid(model, work, hold, 1, 1.0 - hold->share))
            return false;
    }
    return true;
}

/* ---- targets ---- */

void step_begin_holds(motion_state *state, step_work *work) {
    work->pinch.is_script_frozen = false;
    for (size_t k = 0; k < state->hold_count; k++)
        work->pinch.is_script_frozen |=
            state->holds[k].kind == HOLD_ALL && !is_tried(&state->holds[k]);
}

/* Amount [m] by which each hold keeps its points apart. */
static void compute_amounts(const step_model *model, const motion_state *state,
                            const step_work *work, double amounts[HOLDS_MAX]) {
    double excess[HOLDS_MAX]; /* [m] by how much the script brings the points nearer than the gap */
    for (size_t k = 0; k < state->hold_count; k++) {
        const world_hold *const hold = &state->holds[k];
        vec3 const way = vec3_sub(step_get_hold_point(hold, 1, work->targets),
                                  step_get_hold_point(hold, 0, work->targets));
        amounts[k] = 0.0;
        excess[k] = hold->gap - vec3_dot(vec3_load(hold->normal, 0), way);
        for (int side = 0; side < 2; side++) {
            uint32_t const obstacle = hold->obstacles[side];
            if (obstacle != TULLE_NONE &&
                !work->surfaces[model->cloths.count + obstacle].is_present)
                excess[k] = -INFINITY;
        }
    }
    for (int sweep = 0; sweep < HOLD_SWEEPS; sweep++) {
        for (size_t k = 0; k < state->hold_count; k++) {
            const world_hold *const hold = &state->holds[k];
            if (hold->kind != HOLD_APART) continue;
            double wanted = excess[k];
            for (size_t other = 0; other < state->hold_count; other++) {
                const world_hold *const at = &state->holds[other];
                if (other == k || at->kind != HOLD_APART) continue;
                double const along =
                    vec3_dot(vec3_load(hold->normal, 0), vec3_load(at->normal, 0)) * amounts[other];
                for (int a = 0; a < 2; a++) {
                    for (int b = 0; b < 2; b++) {
                        if (hold->obstacles[a] != at->obstacles[b] ||
                            hold->obstacles[a] == TULLE_NONE)
                            continue;
                        double const moved = b == 0 ? -at->share : 1.0 - at->share;
                        wanted -= (a == 0 ? -1.0 : 1.0) * moved * along;
                    }
                }
            }
            amounts[k] = fmax(0.0, wanted);
        }
    }
}

/* Whether a hold that is no HOLD_APART is about a vertex. Bodies are not held. */
static bool concerns(const step_model *model, const step_work *work, const world_hold *hold,
                     size_t vertex) {
    size_t const first = model->cloth_vertex_count + 2 * model->body_count;
    if (vertex < first)
        return hold->kind == HOLD_ALL && vertex < model->cloth_vertex_count &&
               work->active_inverse_masses[vertex] == 0.0;
    size_t const obstacle = model->vertex_surface[vertex] - model->cloths.count;
    return !model->obstacles.data[obstacle].body.is_dynamic &&
           (hold->kind == HOLD_ALL || hold->obstacles[0] == obstacle);
}

/* Vertices of a hold stand still, or go a part of the way to their targets. */
static void limit_way(const step_model *model, const motion_state *state, step_work *work,
                      const world_hold *hold, double *lag) {
    const double *const positions = state->positions;
    double farthest = 0.0;
    for (size_t v = 0; v < model->vertex_count; v++) {
        if (!concerns(model, work, hold, v)) continue;
        vec3 const way = vec3_sub(vec3_load(work->targets, v), vec3_load(positions, v));
        farthest = fmax(farthest, vec3_norm(way));
    }
    double const passed = state->time + work->sub.time_step - work->start->time;
    double const left = hold->lag - passed * fmax(RETURN_SPEED, RETURN_RATE * hold->lag);
    *lag = is_tried(hold) ? fmin(fmax(left, 0.0), farthest) : farthest;
    if (!(*lag > 0.0)) return;
    double const share = 1.0 - *lag / farthest;
    for (size_t v = 0; v < model->vertex_count; v++) {
        if (!concerns(model, work, hold, v)) continue;
        vec3 const start = vec3_load(positions, v), target = vec3_load(work->targets, v);
        vec3_store(work->targets, v, share > 0.0 ? vec3_lerp(start, target, share) : start);
    }
}

void step_hold_targets(const step_model *model, motion_state *state, step_work *work) {
    if (state->hold_count == 0) return;
    double amounts[HOLDS_MAX];
    compute_amounts(model, state, work, amounts);
    for (size_t k = 0; k < state->hold_count; k++) {
        const world_hold *const hold = &state->holds[k];
        work->pinch.hold_left[k] = amounts[k];
        if (hold->kind != HOLD_APART) continue;
        double const shares[2] = {-hold->share, 1.0 - hold->share};
        for (int side = 0; side < 2; side++) {
            if (hold->obstacles[side] == TULLE_NONE || shares[side] == 0.0 || amounts[k] == 0.0)
                continue;
            vec3 const shift = vec3_scale(vec3_load(hold->normal, 0), shares[side] * amounts[k]);
            const surface_range *const range =
                &work->surfaces[model->cloths.count + hold->obstacles[side]];
            for (size_t v = range->vertex_begin; v < range->vertex_end; v++)
                vec3_store(work->targets, v, vec3_add(vec3_load(work->targets, v), shift));
        }
    }
    for (size_t k = 0; k < state->hold_count; k++)
        if (state->holds[k].kind != HOLD_APART)
            limit_way(model, state, work, &state->holds[k], &work->pinch.hold_left[k]);
}

void step_end_holds(motion_state *state, step_work *work) {
    size_t kept = 0;
    for (size_t k = 0; k < state->hold_count; k++) {
        world_hold hold = state->holds[k];
        bool const is_apart = hold.kind == HOLD_APART;
        bool const was_tried = is_tried(&hold);
        if (is_apart && hold.gap < hold.wanted_gap)
            hold.gap = fmin(hold.wanted_gap, hold.gap + OPENING_SPEED * work->whole_step);
        if (!is_apart) hold.lag = work->pinch.hold_left[k];
        if (hold.waiting > 0) hold.waiting--;
        bool const is_over = (is_apart || was_tried) && !(work->pinch.hold_left[k] > 0.0) &&
                             !work->pinch.is_script_frozen;
        if (!is_over) state->holds[kept++] = hold;
    }
    state->hold_count = kept;
}
