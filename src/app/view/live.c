/* app/view/live.c - see live.h: what both threads touch. */
#include "app/view/live_thread.h"

#include "base/timer.h"

#include <stdio.h>
#include <string.h>

static void release(view_live *live) {
    memory heap = memory_default();
    for (size_t i = 0; i < live->answer_count; i++)
        buffer_release(&live->answers[(live->answer_begin + i) % LIVE_ANSWER_MAX].buffer);
    for (int i = 0; i < 3; i++)
        if (live->frames[i].object_count > 0 || live->frames[i].positions)
            frame_release(&live->frames[i]);
    record_close(&live->recording);
    record_close(&live->script);
    memory_release(&heap, live->rows, LIVE_ROWS_MAX * sizeof *live->rows);
    tulle_scene_destroy(live->options.scene);
    pthread_mutex_destroy(&live->lock);
    pthread_cond_destroy(&live->has_news);
    memory_release(&heap, live, sizeof *live);
}

static bool prepare(view_live *live) {
    memory heap = memory_default();
    live->rows = memory_allocate(&heap, LIVE_ROWS_MAX * sizeof *live->rows);
    bool is_good = live->rows != NULL;
    for (int i = 0; i < 3 && is_good; i++)
        is_good = frame_prepare(&live->frames[i], live->options.document);
    return is_good && record_open(&live->recording) && record_open(&live->script);
}

view_live *live_start(const live_options *options) {
    memory heap = memory_default();
    view_live *const live = memory_allocate_zeroed(&heap, 1, sizeof *live);
    if (!live) {
        tulle_scene_destroy(options->scene);
        return NULL;
    }
    live->options = *options;
    live->recording.file = live->script.file = -1;
    live->heap = memory_default();
    live->ready = 1;
    live->back = 2;
    live->speed = 1.0;
    live->replayed = options->script;
    live->state.is_starting = true;
    live->state.is_replaying = options->script != NULL;
    pthread_mutex_init(&live->lock, NULL);
    pthread_cond_init(&live->has_news, NULL);
    if (!prepare(live) || pthread_create(&live->thread, NULL, live_run, live) != 0) {
        release(live);
        return NULL;
    }
    return live;
}

void live_stop(view_live *live) {
    if (!live) return;
    atomic_store(&live->is_quitting, true);
    pthread_mutex_lock(&live->lock);
    pthread_cond_signal(&live->has_news);
    pthread_mutex_unlock(&live->lock);
    pthread_join(live->thread, NULL);
    release(live);
}

/* ---- to the world ---- */

bool live_post(view_live *live, const view_request *request, uint32_t client) {
    bool is_taken = false;
    pthread_mutex_lock(&live->lock);
    for (size_t i = live->queue_count; i-- > 0 && request->type == REQUEST_DRAG;) {
        view_request *const other = &live->queue[i].request;
        if (other->type != REQUEST_DRAG) break; /* it came before something else */
        if (other->grab != request->grab || other->has_id) continue;
        *other = *request;
        live->queue[i].client = client;
        is_taken = true;
        break;
    }
    if (!is_taken && live->queue_count < LIVE_QUEUE_MAX) {
        live->queue[live->queue_count++] = (live_command){*request, client};
        is_taken = true;
    }
    pthread_cond_signal(&live->has_news);
    pthread_mutex_unlock(&live->lock);
    return is_taken;
}

void live_set_overlays(view_live *live, unsigned overlays) {
    if (atomic_exchange(&live->overlays, overlays) == overlays) return;
    pthread_mutex_lock(&live->lock);
    live->must_publish = true;
    pthread_cond_signal(&live->has_news);
    pthread_mutex_unlock(&live->lock);
}

/* ---- from the world ---- */

const view_frame *live_get_frame(view_live *live, uint64_t *version) {
    pthread_mutex_lock(&live->lock);
    if (live->front_version != live->frame_version) {
        int const newest = live->ready;
        live->ready = live->front;
        live->front = newest;
        live->front_version = live->frame_version;
    }
    pthread_mutex_unlock(&live->lock);
    *version = live->front_version;
    return live->front_version > 0 ? &live->frames[live->front] : NULL;
}

