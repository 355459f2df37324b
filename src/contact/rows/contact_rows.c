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

static vec3 blend_points(const vec3 points[4], const double weights[4]) {
    vec3 sum = vec3_scale(points[0], weights[0]);
    for (int k = 1; k < 4; k++) sum = vec3_add_scaled(sum, points[k], weights[k]);
    return sum;
}

/* Sets masses from the normal, weights and bodies; false when the row acts on too little. */
static bool set_masses(const contact_scene *scene, contact_row *row) {
    double lightest = 0.0; /* 1 / kg */
    for (int k = 0; k < 4; k++)
        lightest = fmax(lightest, scene->inverse_mass[row->frame.vertices[k]]);
    set_row_mobility(scene, row);
    double const least =
        row->frame.has_body ? 0.0 : LEAST_FREE_WEIGHT * LEAST_FREE_WEIGHT * lightest;
    return row->solve.inverse_mass > least;
}

/* What follows from normal, weights and masses: the tangential part of the row's turning, gap and
 * bias, friction. Points of the two sides are a gap apart, so what turns together would seem to
 * slip, and friction would undo the turn. Rows of bodies have arms instead. */
static void set_row_gap(const contact_scene *scene, contact_row *row) {
    row_frame *const frame = &row->frame;
    vec3 start[4];
    load_points(scene->x0, frame->vertices, start);
    frame->gap = vec3_dot(frame->normal, blend_points(start, frame->weights));
    const affine_map *carrier = NULL;
    for (int k = 0; k < 4 && !carrier && scene->carriers && !frame->has_body; k++)
        carrier = scene->carriers[scene->vertex_surface[frame->vertices[k]]];
    frame->turning = vec3_make(0.0, 0.0, 0.0);
    if (carrier) {
        vec3 const offset = vec3_scale(frame->normal, frame->gap);
        vec3 const change = vec3_sub(mat3_multiply_vec3(&carrier->matrix, offset), offset);
        double const rise = vec3_dot(change, frame->normal);
        frame->turning =
            vec3_scale(vec3_add_scaled(change, frame->normal, -rise), 1.0 / scene->time_step);
    }
    double const contact = compute_pair_distances(scene, frame->kind, frame->vertices).contact;
    double const gap = frame->gap + compute_row_curvature(scene, row);
    double const bias = (contact - gap) / scene->time_step;
    double const most = scene->settings.push_out_speed;
    row->law.bias = bias < most ? bias : most;
    set_row_friction(scene, row);
}

closest_points compute_contact_points(const contact_scene *scene, const double *x1,
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
    *row = (contact_row){.frame.kind = event->kind,
                         .frame.pair = event->pair,
                         .frame.normal = vec3_normalize(closest->difference),
                         .solve.friction_cap = -1.0};
    memcpy(row->frame.vertices, vertices, sizeof row->frame.vertices);
    memcpy(row->frame.weights, closest->weights, sizeof row->frame.weights);
    set_row_bodies(scene, row);
}

bool finish_contact_row(const contact_scene *scene, contact_row *row) {
    if (!set_masses(scene, row) || !(vec3_norm2(row->frame.normal) > 0.5)) return false;
    set_row_gap(scene, row);
    return true;
}

bool make_contact_row(const contact_scene *scene, const double *x1, const pair_event *event,
                      contact_row *row) {
    uint32_t vertices[4];
    closest_points const closest = compute_contact_points(scene, x1, event, vertices);
    begin_contact_row(scene, event, vertices, &closest, row);
    return finish_contact_row(scene, row);
}

/* The motion of what the row lies on, if that is a scripted obstacle with one; else null. */
static const affine_map *get_carrier(const contact_scene *scene, const contact_row *row) {
    if (!scene->carriers) return NULL;
    const affine_map *const first = scene->carriers[scene->vertex_surface[row->frame.vertices[0]]];
    return first ? first : scene->carriers[scene->vertex_surface[row->frame.vertices[3]]];
}

/* Whether the row is fitted to an obstacle: one side follows a script, so that it takes up any
 * couple, and stands still or shifts. What rides on an obstacle that turns keeps its place by
 * set_row_gap; predicted from its velocity, which trembles, the frame would let it creep. */
static bool is_fitted(const contact_scene *scene, const contact_row *row) {
    const uint32_t *const vertices = row->frame.vertices;
    size_t const cloth_count = scene->cloth_vertex_count;
    bool const has_script =
        !row->frame.has_body && (vertices[0] >= cloth_count || vertices[3] >= cloth_count);
    if (!scene->response->fits_rows || !has_script) return false;
    const affine_map *const carrier = get_carrier(scene, row);
    double largest = 0.0;
    for (int i = 0; i < 9 && carrier; i++)
        largest = fmax(largest, fabs(carrier->matrix.m[i] - (i % 4 == 0 ? 1.0 : 0.0)));
    if (carrier) return largest < TURN_TOLERANCE;
    for (int k = 0; k < 4; k++) {
        size_t const at = 3 * (size_t)vertices[k];
        if (vertices[k] >= cloth_count &&
            memcmp(scene->targets + at, scene->x0 + at, 3 * sizeof(double)) != 0)
            return false;
    }
    return true;
}

/* Gives the row another normal, if it can act along that. */
static bool take_normal(const contact_scene *scene, contact_row *row, vec3 normal) {
    if (!(vec3_norm2(normal) > 0.5)) return false;
    contact_row turned = *row;
    turned.frame.normal = normal;
    if (!set_masses(scene, &turned)) return false;
    set_row_gap(scene, &turned);
    if (!(turned.frame.gap > 0.0)) return false;
    *row = turned;
    return true;
}

