/* app/render/camera.h - where pictures of a run are taken from. */
#ifndef TULLE_APP_RENDER_CAMERA_H
#define TULLE_APP_RENDER_CAMERA_H

#include "render/render.h"
#include "scene/picture.h"

static const double PICTURE_AZIMUTH = -0.95;  /* [rad] from the right of the front */
static const double PICTURE_ELEVATION = 0.42; /* [rad] a little from above: folds have shadows */

/* A box; empty while low > high. */
typedef struct picture_bounds {
    double low[3], high[3]; /* [m] */
} picture_bounds;

picture_bounds picture_bounds_empty(void);
bool picture_bounds_is_empty(const picture_bounds *bounds);
void picture_bounds_add(picture_bounds *bounds, const double *positions, size_t vertex_count);
/* Empty ones add nothing. */
void picture_bounds_join(picture_bounds *bounds, const picture_bounds *other);
/* Length of its diagonal; 0 of an empty box. */
double picture_bounds_get_diagonal(const picture_bounds *bounds);

/* What a camera is to see: a box, and the points of it that go farthest in many directions, which
 * fit it closer than the box's corners. */
enum { PICTURE_VIEW_POINTS = 96 };
typedef struct picture_view {
    picture_bounds bounds;
    double points[3 * PICTURE_VIEW_POINTS]; /* meaningless while the bounds are empty */
} picture_view;

picture_view picture_view_empty(void);
void picture_view_add(picture_view *view, const double *positions, size_t vertex_count);
/* Empty ones add nothing. */
void picture_view_join(picture_view *view, const picture_view *other);

/* Adds an obstacle to the view of the cloths if it is near them. Of one that is much larger than
 * they are only the part next to them is added: ground of many metres must not make the cloth tiny.
 * `cloths` is the box of the cloths alone. */
void picture_view_add_obstacle(picture_view *view, const picture_bounds *cloths,
                               const picture_view *obstacle);

/* What `first` says, and `second` where it says nothing; a position and an orbit exclude each
 * other. */
scene_camera picture_camera_merge(const scene_camera *first, const scene_camera *second);

/* The camera of a picture at `share` (0 .. 1) of the film, all of `view` in sight where nothing
 * else is asked for. Errors: TULLE_ERROR_INVALID_ARGUMENT (it stands in its target). */
tulle_status picture_make_camera(const scene_camera *asked, const picture_view *view, double aspect,
                                 double share, render_camera *camera, tulle_error *error);

#endif
