/* contact/solve/body_drives.h - bodies that are damped, driven and locked: how they answer
 * impulses, and what their drives give.
 *
 * Along each axis of the world a drive gives the impulse  push - gain u, but never more than its
 * limit: a spring and a damper that are part of the implicit solve. An axis below its limit adds
 * its gain to the mass or the inertia. One at the limit gives a constant impulse. A locked axis
 * has u = 0. */
#ifndef TULLE_CONTACT_SOLVE_BODY_DRIVES_H
#define TULLE_CONTACT_SOLVE_BODY_DRIVES_H

#include "contact/contact_types.h"

/* What an axis adds to the mass or the inertia. */
static inline double get_drive_gain(const body_drive *drive, int k) {
    return drive->states[k] == DRIVE_FOLLOWS ? drive->gains[k] : 0.0;
}

/* Inverse of a symmetric positive definite matrix on the axes that are not locked; zero on the
 * others. */
mat3 compute_free_inverse(const mat3 *matrix, const bool is_locked[3]);
/* Mass [kg] and inertia [kg m^2] in the linear system. */
static inline double get_system_mass(const contact_body *body) {
    return body->mass_factor * body->body->mass;
}
static inline mat3 get_system_inertia(const contact_body *body) {
    return mat3_scale(&body->inertia, body->inertia_factor);
}

/* Sets inverse_mass and inverse_inertia from the damping and what the drive does now. */
void update_body_answers(contact_body *body);

/* Entries of the linear system: the right-hand side and diagonal blocks of both slots. Those of a
 * locked axis are 0 and 1. */
typedef struct body_system {
    vec3 momentum, spin;
    mat3 mass, inertia;
} body_system;
body_system make_body_system(const contact_body *body);
/* Puts 0 in place of what is locked in a vector over slots. */
void clear_locked(const contact_scene *scene, double *vector);
/* Makes the entries of locked axes 0 and 1 again, once rows are in them. */
void fix_locked(const contact_scene *scene, double *right_hand_side, double *diagonal);

/* Chooses what each drive does anew for u, in which the rows have their impulses: a drive that
 * would give more than its limit gives the limit from here on, and u changes by that. Sets what
 * the drives give, and the answers of rows of what has changed. True if anything has. */
bool settle_drives(const contact_scene *scene, contact_row *rows, size_t count, double *u);
/* project_impulses, and settle_drives after it, until no drive changes what it does. */
tulle_status project_driven_impulses(const contact_scene *scene, contact_row *rows, size_t count,
                                     double *u);
/* Drives give no more, and nothing damps, as for the laws of impact. */
void rest_bodies(const contact_scene *scene, contact_row *rows, size_t count);
/* Sets the answers of all rows on driven and damped bodies. */
void update_body_rows(const contact_scene *scene, contact_row *rows, size_t count);

#endif
