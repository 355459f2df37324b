/* contact/solve/end_velocities.c - see end_velocities.h.
 *
 * Positions end where stages 7 to 9 put them; only velocities change here. If the sides of a row
 * that carries load meet with the speed a, they part with the speed k a at the end: Newton's law of
 * impact for the normal part. Friction bounds the tangential part of all that the row gave in the
 * step. Projected Gauss-Seidel finds the impulses in the metric of the masses, over all rows that
 * carry load. So a rebound passes through layers, and no row ends with an approach that its law
 * does not allow.
 *
 * The speed a is that at the time of the impact, a0 + s fall: contact begins after the part s of
 * the step, and gravity acts until then. Position and velocity at the end of the step are those at
 * the impact. Springs may take part in an impact; so the energy at the end is held against that at
 * the start and the work done in the step, and a rebound that would exceed both is cut.
 *
 * Contacts at rest approach with no more than what gravity gives in a step; they do not rebound.
 *
 * Based on: Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988 (laws of
 * impact on velocities at the end of a step). */
#include "contact/solve/end_velocities.h"

#include "contact/solve/project_impulses.h"

#include <string.h>

/* Sweeps at most. They usually end before, when nothing changes. */
enum { END_SWEEPS = 200 };
/* Rows that approach with less than so many times the speed that gravity adds in a step are at
 * rest. */
static const double RESTING_FALLS = 2.0;

bool row_is_impact(const contact_scene *scene, const contact_row *row) {
    double const resting = fmax(RESTING_FALLS * fabs(row->law.fall), scene->settings.slip_speed);
    return row->law.approach < -resting;
}

double compute_obstacle_work(const contact_scene *scene, const contact_row *rows, size_t count,
                             const double *u) {
    double work = 0.0;
    for (size_t i = 0; i < count; i++) {
        const row_frame *const frame = &rows[i].frame;
        /* what the frame's turn takes from the gap is no motion of what is held: no work */
        vec3 const turn = vec3_sub(frame->turning, vec3_reject(frame->turning, frame->normal));
        vec3 const held =
            vec3_sub(get_relative_velocity(&rows[i], u), get_free_velocity(scene, &rows[i], u));
        work -= vec3_dot(rows[i].solve.impulse, vec3_add(held, turn));
    }
    return work;
}

/* [J] sum m a . b / 2 over the vertices and bodies that can move */
static double compute_energy(const contact_scene *scene, const double *a, const double *b) {
    double sum = 0.0;
    for (size_t v = 0; v < scene->cloth_vertex_count; v++)
        if (scene->inverse_mass[v] > 0.0)
            sum += vec3_dot(vec3_load(a, v), vec3_load(b, v)) / scene->inverse_mass[v];
    for (size_t i = 0; i < scene->body_count; i++) {
        const contact_body *const body = &scene->bodies[i];
        size_t const slot = get_body_slot(scene, i);
        if (!body->is_free) continue;
        sum += body->body->mass * vec3_dot(vec3_load(a, slot), vec3_load(b, slot));
        sum += vec3_dot(vec3_load(a, slot + 1),
                        mat3_multiply_vec3(&body->inertia, vec3_load(b, slot + 1)));
    }
    return 0.5 * sum;
}

/* Cuts a rebound that would have more energy than is allowed: goes only the largest part of the way
 * from `before`, the inelastic end, to v1 for which T(before + part (v1 - before)) <= allowed.
 * Speeds of approach were taken at the start; forces within the step may have spent some. */
static void limit_energy(const contact_scene *scene, double allowed, const double *before,
                         double *v1) {
    size_t const size = 3 * get_solved_count(scene);
    double const after = compute_energy(scene, v1, v1),
                 rest = compute_energy(scene, before, before);
    if (after <= fmax(allowed, rest)) return;
    double const mixed = compute_energy(scene, before, v1);
    double const a = after - 2.0 * mixed + rest, b = mixed - rest, c = rest - allowed;
    /* a part^2 + 2 b part + c = 0 with c <= 0 has one root in 0 .. 1 */
    double const root2 = b * b - a * c;
    double part = a > 0.0 && root2 > 0.0 ? (sqrt(root2) - b) / a : 0.0;
    part = part > 0.0 ? fmin(part, 1.0) : 0.0;
    for (size_t i = 0; i < size; i++) v1[i] = before[i] + part * (v1[i] - before[i]);
}

tulle_status end_contacts(const contact_scene *scene, row_list *list, const double *u, double *v1,
                          end_velocities *ends) {
    /* the speed at which each impact must part at the end */
    size_t loaded_count = 0;
    ends->approach = 0.0;
    ends->rebound_count = 0;
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        row_law *const law = &list->rows.data[i].law;
        bool const is_loaded = get_normal_impulse(row) > 0.0;
        loaded_count += is_loaded;
        law->rebound = 0.0;
        if (!(law->restitution > 0.0) || !is_loaded || !row_is_impact(scene, row)) continue;
        double const end = law->approach + law->fall;
        double part = end < 0.0 ? law->bias / end : 0.0;
        part = part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
        law->rebound = -law->restitution * (law->approach + part * law->fall);
        ends->rebound_count += law->rebound > 0.0;
    }
    if (loaded_count == 0 || (ends->rebound_count == 0 && !ends->is_inelastic)) return TULLE_OK;
    arena_mark const mark = arena_get_mark(scene->scratch);
    size_t const size = 3 * get_solved_count(scene);
    contact_row *const rows = ARENA_NEW(scene->scratch, contact_row, loaded_count);
    double *const before = ARENA_NEW(scene->scratch, double, size);
    tulle_status status = rows && before ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    /* copies of the rows that carry load, with the normal speeds that they must end with */
    size_t count = 0;
    for (size_t i = 0; i < list->rows.count && status == TULLE_OK; i++) {
        if (!(get_normal_impulse(&list->rows.data[i]) > 0.0)) continue;
        contact_row *const row = &rows[count++];
        *row = list->rows.data[i];
        row->solve.friction_cap = -1.0;
        row->law.return_velocity = vec3_make(0.0, 0.0, 0.0);
        /* at the end its frame stands; what rides on an obstacle still turns with it */
        row->frame.turning = vec3_reject(row->frame.turning, row->frame.normal);
        if (row->law.rebound > 0.0 || ends->is_inelastic) {
            row->law.bias = row->law.rebound; /* 0 where it does not rebound */
            row->solve.compliance = 0.0;
        }
    }
    if (status == TULLE_OK) {
        memcpy(before, v1, size * sizeof(double));
        status = project_impulses(scene, END_SWEEPS, rows, count, v1);
    }
    if (status == TULLE_OK) {
        for (size_t i = 0; i < count; i++) {
            double const speed =
                vec3_dot(rows[i].frame.normal, get_relative_velocity(&rows[i], v1));
            ends->approach = fmax(ends->approach, rows[i].law.bias - speed);
        }
        double const allowed = ends->kinetic_limit + compute_obstacle_work(scene, rows, count, u);
        if (ends->rebound_count > 0) limit_energy(scene, allowed, before, v1);
    }
    arena_release(scene->scratch, mark);
    return status;
}
