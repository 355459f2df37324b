/* detect/queries/surface_queries.c - see surface_queries.h.
 *
 * Whether a ray meets a triangle is the sign of determinants of its two ends and the corners, each
 * exact: both ends do not lie beyond one side of the plane, and the line passes all three edges on
 * the same side, or through them. Two triangles that share an edge ask the same question about it,
 * so no ray slips through between them. Where on the triangle the ray passes is rounded: the
 * weights of the corners are the determinants of the edges across.
 *
 * Boxes never leave out what counts. A ray that meets a triangle is within its box along each axis,
 * which comparisons of the given numbers tell exactly; times at which it passes the box's sides are
 * rounded, and compared with room for that. */
#include "detect/queries/surface_queries.h"

#include "geom/distance.h"
#include "geom/exact_predicates.h"

/* [m] A ray that goes on less along an axis is not divided by that: 1 / way stays finite. */
static const double WAY_MIN = 1e-290;
/* A quotient carries three roundings; twice, and somewhat more, is left between two of them. */
static const double QUOTIENT_ROOM = 0x1p-49;
/* What underflows in it is smaller. */
static const double UNDERFLOW_ROOM = 1e-300;
/* [square of the longest edge times the length of the ray] Determinants whose sum is smaller, since
 * the ray runs almost in the plane, say too little of the place. */
static const double FLAT_LIMIT = 1e-12;
/* Squared distances carry fewer roundings than this leaves room for. */
static const double SQUARE_ROOM = 1e-14;

static void load_triangle(const double *positions, const uint32_t *corners, uint32_t triangle,
                          const double *x[3]) {
    for (size_t k = 0; k < 3; k++) x[k] = positions + 3 * (size_t)corners[3 * (size_t)triangle + k];
}

/* ---- rays ---- */

/* The part of the way at which the ray enters the box of each child. */
static void measure_ray(const tree_query *query, const query_node *node,
                        double distances[QUERY_LANES]) {
    const ray_query *const ray = (const ray_query *)query;
    double enters[QUERY_LANES], leaves[QUERY_LANES];
    int is_met[QUERY_LANES];
    for (int c = 0; c < QUERY_LANES; c++) {
        enters[c] = 0.0;
        leaves[c] = 1.0;
        is_met[c] = 1;
    }
    for (int k = 0; k < 3; k++) {
        double const from = ray->from[k], inv = ray->inv_way[k];
        double const way_low = ray->low[k], way_high = ray->high[k];
        for (int c = 0; c < QUERY_LANES; c++)
            is_met[c] &= (way_low <= node->high[k][c]) & (node->low[k][c] <= way_high);
        if (inv == 0.0) continue;
        const double *const near = inv > 0.0 ? node->low[k] : node->high[k];
        const double *const far = inv > 0.0 ? node->high[k] : node->low[k];
        for (int c = 0; c < QUERY_LANES; c++) {
            double const enter = (near[c] - from) * inv, leave = (far[c] - from) * inv;
            enters[c] = enter > enters[c] ? enter : enters[c];
            leaves[c] = leave < leaves[c] ? leave : leaves[c];
        }
    }
    for (int c = 0; c < QUERY_LANES; c++) {
        bool const is_within =
            is_met[c] && enters[c] <= leaves[c] * (1.0 + QUOTIENT_ROOM) + UNDERFLOW_ROOM;
        distances[c] =
            is_within ? enters[c] * (1.0 - QUOTIENT_ROOM) - UNDERFLOW_ROOM : (double)INFINITY;
    }
}

/* Where a ray almost in the plane of a triangle passes it: on the edge that it comes nearest to,
 * the first such on its way. */
static void weigh_edges(const ray_query *ray, const double *const x[3], double weights[3]) {
    double best = (double)INFINITY, best_part = 0.0;
    for (size_t k = 0; k < 3; k++) {
        size_t const next = (k + 1) % 3;
        vec3 const points[4] = {vec3_load(ray->from, 0), vec3_load(ray->to, 0), vec3_load(x[k], 0),
                                vec3_load(x[next], 0)};
        closest_points const closest = closest_edge_edge(points);
        double const part = closest.weights[1];
        if (closest.distance2 > best || (closest.distance2 == best && part >= best_part)) continue;
        best = closest.distance2;
        best_part = part;
        weights[k] = -closest.weights[2];
        weights[next] = -closest.weights[3];
        weights[3 - k - next] = 0.0;
    }
}

/* Determinant of the way and two corners as seen from the ray's start. */
static double compute_side(const ray_query *ray, const double *a, const double *b) {
    vec3 const from = vec3_load(ray->from, 0);
    return vec3_dot(vec3_load(ray->way, 0),
                    vec3_cross(vec3_sub(vec3_load(a, 0), from), vec3_sub(vec3_load(b, 0), from)));
}

static void weigh_corners(const ray_query *ray, const double *const x[3], const int signs[3],
                          double weights[3]) {
    /* Signs are known exactly, and what has the wrong one is zero. */
    int const side = signs[0] != 0 ? signs[0] : signs[1] != 0 ? signs[1] : signs[2];
    double sum = 0.0, longest2 = 0.0;
    for (size_t k = 0; k < 3; k++) {
        const double *const a = x[(k + 1) % 3], *const b = x[(k + 2) % 3];
        double const value = signs[k] == 0 ? 0.0 : side * compute_side(ray, a, b);
        weights[k] = value > 0.0 ? value : 0.0;
        sum += weights[k];
        longest2 = fmax(longest2, vec3_norm2(vec3_sub(vec3_load(b, 0), vec3_load(a, 0))));
    }
    if (sum > FLAT_LIMIT * longest2 * ray->length && sum < (double)INFINITY)
        for (size_t k = 0; k < 3; k++) weights[k] /= sum;
    else
        weigh_edges(ray, x, weights);
}

