/* contact/commit/scale_components.h - second step of the rescue: vertices that hits connect go only
 * a part of their paths. */
#ifndef TULLE_CONTACT_COMMIT_SCALE_COMPONENTS_H
#define TULLE_CONTACT_COMMIT_SCALE_COMPONENTS_H

#include "contact/commit/vertex_groups.h"
#include "contact/pairs/pair_scan.h"

typedef struct scaled_components {
    vertex_groups groups; /* cloth vertices, then bodies */
    vec3 *body_motions;   /* before any scaling: u of both slots of each body */
    double *base;         /* [m] x1 before any scaling, 3 * vertex_count */
    double *scales;       /* by group name: part of the path, 0 .. 1 */
    int32_t *carriers;    /* by group name: surface, or one of the marks in the source */
    double *times;        /* by group name: smallest time of impact of the round */
} scaled_components;

/* Takes u and x1 before any scaling. Arrays are in the scene's scratch arena. False when memory is
 * short. */
bool scaled_components_make(scaled_components *components, const contact_scene *scene,
                            const double *x1, const double *u);

/* Joins the hits to the components. Shortens each component that was hit to 0.9 of its smallest
 * time of impact, or to nothing when `stop`, and sets x1 and u of all components. A component moves
 * to K x0 + s (base - K x0). K is the affine motion of the moving obstacle that it touches, if it
 * touches just one; else the identity. A body is one member. Returns how many components were
 * shortened. If 0, no component can help further. */
size_t scale_components(const contact_scene *scene, scaled_components *components,
                        const pair_events *hits, bool stop, double *u, double *x1);

#endif
