/* step/lag/room.c - see room.h.
 *
 * In: contacts of cloth with what may lag. From the cloth a ray goes on across it, away from the
 * surface that it touches. What the ray meets first beyond the cloth is the other side. The cloth
 * needs room there by the layers of cloth that the ray passes on its way. */
#include "step/lag/room.h"

#include "detect/queries/surface_queries.h"
#include "step/lag/lag.h"
#include "step/surface_box.h"

#include <math.h>
#include <string.h>

/* Two sides face each other when the cosine between the directions into the cloth is under this. */
static const double OPPOSED_COSINE = -0.5;
/* [contact distances] room of a layer of cloth on each of its sides: a little pressed */
static const double ROOM_OF_SIDE = 0.9;
/* [m/s] Sides that lag and are nearer than that part at this speed, as obstacles that are held. */
static const double OPENING_SPEED = 0.05;

/* ---- what lies across ---- */

tulle_status step_update_queries(const step_model *model, step_work *work) {
    if (work->has_queries) return TULLE_OK;
    if (!work->queries.trees &&
        !query_trees_make(&work->queries, work->heap, &work->set, work->broad, model->rest,
                          model->topo.triangle_count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    query_trees_fit(&work->queries, &work->set, work->start->positions, work->threads);
    work->has_queries = true;
    return TULLE_OK;
}

/* Counts the triangles of cloth that a segment passes, without those at a vertex of the contact. */
typedef struct layer_query {
    tree_query query;
    ray_query ray;
    const step_model *model;
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
    const uint32_t *const corners = layers->model->topo.triangles + 3 * (size_t)triangle;
    for (int k = 0; k < 12; k++)
        if (corners[k % 3] == layers->contact[k / 3]) return;
    ray_query ray = layers->ray;
    ray.query.visit(&ray.query, triangle);
    layers->count += ray.hit.triangle != TULLE_NONE;
}

static size_t count_layers(const step_model *model, const step_work *work,
                           const uint32_t contact[4], const double *from, const double *to) {
    layer_query layers = {
        .query = {measure_layers, visit_layer, 1.0},
        .ray = ray_query_make(model->topo.triangles, work->start->positions, from, to, false),
        .model = model,
        .contact = contact};
    for (size_t s = 0; s < model->cloths.count; s++)
        query_tree_visit(&work->queries.trees[s], &layers.query);
    return layers.count + 1;
}

/* What the cloth meets across itself, farther from the side that it touches; or no triangle. */
static surface_hit find_across(const step_model *model, const step_work *work, size_t cloth,
                               vec3 from, vec3 normal, double reach) {
    double ends[2][3];
    vec3_store(ends[0], 0, from);
    vec3_store(ends[1], 0, vec3_add_scaled(from, normal, reach));
    ray_query query =
        ray_query_make(model->topo.triangles, work->start->positions, ends[0], ends[1], false);
    for (size_t s = model->cloths.count; s < model->surface_count; s++)
        if (work->surfaces[s].is_present && !work->surfaces[s].is_body &&
            world_pair_collides(model, cloth, s))
            query_tree_visit(&work->queries.trees[s], &query.query);
    return query.hit;
}

/* [m] What a place that has the room `now` is to have: no less, and where a side lags, little by
 * little, all that the cloth needs. */
static double choose_room(const step_model *model, const step_work *work, const room_place *place,
                          double now, double full) {
    bool opens = false;
    for (int k = 0; k < 6; k++) {
        const room_side *const side = &place->sides[k / 3];
        opens |=
            side->may_lag && vec3_norm2(step_get_lag(model, work, side->vertices[k % 3])) > 0.0;
    }
    return fmin(full, now + (opens ? OPENING_SPEED * work->whole_step : 0.0));
}

/* How far the side goes along the direction in this step, as drawn. */
static double get_advance(const step_work *work, const room_side *side, const double *ends,
                          vec3 direction) {
    vec3 const way =
        vec3_sub(get_side_point(side, ends), get_side_point(side, work->start->positions));
    return side->may_lag ? fmax(0.0, vec3_dot(way, direction)) : 0.0;
}

/* Unit normal of a triangle, on the side of `way`. */
static vec3 measure_facing(const step_work *work, const uint32_t corners[3], vec3 way) {
    const double *const positions = work->start->positions;
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
static bool find_place(const step_model *model, const step_work *work, const touch *at,
                       const double *ends, double reach, room_place *place) {
    const double *const positions = work->start->positions;
    size_t const cloth = model->vertex_surface[at->vertex];
    vec3 const away = vec3_sub(at->cloth, get_side_point(&at->side, positions));
    vec3 const normal = vec3_normalize(away);
    if (!(vec3_norm(away) > 0.0)) return false;
    surface_hit const hit = find_across(model, work, cloth, at->cloth, normal, reach);
    if (hit.triangle == TULLE_NONE) return false;

    room_side *const second = &place->sides[1];
    const uint32_t *const corners = model->topo.triangles + 3 * (size_t)hit.triangle;
    for (int k = 0; k < 3; k++) {
        second->vertices[k] = corners[k];
        second->weights[k] = hit.weights[k];
    }
    size_t const other = model->vertex_surface[corners[0]];
    second->may_lag = step_may_lag(model, other - model->cloths.count);
    place->sides[0] = at->side;
    vec3 const facing = measure_facing(work, corners, vec3_neg(normal));
    if (vec3_dot(facing, normal) > OPPOSED_COSINE) return false;
    /* Contacts at edges and at wrinkled cloth have directions of their own, by which the surfaces
     * would shift along themselves. Those within a triangle have its normal. */
    bool const is_within =
        fmin(at->side.weights[0], fmin(at->side.weights[1], at->side.weights[2])) > 0.0;
    place->normal = is_within ? vec3_normalize(vec3_sub(normal, facing)) : vec3_neg(facing);

    double from[3], to[3];
    vec3_store(from, 0, at->cloth);
    vec3_store(to, 0, hit.position);
    size_t const count = model->surface_count;
    size_t const own = model->vertex_surface[at->side.vertices[0]];
    double const side = ROOM_OF_SIDE * fmax(model->laws[cloth * count + own].contact_distance,
                                            model->laws[cloth * count + other].contact_distance);
    double const full =
        fmax(side, at->height) + side * (double)count_layers(model, work, at->vertices, from, to);
    double const now = vec3_dot(place->normal, vec3_sub(get_side_point(second, positions),
                                                        get_side_point(&at->side, positions)));
    place->room = choose_room(model, work, place, now, full);
    double const a = get_advance(work, &at->side, ends, place->normal);
    double const b = get_advance(work, second, ends, vec3_neg(place->normal));
    place->share = !second->may_lag ? 1.0 : a + b > 0.0 ? a / (a + b) : 0.5;
    return true;
}

/* ---- what touches ---- */

/* Reads a contact. False where it is not one of cloth with something that may lag. */
static bool read_touch(const step_model *model, const step_work *work, feature_kind kind,
                       feature_pair pair, touch *at) {
    vec3 points[4];
    int own = 0;
    size_t surface = 0;
    feature_pair_vertices(&model->topo, kind, pair, at->vertices);
    for (int k = 0; k < 4; k++) {
        points[k] = vec3_load(work->start->positions, at->vertices[k]);
        size_t const its = model->vertex_surface[at->vertices[k]];
        surface = its > surface ? its : surface;
        own += at->vertices[k] < model->cloth_vertex_count;
    }
    if (own == 0 || own == 4 || surface < model->cloths.count ||
        !work->surfaces[surface].is_present || !step_may_lag(model, surface - model->cloths.count))
        return false;
    closest_points const closest = closest_of_pair(kind, points);
    at->side = (room_side){.may_lag = true};
    at->cloth = vec3_make(0.0, 0.0, 0.0);
    at->height = 0.0;
    int used = 0;
    for (int k = 0; k < 4; k++) {
        double const weight = fabs(closest.weights[k]);
        if (at->vertices[k] < model->cloth_vertex_count) {
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
static bool read_tie(const step_model *model, const step_work *work, const world_tie *tie,
                     touch *at) {
    if (tie->corners[0] == TULLE_NONE) return false;
    size_t const surface = model->vertex_surface[tie->corners[0]];
    if (surface < model->cloths.count || !step_may_lag(model, surface - model->cloths.count))
        return false;
    *at = (touch){.side = {.may_lag = true},
                  .cloth = vec3_load(work->start->positions, tie->vertex),
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
static bool find_pin_place(const step_model *model, const step_work *work, uint32_t vertex,
                           double reach, room_place *place) {
    size_t const cloth = model->vertex_surface[vertex], count = model->surface_count;
    vec3 const pin = vec3_load(work->start->positions, vertex);
    nearest_query query =
        nearest_query_make(model->topo.triangles, work->start->positions, pin, reach);
    for (size_t s = model->cloths.count; s < count; s++)
        if (work->surfaces[s].is_present && step_may_lag(model, s - model->cloths.count) &&
            world_pair_collides(model, cloth, s))
            query_tree_visit(&work->queries.trees[s], &query.query);
    const surface_hit *const hit = &query.hit;
    if (hit->triangle == TULLE_NONE || !(hit->distance > 0.0)) return false;
    const uint32_t *const corners = model->topo.triangles + 3 * (size_t)hit->triangle;
    vec3 const way = vec3_scale(vec3_sub(pin, hit->position), 1.0 / hit->distance);
    vec3 const normal = measure_facing(work, corners, way);
    if (vec3_dot(normal, way) < -OPPOSED_COSINE) return false; /* it passes beside the pin */
    *place = (room_place){.sides = {{.may_lag = true}, {.vertices = {vertex, vertex, vertex}}},
                          .normal = normal,
                          .share = 1.0};
    place->sides[1].weights[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        place->sides[0].vertices[k] = corners[k];
        place->sides[0].weights[k] = hit->weights[k];
    }
    size_t const other = model->vertex_surface[corners[0]];
    double const full = ROOM_OF_SIDE * model->laws[cloth * count + other].contact_distance;
    place->room =
        choose_room(model, work, place, vec3_dot(normal, vec3_sub(pin, hit->position)), full);
    return true;
}

/* Where pinned vertices matter: in the box around the ways of all that may lag. */
static surface_box measure_lag_box(const step_model *model, const step_work *work,
                                   const double *ends, double reach) {
    double const most = (double)INFINITY;
    surface_box box = {{most, most, most}, {-most, -most, -most}};
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        if (!step_may_lag(model, i) || !range->is_present) continue;
        surface_box const own = measure_surface_box(range, work->start->positions, ends);
        for (int k = 0; k < 3; k++) {
            box.low[k] = fmin(box.low[k], own.low[k] - reach);
            box.high[k] = fmax(box.high[k], own.high[k] + reach);
        }
    }
    return box;
}

/* Finds what touches something that may lag: contacts, rows of a try before, ties. Returns how many
 * there are; there is room for all. */
static size_t list_touches(const step_model *model, const step_work *work, touch *touches) {
    const contact_store *const store = &work->start->contacts;
    size_t const tried = work->pinch.level > 0 ? work->rows.rows.count : 0;
    size_t count = 0;
    for (size_t i = 0; i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        feature_pair const pair = {contact->first, contact->second};
        count += read_touch(model, work, (feature_kind)contact->kind, pair, &touches[count]);
    }
    for (size_t i = 0; i < tried; i++) {
        const row_frame *const frame = &work->rows.rows.data[i].frame;
        count += read_touch(model, work, frame->kind, frame->pair, &touches[count]);
    }
    for (size_t i = 0; i < work->start->ties.count; i++)
        count += read_tie(model, work, &work->start->ties.data[i], &touches[count]);
    return count;
}

/* Pinned vertices near what may lag. */
static size_t list_pins(const step_model *model, const step_work *work, const double *ends,
                        double reach, uint32_t *pins) {
    surface_box const box = measure_lag_box(model, work, ends, reach);
    size_t count = 0;
    for (uint32_t v = 0; v < model->cloth_vertex_count; v++)
        if (work->is_fixed[v] && surface_box_holds(&box, work->start->positions + 3 * (size_t)v))
            pins[count++] = v;
    return count;
}

tulle_status step_find_room(const step_model *model, step_work *work, const double *ends,
                            double reach, room_list *places) {
    arena *const scratch = &work->scratch;
    size_t const most =
        work->start->contacts.contacts.count + work->rows.rows.count + work->start->ties.count;
    touch *const touches = ARENA_NEW(scratch, touch, most);
    uint32_t *const pins = ARENA_NEW(scratch, uint32_t, model->cloth_vertex_count);
    if (!touches || !pins) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t const touch_count = list_touches(model, work, touches);
    size_t const pin_count = list_pins(model, work, ends, reach, pins);
    places->count = 0;
    if (touch_count + pin_count == 0) return TULLE_OK;
    tulle_status const status = step_update_queries(model, work);
    if (status != TULLE_OK) return status;
    if (!ARRAY_RESERVE(work->heap, places, touch_count + pin_count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < touch_count; i++)
        places->count +=
            find_place(model, work, &touches[i], ends, reach, &places->data[places->count]);
    for (size_t i = 0; i < pin_count; i++)
        places->count += find_pin_place(model, work, pins[i], reach, &places->data[places->count]);
    return TULLE_OK;
}
