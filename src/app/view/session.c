/* app/view/session.c - see session.h: opening, clients, what is sent when. */
#include "app/view/session.h"

#include "app/cli/mesh_file.h"
#include "app/commands.h"
#include "base/error.h"
#include "base/timer.h"
#include "io/file_data.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double FOLLOW_SECONDS = 1.0; /* between two looks at a run under way */
static const double STATE_SECONDS = 0.1;  /* between two state messages */

/* ---- opening ---- */

static const char *get_name(const char *path) {
    const char *const slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

static tulle_status open_meshes(view_session *session, tulle_error *error) {
    const view_options *const options = session->options;
    view_document *const document = &session->document;
    mesh_file_notes notes = {.command = "view"};
    if (!document_begin(document, options->path_count))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    document->kind = KIND_MESH;
    document->title = document->name = get_name(options->paths[0]);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < options->path_count && status == TULLE_OK; i++) {
        tulle_mesh mesh = {0};
        status = mesh_file_read_noted(options->paths[i], &notes, &mesh, error);
        if (status == TULLE_OK)
            status = document_add(document, get_name(options->paths[i]), ROLE_CLOTH,
                                  tulle_mesh_get_view(&mesh), error);
        if (status == TULLE_OK) document->objects[i].is_static = true;
        tulle_mesh_destroy(&mesh);
    }
    mesh_file_finish_notes(&notes);
    document_finish(document, NULL);
    return status;
}

static bool has_ending(const char *path, const char *ending) {
    size_t const length = strlen(path), end = strlen(ending);
    return length > end && strcmp(path + length - end, ending) == 0;
}

static tulle_status read_replayed(view_session *session, tulle_error *error) {
    memory heap = memory_default();
    file_data file = {0};
    tulle_status const status =
        file_load(&heap, session->options->replay, (size_t)1 << 30, &file, error);
    if (status != TULLE_OK) return status;
    session->replayed = file.bytes;
    session->replayed_size = file.byte_count;
    return TULLE_OK;
}

static tulle_status open_source(view_session *session, tulle_error *error) {
    const view_options *const options = session->options;
    const char *const path = options->paths[0];
    bool const is_scene = has_ending(path, ".yaml") || has_ending(path, ".yml");
    if (options->replay && !is_scene)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--replay repeats actions in a scene; give a scene");
    if (options->replay) {
        tulle_status const status = read_replayed(session, error);
        if (status != TULLE_OK) return status;
    }
    if (options->path_count == 1 && is_scene) return editing_open(session, path, error);
    if (options->path_count == 1 && tulle_run_is_directory(path))
        return view_run_open(&session->run, path, &session->document, error);
    return open_meshes(session, error);
}

tulle_status session_open(view_session *session, const view_options *options,
                          void (*wake)(void *context), void *wake_context, tulle_error *error) {
    *session = (view_session){.options = options,
                              .wake = wake,
                              .wake_context = wake_context,
                              .next_client = 1,
                              .live_rows.heap = memory_default()};
    session->worker = worker_start(wake, wake_context);
    if (!session->worker)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "a thread could not be started");
    tulle_status const status = open_source(session, error);
    if (status != TULLE_OK) return status;
    return frame_prepare(&session->frame, &session->document)
               ? TULLE_OK
               : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
}

void session_close(view_session *session) {
    memory heap = memory_default();
    worker_stop(session->worker);
    live_stop(session->live);
    while (session->client_count > 0)
        session_remove_client(session, session->clients[session->client_count - 1]);
    if (session->run.path) view_run_close(&session->run);
    if (session->frame.positions) frame_release(&session->frame);
    series_clear(&session->live_rows);
    if (session->replayed) memory_release(&heap, session->replayed, session->replayed_size + 1);
    document_destroy(&session->document);
}

/* ---- clients ---- */

view_client *session_add_client(view_session *session, struct lws *wsi) {
    if (session->client_count == VIEW_CLIENT_MAX) return NULL;
    view_client *const client = client_create(wsi, session->next_client);
    if (!client) return NULL;
    if (!client_begin_document(client, &session->document)) {
        client_destroy(client);
        return NULL;
    }
    session->next_client++;
    session->clients[session->client_count++] = client;
    return client;
}

/* Overlays that any client wants of a live scene. */
static void update_overlays(view_session *session) {
    unsigned overlays = 0;
    for (size_t i = 0; i < session->client_count; i++) overlays |= session->clients[i]->overlays;
    if (session->live) live_set_overlays(session->live, overlays);
}

