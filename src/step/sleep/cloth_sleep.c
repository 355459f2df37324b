/* step/sleep/cloth_sleep.c - see cloth_sleep.h.
 *
 * Why nothing is lost: a sleeper does not move at all, nor does a sleeper next to it. An obstacle
 * that is no body either moves in a substep or not. If it does, the box of its way is farther from
 * the sleeper than any contact reaches, else the sleeper wakes before pairs are looked for. So of a
 * sleeper only pairs with cloth and bodies that are awake may come nearer than they were, and those
 * are found as all others are. Neither place nor gap of other pairs changes, and their contacts in
 * the store stay valid.
 *
 * Why it may stop: the fastest vertex was below sleep_speed s for sleep_time t, by its velocity and
 * by its displacement. Cloth that swings with the period T and stays so slow has an amplitude below
 * s T / (2 pi sin(pi t / T)): docs/method/sleep.md. The centre of mass must be ten times slower
 * still: the remaining motion of cloth at rest has no common direction, that of sliding or falling
 * cloth has. */
#include "step/sleep/cloth_sleep.h"

#include "geom/union_find.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/energy_balance.h"
#include "step/lag/lag.h"
#include "step/ties/ties.h"

#include <math.h>
#include <string.h>

/* The centre of mass must be slower than this part of sleep_speed. */
static const double CENTRE_SHARE = 0.1;

/* ---- waking ---- */

void step_wake_cloth(const step_model *model, motion_state *state, size_t cloth) {
    if (cloth < model->cloth_rest_count) state->cloth_rests[cloth] = (cloth_rest){0};
}

void step_wake_cloths(const step_model *model, motion_state *state) {
    for (size_t c = 0; c < model->cloth_rest_count; c++) step_wake_cloth(model, state, c);
}

void step_wake_cloth_at(const step_model *model, motion_state *state, uint32_t vertex) {
    if (vertex < model->cloth_vertex_count)
        step_wake_cloth(model, state, model->vertex_surface[vertex]);
}

static bool has_gusts(const step_model *model) {
    return model->def.wind.gust_strength > 0.0 && model->def.wind.drag_coefficient > 0.0;
}

/* Whether a surface has unknowns in this substep. */
static bool is_awake(const step_model *model, const motion_state *state, const step_work *work,
                     size_t surface) {
    if (surface < model->cloths.count) return !state->cloth_rests[surface].is_asleep;
    uint32_t const body = model->surface_bodies ? model->surface_bodies[surface] : TULLE_NONE;
    return body != TULLE_NONE && state->rests[body].state == BODY_FREE &&
           work->surfaces[surface].is_present;
}

/* Whether a vertex is to be elsewhere at the end of the substep. */
static bool is_moved(const motion_state *state, const step_work *work, size_t vertex) {
    return memcmp(work->targets + 3 * vertex, state->positions + 3 * vertex, 3 * sizeof(double)) !=
           0;
}

/* Whether a holder of a cloth moves in this substep, or has let go since it fell asleep. */
static bool is_pulled(const step_model *model, const motion_state *state, const step_work *work,
                      size_t cloth) {
    const surface_range *const range = &work->surfaces[cloth];
    const world_cloth *const own = &model->cloths.data[cloth];
    const cloth_rest *const rest = &state->cloth_rests[cloth];
    for (size_t v = range->vertex_begin; v < range->vertex_end; v++)
        if (work->is_fixed[v] && is_moved(state, work, v)) return true;
    for (size_t p = 0; p < own->pin_count; p++) {
        double const release = own->pins[p].release_time;
        if (rest->is_asleep && release > rest->slept_from && release <= state->time) return true;
    }
    return false;
}

/* Wakes cloths that are tied to something that moves or is awake. True when there is one. */
static bool wake_tied(const step_model *model, motion_state *state, const step_work *work) {
    bool has_woken = false;
    for (size_t i = 0; i < state->ties.count; i++) {
        const world_tie *const tie = &state->ties.data[i];
        uint32_t const surface = get_tie_surface(model, tie);
        size_t const cloth = model->vertex_surface[tie->vertex];
        if (surface == TULLE_NONE)
            continue; /* is_pulled has seen rigid ones; others pull as ever */
        bool const is_other_awake = is_awake(model, state, work, surface);
        bool const is_other_cloth = surface < model->cloths.count;
        bool is_led = false;
        for (int k = 0; k < 3; k++)
            is_led |= !is_other_cloth && is_moved(state, work, tie->corners[k]);
        if (state->cloth_rests[cloth].is_asleep && (is_other_awake || is_led)) {
            step_wake_cloth(model, state, cloth);
            has_woken = true;
        } else if (is_other_cloth && !is_other_awake && !state->cloth_rests[cloth].is_asleep) {
            step_wake_cloth(model, state, surface);
            has_woken = true;
        }
    }
    return has_woken;
}

