/* dynamics/yarn_frame.h - the directions of warp and weft in a triangle at rest. */
#ifndef TULLE_DYNAMICS_YARN_FRAME_H
#define TULLE_DYNAMICS_YARN_FRAME_H

#include "dynamics/cloth_model.h"

/* Unit vectors in the plane of the triangle, at right angles. */
typedef struct yarn_frame {
    vec3 warp, weft;
} yarn_frame;

/* A warp at right angles to the plane says nothing; then another axis does. */
static inline yarn_frame yarn_frame_make(const cloth_model_def *def, size_t triangle) {
    static const double LEAST = 1e-3;
    const uint32_t *const corners = def->surface->triangles + 3 * triangle;
    vec3 const origin = cloth_get_rest(def, triangle, corners[0]);
    vec3 const left = vec3_sub(cloth_get_rest(def, triangle, corners[1]), origin);
    vec3 const right = vec3_sub(cloth_get_rest(def, triangle, corners[2]), origin);
    vec3 const normal = vec3_normalize(vec3_cross(left, right));
    vec3 const directions[3] = {def->warps ? vec3_normalize(vec3_load(def->warps, triangle))
                                           : (vec3){1.0, 0.0, 0.0},
                                {1.0, 0.0, 0.0},
                                {0.0, 1.0, 0.0}};
    vec3 warp = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        warp = vec3_add_scaled(directions[k], normal, -vec3_dot(directions[k], normal));
        if (vec3_norm(warp) > LEAST) break;
    }
    warp = vec3_normalize(warp);
    return (yarn_frame){warp, vec3_cross(normal, warp)};
}

#endif
