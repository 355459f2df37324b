/* fuzz/support/animation.c - see animation.h. */
#include "support/animation.h"

#include "support/fuzz.h"

#include "tulle_io/animation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES_MAX = 4, VERTICES_MAX = 1 << 20 };

static void read_frames(tulle_animation *animation, const tulle_animation_info *info) {
    double *const positions = malloc(3 * info->vertex_count * sizeof *positions);
    FUZZ_CHECK(positions);
    for (uint32_t frame = 0; frame < info->frame_count && frame < FRAMES_MAX; frame++) {
        tulle_error error = {0};
        FUZZ_CHECK(isfinite(tulle_animation_get_time(animation, frame)));
        tulle_status const status = tulle_animation_read_frame(animation, frame, positions, &error);
        if (status) fuzz_check_error(status, &error);
        for (size_t i = 0; !status && i < 3 * info->vertex_count; i++)
            FUZZ_CHECK(isfinite(positions[i]));
    }
    free(positions);
}

void fuzz_read_animation(const char *name, const uint8_t *data, size_t size) {
    const char *const path = fuzz_put_file(name, data, size);
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    tulle_status const status = tulle_animation_open(path, &animation, &info, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!animation && error.file[0]);
        return;
    }
    FUZZ_CHECK(info.vertex_count > 0 && info.frame_count > 0);
    const uint32_t *const triangles = tulle_animation_get_triangles(animation);
    for (size_t i = 0; i < 3 * info.triangle_count; i++)
        FUZZ_CHECK(triangles[i] < info.vertex_count);
    if (info.vertex_count <= VERTICES_MAX) read_frames(animation, &info);
    tulle_animation_close(animation);
}

static tulle_status read_seed(void *context, size_t surface, uint32_t frame, double *values,
                              tulle_error *error) {
    (void)context;
    (void)error;
    static const double pose[7] = {0, 1, 0, 0.6, 0.8, 0, 0};
    static const double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    if (surface == 1) {
        memcpy(values, pose, sizeof pose);
        return TULLE_OK;
    }
    for (int i = 0; i < 12; i++) values[i] = square[i] + 0.25 * frame;
    return TULLE_OK;
}

void fuzz_make_animation_seed(const char *name, int has_poses) {
    static const double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    static const double times[3] = {0, 0.5, 1};
    tulle_animation_surface const surfaces[2] = {
        {.name = "a", .mesh = {square, 4, triangles, 2}, .motion = TULLE_ANIMATION_DEFORMS},
        {.name = "b",
         .mesh = {square, 4, triangles, 2},
         .motion = TULLE_ANIMATION_RIGID,
         .prototype = 1}};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = surfaces;
    def.surface_count = has_poses ? 2 : 1;
    def.times = times;
    def.frame_count = 3;
    def.read = read_seed;
    tulle_error error = {0};
    const char *const path = fuzz_path(name);
    FUZZ_CHECK_OK(tulle_animation_write(path, &def, &error), &error);
    fuzz_put_file_seed(has_poses ? "cloth_and_body" : "cloth", path);
}
