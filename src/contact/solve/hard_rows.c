/* contact/solve/hard_rows.c - see hard_rows.h.
 *
 * Normal part: K has k n n^T. The multiplier grows by k times the speed that is missing, and is
 * clamped to push only. One round leaves about 1 / (1 + k c) of a violation; c is the row's
 * compliance in A.
 *
 * Friction: the trial is the tangential multiplier less k times the slip. A trial inside of its
 * bound holds the row, and K has k for slip too. With a trial outside, the row slides with the
 * nearest point of the bound. There K has the derivative of that point, about the slip of the last
 * solve: k r / (r + d) along the bound, where r is its radius of curvature and d the distance to
 * the trial. If a solve turned a sliding row back, the row is held in the next round with the
 * friction that it had: a reversed trial would go to and fro.
 *
 * Based on: Hestenes, Multiplier and gradient methods, 1969; Alart, Curnier, A mixed formulation
 * for frictional contact problems prone to Newton like solution methods, 1991 (the trial, its
 * projection and derivative). Departures: bounds follow the normal multiplier from round to round,
 * and their change with it is not in the matrix, which stays symmetric. */
#include "contact/solve/hard_rows.h"

#include "base/parallel.h"
#include "contact/rows/row_friction.h"
#include "contact/rows/row_motion.h"
#include "contact/solve/project_impulses.h"

#include <math.h>

enum { ROW_CHUNK = 128 };

typedef struct row_preparation {
    const contact_scene *scene;
    const double *diagonal, *u;
    contact_row *rows;
} row_preparation;

static void prepare_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const row_preparation *const task = context;
    const contact_settings *const settings = &task->scene->settings;
    for (size_t i = begin; i < end; i++) {
        contact_row *const row = &task->rows[i];
        double const mobility = measure_row_mobility(task->scene, row, task->diagonal);
        row->solve.stiffness = mobility > 0.0 ? settings->hard_stiffness / mobility : 0.0;
        row->solve.compliance = settings->push_out_softness * mobility;
        row->solve.slip_penalty = settings->hard_friction * row->solve.stiffness;
        row->solve.is_in_matrix = false;
        row->solve.is_hard &= row->solve.stiffness > 0.0; /* as carried over */
        harden_if_violated(row, task->u);
    }
}

void prepare_hard_rows(const contact_scene *scene, const double *diagonal, contact_row *rows,
                       size_t count, const double *u) {
    row_preparation task = {scene, diagonal, u, rows};
    parallel_for(count, ROW_CHUNK, scene->threads, prepare_chunk, &task);
}

static bool has_friction(const contact_row *row) {
    return row->law.friction * row->solve.friction_cap > 0.0;
}

/* Gives the row its trial friction within the bound, and returns it. The row sticks where the trial
 * lies inside of the bound, or where it `is_held`; else it slides. */
static vec3 set_friction(contact_row *row, vec3 trial, vec3 slip, bool is_held) {
    row_solve *const solve = &row->solve;
    bool is_inside;
    vec3 const friction = limit_friction(row, solve->friction_cap, trial, &is_inside);
    solve->impulse = vec3_add_scaled(friction, row->frame.normal, get_normal_impulse(row));
    if (is_held || (is_inside && has_friction(row))) {
        solve->state = ROW_STICKS;
        solve->slip_pull = solve->slip_penalty;
        solve->slip_free = vec3_make(0.0, 0.0, 0.0);
        solve->slip_target = row->law.return_velocity;
        return friction;
    }
    solve->state = ROW_SLIDES;
    /* the bounded trial does not change along the normal of the bound */
    solve->slip_pull =
        solve->slip_penalty * measure_bound_follow(row, solve->friction_cap, friction, trial);
    solve->slip_free = vec3_normalize(vec3_sub(trial, friction));
    solve->slip_target = slip;
    return friction;
}

