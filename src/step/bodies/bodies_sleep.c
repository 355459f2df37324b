/* step/bodies/bodies_sleep.c - see bodies_sleep.h. */
#include "step/bodies/bodies_sleep.h"

#include "contact/pairs/body_paths.h"
#include "contact/rows/row_motion.h"
#include "geom/union_find.h"
#include "step/bodies/bodies.h"
#include "step/sleep/cloth_sleep.h"
#include "step/surface_box.h"

#include <math.h>
#include <string.h>

/* ---- waking ---- */

void step_wake_body(const step_model *model, motion_state *state, size_t body) {
    state->rests[body].quiet_time = 0.0;
    if (state->rests[body].state != BODY_SLEEPS) return;
    uint32_t const group = state->rests[body].group;
    for (size_t b = 0; b < model->body_count; b++) {
        body_rest *const rest = &state->rests[b];
        if (rest->state != BODY_SLEEPS || rest->group != group) continue;
        rest->state = BODY_FREE;
        rest->quiet_time = 0.0;
    }
}

void step_wake_all(const step_model *model, motion_state *state) {
    for (size_t b = 0; b < model->body_count; b++) {
        body_rest *const rest = &state->rests[b];
        rest->quiet_time = 0.0;
        if (rest->state == BODY_SLEEPS) rest->state = BODY_FREE;
    }
    step_wake_cloths(model, state);
}

/* The boxes of the paths of moving obstacles that are not free bodies. Returns how many; there is
 * room for all. */
static size_t list_ways(const step_model *model, const motion_state *state, const step_work *work,
                        surface_box *ways) {
    const double *const positions = state->positions;
    size_t count = 0;
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        if (range->is_static || range->is_body || !range->is_present) continue;
        size_t const begin = 3 * (size_t)range->vertex_begin, end = 3 * (size_t)range->vertex_end;
        if (memcmp(work->targets + begin, positions + begin, (end - begin) * sizeof(double)) != 0)
            ways[count++] = measure_surface_box(range, positions, work->targets);
    }
    return count;
}

/* Whether a surface, which stands, is near one of these boxes. */
static bool is_near_ways(const step_model *model, const motion_state *state,
                         const surface_range *range, const surface_box *ways, size_t count) {
    const double *const positions = state->positions;
    surface_box const own = measure_surface_box(range, positions, positions);
    double const distance = model->separation_distance;
    for (size_t i = 0; i < count; i++) {
        bool is_near = true;
        for (size_t c = 0; c < 3; c++)
            is_near = is_near && own.low[c] <= ways[i].high[c] + distance &&
                      ways[i].low[c] <= own.high[c] + distance;
        if (is_near) return true;
    }
    return false;
}

tulle_status step_wake_near_script(const step_model *model, motion_state *state, step_work *work) {
    if (!model->has_sleep) return TULLE_OK;
    surface_box *const ways = ARENA_NEW(&work->scratch, surface_box, model->obstacles.count);
    if (!ways) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t const count = list_ways(model, state, work, ways);
    for (size_t b = 0; b < model->body_count && count > 0; b++)
        if (is_near_ways(model, state, get_body_surface(model, work, b), ways, count))
            step_wake_body(model, state, b);
    for (size_t c = 0; c < model->cloth_rest_count && count > 0; c++)
        if (is_near_ways(model, state, &work->surfaces[c], ways, count))
            step_wake_cloth(model, state, c);
    for (size_t b = 0; b < model->body_count; b++)
        get_body_surface(model, work, b)->is_asleep = state->rests[b].state == BODY_SLEEPS;
    return TULLE_OK;
}

/* The push of cloth on a sleeper, as an impulse [N s] and its moment [N m s]. */
typedef struct body_press {
    vec3 impulse, moment;
    bool by_body; /* a body that is awake takes part */
} body_press;

/* What a side of a row lies on. */
typedef struct side_owner {
    uint32_t body; /* a sleeper or other body; TULLE_NONE: neither */
    bool is_cloth;
} side_owner;

