/* step/energy_balance.c - the energy that a substep may end with, and damping.
 *
 * At the end of a substep, kinetic energy and the true potentials of springs, bending and gravity
 * may not exceed the energy at its start plus the work from outside: of wind, of pins and of
 * obstacles on scripts. Takes the substep as solved; gives what is left for the kinetic energy. */
#include "step/energy_balance.h"

#include "contact/rows/row_motion.h"
#include "contact/solve/end_velocities.h"
#include "step/bodies/bodies.h"
#include "step/ties/ties.h"

#include <math.h>
#include <string.h>

/* A gain is worth another solve if it is over the sum of two slacks. This is the first one, as a
 * share of the kinetic energy that gravity gives in a step from rest. */
static const double GRAVITY_SHARE = 1e-6;
/* The second slack: a share of the kinetic energy at the start. */
static const double KINETIC_SHARE = 1e-12;

/* A substep that gains more than this share of the energy at work in it is tried again at half its
 * length. Where all is well, a substep gains under a hundred thousandth of that energy. Very stiff
 * cloth that the solve has lost gains a hundred times that energy. */
static const double GAIN_MAX = 0.1;

/* The solve is lost when springs take so many times as much as is at work in the substep. What
 * moves slowly and pulls stiff cloth may well give more than that, so the springs' excess over what
 * is linear counts. Sheets that land well stay below. */
static const double LOST_SHARE = 1000.0;
/* A solution that no other follows may have so many times as much: a script that moves slowly and
 * pulls stiff cloth gives more than its own speed tells. */
static const double LAST_SHARE = 10.0;
/* A solution goes back on its way by so many halvings at most. */
enum { HALVINGS_MAX = 30 };

bool step_keeps_balance(const step_model *model, const step_work *work) {
    return work->sub.scene.response->balances_energy && work->rows.rows.count > 0 &&
           !model->cloth_model->shape && /* targets give what they like */
           work->system.integrator == TULLE_INTEGRATOR_IMPLICIT_EULER;
}

bool step_gains_too_much(const step_work *work, const lost_solve *lost) {
    return lost->is_tempered || work->sub.gain > GAIN_MAX * work->sub.energy_scale;
}

/* Energies of the cloths at `positions` with the velocities of state. Elastic energies are taken
 * from *elastic if they are known; otherwise they are measured into it. */
static tulle_status measure_cloths(const step_model *model, motion_state *state, step_work *work,
                                   const double *positions, known_elastic *elastic,
                                   cloth_energies *energies) {
    energy_options const options = {.gravity = vec3_load(model->def.gravity, 0),
                                    .threads = work->threads,
                                    .plastic = state->plastic,
                                    .is_elastic_known = elastic->is_known};
    if (elastic->is_known) energies->elastic = elastic->energies;
    tulle_status const status = compute_energies(model->cloth_model, positions, state->velocities,
                                                 options, &work->scratch, energies);
    if (status != TULLE_OK) return status;
    *elastic = (known_elastic){energies->elastic, true};
    return TULLE_OK;
}

tulle_status step_report_energies(const step_model *model, motion_state *state, step_work *work) {
    tulle_step_report *const report = work->report;
    cloth_energies energies;
    tulle_status const status =
        measure_cloths(model, state, work, state->positions, &state->elastic, &energies);
    if (status != TULLE_OK) return status;
    body_energies const bodies =
        step_measure_bodies(model, work, state->positions, state->velocities);
    report->kinetic_energy = energies.kinetic + bodies.kinetic;
    report->gravity_energy = energies.gravity + bodies.gravity;
    report->elastic_energy = energies.elastic.stretch + energies.elastic.bend;
    report->max_stretch = energies.elastic.max_stretch;
    report->overstretched = energies.elastic.overstretched;
    return TULLE_OK;
}

/* Work [J] of the pins that hold cloth vertices, without their contacts: u . (A u - b). */
static tulle_status measure_pins(const step_model *model, step_work *work, double *pulled) {
    const double *const u = work->sub.mean_velocity;
    bool moves = false;
    *pulled = 0.0;
    for (size_t v = 0; v < model->cloth_vertex_count; v++)
        moves |= work->is_fixed[v] && vec3_norm2(vec3_load(u, v)) > 0.0;
    if (!moves) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&work->scratch);
    double *const product = ARENA_NEW(&work->scratch, double, 3 * model->cloth_vertex_count);
    if (!product) return TULLE_ERROR_OUT_OF_MEMORY;
    block_matrix_operator matrix = {&work->system.matrix, work->threads};
    block_matrix_apply(&matrix, u, product);
    for (size_t v = 0; v < model->cloth_vertex_count; v++) {
        if (!work->is_fixed[v]) continue;
        vec3 const pull =
            vec3_sub(vec3_load(product, v), vec3_load(work->system.right_hand_side, v));
        *pulled += vec3_dot(pull, vec3_load(u, v));
    }
    arena_release(&work->scratch, mark);
    return TULLE_OK;
}

