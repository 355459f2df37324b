/* support/pins.h - pins of cloth for tests. */
#ifndef TULLE_TEST_PINS_H
#define TULLE_TEST_PINS_H

#include "tulle/world.h"

/* A pin that holds vertices where they are until `release_time` [s]; INFINITY: for ever. */
static inline tulle_pin make_pin(const uint32_t *vertices, size_t vertex_count,
                                 double release_time) {
    tulle_pin pin = tulle_pin_default();
    pin.vertices = vertices;
    pin.vertex_count = vertex_count;
    pin.release_time = release_time;
    return pin;
}

#endif
