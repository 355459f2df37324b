/* render/check_def.c - see check_def.h. */
#include "render/check_def.h"

#include "base/error.h"
#include "math/vec3.h"

enum { SAMPLES_MAX = 65536, BOUNCES_MAX = 64 };

static const double pi = 3.14159265358979323846;
/* [m] of any coordinate; squares of lengths stay far inside single precision's range. */
static const double coordinate_max = 1e9;
/* [rad] smallest angle between the view and the camera's up that still tells which way is up. */
static const double up_angle_min = 1e-6;

static bool are_finite(const double *values, size_t count, double limit) {
    for (size_t i = 0; i < count; i++)
        if (!(fabs(values[i]) <= limit)) return false;
    return true;
}

static bool is_color(const float *color, float limit) {
    for (int i = 0; i < 3; i++)
        if (!(color[i] >= 0.0f && color[i] <= limit)) return false;
    return true;
}

static tulle_status refuse(tulle_error *error, const char *what) {
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the picture cannot be made: %s", what);
}

static tulle_status check_camera(const render_camera *camera, tulle_error *error) {
    if (!are_finite(camera->position, 3, coordinate_max) ||
        !are_finite(camera->target, 3, coordinate_max) ||
        !are_finite(camera->up, 3, coordinate_max))
        return refuse(error, "a coordinate of the camera is not a number or beyond 1e9 m");
    vec3 const view = vec3_sub(vec3_load(camera->target, 0), vec3_load(camera->position, 0));
    vec3 const up = vec3_load(camera->up, 0);
    if (!(vec3_norm(view) > 0.0)) return refuse(error, "the camera stands at its own target");
    if (!(vec3_norm(up) > 0.0)) return refuse(error, "the camera's up has no length");
    if (vec3_norm(vec3_cross(vec3_normalize(view), vec3_normalize(up))) < up_angle_min)
        return refuse(error, "the camera looks along its own up; choose another up");
    if (!(camera->field_of_view > 0.0 && camera->field_of_view < pi))
        return refuse(error, "the camera's field of view is not between 0 and 180 degrees");
    return TULLE_OK;
}

static tulle_status check_lighting(const render_lighting *lighting, tulle_error *error) {
    if (!are_finite(lighting->light_direction, 3, coordinate_max) ||
        !(vec3_norm(vec3_load(lighting->light_direction, 0)) > 0.0))
        return refuse(error, "the light has no direction");
    if (!(lighting->light_angle >= 0.0 && lighting->light_angle < 0.5 * pi))
        return refuse(error, "the light's angle is not between 0 and 90 degrees");
    if (!is_color(lighting->light_radiance, 1e6f) || !is_color(lighting->sky_color, 1e6f) ||
        !is_color(lighting->horizon_color, 1e6f))
        return refuse(error, "a color of the light or the sky is negative or not a number");
    if (!is_color(lighting->floor_color, 1.0f))
        return refuse(error, "the floor's color is not between 0 and 1");
    if (lighting->has_floor && !(fabs(lighting->floor_height) <= coordinate_max))
        return refuse(error, "the floor's height is not a number");
    if (lighting->bounces > BOUNCES_MAX) return refuse(error, "more than 64 bounces");
    return TULLE_OK;
}

static tulle_status check_mesh(tulle_mesh_view mesh, size_t surface, tulle_error *error) {
    for (size_t v = 0; v < mesh.vertex_count; v++)
        if (!are_finite(mesh.positions + 3 * v, 3, coordinate_max))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the picture cannot be made: vertex %zu of surface %zu is not a "
                             "number or beyond 1e9 m",
                             v, surface);
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        if (mesh.triangles[i] >= mesh.vertex_count)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the picture cannot be made: triangle %zu of surface %zu has a vertex "
                             "that is not there",
                             i / 3, surface);
    return TULLE_OK;
}

static tulle_status check_surface(const render_surface *surface, size_t index, tulle_error *error) {
    tulle_status const status = check_mesh(surface->mesh, index, error);
    if (status != TULLE_OK) return status;
    const char *what = NULL;
    if (!is_color(surface->front_color, 1.0f) || !is_color(surface->back_color, 1.0f))
        what = "a color that is not between 0 and 1";
    else if (!(surface->crease_angle >= 0.0))
        what = "a crease angle that is negative or not a number";
    else if ((unsigned)surface->pattern > RENDER_PATTERN_CHECK)
        what = "an unknown pattern";
    else if (surface->pattern != RENDER_PATTERN_PLAIN && surface->rest_coordinates &&
             !(surface->pattern_size > 0.0 && surface->pattern_size <= coordinate_max))
        what = "a pattern without a size";
    for (size_t v = 0; !what && surface->vertex_colors && v < surface->mesh.vertex_count; v++)
        if (!is_color(surface->vertex_colors + 3 * v, 1.0f))
            what = "a vertex color that is not between 0 and 1";
    for (size_t t = 0; !what && surface->triangle_colors && t < surface->mesh.triangle_count; t++)
        if (!is_color(surface->triangle_colors + 3 * t, 1.0f))
            what = "a triangle color that is not between 0 and 1";
    for (size_t v = 0; !what && surface->rest_coordinates && v < surface->mesh.vertex_count; v++)
        if (!are_finite(surface->rest_coordinates + 2 * v, 2, coordinate_max))
            what = "a rest coordinate that is not a number";
    if (!what) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "the picture cannot be made: surface %zu has %s", index, what);
}

static tulle_status check_marks(const render_frame_def *def, tulle_error *error) {
    for (size_t i = 0; i < def->mark_count; i++) {
        const render_mark *const mark = &def->marks[i];
        if (!are_finite(mark->position, 3, coordinate_max) ||
            !(mark->radius > 0.0 && mark->radius <= coordinate_max) || !is_color(mark->color, 1.0f))
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "the picture cannot be made: mark %zu has a place, a radius or a "
                             "color that cannot be drawn",
                             i);
    }
    return TULLE_OK;
}

static tulle_status check_sizes(const render_frame_def *def, tulle_error *error) {
    if (def->width < 1 || def->height < 1 || def->width > RENDER_IMAGE_SIDE_MAX ||
        def->height > RENDER_IMAGE_SIDE_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a picture of %ux%u pixels cannot be made: each side has 1 to %d",
                         def->width, def->height, RENDER_IMAGE_SIDE_MAX);
    if (def->samples < 1 || def->samples > SAMPLES_MAX)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%u samples of each pixel: use 1 to %d", def->samples, SAMPLES_MAX);
    size_t vertex_count = 0, triangle_count = 0;
    for (size_t s = 0; s < def->surface_count; s++) {
        vertex_count += def->surfaces[s].mesh.vertex_count;
        triangle_count += def->surfaces[s].mesh.triangle_count;
    }
    if (vertex_count > INT32_MAX || triangle_count > INT32_MAX / 3 ||
        def->surface_count > INT32_MAX || def->mark_count > INT32_MAX)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "%zu triangles on %zu vertices are more than one picture can hold",
                         triangle_count, vertex_count);
    return TULLE_OK;
}

tulle_status render_check_def(const render_frame_def *def, tulle_error *error) {
    tulle_status status = check_sizes(def, error);
    if (status == TULLE_OK) status = check_camera(&def->camera, error);
    if (status == TULLE_OK) status = check_lighting(&def->lighting, error);
    for (size_t s = 0; status == TULLE_OK && s < def->surface_count; s++)
        status = check_surface(&def->surfaces[s], s, error);
    return status == TULLE_OK ? check_marks(def, error) : status;
}
