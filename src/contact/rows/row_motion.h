/* contact/rows/row_motion.h - how a row moves with the vertices that it touches, and with rigid
 * bodies through the two slots of each.
 *
 * A side of a row that lies on a body adds  s V + w x a  to the row's velocity: V and w are the
 * body's slots, a = sum w_i r_i is the side's arm, and s is 1 for the first side and -1 for the
 * second. The velocities of the side's own vertices are then not read. An impulse p on the row adds
 * s p to the body's momentum and a x p to its spin. */
#ifndef TULLE_CONTACT_ROWS_ROW_MOTION_H
#define TULLE_CONTACT_ROWS_ROW_MOTION_H

#include "contact/contact_types.h"

/* sum w_i x_i over the four vertices, of cloth or not. */
static inline vec3 blend_row_vertices(const contact_row *row, const double *x) {
    vec3 sum = vec3_scale(vec3_load(x, row->frame.vertices[0]), row->frame.weights[0]);
    for (int k = 1; k < 4; k++)
        sum = vec3_add_scaled(sum, vec3_load(x, row->frame.vertices[k]), row->frame.weights[k]);
    return sum;
}

/* [N s] */
static inline double get_normal_impulse(const contact_row *row) {
    return vec3_dot(row->frame.normal, row->solve.impulse);
}

/* 0 or 1: the side that vertex k of the row belongs to. */
static inline int get_row_side(const contact_row *row, int k) {
    return k >= (row->frame.kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2);
}

/* Whether vertex k counts by itself, not by the slots of a body. */
static inline bool is_row_vertex(const contact_row *row, int k) {
    return !row->frame.has_body || row->frame.slots[get_row_side(row, k)] == TULLE_NONE;
}

/* The free body of a side, or null. */
static inline const contact_body *find_side_body(const contact_scene *scene, const contact_row *row,
                                                 int side) {
    if (!row->frame.has_body || row->frame.slots[side] == TULLE_NONE) return NULL;
    return &scene->bodies[(row->frame.slots[side] - scene->cloth_vertex_count) / 2];
}

/* Velocity [m/s] of the first feature relative to the second, of a row with bodies or a tilt: the
 * sum of their parts and of the vertices that count by themselves. */
vec3 get_coupled_velocity(const contact_row *row, const double *u);

/* Velocity [m/s] of the first feature relative to the second at the contact, less the row's
 * `turning`, at which the contact keeps its place. */
static inline vec3 get_relative_velocity(const contact_row *row, const double *u) {
    vec3 const of_points =
        row->frame.has_body ? get_coupled_velocity(row, u) : blend_row_vertices(row, u);
    return vec3_sub(of_points, row->frame.turning);
}

/* The part that vertices and bodies with mass have in the relative velocity [m/s]. */
vec3 get_free_velocity(const contact_scene *scene, const contact_row *row, const double *u);

/* The next three see the unknowns of the solve: slots, and the vertices of cloth, which are those
 * before cloth_count. J maps velocities of the unknowns to that of the row. */

/* J u [m/s]. */
vec3 get_solved_velocity(const contact_row *row, size_t cloth_count, const double *u);
/* Adds J^T impulse. */
void add_row_impulse(const contact_row *row, size_t cloth_count, vec3 impulse, double *sum);
/* Adds J^T stiffness J to diagonal blocks of 9 doubles. */
void add_row_blocks(const contact_row *row, size_t cloth_count, const mat3 *stiffness,
                    double *blocks);
/* n . J D^-1 J^T n [1/kg] with D the diagonal blocks of a matrix over unknowns, without vertices
 * that cannot move. */
double measure_row_mobility(const contact_scene *scene, const contact_row *row,
                            const double *blocks);

/* Changes u of all that has mass by an impulse on the row, in the metric of the masses. */
void move_row(const contact_scene *scene, const contact_row *row, vec3 impulse, double *u);

/* Fills slots and arms of the row's bodies, from vertices and weights. */
void set_row_bodies(const contact_scene *scene, contact_row *row);
/* Sets inverse_mass from the normal too, and with bodies the answers to normal and tangential
 * impulses. False when the row acts on too little to move it. */
bool set_row_mobility(const contact_scene *scene, contact_row *row);

/* [m] What predicted turns of bodies add to the row's vector, and to its gap, beyond h w x arm. */
vec3 get_row_curvature(const contact_scene *scene, const contact_row *row);
double compute_row_curvature(const contact_scene *scene, const contact_row *row);

#endif
