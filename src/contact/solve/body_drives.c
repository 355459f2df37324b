/* contact/solve/body_drives.c - see body_drives.h.
 *
 * The limit makes the drive a problem of complementarity with six unknowns a body. It is solved by
 * active sets: each axis either follows its spring or gives its limit; the body is solved for that,
 * with the impulses of its rows as they are; axes that disagree with the result change sides. The
 * centre's axes are by themselves, so one change is right at once. Those of the turn are coupled by
 * the inertia. After a few rounds axes only go to their limits, so it ends, and what a drive gives
 * is never above its limit.
 *
 * Based on: Catto, Soft constraints, 2011 (a spring as an implicit term of the velocity). */
#include "contact/solve/body_drives.h"

#include "contact/rows/row_motion.h"
#include "contact/solve/project_impulses.h"

#include <math.h>
#include <string.h>

/* Rounds in which an axis may also come back from its limit. */
enum { FREE_ROUNDS = 6 };
/* Projections of the rows after one another, while drives change. The last word is the drives'. */
enum { PROJECTIONS_MAX = 4 };
/* An axis comes back when it would give this share of its limit; rounding alone moves none. */
static const double RETURN_SHARE = 1.0 - 1e-12;

/* Makes a row and a column those of the identity. */
static void lock_block(double *block, int k) {
    for (int i = 0; i < 3; i++) block[3 * k + i] = block[3 * i + k] = i == k ? 1.0 : 0.0;
}

mat3 compute_free_inverse(const mat3 *matrix, const bool is_locked[3]) {
    mat3 m = *matrix;
    for (int k = 0; k < 3; k++)
        if (is_locked[k]) lock_block(m.m, k);
    /* Cramer's rule, by columns */
    vec3 const c0 = {m.m[0], m.m[3], m.m[6]}, c1 = {m.m[1], m.m[4], m.m[7]},
               c2 = {m.m[2], m.m[5], m.m[8]};
    vec3 const rows[3] = {vec3_cross(c1, c2), vec3_cross(c2, c0), vec3_cross(c0, c1)};
    double const scale = 1.0 / vec3_dot(c0, rows[0]);
    mat3 inverse;
    for (int i = 0; i < 3; i++) {
        double const row[3] = {rows[i].x, rows[i].y, rows[i].z};
        for (int j = 0; j < 3; j++)
            inverse.m[3 * i + j] = is_locked[i] || is_locked[j] ? 0.0 : scale * row[j];
    }
    return inverse;
}

/* What axis k gives whatever u is. */
static double get_push(const body_drive *drive, int k) {
    switch (drive->states[k]) {
    case DRIVE_FOLLOWS: return drive->pushes[k];
    case DRIVE_AT_MOST: return drive->limits[k];
    case DRIVE_AT_LEAST: return -drive->limits[k];
    default: return 0.0;
    }
}

void update_body_answers(contact_body *body) {
    const body_drive *const drive = body->drive;
    double const mass = get_system_mass(body);
    body->inverse_mass = vec3_make(1.0 / mass, 1.0 / mass, 1.0 / mass);
    mat3 const inverse_inertia = rigid_compute_inverse_inertia(body->body, body->start.orientation);
    body->inverse_inertia = mat3_scale(&inverse_inertia, 1.0 / body->inertia_factor);
    if (!drive) return;
    double inverse[3];
    mat3 inertia = get_system_inertia(body);
    for (int k = 0; k < 3; k++) {
        inverse[k] = drive->is_locked[k] ? 0.0 : 1.0 / (mass + get_drive_gain(drive, k));
        inertia.m[4 * k] += get_drive_gain(drive, 3 + k);
    }
    body->inverse_mass = vec3_load(inverse, 0);
    body->inverse_inertia = compute_free_inverse(&inertia, drive->is_locked + 3);
}

body_system make_body_system(const contact_body *body) {
    const body_drive *const drive = body->drive;
    body_system system = {body->momentum, body->spin, mat3_identity(get_system_mass(body)),
                          get_system_inertia(body)};
    if (!drive) return system;
    double sides[BODY_AXES];
    vec3_store(sides, 0, system.momentum);
    vec3_store(sides, 1, system.spin);
    for (int k = 0; k < BODY_AXES; k++) {
        mat3 *const block = k < 3 ? &system.mass : &system.inertia;
        sides[k] = drive->is_locked[k] ? 0.0 : sides[k] + get_push(drive, k);
        block->m[4 * (k % 3)] += get_drive_gain(drive, k);
        if (drive->is_locked[k]) lock_block(block->m, k % 3);
    }
    system.momentum = vec3_load(sides, 0);
    system.spin = vec3_load(sides, 1);
    return system;
}

void clear_locked(const contact_scene *scene, double *vector) {
    for (size_t b = 0; b < scene->body_count; b++) {
        const body_drive *const drive = scene->bodies[b].drive;
        double *const axes = vector + 3 * (size_t)get_body_slot(scene, b);
        for (int k = 0; drive && k < BODY_AXES; k++)
            if (drive->is_locked[k]) axes[k] = 0.0;
    }
}

