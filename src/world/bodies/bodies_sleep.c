/* world/bodies/bodies_sleep.c - see bodies_sleep.h. */
#include "world/bodies/bodies_sleep.h"

#include "base/error.h"
#include "contact/pairs/body_paths.h"
#include "contact/rows/row_motion.h"
#include "world/bodies/bodies.h"

#include <math.h>
#include <string.h>

static const world_obstacle *get_body(const tulle_world *world, size_t body) {
    return &world->obstacles.data[world->body_obstacles[body]];
}

static size_t get_surface(const tulle_world *world, size_t body) {
    return world->cloths.count + world->body_obstacles[body];
}

static size_t get_slot(const tulle_world *world, size_t body) {
    return world->cloth_vertex_count + 2 * body;
}

static quaternion get_orientation(const world_motion_state *state, const tulle_world *world,
                                  size_t body) {
    return unpack_orientation(vec3_load(state->positions, get_slot(world, body) + 1));
}

static bool may_sleep(const tulle_world *world, size_t body) {
    return get_body(world, body)->body.sleep_speed > 0.0;
}

void world_note_sleep(tulle_world *world) {
    for (size_t b = 0; b < world->body_count; b++) world->has_sleep |= may_sleep(world, b);
}

/* ---- waking ---- */

void world_wake_body(const tulle_world *world, world_motion_state *state, size_t body) {
    state->rests[body].quiet_time = 0.0;
    if (!body_sleeps(state, body)) return;
    uint32_t const group = state->rests[body].group;
    for (size_t b = 0; b < world->body_count; b++) {
        body_rest *const rest = &state->rests[b];
        if (rest->state != BODY_SLEEPS || rest->group != group) continue;
        rest->state = BODY_FREE;
        rest->quiet_time = 0.0;
    }
}

void world_wake_all(const tulle_world *world, world_motion_state *state) {
    for (size_t b = 0; b < world->body_count; b++) {
        state->rests[b].quiet_time = 0.0;
        if (body_sleeps(state, b)) state->rests[b].state = BODY_FREE;
    }
}

/* [m] Box of some vertices at two times. */
typedef struct swept_box {
    double low[3], high[3];
} swept_box;

static swept_box sweep_box(const surface_range *range, const double *start, const double *end) {
    double const most = (double)INFINITY;
    swept_box box = {{most, most, most}, {-most, -most, -most}};
    for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
        for (size_t c = 0; c < 3; c++) {
            box.low[c] = fmin(box.low[c], fmin(start[3 * v + c], end[3 * v + c]));
            box.high[c] = fmax(box.high[c], fmax(start[3 * v + c], end[3 * v + c]));
        }
    }
    return box;
}

static bool boxes_are_near(const swept_box *a, const swept_box *b, double distance) {
    for (size_t c = 0; c < 3; c++)
        if (a->low[c] > b->high[c] + distance || b->low[c] > a->high[c] + distance) return false;
    return true;
}

/* Whether an obstacle that is no free body moves in this substep. */
static bool is_on_the_way(const step_context *context, const surface_range *range) {
    if (range->is_static || range->is_body || !range->is_present) return false;
    size_t const begin = 3 * (size_t)range->vertex_begin, end = 3 * (size_t)range->vertex_end;
    return memcmp(context->world->targets + begin, context->state->positions + begin,
                  (end - begin) * sizeof(double)) != 0;
}

static void mark_sleepers(const tulle_world *world, const world_motion_state *state) {
    for (size_t b = 0; b < world->body_count; b++)
        world->surfaces[get_surface(world, b)].is_asleep = body_sleeps(state, b);
}

void world_wake_near_script(step_context *context) {
    tulle_world *const world = context->world;
    world_motion_state *const state = context->state;
    if (!world->has_sleep) return;
    for (size_t i = 0; i < world->obstacles.count; i++) {
        surface_range const *const range = &world->surfaces[world->cloths.count + i];
        if (!is_on_the_way(context, range)) continue;
        swept_box const way = sweep_box(range, state->positions, world->targets);
        for (size_t b = 0; b < world->body_count; b++) {
            swept_box const own = sweep_box(&world->surfaces[get_surface(world, b)],
                                            state->positions, state->positions);
            if (boxes_are_near(&own, &way, world->separation_distance))
                world_wake_body(world, state, b);
        }
    }
    mark_sleepers(world, state);
}

/* What cloth presses on a sleeper with, as an impulse [N s] and its moment [N m s]. */
typedef struct body_press {
    vec3 impulse, moment;
    bool by_body; /* a body that is awake takes part */
} body_press;

/* The sleeper or other body that a side of a row lies on, or TULLE_NONE. */
static uint32_t find_side(const tulle_world *world, const contact_row *row, int side) {
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == side && row->frame.vertices[k] >= world->cloth_vertex_count)
            return world->surface_bodies[world->vertex_surface[row->frame.vertices[k]]];
    return TULLE_NONE;
}

