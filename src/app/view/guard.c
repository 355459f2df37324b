/* app/view/guard.c - see guard.h. */
#define _DEFAULT_SOURCE
#include "app/view/guard.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>

bool guard_make_token(view_guard *guard) {
    unsigned char bytes[(GUARD_TOKEN_SIZE - 1) / 2];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) return false;
    for (size_t i = 0; i < sizeof bytes; i++) snprintf(guard->token + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

const char *guard_match_path(const view_guard *guard, const char *path) {
    size_t const length = GUARD_TOKEN_SIZE - 1;
    if (strlen(path) < length + 2 || path[0] != '/' || path[length + 1] != '/') return NULL;
    unsigned difference = 0;
    for (size_t i = 0; i < length; i++)
        difference |= (unsigned char)path[i + 1] ^ (unsigned char)guard->token[i];
    return difference == 0 ? path + length + 2 : NULL;
}

bool guard_allows_host(const view_guard *guard, const char *host) {
    char wanted[300];
    for (size_t i = 0; i < guard->name_count; i++) {
        snprintf(wanted, sizeof wanted, "%.250s:%d", guard->names[i], guard->port);
        if (strcasecmp(host, wanted) == 0) return true;
        if (guard->port == 80 && strcasecmp(host, guard->names[i]) == 0) return true;
    }
    return false;
}

bool guard_allows_origin(const view_guard *guard, const char *origin) {
    static const char scheme[] = "http://";
    return strncasecmp(origin, scheme, sizeof scheme - 1) == 0 &&
           guard_allows_host(guard, origin + sizeof scheme - 1);
}
