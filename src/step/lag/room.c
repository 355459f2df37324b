/* step/lag/room.c - see room.h.
 *
 * In: contacts of cloth with what lags. From the cloth a ray goes on across it, away from the
 * surface that it touches. What the ray meets first beyond the cloth is the other side. The cloth
 * needs room there by the layers of cloth that the ray passes on its way. */
#include "step/lag/room.h"

#include "detect/queries/surface_queries.h"
#include "step/lag/lag.h"

#include <math.h>
#include <string.h>

/* [contact distances] room of a layer of cloth on each of its sides: a little pressed */
static const double ROOM_OF_SIDE = 0.9;
/* [m/s] Sides that lag and are nearer than that part at this speed. */
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

/* What a ray from a cloth meets first of obstacles, or of what lags alone; or no triangle. */
static surface_hit find_across(const step_model *model, const step_work *work, size_t cloth,
                               vec3 from, vec3 way, bool lags) {
    double ends[2][3];
    vec3_store(ends[0], 0, from);
    vec3_store(ends[1], 0, vec3_add(from, way));
    ray_query query =
        ray_query_make(model->topo.triangles, work->start->positions, ends[0], ends[1], false);
    for (size_t s = model->cloths.count; s < model->surface_count; s++)
        if (work->surfaces[s].is_present && !work->surfaces[s].is_body &&
            world_pair_collides(model, cloth, s) &&
            (!lags || step_lags_now(model, work, s - model->cloths.count)))
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
        opens |= side->may_lag &&
                 vec3_norm2(step_get_lag(model, work->start, side->vertices[k % 3])) > 0.0;
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

/* ---- places ---- */

typedef struct room_search {
    const step_model *model;
    step_work *work;
    const double *ends; /* [m] all vertices, as drawn */
    double reach;       /* [m] */
    room_list *places;
} room_search;

/* What a side that lags touches the cloth with, and the cloth there. */
typedef struct touch {
    room_side side;
    vec3 cloth;           /* [m] the point of the cloth */
    uint32_t vertices[4]; /* of both; triangles at these are no further layer */
    uint32_t vertex;      /* one of the cloth */
    double height;        /* [m] at which the cloth is held over the side; 0: it may come nearer */
} touch;

static room_side make_side(const room_search *search, const surface_hit *hit) {
    const step_model *const model = search->model;
    const uint32_t *const corners = model->topo.triangles + 3 * (size_t)hit->triangle;
    size_t const obstacle = model->vertex_surface[corners[0]] - model->cloths.count;
    return (room_side){{corners[0], corners[1], corners[2]},
                       {hit->weights[0], hit->weights[1], hit->weights[2]},
                       step_lags_now(model, search->work, obstacle)};
}

/* The place of a touch, if the cloth has another side across. */
static bool find_place(const room_search *search, const touch *at, room_place *place) {
    const step_model *const model = search->model;
    const step_work *const work = search->work;
    const double *const positions = work->start->positions;
    size_t const cloth = model->vertex_surface[at->vertex];
    vec3 const away = vec3_sub(at->cloth, get_side_point(&at->side, positions));
    vec3 const normal = vec3_normalize(away);
    if (!(vec3_norm(away) > 0.0)) return false;
    surface_hit const hit =
        find_across(model, work, cloth, at->cloth, vec3_scale(normal, search->reach), false);
    if (hit.triangle == TULLE_NONE) return false;

    room_side *const second = &place->sides[1];
    place->sides[0] = at->side;
    *second = make_side(search, &hit);
    size_t const own = model->vertex_surface[at->side.vertices[0]];
    size_t const other = model->vertex_surface[second->vertices[0]];
    vec3 const facing = measure_facing(work, second->vertices, vec3_neg(normal));
    if (vec3_dot(facing, normal) > OPPOSED_COSINE) return false;
    if (own == other && !step_deforms(model, own - model->cloths.count)) return false;
    /* Contacts at edges and at wrinkled cloth have directions of their own, by which the surfaces
     * would shift along themselves. Those within a triangle have its normal. */
    bool const is_within =
        fmin(at->side.weights[0], fmin(at->side.weights[1], at->side.weights[2])) > 0.0;
    place->normal = is_within ? vec3_normalize(vec3_sub(normal, facing)) : vec3_neg(facing);

    double from[3], to[3];
    vec3_store(from, 0, at->cloth);
    vec3_store(to, 0, hit.position);
    size_t const count = model->surface_count;
    double const side = ROOM_OF_SIDE * fmax(model->laws[cloth * count + own].contact_distance,
                                            model->laws[cloth * count + other].contact_distance);
    double const full =
        fmax(side, at->height) + side * (double)count_layers(model, work, at->vertices, from, to);
    double const now = vec3_dot(place->normal, vec3_sub(get_side_point(second, positions),
                                                        get_side_point(&at->side, positions)));
    place->room = choose_room(model, work, place, now, full);
    double const a = get_advance(work, &at->side, search->ends, place->normal);
    double const b = get_advance(work, second, search->ends, vec3_neg(place->normal));
    place->share = !second->may_lag ? 1.0 : a + b > 0.0 ? a / (a + b) : 0.5;
    return true;
}

/* Adds the place of four vertices, cloth and something that lags, with their weights in the point
 * of their side. */
static tulle_status add_touch(const room_search *search, const uint32_t vertices[4],
                              const double weights[4], double height) {
    const step_model *const model = search->model;
    touch at = {.side.may_lag = true, .height = height};
    int used = 0, own = 0;
    size_t surface = 0;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = vertices[k];
        size_t const its = model->vertex_surface[v];
        surface = its > surface ? its : surface;
        at.vertices[k] = v;
        if (v < model->cloth_vertex_count) {
            own++;
            at.vertex = v;
            vec3 const x = vec3_load(search->work->start->positions, v);
            at.cloth = vec3_add_scaled(at.cloth, x, weights[k]);
        } else if (used < 3) {
            at.side.vertices[used] = v;
            at.side.weights[used++] = weights[k];
        }
    }
    if (own == 0 || own == 4 || surface < model->cloths.count ||
        !search->work->surfaces[surface].is_present ||
        !step_lags_now(model, search->work, surface - model->cloths.count))
        return TULLE_OK;
    for (; used < 3; used++) at.side.vertices[used] = at.side.vertices[0];
    room_list *const places = search->places;
    if (!ARRAY_RESERVE(search->work->heap, places, places->count + 1) ||
        step_update_queries(model, search->work) != TULLE_OK)
        return TULLE_ERROR_OUT_OF_MEMORY;
    places->count += find_place(search, &at, &places->data[places->count]);
    return TULLE_OK;
}

