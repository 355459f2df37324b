/* fuzz/targets/view_socket.c - bytes to the server of `tulle view` over a pair of sockets: HTTP, or
 * what follows a handshake of a WebSocket that is let in. The server stays: after each input it
 * lets in a page that behaves. Without the viewer in the program nothing is tested.
 *
 * The first byte of an input chooses: 0 HTTP from the first byte on, else what a page that was let
 * in says. Seeds mask their frames by zeros, so that mutations keep them readable. */
#define _XOPEN_SOURCE 700
#include "app/view/server.h"
#include "support/fuzz.h"

#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { ROUNDS = 6, ROUNDS_MAX = 2000 };

static const char scene_text[] =
    "time: {step: 1/60 s, frames: 2}\n"
    "cloth:\n"
    "  - mesh: {shape: rectangle, size: [0.2, 0.2], resolution: [4, 4]}\n"
    "    pins: [{vertices: [0]}]\n"
    "obstacles:\n"
    "  - {mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0, 0, -0.2]}\n";

static view_server *server;

static void close_server(void) {
    if (server) (void)server_close(server);
    (void)unlink("scene.session"); /* which a page may have asked for */
}

static bool open_server(void) {
    static bool was_tried;
    static const char *paths[1];
    static view_options options = {
        .paths = paths, .path_count = 1, .listen = "127.0.0.1", .port = -1, .threads = 1};
    if (was_tried) return server != NULL;
    was_tried = true;
    paths[0] = strdup(fuzz_put_file("scene.yaml", scene_text, sizeof scene_text - 1));
    int code = 0;
    server = server_open(&options, &code);
    atexit(close_server);
    return server != NULL;
}

/* Lets the server work, and takes what it sends; whether the connection stays. */
static bool drain(int file, char *text, size_t size) {
    char bytes[1 << 14];
    size_t kept = 0;
    bool is_open = true;
    for (int round = 0; round < ROUNDS; round++) {
        server_come_round(server);
        ssize_t count;
        while ((count = read(file, bytes, sizeof bytes)) > 0) {
            size_t const rest = size - kept < (size_t)count ? size - kept : (size_t)count;
            if (text) memcpy(text + kept, bytes, rest);
            kept += text ? rest : 0;
            round = 0;
        }
        if (count == 0) is_open = false;
    }
    return is_open;
}

static int connect_page(void) {
    int files[2];
    FUZZ_CHECK(socketpair(AF_UNIX, SOCK_STREAM, 0, files) == 0);
    for (int i = 0; i < 2; i++)
        FUZZ_CHECK(fcntl(files[i], F_SETFL, fcntl(files[i], F_GETFL) | O_NONBLOCK) != -1);
    FUZZ_CHECK(server_adopt(server, files[1]));
    return files[0];
}

static void send_bytes(int file, const void *bytes, size_t count) {
    const char *at = bytes;
    while (count > 0) {
        ssize_t const sent = send(file, at, count, MSG_NOSIGNAL);
        if (sent > 0) {
            at += sent;
            count -= (size_t)sent;
        } else if (!drain(file, NULL, 0)) {
            return;
        }
    }
}

static void shake_hands(int file) {
    char text[600], answer[1 << 14] = "";
    int const length =
        snprintf(text, sizeof text,
                 "GET /%s/session HTTP/1.1\r\nHost: 127.0.0.1:0\r\nOrigin: http://127.0.0.1:0\r\n"
                 "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                 "Sec-WebSocket-Protocol: tulle-1\r\n\r\n",
                 server_get_token(server));
    send_bytes(file, text, (size_t)length);
    for (int round = 0; round < ROUNDS_MAX && !strstr(answer, "HTTP/1.1 101"); round++)
        (void)drain(file, answer, sizeof answer - 1);
    FUZZ_CHECK(strncmp(answer, "HTTP/1.1 101", 12) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < 1 || !open_server()) return 0;
    int const file = connect_page();
    if (data[0] != 0) shake_hands(file);
    send_bytes(file, data + 1, size - 1);
    (void)drain(file, NULL, 0);
    close(file);
    int const page = connect_page();
    shake_hands(page);
    close(page);
    for (int round = 0; round < ROUNDS; round++) server_come_round(server);
    return 0;
}

static void put_frame_seed(const char *name, unsigned first, const char *text) {
    uint8_t bytes[600] = {1, (uint8_t)first};
    size_t const length = strlen(text);
    size_t at = 2;
    if (length < 126) {
        bytes[at++] = (uint8_t)(128 | length);
    } else {
        bytes[at++] = 254;
        bytes[at++] = (uint8_t)(length >> 8);
        bytes[at++] = (uint8_t)(length & 255);
    }
    at += 4;
    memcpy(bytes + at, text, length);
    fuzz_put_seed(name, bytes, at + length);
}

void fuzz_make_seeds(void) {
    static const char get[] =
        "\0GET /0123456789abcdef0123456789abcdef/ HTTP/1.1\r\nHost: 127.0.0.1:0\r\n\r\n";
    fuzz_put_seed("get", get, sizeof get - 1);
    put_frame_seed("text", 0x81, "{\"type\":\"text\",\"id\":1}");
    put_frame_seed(
        "grab", 0x81,
        "{\"type\":\"grab\",\"object\":0,\"triangle\":5,\"weights\":[1,0,0],\"point\":[0,0,0]}");
    put_frame_seed("step", 0x81, "{\"type\":\"step\",\"count\":2}");
    put_frame_seed(
        "move", 0x81,
        "{\"type\":\"move\",\"object\":1,\"position\":[0,0,-0.3],\"rotation\":[1,0,0,0]}");
    put_frame_seed(
        "overlays", 0x81,
        "{\"type\":\"overlays\",\"names\":[\"contacts\",\"gaps\",\"crossings\",\"strain\"]}");
    put_frame_seed("pick", 0x81,
                   "{\"type\":\"pick\",\"object\":0,\"triangle\":2,\"weights\":[1,0,0]}");
    put_frame_seed("check", 0x81, "{\"type\":\"check\",\"text\":\"time: {step: 1}\"}");
    put_frame_seed("piece", 0x01, "{\"type\":");
    put_frame_seed("ping", 0x89, "still there?");
    put_frame_seed("close", 0x88, "\x03\xe8 bye");
    put_frame_seed("binary", 0x82, "x");
}
