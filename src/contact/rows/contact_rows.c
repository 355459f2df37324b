/* contact/rows/contact_rows.c - see contact_rows.h.
 *
 * The gap of a row is linear in the displacements: gap(1) = g0 + h n . sum w u. A row asks that it
 * ends no lower than the contact distance delta_c, or, where it starts lower, that it grows at the
 * push-out speed: bias = min((delta_c - g0) / h, push_out_speed). Where a body turns, what its
 * predicted turn adds to the linear displacement counts as a part of g0.
 *
 * Implicit Euler balances forces at the end of the step, so a row against an obstacle that stands
 * or shifts takes normal and weights from the predicted end. What n . sum w x0 then lacks to g0 is
 * in `turning`: gap(1) = g0 + h n . (sum w u - turning). */
#include "contact/rows/contact_rows.h"

#include "contact/response.h"
#include "contact/rows/normal_cones.h"
#include "contact/rows/row_friction.h"
#include "contact/rows/row_motion.h"

#include <math.h>
#include <string.h>

/* Sine of the largest angle between the frames of start and end: 45 degrees. */
static const double LARGEST_TURN = 0.7;
/* Ways under this part of the gap leave the frame as it is: what rests keeps its frame. */
static const double LEAST_WAY = 1e-3;
/* Entries by which the matrix of a motion without a turn may differ from the identity: rounding. */
static const double TURN_TOLERANCE = 1e-9;

/* A row acts on what can move if this much of one side's weight lies on it. With less, as where an
 * edge lies under a held one, the impulse that moves the row would throw the free vertex away. */
static const double LEAST_FREE_WEIGHT = 0.01;

static double find_bias(const contact_scene *scene, double gap, double contact_distance) {
    double const bias = (contact_distance - gap) / scene->time_step;
    return bias < scene->settings.push_out_speed ? bias : scene->settings.push_out_speed;
}

static vec3 blend_points(const vec3 points[4], const double weights[4]) {
    vec3 sum = vec3_scale(points[0], weights[0]);
    for (int k = 1; k < 4; k++) sum = vec3_add_scaled(sum, points[k], weights[k]);
    return sum;
}

/* The least inverse mass of a row that acts. */
static double find_least_mobility(const contact_scene *scene, const contact_row *row) {
    double lightest = 0.0; /* 1 / kg */
    for (int k = 0; k < 4; k++)
        lightest = fmax(lightest, scene->inverse_mass[row->frame.vertices[k]]);
    return row->frame.has_body ? 0.0 : LEAST_FREE_WEIGHT * LEAST_FREE_WEIGHT * lightest;
}

/* What follows from normal, weights and mobility. */
static void set_row_gap(const contact_scene *scene, contact_row *row) {
    vec3 start[4];
    for (int k = 0; k < 4; k++) start[k] = vec3_load(scene->x0, row->frame.vertices[k]);
    pair_distances const distances =
        find_pair_distances(scene, row->frame.kind, row->frame.vertices);
    row->frame.gap = vec3_dot(row->frame.normal, blend_points(start, row->frame.weights));
    set_row_turning(scene, row);
    row->law.bias =
        find_bias(scene, row->frame.gap + find_row_curvature(scene, row), distances.contact);
    set_row_friction(scene, row);
}

closest_points find_contact_points(const contact_scene *scene, const double *x1,
                                   const pair_event *event, uint32_t vertices[4]) {
    vec3 points[4];
    feature_pair_vertices(scene->set->topo, event->kind, event->pair, vertices);
    for (int k = 0; k < 4; k++)
        points[k] =
            vec3_lerp(vec3_load(scene->x0, vertices[k]), vec3_load(x1, vertices[k]), event->time);
    return closest_of_pair(event->kind, points);
}

void begin_contact_row(const contact_scene *scene, const pair_event *event,
                       const uint32_t vertices[4], const closest_points *closest,
                       contact_row *row) {
    *row = (contact_row){
        .frame.kind = event->kind, .frame.pair = event->pair, .solve.friction_cap = -1.0};
    memcpy(row->frame.vertices, vertices, sizeof row->frame.vertices);
    memcpy(row->frame.weights, closest->weights, sizeof row->frame.weights);
    row->frame.normal = vec3_normalize(closest->difference);
    set_row_bodies(scene, row);
}

bool finish_contact_row(const contact_scene *scene, contact_row *row) {
    set_row_mobility(scene, row);
    if (!(row->solve.inverse_mass > find_least_mobility(scene, row))) return false;
    if (!(vec3_norm2(row->frame.normal) > 0.5)) return false;
    set_row_gap(scene, row);
    return true;
}

bool make_contact_row(const contact_scene *scene, const double *x1, const pair_event *event,
                      contact_row *row) {
    uint32_t vertices[4];
    closest_points const closest = find_contact_points(scene, x1, event, vertices);
    begin_contact_row(scene, event, vertices, &closest, row);
    return finish_contact_row(scene, row);
}

