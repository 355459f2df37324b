/* render/without_embree.c - stands in for the ray tracer in a build without Embree: says so. */
#include "base/error.h"
#include "render/render.h"

bool render_is_available(void) { return false; }

tulle_status render_context_create(render_context **context, tulle_error *error) {
    *context = NULL;
    return error_set(error, TULLE_ERROR_UNSUPPORTED,
                     "this program was built without Embree, which makes the pictures: install "
                     "libembree-dev (version 3), then remove the build folder and run make again");
}

void render_context_destroy(render_context *context) { (void)context; }

tulle_status render_trace(render_context *context, const render_frame_def *def, float *radiance,
                          tulle_error *error) {
    (void)context, (void)def, (void)radiance;
    return error_set(error, TULLE_ERROR_UNSUPPORTED, "this program was built without Embree");
}

tulle_status render_find_sights(render_context *context, const render_frame_def *def,
                                size_t wanted_count, render_sight *sights, size_t sight_count,
                                tulle_error *error) {
    (void)context, (void)def, (void)wanted_count, (void)sights, (void)sight_count;
    return error_set(error, TULLE_ERROR_UNSUPPORTED, "this program was built without Embree");
}
