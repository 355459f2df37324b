/* Animations and caches with damage: every truncation, flipped bit and failing allocation. */
#define _XOPEN_SOURCE 700
#include "io/animation/everything.h"

#include "tulle_io/cache.h"

static void damage_is_found(void **state) {
    (void)state;
    make_sample(3, 3);
    made.vertex_count = 4;
    made.triangle_count = 2;
    for (int i = 0; i < 6; i++) made.triangles[i] %= 4;
    assert_int_equal(write_sample(test_path("small.glb"), NULL), TULLE_OK);
    write_everything(test_path("all.gltf"));
    static const char *const names[] = {"small.glb", "all.gltf"};
    for (int i = 0; i < 2; i++) {
        size_t size = 0;
        char *const bytes = get_file(test_path(names[i]), &size);
        for (size_t cut = 0; cut < size; cut++) try_bytes(test_path(names[i]), bytes, cut);
        for (size_t bit = 0; bit < 8 * size; bit++) {
            bytes[bit / 8] ^= (char)(1 << bit % 8);
            try_bytes(test_path(names[i]), bytes, size);
            bytes[bit / 8] ^= (char)(1 << bit % 8);
        }
        free(bytes);
    }
}

/* The size of an MDD file is the one that its counts say, so no part of one is one. */
static void damaged_caches_are_found(void **state) {
    (void)state;
    make_sample(4, 3);
    const char *const path = test_path("a.mdd");
    assert_int_equal(write_sample(path, NULL), TULLE_OK);
    size_t size = 0;
    char *const bytes = get_file(path, &size);
    for (size_t step = 0; step <= 9 * size; step++) {
        size_t const bit = step - size, kept = step < size ? step : size;
        if (step >= size && bit < 8 * size) bytes[bit / 8] ^= (char)(1 << bit % 8);
        put_file(path, bytes, kept);
        if (step >= size && bit < 8 * size) bytes[bit / 8] ^= (char)(1 << bit % 8);
        tulle_pc2 *cache = NULL;
        tulle_pc2_info info;
        tulle_error error = {0};
        double positions[3 * VERTEX_MAX];
        tulle_status status = tulle_pc2_open(path, &cache, &info, &error);
        assert_int_equal(status, step < size || bit < 64 ? TULLE_ERROR_PARSE : TULLE_OK);
        if (status) assert_true(strncmp(error.message, "byte ", 5) == 0);
        for (uint32_t f = 0; cache && f < 3; f++) {
            status = tulle_pc2_read_frame(cache, f, positions, &error);
            assert_true(status == TULLE_OK || status == TULLE_ERROR_PARSE);
            for (size_t i = 0; bit == 8 * size && i < 3 * made.vertex_count; i++)
                assert_true(positions[i] == (double)made.positions[f][i]);
        }
        tulle_pc2_close(cache);
    }
    free(bytes);
}

static void every_failing_allocation(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    size_t const size = write_everything(test_path("all.gltf"));
    long fail = 0;
    while (read_and_judge(test_path("all.gltf"), size, fail) == TULLE_ERROR_OUT_OF_MEMORY) fail++;
    assert_true(fail > 10);
    assert_int_equal(read_and_judge(test_path("all.gltf"), size, fail), TULLE_OK);
    static const char *const names[] = {"out.glb", "out.gltf", "out.usda", "out.mdd", "out.npz"};
    make_sample(3, 3);
    for (int i = 0; i < 5; i++) {
        tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
        for (fail = 0; status == TULLE_ERROR_OUT_OF_MEMORY; fail++) {
            assert_true(fail < 200);
            watch_heap(fail);
            status = write_sample(test_path(names[i]), NULL);
            unwatch_heap();
            assert_int_equal(access(test_path(names[i]), F_OK) == 0, status == TULLE_OK);
        }
        assert_int_equal(status, TULLE_OK);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damage_is_found),
        cmocka_unit_test(damaged_caches_are_found),
        cmocka_unit_test(every_failing_allocation),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
