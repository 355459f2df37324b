/* world/pinch.c - what happens when a step can move on no further.
 *
 * Cloth alone can always stand still, so only scripted vertices (obstacles, pins) that go where
 * cloth has no room can block a step. The message names the cloth and the obstacles around the pair
 * that blocked; then on_pinch decides: stop (an error), slow (scripted motion waits until there is
 * room) or release (the moving obstacles around it let the cloth through until they are free of it
 * again). */
#include "base/error.h"
#include "world/bodies_sleep.h"

#include <stdio.h>
#include <string.h>

/* Cloth vertices of the pair that blocked the step. */
typedef struct blocked_place {
    uint32_t vertices[4];
    uint32_t surface; /* a cloth, or the surface of the first vertex */
    vec3 position;    /* [m] of one of them */
} blocked_place;

static blocked_place find_blocked_place(const step_context *context) {
    tulle_world const *const world = context->world;
    commit_report const *const commit = &context->blocked;
    blocked_place place = {0};
    if (!commit->has_blocking) return place;
    feature_pair_vertices(&world->topo, commit->blocking_kind, commit->blocking_pair,
                          place.vertices);
    uint32_t chosen = place.vertices[0];
    for (int k = 3; k >= 0; k--) {
        if (place.vertices[k] < world->cloth_vertex_count) chosen = place.vertices[k];
    }
    place.surface = world->vertex_surface[chosen];
    place.position = vec3_load(context->state->positions, chosen);
    return place;
}

/* Whether a row touches a vertex of the place or one of its neighbours. */
static bool row_is_near(const tulle_world *world, const contact_row *row,
                        const blocked_place *place) {
    adjacency const *const around = &world->topo.vertex_neighbours;
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = place->vertices[k];
        for (int j = 0; j < 4; j++) {
            if (row->vertices[j] == vertex) return true;
            for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
                if (around->items[i] == row->vertices[j]) return true;
            }
        }
    }
    return false;
}

/* Marks obstacles that touch the cloth at the place. */
static void mark_obstacles(const step_context *context, const blocked_place *place,
                           uint8_t *is_near) {
    tulle_world const *const world = context->world;
    size_t const cloth_count = world->cloths.count;
    memset(is_near, 0, world_surface_count(world));
    for (int k = 0; k < 4; k++) is_near[world->vertex_surface[place->vertices[k]]] = 1;
    for (size_t i = 0; i < world->rows.rows.count; i++) {
        contact_row const *const row = &world->rows.rows.data[i];
        if (!row_is_near(world, row, place)) continue;
        for (int k = 0; k < 4; k++) is_near[world->vertex_surface[row->vertices[k]]] = 1;
    }
    memset(is_near, 0, cloth_count);
}

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

static void write_message(const step_context *context, const blocked_place *place,
                          const uint8_t *is_near, const char *consequence) {
    tulle_world *const world = context->world;
    char names[WORLD_MESSAGE_BYTES / 2] = "";
    size_t length = 0, name_count = 0;
    for (size_t s = world->cloths.count; s < world_surface_count(world); s++) {
        if (!is_near[s] || length >= sizeof names) continue;
        length += (size_t)snprintf(names + length, sizeof names - length, "%s'%s'",
                                   length > 0 ? ", " : "", world_surface_name(world, s));
        name_count++;
    }
    snprintf(world->message, sizeof world->message,
             "'%s' is pinched near (%.6g, %.6g, %.6g) m at %.6g s, %s %s; %s",
             world_surface_name(world, place->surface), place->position.x, place->position.y,
             place->position.z, context->state->time, name_count == 1 ? "by" : "between",
             names[0] ? names : "pins and other cloth", consequence);
}

/* on_pinch: release. False when no moving obstacle is near. */
static bool release_obstacles(step_context *context, const uint8_t *is_near) {
    tulle_world *const world = context->world;
    bool has_released = false;
    for (size_t i = 0; i < world->obstacles.count; i++) {
        surface_range *const range = &world->surfaces[world->cloths.count + i];
        if (!is_near[world->cloths.count + i] || range->is_static) continue;
        context->state->is_released[i] = 1;
        context->state->is_present[i] = 0;
        range->is_present = false;
        has_released = true;
    }
    if (has_released) world_wake_all(context->world, context->state);
    return has_released;
}

/* Cloth and bodies stand still for the rest of the step. */
static void skip_rest(step_context *context) {
    size_t const vertices = context->world->cloth_vertex_count + 2 * context->world->body_count;
    size_t const bytes = 3 * vertices * sizeof(double);
    memset(context->state->velocities, 0, bytes);
    context->state->previous_time_step = 0.0;
    context->is_rest_skipped = true;
}

tulle_status world_handle_pinch(step_context *context) {
    tulle_world *const world = context->world;
    if (!world_is_script_moving(context)) {
        skip_rest(context);
        return TULLE_OK;
    }
    arena_mark const mark = arena_get_mark(&world->scratch);
    uint8_t *const is_near = ARENA_NEW(&world->scratch, uint8_t, world_surface_count(world));
    if (!is_near) {
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for a pinch");
    }
    blocked_place const place = find_blocked_place(context);
    mark_obstacles(context, &place, is_near);
    context->report->pinched = 1;
    tulle_status status = TULLE_OK;
    if (world->def.on_pinch == TULLE_ON_PINCH_SLOW) {
        write_message(context, &place, is_near, "scripted motion waits (on_pinch: slow)");
        context->is_script_frozen = true;
    } else if (world->def.on_pinch == TULLE_ON_PINCH_RELEASE &&
               release_obstacles(context, is_near)) {
        write_message(
            context, &place, is_near,
            "the moving ones let it through until they are free of it (on_pinch: release)");
    } else {
        write_message(
            context, &place, is_near,
            "give it room, take shorter steps if the obstacle is fast, or set on_pinch to "
            "slow or release");
        status = error_set(context->error, TULLE_ERROR_PINCHED, "%s", world->message);
    }
    arena_release(&world->scratch, mark);
    return status;
}
