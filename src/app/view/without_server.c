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
