/* fuzz/targets/mdd.c - MDD point caches. */
#include "support/fuzz.h"

#include "tulle_io/animation.h"
#include "tulle_io/cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES_MAX = 8 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *const path = fuzz_put_file("cache.mdd", data, size);
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    tulle_error error = {0};
    tulle_status status = tulle_pc2_open(path, &cache, &info, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!cache && strcmp(error.file, path) == 0);
        return 0;
    }
    /* A cache without frames may speak of any number of vertices. */
    size_t const count = info.frame_count > 0 ? 3 * (size_t)info.vertex_count : 1;
    double *const positions = malloc(count * sizeof *positions);
    FUZZ_CHECK(positions);
    for (uint32_t frame = 0; frame < info.frame_count && frame < FRAMES_MAX; frame++) {
        double time = 0.0;
        status = tulle_pc2_get_time(cache, frame, &time, &error);
        if (status)
            fuzz_check_error(status, &error);
        else
            FUZZ_CHECK(isfinite(time));
        status = tulle_pc2_read_frame(cache, frame, positions, &error);
        if (status) fuzz_check_error(status, &error);
        for (size_t i = 0; !status && i < count; i++) FUZZ_CHECK(isfinite(positions[i]));
    }
    free(positions);
    tulle_pc2_close(cache);
    return 0;
}

static tulle_status read_seed(void *context, size_t surface, uint32_t frame, double *values,
                              tulle_error *error) {
    (void)context;
    (void)surface;
    (void)error;
    for (int i = 0; i < 12; i++) values[i] = i * 0.25 - frame;
    return TULLE_OK;
}

void fuzz_make_seeds(void) {
    static const double times[3] = {0, 0.5, 1};
    tulle_animation_surface const surface = {
        .name = "a", .mesh = {NULL, 4, NULL, 0}, .motion = TULLE_ANIMATION_DEFORMS};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.times = times;
    def.frame_count = 3;
    def.read = read_seed;
    tulle_error error = {0};
    const char *const path = fuzz_path("made.mdd");
    FUZZ_CHECK_OK(tulle_animation_write(path, &def, &error), &error);
    fuzz_put_file_seed("three_frames", path);
}
