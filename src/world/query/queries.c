/* world/query/queries.c - rays, nearest points and overlaps, asked of the state as it is
 * (tulle/query.h). The trees are detect/queries/; exact questions about two triangles go to the
 * judge. */
#include "base/error.h"
#include "base/sort.h"
#include "detect/queries/surface_queries.h"
#include "step/lag/room.h"
#include "tulle/check.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

/* [m] as for meshes */
static const double COORDINATE_MAX = 1e100;

/* ---- the trees ---- */

tulle_status tulle_world_update_queries(tulle_world *world, tulle_error *error) {
    if (!world || !world->is_started)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "only a world that has started can be asked; call tulle_world_start");
    tulle_status const status = step_update_queries(&world->model, &world->work);
    return status == TULLE_OK ? status
                              : error_set(error, status, "no memory left for trees of queries");
}

/* Puts a query to all present objects with a category in the mask. */
static void ask(const tulle_world *world, uint32_t mask, tree_query *query) {
    for (size_t s = 0; s < world->model.surface_count; s++) {
        uint32_t const category = world_get_label(&world->model, s)->category;
        if (world->work.surfaces[s].is_present && (mask == 0 || (category & mask)))
            query_tree_visit(&world->work.queries.trees[s], query);
    }
}

static tulle_status check_numbers(const double *numbers, size_t count, const char *what,
                                  tulle_error *error) {
    for (size_t i = 0; i < count; i++)
        if (!(fabs(numbers[i]) <= COORDINATE_MAX))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "coordinate %zu of %s is %g; it must be a number of at most %g m",
                             i % 3, what, numbers[i], COORDINATE_MAX);
    return TULLE_OK;
}

/* ---- rays and points ---- */

static void describe_hit(const tulle_world *world, const surface_hit *found, tulle_hit *hit) {
    if (found->triangle == TULLE_NONE) return;
    const uint32_t *const corners = world->model.topo.triangles + 3 * (size_t)found->triangle;
    uint32_t const surface = world->model.vertex_surface[corners[0]];
    hit->object = tulle_world_get_object(world, surface);
    hit->triangle = found->triangle - world->work.surfaces[surface].triangle_begin;
    memcpy(hit->weights, found->weights, sizeof hit->weights);
    vec3_store(hit->position, 0, found->position);
    hit->distance = found->distance;
    vec3 x[3];
    for (int k = 0; k < 3; k++) x[k] = vec3_load(world->now.positions, corners[k]);
    vec3 const left = vec3_normalize(vec3_sub(x[1], x[0]));
    vec3 const right = vec3_normalize(vec3_sub(x[2], x[0]));
    vec3_store(hit->normal, 0, vec3_normalize(vec3_cross(left, right)));
}

tulle_status tulle_world_cast_ray(tulle_world *world, const tulle_ray *ray, tulle_hit *hit,
                                  tulle_error *error) {
    if (hit) *hit = (tulle_hit){0};
    if (!ray || !hit)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the ray or the hit is null");
    tulle_status status = check_numbers(ray->from, 3, "the start of the ray", error);
    if (status == TULLE_OK) status = check_numbers(ray->to, 3, "the end of the ray", error);
    if (status != TULLE_OK) return status;
    if (ray->from[0] == ray->to[0] && ray->from[1] == ray->to[1] && ray->from[2] == ray->to[2])
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the ray ends where it begins; give two different points");
    status = tulle_world_update_queries(world, error);
    if (status != TULLE_OK) return status;
    ray_query query = ray_query_make(world->model.topo.triangles, world->now.positions, ray->from,
                                     ray->to, ray->skips_back_faces != 0);
    ask(world, ray->mask, &query.query);
    describe_hit(world, &query.hit, hit);
    return TULLE_OK;
}

