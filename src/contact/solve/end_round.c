/* contact/solve/end_round.c - see end_round.h. */
#include "contact/solve/end_round.h"

#include "contact/solve/hard_rows.h"
#include "contact/solve/project_impulses.h"

#include <math.h>
#include <string.h>

/* Friction between cloths is settled when its misfit is less than this part of the momentum that a
 * cloth gains in a step. The misfits of sliding cloth have the same direction in every step, so
 * they add up: with a larger part cloth slides too fast (lab/contact.md). */
static const double SETTLED_SHARE = 0.01;

/* Whether misfits give a cloth that nothing holds more speed than settings and the step's own
 * change of its motion allow, or a cloth still slips as a whole on the rows that hold it: their
 * multipliers, which still gain, say so. */
static bool may_drift(const contact_scene *scene, const friction_sums *all,
                      const solve_effort *effort, const double *u) {
    const contact_settings *const settings = &scene->settings;
    for (size_t s = 0; s < scene->set->surface_count; s++) {
        const surface_range *const range = &scene->set->surfaces[s];
        const friction_sums *const sums = &all[s];
        double const slip = vec3_norm(sums->slip), misfit = vec3_norm(sums->misfit);
        bool const slips = slip > settings->settled_slip * sums->held;
        if (!slips && misfit == 0.0) continue;
        vec3 gained = {0.0, 0.0, 0.0};  /* [N s] */
        double mass = 0.0, moved = 0.0; /* [kg], [kg m^2/s^2] of what is free */
        bool is_held = false;
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++) {
            is_held |= !(scene->inverse_mass[v] > 0.0);
            if (!(scene->inverse_mass[v] > 0.0)) continue;
            vec3 const before = scene->v0 ? vec3_load(scene->v0, v) : vec3_make(0.0, 0.0, 0.0);
            vec3 const now = vec3_load(u, v);
            gained = vec3_add_scaled(gained, vec3_sub(now, before), 1.0 / scene->inverse_mass[v]);
            moved += vec3_norm2(now) / scene->inverse_mass[v];
            mass += 1.0 / scene->inverse_mass[v];
        }
        double const speed = mass > 0.0 ? sqrt(moved / mass) : 0.0;
        if (slips && slip > effort->slip_share * speed * sums->held) return true;
        double const limit = settings->settled_drift * mass + SETTLED_SHARE * vec3_norm(gained);
        if (!is_held && misfit > effort->looseness * limit) return true;
    }
    return false;
}

tulle_status end_round(const contact_scene *scene, const solve_effort *effort, row_list *list,
                       friction_sums *sums, double *u, round_result *result) {
    double const count = (double)list->rows.count;
    double violation2 = 0.0, misfit2 = 0.0, largest_misfit = 0.0;
    *result = (round_result){0};
    memset(sums, 0, scene->set->surface_count * sizeof *sums);
    for (size_t i = 0; i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        double const violation = harden_if_violated(row, u);
        if (violation > result->largest_violation) result->largest_violation = violation;
        violation2 += violation * violation;
        if (!row->solve.is_in_matrix) continue;
        vec3 const misfit = update_hard_row(row, u);
        double const missed = vec3_norm(misfit) / row->solve.slip_penalty;
        misfit2 += missed * missed;
        if (missed > largest_misfit) largest_misfit = missed;
        /* to the sums of the cloths that the row touches */
        bool const sticks = row->solve.state == ROW_STICKS;
        double const penalty = row->solve.slip_penalty;
        vec3 slip = {0.0, 0.0, 0.0};
        if (sticks)
            slip = vec3_sub(vec3_reject(get_relative_velocity(row, u), row->frame.normal),
                            row->law.return_velocity);
        /* a side is of an obstacle, which no impulse moves */
        bool const is_on_obstacle =
            !row->frame.has_body && (row->frame.vertices[0] >= scene->cloth_vertex_count ||
                                     row->frame.vertices[3] >= scene->cloth_vertex_count);
        for (int k = 0; k < 4; k++) {
            if (row->frame.vertices[k] >= scene->cloth_vertex_count) continue;
            size_t const surface = scene->vertex_surface[row->frame.vertices[k]];
            friction_sums *const sum = &sums[surface];
            double const weight = row->frame.weights[k];
            bool const is_given = is_on_obstacle && !scene->set->surfaces[surface].is_in_pieces;
            vec3 *const to = is_given ? &sum->missed : &sum->misfit;
            *to = vec3_add_scaled(*to, misfit, weight);
            sum->slip = vec3_add_scaled(sum->slip, slip, weight * penalty);
            if (sticks) sum->held += fabs(weight) * penalty;
        }
    }
    tulle_status const status = project_impulses(scene, scene->settings.impulse_sweeps,
                                                 list->rows.data, list->rows.count, u);
    double const violation = sqrt(violation2 / count), misfit = sqrt(misfit2 / count);
    const contact_settings *const settings = &scene->settings;
    double const looseness = effort->looseness;
    result->has_settled =
        violation <= effort->most_violation && violation <= looseness * settings->settled_speed &&
        misfit <= looseness * settings->settled_speed && !may_drift(scene, sums, effort, u) &&
        largest_misfit <= looseness * settings->settled_misfit &&
        result->largest_violation <= looseness * settings->settled_most;
    return status;
}
