/* world/pinch/pinch.c - what happens when a step can move on no further, or tears cloth that is
 * squeezed.
 *
 * Cloth alone can always stand still, so only scripted vertices (obstacles, pins) that go where
 * cloth has no room can block a step. Before it blocks, cloth between obstacles that close on it is
 * torn: rows of both sides push it where neither lets it. Either way the step is undone and the
 * message names the cloth and the obstacles around the place; then on_pinch decides: stop (an
 * error), slow (those obstacles are held back, see holds.h) or release (the moving ones among them
 * let the cloth through until they are free of it again), and the step is made anew. */
#include "base/error.h"
#include "world/bodies/bodies_sleep.h"
#include "world/pinch/holds.h"
#include "world/pinch/pinch_sides.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* An obstacle is moving nearer when it does so by this share of the minimum gap in a step. */
static const double APPROACH_SHARE = 1e-6;

/* What comes nearer in a direction within acos of this of that across the cloth is held back along
 * its way: then what goes at right angles to it does not change the gap. */
static const double STRAIGHT_COSINE = 0.99;

/* Obstacles that pinch one layer of cloth are let come to this many contact distances from each
 * other, or part to there: it rests between them, a little pressed. */
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
    tulle_world const *const world = context->world;
    if (context->is_script_frozen) return false;
    for (size_t v = 0; v < world->vertex_count; v++) {
        if (world->active_inverse_masses[v] != 0.0) continue;
        if (memcmp(world->targets + 3 * v, context->state->positions + 3 * v, 3 * sizeof(double)) !=
            0) {
            return true;
        }
    }
    return false;
}

void world_stand_still(step_context *context) {
    size_t const vertices = context->world->cloth_vertex_count + 2 * context->world->body_count;
    size_t const bytes = 3 * vertices * sizeof(double);
    memset(context->state->velocities, 0, bytes);
    context->state->previous_time_step = 0.0;
}

/* ---- messages ---- */

/* The names of obstacles that are marked, as many as there is room for; how many are marked. */
static size_t list_names(const tulle_world *world, const uint8_t *is_marked, char *text,
                         size_t size) {
    static const char others[] = " and others";
    size_t length = 0, count = 0;
    bool is_full = false;
    text[0] = '\0';
    for (size_t i = 0; i < world->obstacles.count; i++) {
        if (!is_marked[i]) continue;
        const char *const name = world->obstacles.data[i].name;
        const char *const separator = count++ > 0 ? ", " : "";
        if (is_full) continue;
        is_full = length + strlen(separator) + strlen(name) + 2 + sizeof others > size;
        length +=
            (size_t)(is_full ? snprintf(text + length, size - length, "%s", others)
                             : snprintf(text + length, size - length, "%s'%s'", separator, name));
    }
    return count;
}

/* Marks the obstacles of the vertices of a contact with a body, but for the body itself. */
static void mark_others(const tulle_world *world, const uint32_t vertices[4], uint32_t body,
                        uint8_t *is_near) {
    bool has_body = false;
    for (int k = 0; k < 4; k++) has_body |= world->vertex_surface[vertices[k]] == body;
    for (int k = 0; k < 4 && has_body; k++) {
        uint32_t const surface = world->vertex_surface[vertices[k]];
        if (surface != body && surface >= world->cloths.count)
            is_near[surface - world->cloths.count] = 1;
    }
}

static void write_message(step_context *context, const blocked_place *place,
                          const pinch_side *sides, const char *consequence) {
    tulle_world *const world = context->world;
    char names[WORLD_MESSAGE_BYTES / 4];
    uint8_t *const is_near = ARENA_NEW(&world->scratch, uint8_t, world->obstacles.count);
    if (!is_near) return;
    for (size_t i = 0; i < world->obstacles.count; i++) is_near[i] = sides[i].is_near;
    if (place->surface >= world->cloths.count) { /* a body: all that it touches */
        for (size_t i = 0; i < world->rows.rows.count; i++)
            mark_others(world, world->rows.rows.data[i].frame.vertices, place->surface, is_near);
        if (place->is_pair) mark_others(world, place->vertices, place->surface, is_near);
    }
    size_t const count = list_names(world, is_near, names, sizeof names);
    snprintf(context->pinch_message, sizeof context->pinch_message,
             "'%s' is pinched near (%.6g, %.6g, %.6g) m at %.6g s, %s %s; %s",
             world_surface_name(world, place->surface), place->position.x, place->position.y,
             place->position.z, context->state->time, count == 1 ? "by" : "between",
             count > 0 ? names : "pins and other cloth", consequence);
}