void straighten_row(const contact_scene *scene, const double *x1, double time, contact_row *row) {
    if (!is_fitted(scene, row)) return;
    double const tolerance2 = scene->settings.slope_tolerance * scene->settings.slope_tolerance;
    vec3 const normal = row->frame.normal;
    vec3 const fitted = fit_normal_to_cone(scene, x1, row, normal, time);
    /* a normal that leans further is fitted only where the cone is hardly more than one direction
     * or lies in a hollow: then its mirror image, too, is fitted to the same normal */
    if (vec3_norm2(fitted) > 0.5 && !(vec3_norm2(vec3_sub(fitted, normal)) <= tolerance2)) {
        vec3 const mirrored = vec3_normalize(vec3_sub(vec3_scale(fitted, 2.0), normal));
        vec3 const back = fit_normal_to_cone(scene, x1, row, mirrored, time);
        if (!(vec3_norm2(vec3_sub(back, fitted)) <= tolerance2)) return;
    }
    if (memcmp(&fitted, &normal, sizeof normal) == 0) return;
    /* the way to the obstacle stays what it is: a gap along the new normal is shorter, and a
     * push-out that made up for it would feed stiff cloth energy */
    double const bias = row->law.bias;
    if (take_normal(scene, row, fitted)) row->law.bias = bias;
}

void straighten_impact(const contact_scene *scene, const double *x1, double time,
                       contact_row *row) {
    if (!is_fitted(scene, row)) return;
    if (scene->ignored_count > 0) return; /* the sides may start on the wrong ones */
    vec3 const normal = fit_normal_to_cone(scene, x1, row, row->frame.normal, time);
    if (memcmp(&normal, &row->frame.normal, sizeof normal) != 0) take_normal(scene, row, normal);
}

/* The normal of cloth at a vertex at the start, from the areas of its triangles. */
static vec3 compute_vertex_normal(const contact_scene *scene, uint32_t vertex) {
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

/* Predicted points of the step's end; false when hardly any moves against the obstacle.
 *
 * A vertex of cloth slides on as it starts: within its own surface, relative to the obstacle. The
 * rest of its velocity is noise from step to step, and edges are short: rows that follow it make
 * the cloth tremble. The way of the row's points along its normal is left out, too: contact stops
 * it. */
static bool predict_end(const contact_scene *scene, const contact_row *row, vec3 points[4]) {
    const affine_map *const carrier = get_carrier(scene, row);
    double const least = LEAST_WAY * row->frame.gap;
    vec3 start[4], carried[4]; /* carried: where points end that ride along */
    bool has_moved = false;
    load_points(scene->x0, row->frame.vertices, start);
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        carried[k] = start[k];
        if (carrier)
            carried[k] = vec3_add(mat3_multiply_vec3(&carrier->matrix, start[k]), carrier->offset);
        points[k] = scene->inverse_mass[vertex] > 0.0
                        ? vec3_add_scaled(start[k], vec3_load(scene->v0, vertex), scene->time_step)
                        : vec3_load(scene->targets, vertex);
        has_moved |= vec3_norm2(vec3_sub(points[k], carried[k])) > least * least;
    }
    if (!has_moved) return false;
    for (int k = 0; k < 4; k++) {
        uint32_t const vertex = row->frame.vertices[k];
        if (!(scene->inverse_mass[vertex] > 0.0)) continue;
        vec3 const way = vec3_sub(points[k], carried[k]);
        vec3 const normal = compute_vertex_normal(scene, vertex);
        points[k] = vec3_add(carried[k], vec3_add_scaled(way, normal, -vec3_dot(normal, way)));
    }
    double const rise =
        vec3_dot(row->frame.normal, blend_points(points, row->frame.weights)) - row->frame.gap;
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == 0)
            points[k] = vec3_add_scaled(points[k], row->frame.normal, -rise);
    return true;
}

void turn_row_to_end(const contact_scene *scene, contact_row *row) {
    vec3 points[4], start[4];
    if (!scene->v0 || !(row->frame.gap > 0.0) || !is_fitted(scene, row)) return;
    if (!predict_end(scene, row, points)) return;
    closest_points const closest = closest_of_pair(row->frame.kind, points);

    /* the unit normal of the end, from that of the start and the direction after a straight way,
     * whose angle has the tangent that the sine of the angle on an arc is */
    vec3 const normal = row->frame.normal, direction = vec3_normalize(closest.difference);
    double const cosine = vec3_dot(direction, normal);
    vec3 const lean = vec3_sub(vec3_scale(direction, 1.0 / cosine), normal);
    double const square = vec3_norm2(lean);
    if (!(cosine > 0.0 && square < LARGEST_TURN * LARGEST_TURN)) return;
    contact_row turned = *row;
    turned.frame.normal = vec3_normalize(vec3_add_scaled(lean, normal, sqrt(1.0 - square)));
    if (!(vec3_norm2(turned.frame.normal) > 0.5)) return;

    /* both must touch the same features: at the rim of an edge or a triangle a neighbour goes on */
    for (int k = 0; k < 4; k++) {
        bool const is_rim = fabs(closest.weights[k]) < RIM_WEIGHT;
        if ((fabs(row->frame.weights[k]) < RIM_WEIGHT) != is_rim) return;
        turned.frame.weights[k] = closest.weights[k];
    }
    if (!set_masses(scene, &turned)) return;
    load_points(scene->x0, row->frame.vertices, start);
    double const way =
        row->frame.gap - vec3_dot(turned.frame.normal, blend_points(start, turned.frame.weights));
    turned.frame.turning =
        vec3_add_scaled(row->frame.turning, turned.frame.normal,
                        way / scene->time_step - vec3_dot(row->frame.turning, turned.frame.normal));
    set_row_friction(scene, &turned);
    *row = turned;
}
