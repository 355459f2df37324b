/* app/view/live_thread.c - the loop of the world's thread: commands, a step, a frame. */
#define _POSIX_C_SOURCE 200809L
#include "app/view/live_thread.h"

#include "base/timer.h"
#include "tulle/paper.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const double LATE_MOST = 0.1; /* [s] by which steps may be late and still catch up */

void live_say(view_live *live, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(live->message, sizeof live->message, format, arguments);
    va_end(arguments);
}

static int is_stopped(void *context) {
    view_live *const live = context;
    return atomic_load(&live->is_quitting);
}

/* ---- frames ---- */

static void fill_contacts(view_live *live, view_overlay *overlay) {
    const tulle_contact *contacts = NULL;
    size_t count = 0;
    if (tulle_world_get_contacts(live->built.world, &contacts, &count, NULL) == TULLE_OK)
        overlay_put_contacts(overlay, contacts, count);
}

static tulle_object_id get_id(const view_live *live, size_t object) {
    size_t const cloth_count = live->built.cloth_count;
    return object < cloth_count
               ? tulle_object_from_cloth(live->built.cloths[object])
               : tulle_object_from_obstacle(live->built.obstacles[object - cloth_count]);
}

/* Values of the vertices or triangles of an object, if the world has them. */
static void fill_values(view_live *live, size_t object, tulle_values values, size_t count,
                        view_overlay *overlay) {
    float *const copy = memory_allocate(&live->heap, 3 * count * sizeof *copy);
    tulle_target const target = {copy, 3 * count * sizeof *copy, 0, TULLE_NUMBER_FLOAT};
    if (copy && tulle_object_copy_values(live->built.world, get_id(live, object), values, &target,
                                         NULL) == TULLE_OK) {
        overlay_put_object(overlay, object, count);
        buffer_put_f32s(&overlay->bytes, copy, 3 * count);
    }
    memory_release(&live->heap, copy, 3 * count * sizeof *copy);
}

static void fill_patches(view_live *live, size_t cloth, size_t count, view_overlay *overlay) {
    uint32_t *const labels = memory_allocate(&live->heap, count * sizeof *labels);
    size_t patch_count = 0;
    tulle_patch_options const options = {.is_in_use = 1};
    if (labels && tulle_cloth_get_patches(live->built.world, live->built.cloths[cloth], &options,
                                          labels, &patch_count, NULL) == TULLE_OK) {
        overlay_put_object(overlay, cloth, count);
        buffer_put_u32s(&overlay->bytes, labels, count);
    }
    memory_release(&live->heap, labels, count * sizeof *labels);
}

static void fill_overlay(view_live *live, view_overlay_kind kind, view_frame *frame) {
    const view_document *const document = live->options.document;
    view_overlay *const overlay = &frame->overlays[kind];
    overlay_begin(overlay);
    if (!live->is_started) return;
    if (kind == OVERLAY_CONTACTS) fill_contacts(live, overlay);
    for (size_t i = 0; i < document->object_count; i++) {
        tulle_mesh_view const mesh = document->objects[i].mesh;
        bool const is_cloth = i < document->cloth_count;
        if (kind == OVERLAY_VELOCITIES)
            fill_values(live, i, TULLE_VALUES_VELOCITIES, mesh.vertex_count, overlay);
        if (kind == OVERLAY_STRAIN && is_cloth)
            fill_values(live, i, TULLE_VALUES_STRAINS, mesh.triangle_count, overlay);
        if (kind == OVERLAY_PATCHES && is_cloth)
            fill_patches(live, i, mesh.triangle_count, overlay);
    }
    if (kind == OVERLAY_STRAIN && overlay->count == 0) /* cloth made of springs */
        overlay_put_flat_strains(overlay, document, frame->positions);
}

static void copy_positions(view_live *live, view_frame *frame) {
    const view_document *const document = live->options.document;
    const tulle_world *const world = live->built.world;
    for (size_t i = 0; i < document->object_count; i++) {
        const view_object *const object = &document->objects[i];
        size_t count = 0;
        const double *positions;
        if (i < document->cloth_count) {
            positions = tulle_cloth_get_positions(world, live->built.cloths[i], &count);
        } else {
            tulle_obstacle_id const id = live->built.obstacles[i - document->cloth_count];
            positions = tulle_obstacle_get_positions(world, id, &count);
            frame->is_absent[i] = live->is_started && !tulle_obstacle_is_present(world, id);
        }
        if (count != object->mesh.vertex_count) continue;
        float *const to = frame->positions + 3 * object->vertex_begin;
        for (size_t k = 0; k < 3 * count; k++) to[k] = (float)positions[k];
    }
}

void live_publish(view_live *live) {
    view_frame *const frame = &live->frames[live->back];
    if (!live->built.world) return;
    frame->step = tulle_world_get_step_count(live->built.world);
    frame->number = (uint32_t)frame->step;
    frame->time = tulle_world_get_time(live->built.world);
    copy_positions(live, frame);
    unsigned const overlays = atomic_load(&live->overlays) & ~OVERLAYS_LATE;
    for (int kind = 0; kind < OVERLAY_COUNT; kind++) {
        frame->overlays[kind].is_filled = false;
        if (overlays >> kind & 1u) fill_overlay(live, (view_overlay_kind)kind, frame);
    }
    pthread_mutex_lock(&live->lock);
    int const other = live->ready;
    live->ready = live->back;
    live->back = other;
    live->frame_version++;
    pthread_mutex_unlock(&live->lock);
    live_put_state(live); /* who knows of a step can have its frame */
    live->options.wake(live->options.context);
}

