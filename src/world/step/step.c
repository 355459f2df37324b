/* world/step/step.c - tulle_world_step: a whole step in one or more substeps, all or nothing.
 *
 * The step works on a copy of the state and swaps it in at the end, so a step that fails leaves the
 * world as it was. A substep that had to shorten time is followed by another over what is left. */
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_sleep.h"
#include "world/bodies/bodies_turn.h"
#include "world/pinch/holds.h"
#include "world/step/detection.h"

#include "base/error.h"
#include "base/timer.h"

#include <math.h>
#include <string.h>

/* Longest time step [s]; the integrators say nothing sensible beyond it. */
static const double TIME_STEP_MAX = 1.0;
/* What is left of a step under this share of it is not worth a substep: rounding. */
static const double REMAINDER_SHARE = 1e-9;
/* Substeps are not halved below this share of the step; a power of two. */
static const double SHORTEST_SUBSTEP_SHARE = 1.0 / 4.0;
/* Substeps of one step before it counts as pinched. */
enum { SUBSTEPS_MAX = 48 };
/* So many substeps in a row that each pass less than this share of what they are to pass count as
 * pinched. */
enum { CRAWLS_MAX = 4 };
static const double CRAWL_SHARE = 0.01;
/* A step that is stuck is retried so often with substeps that are shorter by so many halvings. */
enum { RETRIES_MAX = 3, RETRY_HALVINGS = 2 };

static void copy_state(const tulle_world *world, const world_motion_state *source,
                       world_motion_state *target) {
    size_t const bytes = 3 * world->vertex_count * sizeof(double);
    memcpy(target->positions, source->positions, bytes);
    memcpy(target->velocities, source->velocities, bytes);
    memcpy(target->previous_mean, source->previous_mean, bytes);
    memcpy(target->previous_velocities, source->previous_velocities, bytes);
    if (world->obstacles.count > 0) {
        memcpy(target->is_released, source->is_released, world->obstacles.count);
        memcpy(target->is_present, source->is_present, world->obstacles.count);
    }
    if (world_particle_count(world) > 0)
        memcpy(target->particles, source->particles, world_particle_count(world));
    if (world->body_count > 0)
        memcpy(target->rests, source->rests, world->body_count * sizeof *target->rests);
    target->previous_time_step = source->previous_time_step;
    target->lost_energy = source->lost_energy;
    target->elastic = source->elastic;
    target->has_elastic = source->has_elastic;
    memcpy(target->holds, source->holds, source->hold_count * sizeof *source->holds);
    target->hold_count = source->hold_count;
    target->time = source->time;
}

