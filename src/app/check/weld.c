/* app/check/weld.c - see weld.h. */
#include "app/check/weld.h"

#include "base/error.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A vertex in its place. */
typedef struct placed_vertex {
    double position[3];
    uint32_t number;
} placed_vertex;

static int compare_places(const void *a, const void *b) {
    const placed_vertex *const left = a, *const right = b;
    for (int k = 0; k < 3; k++)
        if (left->position[k] != right->position[k])
            return left->position[k] < right->position[k] ? -1 : 1;
    return (left->number > right->number) - (left->number < right->number);
}

static bool is_same_place(const double *positions, uint32_t a, uint32_t b) {
    const double *const x = positions + 3 * (size_t)a, *const y = positions + 3 * (size_t)b;
    return x[0] == y[0] && x[1] == y[1] && x[2] == y[2];
}

tulle_status check_weld_open(const double *positions, size_t vertex_count, check_weld *weld,
                             tulle_error *error) {
    *weld = (check_weld){.vertex_count = vertex_count};
    weld->same = calloc(vertex_count + 1, sizeof *weld->same);
    weld->next = calloc(vertex_count + 1, sizeof *weld->next);
    weld->last = calloc(vertex_count + 1, sizeof *weld->last);
    placed_vertex *const placed = calloc(vertex_count + 1, sizeof *placed);
    if (!weld->same || !weld->next || !weld->last || !placed) {
        free(placed);
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for %zu vertices",
                         vertex_count);
    }
    for (size_t v = 0; v < vertex_count; v++) {
        memcpy(placed[v].position, positions + 3 * v, sizeof placed[v].position);
        placed[v].number = (uint32_t)v;
    }
    qsort(placed, vertex_count, sizeof *placed, compare_places);
    for (size_t i = 0; i < vertex_count; i++) {
        uint32_t const number = placed[i].number;
        bool const goes_on =
            i > 0 && is_same_place(positions, placed[i - 1].number, placed[i].number);
        weld->same[number] = goes_on ? weld->same[placed[i - 1].number] : number;
    }
    free(placed);
    return TULLE_OK;
}

void check_weld_close(check_weld *weld) {
    free(weld->same);
    free(weld->next);
    free(weld->last);
    *weld = (check_weld){0};
}

/* Those that left an earlier vertex in this frame are in a list behind it: what leaves later joins
 * the first of them in its place. */
void check_weld_part(check_weld *weld, const double *positions) {
    for (size_t v = 0; v < weld->vertex_count; v++) {
        weld->next[v] = TULLE_NONE;
        weld->last[v] = (uint32_t)v;
    }
    for (uint32_t v = 0; v < weld->vertex_count; v++) {
        uint32_t const first = weld->same[v];
        if (first == v || is_same_place(positions, first, v)) continue;
        uint32_t other = weld->next[first];
        while (other != TULLE_NONE && !is_same_place(positions, other, v))
            other = weld->next[other];
        weld->same[v] = other != TULLE_NONE ? other : v;
        if (other != TULLE_NONE) continue;
        weld->next[weld->last[first]] = v;
        weld->last[first] = v;
    }
}

size_t check_weld_count(const check_weld *weld) {
    size_t count = 0;
    for (size_t v = 0; v < weld->vertex_count; v++) count += weld->same[v] != v;
    return count;
}
