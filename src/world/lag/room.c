/* world/lag/room.c - see room.h.
 *
 * In: contacts of cloth with what may lag. From the cloth a ray goes on across it, away from the
 * surface that it touches. What the ray meets first beyond the cloth is the other side. The cloth
 * needs room there by the layers of cloth that the ray passes on its way. */
#include "world/lag/room.h"

#include "detect/queries/surface_queries.h"
#include "tulle/query.h"
#include "world/lag/lag.h"
#include "world/surface_box.h"

#include <math.h>
#include <string.h>

/* Two sides face each other when the cosine between the directions into the cloth is under this. */
static const double OPPOSED_COSINE = -0.5;
/* [contact distances] room of a layer of cloth on each of its sides: a little pressed */
static const double ROOM_OF_SIDE = 0.9;
/* [m/s] Sides that lag and are nearer than that part at this speed, as obstacles that are held. */
static const double OPENING_SPEED = 0.05;

/* ---- what lies across ---- */

/* Counts the triangles of cloth that a segment passes, without those at a vertex of the contact. */
typedef struct layer_query {
    tree_query query;
    ray_query ray;
    const tulle_world *world;
    const uint32_t *contact; /* its four vertices */
    size_t count;
} layer_query;

static void measure_layers(const tree_query *query, const query_node *node,
                           double distances[QUERY_LANES]) {
    const layer_query *const layers = (const layer_query *)query;
    layers->ray.query.measure(&layers->ray.query, node, distances);
}

static void visit_layer(tree_query *query, uint32_t triangle) {
    layer_query *const layers = (layer_query *)query;
    const uint32_t *const corners = layers->world->model.topo.triangles + 3 * (size_t)triangle;
    for (int k = 0; k < 12; k++)
        if (corners[k % 3] == layers->contact[k / 3]) return;
    ray_query ray = layers->ray;
    ray.query.visit(&ray.query, triangle);
    layers->count += ray.hit.triangle != TULLE_NONE;
}

static size_t count_layers(const tulle_world *world, const uint32_t contact[4], const double *from,
                           const double *to) {
    layer_query layers = {
        .query = {measure_layers, visit_layer, 1.0},
        .ray = ray_query_make(world->model.topo.triangles, world->now.positions, from, to, false),
        .world = world,
        .contact = contact};
    for (size_t s = 0; s < world->model.cloths.count; s++)
        query_tree_visit(&world->queries.trees[s], &layers.query);
    return layers.count + 1;
}

/* What the cloth meets across itself, farther from the side that it touches. */
static bool find_across(const tulle_world *world, size_t cloth, vec3 from, vec3 normal,
                        double reach, surface_hit *hit) {
    double ends[2][3];
    vec3_store(ends[0], 0, from);
    vec3_store(ends[1], 0, vec3_add_scaled(from, normal, reach));
    ray_query query =
        ray_query_make(world->model.topo.triangles, world->now.positions, ends[0], ends[1], false);
    for (size_t s = world->model.cloths.count; s < world->model.set.surface_count; s++)
        if (world->model.surfaces[s].is_present && !world->model.surfaces[s].is_body &&
            world_pair_collides(world, cloth, s))
            query_tree_visit(&world->queries.trees[s], &query.query);
    *hit = query.hit;
    return hit->triangle != TULLE_NONE;
}

/* [m] What a place that has the room `now` is to have: no less, and where a side lags, little by
 * little, all that the cloth needs. */
static double choose_room(const step_context *context, const room_place *place, double now,
                          double full) {
    bool opens = false;
    for (int k = 0; k < 6; k++) {
        const room_side *const side = &place->sides[k / 3];
        opens |=
            side->may_lag && vec3_norm2(world_get_lag(context->world, side->vertices[k % 3])) > 0.0;
    }
    return fmin(full, now + (opens ? OPENING_SPEED * context->whole_step : 0.0));
}

