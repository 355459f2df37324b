/* contact/commit/scale_components.h - second step of the rescue: cloth vertices connected by hits
 * go only part of their way. */
#ifndef TULLE_CONTACT_COMMIT_SCALE_COMPONENTS_H
#define TULLE_CONTACT_COMMIT_SCALE_COMPONENTS_H

#include "contact/commit/vertex_groups.h"
#include "contact/pairs/pair_scan.h"

typedef struct scaled_components {
    vertex_groups groups; /* cloth vertices, then bodies */
    vec3 *body_motions;   /* before any scaling: u of both slots and the lift of each body */
    double *base;         /* [m] x1 before any scaling, 3 * vertex_count */
    double *scales;       /* by group name: part of the way, 0 .. 1 */
    int32_t *carriers;    /* by group name: surface, or one of the marks in the source */
    double *times;        /* by group name: smallest time of impact of the round */
} scaled_components;

/* False when memory is short. Arrays are in the scene's scratch arena. */
bool scaled_components_make(scaled_components *components, const contact_scene *scene,
                            const double *x1, const double *u);

/* Joins the hits to the components, shortens each component that was hit to 0.9 of its smallest
 * time of impact (to nothing when `stop`), and sets x1 and u of all components. A body is one
 * member. A component goes x0 -> K x0 + s (base - K x0), where K is the affine motion of the one
 * moving obstacle that it touches, else the identity. Returns how many components were shortened.
 * If 0, no component can help further. */
size_t scale_components(const contact_scene *scene, scaled_components *components,
                        const pair_events *hits, bool stop, double *u, double *x1);

#endif