mat3 get_pull(const contact_row *row) {
    const row_solve *const solve = &row->solve;
    vec3 const n = row->frame.normal;
    mat3 const all = mat3_identity(solve->slip_pull);
    mat3 const along = mat3_outer(solve->slip_free, solve->slip_free, -solve->slip_pull);
    mat3 pull = mat3_outer(n, n, solve->stiffness - solve->slip_pull);
    mat3_add_scaled(&pull, &all, 1.0);
    mat3_add_scaled(&pull, &along, 1.0);
    return pull;
}

void make_pull(const contact_settings *settings, contact_row *row, const double *u) {
    row_solve *const solve = &row->solve;
    vec3 const n = row->frame.normal;
    if (!solve->is_in_matrix) {
        /* Before its first round a row goes on as it was in the step before, or after the
         * projection of other rows. A new one slides if it comes with slip. */
        vec3 const slip = vec3_reject(get_relative_velocity(row, u), n);
        vec3 const before = vec3_reject(solve->impulse, n);
        bool const is_new = solve->state == ROW_OPEN;
        bool const is_fast = vec3_norm(slip) > settings->slip_speed;
        solve->friction_cap = fmax(get_normal_impulse(row), 0.0);
        if (solve->state == ROW_SLIDES || (is_new && is_fast) || !has_friction(row))
            set_friction(row, vec3_add_scaled(before, slip, -solve->slip_penalty), slip, false);
        else
            set_friction(row, before, slip, true);
    }
    solve->pull = get_pull(row);
}

/* An impulse that is too large makes a vertex fly off, which drags its neighbours apart: a row that
 * pushes is violated by too much speed, too. A row that pulled has failed by the speed that the
 * pull cost, even if it met the speed that it wanted. */
double harden_if_violated(contact_row *row, const double *u) {
    row_solve *const solve = &row->solve;
    double const missing =
        get_wanted_speed(row) - vec3_dot(row->frame.normal, get_relative_velocity(row, u));
    double const penalty = solve->is_in_matrix ? solve->stiffness * missing : 0.0;
    double const acted = get_normal_impulse(row) + penalty;
    double violation = acted > 0.0 ? fabs(missing) : fmax(missing, 0.0);
    if (acted < 0.0 && solve->is_in_matrix) violation = -acted / solve->stiffness;
    if (violation > LEAST_VIOLATION && !row->frame.is_without_cloth && solve->stiffness > 0.0)
        solve->is_hard = true;
    return violation;
}

vec3 update_hard_row(contact_row *row, const double *u) {
    row_solve *const solve = &row->solve;
    vec3 const n = row->frame.normal, velocity = get_relative_velocity(row, u);
    double const speed = vec3_dot(n, velocity);
    double const normal_before = get_normal_impulse(row);
    double const acted = normal_before + solve->stiffness * (get_wanted_speed(row) - speed);
    solve->friction_cap = fmax(acted, 0.0);
    /* friction: what the solve took it for, and what it is by its trial */
    vec3 const slip = vec3_reject(velocity, n), before = vec3_reject(solve->impulse, n);
    vec3 const past = vec3_reject(vec3_sub(slip, solve->slip_target), solve->slip_free);
    vec3 const taken = vec3_add_scaled(before, past, -solve->slip_pull);
    bool const turned_back = solve->state == ROW_SLIDES && vec3_dot(slip, solve->slip_free) > 0.0;
    vec3 const trial =
        vec3_add_scaled(before, vec3_sub(slip, row->law.return_velocity), -solve->slip_penalty);
    vec3 const misfit = vec3_sub(set_friction(row, trial, slip, false), taken);
    if (turned_back && has_friction(row)) set_friction(row, before, slip, true);
    solve->impulse = vec3_add_scaled(solve->impulse, n, solve->friction_cap - normal_before);
    if (!(acted > 0.0)) solve->state = ROW_OPEN;
    if (acted < 0.0) solve->is_hard = false;
    return misfit;
}