static const affine_map *find_carrier(const contact_scene *scene, const contact_row *row) {
    if (!scene->carriers) return NULL;
    const affine_map *const first = scene->carriers[scene->vertex_surface[row->frame.vertices[0]]];
    return first ? first : scene->carriers[scene->vertex_surface[row->frame.vertices[3]]];
}

/* Whether the scripted side stands still or shifts. What rides on one that turns keeps its place by
 * set_row_turning; predicted from its velocity, which trembles, the frame would let it creep. */
static bool is_shifted_only(const contact_scene *scene, const contact_row *row) {
    const affine_map *const carrier = find_carrier(scene, row);
    double largest = 0.0;
    if (carrier)
        for (int i = 0; i < 9; i++)
            largest = fmax(largest, fabs(carrier->matrix.m[i] - (i % 4 == 0 ? 1.0 : 0.0)));
    if (carrier) return largest < TURN_TOLERANCE;
    for (int k = 0; k < 4; k++) {
        size_t const at = 3 * (size_t)row->frame.vertices[k];
        if (row->frame.vertices[k] >= scene->cloth_vertex_count &&
            memcmp(scene->targets + at, scene->x0 + at, 3 * sizeof(double)) != 0)
            return false;
    }
    return true;
}

/* Whether one side follows a script: what is outside takes up any couple. */
static bool has_scripted_side(const contact_scene *scene, const contact_row *row) {
    size_t const cloth_count = scene->cloth_vertex_count;
    return !row->frame.has_body &&
           (row->frame.vertices[0] >= cloth_count || row->frame.vertices[3] >= cloth_count);
}

static bool is_near(vec3 a, vec3 b, double tolerance) {
    return vec3_norm2(vec3_sub(a, b)) <= tolerance * tolerance;
}

/* The row's normal in the normal cone of the obstacle's feature, if it was not far off, or that
 * cone is hardly more than one direction or lies in a hollow. */
static vec3 find_straight_normal(const contact_scene *scene, const double *x1, double time,
                                 const contact_row *row) {
    double const tolerance = scene->settings.slope_tolerance;
    vec3 const normal = row->frame.normal;
    vec3 const fitted = fit_normal_to_cone(scene, x1, row, normal, time);
    if (!(vec3_norm2(fitted) > 0.5) || is_near(fitted, normal, tolerance)) return fitted;
    vec3 const mirrored = vec3_normalize(vec3_sub(vec3_scale(fitted, 2.0), normal));
    vec3 const back = fit_normal_to_cone(scene, x1, row, mirrored, time);
    return is_near(back, fitted, tolerance) ? fitted : normal;
}

/* The row with another normal, if it can act along that. */
static bool take_normal(const contact_scene *scene, contact_row *row, vec3 normal) {
    if (!(vec3_norm2(normal) > 0.5)) return false;
    contact_row turned = *row;
    turned.frame.normal = normal;
    set_row_mobility(scene, &turned);
    if (!(turned.solve.inverse_mass > find_least_mobility(scene, &turned))) return false;
    set_row_gap(scene, &turned);
    if (!(turned.frame.gap > 0.0)) return false;
    *row = turned;
    return true;
}

void straighten_row(const contact_scene *scene, const double *x1, double time, contact_row *row) {
    if (!scene->response->fits_rows || !has_scripted_side(scene, row)) return;
    if (!is_shifted_only(scene, row)) return;
    vec3 const normal = find_straight_normal(scene, x1, time, row);
    if (memcmp(&normal, &row->frame.normal, sizeof normal) == 0) return;
    /* the way to the obstacle stays what it is: a gap along the new normal is shorter, and a
     * push-out that made up for it would feed stiff cloth energy */
    double const bias = row->law.bias;
    if (take_normal(scene, row, normal)) row->law.bias = bias;
}

void straighten_impact(const contact_scene *scene, const double *x1, double time,
                       contact_row *row) {
    if (!scene->response->fits_rows || !has_scripted_side(scene, row)) return;
    if (!is_shifted_only(scene, row)) return;
    if (scene->ignored_count > 0) return; /* the sides may start on the wrong ones */
    vec3 const normal = fit_normal_to_cone(scene, x1, row, row->frame.normal, time);
    if (memcmp(&normal, &row->frame.normal, sizeof normal) != 0) take_normal(scene, row, normal);
}

static vec3 find_vertex_normal(const contact_scene *scene, uint32_t vertex) {
    const topology *const topo = scene->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
        const uint32_t *const corner = topo->triangles + 3 * (size_t)around->items[i];
        vec3 const a = vec3_load(scene->x0, corner[0]);
        sum = vec3_add(sum, vec3_cross(vec3_sub(vec3_load(scene->x0, corner[1]), a),
                                       vec3_sub(vec3_load(scene->x0, corner[2]), a)));
    }
    return vec3_normalize(sum);
}