/* How far the side goes along the direction in this step, as drawn. */
static double get_advance(const tulle_world *world, const room_side *side, const double *ends,
                          vec3 direction) {
    vec3 const way =
        vec3_sub(get_side_point(side, ends), get_side_point(side, world->now.positions));
    return side->may_lag ? fmax(0.0, vec3_dot(way, direction)) : 0.0;
}

/* Unit normal of a triangle, on the side of `way`. */
static vec3 measure_facing(const tulle_world *world, const uint32_t corners[3], vec3 way) {
    const double *const positions = world->now.positions;
    vec3 const a = vec3_load(positions, corners[0]);
    vec3 const normal = vec3_normalize(vec3_cross(vec3_sub(vec3_load(positions, corners[1]), a),
                                                  vec3_sub(vec3_load(positions, corners[2]), a)));
    return vec3_dot(normal, way) < 0.0 ? vec3_neg(normal) : normal;
}

/* What a side that may lag touches the cloth with, and the cloth there. */
typedef struct touch {
    room_side side;
    vec3 cloth;           /* [m] the point of the cloth */
    uint32_t vertices[4]; /* of both; triangles at these are no further layer */
    uint32_t vertex;      /* one of the cloth */
    double height;        /* [m] at which the cloth is held over the side; 0: it may come nearer */
} touch;

/* The place of a touch, if the cloth has another side across. */
static bool find_place(const step_context *context, const touch *at, const double *ends,
                       double reach, room_place *place) {
    const tulle_world *const world = context->world;
    const double *const positions = world->now.positions;
    size_t const cloth = world->model.vertex_surface[at->vertex];
    vec3 const away = vec3_sub(at->cloth, get_side_point(&at->side, positions));
    vec3 const normal = vec3_normalize(away);
    surface_hit hit;
    if (!(vec3_norm(away) > 0.0) || !find_across(world, cloth, at->cloth, normal, reach, &hit))
        return false;

    room_side *const second = &place->sides[1];
    const uint32_t *const corners = world->model.topo.triangles + 3 * (size_t)hit.triangle;
    for (int k = 0; k < 3; k++) {
        second->vertices[k] = corners[k];
        second->weights[k] = hit.weights[k];
    }
    size_t const other = world->model.vertex_surface[corners[0]];
    second->may_lag = world_may_lag(world, other - world->model.cloths.count);
    place->sides[0] = at->side;
    vec3 const facing = measure_facing(world, corners, vec3_neg(normal));
    if (vec3_dot(facing, normal) > OPPOSED_COSINE) return false;
    /* Contacts at edges and at wrinkled cloth have directions of their own, by which the surfaces
     * would shift along themselves. Those within a triangle have its normal. */
    bool const is_within =
        fmin(at->side.weights[0], fmin(at->side.weights[1], at->side.weights[2])) > 0.0;
    place->normal = is_within ? vec3_normalize(vec3_sub(normal, facing)) : vec3_neg(facing);

    double from[3], to[3];
    vec3_store(from, 0, at->cloth);
    vec3_store(to, 0, hit.position);
    size_t const count = world->model.set.surface_count;
    size_t const own = world->model.vertex_surface[at->side.vertices[0]];
    double const side =
        ROOM_OF_SIDE * fmax(world->model.laws[cloth * count + own].contact_distance,
                            world->model.laws[cloth * count + other].contact_distance);
    double const full =
        fmax(side, at->height) + side * (double)count_layers(world, at->vertices, from, to);
    double const now = vec3_dot(place->normal, vec3_sub(get_side_point(second, positions),
                                                        get_side_point(&at->side, positions)));
    place->room = choose_room(context, place, now, full);
    double const a = get_advance(world, &at->side, ends, place->normal);
    double const b = get_advance(world, second, ends, vec3_neg(place->normal));
    place->share = !second->may_lag ? 1.0 : a + b > 0.0 ? a / (a + b) : 0.5;
    return true;
}

