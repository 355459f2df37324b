/* app/view/server.h - serves a page and its WebSocket until someone asks to stop. */
#ifndef TULLE_APP_VIEW_SERVER_H
#define TULLE_APP_VIEW_SERVER_H

#include "app/view/session.h"

/* The exit code. Messages are printed. */
int server_run(const view_options *options);

/* ---- its parts, for tests ---- */

typedef struct view_server view_server;

/* Null after a message, with the exit code. There is one server at a time. */
view_server *server_open(const view_options *options, int *code);
/* Ends its threads; the exit code. */
int server_close(view_server *server);
const char *server_get_token(const view_server *server);
/* Takes a connected socket as one that it accepted, and owns it. */
bool server_adopt(view_server *server, int socket);
/* Does what there is to be done now, and does not wait. */
void server_come_round(view_server *server);

#endif
