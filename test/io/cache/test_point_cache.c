/* PC2 and VTK files: round trips, resuming, damaged and cut files, whole-or-nothing writing. */
#define _XOPEN_SOURCE 700
#include "base/hash.h"
#include "io/bytes.h"

#include "io/io_support.h"
#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>

enum { VERTEX_COUNT = 5, VALUE_COUNT = 3 * VERTEX_COUNT };

static void make_frame(double positions[VALUE_COUNT], int frame) {
    uint64_t seed = (uint64_t)frame + 100;
    for (int i = 0; i < VALUE_COUNT; i++) positions[i] = random_uniform(&seed) * 4.0 - 2.0;
}

static void assert_frame(tulle_pc2 *cache, uint32_t index, int frame) {
    double expected[VALUE_COUNT], read[VALUE_COUNT];
    make_frame(expected, frame);
    assert_int_equal(tulle_pc2_read_frame(cache, index, read, NULL), TULLE_OK);
    for (int i = 0; i < VALUE_COUNT; i++) assert_true(read[i] == (double)(float)expected[i]);
}

static void append_frames(const char *path, uint32_t resume, int first, int count) {
    tulle_pc2_writer *writer = NULL;
    assert_int_equal(tulle_pc2_writer_open(path, VERTEX_COUNT, resume, &writer, NULL), TULLE_OK);
    for (int i = first; i < first + count; i++) {
        if (i == first + 1) tulle_pc2_writer_defer_flush(writer); /* changes no byte */
        double positions[VALUE_COUNT];
        make_frame(positions, i);
        assert_int_equal(tulle_pc2_writer_append(writer, positions, NULL), TULLE_OK);
    }
    assert_int_equal(tulle_pc2_writer_close(writer, NULL), TULLE_OK);
}