/* Wakes cloths that rested on something that is awake now. True when there is one. */
static bool wake_touched(const step_model *model, motion_state *state, const step_work *work) {
    const contact_store *const store = &state->contacts;
    bool has_woken = false;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        uint32_t vertices[4];
        feature_pair_vertices(&model->topo, (feature_kind)contact->kind,
                              (feature_pair){contact->first, contact->second}, vertices);
        const size_t sides[2] = {model->vertex_surface[vertices[0]],
                                 model->vertex_surface[vertices[3]]};
        for (int k = 0; k < 2; k++) {
            size_t const cloth = sides[k];
            if (cloth >= model->cloth_rest_count || !state->cloth_rests[cloth].is_asleep ||
                !is_awake(model, state, work, sides[1 - k]) ||
                !(vec3_norm2(vec3_load(contact->impulse, 0)) > 0.0))
                continue;
            step_wake_cloth(model, state, cloth);
            has_woken = true;
        }
    }
    return has_woken;
}

void step_hold_sleepers(const step_model *model, motion_state *state, step_work *work) {
    size_t const count = model->cloth_rest_count;
    bool has_sleeper = false;
    if (count == 0) return;
    if (has_gusts(model)) step_wake_cloths(model, state);
    for (size_t c = 0; c < count; c++) {
        if (is_pulled(model, state, work, c)) step_wake_cloth(model, state, c);
        has_sleeper |= state->cloth_rests[c].is_asleep != 0;
    }
    /* what wakes may wake others */
    for (bool is_over = !has_sleeper; !is_over;) {
        bool const is_tied = wake_tied(model, state, work),
                   is_touched = wake_touched(model, state, work);
        is_over = !is_tied && !is_touched;
    }
    has_sleeper = false;
    for (size_t c = 0; c < count; c++) {
        surface_range *const range = &work->surfaces[c];
        size_t const begin = range->vertex_begin, length = range->vertex_end - begin;
        range->is_asleep = state->cloth_rests[c].is_asleep != 0;
        memset(work->idle.vertices + begin, range->is_asleep, length);
        memset(work->idle.triangles + range->triangle_begin, range->is_asleep,
               range->triangle_end - range->triangle_begin);
        if (!range->is_asleep) continue;
        has_sleeper = true;
        memset(work->is_fixed + begin, 1, length);
        memset(work->active_inverse_masses + begin, 0, length * sizeof(double));
        memcpy(work->targets + 3 * begin, state->positions + 3 * begin,
               3 * length * sizeof(double));
    }
    model->cloth_model->idle_vertices = has_sleeper ? work->idle.vertices : NULL;
    model->cloth_model->idle_triangles = has_sleeper ? work->idle.triangles : NULL;
    work->system.matrix.is_idle = model->cloth_model->idle_vertices;
}

bool step_wake_loaded(const step_model *model, motion_state *state, step_work *work) {
    bool wakes = false;
    for (size_t i = 0; model->cloth_rest_count > 0 && i < work->rows.rows.count; i++) {
        const contact_row *const row = &work->rows.rows.data[i];
        if (!(vec3_norm2(row->solve.impulse) > 0.0)) continue;
        for (int k = 0; k < 4; k += 3) { /* a vertex of either side */
            uint32_t const vertex = row->frame.vertices[k];
            if (!work->surfaces[model->vertex_surface[vertex]].is_asleep ||
                vertex >= model->cloth_vertex_count)
                continue;
            step_wake_cloth_at(model, state, vertex);
            wakes = true;
        }
    }
    return wakes;
}

/* ---- falling asleep ---- */

