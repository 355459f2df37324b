/* render/ticks.h - round numbers along a scale, and their texts. */
#ifndef TULLE_RENDER_TICKS_H
#define TULLE_RENDER_TICKS_H

#include <stdbool.h>
#include <stddef.h>

enum { TICK_MAX = 64, TICK_LABEL_SIZE = 32 };

typedef struct tick_scale {
    double low, high; /* finite, low < high; both > 0 on a logarithmic scale */
    bool is_logarithmic;
    bool has_prefixes; /* the unit takes them: m, mm, um ... */
    const char *unit;  /* null or empty: a pure number */
} tick_scale;

typedef struct tick {
    double part; /* of the way from low to high, 0 .. 1 */
    double value;
    char label[TICK_LABEL_SIZE]; /* empty: a small tick between two labelled ones */
} tick;

typedef struct tick_list {
    tick ticks[TICK_MAX];
    size_t count;
    char unit[TICK_LABEL_SIZE]; /* of the labels, to be named beside the title; empty when each
                                   label has its own, or there is none */
} tick_list;

/* Where a value is, 0 at low and 1 at high, less and more outside. */
double tick_scale_get_part(const tick_scale *scale, double value);

/* At most label_max (2 .. 16) labelled ticks. On a linear scale they are at 1, 2 or 5 times a power
 * of ten. On a logarithmic scale they are at powers of ten, and at 2 and 5 times these where few
 * powers are in range. A scale of no extent has none. */
void tick_list_make(const tick_scale *scale, size_t label_max, tick_list *list);

#endif
