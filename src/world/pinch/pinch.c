/* world/pinch/pinch.c - what happens when a step can move on no further, or tears cloth that is
 * squeezed.
 *
 * Cloth alone can always stand still. So only scripted vertices (obstacles, pins) that go where
 * cloth has no room can block a step. Obstacles that close on cloth tear it before they block the
 * step: the rows of each side push the cloth into the other side. Either way the step is undone,
 * and the message names the cloth and the obstacles around the place. Then on_pinch decides:
 * - stop: the step is an error.
 * - slow: those obstacles are held back (see holds.h), and the step is made anew. */
#include "base/error.h"
#include "world/bodies/bodies_sleep.h"
#include "world/lag/lag.h"
#include "world/pinch/holds.h"
#include "world/pinch/pinch_sides.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Obstacles that come nearer by at most this share of the minimum gap in a step count as still. */
static const double APPROACH_SHARE = 1e-6;

/* The way of an obstacle may differ by at most acos of this from the direction across the cloth.
 * Then the obstacle is held back along its way, and motion at right angles to that way does not
 * change the gap. */
static const double STRAIGHT_COSINE = 0.99;

/* Obstacles that pinch one layer of cloth may come to this many contact distances from each other.
 * Nearer ones part to there. The cloth rests between them, a little pressed. */
static const double CLOSED_DISTANCES = 1.5;

/* Two sides of cloth face each other when the cosine between their directions is under this. */
static const double OPPOSED_COSINE = -0.5;

/* What a step that is pinched again and again holds back. */
enum {
    LEVEL_CLOSED = 1, /* obstacles apart, but closed on one layer of cloth */
    LEVEL_APART,      /* as far apart as they were */
    LEVEL_STILL       /* wholly; after it, all that follows a script */
};

bool world_is_script_moving(const step_context *context) {
    const tulle_world *const world = context->world;
    if (context->is_script_frozen) return false;
    for (size_t v = 0; v < world->model.vertex_count; v++) {
        if (world->work.active_inverse_masses[v] != 0.0) continue;
        if (memcmp(world->work.targets + 3 * v, context->state->positions + 3 * v,
                   3 * sizeof(double)) != 0) {
            return true;
        }
    }
    return false;
}

void world_stand_still(step_context *context) {
    size_t const vertices =
        context->world->model.cloth_vertex_count + 2 * context->world->model.body_count;
    size_t const bytes = 3 * vertices * sizeof(double);
    memset(context->state->velocities, 0, bytes);
    context->state->previous_time_step = 0.0;
}

/* ---- messages ---- */

/* Writes the names of marked obstacles, as many as there is room for. Returns how many are marked.
 */
static size_t list_names(const tulle_world *world, const uint8_t *is_marked, char *text,
                         size_t size) {
    static const char others[] = " and others";
    size_t length = 0, count = 0;
    bool is_full = false;
    text[0] = '\0';
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        if (!is_marked[i]) continue;
        const char *const name = world->model.obstacles.data[i].name;
        const char *const separator = count++ > 0 ? ", " : "";
        if (is_full) continue;
        is_full = length + strlen(separator) + strlen(name) + 2 + sizeof others > size;
        length +=
            (size_t)(is_full ? snprintf(text + length, size - length, "%s", others)
                             : snprintf(text + length, size - length, "%s'%s'", separator, name));
    }
    return count;
}

/* Marks the obstacles, other than the body itself, whose vertices are beside one of the body. */
static void mark_touched(const tulle_world *world, uint32_t body, const uint32_t vertices[4],
                         uint8_t *is_near) {
    bool has_body = false;
    for (int k = 0; k < 4; k++) has_body |= world->model.vertex_surface[vertices[k]] == body;
    for (int k = 0; k < 4 && has_body; k++) {
        uint32_t const surface = world->model.vertex_surface[vertices[k]];
        if (surface != body && surface >= world->model.cloths.count)
            is_near[surface - world->model.cloths.count] = 1;
    }
}