/* ---- what touches ---- */

/* Reads a contact. False where it is not one of cloth with something that may lag. */
static bool read_touch(const tulle_world *world, feature_kind kind, feature_pair pair, touch *at) {
    vec3 points[4];
    int own = 0;
    size_t surface = 0;
    feature_pair_vertices(&world->model.topo, kind, pair, at->vertices);
    for (int k = 0; k < 4; k++) {
        points[k] = vec3_load(world->now.positions, at->vertices[k]);
        size_t const its = world->model.vertex_surface[at->vertices[k]];
        surface = its > surface ? its : surface;
        own += at->vertices[k] < world->model.cloth_vertex_count;
    }
    if (own == 0 || own == 4 || surface < world->model.cloths.count ||
        !world->model.surfaces[surface].is_present ||
        !world_may_lag(world, surface - world->model.cloths.count))
        return false;
    closest_points const closest = closest_of_pair(kind, points);
    at->side = (room_side){.may_lag = true};
    at->cloth = vec3_make(0.0, 0.0, 0.0);
    at->height = 0.0;
    int used = 0;
    for (int k = 0; k < 4; k++) {
        double const weight = fabs(closest.weights[k]);
        if (at->vertices[k] < world->model.cloth_vertex_count) {
            at->vertex = at->vertices[k];
            at->cloth = vec3_add_scaled(at->cloth, points[k], weight);
        } else {
            at->side.vertices[used] = at->vertices[k];
            at->side.weights[used++] = weight;
        }
    }
    for (; used < 3; used++) at->side.vertices[used] = at->side.vertices[0];
    return true;
}

/* Reads a tie. False where it is not to something that may lag. */
static bool read_tie(const tulle_world *world, const world_tie *tie, touch *at) {
    if (tie->corners[0] == TULLE_NONE) return false;
    size_t const surface = world->model.vertex_surface[tie->corners[0]];
    if (surface < world->model.cloths.count ||
        !world_may_lag(world, surface - world->model.cloths.count))
        return false;
    *at = (touch){.side = {.may_lag = true},
                  .cloth = vec3_load(world->now.positions, tie->vertex),
                  .vertices = {tie->vertex, tie->corners[0], tie->corners[1], tie->corners[2]},
                  .vertex = tie->vertex,
                  .height = fabs(tie->height)};
    for (int k = 0; k < 3; k++) {
        at->side.vertices[k] = tie->corners[k];
        at->side.weights[k] = tie->weights[k];
    }
    return true;
}

/* The place between a pinned vertex and what may lag and comes near it. */
static bool find_pin_place(const step_context *context, uint32_t vertex, double reach,
                           room_place *place) {
    const tulle_world *const world = context->world;
    size_t const cloth = world->model.vertex_surface[vertex],
                 count = world->model.set.surface_count;
    vec3 const pin = vec3_load(world->now.positions, vertex);
    nearest_query query =
        nearest_query_make(world->model.topo.triangles, world->now.positions, pin, reach);
    for (size_t s = world->model.cloths.count; s < count; s++)
        if (world->model.surfaces[s].is_present &&
            world_may_lag(world, s - world->model.cloths.count) &&
            world_pair_collides(world, cloth, s))
            query_tree_visit(&world->queries.trees[s], &query.query);
    const surface_hit *const hit = &query.hit;
    if (hit->triangle == TULLE_NONE || !(hit->distance > 0.0)) return false;
    const uint32_t *const corners = world->model.topo.triangles + 3 * (size_t)hit->triangle;
    vec3 const way = vec3_scale(vec3_sub(pin, hit->position), 1.0 / hit->distance);
    vec3 const normal = measure_facing(world, corners, way);
    if (vec3_dot(normal, way) < -OPPOSED_COSINE) return false; /* it passes beside the pin */
    *place = (room_place){.sides = {{.may_lag = true}, {.vertices = {vertex, vertex, vertex}}},
                          .normal = normal,
                          .share = 1.0};
    place->sides[1].weights[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        place->sides[0].vertices[k] = corners[k];
        place->sides[0].weights[k] = hit->weights[k];
    }
    size_t const other = world->model.vertex_surface[corners[0]];
    double const full = ROOM_OF_SIDE * world->model.laws[cloth * count + other].contact_distance;
    place->room = choose_room(context, place, vec3_dot(normal, vec3_sub(pin, hit->position)), full);
    return true;
}

