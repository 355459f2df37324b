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
    expect_refused(bytes, size, "positions.npy: its checksum differs");
    free(bytes);
}

/* ---- archives made by hand ---- */

typedef struct npz_bytes {
    unsigned char bytes[2048], directory[512];
    size_t size, directory_size, count;
} npz_bytes;

static uint32_t sum_bytes(const unsigned char *bytes, size_t size) {
    uint32_t sum = UINT32_MAX;
    for (size_t i = 0; i < 8 * size; i++) {
        uint32_t const bit = (sum ^ (uint32_t)bytes[i / 8] >> i % 8) & 1u;
        sum = sum >> 1 ^ (bit ? UINT32_C(0xedb88320) : 0u);
    }
    return ~sum;
}

static size_t put_number(unsigned char *to, uint64_t value, size_t size) {
    for (size_t i = 0; i < size; i++) to[i] = (unsigned char)(value >> 8 * i);
    return size;
}

/* The fields that a member's own head and its entry in the directory share. */
static size_t put_fields(unsigned char *to, uint32_t sum, size_t size, size_t name_size) {
    memset(to, 0, 26);
    to[0] = 20;
    put_number(to + 10, sum, 4);
    put_number(to + 14, size, 4);
    put_number(to + 18, size, 4);
    put_number(to + 22, name_size, 2);
    return 26;
}

/* An array of numbers of four bytes. */
static void put_array(npz_bytes *to, const char *name, const char *type, const char *shape,
                      const void *numbers, size_t count) {
    unsigned char content[512];
    char *const head = (char *)content + 10;
    memcpy(content, "\x93NUMPY\x01\0", 8);
    int const length = snprintf(
        head, 200, "{'descr': '%s', 'fortran_order': False, 'shape': %s, }\n", type, shape);
    put_number(content + 8, (uint64_t)length, 2);
    memcpy(head + length, numbers, 4 * count);
    size_t const size = 10 + (size_t)length + 4 * count, name_size = strlen(name);
    uint32_t const sum = sum_bytes(content, size);
    unsigned char *entry = to->directory + to->directory_size;
    memcpy(entry, "PK\1\2\x14\0", 6);
    put_fields(entry + 6, sum, size, name_size);
    memset(entry + 32, 0, 10);
    put_number(entry + 42, to->size, 4);
    memcpy(entry + 46, name, name_size);
    to->directory_size += 46 + name_size;
    unsigned char *own = to->bytes + to->size;
    memcpy(own, "PK\3\4", 4);
    put_fields(own + 4, sum, size, name_size);
    memcpy(own + 30, name, name_size);
    memcpy(own + 30 + name_size, content, size);
    to->size += 30 + name_size + size;
    to->count++;
}

/* Three vertices in one frame, and a triangle. */
static void make_archive(npz_bytes *to, const char *shape, const char *corners_shape,
                         int32_t corner) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    int32_t const corners[4] = {0, 1, corner, 0};
    *to = (npz_bytes){.size = 0};
    put_array(to, "positions.npy", "<f4", shape, positions, 9);
    put_array(to, "triangles.npy", "<i4", corners_shape, corners, 3);
    size_t const begin = to->size;
    memcpy(to->bytes + to->size, to->directory, to->directory_size);
    unsigned char *const end = to->bytes + to->size + to->directory_size;
    memset(end, 0, 22);
    memcpy(end, "PK\5\6", 4);
    put_number(end + 8, to->count, 2);
    put_number(end + 10, to->count, 2);
    put_number(end + 12, to->directory_size, 4);
    put_number(end + 16, begin, 4);
    to->size += to->directory_size + 22;
}

static void wrong_arrays_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *shape, *corners_shape;
        int32_t corner;
        const char *message;
    } cases[] = {{"(1, 3, 3)", "(1, 3)", 2, NULL},
                 {"(1, 3, 3,)", "(1L, 3)", 2, NULL},
                 {"(1, a, 3)", "(1, 3)", 2, "key 'shape' should be"},
                 {"(1, 1, 1, 3, 3)", "(1, 3)", 2, "key 'shape' should be"},
                 {"1, 3, 3", "(1, 3)", 2, "key 'shape' should be"},
                 {"(1, 3, 4)", "(1, 3)", 2, "not what its shape and type need"},
                 {"(1, 3, 3)", "(3, 1)", 2, "should be whole numbers, triangles x 3"},
                 {"(1, 3, 3)", "(1, 3)", 3, "triangle 0 uses vertex 3, but there are only 3"},
                 {"(1, 3, 3)", "(1, 3)", -1, "triangle 0 uses vertex -1"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        npz_bytes archive;
        make_archive(&archive, cases[i].shape, cases[i].corners_shape, cases[i].corner);
        if (cases[i].message) {
            expect_refused((const char *)archive.bytes, archive.size, cases[i].message);
            continue;
        }
        tulle_animation *animation = NULL;
        tulle_error error = {0};
        put_file(test_path("good.npz"), (const char *)archive.bytes, archive.size);
        if (tulle_animation_open(test_path("good.npz"), &animation, NULL, &error))
            fail_msg("case %zu: %s", i, error.message);
        assert_int_equal(tulle_animation_get_triangles(animation)[2], 2);
        tulle_animation_close(animation);
    }
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
        cmocka_unit_test(damage_is_found), cmocka_unit_test(wrong_arrays_are_refused),
        cmocka_unit_test(every_failing_allocation)};
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
