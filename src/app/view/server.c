/* app/view/server.c - HTTP and WebSocket by libwebsockets, in one thread.
 *
 * What comes in is checked here before anyone else sees it: the token in the path, the Host, the
 * Origin, the method, the size of a message. Everything that is answered to HTTP is part of the
 * program, but for the recording of a live scene. */
#define _DEFAULT_SOURCE
#include "app/view/server.h"

#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "app/view/assets.h"
#include "app/view/guard.h"
#include "base/error.h"
#include "base/timer.h"

#include <libwebsockets.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

extern char **environ;

enum {
    CONNECTIONS_MAX = 192,    /* of all kinds, before they are known to be clients */
    HALF_OPEN_MAX = 64,       /* of these without a whole request; the oldest makes room */
    UNREAD_BYTES = 1 << 18,   /* that the system keeps for a connection that does not read them */
    HEADER_BYTES_MAX = 4096,  /* of a request */
    HEADER_SECONDS_MAX = 10,  /* in which a request must be whole */
    PIECE_BYTES = 1 << 14,    /* of a download, of a message that comes in */
    TICK_MICROSECONDS = 50000 /* between two looks at what time alone changes */
};

static const char protocol_name[] = "tulle-1";
static const char command_name[] = "view";

struct view_server {
    struct lws_context *context;
    struct lws_vhost *vhost;
    view_session session;
    view_guard guard;
    const view_options *options;
    lws_sorted_usec_list_t tick;
    struct lws
        *half_open[HALF_OPEN_MAX]; /* connections without a whole request, the oldest first */
    size_t half_open_count;
};

/* Of an HTTP connection: what is being sent. Of a WebSocket: the client. */
typedef struct connection {
    view_client *client;
    const unsigned char *bytes; /* of an asset */
    bool is_recording;
    unsigned scene_count, generation; /* of the recording */
    uint64_t sent, size;
} connection;

static view_server *get_server(struct lws *wsi) { return lws_context_user(lws_get_context(wsi)); }

/* From any thread. */
static void wake(void *context) {
    view_server *const server = context;
    if (server->context) lws_cancel_service(server->context);
}

/* ---- HTTP ---- */

static const char *get_type(const char *name) {
    static const char *const types[][2] = {{".html", "text/html; charset=utf-8"},
                                           {".js", "text/javascript; charset=utf-8"},
                                           {".css", "text/css; charset=utf-8"},
                                           {".svg", "image/svg+xml"}};
    size_t const length = strlen(name);
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        size_t const end = strlen(types[i][0]);
        if (length > end && strcmp(name + length - end, types[i][0]) == 0) return types[i][1];
    }
    return "application/octet-stream";
}

/* Writes the head of an answer; what every answer has beside it is in `headers` below. */
static bool write_head(struct lws *wsi, unsigned code, const char *type, uint64_t size,
                       const char *extra) {
    unsigned char room[LWS_PRE + 2048], *const start = room + LWS_PRE, *at = start;
    unsigned char *const end = room + sizeof room - 1;
    static const char disposition[] = "attachment; filename=\"recording.tullerec\"";
    if (lws_add_http_common_headers(wsi, code, type, size, &at, end)) return false;
    if (extra && lws_add_http_header_by_name(
                     wsi, (const unsigned char *)"allow:", (const unsigned char *)extra,
                     (int)strlen(extra), &at, end))
        return false;
    if (code == 200 && strcmp(type, "application/octet-stream") == 0 &&
        lws_add_http_header_by_name(
            wsi, (const unsigned char *)"content-disposition:", (const unsigned char *)disposition,
            sizeof disposition - 1, &at, end))
        return false;
    return lws_finalize_write_http_header(wsi, start, &at, end) == 0;
}

/* A refusal; its few words are the same for all, and nothing of the request is in them. */
static int refuse(struct lws *wsi, unsigned code) {
    static const char words[] = "tulle view: no\n";
    unsigned char room[LWS_PRE + sizeof words];
    memcpy(room + LWS_PRE, words, sizeof words - 1);
    if (!write_head(wsi, code, "text/plain; charset=utf-8", sizeof words - 1,
                    code == 405 ? "GET" : NULL))
        return -1;
    (void)lws_write(wsi, room + LWS_PRE, sizeof words - 1, LWS_WRITE_HTTP_FINAL);
    return -1;
}

/* 0, or the code of a refusal. */
static unsigned check_host(struct lws *wsi) {
    char host[300];
    int const length = lws_hdr_copy(wsi, host, sizeof host, WSI_TOKEN_HOST);
    return length > 0 && guard_allows_host(&get_server(wsi)->guard, host) ? 0 : 403;
}

