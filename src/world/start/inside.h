/* world/start/inside.h - objects that lie inside closed obstacles. */
#ifndef TULLE_WORLD_START_INSIDE_H
#define TULLE_WORLD_START_INSIDE_H

#include "math/vec3.h"
#include "world/world_state.h"

/* Solid angle of triangles seen from a point, over 4 pi: the winding number, 1 inside a closed
 * surface that faces outward, -1 inside one that faces inward, 0 outside. Corners are indices into
 * `positions`. */
double compute_winding_number(const uint32_t *triangles, size_t triangle_count,
                              const double *positions, vec3 point);

/* Over this the winding number says inside. Surfaces that face inward (rooms) have no inside. */
static const double INSIDE_WINDING = 0.5;

/* Whether each edge of a surface has two triangles. */
bool surface_is_closed(const topology *topo, const surface_range *range);

typedef struct inside_question {
    const char *when; /* "at the start" and the like, for the message */
    bool is_late;   /* asked in a step: refuses cloth only inside an obstacle that just appeared */
    bool has_added; /* asked of one surface: others inside it, and it inside others */
    uint32_t added;
} inside_question;

/* Refuses objects inside others, with TULLE_ERROR_INTERSECTING_START:
 * - a piece of cloth that intersects nothing, inside a present obstacle that is closed and faces
 *   outward;
 * - a piece of an obstacle inside another obstacle, when one of the two is a free body.
 * The winding number decides, so the hollow of a shell with an inner surface is not inside. */
tulle_status world_refuse_inside(tulle_world *world, const double *positions,
                                 inside_question question, tulle_error *error);

#endif