/* Whether a cloth was slow in the step that ends, and nothing that holds it moved. */
static bool is_slow(const step_model *model, const motion_state *state, const step_work *work,
                    size_t cloth, double time_step) {
    const surface_range *const range = &work->surfaces[cloth];
    double const speed = model->def.sleep_speed, limit = speed * speed;
    double const way_limit = limit * time_step * time_step;
    vec3 momentum = {0.0, 0.0, 0.0}, drift = {0.0, 0.0, 0.0};
    double mass = 0.0;
    for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
        vec3 const velocity = vec3_load(state->velocities, v);
        vec3 const way =
            vec3_sub(vec3_load(state->positions, v), vec3_load(work->start->positions, v));
        if (!(vec3_norm2(velocity) <= limit && vec3_norm2(way) <= way_limit)) return false;
        if (work->is_fixed[v] && vec3_norm2(way) > 0.0) return false;
        double const own = model->cloth_model->masses[v];
        momentum = vec3_add_scaled(momentum, velocity, own);
        drift = vec3_add_scaled(drift, way, own);
        mass += own;
    }
    double const most = CENTRE_SHARE * speed * mass;
    return vec3_norm(momentum) <= most && vec3_norm(drift) <= most * time_step;
}

/* Cloths that touch or are tied get the same root. A cloth that something awake holds is restless.
 */
static void join_surfaces(const step_model *model, const motion_state *state, const step_work *work,
                          const size_t pair[2], uint32_t *parents, bool *is_restless) {
    size_t const a = pair[0], b = pair[1];
    size_t const count = model->cloths.count;
    if (a < count && b < count) {
        union_find_join(parents, (uint32_t)a, (uint32_t)b);
    } else if (a < count || b < count) {
        size_t const cloth = a < count ? a : b, other = a < count ? b : a;
        is_restless[cloth] |= is_awake(model, state, work, other);
    }
}

static void fall_asleep(motion_state *state, const step_work *work, size_t cloth) {
    const surface_range *const range = &work->surfaces[cloth];
    size_t const begin = 3 * (size_t)range->vertex_begin;
    size_t const bytes = 3 * (range->vertex_end - range->vertex_begin) * sizeof(double);
    cloth_rest *const rest = &state->cloth_rests[cloth];
    rest->is_asleep = 1;
    rest->slept_from = work->start->time;
    memset(state->velocities + begin, 0, bytes);
    if (!state->previous_mean) return;
    memset(state->previous_mean + begin, 0, bytes);
    memset(state->previous_velocities + begin, 0, bytes);
}

tulle_status step_settle_cloths(const step_model *model, motion_state *state, step_work *work,
                                bool is_whole) {
    size_t const count = model->cloth_rest_count;
    if (count == 0) return TULLE_OK;
    uint32_t *const parents = ARENA_NEW(&work->scratch, uint32_t, count);
    bool *const is_restless = ARENA_NEW_ZEROED(&work->scratch, bool, count);
    if (!parents || !is_restless) return TULLE_ERROR_OUT_OF_MEMORY;
    /* A stuck step says nothing about the motion of cloth, and an obstacle that lags will move on.
     */
    bool const may_sleep = is_whole && !has_gusts(model) && !step_has_lags(model, state);
    for (uint32_t c = 0; c < count; c++) {
        cloth_rest *const rest = &state->cloth_rests[c];
        parents[c] = c;
        if (rest->is_asleep) continue;
        bool const is_quiet = may_sleep && is_slow(model, state, work, c, work->whole_step);
        rest->quiet_time = is_quiet ? rest->quiet_time + work->whole_step : 0.0;
        is_restless[c] = rest->quiet_time < model->def.sleep_time;
    }
    for (size_t i = 0; model->cloth_rest_count > 0 && i < work->rows.rows.count; i++) {
        const contact_row *const row = &work->rows.rows.data[i];
        if (!(vec3_norm2(row->solve.impulse) > 0.0)) continue;
        size_t const pair[2] = {model->vertex_surface[row->frame.vertices[0]],
                                model->vertex_surface[row->frame.vertices[3]]};
        join_surfaces(model, state, work, pair, parents, is_restless);
    }
    for (size_t i = 0; i < state->ties.count; i++) {
        const world_tie *const tie = &state->ties.data[i];
        uint32_t const surface = get_tie_surface(model, tie);
        if (surface == TULLE_NONE) continue;
        size_t const pair[2] = {model->vertex_surface[tie->vertex], surface};
        join_surfaces(model, state, work, pair, parents, is_restless);
    }
    for (uint32_t c = 0; c < count; c++)
        if (is_restless[c]) is_restless[union_find_root(parents, c)] = true;
    for (uint32_t c = 0; c < count; c++)
        if (!state->cloth_rests[c].is_asleep && !is_restless[union_find_root(parents, c)])
            fall_asleep(state, work, c);
    return TULLE_OK;
}

