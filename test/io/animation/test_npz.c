/* NPZ that is read: what is written comes back with the same bits; what is refused; every
 * truncation, flipped bit and failing allocation. Archives of other types, orders and methods are
 * those of test/e2e/convert_round_trips.py. */
#define _XOPEN_SOURCE 700
#include "io/animation/animation_sample.h"

static void npz_comes_back(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 60; seed++) {
        make_sample(seed, 1 + (uint32_t)(seed % 6));
        made.positions[0][0] = -0.0f;
        assert_int_equal(write_sample(test_path("a.npz"), NULL), TULLE_OK);
        expect_sample(test_path("a.npz"));
        tulle_animation *animation = NULL;
        double positions[3 * VERTEX_MAX];
        assert_int_equal(tulle_animation_open(test_path("a.npz"), &animation, NULL, NULL), 0);
        assert_int_equal(tulle_animation_read_frame(animation, 0, positions, NULL), 0);
        assert_true(signbit(positions[0]) &&
                    tulle_animation_get_time(animation, 0) == made.times[0]);
        tulle_animation_close(animation);
    }
}

static void many_frames_come_back(void **state) {
    (void)state;
    make_sample(7, FRAME_MAX);
    assert_int_equal(write_sample(test_path("many.npz"), NULL), TULLE_OK);
    expect_sample(test_path("many.npz"));
}

static void expect_refused(const char *bytes, size_t size, const char *message) {
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    put_file(test_path("bad.npz"), bytes, size);
    tulle_status const status =
        tulle_animation_open(test_path("bad.npz"), &animation, NULL, &error);
    tulle_animation_close(animation);
    if (status != TULLE_ERROR_PARSE || !strstr(error.message, message) ||
        strcmp(error.file, test_path("bad.npz")) != 0)
        fail_msg("status %d: %s, not %s", status, error.message, message);
}

/* Every byte of the arrays counts: a sum stands for it. */
static void damage_is_found(void **state) {
    (void)state;
    make_sample(3, 2);
    made.vertex_count = 4;
    made.triangle_count = 2;
    for (int i = 0; i < 6; i++) made.triangles[i] %= 4;
    assert_int_equal(write_sample(test_path("small.npz"), NULL), TULLE_OK);
    size_t size = 0;
    char *const bytes = get_file(test_path("small.npz"), &size);
    for (size_t cut = 0; cut < size; cut++)
        expect_refused(bytes, cut, cut < 22 ? "no end record" : "");
    for (size_t bit = 0; bit < 8 * size; bit++) {
        bytes[bit / 8] ^= (char)(1 << bit % 8);
        try_bytes(test_path("bad.npz"), bytes, size);
        bytes[bit / 8] ^= (char)(1 << bit % 8);
    }
    char *positions = bytes;
    while (memcmp(positions, "NUMPY", 5) != 0) positions++;
    positions[60] ^= 1;
    expect_refused(bytes, size, "positions.npy: its sum is not the one");
    free(bytes);
}

static void every_failing_allocation(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    make_sample(3, 3);
    assert_int_equal(write_sample(test_path("m.npz"), NULL), TULLE_OK);
    struct stat facts;
    assert_int_equal(stat(test_path("m.npz"), &facts), 0);
    long fail = 0;
    size_t const size = (size_t)facts.st_size;
    while (read_and_judge(test_path("m.npz"), size, fail) == TULLE_ERROR_OUT_OF_MEMORY) fail++;
    assert_true(fail > 8);
    assert_int_equal(read_and_judge(test_path("m.npz"), size, fail), TULLE_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(npz_comes_back), cmocka_unit_test(many_frames_come_back),
        cmocka_unit_test(damage_is_found), cmocka_unit_test(every_failing_allocation)};
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