void session_remove_client(view_session *session, view_client *client) {
    for (size_t i = 0; i < session->client_count; i++)
        if (session->clients[i] == client) {
            session->clients[i] = session->clients[--session->client_count];
            break;
        }
    client_destroy(client);
    update_overlays(session);
}

view_client *session_find_client(const view_session *session, uint32_t number) {
    for (size_t i = 0; i < session->client_count; i++)
        if (session->clients[i]->number == number) return session->clients[i];
    return NULL;
}

void session_take_message(view_session *session, view_client *client, const char *text,
                          size_t length) {
    view_request request;
    char reason[REASON_SIZE];
    double const begin = timer_now();
    if (!client_count_message(client, begin)) {
        client->end_reason = "too many messages in a second";
        return;
    }
    switch (request_read(text, length, &request, reason)) {
    case REQUEST_READ:
        session_take_request(session, client, &request);
        request_release(&request);
        if (request.type == REQUEST_OVERLAYS) update_overlays(session);
        break;
    case REQUEST_REFUSED: client_push_error(client, &request, reason); break;
    case REQUEST_BAD:
        snprintf(client->reason, sizeof client->reason, "%.120s", reason);
        client->end_reason = client->reason;
        break;
    }
    client->credit -= timer_now() - begin;
}

/* ---- coming round ---- */

static void follow_run(view_session *session, double now) {
    if (session->document.kind != KIND_RUN || now - session->followed < FOLLOW_SECONDS) return;
    session->followed = now;
    if (!view_run_follow(&session->run)) return;
    view_progress const progress = view_run_get_progress(&session->run);
    for (size_t i = 0; i < session->client_count; i++) {
        view_buffer buffer = {0};
        buffer_print(&buffer, "{\"type\":\"changed\"");
        buffer_json_whole(&buffer, "frame_count", progress.frame_count);
        buffer_json_bool(&buffer, "is_under_way", progress.is_under_way);
        buffer_print(&buffer, "}");
        client_push(session->clients[i], &buffer, false);
    }
}

static void fetch_from_live(view_session *session) {
    uint32_t number = 0;
    view_buffer answer = {0};
    while (live_take_answer(session->live, &number, &answer)) {
        view_client *const client = session_find_client(session, number);
        if (client)
            client_push(client, &answer, false);
        else
            buffer_release(&answer);
    }
    live_take_rows(session->live, &session->live_rows);
}

/* What a repeated session came to is told where the program was started, too. */
static void tell_replay(view_session *session, const live_state *state) {
    if (!session->options->replay || session->is_replay_told || state->is_replaying ||
        state->is_starting)
        return;
    session->is_replay_told = true;
    app_print_names(stdout, "%s\n", state->message);
    fflush(stdout);
    if (state->has_failed) session->exit_code = APP_EXIT_FALSE;
}

static void note_state(view_session *session, double now) {
    live_state const state = live_get_state(session->live);
    tell_replay(session, &state);
    bool const is_due = now - session->told_state >= STATE_SECONDS;
    if (state.version == session->state_version || !is_due) return;
    session->state_version = state.version;
    session->told_state = now;
    for (size_t i = 0; i < session->client_count; i++) session->clients[i]->needs_state = true;
}

void session_come_round(view_session *session) {
    double const now = timer_now();
    follow_run(session, now);
    worker_finish_done(session->worker, session);
    if (!session->live) return;
    fetch_from_live(session);
    note_state(session, now);
}

/* ---- what is sent next ---- */

static view_progress get_progress(const view_session *session) {
    if (session->document.kind == KIND_RUN) return view_run_get_progress(&session->run);
    return (view_progress){session->document.kind == KIND_MESH ? 1 : 0, false};
}

static void write_state(const view_session *session, view_buffer *buffer) {
    live_state const state = live_get_state(session->live);
    const tulle_step_report *const report = &state.report;
    buffer_print(buffer, "{\"type\":\"state\"");
    buffer_json_bool(buffer, "is_running", state.is_running);
    buffer_json_bool(buffer, "is_starting", state.is_starting);
    buffer_json_bool(buffer, "is_replaying", state.is_replaying);
    buffer_json_bool(buffer, "has_failed", state.has_failed);
    buffer_json_whole(buffer, "step", state.step);
    buffer_json_double(buffer, "time", state.time);
    buffer_json_whole(buffer, "frame", state.step);
    buffer_json_double(buffer, "steps_per_second", state.steps_per_second);
    buffer_json_double(buffer, "real_time_ratio", state.real_time_ratio);
    buffer_json_whole(buffer, "contacts", report->contacts);
    buffer_print(buffer, ",\"energies\":{\"kinetic\":");
    buffer_json_double(buffer, NULL, report->kinetic_energy);
    buffer_json_double(buffer, "gravity", report->gravity_energy);
    buffer_json_double(buffer, "elastic", report->elastic_energy);
    buffer_print(buffer, "},\"held\":[");
    for (size_t i = 0; i < state.held_count; i++)
        buffer_print(buffer, i > 0 ? ",%u" : "%u", state.held[i]);
    buffer_print(buffer, "],\"saved\":[");
    for (size_t i = 0; i < state.saved_count; i++)
        buffer_print(buffer, i > 0 ? ",%llu" : "%llu", (unsigned long long)state.saved[i]);
    buffer_print(buffer, "]");
    buffer_json_text(buffer, "message", state.message);
    if (state.has_hash)
        buffer_print(buffer, ",\"hash\":\"%016llx\"", (unsigned long long)state.hash);
    buffer_print(buffer, "}");
}