static void write_message(step_context *context, const blocked_place *place, uint8_t *is_near,
                          const char *consequence) {
    const tulle_world *const world = context->world;
    char names[WORLD_MESSAGE_BYTES / 4];
    /* A body: all obstacles that it touches, by rows and by the pair of the place. */
    bool const is_body = place->surface >= world->model.cloths.count;
    for (size_t i = 0; is_body && i < world->work.rows.rows.count; i++)
        mark_touched(world, place->surface, world->work.rows.rows.data[i].frame.vertices, is_near);
    if (is_body && place->is_pair) mark_touched(world, place->surface, place->vertices, is_near);
    size_t const count = list_names(world, is_near, names, sizeof names);
    const char *const name = world_surface_name(world, place->surface);
    /* cloth: the pin that moves nearest to the place, and whether others move */
    char pins[80] = "";
    size_t named = 0, moving = 0;
    double nearest = (double)INFINITY;
    const world_cloth *const cloth = is_body ? NULL : &world->model.cloths.data[place->surface];
    for (size_t p = 0; cloth && p < cloth->pin_count; p++) {
        bool moves = false;
        for (size_t k = 0; k < cloth->pins[p].vertex_count; k++) {
            size_t const v = cloth->vertex_begin + cloth->pins[p].vertices[k];
            vec3 const target = vec3_load(world->work.targets, v);
            if (!world->work.is_fixed[v] ||
                vec3_norm(vec3_sub(target, vec3_load(world->now.positions, v))) == 0.0)
                continue;
            double const distance = vec3_norm(vec3_sub(target, place->position));
            moves = true;
            if (distance < nearest) named = p;
            nearest = fmin(nearest, distance);
        }
        moving += moves;
    }
    if (moving > 0)
        snprintf(pins, sizeof pins, ", dragged by its pin number %zu%s", named,
                 moving > 1 ? " and others" : "");
    snprintf(context->pinch_message, sizeof context->pinch_message,
             "'%s' is pinched near (%.6g, %.6g, %.6g) m at %.6g s, %s %s%s; %s", name,
             place->position.x, place->position.y, place->position.z, context->state->time,
             count == 1 ? "by" : "between", count > 0 ? names : "pins and other cloth", pins,
             consequence);
}

static void append_message(tulle_world *world, const char *text) {
    size_t const length = strlen(world->message);
    snprintf(world->message + length, sizeof world->message - length, "%s%s",
             length > 0 ? ". " : "", text);
}

tulle_status world_end_pinch(step_context *context) {
    tulle_world *const world = context->world;
    size_t const count = world->model.obstacles.count;
    uint8_t *const has_ended = ARENA_NEW_ZEROED(&world->work.scratch, uint8_t, count + 1);
    if (!has_ended)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for a pinch");
    world_end_holds(context);
    bool has_begun = false, any_ended = false;
    for (size_t i = 0; i <= count; i++) {
        bool const was = world_is_held(world, &world->now, i);
        bool const is = world_is_held(world, context->state, i);
        if (was || is) context->report->pinched = 1;
        has_begun |= is && !was;
        has_ended[i] = was && !is;
        any_ended |= was && !is;
    }
    if (has_begun) append_message(world, context->pinch_message);
    if (!any_ended) return TULLE_OK;
    char names[WORLD_MESSAGE_BYTES / 2], text[WORLD_MESSAGE_BYTES];
    size_t const named = list_names(world, has_ended, names, sizeof names);
    snprintf(text, sizeof text, "%s %s again at %.6g s: the cloth is pinched no more",
             named > 0 ? names : "all pins and obstacles",
             named == 1 ? "follows its script" : "follow their script", context->state->time);
    append_message(world, text);
    return TULLE_OK;
}

/* ---- slow ---- */

/* [m] How far the script moves the point of an obstacle in this step. Zero for static obstacles and
 * bodies, which are not held. */
static vec3 get_way(const step_context *context, size_t obstacle, const pinch_side *side) {
    const tulle_world *const world = context->world;
    vec3 way = {0, 0, 0};
    if (world->model.surfaces[world->model.cloths.count + obstacle].is_static ||
        world_may_lag(world, obstacle) || world->model.obstacles.data[obstacle].body.is_dynamic)
        return way;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = side->points[k];
        vec3 const step =
            vec3_sub(vec3_load(world->work.targets, v), vec3_load(world->now.positions, v));
        way = vec3_add(way, vec3_scale(step, side->weights[k]));
    }
    return way;
}

/* Holds two obstacles apart, or one from what is fixed (pair[1]: SIZE_MAX). False when neither
 * moves towards the other, or when there are too many holds. */
static bool hold_apart(step_context *context, const blocked_place *place, const pinch_side *sides,
                       const size_t pair[2]) {
    const tulle_world *const world = context->world;
    bool const has_second = pair[1] != SIZE_MAX;
    const pinch_side *const a = &sides[pair[0]];
    vec3 normal = a->direction, second_way = {0, 0, 0};
    vec3 const first_way = get_way(context, pair[0], a);
    if (has_second) {
        normal = vec3_normalize(vec3_sub(a->direction, sides[pair[1]].direction));
        second_way = get_way(context, pair[1], &sides[pair[1]]);
    }
    vec3 const way = vec3_sub(first_way, second_way);
    if (vec3_dot(way, normal) > STRAIGHT_COSINE * vec3_norm(way)) normal = vec3_normalize(way);
    world_hold hold = {
        .kind = HOLD_APART, .cloth = place->surface, .obstacles = {TULLE_NONE, TULLE_NONE}};
    double const first = fmax(0.0, vec3_dot(first_way, normal));
    double const second = fmax(0.0, -vec3_dot(second_way, normal));
    if (!(first + second > APPROACH_SHARE * world->model.minimum_gap)) return false;
    hold.share = first / (first + second);
    for (int k = 0; k < (has_second ? 2 : 1); k++) {
        const pinch_side *const side = &sides[pair[k]];
        hold.obstacles[k] = (uint32_t)pair[k];
        memcpy(hold.points[k], side->points, sizeof side->points);
        memcpy(hold.weights[k], side->weights, sizeof side->weights);
    }
    vec3_store(hold.normal, 0, normal);
    hold.gap = vec3_dot(normal, vec3_sub(world_get_hold_point(&hold, 1, world->now.positions),
                                         world_get_hold_point(&hold, 0, world->now.positions)));
    double const closed = CLOSED_DISTANCES * world->model.contact_distance;
    hold.wanted_gap = has_second ? fmax(hold.gap, closed) : hold.gap;
    if (has_second && context->pinch_level == LEVEL_CLOSED && hold.gap > closed)
        hold.gap = hold.wanted_gap = fmax(closed, hold.gap - first - second);
    return world_add_hold(context->state, &hold);
}

