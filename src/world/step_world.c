/* world/step_world.c - tulle_world_step: a step of the world, all or nothing; the judgement of
 * obstacles that appear in it, and of bodies that come free. */
#include "base/error.h"
#include "base/parallel.h"
#include "base/timer.h"
#include "step/sleep/cloth_sleep.h"
#include "step/step.h"
#include "world/record/record.h"
#include "world/start/inside.h"

#include <math.h>
#include <stdio.h>

/* Judges obstacles that have just appeared in a state; all others are clean already.
 * One that appears into cloth is an error or is ignored, as the def says. */
static tulle_status judge_appearance(tulle_world *world, const motion_state *state,
                                     tulle_error *error) {
    const intersection_list *const list = &world->intersections;
    size_t const cloth_count = world->model.cloths.count;
    bool const is_ignored = world->model.def.start_intersections == TULLE_START_IGNORE;
    char when[WORLD_NAME_BYTES + 64];
    tulle_status const status =
        world_find_intersections(world, state->positions, &world->intersections, error);
    if (status != TULLE_OK || (list->count == 0 && is_ignored)) return status;
    if (list->count == 0) {
        snprintf(when, sizeof when, "when one of them appears or comes free at %.6g s",
                 state->time);
        return world_refuse_inside(world, state->positions,
                                   (inside_question){.when = when, .is_late = true}, error);
    }
    if (is_ignored) {
        /* a message that names the first obstacle that appears in something, and in what */
        size_t count = 0;
        uint32_t caught = 0, late = 0;
        for (size_t i = 0; i < list->count; i++) {
            uint32_t const a = list->data[i].object_a, b = list->data[i].object_b;
            bool const is_new_a = a >= cloth_count && !world->now.is_present[a - cloth_count];
            bool const is_new_b = b >= cloth_count && !world->now.is_present[b - cloth_count];
            if (!is_new_a && !is_new_b) continue;
            if (count++ > 0) continue;
            caught = is_new_b ? a : b;
            late = is_new_b ? b : a;
        }
        if (count > 0)
            snprintf(world->message, sizeof world->message,
                     "'%s' is caught at %.6g s in '%s', which appears there: %zu pairs of "
                     "triangles intersect and are let be until they come apart "
                     "(start_intersections: ignore)",
                     world_surface_name(&world->model, caught), state->time,
                     world_surface_name(&world->model, late), count);
        return world_ignore_intersections(world, error);
    }
    /* "at 0.8 s, when 'late' appears": the first obstacle of the pairs that is new */
    snprintf(when, sizeof when, "at %.6g s, when a body comes free", state->time);
    bool is_named = false;
    for (size_t i = 0; i < 2 * list->count && !is_named; i++) {
        const tulle_intersection *const pair = &list->data[i / 2];
        uint32_t const object = i % 2 == 0 ? pair->object_a : pair->object_b;
        is_named = object >= cloth_count && !world->now.is_present[object - cloth_count];
        if (is_named)
            snprintf(when, sizeof when, "at %.6g s, when '%s' appears", state->time,
                     world_surface_name(&world->model, object));
    }
    return world_refuse_intersections(world, state->positions, when, error);
}

/* [s] The integrators say nothing sensible beyond it. */
static const double TIME_STEP_MAX = 1.0;

tulle_step_progress tulle_world_get_step_progress(const tulle_world *world) {
    return world ? world->work.progress : (tulle_step_progress){0};
}

/* Puts the copy in the place of the state. */
static tulle_status swap_states(tulle_world *world, tulle_error *error) {
    /* Both sides get the same room, so that a step which needs no more than those before it makes
     * no heap call. */
    memory *const heap = &world->heap;
    row_list *const rows = &world->work.rows, *const accepted = &world->accepted_rows;
    bool const has_room =
        ARRAY_MATCH(heap, &rows->rows, &accepted->rows) &&
        ARRAY_MATCH(heap, &rows->near_pairs.pairs, &accepted->near_pairs.pairs) &&
        ARRAY_MATCH(heap, &world->now.contacts.contacts, &world->next.contacts.contacts);
    if (!has_room)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    motion_state const old = world->now;
    world->now = world->next;
    world->next = old;
    row_list const old_rows = world->accepted_rows;
    world->accepted_rows = world->work.rows;
    world->work.rows = old_rows;
    world->has_contacts = world->work.has_queries = false;
    world->now.step_count++;
    if (world->ignored.count > 0) world_update_ignored(world, world->now.positions);
    return TULLE_OK;
}

