/* base/words.c - see words.h. */
#include "base/words.h"

#include "tulle/shapes.h"

#include <stddef.h>

const char *const method_words[] = {"patches", "refit", "bvox", "paper", NULL};
const char *const cone_words[] = {"bernstein", "paper", NULL};
const char *const switch_words[] = {"off", "on", NULL};
const char *const patches_words[] = {"keep", "grow", NULL};
const char *const response_words[] = {"coupled", "paper", NULL};
const char *const motion_space_words[] = {"cone", "polyhedral", NULL};
const char *const start_words[] = {"refuse", "ignore", "untangle", NULL};
const char *const pinch_words[] = {"stop", "slow", "lag", NULL};
const char *const integrator_words[] = {"implicit-euler", "crank-nicolson", "bdf2", NULL};

const char *const shape_words[] = {
    "rectangle", "ribbon", "disc",         "tube",           "cape", "net",     "plane",
    "box",       "sphere", "hemisphere",   "cylinder",       "cone", "needle",  "tetrahedron",
    "torus",     "nail",   "bumpy-ground", "crested-ground", "tile", "sceptre", NULL};
_Static_assert(sizeof shape_words / sizeof shape_words[0] == TULLE_SHAPE_COUNT + 1,
               "one word for each shape");