void fix_locked(const contact_scene *scene, double *right_hand_side, double *diagonal) {
    clear_locked(scene, right_hand_side);
    for (size_t b = 0; b < scene->body_count; b++) {
        const body_drive *const drive = scene->bodies[b].drive;
        double *const blocks = diagonal + 9 * (size_t)get_body_slot(scene, b);
        for (int k = 0; drive && k < BODY_AXES; k++)
            if (drive->is_locked[k]) lock_block(blocks + 9 * (k / 3), k % 3);
    }
}

/* What an axis that moves with u should do. */
static drive_state choose_state(const body_drive *drive, int k, double u, bool may_return) {
    drive_state const now = drive->states[k];
    double const wanted = drive->pushes[k] - drive->gains[k] * u, limit = drive->limits[k];
    drive_state const side = wanted > 0.0 ? DRIVE_AT_MOST : DRIVE_AT_LEAST;
    if (drive->is_locked[k]) return DRIVE_FOLLOWS;
    if (now == DRIVE_FOLLOWS) return fabs(wanted) > limit ? side : now;
    if (!may_return || (side == now && fabs(wanted) > RETURN_SHARE * limit)) return now;
    return fabs(wanted) > limit ? side : DRIVE_FOLLOWS;
}

/* Settles the drive of one body for u of its slots. True if a state has changed. */
static bool settle_body(contact_body *body, double u[BODY_AXES]) {
    body_drive *const drive = body->drive;
    /* what the body has without its drive: its start, and what rows gave */
    double without[BODY_AXES];
    mat3 const inertia = get_system_inertia(body);
    vec3_store(without, 0, vec3_scale(vec3_load(u, 0), get_system_mass(body)));
    vec3_store(without, 1, mat3_multiply_vec3(&inertia, vec3_load(u, 1)));
    for (int k = 0; k < BODY_AXES; k++)
        without[k] -= get_push(drive, k) - get_drive_gain(drive, k) * u[k];
    bool has_changed = false;
    for (int round = 0; round < FREE_ROUNDS + BODY_AXES; round++) {
        bool changes = false;
        for (int k = 0; k < BODY_AXES; k++) {
            drive_state const state = choose_state(drive, k, u[k], round < FREE_ROUNDS);
            changes |= state != drive->states[k];
            drive->states[k] = state;
        }
        if (!changes) break;
        has_changed = true;
        update_body_answers(body);
        double sides[BODY_AXES];
        for (int k = 0; k < BODY_AXES; k++) sides[k] = without[k] + get_push(drive, k);
        vec3 const a = body->inverse_mass, p = vec3_load(sides, 0);
        vec3_store(u, 0, vec3_make(a.x * p.x, a.y * p.y, a.z * p.z));
        vec3_store(u, 1, mat3_multiply_vec3(&body->inverse_inertia, vec3_load(sides, 1)));
    }
    for (int k = 0; k < BODY_AXES; k++)
        drive->impulses[k] =
            drive->is_locked[k] ? 0.0 : get_push(drive, k) - get_drive_gain(drive, k) * u[k];
    return has_changed;
}

void update_body_rows(const contact_scene *scene, contact_row *rows, size_t count) {
    bool has_any = false;
    for (size_t b = 0; b < scene->body_count; b++) has_any |= scene->bodies[b].has_own_answers;
    for (size_t i = 0; has_any && i < count; i++) {
        bool is_stale = false;
        for (int side = 0; side < 2; side++) {
            const contact_body *const body = find_side_body(scene, &rows[i], side);
            is_stale |= body && body->has_own_answers;
        }
        if (is_stale) (void)set_row_mobility(scene, &rows[i]);
    }
}

bool settle_drives(const contact_scene *scene, contact_row *rows, size_t count, double *u) {
    bool has_changed = false;
    for (size_t b = 0; b < scene->body_count; b++) {
        contact_body *const body = &scene->bodies[b];
        if (!body->is_free || !body->drive) continue;
        has_changed |= settle_body(body, u + 3 * (size_t)get_body_slot(scene, b));
    }
    if (has_changed) update_body_rows(scene, rows, count);
    return has_changed;
}

tulle_status project_driven_impulses(const contact_scene *scene, contact_row *rows, size_t count,
                                     double *u) {
    for (int round = 0; round < PROJECTIONS_MAX; round++) {
        tulle_status const status =
            project_impulses(scene, scene->settings.impulse_sweeps, rows, count, u);
        if (status != TULLE_OK || !settle_drives(scene, rows, count, u)) return status;
    }
    return TULLE_OK;
}

void rest_bodies(const contact_scene *scene, contact_row *rows, size_t count) {
    for (size_t b = 0; b < scene->body_count; b++) {
        contact_body *const body = &scene->bodies[b];
        if (!body->is_free || !body->has_own_answers) continue;
        body->mass_factor = body->inertia_factor = 1.0;
        for (int k = 0; k < BODY_AXES && body->drive; k++) body->drive->states[k] = DRIVE_IS_OFF;
        update_body_answers(body);
    }
    update_body_rows(scene, rows, count);
}