/* Where pinned vertices matter: in the box around the ways of all that may lag. */
static surface_box measure_lag_box(const tulle_world *world, const double *ends, double reach) {
    double const most = (double)INFINITY;
    surface_box box = {{most, most, most}, {-most, -most, -most}};
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        const surface_range *const range = &world->model.surfaces[world->model.cloths.count + i];
        if (!world_may_lag(world, i) || !range->is_present) continue;
        surface_box const own = measure_surface_box(range, world->now.positions, ends);
        for (int k = 0; k < 3; k++) {
            box.low[k] = fmin(box.low[k], own.low[k] - reach);
            box.high[k] = fmax(box.high[k], own.high[k] + reach);
        }
    }
    return box;
}

/* Finds what touches something that may lag: contacts, rows of a try before, ties. Returns how many
 * there are; there is room for all. */
static size_t list_touches(const step_context *context, touch *touches) {
    const tulle_world *const world = context->world;
    const contact_store *const store = &context->state->contacts;
    size_t const tried = context->pinch_level > 0 ? world->work.rows.rows.count : 0;
    size_t count = 0;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        feature_pair const pair = {contact->first, contact->second};
        count += read_touch(world, (feature_kind)contact->kind, pair, &touches[count]);
    }
    for (size_t i = 0; i < tried; i++) {
        const row_frame *const frame = &world->work.rows.rows.data[i].frame;
        count += read_touch(world, frame->kind, frame->pair, &touches[count]);
    }
    for (size_t i = 0; i < context->state->ties.count; i++)
        count += read_tie(world, &context->state->ties.data[i], &touches[count]);
    return count;
}

/* Pinned vertices near what may lag. */
static size_t list_pins(const tulle_world *world, const double *ends, double reach,
                        uint32_t *pins) {
    surface_box const box = measure_lag_box(world, ends, reach);
    size_t count = 0;
    for (uint32_t v = 0; v < world->model.cloth_vertex_count; v++)
        if (world->work.is_fixed[v] &&
            surface_box_holds(&box, world->now.positions + 3 * (size_t)v))
            pins[count++] = v;
    return count;
}

tulle_status world_find_room(step_context *context, const double *ends, double reach,
                             room_list *places) {
    tulle_world *const world = context->world;
    arena *const scratch = &world->work.scratch;
    size_t const most = context->state->contacts.contacts.count + world->work.rows.rows.count +
                        context->state->ties.count;
    touch *const touches = ARENA_NEW(scratch, touch, most);
    uint32_t *const pins = ARENA_NEW(scratch, uint32_t, world->model.cloth_vertex_count);
    if (!touches || !pins) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t const touch_count = list_touches(context, touches);
    size_t const pin_count = list_pins(world, ends, reach, pins);
    places->count = 0;
    if (touch_count + pin_count == 0) return TULLE_OK;
    tulle_status const status = tulle_world_update_queries(world, NULL);
    if (status != TULLE_OK) return status;
    if (!ARRAY_RESERVE(&world->heap, places, touch_count + pin_count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < touch_count; i++)
        places->count +=
            find_place(context, &touches[i], ends, reach, &places->data[places->count]);
    for (size_t i = 0; i < pin_count; i++)
        places->count += find_pin_place(context, pins[i], reach, &places->data[places->count]);
    return TULLE_OK;
}
