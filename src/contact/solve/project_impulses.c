/* contact/solve/project_impulses.c - see project_impulses.h.
 *
 * One row of impulse p: with W = sum w_i^2 / m_i the impulse  p - (v - bias n) / W  takes the row's
 * relative velocity v to the wanted normal speed. Its normal part is clamped to >= 0, its
 * tangential part to what friction can give under it. The difference to p acts on the four
 * vertices.
 *
 * One row with bodies (row_motion.h): they answer an impulse in another direction than its own.
 * The normal part comes first. The tangential part comes after what the normal part has changed,
 * and is divided by the largest answer. Each part is a step down for the impulse of least energy.
 *
 * Based on: Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988; Jean, The
 * non-smooth contact dynamics method, 1999. */
#include "contact/solve/project_impulses.h"

#include "contact/rows/row_friction.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* [m/s] Sweeps end when no row changed its relative velocity by more. A drift of a nanometre in a
 * minute needs far more. */
static const double SETTLED_SPEED = 1e-13;

/* Sweeps also end when that speed is rounding and a sweep leaves more than STALLED_PART of it. Rows
 * of one body then want what no motion of it gives, and sweeps could go on forever. Rounding of
 * positions gives speeds up to SPEED_ROUNDINGS times the rounding of the largest coordinate, over
 * the time step. */
static const double SPEED_ROUNDINGS = 8.0;
static const double STALLED_PART = 0.99;

/* Before the sweeps over all rows, rows with bodies have so many times as many sweeps of their own.
 * No solve carries load along a chain of bodies, nor shares it between the many contacts of one
 * body: only sweeps do. Without these, contacts of a chain that falls taut need rescue, and boxes
 * on a sheet creep (lab/bodies.md). */
enum { SWEEPS_OF_BODIES = 4 };

/* The nearest total impulse by the rules above; sets the row's state. */
static vec3 compute_impulse(contact_row *row, vec3 velocity) {
    row_solve *const solve = &row->solve;
    vec3 const n = row->frame.normal;
    vec3 const asked = vec3_sub(velocity, row->law.return_velocity);
    double normal; /* of the trial */
    vec3 trial;    /* its tangential part */
    if (row->frame.has_body) {
        double const before = vec3_dot(n, solve->impulse), speed = vec3_dot(n, velocity);
        normal = before - (speed - get_wanted_speed(row)) / solve->inverse_mass;
        vec3 const changed = vec3_add_scaled(asked, solve->slip_answer, normal - before);
        vec3 const slip = vec3_reject(changed, n);
        vec3 const held = vec3_add_scaled(solve->impulse, n, -before);
        trial = vec3_add_scaled(held, slip, -1.0 / solve->slip_inverse_mass);
    } else {
        double const inverse = 1.0 / solve->inverse_mass;
        vec3 const missing = vec3_add_scaled(asked, n, -get_wanted_speed(row));
        vec3 const whole = vec3_add_scaled(solve->impulse, missing, -inverse);
        normal = vec3_dot(whole, n);
        trial = vec3_add_scaled(whole, n, -normal);
    }
    if (!(normal > 0.0)) {
        solve->state = ROW_OPEN;
        return vec3_make(0.0, 0.0, 0.0);
    }
    bool is_held;
    double const bound = solve->friction_cap >= 0.0 ? solve->friction_cap : normal;
    vec3 const tangential = limit_friction(row, bound, trial, &is_held);
    solve->state = is_held ? ROW_STICKS : ROW_SLIDES;
    return vec3_add_scaled(tangential, n, normal);
}

/* A row that takes part in sweeps. It has its own copy of the vertices: rows are large, and these
 * lie side by side. */
typedef struct sweep_row {
    uint32_t row;
    uint32_t quiet_pass; /* the pass that last left it as it was; 0: none */
    uint32_t vertices[4];
} sweep_row;

/* Passes go over all rows forward or backward, and are counted from 1. A row that a pass left as it
 * was stays so until one of its vertices changes: passes skip it until then. */
typedef struct sweeps {
    const contact_scene *scene;
    int count; /* most of them, each forward and backward */
    contact_row *rows;
    sweep_row *active;
    size_t active_count;
    uint32_t *change_pass; /* of each vertex: the last pass that changed it */
    uint32_t pass;
    double *u;
} sweeps;

