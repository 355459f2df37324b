/* support/object_world.h - things of each kind, to be added to worlds and removed again. */
#ifndef TULLE_TEST_OBJECT_WORLD_H
#define TULLE_TEST_OBJECT_WORLD_H

#include "tulle/tulle.h"

#include <stdbool.h>

typedef enum thing {
    THING_SHEET,    /* cloth that falls onto the ground */
    THING_PINNED,   /* cloth with hysteresis on two pins, one of them on keyframes */
    THING_GROUND,   /* does not move */
    THING_BOX,      /* a body that sleeps on the ground */
    THING_BALL,     /* a body that falls onto the sheet */
    THING_KEYS,     /* an obstacle on keyframes */
    THING_FRAMES,   /* one that deforms by a reader */
    THING_RIGID,    /* one that the host drives as a whole */
    THING_VERTICES, /* one that the host drives vertex by vertex */
    THING_COUNT
} thing;

static const double THING_STEP = 1.0 / 64.0; /* [s] */

bool thing_is_body(thing what);

/* Fails the test on an error. */
void things_fine(tulle_status status, const tulle_error *error);
/* Adds a thing, shifted by x [m]. */
tulle_status things_try_cloth(tulle_world *world, thing what, double x, tulle_cloth_id *id,
                              tulle_error *error);
tulle_status things_try_obstacle(tulle_world *world, thing what, double x, tulle_obstacle_id *id,
                                 tulle_error *error);
tulle_status things_try(tulle_world *world, thing what, double x, tulle_object_id *id,
                        tulle_error *error);
/* The same; fails the test on an error, as all that follows. */
tulle_object_id things_add(tulle_world *world, thing what, double x);
tulle_status things_try_remove(tulle_world *world, tulle_object_id id, tulle_error *error);
void things_remove(tulle_world *world, tulle_object_id id);
/* A world without objects; null: with the default def and one thread. */
tulle_world *things_make_world(const tulle_world_def *wanted);
void things_start(tulle_world *world);
void things_step(tulle_world *world, int count);
/* Pairs of triangles that intersect now, of all that is present. */
size_t things_judge(const tulle_world *world);

#endif