/* Kinetic energy [J] of the vertices that are held or of those that are not, with velocities u. */
static double measure_kinetic(const step_model *model, const step_work *work, bool is_held) {
    double sum = 0.0;
    for (size_t v = 0; v < model->cloth_vertex_count; v++)
        if ((work->is_fixed[v] != 0) == is_held)
            sum += 0.5 * model->cloth_model->masses[v] *
                   vec3_norm2(vec3_load(work->sub.mean_velocity, v));
    return sum;
}

tulle_status step_compute_kinetic_limit(const step_model *model, motion_state *state,
                                        step_work *work, kinetic_limit *limit) {
    double wind, pins;
    cloth_energies start, end;
    tulle_status status =
        measure_cloths(model, state, work, state->positions, &state->elastic, &start);
    if (status == TULLE_OK)
        status = measure_cloths(model, state, work, work->sub.end, &work->sub.end_elastic, &end);
    if (status == TULLE_OK)
        status = measure_wind_work(model->cloth_model, &work->sub.dynamics, work->sub.mean_velocity,
                                   (wind_work_options){&model->def.wind, work->threads},
                                   &work->scratch, &wind);
    if (status == TULLE_OK) status = measure_pins(model, work, &pins);
    if (status != TULLE_OK) return status;
    body_energies const before =
        step_measure_bodies(model, work, state->positions, state->velocities);
    body_energies const after = step_measure_bodies(model, work, work->sub.end, state->velocities);
    limit->start = start.kinetic + before.kinetic;
    double const potential_start = start.gravity + start.elastic.stretch + start.elastic.bend;
    double const potential_end = end.gravity + end.elastic.stretch + end.elastic.bend;
    limit->energy = limit->start + before.gravity - after.gravity + potential_start -
                    potential_end + wind + pins + step_measure_tie_work(work) +
                    step_measure_control_work(model, state, work) -
                    measure_kinetic(model, work, true);
    return TULLE_OK;
}

tulle_status step_measure_gain(const step_model *model, motion_state *state, step_work *work) {
    work->sub.gain = 0.0;
    if (!step_keeps_balance(model, work)) return TULLE_OK;
    vec3 const fall = vec3_scale(vec3_load(model->def.gravity, 0), work->sub.time_step);
    const double *const u = work->sub.mean_velocity;
    kinetic_limit limit;
    tulle_status const status = step_compute_kinetic_limit(model, state, work, &limit);
    if (status != TULLE_OK) return status;
    double mass = 0.0;
    for (size_t v = 0; v < model->cloth_vertex_count; v++) mass += model->cloth_model->masses[v];
    for (size_t b = 0; b < model->body_count; b++)
        mass += model->obstacles.data[model->body_obstacles[b]].rigid.mass;
    double const outside =
        compute_obstacle_work(&work->sub.scene, work->rows.rows.data, work->rows.rows.count, u);
    double const slack =
        GRAVITY_SHARE * 0.5 * mass * vec3_norm2(fall) + KINETIC_SHARE * limit.start;
    work->sub.energy_scale = fmax(limit.start, limit.energy) + mass * vec3_norm2(fall);
    double const bodies = step_measure_bodies(model, work, state->positions, u).kinetic;
    work->sub.gain = measure_kinetic(model, work, false) + bodies - limit.energy - outside - slack;
    return TULLE_OK;
}

/* Energy [J] at work in a substep, from above: what cloth and bodies have, what cloth gets by its
 * fall, and as much as if all of it went as fast as the fastest of pins and obstacles. */
static tulle_status measure_work(const step_model *model, motion_state *state, step_work *work,
                                 double *energy) {
    double const fall = vec3_norm(vec3_load(model->def.gravity, 0)) * work->sub.time_step;
    double mass = 0.0, fastest2 = 0.0;
    for (size_t v = 0; v < model->cloth_vertex_count; v++) mass += model->cloth_model->masses[v];
    for (size_t v = 0; v < model->vertex_count; v++) {
        if (work->sub.scene.inverse_mass[v] > 0.0) continue;
        vec3 const x0 = vec3_load(state->positions, v);
        vec3 const way = vec3_sub(vec3_load(work->sub.scene.targets, v), x0);
        fastest2 = fmax(fastest2, vec3_norm2(way) / (work->sub.time_step * work->sub.time_step));
    }
    cloth_energies cloths = {0};
    tulle_status const status =
        measure_cloths(model, state, work, state->positions, &state->elastic, &cloths);
    body_energies const bodies =
        step_measure_bodies(model, work, state->positions, state->velocities);
    *energy = cloths.elastic.stretch + 2.0 * (cloths.kinetic + bodies.kinetic) +
              mass * (fall * fall + fastest2);
    return status;
}

