/* app/view/server.h - serves a page and its WebSocket until someone asks to stop. */
#ifndef TULLE_APP_VIEW_SERVER_H
#define TULLE_APP_VIEW_SERVER_H

#include "app/view/session.h"

/* The exit code. Messages are printed. */
int server_run(const view_options *options);

#endif