static side_owner find_side_owner(const step_model *model, const contact_row *row, int side) {
    side_owner owner = {.body = TULLE_NONE};
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        if (get_row_side(row, k) != side) continue;
        if (vertex < model->cloth_vertex_count)
            owner.is_cloth = true;
        else
            owner.body = model->surface_bodies[model->vertex_surface[vertex]];
    }
    return owner;
}

/* The push of cloth on a body, as `impulse` at `point`. */
static void add_press(const step_model *model, const motion_state *state, uint32_t body, vec3 point,
                      vec3 impulse, body_press *press) {
    size_t const slot = get_first_slot(model, body);
    vec3 const arm = vec3_sub(point, vec3_load(state->positions, slot));
    press->impulse = vec3_add(press->impulse, impulse);
    press->moment = vec3_add(press->moment, vec3_cross(arm, impulse));
}

/* As above, for sleeping cloth on sleeping bodies, which has no rows: from the store. `rate`
 * converts its impulses to those of the solve. */
static void add_resting_presses(const step_model *model, const motion_state *state,
                                const step_work *work, double rate, body_press *presses) {
    const contact_store *const store = &state->contacts;
    for (size_t i = 0; model->cloth_rest_count > 0 && i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        feature_kind const kind = (feature_kind)contact->kind;
        uint32_t vertices[4];
        feature_pair_vertices(&model->topo, kind, (feature_pair){contact->first, contact->second},
                              vertices);
        size_t const cloth = model->vertex_surface[vertices[0]]; /* cloths come first */
        size_t const other = model->vertex_surface[vertices[3]];
        size_t const low = cloth < other ? cloth : other, high = cloth < other ? other : cloth;
        uint32_t const body = model->surface_bodies[high];
        if (low >= model->cloths.count || !work->surfaces[low].is_asleep || body == TULLE_NONE ||
            state->rests[body].state != BODY_SLEEPS)
            continue;
        vec3 points[4], point = {0.0, 0.0, 0.0};
        for (int k = 0; k < 4; k++) points[k] = vec3_load(state->positions, vertices[k]);
        closest_points const closest = closest_of_pair(kind, points);
        for (int k = 0; k < 4; k++)
            if (model->vertex_surface[vertices[k]] == low)
                point = vec3_add_scaled(point, points[k], fabs(closest.weights[k]));
        double const sign = cloth == high ? 1.0 : -1.0;
        add_press(model, state, body, point,
                  vec3_scale(vec3_load(contact->impulse, 0), sign * rate), &presses[body]);
    }
}

/* What cloth presses on each body with, and whether other bodies that are awake press on it. In
 * the scratch arena; null: no memory. */
static body_press *collect_presses(const step_model *model, const motion_state *state,
                                   step_work *work) {
    const double *const positions = state->positions;
    body_press *const presses = ARENA_NEW_ZEROED(&work->scratch, body_press, model->body_count);
    for (size_t i = 0; presses && i < work->rows.rows.count; i++) {
        const contact_row *const row = &work->rows.rows.data[i];
        if (!(vec3_norm2(row->solve.impulse) > 0.0)) continue;
        side_owner const owners[2] = {find_side_owner(model, row, 0),
                                      find_side_owner(model, row, 1)};
        for (int side = 0; side < 2; side++) {
            uint32_t const body = owners[side].body, other = owners[1 - side].body;
            if (body == TULLE_NONE) continue;
            presses[body].by_body |= other != TULLE_NONE && state->rests[other].state == BODY_FREE;
            if (!owners[1 - side].is_cloth) continue;
            /* The push acts at the point of the cloth. */
            vec3 point = {0.0, 0.0, 0.0};
            for (int k = 0; k < 4; k++)
                if (get_row_side(row, k) == 1 - side)
                    point = vec3_add_scaled(point, vec3_load(positions, row->frame.vertices[k]),
                                            fabs(row->frame.weights[k]));
            add_press(model, state, body, point,
                      vec3_scale(row->solve.impulse, side == 0 ? 1.0 : -1.0), &presses[body]);
        }
    }
    return presses;
}