tulle_status tulle_world_find_closest_point(tulle_world *world, const double point[3],
                                            double max_distance, uint32_t mask, tulle_hit *hit,
                                            tulle_error *error) {
    if (hit) *hit = (tulle_hit){0};
    if (!point || !hit)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the point or the hit is null");
    tulle_status status = check_numbers(point, 3, "the point", error);
    if (status != TULLE_OK) return status;
    if (!(max_distance >= 0.0))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the largest distance is %g m; it must be at least 0", max_distance);
    status = tulle_world_update_queries(world, error);
    if (status != TULLE_OK) return status;
    nearest_query query = nearest_query_make(world->model.topo.triangles, world->now.positions,
                                             vec3_load(point, 0), max_distance);
    ask(world, mask, &query.query);
    describe_hit(world, &query.hit, hit);
    return TULLE_OK;
}

/* ---- overlaps ---- */

enum { BOX_CORNERS = 8, BOX_TRIANGLES = 12 };

/* Asks for triangles that meet a box, and of these for those that meet what is in it. */
typedef struct overlap_query {
    tree_query query;
    const tulle_world *world;
    double low[3], high[3];
    /* Corners of the triangle that is looked at, then those of the box or of the other triangle. */
    double corners[3 * (3 + BOX_CORNERS)];
    bool is_box;
    uint32_t other; /* triangle of the given mesh */
    tulle_found *found;
} overlap_query;

static void measure_overlap_boxes(const tree_query *query, const query_node *node,
                                  double distances[QUERY_LANES]) {
    const overlap_query *const search = (const overlap_query *)query;
    int is_met[QUERY_LANES];
    for (int c = 0; c < QUERY_LANES; c++) is_met[c] = 1;
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < QUERY_LANES; c++)
            is_met[c] &=
                (node->low[k][c] <= search->high[k]) & (search->low[k] <= node->high[k][c]);
    for (int c = 0; c < QUERY_LANES; c++) distances[c] = is_met[c] ? 0.0 : (double)INFINITY;
}

/* Whether the triangle in search->corners meets the box: one of its corners lies in it, or it meets
 * one of the triangles that make up the box's faces. */
static bool meets_box(const overlap_query *search) {
    static const uint32_t faces[BOX_TRIANGLES][3] = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5},
                                                     {0, 4, 5}, {0, 5, 1}, {2, 3, 7}, {2, 7, 6},
                                                     {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    static const uint32_t own[3] = {0, 1, 2};
    for (size_t corner = 0; corner < 3; corner++) {
        bool is_inside = true;
        for (size_t k = 0; k < 3; k++) {
            double const x = search->corners[3 * corner + k];
            is_inside = is_inside && search->low[k] <= x && x <= search->high[k];
        }
        if (is_inside) return true;
    }
    for (size_t i = 0; i < BOX_TRIANGLES; i++) {
        uint32_t const face[3] = {3 + faces[i][0], 3 + faces[i][1], 3 + faces[i][2]};
        if (tulle_check_triangle_pair(search->corners, own, face, 0)) return true;
    }
    return false;
}

static void visit_overlap(tree_query *query, uint32_t triangle) {
    overlap_query *const search = (overlap_query *)query;
    const tulle_world *const world = search->world;
    const uint32_t *const corners = world->model.topo.triangles + 3 * (size_t)triangle;
    for (size_t k = 0; k < 3; k++)
        memcpy(search->corners + 3 * k, world->now.positions + 3 * (size_t)corners[k],
               3 * sizeof(double));
    for (size_t k = 0; k < 3; k++) {
        double const a = search->corners[k], b = search->corners[3 + k], c = search->corners[6 + k];
        if (fmin(a, fmin(b, c)) > search->high[k] || fmax(a, fmax(b, c)) < search->low[k]) return;
    }
    static const uint32_t own[3] = {0, 1, 2}, given[3] = {3, 4, 5};
    if (search->is_box ? !meets_box(search)
                       : !tulle_check_triangle_pair(search->corners, own, given, 0))
        return;
    uint32_t const surface = world->model.vertex_surface[corners[0]];
    if (search->found->count < search->found->capacity)
        search->found->triangles[search->found->count] = (tulle_found_triangle){
            tulle_world_get_object(world, surface),
            triangle - world->work.surfaces[surface].triangle_begin, search->other};
    search->found->count++;
}

