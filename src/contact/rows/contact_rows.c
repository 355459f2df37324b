/* contact/rows/contact_rows.c - see contact_rows.h.
 *
 * The gap of a row is linear in the displacements: gap(1) = g0 + h n . sum w u. A row asks that the
 * gap ends at the contact distance delta_c or above. A gap that starts far below it need only grow
 * at the push-out speed: bias = min((delta_c - g0) / h, push_out_speed). A body that turns moves
 * its points along arcs; what the predicted turn adds to the straight way is added to g0.
 *
 * Implicit Euler balances forces at the end of the step. So a row against an obstacle that stands
 * or shifts takes normal and weights from the predicted end. With these n . sum w x0 is no longer
 * g0. `turning` holds the difference: gap(1) = g0 + h n . (sum w u - turning). */
#include "contact/rows/contact_rows.h"

#include "contact/response.h"
#include "contact/rows/normal_cones.h"
#include "contact/rows/row_friction.h"
#include "contact/rows/row_motion.h"

#include <math.h>
#include <string.h>

/* Sine of the largest angle between the frames of start and end: 45 degrees. */
static const double LARGEST_TURN = 0.7;
/* Points that move by less than this part of the gap leave the frame as it is, so that things at
 * rest keep their frame. */
static const double LEAST_WAY = 1e-3;
/* The matrix of a motion without a turn differs from the identity by no more than this: rounding.
 */
static const double TURN_TOLERANCE = 1e-9;

void begin_contact_row(const contact_scene *scene, const double *x1, const pair_event *event,
                       contact_row *row) {
    *row = (contact_row){
        .frame.kind = event->kind, .frame.pair = event->pair, .solve.friction_cap = -1.0};
    uint32_t *const vertices = row->frame.vertices;
    feature_pair_vertices(scene->set->topo, event->kind, event->pair, vertices);
    vec3 points[4];
    for (int k = 0; k < 4; k++)
        points[k] =
            vec3_lerp(vec3_load(scene->x0, vertices[k]), vec3_load(x1, vertices[k]), event->time);
    closest_points const closest = closest_of_pair(event->kind, points);
    row->frame.normal = vec3_normalize(closest.difference);
    memcpy(row->frame.weights, closest.weights, sizeof row->frame.weights);
    set_row_bodies(scene, row);
}

/* The motion of the scripted obstacle that the row lies on, or null. */
static const affine_map *get_carrier(const contact_scene *scene, const contact_row *row) {
    if (!scene->carriers) return NULL;
    const affine_map *const first = scene->carriers[scene->vertex_surface[row->frame.vertices[0]]];
    return first ? first : scene->carriers[scene->vertex_surface[row->frame.vertices[3]]];
}

bool finish_contact_row(const contact_scene *scene, contact_row *row) {
    row_frame *const frame = &row->frame;
    if (!set_row_mobility(scene, row) || !(vec3_norm2(frame->normal) > 0.5)) return false;
    frame->gap = vec3_dot(frame->normal, blend_row_vertices(row, scene->x0));
    /* Points of the two sides are a gap apart. Cloth that turns with an obstacle would seem to slip
     * on it, and friction would undo the turn. Rows of bodies have arms instead. */
    const affine_map *const carrier = frame->has_body ? NULL : get_carrier(scene, row);
    frame->turning = vec3_make(0.0, 0.0, 0.0);
    if (carrier) {
        vec3 const offset = vec3_scale(frame->normal, frame->gap);
        vec3 const change = vec3_sub(mat3_multiply_vec3(&carrier->matrix, offset), offset);
        double const rise = vec3_dot(change, frame->normal);
        frame->turning =
            vec3_scale(vec3_add_scaled(change, frame->normal, -rise), 1.0 / scene->time_step);
    }
    double const contact =
        compute_pair_distances(scene, frame->kind, frame->vertices, NULL).contact;
    double const gap = frame->gap + compute_row_curvature(scene, row);
    double const bias = (contact - gap) / scene->time_step;
    double const most = scene->settings.push_out_speed;
    row->law.bias = bias < most ? bias : most;
    set_row_friction(scene, row);
    return true;
}

/* Whether the row is fitted to an obstacle. One side must follow a script, so that it takes up any
 * couple, and it must stand still or shift. Cloth on an obstacle that turns keeps its place by
 * `turning`. Its velocity trembles, so a frame predicted from that would let it creep. */
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