static bool is_of_cloth(const tulle_world *world, const contact_row *row, int side) {
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == side && row->frame.vertices[k] < world->cloth_vertex_count)
            return true;
    return false;
}

/* The point of a side now. */
static vec3 find_side_point(const step_context *context, const contact_row *row, int side) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == side)
            sum = vec3_add_scaled(sum, vec3_load(context->state->positions, row->frame.vertices[k]),
                                  fabs(row->frame.weights[k]));
    return sum;
}

static void add_press(const step_context *context, const contact_row *row, int side,
                      body_press *press) {
    vec3 const impulse = vec3_scale(row->solve.impulse, side == 0 ? 1.0 : -1.0);
    size_t const slot = get_slot(context->world, find_side(context->world, row, side));
    vec3 const arm = vec3_sub(find_side_point(context, row, 1 - side),
                              vec3_load(context->state->positions, slot));
    press->impulse = vec3_add(press->impulse, impulse);
    press->moment = vec3_add(press->moment, vec3_cross(arm, impulse));
}

/* What cloth presses on each body with, and whether other bodies that are awake do; in the scratch
 * arena, null for want of memory. */
static body_press *collect_presses(const step_context *context) {
    tulle_world *const world = context->world;
    body_press *const presses = ARENA_NEW_ZEROED(&world->scratch, body_press, world->body_count);
    for (size_t i = 0; presses && i < world->rows.rows.count; i++) {
        contact_row const *const row = &world->rows.rows.data[i];
        if (!(vec3_norm2(row->solve.impulse) > 0.0)) continue;
        for (int side = 0; side < 2; side++) {
            uint32_t const body = find_side(world, row, side);
            uint32_t const other = find_side(world, row, 1 - side);
            if (body == TULLE_NONE) continue;
            if (is_of_cloth(world, row, 1 - side)) add_press(context, row, side, &presses[body]);
            presses[body].by_body |=
                other != TULLE_NONE && context->state->rests[other].state == BODY_FREE;
        }
    }
    return presses;
}

/* [kg] What a push by cloth moves: a body and those that it carries, whose weight is what cloth
 * pressed on it with against gravity when it fell asleep. */
static double find_carried_mass(const step_context *context, size_t body) {
    vec3 const gravity = context->scene.gravity;
    vec3 const force = vec3_load(context->state->rests[body].force, 0);
    double const own = get_body(context->world, body)->rigid.mass, norm2 = vec3_norm2(gravity);
    return norm2 > 0.0 ? fmax(own, -vec3_dot(force, gravity) / norm2) : own;
}

/* [m/s] By how much a sleeper would be faster than at rest after this substep, with all that it
 * carries: the inertia of a stack is more than this share of its own, so it is found to turn
 * sooner than it does. */
static double find_change(const step_context *context, size_t body, const body_press *press) {
    tulle_world const *const world = context->world;
    world_obstacle const *const obstacle = get_body(world, body);
    body_rest const *const rest = &context->state->rests[body];
    double const h = context->time_step, whole = h / world->system.force_time;
    vec3 const force = vec3_load(rest->force, 0), torque = vec3_load(rest->torque, 0);
    vec3 const push = vec3_add_scaled(vec3_scale(press->impulse, whole), force, -h);
    vec3 const turn = vec3_add_scaled(vec3_scale(press->moment, whole), torque, -h);
    mat3 const inverse = rigid_compute_inverse_inertia(
        &obstacle->rigid, get_orientation(context->state, world, body));
    double const own_share = obstacle->rigid.mass / find_carried_mass(context, body);
    return own_share * (vec3_norm(push) / obstacle->rigid.mass +
                        vec3_norm(mat3_multiply_vec3(&inverse, turn)) * obstacle->radius);
}

tulle_status world_wake_pressed(step_context *context) {
    tulle_world *const world = context->world;
    context->has_woken = false;
    if (!world->has_sleep) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&world->scratch);
    body_press const *const presses = collect_presses(context);
    if (!presses) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t b = 0; b < world->body_count; b++) {
        if (!body_sleeps(context->state, b)) continue;
        bool const is_pressed = presses[b].by_body || find_change(context, b, &presses[b]) >
                                                          get_body(world, b)->body.sleep_speed;
        if (!is_pressed) continue;
        world_wake_body(world, context->state, b);
        context->has_woken = true;
    }
    arena_release(&world->scratch, mark);
    return TULLE_OK;
}

/* ---- contacts that no row tells of ---- */

static uint32_t find_owner(const tulle_world *world, uint32_t kind, uint32_t feature,
                           bool is_second) {
    uint32_t vertex = feature;
    if (kind == FEATURE_EDGE_EDGE)
        vertex = world->topo.edges[2 * (size_t)feature];
    else if (is_second)
        vertex = world->topo.triangles[3 * (size_t)feature];
    return world->vertex_surface[vertex];
}

