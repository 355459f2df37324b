/* render/embree_scene.h - the ray tracer: which triangle a ray meets first, whether it meets any.
 */
#ifndef TULLE_RENDER_EMBREE_SCENE_H
#define TULLE_RENDER_EMBREE_SCENE_H

#include "render/geometry.h"

#include <embree3/rtcore.h>

/* Triangles, and the marks apart, for only the camera sees them. */
typedef struct render_scene {
    render_geometry geometry;
    RTCScene triangles, marks; /* null: there are none */
    float *mark_balls;         /* 4 * mark_count: center, radius */
    size_t mark_count;
    memory heap;
} render_scene;

/* A ray in single precision, as it is traced. */
typedef struct render_ray {
    float origin[3], direction[3];
    uint32_t excluded; /* a triangle that it does not meet, or TULLE_NONE */
    float length;      /* where it ends, in lengths of its direction */
} render_ray;

/* Errors: TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status render_scene_build(RTCDevice device, const render_frame_def *def, render_scene *scene,
                                tulle_error *error);
void render_scene_destroy(render_scene *scene);

/* The first triangle that the ray meets, or TULLE_NONE. */
uint32_t render_scene_find_first(const render_scene *scene, const render_ray *ray);
bool render_scene_is_blocked(const render_scene *scene, const render_ray *ray);
/* The first mark that the ray meets, or TULLE_NONE. */
uint32_t render_scene_find_mark(const render_scene *scene, const render_ray *ray);

#endif
