/* app/view/session.h - what is looked at, who looks at it, and what they ask: the middle between
 * the network (server.c), the sources (a run, meshes, a live scene) and the worker. All of it
 * belongs to the network's thread. */
#ifndef TULLE_APP_VIEW_SESSION_H
#define TULLE_APP_VIEW_SESSION_H

#include "app/view/client.h"
#include "app/view/live.h"
#include "app/view/source_run.h"
#include "app/view/worker.h"

enum { VIEW_CLIENT_MAX = 32 };

typedef struct view_options {
    const char *const *paths; /* a scene, a run or meshes */
    size_t path_count;
    const char *listen; /* address */
    const char *const *host_names;
    size_t host_name_count;
    const char *replay; /* path of a session, or null */
    int port, threads;  /* port -1: it listens on none */
    bool opens_browser;
} view_options;

typedef struct view_session {
    const view_options *options;
    view_document document;
    view_run run;           /* of KIND_RUN */
    view_live *live;        /* of KIND_SCENE; null: the scene has errors */
    series_table live_rows; /* its steps */
    view_frame frame;       /* of runs and meshes: read last */
    char *replayed;         /* text of the session that is repeated first */
    size_t replayed_size;
    view_worker *worker;
    view_client *clients[VIEW_CLIENT_MAX];
    size_t client_count;
    uint32_t next_client;
    double followed;        /* [s] of the clock: last look at a run under way */
    double told_state;      /* [s] of the clock: last state message */
    uint64_t state_version; /* that was told */
    bool is_replay_told;
    int exit_code;
    unsigned scene_count;        /* scenes that were begun */
    void (*wake)(void *context); /* from any thread: the network's is to come round */
    void *wake_context;
} view_session;

/* Opens what the options name. session_close also after a failure. */
tulle_status session_open(view_session *session, const view_options *options,
                          void (*wake)(void *context), void *wake_context, tulle_error *error);
void session_close(view_session *session);

/* Null where there are too many. */
view_client *session_add_client(view_session *session, struct lws *wsi);
void session_remove_client(view_session *session, view_client *client);

/* A whole text message of a client. It may end the connection by client->end_reason. */
void session_take_message(view_session *session, view_client *client, const char *text,
                          size_t length);
/* Between events: fetches what other threads have, looks after runs under way. */
void session_come_round(view_session *session);
/* Puts the next message in the client's queue if there is one to be sent now. [s] until there may
 * be one; 0: there is one; INFINITY: when something happens. */
double session_supply(view_session *session, view_client *client);

/* ---- requests.c, editing.c, late_overlays.c ---- */

void session_take_request(view_session *session, view_client *client, view_request *request);
view_client *session_find_client(const view_session *session, uint32_t number);

/* Opens a scene, also one with errors. */
tulle_status editing_open(view_session *session, const char *path, tulle_error *error);
/* text, check, save, schema, examples, example. */
void editing_take_request(view_session *session, view_client *client, view_request *request);

/* Asks the worker for overlays that take long, of a frame that was sent to the client. */
void late_overlays_ask(view_session *session, view_client *client, const view_frame *frame,
                       unsigned overlays);

#endif