/* ---- a step in which nothing moves ----
 *
 * Where all that may move sleeps, and nothing on a script moves, the ten stages would find nothing
 * to do; but reading and copying would cost in proportion to the world. So they are left out: only
 * the time of the state changes, and the contacts of the last computed step are still reported.
 * Whether a step is one of these follows from the state, the defs and the host's input alone. */

/* Whether a script of keyframes holds still from one time to another. */
static bool keys_are_still(const world_motion *motion, double from, double to) {
    size_t const count = motion->key_count;
    return count == 0 || to <= motion->keys[0].time || from >= motion->keys[count - 1].time;
}

/* Whether an obstacle, or a body, neither comes nor goes nor moves. */
static bool obstacle_is_still(const step_model *model, const step_work *work, size_t index,
                              double end) {
    const motion_state *const now = work->start;
    const world_obstacle *const obstacle = &model->obstacles.data[index];
    const surface_range *const range = &work->surfaces[model->cloths.count + index];
    bool const is_due = now->time >= obstacle->appear_time && now->time < obstacle->disappear_time;
    if (is_due != (now->is_present[index] != 0)) return false;
    if (range->is_static) return true;
    if (obstacle->given != GIVEN_NOTHING || now->largest_lags[index] > 0.0) return false;
    if (obstacle->body.is_dynamic) {
        uint32_t const body = model->surface_bodies[model->cloths.count + index];
        uint32_t const state = now->rests[body].state;
        if (state != BODY_SCRIPTED) return state == BODY_SLEEPS;
        if (now->time >= obstacle->body.start_time) return false;
    }
    if (obstacle->read_frame) {
        double const last = obstacle->frame_start_time +
                            (double)(obstacle->frame_count - 1) * obstacle->frame_interval;
        if (end > obstacle->frame_start_time && now->time < last) return false;
    }
    bool const is_on_keys = obstacle->drive != TULLE_DRIVE_RIGID;
    if (is_on_keys && !keys_are_still(&obstacle->motion, now->time, end)) return false;
    for (size_t i = 3 * (size_t)range->vertex_begin; i < 3 * (size_t)range->vertex_end; i++)
        if (now->velocities[i] != 0.0) return false;
    return true;
}

/* Whether a cloth sleeps on, held as it is. */
static bool cloth_is_still(const step_model *model, const step_work *work, size_t index,
                           double end) {
    const world_cloth *const cloth = &model->cloths.data[index];
    const cloth_rest *const rest = &work->start->cloth_rests[index];
    if (!rest->is_asleep) return false;
    for (size_t p = 0; p < cloth->pin_count; p++) {
        const world_pin *const pin = &cloth->pins[p];
        double const time = work->start->time, release = pin->release_time;
        bool const lets_go = release > rest->slept_from && release <= time;
        bool const moves = release > time && !keys_are_still(&pin->motion, time, end);
        if (lets_go || moves || pin->has_targets) return false;
    }
    return true;
}

bool step_stands_still(const step_model *model, const step_work *work) {
    const motion_state *const now = work->start;
    double const end = now->time + work->whole_step;
    if (model->cloth_rest_count == 0 || now->still_count > 0) return false;
    for (size_t c = 0; c < model->cloth_rest_count; c++)
        if (!cloth_is_still(model, work, c, end)) return false;
    for (size_t i = 0; i < model->obstacles.count; i++)
        if (!obstacle_is_still(model, work, i, end)) return false;
    for (size_t i = 0; i < now->ties.count; i++) {
        uint32_t const corner = now->ties.data[i].corners[0];
        bool const is_on_body = corner != TULLE_NONE && model->surface_bodies &&
                                model->surface_bodies[model->vertex_surface[corner]] != TULLE_NONE;
        if (now->time >= now->ties.data[i].release_time || is_on_body) return false;
    }
    return true;
}

tulle_status step_pass_still(const step_model *model, motion_state *state, step_work *work) {
    contact_store *const store = &state->contacts;
    tulle_status const status = step_report_energies(model, state, work);
    if (status != TULLE_OK) return status;
    work->report->kinetic_energy = 0.0;
    work->report->substeps = 1;

    /* contacts press on as they did, for the length of this step */
    double const share = store->contacts.count > 0 ? work->whole_step / store->time_step : 1.0;
    for (size_t i = 0; share != 1.0 && i < store->contacts.count; i++)
        for (int k = 0; k < 3; k++) store->contacts.data[i].impulse[k] *= share;
    if (store->contacts.count > 0) store->time_step = work->whole_step;
    state->time = work->step_end;
    state->step_count++;
    return TULLE_OK;
}
