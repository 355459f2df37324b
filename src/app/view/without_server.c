/* app/view/without_server.c - what `tulle view` says in a program that was built without it. */
#include "app/commands.h"
#include "app/view/server.h"

int server_run(const view_options *options) {
    (void)options;
    app_print_message("view",
                      "this program was built without the viewer; it needs libwebsockets and npm "
                      "(Debian: libwebsockets-dev, nodejs, npm). `make view` installs them and "
                      "builds it");
    return APP_EXIT_BAD_INPUT;
}

view_server *server_open(const view_options *options, int *code) {
    *code = server_run(options);
    return NULL;
}

int server_close(view_server *server) {
    (void)server;
    return APP_EXIT_FINE;
}

const char *server_get_token(const view_server *server) {
    (void)server;
    return "";
}

bool server_adopt(view_server *server, int socket) {
    (void)server;
    (void)socket;
    return false;
}

void server_come_round(view_server *server) { (void)server; }
