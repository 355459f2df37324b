/* world/start/start_slots.c - how near parts of one obstacle lie to one another where cloth may
 * come between them. Part of the start.
 *
 * From each vertex of an obstacle it looks for the nearest triangle of the same obstacle across a
 * gap that the fronts of both sides look into. The fronts of a closed body look outward, so its own
 * two sides are no gap, however thin it is; of an open surface it counts how its triangles turn. A
 * dent that is wider than deep is no slot: a ray goes down from the middle of the gap, to where
 * both sides turn their backs.
 *
 * Takes positions at time 0. Narrows the rooms of start_rooms.c. */
#include "base/parallel.h"
#include "detect/queries/surface_queries.h"
#include "geom/distance.h"
#include "world/start/start.h"

#include <math.h>

/* A side looks at what lies off its plane by this share of the distance: most of a round bar looks
 * at the bar beside it. */
static const double LOOKS_AT = 0.2;
/* The sum of two unit normals that look at each other. Sides with less are walls of a slot, however
 * deep it is. */
static const double PARALLEL_WALLS = 0.5;
enum {
    VERTICES_PER_CHUNK = 64,
    NORMALS_MAX = 16, /* of triangles at a vertex; more are the tip of a needle, or a flat fan */
    VISITS_MAX = 2048 /* triangles about a vertex; more lie upon one another */
};
/* Normals whose cosine is above this count once. */
static const double SAME_NORMAL = 0.99;

typedef struct slot_search {
    const tulle_world *world;
    const query_tree *tree; /* of the obstacle */
    double *rooms;          /* of all vertices */
    size_t vertex_begin;
    double share;          /* of a gap, that is the room of its vertex */
    double nearest, reach; /* [m] gaps that are looked for: nearer ones are grain of the surface */
} slot_search;

typedef struct slot_query {
    tree_query query; /* its reach: [m^2] */
    const slot_search *search;
    double point[3]; /* [m] of the vertex */
    double normals[NORMALS_MAX][3];
    size_t normal_count, visit_count;
    vec3 found, normal_sum; /* [m] of the nearest point; of both sides' unit normals */
    bool has_found;
} slot_query;

/* Leaves out boxes that lie behind the vertex, as nearly all do on a surface that bulges. */
static void measure_in_front(const tree_query *query, const query_node *node,
                             double distances[QUERY_LANES]) {
    const slot_query *const slot = (const slot_query *)query;
    double const nearest2 = slot->search->nearest * slot->search->nearest;
    double highest[QUERY_LANES] = {0.0}; /* [m] over the planes at the vertex */
    for (size_t i = 0; i < slot->normal_count; i++) {
        double heights[QUERY_LANES] = {0.0};
        for (int k = 0; k < 3; k++) {
            double const along = slot->normals[i][k], from = slot->point[k];
            const double *const far = along > 0.0 ? node->high[k] : node->low[k];
            for (int c = 0; c < QUERY_LANES; c++) heights[c] += along * (far[c] - from);
        }
        for (int c = 0; c < QUERY_LANES; c++)
            highest[c] = heights[c] > highest[c] ? heights[c] : highest[c];
    }
    for (int c = 0; c < QUERY_LANES; c++) distances[c] = 0.0;
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < QUERY_LANES; c++) {
            double const below = node->low[k][c] - slot->point[k];
            double const above = slot->point[k] - node->high[k][c];
            double const outside = below > above ? below : above;
            double const gap = outside > 0.0 ? outside : 0.0;
            distances[c] += gap * gap;
        }
    for (int c = 0; c < QUERY_LANES; c++) {
        double const least2 = distances[c] > nearest2 ? distances[c] : nearest2;
        if (!(highest[c] * highest[c] > LOOKS_AT * LOOKS_AT * least2))
            distances[c] = (double)INFINITY;
    }
}

