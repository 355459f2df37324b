/* contact/contact_rows.c - see contact_rows.h.
 *
 * The gap of a row is linear in the displacements: gap(1) = g0 + h n . sum w u. A row asks that it
 * ends no lower than the contact distance delta_c, or, where it starts lower, that it grows at the
 * push-out speed: bias = min((delta_c - g0) / h, push_out_speed). Where a body turns, what its
 * predicted turn adds to the linear displacement counts as a part of g0. */
#include "contact/contact_rows.h"

#include "contact/row_friction.h"
#include "contact/row_motion.h"

#include <math.h>

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

bool make_contact_row(const contact_scene *scene, const double *x1, const pair_event *event,
                      contact_row *row) {
    *row = (contact_row){.kind = event->kind, .pair = event->pair, .friction_cap = -1.0};
    feature_pair_vertices(scene->set->topo, event->kind, event->pair, row->vertices);
    vec3 start[4], points[4];
    for (int k = 0; k < 4; k++) {
        start[k] = vec3_load(scene->x0, row->vertices[k]);
        points[k] = vec3_lerp(start[k], vec3_load(x1, row->vertices[k]), event->time);
    }
    closest_points const closest = closest_of_pair(event->kind, points);
    row->normal = vec3_normalize(closest.difference);
    double lightest = 0.0; /* 1 / kg */
    for (int k = 0; k < 4; k++) {
        row->weights[k] = closest.weights[k];
        lightest = fmax(lightest, scene->inverse_mass[row->vertices[k]]);
    }
    set_row_bodies(scene, row);
    set_row_mobility(scene, row);
    double const least = row->has_body ? 0.0 : LEAST_FREE_WEIGHT * LEAST_FREE_WEIGHT * lightest;
    if (!(row->inverse_mass > least) || !(vec3_norm2(row->normal) > 0.5)) return false;
    pair_distances const distances = find_pair_distances(scene, event->kind, row->vertices);
    row->gap = vec3_dot(row->normal, blend_points(start, row->weights));
    set_row_turning(scene, row);
    row->bias = find_bias(scene, row->gap + find_row_curvature(scene, row), distances.contact);
    set_row_friction(scene, row);
    return true;
}