/* The step of a world that moves: its copy becomes the state, or all is as it was. */
static tulle_status run_on_copy(tulle_world *world, tulle_error *error) {
    motion_state *const next = &world->next;
    step_work *const work = &world->work;
    arena_mark const mark = arena_get_mark(&work->scratch);
    bool has_appeared = false;
    tulle_status status = world_begin_given(world, error);
    if (status == TULLE_OK && step_copy_start(&world->model, next, work, &has_appeared) != TULLE_OK)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for contacts");
    if (status == TULLE_OK && has_appeared) status = judge_appearance(world, next, error);
    if (status == TULLE_OK) {
        status = step_run(&world->model, next, work);
        if (status == TULLE_OK)
            world_tell_findings(world);
        else
            (void)world_tell_failure(world, status, error);
    }
    arena_release(&work->scratch, mark);
    work->progress = (tulle_step_progress){0};
    if (atomic_load(&work->stop.is_stopped))
        status =
            error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted in step %llu, which is undone",
                      (unsigned long long)world->now.step_count);
    if (status == TULLE_OK) status = world_find_touching(world, next, error);
    if (status == TULLE_OK) status = swap_states(world, error);
    world_end_given(world, status != TULLE_OK);
    if (status == TULLE_OK) {
        world_tell_events(world);
    } else {
        step_undo(&world->model, work);
        world_restore_ignored(world);
    }
    return status;
}

static tulle_status make_step(tulle_world *world, double time_step, tulle_step_report *report,
                              tulle_error *error) {
    double const start = timer_now();
    if (world->is_started) world->message[0] = '\0';
    tulle_status status = world_start(world, true, NULL, error);
    if (status != TULLE_OK) return status;

    tulle_step_report local = {
        .step = world->now.step_count, .cg_converged = 1, .smallest_gap = (double)INFINITY};
    step_work *const work = &world->work;
    const tulle_tasks *const before = parallel_use(work->tasks);
    atomic_store(&work->stop.is_stopped, false);
    work->whole_step = time_step;
    work->step_end = world->now.time + time_step;
    work->report = &local;
    work->error = error;
    work->failure = (step_finding){0};
    if (step_stands_still(&world->model, work)) {
        local.contacts = world->accepted_rows.rows.count;
        status = step_pass_still(&world->model, &world->now, work);
        if (status != TULLE_OK) status = world_tell_failure(world, status, error);
    } else {
        /* what a step that fails puts back */
        status = world_keep_ignored(world, error);
        if (status == TULLE_OK && step_keep_patches(work) != TULLE_OK)
            status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left for patches");
        if (status == TULLE_OK)
            status = run_on_copy(world, error);
        else
            world_end_given(world, true);
    }
    (void)parallel_use(before);
    work->report = NULL;
    work->error = NULL;

    local.time = world->now.time;
    local.ignored_pairs = world->ignored.count;
    local.total_seconds = timer_now() - start;
    if (report) *report = local;
    return status;
}

tulle_status tulle_world_step(tulle_world *world, double time_step, tulle_step_report *report,
                              tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (!(time_step > 0.0 && time_step <= TIME_STEP_MAX))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the time step is %g s; it must be greater than 0 and at most %g s",
                         time_step, TIME_STEP_MAX);
    recorded_call const call = {.kind = RECORD_STEP, .arrays = {{&time_step, 1}}};
    tulle_status status = world_begin_call(world, &call, error);
    if (status != TULLE_OK) return status;
    status = make_step(world, time_step, report, error);
    world_end_call(world, status);
    return status;
}
