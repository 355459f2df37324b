/* fuzz/targets/pc2.c - point caches: reading one, and going on with one. */
#include "support/fuzz.h"

#include "tulle_io/cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES_MAX = 8 /* that are read, of each end */ };

/* A frame is read with finite numbers only, or refused. */
static void read_frame(const tulle_pc2_info *info, tulle_pc2 *cache, uint32_t frame,
                       double *positions) {
    tulle_error error = {0};
    tulle_status const status = tulle_pc2_read_frame(cache, frame, positions, &error);
    if (status) fuzz_check_error(status, &error);
    for (size_t i = 0; !status && i < 3 * (size_t)info->vertex_count; i++)
        FUZZ_CHECK(isfinite(positions[i]));
}

static void read_frames(const char *path, const tulle_pc2_info *info, tulle_pc2 *cache) {
    tulle_error error = {0};
    /* A cache without frames may speak of any number of vertices. */
    size_t const vertex_count = info->frame_count > 0 ? info->vertex_count : 1;
    double *const positions = malloc(3 * vertex_count * sizeof *positions + 1);
    FUZZ_CHECK(positions);
    for (uint32_t i = 0; i < info->frame_count && i < FRAMES_MAX; i++) {
        read_frame(info, cache, i, positions);
        read_frame(info, cache, info->frame_count - 1 - i, positions);
    }
    fuzz_check_error(tulle_pc2_read_frame(cache, info->frame_count, positions, &error), &error);
    FUZZ_CHECK(strcmp(error.file, path) == 0);
    free(positions);
}

/* Keeps some frames of the file and appends one. */
static void resume(const char *path, const tulle_pc2_info *info, uint32_t kept) {
    tulle_pc2_writer *writer = NULL;
    tulle_error error = {0};
    tulle_status status = tulle_pc2_writer_open(path, info->vertex_count, kept, &writer, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!writer);
        return;
    }
    FUZZ_CHECK(kept <= info->frame_count);
    double *const positions = calloc(3 * (size_t)info->vertex_count + 1, sizeof *positions);
    FUZZ_CHECK(positions);
    tulle_pc2_writer_defer_flush(writer);
    FUZZ_CHECK_OK(tulle_pc2_writer_append(writer, positions, &error), &error);
    FUZZ_CHECK_OK(tulle_pc2_writer_close(writer, &error), &error);
    free(positions);
    tulle_pc2 *cache = NULL;
    tulle_pc2_info again;
    FUZZ_CHECK_OK(tulle_pc2_open(path, &cache, &again, &error), &error);
    FUZZ_CHECK(again.frame_count == kept + 1 && again.vertex_count == info->vertex_count);
    read_frames(path, &again, cache);
    tulle_pc2_close(cache);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_bytes bytes = {data, size, 0};
    uint32_t const kept = fuzz_take_below(&bytes, FRAMES_MAX);
    const char *const path = fuzz_put_file("cache.pc2", data + bytes.used, size - bytes.used);
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    tulle_error error = {0};
    tulle_status const status = tulle_pc2_open(path, &cache, &info, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!cache && strcmp(error.file, path) == 0);
        return 0;
    }
    read_frames(path, &info, cache);
    tulle_pc2_close(cache);
    if (info.vertex_count <= size) resume(path, &info, kept); /* else an empty cache of many */
    return 0;
}

void fuzz_make_seeds(void) {
    static const double positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1e30, -2.5, 1e-40};
    const char *const path = fuzz_path("made.pc2");
    tulle_pc2_writer *writer = NULL;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_pc2_writer_open(path, 4, 0, &writer, &error), &error);
    for (int i = 0; i < 3; i++)
        FUZZ_CHECK_OK(tulle_pc2_writer_append(writer, positions, &error), &error);
    FUZZ_CHECK_OK(tulle_pc2_writer_close(writer, &error), &error);
    /* As an input the file's bytes follow the number of frames that are kept; `P` keeps none. */
    fuzz_put_file_seed("three_frames_after_a_byte", path);
}