/* Where a point ends that rides along. */
static vec3 carry(const affine_map *carrier, vec3 start) {
    return carrier ? vec3_add(mat3_multiply_vec3(&carrier->matrix, start), carrier->offset) : start;
}

/* Where a vertex of cloth ends that slides on as it starts: within its own surface, relative to the
 * obstacle. The rest of its velocity is noise from step to step, and edges are short: rows that
 * follow it make the cloth tremble. */
static vec3 slide_vertex(const contact_scene *scene, const affine_map *carrier, uint32_t vertex) {
    vec3 const start = vec3_load(scene->x0, vertex);
    vec3 const carried = carry(carrier, start);
    vec3 const free = vec3_add_scaled(start, vec3_load(scene->v0, vertex), scene->time_step);
    vec3 const way = vec3_sub(free, carried);
    vec3 const normal = find_vertex_normal(scene, vertex);
    return vec3_add(carried, vec3_add_scaled(way, normal, -vec3_dot(normal, way)));
}

/* Predicted points of the step's end; false when hardly any moves against the obstacle. The way of
 * the row's points along its normal is left out: contact stops it. */
static bool predict_end(const contact_scene *scene, const contact_row *row, vec3 points[4]) {
    const affine_map *const carrier = find_carrier(scene, row);
    double const least = LEAST_WAY * row->frame.gap;
    bool has_moved = false;
    for (int k = 0; k < 4 && !has_moved; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        vec3 const start = vec3_load(scene->x0, vertex);
        vec3 const end =
            scene->inverse_mass[vertex] > 0.0
                ? vec3_add_scaled(start, vec3_load(scene->v0, vertex), scene->time_step)
                : vec3_load(scene->targets, vertex);
        has_moved = vec3_norm2(vec3_sub(end, carry(carrier, start))) > least * least;
    }
    if (!has_moved) return false;
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        points[k] = scene->inverse_mass[vertex] > 0.0 ? slide_vertex(scene, carrier, vertex)
                                                      : vec3_load(scene->targets, vertex);
    }
    double const rise =
        vec3_dot(row->frame.normal, blend_points(points, row->frame.weights)) - row->frame.gap;
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == 0)
            points[k] = vec3_add_scaled(points[k], row->frame.normal, -rise);
    return true;
}

/* Whether both touch the same features: at the rim of an edge or a triangle a neighbour goes on. */
static bool has_same_rims(const double a[4], const double b[4]) {
    for (int k = 0; k < 4; k++)
        if ((fabs(a[k]) < RIM_WEIGHT) != (fabs(b[k]) < RIM_WEIGHT)) return false;
    return true;
}

/* The unit normal of the end, from that of the start and the direction after a straight way, whose
 * angle has the tangent that the sine of the angle on an arc is; zero where it turns too far. */
static vec3 turn_normal(vec3 normal, vec3 direction) {
    double const cosine = vec3_dot(direction, normal);
    vec3 const way = vec3_sub(vec3_scale(direction, 1.0 / cosine), normal);
    double const square = vec3_norm2(way);
    if (!(cosine > 0.0 && square < LARGEST_TURN * LARGEST_TURN)) return vec3_make(0.0, 0.0, 0.0);
    return vec3_normalize(vec3_add_scaled(way, normal, sqrt(1.0 - square)));
}

void turn_row_to_end(const contact_scene *scene, contact_row *row) {
    vec3 points[4], start[4];
    if (!scene->response->fits_rows || !scene->v0 || !(row->frame.gap > 0.0)) return;
    if (!has_scripted_side(scene, row) || !is_shifted_only(scene, row)) return;
    if (!predict_end(scene, row, points)) return;
    closest_points const closest = closest_of_pair(row->frame.kind, points);
    contact_row turned = *row;
    turned.frame.normal = turn_normal(row->frame.normal, vec3_normalize(closest.difference));
    if (!(vec3_norm2(turned.frame.normal) > 0.5) ||
        !has_same_rims(row->frame.weights, closest.weights))
        return;
    for (int k = 0; k < 4; k++) {
        turned.frame.weights[k] = closest.weights[k];
        start[k] = vec3_load(scene->x0, row->frame.vertices[k]);
    }
    set_row_mobility(scene, &turned);
    if (!(turned.solve.inverse_mass > find_least_mobility(scene, &turned))) return;
    double const way =
        row->frame.gap - vec3_dot(turned.frame.normal, blend_points(start, turned.frame.weights));
    turned.frame.turning =
        vec3_add_scaled(row->frame.turning, turned.frame.normal,
                        way / scene->time_step - vec3_dot(row->frame.turning, turned.frame.normal));
    set_row_friction(scene, &turned);
    *row = turned;
}