/* A frame with those of its overlays that are there; others are asked for. */
static void send_frame(view_session *session, view_client *client, const view_frame *frame,
                       bool is_exact) {
    view_buffer buffer = {0};
    frame_encode(&client->coder, &session->document, frame, is_exact, ++client->sent, &buffer);
    client_push(client, &buffer, true);
    for (int kind = 0; kind < OVERLAY_COUNT; kind++) {
        if (!(client->overlays >> kind & 1u) || !frame->overlays[kind].is_filled) continue;
        overlay_write(&frame->overlays[kind], (view_overlay_kind)kind, frame->number, frame->time,
                      &buffer);
        client_push(client, &buffer, true);
    }
    late_overlays_ask(session, client, frame, client->overlays & OVERLAYS_LATE);
}

/* The next frame of a run, or the only one of meshes. */
static void supply_run_frame(view_session *session, view_client *client) {
    client_stream *const stream = &client->stream;
    view_frame *const frame = &session->frame;
    tulle_error error = {0};
    if (session->document.kind == KIND_RUN) {
        tulle_status const status = view_run_read(&session->run, &session->document, stream->next,
                                                  client->overlays, frame, &error);
        if (status != TULLE_OK) {
            view_request const none = {0};
            client_push_error(client, &none, error.message);
            stream->remaining = 0;
            return;
        }
    }
    send_frame(session, client, frame, stream->is_exact);
    stream->next += stream->stride;
    stream->remaining--;
    if (stream->next >= get_progress(session).frame_count) stream->remaining = 0;
}

static double supply_live_frame(view_session *session, view_client *client) {
    double const now = timer_now();
    double const due = client->last_frame + (client->rate > 0.0 ? 1.0 / client->rate : 1e9);
    if (!client_has_room(client, CLIENT_LIVE_UNDER_WAY)) return (double)INFINITY;
    if (!client->wants_exact && !client->needs_first && now < due) return due - now;
    uint64_t version = 0;
    const view_frame *const frame = live_get_frame(session->live, &version);
    if (!frame || (version == client->live_version && !client->wants_exact))
        return (double)INFINITY;
    /* A little late still counts as in time, so that the rate is held on average. */
    bool const is_in_time = now >= due && (now - due) * client->rate < 0.1;
    client->last_frame = is_in_time ? due : now;
    send_frame(session, client, frame, client->wants_exact);
    client->live_version = version;
    client->wants_exact = client->needs_first = false;
    return 0.0;
}

static bool supply_once(view_session *session, view_client *client, view_buffer *buffer,
                        bool *is_binary) {
    *is_binary = false;
    if (client->needs_document) {
        client->needs_document = false;
        document_write(&session->document, get_progress(session), buffer);
    } else if (client->next_mesh < session->document.object_count) {
        *is_binary = true;
        document_write_mesh(&session->document, client->next_mesh++, buffer);
    } else if (client->needs_state && session->live) {
        client->needs_state = false;
        write_state(session, buffer);
    } else {
        return false;
    }
    return true;
}

double session_supply(view_session *session, view_client *client) {
    view_buffer buffer = {0};
    bool is_binary = false;
    if (client_get_first(client)) return 0.0;
    if (supply_once(session, client, &buffer, &is_binary)) {
        client_push(client, &buffer, is_binary);
        return 0.0;
    }
    if (session->document.is_live)
        return session->live ? supply_live_frame(session, client) : (double)INFINITY;
    if (client->needs_first) {
        client->needs_first = false;
        if (client->stream.remaining == 0) client->stream = (client_stream){0, 1, 1, false};
    }
    if (client->stream.remaining == 0 || !client_has_room(client, CLIENT_RUN_UNDER_WAY))
        return (double)INFINITY;
    supply_run_frame(session, client);
    return client_get_first(client) ? 0.0 : (double)INFINITY;
}