static void visit_in_front(tree_query *query, uint32_t triangle) {
    slot_query *const slot = (slot_query *)query;
    const slot_search *const search = slot->search;
    const uint32_t *const corners = search->world->model.topo.triangles + 3 * (size_t)triangle;
    if (++slot->visit_count > VISITS_MAX) slot->query.reach = -1.0;
    vec3 points[4] = {vec3_load(slot->point, 0)};
    double highest = 0.0, least = LOOKS_AT * search->nearest; /* [m] over planes at the vertex */
    for (size_t k = 1; k < 4; k++) {
        points[k] = vec3_load(search->world->now.positions, corners[k - 1]);
        for (size_t i = 0; i < slot->normal_count; i++) {
            double const height =
                vec3_dot(vec3_load(slot->normals[i], 0), vec3_sub(points[k], points[0]));
            highest = height > highest ? height : highest;
        }
    }
    if (!(highest > least)) return;
    closest_points const closest = closest_vertex_triangle(points);
    if (!(closest.distance2 < slot->query.reach) ||
        !(closest.distance2 > search->nearest * search->nearest))
        return;
    vec3 const area = vec3_cross(vec3_sub(points[2], points[1]), vec3_sub(points[3], points[1]));
    double const size = vec3_norm(area);
    least = LOOKS_AT * sqrt(closest.distance2);
    if (!(vec3_dot(area, closest.difference) > least * size)) return;
    size_t facing = slot->normal_count;
    for (size_t i = 0; i < slot->normal_count; i++) {
        double const height = -vec3_dot(vec3_load(slot->normals[i], 0), closest.difference);
        if (height > least) least = height, facing = i;
    }
    if (facing == slot->normal_count) return;
    slot->query.reach = closest.distance2;
    slot->found = vec3_sub(points[0], closest.difference);
    slot->normal_sum = vec3_add_scaled(vec3_load(slot->normals[facing], 0), area, 1.0 / size);
    slot->has_found = true;
}

/* Notes the rooms of a chunk of an obstacle's vertices. */
static void note_slots(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const slot_search *const search = context;
    const tulle_world *const world = search->world;
    const adjacency *const around = &world->model.topo.vertex_triangles;
    const double *const positions = world->now.positions;
    for (size_t v = search->vertex_begin + begin; v < search->vertex_begin + end; v++) {
        vec3 const point = vec3_load(positions, v);
        slot_query slot = {
            .query = {measure_in_front, visit_in_front, search->reach * search->reach},
            .search = search,
            .point = {point.x, point.y, point.z}};
        for (uint32_t i = around->begin[v]; i < around->begin[v + 1]; i++) {
            const uint32_t *const corners =
                world->model.topo.triangles + 3 * (size_t)around->items[i];
            vec3 const a = vec3_load(positions, corners[0]);
            vec3 const area = vec3_cross(vec3_sub(vec3_load(positions, corners[1]), a),
                                         vec3_sub(vec3_load(positions, corners[2]), a));
            bool is_new = vec3_norm2(area) > 0.0 && slot.normal_count < NORMALS_MAX;
            vec3 const normal = vec3_scale(area, is_new ? 1.0 / vec3_norm(area) : 0.0);
            for (size_t k = 0; k < slot.normal_count; k++)
                is_new = is_new && vec3_dot(vec3_load(slot.normals[k], 0), normal) < SAME_NORMAL;
            if (is_new) vec3_store(slot.normals[slot.normal_count++], 0, normal);
        }
        query_tree_visit(search->tree, &slot.query);
        if (!slot.has_found || slot.visit_count > VISITS_MAX) continue;
        double const gap = vec3_norm(vec3_sub(slot.found, point));
        double const sum = vec3_norm(slot.normal_sum);
        if (sum > PARALLEL_WALLS) {
            double ends[2][3];
            vec3 const middle = vec3_lerp(point, slot.found, 0.5);
            vec3_store(ends[0], 0, middle);
            vec3_store(ends[1], 0, vec3_add_scaled(middle, slot.normal_sum, -gap / sum));
            ray_query ray =
                ray_query_make(world->model.topo.triangles, positions, ends[0], ends[1], false);
            query_tree_visit(search->tree, &ray.query);
            if (ray.hit.triangle != TULLE_NONE) continue;
        }
        search->rooms[v] = fmin(search->rooms[v], search->share * gap);
    }
}

tulle_status world_find_slots(tulle_world *world, const surface_set *set, const broad_phase *broad,
                              double least, double share) {
    query_trees trees;
    if (!query_trees_make(&trees, &world->heap, set, broad, world->now.positions,
                          world->model.topo.triangle_count))
        return TULLE_ERROR_OUT_OF_MEMORY;
    query_trees_fit(&trees, set, world->now.positions, world->work.threads);
    for (size_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        slot_search search = {.world = world,
                              .tree = &trees.trees[s],
                              .rooms = world->model.rooms,
                              .vertex_begin = range->vertex_begin,
                              .share = share,
                              .nearest = least / share,
                              .reach = world->model.contact_distance / share};
        if (range->is_present)
            parallel_for(range->vertex_end - range->vertex_begin, VERTICES_PER_CHUNK,
                         world->work.threads, note_slots, &search);
    }
    query_trees_destroy(&trees, &world->heap, world->model.topo.triangle_count);
    return TULLE_OK;
}