/* The same of a contact. */
static tulle_status add_contact(const room_search *search, feature_kind kind, feature_pair pair) {
    uint32_t vertices[4];
    vec3 points[4];
    feature_pair_vertices(&search->model->topo, kind, pair, vertices);
    for (int k = 0; k < 4; k++) points[k] = vec3_load(search->work->start->positions, vertices[k]);
    closest_points closest = closest_of_pair(kind, points);
    for (int k = 0; k < 4; k++) closest.weights[k] = fabs(closest.weights[k]);
    return add_touch(search, vertices, closest.weights, 0.0);
}

/* Adds the place between a pinned vertex and what lags and comes to it, as seen from what is
 * nearest. */
static tulle_status add_pin(const room_search *search, uint32_t vertex) {
    const step_model *const model = search->model;
    step_work *const work = search->work;
    size_t const cloth = model->vertex_surface[vertex], count = model->surface_count;
    vec3 const pin = vec3_load(work->start->positions, vertex);
    if (!ARRAY_RESERVE(work->heap, search->places, search->places->count + 1) ||
        step_update_queries(model, work) != TULLE_OK)
        return TULLE_ERROR_OUT_OF_MEMORY;
    nearest_query query =
        nearest_query_make(model->topo.triangles, work->start->positions, pin, search->reach);
    for (size_t s = model->cloths.count; s < count; s++)
        if (work->surfaces[s].is_present && step_lags_now(model, work, s - model->cloths.count) &&
            world_pair_collides(model, cloth, s))
            query_tree_visit(&work->queries.trees[s], &query.query);
    if (query.hit.triangle == TULLE_NONE) return TULLE_OK;
    room_place place = {.sides = {make_side(search, &query.hit),
                                  {.vertices = {vertex, vertex, vertex}, .weights = {1.0}}},
                        .share = 1.0};
    size_t const other = model->vertex_surface[place.sides[0].vertices[0]];
    double const full = ROOM_OF_SIDE * model->laws[cloth * count + other].contact_distance;
    vec3 const way =
        vec3_sub(vec3_sub(vec3_load(search->ends, vertex), pin),
                 vec3_sub(get_side_point(&place.sides[0], search->ends), query.hit.position));
    double const length = vec3_norm(way);
    if (!(length > 0.0)) return TULLE_OK;
    surface_hit const hit =
        find_across(model, work, cloth, pin, vec3_scale(way, 1.0 + full / length), true);
    if (hit.triangle == TULLE_NONE) return TULLE_OK;
    place.sides[0] = make_side(search, &hit);
    place.normal = measure_facing(work, place.sides[0].vertices, vec3_neg(way));
    place.room =
        choose_room(model, work, &place, vec3_dot(place.normal, vec3_sub(pin, hit.position)), full);
    search->places->data[search->places->count++] = place;
    return TULLE_OK;
}

tulle_status step_find_room(const step_model *model, step_work *work, const double *ends,
                            double reach, room_list *places) {
    room_search const search = {model, work, ends, reach, places};
    const motion_state *const start = work->start;
    size_t const tried = work->lag.level > 0 ? work->rows.rows.count : 0;
    tulle_status status = TULLE_OK;
    places->count = 0;
    for (size_t i = 0; i < start->contacts.contacts.count && status == TULLE_OK; i++) {
        const stored_contact *const contact = &start->contacts.contacts.data[i];
        status = add_contact(&search, (feature_kind)contact->kind,
                             (feature_pair){contact->first, contact->second});
    }
    for (size_t i = 0; i < tried && status == TULLE_OK; i++)
        status = add_contact(&search, work->rows.rows.data[i].frame.kind,
                             work->rows.rows.data[i].frame.pair);
    for (size_t i = 0; i < start->ties.count && status == TULLE_OK; i++) {
        const world_tie *const tie = &start->ties.data[i];
        const uint32_t *const corners = tie->corners;
        if (corners[0] != TULLE_NONE)
            status =
                add_touch(&search, (uint32_t[4]){tie->vertex, corners[0], corners[1], corners[2]},
                          (double[4]){1.0, tie->weights[0], tie->weights[1], tie->weights[2]},
                          fabs(tie->height));
    }
    for (uint32_t v = 0; v < model->cloth_vertex_count && status == TULLE_OK; v++)
        if (work->is_fixed[v]) status = add_pin(&search, v);
    return status;
}