static tulle_status copy_contacts(tulle_world *world, const contact_store *source,
                                  contact_store *target) {
    target->contacts.count = 0;
    if (reserve_contacts(target, &world->heap, source->contacts.count) != TULLE_OK) {
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (source->contacts.count > 0) {
        memcpy(target->contacts.data, source->contacts.data,
               source->contacts.count * sizeof *source->contacts.data);
    }
    target->contacts.count = source->contacts.count;
    target->time_step = source->time_step;
    return TULLE_OK;
}

/* Keeps what undo_step puts back. */
static tulle_status keep_start(tulle_world *world, tulle_error *error) {
    tulle_status const status = world_keep_ignored(world, error);
    if (status != TULLE_OK || world_keep_patches(world) == TULLE_OK) return status;
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for patches");
}

/* Undoes what a step that failed changed outside its copy of the state. */
static void undo_step(tulle_world *world) {
    for (size_t i = 0; i < world->obstacles.count; i++) {
        world->surfaces[world->cloths.count + i].is_present = world->now.is_present[i];
    }
    world_mark_bodies(world, &world->now);
    world_restore_ignored(world);
    world_restore_patches(world);
}

/* Whether the last substep shows that going on as before is hopeless. What a turn alone cut short
 * is no sign of it. */
static bool is_stuck(step_context *context, double wanted) {
    double const whole = context->is_cut_by_turns ? context->time_step : wanted;
    bool const is_slow = context->passed < CRAWL_SHARE * whole;
    context->crawl_count = is_slow ? context->crawl_count + 1 : 0;
    return context->commit.outcome == COMMIT_BLOCKED || context->crawl_count >= CRAWLS_MAX ||
           context->report->substeps >= context->substep_limit;
}

/* A step that is stuck while something follows a script goes on with shorter substeps: what turns
 * fast leaves its circle less, and cloth that rides on it comes less near. */
static bool retry_shorter(step_context *context, double time_step, double *wanted) {
    if (context->retry_count == RETRIES_MAX || !world_is_script_moving(context)) return false;
    context->retry_count++;
    *wanted = ldexp(time_step, -RETRY_HALVINGS * context->retry_count);
    context->substep_limit += 1u << (RETRY_HALVINGS * context->retry_count);
    context->crawl_count = 0;
    return true;
}

/* What a stop request may ask for. */
static void note_progress(step_context *context, double share) {
    const tulle_step_report *const report = context->report;
    context->world->progress = (tulle_step_progress){.is_under_way = 1,
                                                     .step = report->step,
                                                     .substep = report->substeps + 1,
                                                     .share = share,
                                                     .solve_count = report->solve_count};
}

/* Length of the next substep, `longest` [s] but for bodies that turn. */
static tulle_status choose_length(step_context *context, double longest) {
    context->time_step = fmin(longest, context->turn_time);
    tulle_status const status = world_limit_turns(context, &context->time_step);
    context->is_cut_by_turns = context->time_step < longest;
    context->turn_time = (double)INFINITY;
    return status;
}

/* Substeps that turns alone asked for do not count as those of a step that is stuck. */
static void allow_for_turns(step_context *context) {
    bool const is_whole =
        !context->is_rejected && context->commit.outcome == COMMIT_CLEAN && !context->has_woken;
    if ((context->is_cut_by_turns && is_whole) || isfinite(context->turn_time))
        context->substep_limit++;
}

/* Substeps until time_step [s] has passed. */
static tulle_status run_substeps(step_context *context, double time_step) {
    double const end_time = context->state->time + time_step;
    double remaining = time_step;
    double wanted = time_step; /* length of the next substep, halved when one is rejected */
    context->substep_limit = context->report->substeps + SUBSTEPS_MAX;
    context->crawl_count = context->retry_count = 0;
    context->shortest_step = SHORTEST_SUBSTEP_SHARE * time_step;
    context->turn_time = (double)INFINITY;
    while (remaining > REMAINDER_SHARE * time_step && !context->is_rest_skipped) {
        note_progress(context, 1.0 - remaining / time_step);
        if (stop_is_wanted(&context->world->stop)) return TULLE_ERROR_INTERRUPTED;
        tulle_status status = choose_length(context, fmin(wanted, remaining));
        if (status == TULLE_OK) status = world_advance(context);
        if (status != TULLE_OK) return status;
        allow_for_turns(context);
        if (context->has_woken) continue;
        if (context->is_rejected) {
            if (!isfinite(context->turn_time)) wanted = 0.5 * context->time_step;
            continue;
        }
        remaining -= context->passed;
        if (remaining <= REMAINDER_SHARE * time_step || !is_stuck(context, wanted)) continue;
        if (retry_shorter(context, time_step, &wanted)) continue;
        context->is_pinched = world_is_script_moving(context);
        if (context->is_pinched) return TULLE_OK;
        world_skip_rest(context);
    }
    context->state->time = end_time;
    return TULLE_OK;
}

static tulle_status check_step(tulle_world *world, double time_step, tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (!(time_step > 0.0 && time_step <= TIME_STEP_MAX)) {
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the time step is %g s; it must be over 0 and at most %g s", time_step,
                         TIME_STEP_MAX);
    }
    return tulle_world_start(world, error);
}

/* The copy on which the step works. */
static tulle_status begin_step(tulle_world *world, tulle_error *error) {
    copy_state(world, &world->now, &world->next);
    if (copy_contacts(world, &world->now.contacts, &world->next.contacts) != TULLE_OK) {
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    }
    return world_update_presence(world, &world->next, error);
}

/* What is swapped at the end of a step gets the same room on both sides, so that a step which needs
 * no more than those before it makes no heap call. */
static tulle_status match_rooms(tulle_world *world, tulle_error *error) {
    memory *const heap = &world->heap;
    row_list *const rows = &world->rows, *const accepted = &world->accepted_rows;
    if (ARRAY_MATCH(heap, &rows->rows, &accepted->rows) &&
        ARRAY_MATCH(heap, &rows->near_pairs.pairs, &accepted->near_pairs.pairs) &&
        ARRAY_MATCH(heap, &world->now.contacts.contacts, &world->next.contacts.contacts))
        return TULLE_OK;
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
}

static void end_step(tulle_world *world) {
    world_motion_state const old = world->now;
    world->now = world->next;
    world->next = old;
    row_list const old_rows = world->accepted_rows;
    world->accepted_rows = world->rows;
    world->rows = old_rows;
    world->has_contacts = false;
    world->step_count++;
    if (world->ignored.count > 0) world_update_ignored(world, world->now.positions);
}

