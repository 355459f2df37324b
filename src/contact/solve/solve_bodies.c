/* contact/solve/solve_bodies.c - see solve_bodies.h. */
#include "contact/solve/solve_bodies.h"

#include "contact/rows/row_motion.h"
#include "contact/solve/body_drives.h"

#include <string.h>

void fill_body_system(const contact_scene *scene, double *right_hand_side, double *diagonal) {
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b);
        body_system const none = {.mass = mat3_identity(1.0), .inertia = mat3_identity(1.0)};
        body_system const own = body->is_free ? make_body_system(body) : none;
        vec3_store(right_hand_side, slot, own.momentum);
        vec3_store(right_hand_side, slot + 1, own.spin);
        memcpy(diagonal + 9 * slot, &own.mass, sizeof own.mass);
        memcpy(diagonal + 9 * (slot + 1), &own.inertia, sizeof own.inertia);
    }
}

void start_bodies(const contact_scene *scene, const row_list *list, double *u) {
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b);
        memset(u + 3 * slot, 0, 6 * sizeof(double));
        if (!body->is_free) continue;
        body_system const own = make_body_system(body);
        vec3 const a = body->inverse_mass, p = own.momentum;
        vec3_store(u, slot, vec3_make(a.x * p.x, a.y * p.y, a.z * p.z));
        vec3_store(u, slot + 1, mat3_multiply_vec3(&body->inverse_inertia, own.spin));
    }
    for (size_t i = 0; list && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body || !(get_normal_impulse(row) > 0.0)) continue;
        for (int side = 0; side < 2; side++) {
            size_t const slot = row->frame.slots[side];
            if (slot != TULLE_NONE) memcpy(u + 3 * slot, scene->v0 + 3 * slot, 6 * sizeof(double));
        }
    }
}

void apply_bodies(const contact_scene *scene, const double *x, double *y) {
    for (size_t b = 0; b < scene->body_count; b++) {
        const contact_body *const body = &scene->bodies[b];
        size_t const slot = get_body_slot(scene, b);
        memset(y + 3 * slot, 0, 6 * sizeof(double));
        if (!body->is_free) continue;
        mat3 const inertia = get_system_inertia(body);
        vec3_store(y, slot, vec3_scale(vec3_load(x, slot), get_system_mass(body)));
        vec3_store(y, slot + 1, mat3_multiply_vec3(&inertia, vec3_load(x, slot + 1)));
        for (int k = 0; body->drive && k < BODY_AXES; k++)
            y[3 * slot + (size_t)k] += get_drive_gain(body->drive, k) * x[3 * slot + (size_t)k];
    }
}

/* The blocks are symmetric and positive definite: Cramer's rule. */
void precondition_bodies(const contact_scene *scene, const double *diagonal, const double *r,
                         double *z) {
    for (size_t i = 0; i < 2 * scene->body_count; i++) {
        size_t const slot = scene->cloth_vertex_count + i;
        vec3_store(z, slot, vec3_make(0.0, 0.0, 0.0));
        if (!scene->bodies[i / 2].is_free) continue;
        const double *const m = diagonal + 9 * slot;
        vec3 const b = vec3_load(r, slot);
        vec3 const c0 = {m[0], m[3], m[6]}, c1 = {m[1], m[4], m[7]}, c2 = {m[2], m[5], m[8]};
        vec3 const n = vec3_cross(c1, c2);
        double const scale = 1.0 / vec3_dot(c0, n);
        vec3_store(z, slot,
                   vec3_make(scale * vec3_dot(b, n), scale * vec3_dot(c0, vec3_cross(b, c2)),
                             scale * vec3_dot(c0, vec3_cross(c1, b))));
    }
}
