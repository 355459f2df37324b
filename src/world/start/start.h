/* world/start/start.h - parts of the start. */
#ifndef TULLE_WORLD_START_START_H
#define TULLE_WORLD_START_START_H

#include "world/world_state.h"

/* start_bodies.c: numbers the bodies. Called before the surfaces are numbered. */
tulle_status world_number_bodies(tulle_world *world);
/* start_bodies.c: the slots of the bodies in the first state, at its time. `transforms`, or null,
 * has those that are there and free; their vertices follow, the others are where obstacles are. */
void world_place_bodies(tulle_world *world, const tulle_transform *transforms);

/* start_detection.c: trees and patches of a world whose distances are known. */
tulle_status world_start_detection(tulle_world *world);
void world_release_detection(tulle_world *world);

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

#endif
