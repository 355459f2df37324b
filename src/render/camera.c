/* render/camera.c - a camera that sees a box whole. */
#include "render/render.h"

#include "math/vec3.h"

static const double default_field_of_view = 0.55; /* [rad] a short telephoto lens: little slant */
static const double margin = 1.06;                /* the box leaves this much room around it */

render_camera render_camera_frame(const double bounds_min[3], const double bounds_max[3],
                                  double azimuth, double elevation, double aspect) {
    vec3 const low = vec3_load(bounds_min, 0), high = vec3_load(bounds_max, 0);
    vec3 const center = vec3_scale(vec3_add(low, high), 0.5);
    /* To the camera, and the picture's axes; up is at right angles for every elevation. */
    vec3 const back =
        vec3_make(cos(elevation) * cos(azimuth), cos(elevation) * sin(azimuth), sin(elevation));
    vec3 const up =
        vec3_make(-sin(elevation) * cos(azimuth), -sin(elevation) * sin(azimuth), cos(elevation));
    vec3 const right = vec3_cross(up, back);
    double const slope_up = tan(0.5 * default_field_of_view) / margin;
    double const slope_right = slope_up * aspect;
    double distance = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        vec3 const point = vec3_make(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                     corner & 4 ? high.z : low.z);
        vec3 const from_center = vec3_sub(point, center);
        double const sideways = fmax(fabs(vec3_dot(from_center, right)) / slope_right,
                                     fabs(vec3_dot(from_center, up)) / slope_up);
        double const needed = sideways + vec3_dot(from_center, back);
        if (needed > distance) distance = needed;
    }
    if (!(distance > 0.0)) distance = 1.0; /* a box of one point */
    render_camera camera = {.field_of_view = default_field_of_view};
    vec3_store(camera.position, 0, vec3_add_scaled(center, back, distance));
    vec3_store(camera.target, 0, center);
    vec3_store(camera.up, 0, up);
    return camera;
}