/* Gives a row its impulse. *largest2 becomes the square of the speed [m/s] that the change gives it
 * at most, if that is larger. A row with bodies changes with their motion, too, so no pass skips
 * it. */
static void relax_row(sweeps *all, sweep_row *active, double *largest2) {
    bool is_quiet = active->quiet_pass > 0;
    for (int k = 0; k < 4; k++)
        is_quiet &= all->change_pass[active->vertices[k]] < active->quiet_pass;
    if (is_quiet) return;
    contact_row *const row = &all->rows[active->row];
    row_solve *const solve = &row->solve;
    vec3 const impulse = compute_impulse(row, get_relative_velocity(row, all->u));
    vec3 const change = vec3_sub(impulse, solve->impulse);
    double const size2 = vec3_norm2(change);
    if (!(size2 > 0.0)) {
        active->quiet_pass = row->frame.has_body ? 0 : all->pass;
        return;
    }
    solve->impulse = impulse;
    move_row(all->scene, row, change, all->u);
    for (int k = 0; k < 4; k++) all->change_pass[active->vertices[k]] = all->pass;
    active->quiet_pass = 0;
    double const answer = row->frame.has_body ? fmax(solve->inverse_mass, solve->slip_inverse_mass)
                                              : solve->inverse_mass;
    *largest2 = fmax(*largest2, size2 * answer * answer);
}

/* Sweeps forward and backward until nothing changes; with `has_bodies_only` only over rows with
 * bodies. */
static void run_sweeps(sweeps *all, bool has_bodies_only) {
    const contact_scene *const scene = all->scene;
    int const factor = has_bodies_only ? SWEEPS_OF_BODIES : 1;
    int const limit = factor * all->count;
    double before = (double)INFINITY; /* [m/s] */
    double coordinate = 0.0;          /* [m] the largest; 0: not known yet */
    for (int sweep = 0; sweep < limit && !stop_is_wanted(scene->stop, 0); sweep++) {
        double largest2 = 0.0;
        all->pass++;
        for (size_t i = 0; i < all->active_count; i++)
            if (!has_bodies_only || all->rows[all->active[i].row].frame.has_body)
                relax_row(all, &all->active[i], &largest2);
        all->pass++;
        for (size_t i = all->active_count; i-- > 0;)
            if (!has_bodies_only || all->rows[all->active[i].row].frame.has_body)
                relax_row(all, &all->active[i], &largest2);
        double const largest = sqrt(largest2);
        if (largest2 <= SETTLED_SPEED * SETTLED_SPEED) break;
        if (largest > STALLED_PART * before) {
            size_t const size = coordinate == 0.0 ? 3 * scene->vertex_count : 0;
            for (size_t i = 0; i < size; i++) coordinate = fmax(coordinate, fabs(scene->x0[i]));
            if (largest <= SPEED_ROUNDINGS * DBL_EPSILON * coordinate / scene->time_step) break;
        }
        before = largest;
    }
}

tulle_status project_impulses(const contact_scene *scene, int sweep_count, contact_row *rows,
                              size_t count, double *u) {
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    size_t active_count = 0; /* rows in the matrix of the solve do not take part */
    bool has_bodies = false;
    for (size_t i = 0; i < count; i++) {
        active_count += !rows[i].solve.is_in_matrix;
        has_bodies |= rows[i].frame.has_body;
    }
    sweeps all = {.scene = scene,
                  .count = sweep_count,
                  .rows = rows,
                  .active = ARENA_NEW(scratch, sweep_row, active_count),
                  .change_pass = ARENA_NEW_ZEROED(scratch, uint32_t, scene->vertex_count),
                  .u = u};
    bool const has_memory = all.active && all.change_pass;
    for (size_t i = 0; i < count && has_memory; i++) {
        if (rows[i].solve.is_in_matrix) continue;
        sweep_row *const active = &all.active[all.active_count++];
        *active = (sweep_row){.row = (uint32_t)i};
        memcpy(active->vertices, rows[i].frame.vertices, sizeof active->vertices);
    }
    if (has_memory && has_bodies) run_sweeps(&all, true);
    if (has_memory) run_sweeps(&all, false);
    arena_release(scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
