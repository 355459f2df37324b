/* contact/solve/hard_rows.c - see hard_rows.h.
 *
 * Normal part: K has k n n^T, and the multiplier grows by k times what is missing, clamped to push
 * only. One round leaves about 1 / (1 + k c) of a violation, c the row's compliance in A.
 *
 * Friction: the trial is the tangential multiplier less k times the slip. Inside of its bound it
 * holds the row, and K has k for slip too. Outside, the row slides with the nearest point of the
 * bound; there K has the derivative of that point, k r / (r + d) along the bound, r its radius of
 * curvature and d the distance to the trial, about the slip of the last solve. A sliding row that a
 * solve turned back is held in the next round with the friction that it had; a reversed trial would
 * go to and fro.
 *
 * Based on: Hestenes, Multiplier and gradient methods, 1969; Alart, Curnier, A mixed formulation
 * for frictional contact problems prone to Newton like solution methods, 1991 (the trial, its
 * projection and derivative). Departures: bounds follow the normal multiplier from round to round,
 * and their change with it is not in the matrix, which stays symmetric. */
#include "contact/solve/hard_rows.h"

#include "contact/rows/row_friction.h"
#include "contact/rows/row_motion.h"
#include "contact/solve/project_impulses.h"

#include <math.h>

void prepare_hard_rows(const contact_scene *scene, const double *diagonal, contact_row *rows,
                       size_t count, const double *u) {
    const contact_settings *const settings = &scene->settings;
    for (size_t i = 0; i < count; i++) {
        contact_row *const row = &rows[i];
        double const mobility = measure_row_mobility(scene, row, diagonal);
        row->solve.stiffness = mobility > 0.0 ? settings->hard_stiffness / mobility : 0.0;
        row->solve.compliance = settings->push_out_softness * mobility;
        row->solve.slip_penalty = settings->hard_friction * row->solve.stiffness;
        row->solve.is_in_matrix = false;
        row->solve.is_hard &= row->solve.stiffness > 0.0; /* as carried over */
        harden(row, measure_row_violation(row, u));
    }
}

vec3 get_slip(const contact_row *row, const double *u) {
    vec3 const velocity = get_relative_velocity(row, u);
    return vec3_add_scaled(velocity, row->frame.normal, -vec3_dot(row->frame.normal, velocity));
}

static vec3 get_friction(const contact_row *row) {
    return vec3_add_scaled(row->solve.impulse, row->frame.normal, -get_normal_impulse(row));
}

static bool has_friction(const contact_row *row) {
    return row->law.friction * row->solve.friction_cap > 0.0;
}

/* The row sticks with this friction. */
static void hold(contact_row *row, vec3 friction) {
    row_solve *const solve = &row->solve;
    solve->impulse = vec3_add_scaled(friction, row->frame.normal, get_normal_impulse(row));
    solve->state = ROW_STICKS;
    solve->slip_pull = solve->slip_penalty;
    solve->slip_free = vec3_make(0.0, 0.0, 0.0);
    solve->slip_target = row->law.return_velocity;
}

/* Sticks or slides with the next friction of a row by its trial; returns that friction. */
static vec3 try_friction(contact_row *row, vec3 trial, vec3 slip) {
    row_solve *const solve = &row->solve;
    bool is_inside;
    vec3 const friction = limit_friction(row, solve->friction_cap, trial, &is_inside);
    if (is_inside && has_friction(row)) {
        hold(row, friction);
        return friction;
    }
    solve->impulse = vec3_add_scaled(friction, row->frame.normal, get_normal_impulse(row));
    solve->state = ROW_SLIDES;
    /* the bounded trial does not change along the normal of the bound */
    solve->slip_pull =
        solve->slip_penalty * measure_bound_follow(row, solve->friction_cap, friction, trial);
    solve->slip_free = vec3_normalize(vec3_sub(trial, friction));
    solve->slip_target = slip;
    return friction;
}

void make_pull(const contact_settings *settings, contact_row *row, const double *u) {
    row_solve *const solve = &row->solve;
    if (!solve->is_in_matrix) {
        /* before its first round: as it was, in the step before or after the projection of other
         * rows; a new one slides if it comes with slip */
        vec3 const slip = get_slip(row, u), before = get_friction(row);
        bool const is_new = solve->state == ROW_OPEN;
        bool const is_fast = vec3_norm(slip) > settings->slip_speed;
        solve->friction_cap = fmax(get_normal_impulse(row), 0.0);
        if (solve->state == ROW_SLIDES || (is_new && is_fast) || !has_friction(row)) {
            try_friction(row, vec3_add_scaled(before, slip, -solve->slip_penalty), slip);
        } else {
            bool is_inside;
            hold(row, limit_friction(row, solve->friction_cap, before, &is_inside));
        }
    }
    vec3 const n = row->frame.normal;
    mat3 const all = mat3_identity(solve->slip_pull);
    mat3 const along = mat3_outer(solve->slip_free, solve->slip_free, -solve->slip_pull);
    solve->pull = mat3_outer(n, n, solve->stiffness - solve->slip_pull);
    mat3_add_scaled(&solve->pull, &all, 1.0);
    mat3_add_scaled(&solve->pull, &along, 1.0);
}

/* Pushed by an impulse that is too large, a vertex flies off and drags its neighbours apart. A row
 * that pulled has failed by the speed that the pull cost, however well it met what it wanted. */
double measure_row_violation(const contact_row *row, const double *u) {
    const row_solve *const solve = &row->solve;
    double const missing =
        get_wanted_speed(row) - vec3_dot(row->frame.normal, get_relative_velocity(row, u));
    double const penalty = solve->is_in_matrix ? solve->stiffness * missing : 0.0;
    double const acted = get_normal_impulse(row) + penalty;
    if (acted < 0.0 && solve->is_in_matrix) return -acted / solve->stiffness;
    return acted > 0.0 ? fabs(missing) : fmax(missing, 0.0);
}

vec3 update_hard_row(contact_row *row, const double *u) {
    row_solve *const solve = &row->solve;
    double const speed = vec3_dot(row->frame.normal, get_relative_velocity(row, u));
    double const normal_before = get_normal_impulse(row);
    double const acted = normal_before + solve->stiffness * (get_wanted_speed(row) - speed);
    solve->friction_cap = fmax(acted, 0.0);
    /* friction: what the solve took it for, and what it is by its trial */
    vec3 const slip = get_slip(row, u), before = get_friction(row);
    vec3 past = vec3_sub(slip, solve->slip_target);
    past = vec3_add_scaled(past, solve->slip_free, -vec3_dot(past, solve->slip_free));
    vec3 const taken = vec3_add_scaled(before, past, -solve->slip_pull);
    bool const turned_back = solve->state == ROW_SLIDES && vec3_dot(slip, solve->slip_free) > 0.0;
    vec3 const trial =
        vec3_add_scaled(before, vec3_sub(slip, row->law.return_velocity), -solve->slip_penalty);
    vec3 const misfit = vec3_sub(try_friction(row, trial, slip), taken);
    if (turned_back && has_friction(row)) {
        bool is_inside;
        hold(row, limit_friction(row, solve->friction_cap, before, &is_inside));
    }
    solve->impulse =
        vec3_add_scaled(solve->impulse, row->frame.normal, solve->friction_cap - normal_before);
    if (!(acted > 0.0)) solve->state = ROW_OPEN;
    if (acted < 0.0) solve->is_hard = false;
    return misfit;
}
