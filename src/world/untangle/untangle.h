/* world/untangle/untangle.h - cleans a start whose cloth intersects itself, other cloth or
 * obstacles. */
#ifndef TULLE_WORLD_UNTANGLE_UNTANGLE_H
#define TULLE_WORLD_UNTANGLE_UNTANGLE_H

#include "world/world_state.h"

/* Moves the cloth vertices of world->now that are not pinned, until the exact judge finds no
 * intersection and pairs keep the minimum gap, or until def.untangle_limit rounds have passed.
 * Laws, distances, world->is_fixed and world->intersections (of the start) must be there. Fills
 * world->untangle_report. TULLE_ERROR_INTERSECTING_START when the limit is met: the text names
 * pairs that the state with the fewest has left. TULLE_ERROR_INTERRUPTED by the world's stop
 * request. */
tulle_status world_untangle(tulle_world *world, tulle_error *error);

#endif