live_state live_get_state(view_live *live) {
    pthread_mutex_lock(&live->lock);
    live_state const state = live->state;
    pthread_mutex_unlock(&live->lock);
    return state;
}

bool live_take_answer(view_live *live, uint32_t *client, view_buffer *answer) {
    bool has_one = false;
    pthread_mutex_lock(&live->lock);
    if (live->answer_count > 0) {
        live_answer *const first = &live->answers[live->answer_begin];
        *client = first->client;
        *answer = first->buffer;
        live->answer_begin = (live->answer_begin + 1) % LIVE_ANSWER_MAX;
        live->answer_count--;
        has_one = true;
    }
    pthread_mutex_unlock(&live->lock);
    return has_one;
}

void live_answer_client(view_live *live, uint32_t client, view_buffer *buffer) {
    bool is_taken = false;
    pthread_mutex_lock(&live->lock);
    if (live->answer_count < LIVE_ANSWER_MAX && !buffer->is_failed) {
        size_t const place = (live->answer_begin + live->answer_count++) % LIVE_ANSWER_MAX;
        live->answers[place] = (live_answer){client, *buffer};
        is_taken = true;
    }
    pthread_mutex_unlock(&live->lock);
    if (!is_taken) buffer_release(buffer);
    *buffer = (view_buffer){0};
    live->options.wake(live->options.context);
}

void live_put_row(view_live *live, const tulle_step_report *report) {
    series_row const row = series_make_row(report);
    pthread_mutex_lock(&live->lock);
    if (live->row_count == LIVE_ROWS_MAX) { /* nobody fetches them: the older half goes */
        live->row_count = LIVE_ROWS_MAX / 2;
        memmove(live->rows, live->rows + LIVE_ROWS_MAX / 2, live->row_count * sizeof row);
    }
    live->rows[live->row_count++] = row;
    pthread_mutex_unlock(&live->lock);
}

void live_take_rows(view_live *live, series_table *table) {
    pthread_mutex_lock(&live->lock);
    for (size_t i = 0; i < live->row_count; i++) series_add(table, &live->rows[i], true);
    live->row_count = 0;
    pthread_mutex_unlock(&live->lock);
}

uint64_t live_get_recording_size(view_live *live) {
    return atomic_load(&live->recording.byte_count);
}

unsigned live_get_recording_generation(view_live *live) {
    return atomic_load(&live->recording.generation);
}

size_t live_read_recording(view_live *live, void *bytes, size_t byte_count, uint64_t offset) {
    return record_read(&live->recording, bytes, byte_count, offset);
}

void live_put_state(view_live *live) {
    const tulle_world *const world = live->built.world;
    live_state state = {.is_running = live->is_running,
                        .has_failed = live->has_failed,
                        .is_starting = !live->is_started && !live->has_failed,
                        .is_replaying = live->replayed != NULL,
                        .step = tulle_world_get_step_count(world),
                        .time = tulle_world_get_time(world),
                        .report = live->report,
                        .held_count = live->hold.grab_count,
                        .saved_count = live->saved_count,
                        .has_hash = live->is_started && !live->is_running && live->steps_left == 0};
    double const now = timer_now(), passed = now - live->rate_begin;
    for (size_t i = 0; i < state.held_count; i++) state.held[i] = live->hold.grabs[i].id;
    for (size_t i = 0; i < state.saved_count; i++) state.saved[i] = live->saved[i].step;
    if (state.has_hash) state.hash = tulle_world_get_state_hash(world);
    snprintf(state.message, sizeof state.message, "%s", live->message);
    pthread_mutex_lock(&live->lock);
    state.steps_per_second = live->state.steps_per_second;
    if (!state.is_running)
        state.steps_per_second = 0.0;
    else if (passed >= 0.5)
        state.steps_per_second = (double)live->rate_steps / passed;
    state.real_time_ratio = state.steps_per_second * tulle_scene_get_time_step(live->options.scene);
    state.version = live->state.version + 1;
    live->state = state;
    pthread_mutex_unlock(&live->lock);
    if (passed < 0.5) return;
    live->rate_begin = now;
    live->rate_steps = 0;
}