static void assert_frames(const char *path, const int *frames, uint32_t count) {
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    assert_int_equal(tulle_pc2_open(path, &cache, &info, NULL), TULLE_OK);
    assert_int_equal(info.vertex_count, VERTEX_COUNT);
    assert_int_equal(info.frame_count, count);
    assert_true(info.start_frame == 0.0 && info.frame_step == 1.0);
    for (uint32_t i = 0; i < count; i++) assert_frame(cache, i, frames[i]);
    double positions[VALUE_COUNT];
    tulle_error error;
    assert_int_equal(tulle_pc2_read_frame(cache, count, positions, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_pc2_close(cache);
}

static void frames_come_back_as_floats(void **state) {
    (void)state;
    const char *const path = test_path("a.pc2");
    append_frames(path, 0, 0, 4);
    assert_frames(path, (int[]){0, 1, 2, 3}, 4);
    size_t size;
    char *const bytes = get_file(path, &size);
    assert_int_equal(size, 32 + 4 * VALUE_COUNT * 4);
    /* The layout that Blender's Mesh Cache modifier reads. */
    assert_memory_equal(bytes, "POINTCACHE2\0\1\0\0\0\5\0\0\0\0\0\0\0\0\0\200\77\4\0\0\0", 32);
    free(bytes);
}

static void resuming_keeps_and_drops(void **state) {
    (void)state;
    const char *const path = test_path("resumed.pc2");
    append_frames(path, 0, 0, 6);
    append_frames(path, 2, 10, 2);
    assert_frames(path, (int[]){0, 1, 10, 11}, 4);
    append_frames(path, 0, 20, 1); /* 0: starts anew */
    assert_frames(path, (int[]){20}, 1);
    tulle_pc2_writer *writer = NULL;
    tulle_error error;
    assert_int_equal(tulle_pc2_writer_open(path, VERTEX_COUNT, 2, &writer, &error),
                     TULLE_ERROR_PARSE);
    assert_null(writer);
    assert_int_equal(tulle_pc2_writer_open(path, VERTEX_COUNT + 1, 1, &writer, &error),
                     TULLE_ERROR_PARSE);
    assert_int_equal(tulle_pc2_writer_open(test_path("missing.pc2"), 5, 1, &writer, &error),
                     TULLE_ERROR_IO);
    assert_int_equal(tulle_pc2_writer_open(path, 0, 0, &writer, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_frames(path, (int[]){20}, 1);
}

/* A writer killed between data and header leaves bytes behind the last frame. */
static void bytes_behind_the_last_frame_do_not_count(void **state) {
    (void)state;
    const char *const path = test_path("torn.pc2");
    append_frames(path, 0, 0, 2);
    size_t size;
    char *const bytes = get_file(path, &size);
    char *const longer = calloc(1, size + 37);
    memcpy(longer, bytes, size);
    put_file(path, longer, size + 37);
    assert_frames(path, (int[]){0, 1}, 2);
    append_frames(path, 2, 2, 1);
    assert_frames(path, (int[]){0, 1, 2}, 3);
    free(bytes);
    free(longer);
}

/* Opens the bytes and reads all frames; any status but a crash is fine. */
static tulle_status try_bytes(const char *path, const char *bytes, size_t size) {
    put_file(path, bytes, size);
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    tulle_error error = {0};
    tulle_status status = tulle_pc2_open(path, &cache, &info, &error);
    if (!status && info.frame_count > 0) {
        assert_true((uint64_t)info.vertex_count * 12 * info.frame_count <= size);
        double *const positions = malloc((size_t)info.vertex_count * 24);
        for (uint32_t i = 0; i < info.frame_count && !status; i++)
            status = tulle_pc2_read_frame(cache, i, positions, &error);
        free(positions);
    }
    tulle_pc2_close(cache);
    if (status) assert_true(error.message[0] != '\0' && strcmp(error.file, path) == 0);
    return status;
}

/* First frame and step are floats: bytes 20 and 24. */
static void frames_are_numbered_by_finite_numbers(void **state) {
    (void)state;
    const char *const path = test_path("numbered.pc2");
    append_frames(path, 0, 0, 2);
    size_t size;
    char *const bytes = get_file(path, &size);
    float const numbers[] = {NAN, INFINITY, -INFINITY, -3.5F};
    for (size_t place = 20; place <= 24; place += 4)
        for (size_t i = 0; i < 4; i++) {
            char changed[4];
            memcpy(changed, bytes + place, 4);
            memcpy(bytes + place, &numbers[i], 4);
            assert_int_equal(try_bytes(path, bytes, size), i < 3 ? TULLE_ERROR_PARSE : TULLE_OK);
            memcpy(bytes + place, changed, 4);
        }
    free(bytes);
}

static void damaged_caches_are_refused_or_read(void **state) {
    (void)state;
    const char *const path = test_path("whole.pc2");
    append_frames(path, 0, 0, 2);
    size_t size;
    char *const bytes = get_file(path, &size);
    const char *const damaged = test_path("damaged.pc2");
    for (size_t length = 0; length < size; length++)
        assert_int_equal(try_bytes(damaged, bytes, length), TULLE_ERROR_PARSE);
    for (size_t bit = 0; bit < 8 * size; bit++) {
        bytes[bit / 8] ^= (char)(1 << bit % 8);
        tulle_status const status = try_bytes(damaged, bytes, size);
        if (bit < 8 * 16) assert_int_equal(status, TULLE_ERROR_PARSE); /* name and version */
        assert_true(status == TULLE_OK || status == TULLE_ERROR_PARSE);
        bytes[bit / 8] ^= (char)(1 << bit % 8);
    }
    bytes_store_float(bytes + 32, NAN);
    assert_int_equal(try_bytes(damaged, bytes, size), TULLE_ERROR_PARSE);
    free(bytes);
    tulle_pc2 *cache = NULL;
    assert_int_equal(tulle_pc2_open(test_path("none.pc2"), &cache, NULL, NULL), TULLE_ERROR_IO);
    assert_int_equal(tulle_pc2_open(test_folder, &cache, NULL, NULL), TULLE_ERROR_IO);
    assert_int_equal(tulle_pc2_open("/dev/zero", &cache, NULL, NULL), TULLE_ERROR_IO);
}

static void what_float_cannot_hold_is_refused(void **state) {
    (void)state;
    const char *const path = test_path("finite.pc2");
    append_frames(path, 0, 0, 1);
    tulle_pc2_writer *writer = NULL;
    assert_int_equal(tulle_pc2_writer_open(path, VERTEX_COUNT, 1, &writer, NULL), TULLE_OK);
    double const bad[] = {NAN, INFINITY, 1e39};
    for (int i = 0; i < 3; i++) {
        double positions[VALUE_COUNT];
        make_frame(positions, 1);
        positions[7] = bad[i];
        tulle_error error;
        assert_int_equal(tulle_pc2_writer_append(writer, positions, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "coordinate y of vertex 2"));
    }
    assert_int_equal(tulle_pc2_writer_close(writer, NULL), TULLE_OK);
    assert_frames(path, (int[]){0}, 1);
}

/* A file-size limit makes a write fail in the middle, as a full disk does. */
static void a_failed_append_leaves_the_frames_before(void **state) {
    (void)state;
    const char *const path = test_path("limited.pc2");
    append_frames(path, 0, 0, 2);
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 32 + 2 * 60 + 30; /* half of the third frame */
    tulle_pc2_writer *writer = NULL;
    assert_int_equal(tulle_pc2_writer_open(path, VERTEX_COUNT, 2, &writer, NULL), TULLE_OK);
    double positions[VALUE_COUNT];
    make_frame(positions, 2);
    tulle_error error;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    tulle_status const status = tulle_pc2_writer_append(writer, positions, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_int_equal(status, TULLE_ERROR_IO);
    assert_frames(path, (int[]){0, 1}, 2);
    assert_int_equal(tulle_pc2_writer_append(writer, positions, &error), TULLE_OK);
    assert_int_equal(tulle_pc2_writer_close(writer, NULL), TULLE_OK);
    assert_frames(path, (int[]){0, 1, 2}, 3);
}

static void files_appear_whole_or_not_at_all(void **state) {
    (void)state;
    const char *const folder = test_path("whole");
    assert_int_equal(mkdir(folder, 0777), 0);
    const char *const path = test_path("whole/file.txt");
    assert_int_equal(tulle_file_write(path, "first", 5, NULL), TULLE_OK);
    static char big[300000];
    memset(big, 'x', sizeof big);
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 100000;
    tulle_error error;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    tulle_status const status = tulle_file_write(path, big, sizeof big, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_int_equal(status, TULLE_ERROR_IO);
    assert_string_equal(error.file, path);
    assert_int_equal(count_files(folder), 1);
    size_t size;
    char *bytes = get_file(path, &size);
    assert_string_equal(bytes, "first");
    free(bytes);
    assert_int_equal(tulle_file_write(path, big, sizeof big, &error), TULLE_OK);
    bytes = get_file(path, &size);
    assert_int_equal(size, sizeof big);
    free(bytes);
    assert_int_equal(count_files(folder), 1);
}

static void a_full_device_is_told(void **state) {
    (void)state;
    tulle_error error;
    if (access("/dev/full", W_OK) != 0) skip();
    assert_int_equal(tulle_file_write("/dev/full", "text", 4, &error), TULLE_ERROR_DISK_FULL);
    assert_string_equal(error.file, "/dev/full");
    struct stat facts;
    assert_int_equal(stat("/dev/full", &facts), 0);
    assert_true(S_ISCHR(facts.st_mode));
    assert_int_equal(tulle_file_write(test_path("no/such/folder"), "text", 4, &error),
                     TULLE_ERROR_IO);
    assert_int_equal(tulle_file_write(test_folder, "text", 4, &error), TULLE_ERROR_IO);
}

static void a_link_keeps_pointing_to_its_file(void **state) {
    (void)state;
    put_text(test_path("real.txt"), "old");
    assert_int_equal(symlink(test_path("real.txt"), test_path("link.txt")), 0);
    assert_int_equal(tulle_file_write(test_path("link.txt"), "new", 3, NULL), TULLE_OK);
    struct stat facts;
    assert_int_equal(lstat(test_path("link.txt"), &facts), 0);
    assert_true(S_ISLNK(facts.st_mode));
    size_t size;
    char *const bytes = get_file(test_path("real.txt"), &size);
    assert_string_equal(bytes, "new");
    free(bytes);
}

/* ---- VTK ---- */

static size_t decode_base64(const char *text, unsigned char *bytes) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t count = 0;
    uint32_t bits = 0;
    int held = 0;
    for (; *text && strchr(letters, *text); text++) {
        bits = bits << 6 | (uint32_t)(strchr(letters, *text) - letters);
        held += 6;
        if (held >= 8) bytes[count++] = (unsigned char)(bits >> (held -= 8));
    }
    return count;
}

/* Decodes the array of that name; returns the number of its bytes after the length. */
static size_t decode_array(const char *text, const char *name, unsigned char *bytes) {
    char start[64];
    snprintf(start, sizeof start, "Name=\"%s\"", name);
    const char *const array = strstr(text, start);
    assert_non_null(array);
    size_t const count = decode_base64(strchr(array, '>') + 2, bytes);
    assert_true(count >= 8);
    assert_int_equal(bytes_load(bytes, 8), count - 8);
    return count - 8;
}

static void polydata_holds_the_mesh(void **state) {
    (void)state;
    double positions[VALUE_COUNT], velocities[VALUE_COUNT];
    make_frame(positions, 1);
    make_frame(velocities, 2);
    uint32_t const triangles[] = {0, 1, 2, 2, 3, 4};
    tulle_mesh_view const mesh = {positions, VERTEX_COUNT, triangles, 2};
    const char *const path = test_path("mesh.vtp");
    assert_int_equal(tulle_vtp_write(path, mesh, velocities, NULL), TULLE_OK);
    size_t size;
    char *text = get_file(path, &size);
    unsigned char bytes[8 + sizeof positions + 8];
    assert_int_equal(decode_array(text, "Points", bytes), sizeof positions);
    for (int i = 0; i < VALUE_COUNT; i++)
        assert_true(bytes_to_double(bytes_load(bytes + 8 + 8 * i, 8)) == positions[i]);
    assert_int_equal(decode_array(text, "velocities", bytes), sizeof velocities);
    for (int i = 0; i < VALUE_COUNT; i++)
        assert_true(bytes_to_double(bytes_load(bytes + 8 + 8 * i, 8)) == velocities[i]);
    assert_int_equal(decode_array(text, "connectivity", bytes), 48);
    for (int i = 0; i < 6; i++) assert_int_equal(bytes_load(bytes + 8 + 8 * i, 8), triangles[i]);
    assert_int_equal(decode_array(text, "offsets", bytes), 16);
    assert_int_equal(bytes_load(bytes + 8, 8), 3);
    assert_int_equal(bytes_load(bytes + 16, 8), 6);
    free(text);
    assert_int_equal(tulle_vtp_write(path, mesh, NULL, NULL), TULLE_OK);
    text = get_file(path, &size);
    assert_null(strstr(text, "PointData"));
    free(text);
    uint32_t const outside[] = {0, 1, 5};
    tulle_mesh_view const wrong = {positions, VERTEX_COUNT, outside, 1};
    assert_int_equal(tulle_vtp_write(path, wrong, NULL, NULL), TULLE_ERROR_INVALID_MESH);
}

static void collection_names_files_and_times(void **state) {
    (void)state;
    const char *const path = test_path("all.pvd");
    assert_int_equal(tulle_pvd_write(path, (const char *[]){"a.vtp", "b&<\"'>.vtp"},
                                     (double[]){0.0, 0.1}, 2, NULL),
                     TULLE_OK);
    size_t size;
    char *const text = get_file(path, &size);
    assert_non_null(strstr(text, "<DataSet timestep=\"0\" group=\"\" part=\"0\" file=\"a.vtp\"/>"));
    assert_non_null(strstr(text, "timestep=\"0.1\" group=\"\" part=\"0\" "
                                 "file=\"b&amp;&lt;&quot;&apos;&gt;.vtp\"/>"));
    free(text);
}

int main(void) {
    signal(SIGXFSZ, SIG_IGN);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_come_back_as_floats),
        cmocka_unit_test(resuming_keeps_and_drops),
        cmocka_unit_test(bytes_behind_the_last_frame_do_not_count),
        cmocka_unit_test(frames_are_numbered_by_finite_numbers),
        cmocka_unit_test(damaged_caches_are_refused_or_read),
        cmocka_unit_test(what_float_cannot_hold_is_refused),
        cmocka_unit_test(a_failed_append_leaves_the_frames_before),
        cmocka_unit_test(files_appear_whole_or_not_at_all),
        cmocka_unit_test(a_full_device_is_told),
        cmocka_unit_test(a_link_keeps_pointing_to_its_file),
        cmocka_unit_test(polydata_holds_the_mesh),
        cmocka_unit_test(collection_names_files_and_times),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