/* Holds apart the obstacles around the place that come nearer to each other, or to what is fixed.
 * False when there are none. */
static bool hold_obstacles_apart(step_context *context, const blocked_place *place,
                                 const pinch_side *sides) {
    size_t const count = context->world->model.obstacles.count;
    bool has_any = false;
    for (size_t i = 0; i < count; i++) {
        bool has_partner = false;
        for (size_t j = 0; j < count && sides[i].has_direction; j++) {
            if (j == i || !sides[j].has_direction ||
                vec3_dot(sides[i].direction, sides[j].direction) > OPPOSED_COSINE)
                continue;
            has_partner = true;
            if (i < j) has_any |= hold_apart(context, place, sides, (size_t[2]){i, j});
        }
        if (sides[i].has_direction && !has_partner)
            has_any |= hold_apart(context, place, sides, (size_t[2]){i, SIZE_MAX});
    }
    return has_any;
}

/* Holds back more each time the step is made anew. */
static void hold_back(step_context *context, const blocked_place *place, const pinch_side *sides) {
    const tulle_world *const world = context->world;
    if (world_delay_holds(context->state)) return;
    context->pinch_level++;
    if (context->pinch_level <= LEVEL_APART && hold_obstacles_apart(context, place, sides)) return;
    if (context->pinch_level < LEVEL_STILL) context->pinch_level = LEVEL_STILL;
    bool has_still = false;
    for (size_t i = 0; context->pinch_level == LEVEL_STILL && i < world->model.obstacles.count;
         i++) {
        const surface_range *const range = &world->model.surfaces[world->model.cloths.count + i];
        bool const is_body = world->model.obstacles.data[i].body.is_dynamic;
        if (!sides[i].is_near || range->is_static || is_body || world_may_lag(world, i)) continue;
        world_hold still = {.kind = HOLD_STILL, .cloth = place->surface};
        still.obstacles[0] = (uint32_t)i;
        still.obstacles[1] = TULLE_NONE;
        for (int k = 0; k < 4; k++) still.points[0][k] = range->vertex_begin;
        has_still |= world_add_hold(context->state, &still);
    }
    if (has_still) return;
    world_hold const all = {
        .kind = HOLD_ALL, .cloth = place->surface, .obstacles = {TULLE_NONE, TULLE_NONE}};
    if (world_add_hold(context->state, &all)) return;
    context->state->hold_count = 0;
    (void)world_add_hold(context->state, &all);
}

/* ---- the choice ---- */

tulle_status world_handle_pinch(step_context *context) {
    tulle_world *const world = context->world;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    pinch_side *const sides =
        ARENA_NEW_ZEROED(&world->work.scratch, pinch_side, world->model.obstacles.count + 1);
    uint8_t *const is_near = ARENA_NEW(&world->work.scratch, uint8_t, world->model.obstacles.count);
    if (!sides || !is_near)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for a pinch");
    blocked_place const place =
        context->outcome == SUBSTEP_TORN ? context->torn_place : world_find_blocked_place(context);
    world_measure_pinch_sides(world, &place, sides);
    /* Targets at the end of the whole step, where the script alone has them. */
    double const start = world->now.time;
    tulle_status status =
        world_script_targets(world, start, start + context->whole_step, context->error);
    if (status != TULLE_OK) {
        arena_release(&world->work.scratch, mark);
        return status;
    }
    for (size_t i = 0; i < world->model.obstacles.count; i++) is_near[i] = sides[i].is_near;
    bool helps_lag = false;
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        helps_lag |= sides[i].is_near && world_may_lag(world, i);
    if (helps_lag && world_feel_pinch(context, &place)) {
        write_message(context, &place, is_near, "it has no room there");
    } else if (world->model.def.on_pinch == TULLE_ON_PINCH_SLOW) {
        write_message(context, &place, is_near, "scripted motion waits (on_pinch: slow)");
        hold_back(context, &place, sides);
    } else {
        write_message(context, &place, is_near,
                      "give it room, take shorter steps if the obstacle is fast, or set on_pinch "
                      "to slow");
        context->report->pinched = 1;
        append_message(world, context->pinch_message);
        status = error_set(context->error, TULLE_ERROR_PINCHED, "%s", context->pinch_message);
    }
    arena_release(&world->work.scratch, mark);
    return status;
}