void straighten_row(const contact_scene *scene, const double *x1, double time, bool is_impact,
                    contact_row *row) {
    if (!is_fitted(scene, row)) return;
    if (is_impact && scene->ignored_count > 0) return; /* the sides may start on the wrong ones */
    double const tolerance2 = scene->settings.slope_tolerance * scene->settings.slope_tolerance;
    vec3 const normal = row->frame.normal;
    vec3 const fitted = fit_normal_to_cone(scene, x1, row, normal, time);
    bool const is_far = !(vec3_norm2(vec3_sub(fitted, normal)) <= tolerance2);
    /* A normal that leans further is fitted only where the cone is hardly more than one direction
     * or lies in a hollow: then its mirror image, too, is fitted to the same normal. */
    if (!is_impact && is_far && vec3_norm2(fitted) > 0.5) {
        vec3 const mirrored = vec3_normalize(vec3_sub(vec3_scale(fitted, 2.0), normal));
        vec3 const back = fit_normal_to_cone(scene, x1, row, mirrored, time);
        if (!(vec3_norm2(vec3_sub(back, fitted)) <= tolerance2)) return;
    }
    if (memcmp(&fitted, &normal, sizeof normal) == 0) return;
    contact_row turned = *row;
    turned.frame.normal = fitted;
    if (!finish_contact_row(scene, &turned) || !(turned.frame.gap > 0.0)) return;
    /* The distance to the obstacle does not change. A gap along the new normal is shorter, and a
     * push-out that made up for it would feed energy to stiff cloth. */
    if (!is_impact) turned.law.bias = row->law.bias;
    *row = turned;
}

/* Predicts the row's points at the end of the step; false when hardly any moves against the
 * obstacle.
 *
 * A vertex of cloth is taken to slide on as it starts, within its own surface and relative to the
 * obstacle. The rest of its velocity is noise from step to step. Edges are short, so rows that
 * followed the noise would make the cloth tremble. The motion of the row's points along its normal
 * is left out, too, because contact stops it. */
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
        vec3 const normal = compute_vertex_normal(scene, scene->x0, 0.0, vertex);
        points[k] = vec3_add(carried[k], vec3_add_scaled(way, normal, -vec3_dot(normal, way)));
    }
    vec3 across = vec3_scale(points[0], row->frame.weights[0]);
    for (int k = 1; k < 4; k++) across = vec3_add_scaled(across, points[k], row->frame.weights[k]);
    double const rise = vec3_dot(row->frame.normal, across) - row->frame.gap;
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == 0)
            points[k] = vec3_add_scaled(points[k], row->frame.normal, -rise);
    return true;
}

void turn_row_to_end(const contact_scene *scene, contact_row *row) {
    vec3 points[4];
    if (!scene->v0 || !(row->frame.gap > 0.0) || !is_fitted(scene, row)) return;
    if (!predict_end(scene, row, points)) return;
    closest_points const closest = closest_of_pair(row->frame.kind, points);

    /* The unit normal of the end. On a straight way the normal turns by an angle whose tangent is
     * way / gap. On an arc of constant gap, way / gap is the sine of the angle. So the tangent
     * found here is taken as the sine. */
    vec3 const normal = row->frame.normal, direction = vec3_normalize(closest.difference);
    double const cosine = vec3_dot(direction, normal);
    vec3 const lean = vec3_sub(vec3_scale(direction, 1.0 / cosine), normal);
    double const square = vec3_norm2(lean);
    if (!(cosine > 0.0 && square < LARGEST_TURN * LARGEST_TURN)) return;
    contact_row turned = *row;
    turned.frame.normal = vec3_normalize(vec3_add_scaled(lean, normal, sqrt(1.0 - square)));
    if (!(vec3_norm2(turned.frame.normal) > 0.5)) return;

    /* Both frames must touch the same part of the features. Where the contact crosses a rim, the
     * row of a neighbour takes over. */
    for (int k = 0; k < 4; k++) {
        bool const is_rim = fabs(closest.weights[k]) < RIM_WEIGHT;
        if ((fabs(row->frame.weights[k]) < RIM_WEIGHT) != is_rim) return;
        turned.frame.weights[k] = closest.weights[k];
    }
    if (!set_row_mobility(scene, &turned)) return;
    double const way =
        row->frame.gap - vec3_dot(turned.frame.normal, blend_row_vertices(&turned, scene->x0));
    turned.frame.turning =
        vec3_add_scaled(row->frame.turning, turned.frame.normal,
                        way / scene->time_step - vec3_dot(row->frame.turning, turned.frame.normal));
    set_row_friction(scene, &turned);
    *row = turned;
}
