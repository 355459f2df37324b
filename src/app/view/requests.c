/* app/view/requests.c - what a page asks, given to whom it concerns. */
#include "app/view/pick.h"
#include "app/view/session.h"
#include "base/error.h"

#include <string.h>

static void answer(view_client *client, const view_request *request, const char *type) {
    view_buffer buffer = {0};
    if (!request->has_id) return;
    client_begin_answer(request, type, &buffer);
    buffer_print(&buffer, "}");
    client_push(client, &buffer, false);
}

static void take_frames(view_session *session, view_client *client, const view_request *request) {
    uint32_t const count =
        session->document.kind == KIND_RUN ? view_run_get_progress(&session->run).frame_count : 1;
    if (session->document.is_live) {
        client_push_error(client, request, "a live scene has no frames to ask for");
        return;
    }
    if (request->from >= count) {
        client_push_error(client, request, "there is no such frame");
        return;
    }
    client->needs_first = false;
    client->stream =
        (client_stream){request->from, request->count, request->stride, request->is_exact};
    answer(client, request, "done");
}

/* Only what was sent can have been taken; a client that claims more is as one that took all. */
static void take_got(view_client *client, const view_request *request) {
    uint32_t const under_way = client->sent - client->got;
    if (client->sent - request->sequence > under_way) return;
    /* One a frame at most does not count: a run comes faster than the limit of messages. */
    if (request->sequence != client->got && client->window_count > 0) client->window_count--;
    client->got = request->sequence;
}

static void take_series(view_session *session, view_client *client, const view_request *request) {
    const series_table *table = &session->live_rows;
    if (session->document.kind == KIND_RUN) {
        tulle_error error = {0};
        if (view_run_read_series(&session->run, &error) != TULLE_OK) {
            client_push_error(client, request, error.message);
            return;
        }
        table = &session->run.series;
    }
    view_buffer buffer = {0};
    client_begin_answer(request, "series", &buffer);
    series_write(
        table,
        (series_request){request->columns, request->from_step, request->to_step, request->buckets},
        &buffer);
    buffer_print(&buffer, "}");
    client_push(client, &buffer, false);
}

/* The frame of a run as doubles, with what is recorded of it. */
static tulle_status pick_in_run(view_session *session, const view_request *request,
                                view_buffer *buffer, tulle_error *error) {
    const view_document *const document = &session->document;
    view_run *const run = &session->run;
    uint32_t const last = run->info->frame_count - 1, index = request->object;
    uint32_t const number = request->frame < last ? request->frame : last;
    if (index >= document->object_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no object %u", index);
    unsigned const wanted = 1u << OVERLAY_CONTACTS | 1u << OVERLAY_VELOCITIES;
    tulle_status status = view_run_read(run, document, number, wanted, &session->frame, error);
    if (status == TULLE_OK)
        status = tulle_run_reader_read_positions(run->reader, number, index, run->scratch, error);
    if (status != TULLE_OK) return status;
    pick_facts facts = {.document = document,
                        .frame = number,
                        .positions = run->scratch,
                        .places =
                            session->frame.positions + 3 * document->objects[index].vertex_begin};
    if (run->has_read_debug) {
        facts.velocities = run->debug.velocities[index];
        facts.patches = run->debug.patch_labels[index];
        facts.contacts = run->debug.contacts;
        facts.contact_count = run->debug.contact_count;
    }
    return pick_write(&facts, request, buffer, error);
}

static void take_pick(view_session *session, view_client *client, const view_request *request) {
    tulle_error error = {0};
    view_buffer buffer = {0};
    client_begin_answer(request, "picked", &buffer);
    tulle_status status;
    if (session->document.kind == KIND_RUN) {
        status = pick_in_run(session, request, &buffer, &error);
    } else {
        pick_facts facts = {.document = &session->document};
        if (request->object < session->document.object_count)
            facts.positions = session->document.objects[request->object].mesh.positions;
        status = pick_write(&facts, request, &buffer, &error);
    }
    buffer_print(&buffer, "}");
    if (status == TULLE_OK) {
        client_push(client, &buffer, false);
        return;
    }
    buffer_release(&buffer);
    client_push_error(client, request, error.message);
}

static void take_live(view_session *session, view_client *client, const view_request *request) {
    if (!session->live)
        client_push_error(client, request, "no scene is simulated here");
    else if (!live_post(session->live, request, client->number))
        client_push_error(client, request, "too many commands wait for the simulation");
}

void session_take_request(view_session *session, view_client *client, view_request *request) {
    unsigned const possible = overlays_get_possible(&session->document);
    switch (request->type) {
    case REQUEST_FRAMES: take_frames(session, client, request); break;
    case REQUEST_GOT: take_got(client, request); break;
    case REQUEST_FOLLOW:
        client->rate = request->rate;
        answer(client, request, "done");
        break;
    case REQUEST_EXACT:
        if (session->document.is_live) client->wants_exact = true;
        answer(client, request, "done");
        break;
    case REQUEST_OVERLAYS:
        client->overlays = request->overlays & possible;
        client->late = 0;
        client->live_version = 0; /* the frame that it has comes again, with its overlays */
        answer(client, request, "done");
        break;
    case REQUEST_SERIES: take_series(session, client, request); break;
    case REQUEST_PICK:
        if (session->live)
            take_live(session, client, request);
        else
            take_pick(session, client, request);
        break;
    case REQUEST_TEXT:
    case REQUEST_CHECK:
    case REQUEST_SAVE:
    case REQUEST_SCHEMA:
    case REQUEST_EXAMPLES:
    case REQUEST_EXAMPLE: editing_take_request(session, client, request); break;
    default: take_live(session, client, request); break;
    }
}