static void visit_ray(tree_query *query, uint32_t triangle) {
    ray_query *const ray = (ray_query *)query;
    const double *x[3];
    load_triangle(ray->positions, ray->corners, triangle, x);
    for (int k = 0; k < 3; k++) {
        double const a = x[0][k], b = x[1][k], c = x[2][k];
        double const low = a < b ? (a < c ? a : c) : (b < c ? b : c);
        double const high = a > b ? (a > c ? a : c) : (b > c ? b : c);
        if (low > ray->high[k] || high < ray->low[k]) return;
    }
    /* signs[k]: on which side the line passes the edge across from corner k */
    int signs[3], least = 1, most = -1;
    for (size_t k = 0; k < 3; k++) {
        signs[k] = orient3d_sign(ray->from, ray->to, x[(k + 1) % 3], x[(k + 2) % 3], NULL);
        least = signs[k] < least ? signs[k] : least;
        most = signs[k] > most ? signs[k] : most;
        if (least * most < 0) return;
    }
    int const from_side = orient3d_sign(x[0], x[1], x[2], ray->from, NULL);
    int const to_side = orient3d_sign(x[0], x[1], x[2], ray->to, NULL);
    if (from_side == to_side) return; /* beyond one side, or both within the plane */
    if (from_side * to_side > 0 || (ray->skips_back_faces && from_side < to_side)) return;

    double weights[3];
    weigh_corners(ray, x, signs, weights);
    vec3 position = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < 3; k++)
        position = vec3_add_scaled(position, vec3_load(x[k], 0), weights[k]);
    vec3 const reached = vec3_sub(position, vec3_load(ray->from, 0));
    double const along = vec3_dot(reached, vec3_load(ray->unit, 0)) / ray->length;
    double const part = fmin(fmax(along, 0.0), 1.0);
    bool const is_first =
        part < ray->query.reach || (part == ray->query.reach && triangle < ray->hit.triangle);
    if (!is_first) return;
    ray->query.reach = part;
    ray->hit =
        (surface_hit){triangle, {weights[0], weights[1], weights[2]}, position, part * ray->length};
}

ray_query ray_query_make(const uint32_t *corners, const double *positions, const double from[3],
                         const double to[3], bool skips_back_faces) {
    ray_query ray = {.query = {measure_ray, visit_ray, 1.0},
                     .corners = corners,
                     .positions = positions,
                     .skips_back_faces = skips_back_faces,
                     .hit = {.triangle = TULLE_NONE}};
    for (int k = 0; k < 3; k++) {
        ray.from[k] = from[k];
        ray.to[k] = to[k];
        ray.low[k] = from[k] < to[k] ? from[k] : to[k];
        ray.high[k] = from[k] < to[k] ? to[k] : from[k];
        ray.way[k] = to[k] - from[k];
        if (fabs(ray.way[k]) >= WAY_MIN) ray.inv_way[k] = 1.0 / ray.way[k];
    }
    /* no square overflows or vanishes */
    double const largest = fmax(fmax(fabs(ray.way[0]), fabs(ray.way[1])), fabs(ray.way[2]));
    for (int k = 0; k < 3; k++) ray.unit[k] = ray.way[k] / largest;
    double const stretch = vec3_norm(vec3_load(ray.unit, 0));
    for (int k = 0; k < 3; k++) ray.unit[k] /= stretch;
    ray.length = largest * stretch;
    return ray;
}

/* ---- nearest points ---- */

static void measure_nearest(const tree_query *query, const query_node *node,
                            double distances[QUERY_LANES]) {
    const nearest_query *const search = (const nearest_query *)query;
    double const point[3] = {search->point.x, search->point.y, search->point.z};
    for (int c = 0; c < QUERY_LANES; c++) distances[c] = 0.0;
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < QUERY_LANES; c++) {
            double const below = node->low[k][c] - point[k], above = point[k] - node->high[k][c];
            double const outside = below > above ? below : above;
            double const gap = outside > 0.0 ? outside : 0.0;
            distances[c] += gap * gap;
        }
}

static void visit_nearest(tree_query *query, uint32_t triangle) {
    nearest_query *const search = (nearest_query *)query;
    const double *x[3];
    load_triangle(search->positions, search->corners, triangle, x);
    vec3 points[4] = {search->point};
    for (size_t k = 0; k < 3; k++) points[1 + k] = vec3_load(x[k], 0);
    closest_points const closest = closest_vertex_triangle(points);
    double const distance2 = closest.distance2;
    bool const is_nearer = distance2 < search->nearest ||
                           (distance2 == search->nearest && triangle < search->hit.triangle);
    if (!is_nearer) return;
    search->nearest = distance2;
    search->query.reach = distance2 * (1.0 + SQUARE_ROOM);
    search->hit = (surface_hit){.triangle = triangle, .distance = sqrt(distance2)};
    for (size_t k = 0; k < 3; k++) {
        double const weight = -closest.weights[1 + k];
        search->hit.weights[k] = fmin(fmax(weight, 0.0), 1.0);
        search->hit.position =
            vec3_add_scaled(search->hit.position, points[1 + k], search->hit.weights[k]);
    }
}

nearest_query nearest_query_make(const uint32_t *corners, const double *positions, vec3 point,
                                 double max_distance) {
    double const square = max_distance * max_distance;
    return (nearest_query){.query = {measure_nearest, visit_nearest, square * (1.0 + SQUARE_ROOM)},
                           .corners = corners,
                           .positions = positions,
                           .point = point,
                           .nearest = square,
                           .hit = {.triangle = TULLE_NONE}};
}
