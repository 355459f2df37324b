/* A random animation for tests: written, read and compared; files with damage, judged. Include in
 * one file of the program only. */
#ifndef TULLE_TEST_ANIMATION_SAMPLE_H
#define TULLE_TEST_ANIMATION_SAMPLE_H

#include "base/hash.h"

#include "io/failing_heap.h"
#include "io/io_support.h"
#include "tulle_io/animation.h"

#include <math.h>
#include <stdbool.h>

enum { VERTEX_MAX = 24, FRAME_MAX = 1100 };

/* A random surface over time; its numbers are floats of all sizes. */
typedef struct sample {
    char name[32];
    size_t vertex_count, triangle_count;
    uint32_t frame_count;
    uint32_t triangles[6 * VERTEX_MAX];
    float positions[FRAME_MAX][3 * VERTEX_MAX];
    double times[FRAME_MAX];
} sample;
static sample made;

static inline double random_float(uint64_t *seed) {
    double const size = pow(10.0, 60.0 * random_uniform(seed) - 30.0);
    return (double)(float)((random_uniform(seed) - 0.5) * (random_next(seed) % 3 ? 2.0 : size));
}

static inline void make_sample(uint64_t seed, uint32_t frame_count) {
    static const char *const names[] = {"sheet", "a b", "\xc3\xa9\xe2\x82\xac \"x\\", "\t1", "_"};
    snprintf(made.name, sizeof made.name, "%s", names[random_next(&seed) % 5]);
    made.vertex_count = 1 + random_next(&seed) % VERTEX_MAX;
    made.triangle_count = random_next(&seed) % (2 * VERTEX_MAX);
    made.frame_count = frame_count;
    for (size_t i = 0; i < 3 * made.triangle_count; i++)
        made.triangles[i] = (uint32_t)(random_next(&seed) % made.vertex_count);
    double time = (double)(float)(random_uniform(&seed) * 3.0);
    for (uint32_t f = 0; f < frame_count; f++) {
        made.times[f] = time;
        time = (double)(float)(time + 0.01 + random_uniform(&seed));
        for (size_t i = 0; i < 3 * made.vertex_count; i++)
            made.positions[f][i] = (float)random_float(&seed);
    }
}

static inline tulle_status read_sample(void *context, size_t surface, uint32_t frame,
                                       double *values, tulle_error *error) {
    (void)context;
    (void)surface;
    (void)error;
    for (size_t i = 0; i < 3 * made.vertex_count; i++) values[i] = (double)made.positions[frame][i];
    return TULLE_OK;
}

static inline tulle_status write_sample(const char *path, tulle_error *error) {
    tulle_animation_surface const surface = {
        .name = made.name,
        .mesh = {NULL, made.vertex_count, made.triangles, made.triangle_count},
        .motion = TULLE_ANIMATION_DEFORMS,
        .color = {0.25, 0.5, 1.0}};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.times = made.times;
    def.frame_count = made.frame_count;
    def.read = read_sample;
    return tulle_animation_write(path, &def, error);
}

static inline void expect_sample(const char *path) {
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    double positions[3 * VERTEX_MAX];
    if (tulle_animation_open(path, &animation, &info, &error)) fail_msg("%s", error.message);
    assert_int_equal(info.vertex_count, made.vertex_count);
    assert_int_equal(info.triangle_count, made.triangle_count);
    assert_int_equal(info.frame_count, made.frame_count);
    if (made.triangle_count > 0)
        assert_memory_equal(tulle_animation_get_triangles(animation), made.triangles,
                            3 * made.triangle_count * sizeof(uint32_t));
    for (uint32_t f = 0; f < made.frame_count; f++) {
        if (made.frame_count > 1)
            assert_true(tulle_animation_get_time(animation, f) == made.times[f]);
        assert_int_equal(tulle_animation_read_frame(animation, f, positions, &error), TULLE_OK);
        for (size_t i = 0; i < 3 * made.vertex_count; i++)
            assert_true(positions[i] == (double)made.positions[f][i]);
    }
    tulle_animation_close(animation);
}

/* ---- damage ---- */

/* Reads the file and all its frames; checks what comes back; the status. */
static inline tulle_status read_and_judge(const char *path, size_t file_size, long fail) {
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    double positions[3 * 512];
    watch_heap(fail);
    tulle_status status = tulle_animation_open(path, &animation, &info, &error);
    if (status) assert_null(animation);
    for (uint32_t i = 0; !status && i < info.frame_count && info.vertex_count <= 512; i++) {
        status = tulle_animation_read_frame(animation, i, positions, &error);
        for (size_t k = 0; !status && k < 3 * info.vertex_count; k++)
            assert_true(isfinite(positions[k]));
    }
    unwatch_heap();
    assert_true(heap_largest <= 200 * file_size + 65536);
    for (size_t i = 0; animation && i < 3 * info.triangle_count; i++)
        assert_true(tulle_animation_get_triangles(animation)[i] < info.vertex_count);
    if (status && (error.message[0] == '\0' || error.status != status))
        fail_msg("status %d without a message", status);
    tulle_animation_close(animation);
    return status;
}

static inline void try_bytes(const char *path, const char *bytes, size_t size) {
    put_file(path, bytes, size);
    tulle_status const status = read_and_judge(path, size, -1);
    if (status != TULLE_OK && status != TULLE_ERROR_PARSE && status != TULLE_ERROR_LIMIT &&
        status != TULLE_ERROR_UNSUPPORTED && status != TULLE_ERROR_IO)
        fail_msg("%s gave status %d", path, status);
}

#endif
