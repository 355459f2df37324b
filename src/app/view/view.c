/* app/view/view.c - `tulle view`: looks at a run, at meshes or at a scene that is simulated
 * meanwhile, in a browser. docs/guide/view.md tells more. */
#include "app/cli/options.h"
#include "app/commands.h"
#include "app/view/server.h"

#include <arpa/inet.h>
#include <stdbool.h>
#include <string.h>

enum { PATHS_MAX = 64, PORT_MAX = 65535, THREADS_MAX = 256, HOST_NAMES_MAX = 16, HOST_SIZE = 254 };

static bool is_host_name(const char *name) {
    static const char marks[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-.";
    size_t const length = strlen(name);
    return length > 0 && length < HOST_SIZE && strspn(name, marks) == length;
}

/* Not the name of a network card: no browser could call it so. */
static bool is_address(const char *text) {
    unsigned char bytes[sizeof(struct in6_addr)];
    return inet_pton(AF_INET, text, bytes) == 1 || inet_pton(AF_INET6, text, bytes) == 1;
}

int app_view(int argc, char **argv) {
    long port = 0, threads = 0;
    int stays_closed = 0;
    view_options chosen = {.listen = "127.0.0.1"};
    option_list host_names = {.count = 0};
    const option_spec options[] = {
        INTEGER_OPTION("port", 'p', &port, "N", 0, PORT_MAX,
                       "port to listen on (default 0: any that is free)"),
        TEXT_OPTION("listen", 'l', &chosen.listen, "ADDRESS",
                    "address of this machine to listen on (default 127.0.0.1: this machine alone)"),
        LIST_OPTION("host-name", 0, &host_names, "NAME",
                    "with --listen: a name by which browsers may call this machine"),
        FLAG_OPTION("no-browser", 'n', &stays_closed, "print the address and open nothing"),
        TEXT_OPTION("replay", 'r', &chosen.replay, "FILE",
                    "repeat the actions in a scene, as saved to NAME.session"),
        INTEGER_OPTION("threads", 't', &threads, "N", 1, THREADS_MAX,
                       "threads of the simulation; the result does not depend on it (default: one "
                       "per processor)"),
    };
    const command_spec command = COMMAND(
        "view", "SCENE.yaml|RUN|MESH...", options, 1, PATHS_MAX,
        "Shows a run, meshes, or a scene while it is simulated, in a browser: orbit, play, pick,\n"
        "overlays and plots; a scene can be held, pulled and edited. Serves one page at an "
        "address\n"
        "with a token, to this machine alone. Ends with Ctrl-C.");
    size_t operand_count = 0;
    options_outcome const outcome = options_parse(&command, argc, argv, &operand_count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    if (strcmp(chosen.listen, "localhost") == 0) chosen.listen = "127.0.0.1";
    if (!is_address(chosen.listen)) {
        app_print_message("view",
                          "--listen: \"%s\" should be an address of this machine in numbers, as "
                          "192.168.1.5 or ::1; --host-name gives its names",
                          chosen.listen);
        return APP_EXIT_BAD_INPUT;
    }
    for (size_t i = 0; i < host_names.count; i++) {
        if (i < HOST_NAMES_MAX && is_host_name(host_names.items[i])) continue;
        app_print_message("view",
                          "--host-name: \"%s\" should be one of at most %d names of letters, "
                          "digits, '-' and '.'",
                          host_names.items[i], HOST_NAMES_MAX);
        return APP_EXIT_BAD_INPUT;
    }
    chosen.paths = (const char *const *)argv;
    chosen.path_count = operand_count;
    chosen.host_names = host_names.items;
    chosen.host_name_count = host_names.count;
    chosen.port = (int)port;
    chosen.threads = (int)threads;
    chosen.opens_browser = !stays_closed;
    return server_run(&chosen);
}