static bool is_special(const tulle_world *world, const world_motion_state *state, size_t i) {
    return world_is_held(world, state, i) ||
           (i < world->obstacles.count && state->is_released[i] != 0);
}

static void append_message(tulle_world *world, const char *text) {
    size_t const length = strlen(world->message);
    snprintf(world->message + length, sizeof world->message - length, "%s%s",
             length > 0 ? ". " : "", text);
}

tulle_status world_end_pinch(step_context *context) {
    tulle_world *const world = context->world;
    size_t const count = world->obstacles.count;
    uint8_t *const has_ended = ARENA_NEW_ZEROED(&world->scratch, uint8_t, count + 1);
    if (!has_ended)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for a pinch");
    world_end_holds(context);
    bool has_begun = false, any_ended = false;
    for (size_t i = 0; i <= count; i++) {
        bool const was = is_special(world, &world->now, i);
        bool const is = is_special(world, context->state, i);
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
             world->def.on_pinch != TULLE_ON_PINCH_RELEASE
                 ? (named == 1 ? "follows its script" : "follow their script")
                 : (named == 1 ? "meets cloth" : "meet cloth"),
             context->state->time);
    append_message(world, text);
    return TULLE_OK;
}

/* ---- slow ---- */

/* [m] Way of the point of an obstacle by its script in this step; none of what is not to be held.
 */
static vec3 get_way(const step_context *context, size_t obstacle, const pinch_side *side) {
    tulle_world const *const world = context->world;
    vec3 way = {0, 0, 0};
    if (world->surfaces[world->cloths.count + obstacle].is_static ||
        !world_may_hold(world, obstacle))
        return way;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = side->points[k];
        vec3 const step =
            vec3_sub(vec3_load(world->targets, v), vec3_load(world->now.positions, v));
        way = vec3_add(way, vec3_scale(step, side->weights[k]));
    }
    return way;
}

static void set_hold_side(world_hold *hold, int which, size_t obstacle, const pinch_side *side) {
    hold->obstacles[which] = (uint32_t)obstacle;
    memcpy(hold->points[which], side->points, sizeof side->points);
    memcpy(hold->weights[which], side->weights, sizeof side->weights);
}

/* Holds two obstacles apart, or one from what is fixed (pair[1]: SIZE_MAX); false when none of them
 * brings them nearer or there are too many holds. */
static bool hold_apart(step_context *context, const blocked_place *place, const pinch_side *sides,
                       const size_t pair[2]) {
    tulle_world const *const world = context->world;
    bool const has_second = pair[1] != SIZE_MAX;
    pinch_side const *const a = &sides[pair[0]];
    vec3 normal = a->direction, second_way = {0, 0, 0};
    vec3 const first_way = get_way(context, pair[0], a);
    if (has_second) {
        normal = vec3_normalize(vec3_sub(a->direction, sides[pair[1]].direction));
        second_way = get_way(context, pair[1], &sides[pair[1]]);
    }
    vec3 const way = vec3_sub(first_way, second_way);
    if (vec3_dot(way, normal) > STRAIGHT_COSINE * vec3_norm(way)) normal = vec3_normalize(way);
    world_hold hold = {.kind = HOLD_APART, .cloth = place->surface};
    double const first = fmax(0.0, vec3_dot(first_way, normal));
    double const second = fmax(0.0, -vec3_dot(second_way, normal));
    if (!(first + second > APPROACH_SHARE * world->minimum_gap)) return false;
    hold.share = first / (first + second);
    set_hold_side(&hold, 0, pair[0], a);
    if (has_second)
        set_hold_side(&hold, 1, pair[1], &sides[pair[1]]);
    else
        hold.obstacles[1] = TULLE_NONE;
    vec3_store(hold.normal, 0, normal);
    hold.gap = vec3_dot(normal, vec3_sub(world_get_hold_point(&hold, 1, world->now.positions),
                                         world_get_hold_point(&hold, 0, world->now.positions)));
    double const closed = CLOSED_DISTANCES * world->contact_distance;
    hold.wanted_gap = has_second ? fmax(hold.gap, closed) : hold.gap;
    if (has_second && context->pinch_level == LEVEL_CLOSED && hold.gap > closed)
        hold.gap = hold.wanted_gap = fmax(closed, hold.gap - first - second);
    return world_add_hold(context->state, &hold);
}

