/* contact/project_impulses.c - see project_impulses.h.
 *
 * One row: with W = sum w_i^2 / m_i the impulse that stops the row's relative velocity v at the
 * wanted normal speed is  p - (v - bias n) / W.  Its normal part is clamped to >= 0, its tangential
 * part to what friction can give under it; the difference to p acts on the four vertices.
 * Where a side lies on a body see row_motion.h.
 *
 * Based on: Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988; Jean, The
 * non-smooth contact dynamics method, 1999. */
#include "contact/project_impulses.h"

#include "contact/row_friction.h"

#include <float.h>
#include <math.h>

/* [m/s] Sweeps end when no row changed its relative velocity by more: far below what a drift of a
 * nanometre in a minute needs. */
#define SETTLED_SPEED 1e-13

/* ... or when that speed is no more than rounding of positions makes of it, which are so many times
 * the largest coordinate's over the time step, and a sweep leaves this part of it: rows of one body
 * then want what no motion of it gives, and sweeps could go on forever. */
#define SPEED_ROUNDINGS 8.0
#define STALLED_PART 0.99

/* Times as many sweeps over the rows of bodies alone, before those over all. No solve carries load
 * along a chain of bodies, nor shares it between the many contacts of one body: only sweeps do. A
 * chain of 20 rings that falls taut needs no rescue with 4, and 1.5 in 1,000 contacts with 1; three
 * boxes on a sheet come to rest where they are, while they crept by up to a micrometre a second. */
#define SWEEPS_OF_BODIES 4

/* The same where bodies take part, which answer an impulse not along itself: first the normal part,
 * then the tangential one, after what the normal part has changed, by no more than the largest
 * answer. Each is a step down for the impulse of least energy. */
static vec3 find_coupled_impulse(contact_row *row, vec3 velocity) {
    vec3 const n = row->normal;
    double const before = vec3_dot(n, row->impulse), speed = vec3_dot(n, velocity);
    double const normal = before - (speed - get_wanted_speed(row)) / row->inverse_mass;
    if (!(normal > 0.0)) {
        row->state = ROW_OPEN;
        return vec3_make(0.0, 0.0, 0.0);
    }
    vec3 const changed = vec3_add_scaled(vec3_sub(velocity, row->return_velocity), row->slip_answer,
                                         normal - before);
    vec3 const slip = vec3_add_scaled(changed, n, -vec3_dot(n, changed));
    vec3 const held = vec3_add_scaled(row->impulse, n, -before);
    vec3 const trial = vec3_add_scaled(held, slip, -1.0 / row->slip_inverse_mass);
    bool is_held;
    double const bound = row->friction_cap >= 0.0 ? row->friction_cap : normal;
    vec3 const tangential = limit_friction(row, bound, trial, &is_held);
    row->state = is_held ? ROW_STICKS : ROW_SLIDES;
    return vec3_add_scaled(tangential, n, normal);
}

/* The nearest total impulse by the rule above; sets the row's state. */
static vec3 find_impulse(contact_row *row, vec3 velocity) {
    if (row->has_body) return find_coupled_impulse(row, velocity);
    double const inverse = 1.0 / row->inverse_mass;
    vec3 const missing = vec3_add_scaled(vec3_sub(velocity, row->return_velocity), row->normal,
                                         -get_wanted_speed(row));
    vec3 const trial = vec3_add_scaled(row->impulse, missing, -inverse);
    double const normal = vec3_dot(trial, row->normal);
    if (!(normal > 0.0)) {
        row->state = ROW_OPEN;
        return vec3_make(0.0, 0.0, 0.0);
    }
    bool is_held;
    double const bound = row->friction_cap >= 0.0 ? row->friction_cap : normal;
    vec3 const tangential =
        limit_friction(row, bound, vec3_add_scaled(trial, row->normal, -normal), &is_held);
    row->state = is_held ? ROW_STICKS : ROW_SLIDES;
    return vec3_add_scaled(tangential, row->normal, normal);
}

static double relax_row(const contact_scene *scene, contact_row *row, double *u) {
    if (row->is_in_matrix) return 0.0;
    vec3 const impulse = find_impulse(row, get_relative_velocity(row, u));
    vec3 const change = vec3_sub(impulse, row->impulse);
    double const size2 = vec3_norm2(change);
    if (!(size2 > 0.0)) return 0.0;
    row->impulse = impulse;
    move_row(scene, row, change, u);
    double const answer =
        row->has_body ? fmax(row->inverse_mass, row->slip_inverse_mass) : row->inverse_mass;
    return size2 * answer * answer;
}

/* One sweep, forward and backward; with `has_bodies_only` only rows that bodies take part in. The
 * largest change, as of relax_row. */
static double sweep_rows(const contact_scene *scene, contact_row *rows, size_t count,
                         bool has_bodies_only, double *u) {
    double largest2 = 0.0;
    for (size_t i = 0; i < count; i++)
        if (!has_bodies_only || rows[i].has_body)
            largest2 = fmax(largest2, relax_row(scene, &rows[i], u));
    for (size_t i = count; i-- > 0;)
        if (!has_bodies_only || rows[i].has_body)
            largest2 = fmax(largest2, relax_row(scene, &rows[i], u));
    return largest2;
}

/* [m/s] What rounding of positions leaves of speeds that close gaps in one step. */
static double find_speed_rounding(const contact_scene *scene) {
    double largest = 0.0;
    for (size_t i = 0; i < 3 * scene->vertex_count; i++)
        largest = fmax(largest, fabs(scene->x0[i]));
    return SPEED_ROUNDINGS * DBL_EPSILON * largest / scene->time_step;
}

static void run_sweeps(const contact_scene *scene, contact_row *rows, size_t count,
                       bool has_bodies_only, double *u) {
    int const factor = has_bodies_only ? SWEEPS_OF_BODIES : 1;
    int const limit = factor * scene->settings.impulse_sweeps;
    double before = (double)INFINITY; /* [m/s] */
    for (int sweep = 0; sweep < limit && !stop_is_wanted(scene->stop); sweep++) {
        double const largest2 = sweep_rows(scene, rows, count, has_bodies_only, u);
        double const largest = sqrt(largest2);
        if (largest2 <= SETTLED_SPEED * SETTLED_SPEED) break;
        if (largest > STALLED_PART * before && largest <= find_speed_rounding(scene)) break;
        before = largest;
    }
}

void project_impulses(const contact_scene *scene, contact_row *rows, size_t count, double *u) {
    bool has_bodies = false;
    for (size_t i = 0; i < count; i++) has_bodies |= rows[i].has_body;
    if (has_bodies) run_sweeps(scene, rows, count, true, u);
    run_sweeps(scene, rows, count, false, u);
}
