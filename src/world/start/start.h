/* world/start/start.h - parts of the start. */
#ifndef TULLE_WORLD_START_START_H
#define TULLE_WORLD_START_START_H

#include "world/world_state.h"

/* start_arrays.c: numbers the bodies. Called before the surfaces are numbered. */
tulle_status world_number_bodies(tulle_world *world);
/* start_arrays.c: the slots of the bodies in the first state, at its time. `transforms`, or null,
 * has those that are there and free; their vertices follow, the others are where obstacles are. */
void world_place_bodies(tulle_world *world, const tulle_transform *transforms);

/* start_arrays.c: trees and patches of a world whose distances are known. */
tulle_status world_start_detection(tulle_world *world);

/* start_arrays.c: allocates the arrays whose sizes are numbers of vertices or surfaces. False when
 * memory is short: world_release_start then releases what there is. */
bool world_allocate_start(tulle_world *world);

/* start.c: joins the objects to one numbering. Puts what the def of an object says into the arrays.
 * Makes the cloth's model. Makes the search, and notes what saved states must fit. Errors of memory
 * without a text. */
tulle_status world_join_surfaces(tulle_world *world, tulle_error *error);
void world_fill_surface(tulle_world *world, size_t surface);
tulle_status world_build_model(tulle_world *world, tulle_error *error);
tulle_status world_finish_start(tulle_world *world);

/* start_laws.c: [m] the separation distance that goes with a contact distance. */
double world_get_separation(const tulle_world *world, double contact_distance);
/* start_laws.c: contact laws of all pairs of surfaces and the distances that the world reports. */
tulle_status world_derive_distances(tulle_world *world, tulle_error *error);
/* start_laws.c: grain of the surfaces, if one of them has friction that depends on the direction.
 * TULLE_ERROR_OUT_OF_MEMORY without a text. */
tulle_status world_set_grains(tulle_world *world);

/* start_rooms.c: notes where the start, or what a change adds, is narrower than the contact
 * distances, see rooms. Errors other than TULLE_ERROR_LIMIT without a text. */
tulle_status world_find_rooms(tulle_world *world, tulle_error *error);
/* start_slots.c: notes rooms of vertices of present surfaces, each by gaps to its own surface: the
 * share of a gap that is at least `least` [m]. `broad` has the order of the triangles. */
tulle_status world_find_slots(tulle_world *world, const surface_set *set, const broad_phase *broad,
                              double least, double share);

/* untangle/untangle.c: cleans a start whose cloth intersects itself, other cloth or obstacles.
 * Moves the cloth vertices of world->now that are not pinned, until the exact judge finds no
 * intersection and pairs keep the minimum gap, or until def.untangle_limit rounds have passed.
 * Laws, distances, world->is_fixed and world->intersections (of the start) must be there. Fills
 * world->untangle_report. TULLE_ERROR_INTERSECTING_START when the limit is met: the text names
 * pairs that the state with the fewest has left. TULLE_ERROR_INTERRUPTED by the world's stop
 * request. */
tulle_status world_untangle(tulle_world *world, tulle_error *error);

typedef struct triangle_overlap {
    double depth; /* [m] length of the shortest move of one triangle that parts it from the other */
    vec3 position; /* [m] middle of the points at which an edge of one passes through the other; the
                      middle of both where no edge does, as in a common plane */
} triangle_overlap;

/* refuse.c: of triangles that intersect or touch; a depth of 0 where they lie in one plane or only
 * touch. */
triangle_overlap measure_overlap(const vec3 a[3], const vec3 b[3]);

#endif