/* Newton's method diverges if a solution stretches stiff cloth far: the tangent there throws it
 * farther off. No motion can have more energy than there is, so springs are never linearised about
 * such a solution. It is moved back towards the guess before it, by halves, until its energy is low
 * enough. Pins go their part of it in the guess, but not in u. */
tulle_status step_temper_solution(const step_model *model, motion_state *state, step_work *work,
                                  const linear_excess *excess, bool is_last, lost_solve *lost) {
    double energy;
    tulle_status status = measure_work(model, state, work, &energy);
    if (status != TULLE_OK) return status;
    bool const was_lost = lost->is_lost;
    lost->is_lost |= excess->springs > LOST_SHARE * energy;
    if (!lost->is_lost) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&work->scratch);
    size_t const size = 3 * model->cloth_vertex_count;
    double *const before = ARENA_NEW_ZEROED(&work->scratch, double, size);
    double *const ends = ARENA_NEW(&work->scratch, double, size);
    if (!before || !ends) return TULLE_ERROR_OUT_OF_MEMORY;
    if (was_lost) memcpy(before, work->sub.guess, size * sizeof *before);
    double const most = (is_last ? LAST_SHARE : 1.0) * energy;
    double part = 1.0;
    for (int halvings = 0; status == TULLE_OK; halvings++, part *= 0.5) {
        double kinetic = 0.0;
        for (size_t i = 0; i < size; i++) {
            double const way = work->sub.mean_velocity[i] - before[i];
            work->sub.guess[i] =
                halvings == 0 ? work->sub.mean_velocity[i] : before[i] + part * way;
            if (!work->is_fixed[i / 3])
                kinetic += 0.5 * model->cloth_model->masses[i / 3] * work->sub.guess[i] *
                           work->sub.guess[i];
            ends[i] = state->positions[i] + work->sub.time_step * work->sub.guess[i];
        }
        known_elastic elastic = {.is_known = false};
        cloth_energies energies = {0};
        status = measure_cloths(model, state, work, ends, &elastic, &energies);
        if (energies.elastic.stretch + kinetic <= most || halvings == HALVINGS_MAX) break;
        lost->is_tempered = is_last;
    }
    for (size_t i = 0; i < size && status == TULLE_OK; i++)
        if (!work->is_fixed[i / 3]) work->sub.mean_velocity[i] = work->sub.guess[i];
    arena_release(&work->scratch, mark);
    return status;
}

/* ---- room: bodies that are too near make it only as far as there is energy for it ----
 *
 * A row inside the contact distance asks for speed apart. If the row carries load, that speed lifts
 * the objects that hang or stand there, as between the rings of a chain or below a stack on a
 * sheet. No force does that work. So rows of bodies may only use energy that the steps lose anyway,
 * by impact, friction and the integrator. */

/* Rows may use this share of the energy that the substep before lost. */
static const double ROOM_SHARE = 0.5;

/* [m/s] Speed at which a row keeps its room. Without it, bodies that turn come nearer. */
static double compute_kept_speed(const step_work *work, const contact_row *row) {
    return -compute_row_curvature(&work->sub.scene, row) / work->sub.time_step;
}

static double compute_push(const contact_row *row) {
    return fmax(vec3_dot(row->frame.normal, row->solve.impulse), 0.0);
}

void step_share_room(motion_state *state, step_work *work) {
    row_list *const list = &work->rows;
    double asked = 0.0; /* [J] with the impulses of the substep before */
    for (size_t i = 0; work->sub.scene.body_count > 0 && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (row->frame.has_body)
            asked += compute_push(row) * fmax(row->law.bias - compute_kept_speed(work, row), 0.0);
    }
    double const budget = ROOM_SHARE * state->lost_energy;
    if (!(asked > budget)) return;
    for (size_t i = 0; i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const kept = compute_kept_speed(work, row);
        if (row->law.bias > kept) row->law.bias = kept + (row->law.bias - kept) * (budget / asked);
    }
}