static bool is_resting(const tulle_world *world, const stored_contact *contact) {
    size_t const a = find_owner(world, contact->kind, contact->first, false);
    size_t const b = find_owner(world, contact->kind, contact->second, true);
    bool const has_sleeper = world->surfaces[a].is_asleep || world->surfaces[b].is_asleep;
    return has_sleeper && !surfaces_may_meet(&world->set, a, b);
}

tulle_status world_keep_resting(step_context *context) {
    tulle_world *const world = context->world;
    contact_store const *const store = &context->state->contacts;
    context->resting_count = 0;
    if (!world->has_sleep) return TULLE_OK;
    context->resting = ARENA_NEW(&world->scratch, stored_contact, store->contacts.count);
    if (!context->resting) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < store->contacts.count; i++) {
        if (!is_resting(world, &store->contacts.data[i])) continue;
        stored_contact *const kept = &context->resting[context->resting_count++];
        *kept = store->contacts.data[i];
        for (int k = 0; k < 3; k++) kept->impulse[k] *= context->time_step / store->time_step;
    }
    return TULLE_OK;
}

/* ---- falling asleep ---- */

/* A tree of bodies that touch: index of another of them, or its own where it stands for all. */
static uint32_t find_root(uint32_t *parents, uint32_t body) {
    while (parents[body] != body) {
        parents[body] = parents[parents[body]];
        body = parents[body];
    }
    return body;
}

/* The root of each body is the lowest of those it touches, directly or over others. */
static void join_bodies(const step_context *context, uint32_t *parents) {
    tulle_world const *const world = context->world;
    body_rest const *const rests = context->state->rests;
    for (uint32_t b = 0; b < world->body_count; b++) parents[b] = b;
    for (size_t i = 0; i < world->rows.rows.count; i++) {
        contact_row const *const row = &world->rows.rows.data[i];
        uint32_t const first = find_side(world, row, 0), second = find_side(world, row, 1);
        if (first == TULLE_NONE || second == TULLE_NONE) continue;
        if (rests[first].state == BODY_SCRIPTED || rests[second].state == BODY_SCRIPTED) continue;
        uint32_t const a = find_root(parents, first), b = find_root(parents, second);
        parents[a > b ? a : b] = a > b ? b : a;
    }
}

/* Counts on while a body is slow; whether it has been for long enough. */
static bool count_quiet_time(const step_context *context, size_t body, double time_step) {
    tulle_world const *const world = context->world;
    world_motion_state const *const state = context->state;
    world_obstacle const *const obstacle = get_body(world, body);
    body_rest *const rest = &state->rests[body];
    if (rest->state == BODY_SLEEPS) return true;
    if (rest->state != BODY_FREE || !may_sleep(world, body) ||
        !world->surfaces[get_surface(world, body)].is_present)
        return false;
    size_t const slot = get_slot(world, body);
    double const speed =
        vec3_norm(vec3_load(state->velocities, slot)) +
        vec3_norm(vec3_load(state->velocities, slot + 1)) * obstacle->radius; /* of any point */
    rest->quiet_time = speed <= obstacle->body.sleep_speed ? rest->quiet_time + time_step : 0.0;
    return rest->quiet_time >= obstacle->body.sleep_time;
}

static void fall_asleep(step_context *context, size_t body, uint32_t group,
                        const body_press *press) {
    tulle_world *const world = context->world;
    world_motion_state *const state = context->state;
    surface_range const *const range = &world->surfaces[get_surface(world, body)];
    size_t const begin = range->vertex_begin;
    body_rest *const rest = &state->rests[body];
    double const rate = 1.0 / context->time_step;
    rest->state = BODY_SLEEPS;
    rest->group = group;
    vec3_store(rest->force, 0, vec3_scale(press->impulse, rate));
    vec3_store(rest->torque, 0, vec3_scale(press->moment, rate));
    world_sum_contact_impulses(&world->rows, get_slot(world, body), rest->impulse, rest->moment);
    memset(state->velocities + 3 * get_slot(world, body), 0, 6 * sizeof(double));
    memset(state->velocities + 3 * begin, 0, 3 * (range->vertex_end - begin) * sizeof(double));
}

tulle_status world_settle_bodies(step_context *context, double time_step) {
    tulle_world *const world = context->world;
    if (!world->has_sleep) return TULLE_OK;
    size_t const count = world->body_count;
    uint32_t *const parents = ARENA_NEW(&world->scratch, uint32_t, count);
    bool *const is_awake = ARENA_NEW_ZEROED(&world->scratch, bool, count);
    body_press const *const presses = collect_presses(context);
    if (!parents || !is_awake || !presses)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for bodies");
    join_bodies(context, parents);
    for (uint32_t b = 0; b < count; b++)
        if (!count_quiet_time(context, b, time_step)) is_awake[find_root(parents, b)] = true;
    for (uint32_t b = 0; b < count; b++) {
        uint32_t const root = find_root(parents, b);
        if (is_awake[root] || body_sleeps(context->state, b)) continue;
        fall_asleep(context, b, root, &presses[b]);
    }
    return TULLE_OK;
}
