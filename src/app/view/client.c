/* app/view/client.c - see client.h. */
#include "app/view/client.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

static const double RATE_DEFAULT = 60.0; /* [1/s] */
/* Of the network's thread requests of all clients together get this share. */
static const double REQUEST_SHARE = 0.25;
static const double CREDIT_MAX = 0.01; /* [s] saved up by a client that asks seldom */

view_client *client_create(struct lws *wsi, uint32_t number) {
    memory heap = memory_default();
    view_client *const client = memory_allocate_zeroed(&heap, 1, sizeof *client);
    if (!client) return NULL;
    client->wsi = wsi;
    client->number = number;
    client->rate = RATE_DEFAULT;
    client->credit = CREDIT_MAX;
    return client;
}

void client_destroy(view_client *client) {
    if (!client) return;
    memory heap = memory_default();
    while (client_get_first(client)) client_drop_first(client);
    buffer_release(&client->incoming);
    frame_coder_release(&client->coder);
    memory_release(&heap, client, sizeof *client);
}

bool client_may_ask(view_client *client, size_t client_count, double now) {
    double const share = REQUEST_SHARE / (double)(client_count > 0 ? client_count : 1);
    client->credit = fmin(CREDIT_MAX, client->credit + (now - client->credited) * share);
    client->credited = now;
    return client->credit > 0.0 && client->queue_count < CLIENT_QUEUE_FULL;
}

bool client_begin_document(view_client *client, const view_document *document) {
    if (client->coder.grids) frame_coder_release(&client->coder);
    client->needs_document = client->needs_state = client->needs_first = true;
    client->next_mesh = 0;
    client->stream.remaining = 0;
    client->overlays = client->late = 0;
    client->live_version = 0;
    return frame_coder_prepare(&client->coder, document);
}

void client_push(view_client *client, view_buffer *buffer, bool is_binary) {
    if (client->queue_count == CLIENT_QUEUE_MAX || buffer->is_failed) {
        client->is_overrun = true;
        buffer_release(buffer);
        return;
    }
    size_t const place = (client->queue_begin + client->queue_count++) % CLIENT_QUEUE_MAX;
    client->queue[place] = (client_message){*buffer, is_binary};
    *buffer = (view_buffer){0};
}

void client_begin_answer(const view_request *request, const char *type, view_buffer *buffer) {
    buffer_print(buffer, "{\"type\":\"%s\"", type);
    if (request->has_id) buffer_json_whole(buffer, "id", request->id);
}

void client_push_error(view_client *client, const view_request *request, const char *message) {
    view_buffer buffer = {0};
    client_begin_answer(request, "error", &buffer);
    buffer_json_text(&buffer, "message", message);
    buffer_print(&buffer, "}");
    client_push(client, &buffer, false);
}

client_message *client_get_first(view_client *client) {
    return client->queue_count > 0 ? &client->queue[client->queue_begin] : NULL;
}

void client_drop_first(view_client *client) {
    buffer_release(&client->queue[client->queue_begin].buffer);
    client->queue_begin = (client->queue_begin + 1) % CLIENT_QUEUE_MAX;
    client->queue_count--;
}

bool client_has_room(const view_client *client, uint32_t limit) {
    return client->sent - client->got < limit;
}

bool client_count_message(view_client *client, double now) {
    if (now - client->window_begin >= 1.0) {
        client->window_begin = now;
        client->window_count = 0;
    }
    return ++client->window_count <= CLIENT_MESSAGES_A_SECOND;
}
