/* render/rest_coordinates.h - where each vertex of a cloth lies in flat cloth at rest, so that a
 * pattern drawn there moves, stretches and slips with the cloth. */
#ifndef TULLE_RENDER_REST_COORDINATES_H
#define TULLE_RENDER_REST_COORDINATES_H

#include "base/memory.h"

/* pieces: 1 a triangle, the number of its edge-connected piece, from 0 in the order of their first
 * triangles; returns in *piece_count how many there are. Indices must be in range. Errors:
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status render_find_pieces(memory *heap, tulle_mesh_view mesh, uint32_t *pieces,
                                size_t *piece_count, tulle_error *error);

/* coordinates [m]: 2 a vertex, from the shape at rest. A flat piece maps to its plane without
 * distortion. Another piece is unfolded triangle by triangle. That keeps lengths where the piece is
 * developable, and leaves a seam where it closes on itself. Axes go along the borders where these
 * are mostly at right angles to one another, else along x. A vertex that no triangle uses gets 0,
 * 0. Errors: TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status render_make_rest_coordinates(memory *heap, tulle_mesh_view rest, double *coordinates,
                                          tulle_error *error);

#endif