/* By triangle of the given mesh, then by object and number. */
static int compare_found(const void *one, const void *two) {
    const tulle_found_triangle *const x = one, *const y = two;
    uint32_t const a[4] = {x->other, (uint32_t)x->object.kind, x->object.index, x->triangle};
    uint32_t const b[4] = {y->other, (uint32_t)y->object.kind, y->object.index, y->triangle};
    for (int k = 0; k < 4; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

static void sort_found(const tulle_found *found) {
    size_t const count = found->count < found->capacity ? found->count : found->capacity;
    sort_in_place(found->triangles, count, sizeof *found->triangles, compare_found);
}

static tulle_status check_found(tulle_found *found, tulle_error *error) {
    if (found) found->count = 0;
    if (found && (found->triangles || found->capacity == 0)) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "`found` or its memory is null");
}

tulle_status tulle_world_find_box_overlaps(tulle_world *world, const double low[3],
                                           const double high[3], uint32_t mask, tulle_found *found,
                                           tulle_error *error) {
    tulle_status status = check_found(found, error);
    if (status != TULLE_OK) return status;
    if (!low || !high)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "a side of the box is null");
    status = check_numbers(low, 3, "the low side of the box", error);
    if (status == TULLE_OK) status = check_numbers(high, 3, "the high side of the box", error);
    if (status != TULLE_OK) return status;
    for (int k = 0; k < 3; k++)
        if (low[k] > high[k])
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the box goes from %g m down to %g m along axis %d", low[k], high[k],
                             k);
    status = tulle_world_update_queries(world, error);
    if (status != TULLE_OK) return status;
    overlap_query search = {.query = {measure_overlap_boxes, visit_overlap, 0.0},
                            .world = world,
                            .is_box = true,
                            .found = found};
    memcpy(search.low, low, sizeof search.low);
    memcpy(search.high, high, sizeof search.high);
    for (size_t i = 0; i < BOX_CORNERS; i++)
        for (size_t k = 0; k < 3; k++)
            search.corners[3 * (3 + i) + k] = (i >> k) % 2 == 0 ? low[k] : high[k];
    ask(world, mask, &search.query);
    sort_found(found);
    return TULLE_OK;
}

static tulle_status check_mesh(tulle_mesh_view mesh, tulle_error *error) {
    if ((mesh.vertex_count > 0 && !mesh.positions) || (mesh.triangle_count > 0 && !mesh.triangles))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the mesh has a null array");
    if (mesh.triangle_count > UINT32_MAX)
        return error_set(error, TULLE_ERROR_INVALID_MESH, "the mesh has more than 2^32 triangles");
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++)
        if (!(fabs(mesh.positions[i]) <= COORDINATE_MAX))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "coordinate %zu of vertex %zu of the mesh is %g; it must be a number "
                             "of at most %g m",
                             i % 3, i / 3, mesh.positions[i], COORDINATE_MAX);
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        if (mesh.triangles[i] >= mesh.vertex_count)
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "triangle %zu of the mesh uses vertex %u of %zu", i / 3,
                             (unsigned)mesh.triangles[i], mesh.vertex_count);
    return TULLE_OK;
}

tulle_status tulle_world_find_mesh_overlaps(tulle_world *world, tulle_mesh_view mesh, uint32_t mask,
                                            tulle_found *found, tulle_error *error) {
    tulle_status status = check_found(found, error);
    if (status == TULLE_OK) status = check_mesh(mesh, error);
    if (status == TULLE_OK) status = tulle_world_update_queries(world, error);
    if (status != TULLE_OK) return status;
    overlap_query search = {
        .query = {measure_overlap_boxes, visit_overlap, 0.0}, .world = world, .found = found};
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        search.other = (uint32_t)t;
        for (size_t k = 0; k < 3; k++) {
            search.low[k] = (double)INFINITY;
            search.high[k] = -(double)INFINITY;
        }
        for (size_t i = 0; i < 9; i++) {
            double const x = mesh.positions[3 * (size_t)mesh.triangles[3 * t + i / 3] + i % 3];
            search.corners[9 + i] = x;
            search.low[i % 3] = fmin(search.low[i % 3], x);
            search.high[i % 3] = fmax(search.high[i % 3], x);
        }
        ask(world, mask, &search.query);
    }
    sort_found(found);
    return TULLE_OK;
}