/* Holds for the obstacles around the place that bring one another nearer; false when there are
 * none. */
static bool hold_obstacles_apart(step_context *context, const blocked_place *place,
                                 const pinch_side *sides) {
    size_t const count = context->world->obstacles.count;
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

/* Holds more with each time that the step is made anew. */
static void hold_back(step_context *context, const blocked_place *place, const pinch_side *sides) {
    tulle_world const *const world = context->world;
    if (world_delay_holds(context->state)) return;
    context->pinch_level++;
    if (context->pinch_level <= LEVEL_APART && hold_obstacles_apart(context, place, sides)) return;
    if (context->pinch_level < LEVEL_STILL) context->pinch_level = LEVEL_STILL;
    bool has_still = false;
    for (size_t i = 0; context->pinch_level == LEVEL_STILL && i < world->obstacles.count; i++) {
        surface_range const *const range = &world->surfaces[world->cloths.count + i];
        if (!sides[i].is_near || range->is_static || !world_may_hold(world, i)) continue;
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

static bool may_release(const step_context *context, const pinch_side *sides, size_t obstacle) {
    tulle_world const *const world = context->world;
    return sides[obstacle].is_near && !world->surfaces[world->cloths.count + obstacle].is_static &&
           !context->state->is_released[obstacle];
}

/* What on_pinch says, with targets at the end of the whole step, where the script alone has them.
 */
static tulle_status choose(step_context *context, const blocked_place *place,
                           const pinch_side *sides) {
    tulle_world *const world = context->world;
    if (world->def.on_pinch == TULLE_ON_PINCH_SLOW) {
        write_message(context, place, sides, "scripted motion waits (on_pinch: slow)");
        hold_back(context, place, sides);
        return TULLE_OK;
    }
    bool helps_release = false;
    for (size_t i = 0; i < world->obstacles.count; i++)
        helps_release |= may_release(context, sides, i);
    if (world->def.on_pinch == TULLE_ON_PINCH_RELEASE && helps_release) {
        for (size_t i = 0; i < world->obstacles.count; i++)
            if (may_release(context, sides, i)) context->state->is_released[i] = 1;
        write_message(
            context, place, sides,
            "the moving ones let it through until they are free of it (on_pinch: release)");
        return TULLE_OK;
    }
    write_message(context, place, sides,
                  helps_release
                      ? "give it room, take shorter steps if the obstacle is fast, or set on_pinch "
                        "to slow or release"
                      : "give it room, take shorter steps if the obstacle is fast, or set on_pinch "
                        "to slow");
    context->report->pinched = 1;
    append_message(world, context->pinch_message);
    return error_set(context->error, TULLE_ERROR_PINCHED, "%s", context->pinch_message);
}

tulle_status world_handle_pinch(step_context *context) {
    tulle_world *const world = context->world;
    arena_mark const mark = arena_get_mark(&world->scratch);
    pinch_side *const sides =
        ARENA_NEW_ZEROED(&world->scratch, pinch_side, world->obstacles.count + 1);
    if (!sides)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for a pinch");
    blocked_place const place =
        context->outcome == SUBSTEP_TORN ? context->torn_place : world_find_blocked_place(context);
    world_find_pinch_sides(world, &place, sides);
    double const start = world->now.time;
    tulle_status status =
        world_script_targets(world, start, start + context->whole_step, context->error);
    if (status == TULLE_OK) status = choose(context, &place, sides);
    arena_release(&world->scratch, mark);
    return status;
}