/* [m/s] The speed that this substep would give a sleeper with all that it carries. The moment of
 * inertia is that of the sleeper alone. What it carries makes it larger, so a sleeper is found to
 * turn sooner than it does. */
static double compute_change(const step_model *model, const motion_state *state,
                             const step_work *work, size_t body, const body_press *press) {
    const world_obstacle *const obstacle = get_body(model, body);
    const body_rest *const rest = &state->rests[body];
    double const h = work->sub.time_step, whole = h / work->system.force_time;
    vec3 const force = vec3_load(rest->force, 0), torque = vec3_load(rest->torque, 0);
    vec3 const push = vec3_add_scaled(vec3_scale(press->impulse, whole), force, -h);
    vec3 const turn = vec3_add_scaled(vec3_scale(press->moment, whole), torque, -h);
    quaternion const orientation =
        unpack_orientation(vec3_load(state->positions, get_first_slot(model, body) + 1));
    mat3 const inverse = rigid_compute_inverse_inertia(&obstacle->rigid, orientation);
    /* A push by cloth moves the body and those that it carries. Their weight is the push of cloth
     * against gravity when it fell asleep. */
    vec3 const gravity = work->sub.scene.gravity;
    double const own = obstacle->rigid.mass, norm2 = vec3_norm2(gravity);
    double const carried =
        norm2 > 0.0 ? fmax(own, -vec3_dot(force, gravity) / norm2) : own; /* [kg] */
    double const own_share = own / carried;
    return own_share * (vec3_norm(push) / own +
                        vec3_norm(mat3_multiply_vec3(&inverse, turn)) * obstacle->radius);
}

tulle_status step_wake_pressed(const step_model *model, motion_state *state, step_work *work,
                               bool *wakes) {
    *wakes = step_wake_loaded(model, state, work);
    if (!model->has_sleep || model->body_count == 0) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&work->scratch);
    body_press *const presses = collect_presses(model, state, work);
    if (!presses) return TULLE_ERROR_OUT_OF_MEMORY;
    const contact_store *const store = &state->contacts;
    if (store->contacts.count > 0)
        add_resting_presses(model, state, work, work->system.force_time / store->time_step,
                            presses);
    for (size_t b = 0; b < model->body_count; b++) {
        if (state->rests[b].state != BODY_SLEEPS) continue;
        bool const is_pressed =
            presses[b].by_body || compute_change(model, state, work, b, &presses[b]) >
                                      get_body(model, b)->body.sleep_speed;
        if (!is_pressed) continue;
        step_wake_body(model, state, b);
        *wakes = true;
    }
    arena_release(&work->scratch, mark);
    return TULLE_OK;
}

/* ---- contacts without a row ---- */

tulle_status step_keep_resting(const step_model *model, motion_state *state, step_work *work) {
    const contact_store *const store = &state->contacts;
    const uint32_t *const edges = model->topo.edges, *const triangles = model->topo.triangles;
    work->sub.resting_count = 0;
    if (!model->has_sleep) return TULLE_OK;
    work->sub.resting = ARENA_NEW(&work->scratch, stored_contact, store->contacts.count);
    if (!work->sub.resting) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        bool const has_edges = contact->kind == FEATURE_EDGE_EDGE;
        size_t const first = contact->first, second = contact->second;
        uint32_t const vertices[2] = {has_edges ? edges[2 * first] : contact->first,
                                      has_edges ? edges[2 * second] : triangles[3 * second]};
        size_t const a = model->vertex_surface[vertices[0]], b = model->vertex_surface[vertices[1]];
        bool const has_sleeper = work->surfaces[a].is_asleep || work->surfaces[b].is_asleep;
        if (!has_sleeper || surfaces_may_meet(&work->set, a, b)) continue;
        stored_contact *const kept = &work->sub.resting[work->sub.resting_count++];
        *kept = *contact;
        for (int k = 0; k < 3; k++) kept->impulse[k] *= work->sub.time_step / store->time_step;
    }
    return TULLE_OK;
}

