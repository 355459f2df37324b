/* contact/rows/normal_cones.c - see normal_cones.h. */
#include "contact/rows/normal_cones.h"

#include <math.h>

/* A direction lies in a half-space if it leaves it by this sine at most: rounding. */
static const double CONE_TOLERANCE = 1e-12;
/* Rounds of projections on the half-spaces of a vertex's edges; six edges take ten. */
enum { MOST_ROUNDS = 40 };
/* A direction that projections shorten to less than this points into a hollow. */
static const double LEAST_LENGTH = 0.5;

/* The positions of all vertices at one time of the step. */
typedef struct cone_view {
    const contact_scene *scene;
    const double *x1;
    double time;
} cone_view;

static vec3 point_at(const cone_view *view, uint32_t vertex) {
    return vec3_lerp(vec3_load(view->scene->x0, vertex), vec3_load(view->x1, vertex), view->time);
}

rim_part find_rim_part(const topology *topo, const contact_row *row, uint32_t *feature) {
    int zero_count = 0, zero = 0, other = 0;
    for (int k = 0; k < 3; k++) {
        if (row->frame.weights[1 + k] > -RIM_WEIGHT) {
            zero_count++;
            zero = k;
        } else {
            other = k;
        }
    }
    if (zero_count == 0) return RIM_INSIDE;
    if (zero_count == 1) {
        *feature =
            topo->triangle_edges[3 * (size_t)row->frame.pair.second + (size_t)((zero + 1) % 3)];
        return RIM_EDGE;
    }
    *feature = row->frame.vertices[1 + other];
    return RIM_VERTEX;
}

vec3 compute_vertex_normal(const contact_scene *scene, const double *x1, double time,
                           uint32_t vertex) {
    cone_view const view = {scene, x1, time};
    const topology *const topo = scene->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
        const uint32_t *const corner = topo->triangles + 3 * (size_t)around->items[i];
        vec3 const a = point_at(&view, corner[0]);
        sum = vec3_add(sum, vec3_cross(vec3_sub(point_at(&view, corner[1]), a),
                                       vec3_sub(point_at(&view, corner[2]), a)));
    }
    return vec3_normalize(sum);
}

/* The cone of an edge lies in the plane at right angles to it, between the normals of its
 * triangles. Where the edge is hollow the cone is empty, and the mean of the two normals is taken.
 */
static vec3 fit_to_edge(const cone_view *view, uint32_t edge, vec3 outward) {
    const topology *const topo = view->scene->set->topo;
    const uint32_t *const ends = topo->edges + 2 * (size_t)edge;
    const uint32_t *const opposites = topo->edge_opposites + 2 * (size_t)edge;
    vec3 const begin = point_at(view, ends[0]);
    vec3 const along = vec3_normalize(vec3_sub(point_at(view, ends[1]), begin));
    vec3 inward[2]; /* from the edge along its triangles */
    int count = 0, above = 0, above_count = 0;
    for (int k = 0; k < 2; k++) {
        if (opposites[k] == TULLE_NONE) continue;
        vec3 const to = vec3_sub(point_at(view, opposites[k]), begin);
        vec3 const across = vec3_add_scaled(to, along, -vec3_dot(to, along));
        if (!(vec3_norm2(across) > 0.0)) continue;
        if (vec3_dot(across, outward) > CONE_TOLERANCE * vec3_norm(across)) {
            above_count++;
            above = count;
        }
        inward[count++] = across;
    }
    if (above_count == 0) return outward;
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < count; k++) {
        if (above_count == 1 && k != above) continue;
        double const length2 = vec3_norm2(inward[k]);
        vec3 const normal =
            vec3_add_scaled(outward, inward[k], -vec3_dot(outward, inward[k]) / length2);
        sum = vec3_add(sum, vec3_normalize(normal));
    }
    return vec3_normalize(sum);
}

/* The cone of a vertex is where all of its edges' half-spaces meet. Projects on one half-space
 * after the other. Where the vertex is hollow the mean normal of its triangles is taken. */
static vec3 fit_to_vertex(const cone_view *view, uint32_t vertex, vec3 outward) {
    const adjacency *const neighbours = &view->scene->set->topo->vertex_neighbours;
    vec3 const point = point_at(view, vertex);
    vec3 fitted = outward;
    bool is_above = true;
    for (int round = 0; round < MOST_ROUNDS && is_above; round++) {
        is_above = false;
        for (uint32_t i = neighbours->begin[vertex]; i < neighbours->begin[vertex + 1]; i++) {
            vec3 const to = vec3_sub(point_at(view, neighbours->items[i]), point);
            double const height = vec3_dot(fitted, to), length2 = vec3_norm2(to);
            if (!(height > CONE_TOLERANCE * sqrt(length2))) continue;
            fitted = vec3_add_scaled(fitted, to, -height / length2);
            is_above = true;
        }
    }
    if (vec3_norm2(fitted) > LEAST_LENGTH * LEAST_LENGTH) return vec3_normalize(fitted);
    vec3 const mean = compute_vertex_normal(view->scene, view->x1, view->time, vertex);
    return vec3_dot(mean, outward) < 0.0 ? vec3_neg(mean) : mean;
}

vec3 fit_normal_to_cone(const contact_scene *scene, const double *x1, const contact_row *row,
                        vec3 normal, double time) {
    cone_view const view = {scene, x1, time};
    bool const is_vertex_row = row->frame.kind == FEATURE_VERTEX_TRIANGLE;
    if (row->frame.vertices[3] >= scene->cloth_vertex_count) {
        uint32_t feature = row->frame.pair.second;
        rim_part const part =
            is_vertex_row ? find_rim_part(scene->set->topo, row, &feature) : RIM_EDGE;
        if (part == RIM_EDGE) normal = fit_to_edge(&view, feature, normal);
        if (part == RIM_VERTEX) normal = fit_to_vertex(&view, feature, normal);
    }
    if (row->frame.vertices[0] >= scene->cloth_vertex_count) {
        vec3 const outward = vec3_neg(normal);
        normal = vec3_neg(is_vertex_row ? fit_to_vertex(&view, row->frame.pair.first, outward)
                                        : fit_to_edge(&view, row->frame.pair.first, outward));
    }
    return normal;
}
