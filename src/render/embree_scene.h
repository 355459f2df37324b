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

static inline render_ray render_ray_make(vec3 origin, vec3 direction, uint32_t excluded) {
    return (render_ray){{(float)origin.x, (float)origin.y, (float)origin.z},
                        {(float)direction.x, (float)direction.y, (float)direction.z},
                        excluded,
                        INFINITY};
}

/* A camera as its rays start. */
typedef struct render_lens {
    vec3 origin;              /* relative to the center, rounded */
    vec3 corner, right, down; /* direction to the top left corner, and per pixel */
} render_lens;

render_lens render_lens_make(const render_camera *camera, vec3 center, uint32_t width,
                             uint32_t height);

/* Through a place of the picture, in pixels from the top left corner. */
static inline vec3 render_lens_get_direction(const render_lens *lens, double column, double row) {
    return vec3_add_scaled(vec3_add_scaled(lens->corner, lens->right, column), lens->down, row);
}

struct render_context {
    RTCDevice device;
};

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