/* ---- falling asleep ---- */

/* The root of each body is the lowest of those it touches, directly or over others. */
static void join_bodies(const step_model *model, const motion_state *state, const step_work *work,
                        uint32_t *parents) {
    const body_rest *const rests = state->rests;
    for (uint32_t b = 0; b < model->body_count; b++) parents[b] = b;
    for (size_t i = 0; i < work->rows.rows.count; i++) {
        const contact_row *const row = &work->rows.rows.data[i];
        uint32_t const first = find_side_owner(model, row, 0).body;
        uint32_t const second = find_side_owner(model, row, 1).body;
        if (first == TULLE_NONE || second == TULLE_NONE) continue;
        if (rests[first].state == BODY_SCRIPTED || rests[second].state == BODY_SCRIPTED) continue;
        union_find_join(parents, first, second);
    }
}

static void fall_asleep(const step_model *model, motion_state *state, const step_work *work,
                        size_t body, uint32_t group, const body_press *press) {
    const surface_range *const range = get_body_surface(model, work, body);
    size_t const begin = range->vertex_begin;
    body_rest *const rest = &state->rests[body];
    double const rate = 1.0 / work->sub.time_step;
    rest->state = BODY_SLEEPS;
    rest->group = group;
    vec3_store(rest->force, 0, vec3_scale(press->impulse, rate));
    vec3_store(rest->torque, 0, vec3_scale(press->moment, rate));
    step_sum_contact_impulses(&work->rows, get_first_slot(model, body), rest->impulse,
                              rest->moment);
    double *vectors[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(state, vectors);
    for (size_t i = 1; i < vector_count; i++) /* all but positions */
        memset(vectors[i] + 3 * get_first_slot(model, body), 0, 6 * sizeof(double));
    memset(state->velocities + 3 * begin, 0, 3 * (range->vertex_end - begin) * sizeof(double));
}

tulle_status step_settle_bodies(const step_model *model, motion_state *state, step_work *work) {
    size_t const count = model->body_count;
    if (!model->has_sleep || count == 0) return TULLE_OK;
    uint32_t *const parents = ARENA_NEW(&work->scratch, uint32_t, count);
    bool *const is_awake = ARENA_NEW_ZEROED(&work->scratch, bool, count);
    const body_press *const presses = collect_presses(model, state, work);
    if (!parents || !is_awake || !presses) return TULLE_ERROR_OUT_OF_MEMORY;
    join_bodies(model, state, work, parents);
    /* Bodies that hang together stay awake while one of them has not been slow for long enough. */
    for (uint32_t b = 0; b < count; b++) {
        const world_obstacle *const obstacle = get_body(model, b);
        body_rest *const rest = &state->rests[b];
        if (rest->state == BODY_SLEEPS) continue;
        bool const may_sleep = rest->state == BODY_FREE && obstacle->body.sleep_speed > 0.0 &&
                               !model->controls[b].is_driven &&
                               get_body_surface(model, work, b)->is_present;
        if (may_sleep) {
            size_t const slot = get_first_slot(model, b);
            double const speed = vec3_norm(vec3_load(state->velocities, slot)) +
                                 vec3_norm(vec3_load(state->velocities, slot + 1)) *
                                     obstacle->radius; /* of any point */
            bool const is_slow = speed <= obstacle->body.sleep_speed;
            rest->quiet_time = is_slow ? rest->quiet_time + work->whole_step : 0.0;
        }
        if (!may_sleep || rest->quiet_time < obstacle->body.sleep_time)
            is_awake[union_find_root(parents, b)] = true;
    }
    for (uint32_t b = 0; b < count; b++) {
        uint32_t const root = union_find_root(parents, b);
        if (is_awake[root] || state->rests[b].state == BODY_SLEEPS) continue;
        fall_asleep(model, state, work, b, root, &presses[b]);
    }
    return TULLE_OK;
}
