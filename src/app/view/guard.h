/* app/view/guard.h - who may come in: the token in the address, the names by which the server is
 * called, the page that a WebSocket comes from. */
#ifndef TULLE_APP_VIEW_GUARD_H
#define TULLE_APP_VIEW_GUARD_H

#include <stdbool.h>
#include <stddef.h>

enum { GUARD_TOKEN_SIZE = 33 /* 32 hexadecimal digits and a zero */, GUARD_NAMES_MAX = 32 };

typedef struct view_guard {
    char token[GUARD_TOKEN_SIZE];
    const char *names[GUARD_NAMES_MAX]; /* hosts, as "127.0.0.1", "[::1]" */
    size_t name_count;
    int port;
} view_guard;

/* Fills the token by the system's random numbers; false where there are none. */
bool guard_make_token(view_guard *guard);
/* "/TOKEN/REST" to REST, which may be empty; null for another token. Takes the same time for all
 * tokens of the right length. */
const char *guard_match_path(const view_guard *guard, const char *path);
/* Whether a Host header is one of the names with the port. */
bool guard_allows_host(const view_guard *guard, const char *host);
/* Whether an Origin header is http:// and such a host. */
bool guard_allows_origin(const view_guard *guard, const char *origin);

#endif