static unsigned check_origin(struct lws *wsi) {
    char origin[300];
    int const length = lws_hdr_copy(wsi, origin, sizeof origin, WSI_TOKEN_ORIGIN);
    return length > 0 && guard_allows_origin(&get_server(wsi)->guard, origin) ? 0 : 403;
}

static bool is_get(struct lws *wsi) { return lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) > 0; }

static int begin_recording(struct lws *wsi, connection *answer) {
    view_server *const server = get_server(wsi);
    if (!server->session.live) return refuse(wsi, 404);
    answer->is_recording = true;
    answer->scene_count = server->session.scene_count;
    answer->generation = live_get_recording_generation(server->session.live);
    answer->size = live_get_recording_size(server->session.live);
    if (!write_head(wsi, 200, "application/octet-stream", answer->size, NULL)) return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int begin_answer(struct lws *wsi, connection *answer, const char *path) {
    view_server *const server = get_server(wsi);
    unsigned const code = check_host(wsi);
    if (code != 0) return refuse(wsi, code);
    const char *const name = guard_match_path(&server->guard, path);
    if (!name) return refuse(wsi, 404);
    if (!is_get(wsi)) return refuse(wsi, 405);
    if (strcmp(name, "recording") == 0) return begin_recording(wsi, answer);
    const char *const file = name[0] ? name : "index.html";
    const view_asset *asset;
    for (size_t i = 0; (asset = assets_get(i)); i++) {
        if (strchr(asset->name, '/') || strcmp(asset->name, file) != 0) continue;
        answer->bytes = asset->bytes;
        answer->size = (uint64_t)(asset->end - asset->bytes);
        if (!write_head(wsi, 200, get_type(file), answer->size, NULL)) return -1;
        lws_callback_on_writable(wsi);
        return 0;
    }
    return refuse(wsi, 404);
}

static int go_on_with_answer(struct lws *wsi, connection *answer) {
    unsigned char room[LWS_PRE + PIECE_BYTES];
    uint64_t const rest = answer->size - answer->sent;
    size_t count = rest < PIECE_BYTES ? (size_t)rest : PIECE_BYTES;
    const view_session *const session = &get_server(wsi)->session;
    view_live *const live = session->live;
    bool const is_same = live && answer->scene_count == session->scene_count &&
                         answer->generation == live_get_recording_generation(live);
    if (answer->bytes)
        memcpy(room + LWS_PRE, answer->bytes + answer->sent, count);
    else if (answer->is_recording && is_same)
        count = live_read_recording(live, room + LWS_PRE, count, answer->sent);
    else
        return -1;
    if (count == 0 && rest > 0) return -1; /* the scene began anew meanwhile */
    answer->sent += count;
    bool const is_last = answer->sent == answer->size;
    if (lws_write(wsi, room + LWS_PRE, count, is_last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0)
        return -1;
    if (!is_last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

/* Forgets a connection whose request is whole, or that is gone. */
static void settle(struct lws *wsi) {
    view_server *const server = get_server(wsi);
    size_t at = 0;
    while (at < server->half_open_count && server->half_open[at] != wsi) at++;
    if (at == server->half_open_count) return;
    server->half_open_count--;
    memmove(server->half_open + at, server->half_open + at + 1,
            (server->half_open_count - at) * sizeof *server->half_open);
}

/* Those who never finish a request keep nobody out: a page asks at once, and the oldest goes. */
static void await_request(struct lws *wsi) {
    view_server *const server = get_server(wsi);
    int const unread = UNREAD_BYTES;
    (void)setsockopt(lws_get_socket_fd(wsi), SOL_SOCKET, SO_SNDBUF, &unread, sizeof unread);
    if (server->half_open_count == HALF_OPEN_MAX) {
        /* what it has sent already may set its timeout anew, but nothing undoes the end */
        (void)shutdown(lws_get_socket_fd(server->half_open[0]), SHUT_RDWR);
        lws_set_timeout(server->half_open[0], PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
        settle(server->half_open[0]);
    }
    server->half_open[server->half_open_count++] = wsi;
}

/* 0: the WebSocket may begin. */
static int check_upgrade(struct lws *wsi) {
    char path[256], protocol[64];
    view_server *const server = get_server(wsi);
    int const length = lws_hdr_copy(wsi, path, sizeof path, WSI_TOKEN_GET_URI);
    unsigned code = check_host(wsi);
    if (code == 0) code = check_origin(wsi);
    const char *const name = length > 0 ? guard_match_path(&server->guard, path) : NULL;
    if (code == 0 && (!name || strcmp(name, "session") != 0)) code = 404;
    bool const has_protocol =
        lws_hdr_copy(wsi, protocol, sizeof protocol, WSI_TOKEN_PROTOCOL) > 0 &&
        strcmp(protocol, protocol_name) == 0;
    if (code == 0 && !has_protocol) code = 400;
    if (code == 0 && server->session.client_count >= VIEW_CLIENT_MAX) code = 503;
    if (code == 0) return 0;
    (void)refuse(wsi, code);
    return 1;
}

static int handle_http(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                       size_t length) {
    connection *const answer = user;
    switch (reason) {
    case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED: await_request(wsi); break;
    case LWS_CALLBACK_CLOSED_HTTP:
    case LWS_CALLBACK_WSI_DESTROY: settle(wsi); break;
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
        settle(wsi);
        /* Nothing but the WebSocket is upgraded to. */
        return in && strcmp(in, "websocket") == 0 ? check_upgrade(wsi) : -1;
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return -1; /* without the protocol */
    case LWS_CALLBACK_HTTP: settle(wsi); return begin_answer(wsi, answer, in);
    case LWS_CALLBACK_RAW_ADOPT: /* what is no HTTP, as CONNECT */
    case LWS_CALLBACK_RAW_RX: return -1;
    case LWS_CALLBACK_HTTP_WRITEABLE: return answer ? go_on_with_answer(wsi, answer) : -1;
    case LWS_CALLBACK_HTTP_BODY:
    case LWS_CALLBACK_HTTP_BODY_COMPLETION: return -1;

    default: break;
    }
    (void)length;
    return 0;
}

/* ---- WebSocket ---- */

static int close_with(struct lws *wsi, enum lws_close_status status, const char *reason) {
    char text[124];
    snprintf(text, sizeof text, "%s", reason);
    lws_close_reason(wsi, status, (unsigned char *)text, strlen(text));
    return -1;
}

/* Asks for the client's turn where there is something for it. A client that does not read its
 * answers, or asks for more than its share, is not listened to. */
static void look_after(view_server *server, view_client *client) {
    bool const is_paused = !client_may_ask(client, server->session.client_count, timer_now());
    if (is_paused != client->is_paused) {
        client->is_paused = is_paused;
        lws_rx_flow_control(client->wsi, !is_paused);
    }
    double const seconds = session_supply(&server->session, client);
    if (seconds <= 0.0 || client->end_reason || client->is_overrun)
        lws_callback_on_writable(client->wsi);
    else if (isfinite(seconds))
        lws_set_timer_usecs(client->wsi, (lws_usec_t)(seconds * 1e6) + 1);
}

static void look_after_all(view_server *server) {
    session_come_round(&server->session);
    for (size_t i = 0; i < server->session.client_count; i++)
        look_after(server, server->session.clients[i]);
}

/* Sends one message. */
static int send_next(struct lws *wsi, view_client *client) {
    view_server *const server = get_server(wsi);
    if (client->end_reason)
        return close_with(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, client->end_reason);
    if (client->is_overrun)
        return close_with(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION,
                          "too many messages wait to be read");
    (void)session_supply(&server->session, client);
    client_message *const message = client_get_first(client);
    if (message) {
        size_t const count = message->buffer.count;
        int const sent = lws_write(wsi, buffer_get(&message->buffer), count,
                                   message->is_binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT);
        if (sent < (int)count) return -1;
        client_drop_first(client);
    }
    look_after(server, client);
    return 0;
}

static int receive(struct lws *wsi, view_client *client, const void *bytes, size_t count) {
    view_server *const server = get_server(wsi);
    if (lws_frame_is_binary(wsi))
        return close_with(wsi, LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE, "only text is taken");
    if (client->incoming.count + count > MESSAGE_TEXT_MAX)
        return close_with(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, "the message is too long");
    buffer_put_bytes(&client->incoming, bytes, count);
    if (client->incoming.is_failed)
        return close_with(wsi, LWS_CLOSE_STATUS_UNEXPECTED_CONDITION, "out of memory");
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi) > 0) return 0;
    view_buffer const message = client->incoming;
    client->incoming = (view_buffer){0};
    session_take_message(&server->session, client, (const char *)buffer_get(&message),
                         message.count);
    buffer_release(&(view_buffer){message.bytes, message.count, message.capacity, false});
    if (client->end_reason)
        return close_with(wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, client->end_reason);
    look_after(server, client);
    return 0;
}

static int handle_session(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                          size_t length) {
    connection *const place = user;
    switch (reason) {
    case LWS_CALLBACK_ESTABLISHED:
        place->client = session_add_client(&get_server(wsi)->session, wsi);
        if (!place->client) return -1;
        look_after(get_server(wsi), place->client);
        break;
    case LWS_CALLBACK_RECEIVE: return place->client ? receive(wsi, place->client, in, length) : -1;
    case LWS_CALLBACK_SERVER_WRITEABLE: return place->client ? send_next(wsi, place->client) : -1;
    case LWS_CALLBACK_TIMER:
        if (place->client) look_after(get_server(wsi), place->client);
        break;
    case LWS_CALLBACK_CLOSED:
        if (place->client) session_remove_client(&get_server(wsi)->session, place->client);
        place->client = NULL;
        break;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED: look_after_all(get_server(wsi)); break;
    default: break;
    }
    return 0;
}

/* ---- the server ---- */

static const struct lws_protocols protocols[] = {
    {"http-only", handle_http, sizeof(connection), 0, 0, NULL, 0},
    {protocol_name, handle_session, sizeof(connection), PIECE_BYTES, 0, NULL, 0},
    {NULL, NULL, 0, 0, 0, NULL, 0}};

/* Every answer has these. */
static const struct lws_protocol_vhost_options headers[] = {
    {&headers[1], NULL, "content-security-policy:",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
     "connect-src 'self'; media-src blob:; base-uri 'none'; form-action 'none'; frame-ancestors "
     "'none'"},
    {&headers[2], NULL, "x-content-type-options:", "nosniff"},
    {&headers[3], NULL, "referrer-policy:", "no-referrer"},
    {&headers[4], NULL, "cache-control:", "no-store"},
    {&headers[5], NULL, "cross-origin-resource-policy:", "same-origin"},
    {NULL, NULL, "cross-origin-opener-policy:", "same-origin"}};

static void tick(lws_sorted_usec_list_t *list) {
    view_server *const server = lws_container_of(list, view_server, tick);
    look_after_all(server);
    lws_sul_schedule(server->context, 0, &server->tick, tick, TICK_MICROSECONDS);
}

static bool is_loopback(const char *address) {
    return strncmp(address, "127.", 4) == 0 || strcmp(address, "::1") == 0;
}

/* Every address of this machine, the loopback among them. */
static bool is_any(const char *address) {
    return strcmp(address, "0.0.0.0") == 0 || strcmp(address, "::") == 0;
}

static void add_name(view_guard *guard, const char *name) {
    if (guard->name_count < GUARD_NAMES_MAX) guard->names[guard->name_count++] = name;
}

static void name_hosts(view_server *server) {
    const view_options *const options = server->options;
    if (is_loopback(options->listen) || is_any(options->listen)) {
        add_name(&server->guard, "127.0.0.1");
        add_name(&server->guard, "localhost");
        add_name(&server->guard, "[::1]");
    }
    static char bracketed[64]; /* an IPv6 address as a host has it */
    snprintf(bracketed, sizeof bracketed, strchr(options->listen, ':') ? "[%.50s]" : "%.60s",
             options->listen);
    add_name(&server->guard, bracketed);
    for (size_t i = 0; i < options->host_name_count; i++)
        add_name(&server->guard, options->host_names[i]);
}

/* The context comes first, since the session's threads wake it; then the host, which listens. */
static bool begin(view_server *server, bool listens) {
    const view_options *const options = server->options;
    uint64_t const six = strchr(options->listen, ':') ? 0 : LWS_SERVER_OPTION_DISABLE_IPV6;
    struct lws_context_creation_info info = {.port = CONTEXT_PORT_NO_LISTEN_SERVER,
                                             .protocols = protocols,
                                             .user = server,
                                             .options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS |
                                                        LWS_SERVER_OPTION_VALIDATE_UTF8 | six,
                                             .fd_limit_per_thread = CONNECTIONS_MAX,
                                             .max_http_header_data = HEADER_BYTES_MAX,
                                             .max_http_header_pool = CONNECTIONS_MAX / 2,
                                             .timeout_secs = HEADER_SECONDS_MAX,
                                             .keepalive_timeout = HEADER_SECONDS_MAX,
                                             .headers = headers,
                                             .server_string = "tulle",
                                             .iface = options->listen,
                                             .vhost_name = "view"};
    lws_set_log_level(getenv("TULLE_VIEW_LOG") ? LLL_ERR | LLL_WARN | LLL_NOTICE | LLL_INFO : 0,
                      NULL);
    if (!listens) server->context = lws_create_context(&info);
    if (!listens || !server->context) return server->context != NULL;
    if (options->port >= 0) info.port = options->port;
    server->vhost = lws_create_vhost(server->context, &info);
    if (!server->vhost) return false;
    if (options->port < 0) return true;
    server->guard.port = lws_get_vhost_listen_port(server->vhost);
    return server->guard.port > 0;
}

static void print_address(const view_server *server, char *address, size_t size) {
    bool const is_six = strchr(server->options->listen, ':') != NULL;
    const char *host =
        is_any(server->options->listen) ? is_six ? "::1" : "127.0.0.1" : server->options->listen;
    if (server->options->host_name_count > 0) host = server->options->host_names[0];
    bool const has_name = server->options->host_name_count > 0;
    snprintf(address, size, is_six && !has_name ? "http://[%.250s]:%d/%s/" : "http://%.250s:%d/%s/",
             host, server->guard.port, server->guard.token);
    printf("%s\n", address);
    if (!is_loopback(server->options->listen))
        printf("the connection is not encrypted, and who has this address may do all "
               "that the page can\n");
    printf("Ctrl-C ends\n");
    fflush(stdout);
}

static void open_browser(const char *address) {
    char program[] = "xdg-open", copy[400];
    snprintf(copy, sizeof copy, "%s", address);
    char *const argv[] = {program, copy, NULL};
    pid_t child = 0;
    posix_spawnattr_t own_group; /* Ctrl-C is not for the browser */
    bool is_open = posix_spawnattr_init(&own_group) == 0;
    if (is_open) {
        is_open = posix_spawnattr_setflags(&own_group, POSIX_SPAWN_SETPGROUP) == 0 &&
                  posix_spawnp(&child, program, NULL, &own_group, argv, environ) == 0;
        posix_spawnattr_destroy(&own_group);
    }
    if (!is_open)
        app_print_message(command_name, "no browser could be opened; open the address yourself");
}

static void serve(view_server *server) {
    char address[400];
    interrupt_catch();
    print_address(server, address, sizeof address);
    if (server->options->opens_browser) open_browser(address);
    lws_sul_schedule(server->context, 0, &server->tick, tick, TICK_MICROSECONDS);
    while (!interrupt_is_pending() && lws_service(server->context, 0) >= 0) {}
    lws_sul_cancel(&server->tick);
}

view_server *server_open(const view_options *options, int *code) {
    static view_server server; /* one at a time: it is too large for a stack */
    server = (view_server){.options = options};
    tulle_error error = {0};
    *code = APP_EXIT_CANNOT_GO_ON;
    tulle_status const status =
        begin(&server, false)
            ? session_open(&server.session, options, wake, &server, &error)
            : error_set(&error, TULLE_ERROR_OUT_OF_MEMORY, "the network cannot be used");
    if (status != TULLE_OK) {
        app_print_error(command_name, &error);
        *code = app_exit_for_input(status);
    } else if (!guard_make_token(&server.guard)) {
        app_print_message(command_name, "the system has no random numbers for a token");
    } else if (!begin(&server, true)) {
        app_print_message(command_name,
                          "%s, port %d cannot be listened on: is another program there, or is it "
                          "not this machine's? --port 0 takes any that is free",
                          options->listen, options->port);
    } else {
        name_hosts(&server);
        *code = APP_EXIT_FINE;
        return &server;
    }
    server_close(&server);
    return NULL;
}

int server_close(view_server *server) {
    int const code = server->session.exit_code;
    struct lws_context *const context = server->context;
    worker_stop(server->session.worker); /* threads that wake end before the context does */
    server->session.worker = NULL;
    live_stop(server->session.live);
    server->session.live = NULL;
    if (context) lws_context_destroy(context);
    server->context = NULL;
    session_close(&server->session);
    return code;
}

const char *server_get_token(const view_server *server) { return server->guard.token; }

bool server_adopt(view_server *server, int socket) {
    return lws_adopt_socket_vhost(server->vhost, socket) != NULL;
}

void server_come_round(view_server *server) {
    look_after_all(server);
    (void)lws_service(server->context, -1);
}

int server_run(const view_options *options) {
    int code = APP_EXIT_FINE;
    view_server *const server = server_open(options, &code);
    if (!server) return code;
    serve(server);
    return server_close(server);
}