/* Energies and stretch at the end of the step. */
static tulle_status measure(step_context *context) {
    tulle_world *const world = context->world;
    tulle_step_report *const report = context->report;
    cloth_energies energies;
    tulle_status const status = world_measure_state(context, &energies);
    if (status != TULLE_OK) {
        return error_set(context->error, status, "no memory left for the energies");
    }
    body_energies const bodies =
        world_measure_bodies(world, context->state->positions, context->state->velocities);
    report->kinetic_energy = energies.kinetic + bodies.kinetic;
    report->gravity_energy = energies.gravity + bodies.gravity;
    report->elastic_energy = energies.elastic.stretch + energies.elastic.bend;
    report->max_stretch = energies.elastic.max_stretch;
    return TULLE_OK;
}

/* One go at the step; is_pinched tells whether it is to be undone. */
static tulle_status try_step(step_context *context, double time_step) {
    context->is_pinched = context->is_torn = context->is_rest_skipped = false;
    world_begin_holds(context);
    tulle_status status = world_begin_carriers(context);
    if (status == TULLE_OK) status = run_substeps(context, time_step);
    if (status != TULLE_OK || context->is_pinched) return status;
    status = world_settle_bodies(context, time_step);
    if (status == TULLE_OK) status = measure(context);
    if (status == TULLE_OK) context->is_pinched = context->is_torn = world_tears_squeezed(context);
    return status;
}

/* Undoes a step that is pinched; the next go holds back, or lets through, what the last one found.
 */
static tulle_status begin_again(step_context *context) {
    tulle_world *const world = context->world;
    world_motion_state *const state = context->state;
    world_hold holds[HOLDS_MAX];
    uint64_t const hold_count = state->hold_count;
    memcpy(holds, state->holds, sizeof holds);
    size_t const count = world->obstacles.count;
    uint8_t *const is_released = ARENA_NEW(&world->scratch, uint8_t, count);
    if (!is_released)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for a pinch");
    if (count > 0) memcpy(is_released, state->is_released, count);
    undo_step(world);
    tulle_status const status = begin_step(world, context->error);
    if (status != TULLE_OK) return status;
    memcpy(state->holds, holds, sizeof holds);
    state->hold_count = hold_count;
    for (size_t i = 0; i < count; i++) {
        if (!is_released[i] || state->is_released[i]) continue;
        state->is_released[i] = 1;
        state->is_present[i] = 0;
        world->surfaces[world->cloths.count + i].is_present = false;
        world_wake_all(world, state);
    }
    return TULLE_OK;
}

/* Goes at the step until it is not pinched. */
static tulle_status run_step(step_context *context, double time_step) {
    tulle_world *const world = context->world;
    context->whole_step = time_step;
    tulle_status status = begin_step(world, context->error);
    for (;;) {
        arena_mark const mark = arena_get_mark(&world->scratch);
        if (status == TULLE_OK) status = try_step(context, time_step);
        bool const is_pinched = status == TULLE_OK && context->is_pinched;
        if (is_pinched) status = world_handle_pinch(context);
        if (is_pinched && status == TULLE_OK) status = begin_again(context);
        arena_release(&world->scratch, mark);
        if (!is_pinched || status != TULLE_OK) return status;
    }
}

/* What was asked to stop has ended somewhere, with whatever result. */
static tulle_status check_stop(tulle_world *world, tulle_status status, tulle_error *error) {
    world->progress = (tulle_step_progress){0};
    if (!atomic_load(&world->stop.is_stopped)) return status;
    return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted in step %llu, which is undone",
                     (unsigned long long)world->step_count);
}

tulle_step_progress tulle_world_get_step_progress(const tulle_world *world) {
    return world ? world->progress : (tulle_step_progress){0};
}

tulle_status tulle_world_step(tulle_world *world, double time_step, tulle_step_report *report,
                              tulle_error *error) {
    double const start = timer_now();
    tulle_step_report local = {.cg_converged = 1, .smallest_gap = (double)INFINITY};
    tulle_status status = check_step(world, time_step, error);
    if (status != TULLE_OK) return status;
    local.step = world->step_count;
    world->message[0] = '\0';
    atomic_store(&world->stop.is_stopped, false);
    status = keep_start(world, error);
    if (status != TULLE_OK) return status;

    step_context context = {
        .world = world, .state = &world->next, .report = &local, .error = error};
    arena_mark const mark = arena_get_mark(&world->scratch);
    status = run_step(&context, time_step);
    if (status == TULLE_OK) status = world_end_pinch(&context);
    if (status == TULLE_OK) status = match_rooms(world, error);
    arena_release(&world->scratch, mark);
    status = check_stop(world, status, error);
    if (status == TULLE_OK)
        end_step(world);
    else
        undo_step(world);

    local.time = world->now.time;
    local.ignored_pairs = world->ignored.count;
    local.total_seconds = timer_now() - start;
    if (report) *report = local;
    return status;
}