bool step_ask_less_room(step_work *work, int level) {
    row_list *const list = &work->rows;
    bool has_changed = false;
    for (size_t i = 0; work->sub.scene.body_count > 0 && i < list->rows.count; i++) {
        contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const kept = level == 0 ? compute_kept_speed(work, row) : 0.0;
        if (!(row->law.bias > kept)) continue;
        has_changed |= compute_push(row) > 0.0;
        row->law.bias = kept;
    }
    return has_changed;
}

void step_note_loss(step_work *work) {
    const row_list *const list = &work->rows;
    double given = 0.0; /* [J] of making room */
    for (size_t i = 0; work->sub.scene.body_count > 0 && i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (!row->frame.has_body) continue;
        double const speed =
            vec3_dot(row->frame.normal, get_relative_velocity(row, work->sub.mean_velocity));
        given += compute_push(row) * fmax(speed - compute_kept_speed(work, row), 0.0);
    }
    work->sub.lost_energy =
        work->sub.scene.body_count > 0 ? fmax(given - work->sub.gain, 0.0) : 0.0;
}

/* ---- damping: how far a step goes from its integrator towards implicit Euler ----
 *
 * Crank-Nicolson turns the sign of modes that the step does not resolve, and BDF2 continues with
 * velocities from before an impact. So a step with an impact is one of implicit Euler, which also
 * stops the cloth that hangs on the vertex that hit; the next step takes no history from it.
 * Impulses that have not settled excite modes that the step does not resolve, so steps with contact
 * are damped. Free steps of Crank-Nicolson are damped a little. The damping is a rate times the
 * step, so the order without impacts stays two. It is the same for all vertices: linear momentum is
 * kept.
 *
 * Takes rows as gathered and velocities at the start; gives force_options.damping. The numerical
 * damping of free motion is computed here, too. */

/* [1/s] Least rates with which cloth that hangs free gains no energy at steps of 1/90 s. */
static const double FREE_RATES[] = {[TULLE_INTEGRATOR_IMPLICIT_EULER] = 0.0,
                                    [TULLE_INTEGRATOR_CRANK_NICOLSON] = 10.0,
                                    [TULLE_INTEGRATOR_BDF2] = 0.0};
/* [1/s] With this rate cloth on needles comes to rest about as well as by implicit Euler. */
static const double CONTACT_RATE = 40.0;

double step_choose_damping(const step_model *model, step_work *work) {
    tulle_integrator const integrator = model->def.integrator;
    if (integrator == TULLE_INTEGRATOR_IMPLICIT_EULER) return 0.0;
    const row_list *const list = &work->rows;
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        bool const is_faster = row->law.approach + row->law.fall < row->law.bias;
        if (is_faster && row_is_impact(&work->sub.scene, row)) return 1.0;
    }
    double rate = FREE_RATES[integrator];
    if (work->rows.rows.count > 0) rate = CONTACT_RATE;
    return fmin(rate * work->sub.time_step, 1.0);
}

/* ---- the damping of free motion ---- */

/* By what a step multiplies x + i v / omega of a motion that turns by omega h in it. */
typedef struct amplification {
    double size, angle;
} amplification;

/* `share` is c of docs/method/integrators.md. */
static amplification find_amplification(tulle_integrator integrator, double share, double turn) {
    double const next = share * turn, rest = 1.0 - share;
    if (integrator != TULLE_INTEGRATOR_BDF2)
        return (amplification){hypot(1.0, rest * turn) / hypot(1.0, next),
                               atan(rest * turn) + atan(next)};
    /* The root of (1 - i c turn) z^2 - (2 - c) z + 1 - c that is 1 where nothing turns. */
    double const real = share * share, imaginary = 4.0 * rest * next;
    double const root = sqrt(0.5 * (hypot(real, imaginary) + real));
    double const sum = 2.0 - share + root, part = 0.5 * imaginary / root;
    return (amplification){0.5 * hypot(sum, part) / hypot(1.0, next),
                           atan2(part, sum) + atan(next)};
}

double measure_numerical_damping(tulle_integrator integrator, double time_step, double period) {
    static double const most_turn = 1e9; /* so that nothing overflows */
    double const damping = fmin(FREE_RATES[integrator] * time_step, 1.0);
    double share = 1.0;
    if (integrator == TULLE_INTEGRATOR_CRANK_NICOLSON) share = 0.5 + 0.5 * damping;
    if (integrator == TULLE_INTEGRATOR_BDF2) share = (2.0 + damping) / 3.0;
    double const turn = fmin(2.0 * 3.14159265358979323846 * time_step / period, most_turn);
    amplification const factor = find_amplification(integrator, share, turn);
    double const loss = fmax(-log(factor.size), 0.0);
    return loss / hypot(loss, factor.angle);
}