/* ---- the world ---- */

tulle_status live_build(view_live *live, tulle_error *error) {
    tulle_scene_destroy_world(&live->built);
    live_forget_saved(live);
    record_cut(&live->recording, 0);
    live->is_started = false;
    live->report = (tulle_step_report){0};
    tulle_record_writer const writer = record_get_writer(&live->recording);
    tulle_status status = scene_build_recorded_world(live->options.scene, live->options.threads,
                                                     &writer, &live->built, error);
    if (status != TULLE_OK) return status;
    live->held =
        (hold_scene){live->options.scene, &live->built, live->options.document, &live->hold};
    hold_begin(&live->held);
    tulle_world_set_stop_request(live->built.world, is_stopped, live);
    status = tulle_world_start(live->built.world, error);
    live->is_started = status == TULLE_OK;
    const char *const message = tulle_world_last_message(live->built.world);
    if (live->is_started && message[0]) live_say(live, "%s", message);
    return status;
}

/* An obstacle that finds no way on because cloth is in between stays where it is. */
static bool is_helped_by_stopping(view_live *live, tulle_status status) {
    bool const is_pinch = status == TULLE_ERROR_PINCHED || status == TULLE_ERROR_STEP_FAILED;
    return is_pinch && hold_stop_obstacles(&live->held);
}

static void make_step(view_live *live) {
    double const time_step = tulle_scene_get_time_step(live->options.scene);
    tulle_error error = {0};
    tulle_step_report report = {0};
    hold_apply(&live->held, time_step);
    tulle_status const status = tulle_world_step(live->built.world, time_step, &report, &error);
    if (status == TULLE_OK) {
        hold_accept(&live->held, time_step);
        live->report = report;
        live->rate_steps++;
        live_put_row(live, &report);
        const char *const message = tulle_world_last_message(live->built.world);
        if (message[0]) live_say(live, "%s", message);
        live_save_if_due(live);
    } else if (is_helped_by_stopping(live, status)) {
        live_say(live, "the moved object is stopped: there is no room between it and the cloth");
    } else if (status != TULLE_ERROR_INTERRUPTED) {
        live->has_failed = true;
        live->is_running = false;
        live->steps_left = 0;
        live->replayed = NULL;
        live_say(live, "the step could not be made: %s", error.message);
    }
}

/* ---- the loop ---- */

static bool wants_step(const view_live *live) {
    return live->is_started && !live->has_failed &&
           (live->is_running || live->steps_left > 0 || live->replayed);
}

static void wait_until(view_live *live, double clock) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    double const rest = fmin(fmax(clock - timer_now(), 0.0), 1.0);
    until.tv_nsec += (long)(rest * 1e9);
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_cond_timedwait(&live->has_news, &live->lock, &until);
}

/* Takes the commands that wait; waits for some where there is nothing else to do. */
static size_t take_commands(view_live *live, live_command *commands, bool *must_publish) {
    pthread_mutex_lock(&live->lock);
    bool const is_paced = live->is_running && !live->replayed && live->speed > 0.0;
    while (!atomic_load(&live->is_quitting) && live->queue_count == 0 && !live->must_publish) {
        if (!wants_step(live))
            pthread_cond_wait(&live->has_news, &live->lock);
        else if (is_paced && timer_now() < live->next_step)
            wait_until(live, live->next_step);
        else
            break;
    }
    size_t const count = live->queue_count;
    memcpy(commands, live->queue, count * sizeof *commands);
    live->queue_count = 0;
    *must_publish = live->must_publish;
    live->must_publish = false;
    pthread_mutex_unlock(&live->lock);
    return count;
}

static void pace(view_live *live) {
    double const now = timer_now(), length = tulle_scene_get_time_step(live->options.scene);
    live->next_step = fmax(live->next_step, now - LATE_MOST);
    if (live->speed > 0.0) live->next_step += length / live->speed;
}

static void start(view_live *live) {
    tulle_error error = {0};
    live->rate_begin = timer_now();
    tulle_status const status = live_build(live, &error);
    live->has_failed = status != TULLE_OK;
    if (status != TULLE_OK) {
        live->replayed = NULL;
        live_say(live, "the scene cannot start: %s", error.message);
    } else {
        live_save_if_due(live);
    }
    live_publish(live);
    live_put_state(live);
    live->options.wake(live->options.context);
}

void *live_run(void *context) {
    view_live *const live = context;
    live_command *const commands = memory_allocate(&live->heap, sizeof live->queue);
    start(live);
    while (commands && !atomic_load(&live->is_quitting)) {
        bool must_publish = false;
        size_t const count = take_commands(live, commands, &must_publish);
        for (size_t i = 0; i < count; i++) live_execute(live, &commands[i]);
        bool const was_replaying = live->replayed != NULL;
        live_go_on_with_script(live);
        bool const has_ended = was_replaying && !live->replayed;
        bool const is_due =
            wants_step(live) && (!live->is_running || live->replayed || live->speed == 0.0 ||
                                 timer_now() >= live->next_step);
        if (is_due) {
            pace(live);
            make_step(live);
            if (live->steps_left > 0) live->steps_left--;
        }
        if (count > 0 || is_due || has_ended || must_publish) live_publish(live);
    }
    memory_release(&live->heap, commands, sizeof live->queue);
    live_forget_saved(live);
    tulle_scene_destroy_world(&live->built);
    return NULL;
}
