/* app/view/client.h - one page that is connected: what is to be sent to it, how far it has come,
 * and how much it may ask. A client that does not read costs a bounded queue and nothing else. */
#ifndef TULLE_APP_VIEW_CLIENT_H
#define TULLE_APP_VIEW_CLIENT_H

#include "app/view/frame.h"
#include "app/view/message.h"

enum {
    CLIENT_QUEUE_MAX = 256, /* messages that wait */
    CLIENT_QUEUE_FULL = 8,  /* from here on nothing more is read from the client */
    CLIENT_MESSAGES_A_SECOND = 200,
    CLIENT_RUN_UNDER_WAY = 4, /* frames of a run that are not acknowledged */
    CLIENT_LIVE_UNDER_WAY = 2 /* the same of a live scene */
};

typedef struct client_message {
    view_buffer buffer;
    bool is_binary;
} client_message;

/* Frames of a run that were asked for and are not sent yet. */
typedef struct client_stream {
    uint32_t next, remaining, stride;
    bool is_exact;
} client_stream;

typedef struct view_client {
    struct lws *wsi;
    uint32_t number; /* unique as long as the program runs */
    view_buffer incoming;
    client_message queue[CLIENT_QUEUE_MAX];
    size_t queue_begin, queue_count;
    bool is_paused;  /* nothing is read from it */
    double credit;   /* [s] of the network's thread that its requests may take; negative: a debt */
    double credited; /* [s] of the clock: when the credit was last counted */
    bool is_overrun; /* a message found no room: the connection ends */
    bool needs_document, needs_state;
    size_t next_mesh; /* to be sent; from object_count on: all are */
    bool needs_first; /* the first frame */
    client_stream stream;
    frame_coder coder;
    uint32_t sent, got; /* sequence numbers of frames */
    double rate;        /* [1/s] most frames of a live scene */
    double last_frame;  /* [s] of the clock */
    bool wants_exact;
    uint64_t live_version; /* of the newest live frame that it got */
    unsigned overlays;
    unsigned late;       /* overlays that are made for it beside the network */
    unsigned missed;     /* of these: a later frame was sent meanwhile, which has none */
    uint32_t last_sent;  /* number of the frame that was sent last */
    double window_begin; /* [s] of the clock: second in which messages are counted */
    int window_count;
    uint64_t text_hash;     /* of the scene's file as it was given to it or saved by it; 0: never */
    const char *end_reason; /* not null: the connection ends with 1008 and this */
    char reason[124];
} view_client;

view_client *client_create(struct lws *wsi, uint32_t number);
void client_destroy(view_client *client);
/* Counts the credit of a client among `client_count`; whether it may ask now: it has credit, and
 * reads its answers. */
bool client_may_ask(view_client *client, size_t client_count, double now);
/* Begins a document anew: its message, its meshes, its first frame. False without memory. */
bool client_begin_document(view_client *client, const view_document *document);

/* Takes over the bytes. */
void client_push(view_client *client, view_buffer *buffer, bool is_binary);
/* Answers {type: "error"}. */
void client_push_error(view_client *client, const view_request *request, const char *message);
/* Begins an answer: {"type":"...","id":...; the caller closes the brace. */
void client_begin_answer(const view_request *request, const char *type, view_buffer *buffer);
/* The oldest message, or null. */
client_message *client_get_first(view_client *client);
void client_drop_first(view_client *client);
/* Whether it may be sent another frame. */
bool client_has_room(const view_client *client, uint32_t limit);
/* Counts a message that came; false: too many in this second. */
bool client_count_message(view_client *client, double now);

#endif
