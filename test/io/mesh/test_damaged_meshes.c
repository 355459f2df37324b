/* Damaged mesh files: every truncation, every flipped bit, garbage, headers that promise far too
 * much, and every failing allocation. A reader gives a mesh with valid indices and finite
 * coordinates or a clean error, in little memory. */
#define _XOPEN_SOURCE 700
#include "base/hash.h"
#include "io/bytes.h"

#include "io/failing_heap.h"
#include "io/io_support.h"
#include "tulle_io/mesh_files.h"

#include <math.h>
#include <stdbool.h>

/* Reads the file at `path`; checks what comes back; the status. */
static tulle_status read_and_judge(const char *path, size_t file_size, long fail) {
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    watch_heap(fail);
    tulle_status const status = tulle_mesh_read(path, &mesh, &error);
    unwatch_heap();
    assert_true(heap_largest <= 100 * file_size + 65536);
    if (status) {
        assert_true(error.message[0] != '\0');
        assert_int_equal(error.status, status);
        assert_null(mesh.positions);
    } else {
        assert_true(mesh.vertex_count > 0);
        for (size_t i = 0; i < 3 * mesh.vertex_count; i++) assert_true(isfinite(mesh.positions[i]));
        for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
            assert_true(mesh.triangles[i] < mesh.vertex_count);
    }
    tulle_mesh_destroy(&mesh);
    return status;
}

static tulle_status try_bytes(const char *name, const char *bytes, size_t size) {
    put_file(test_path(name), bytes, size);
    tulle_status const status = read_and_judge(test_path(name), size, -1);
    if (status != TULLE_OK && status != TULLE_ERROR_PARSE && status != TULLE_ERROR_LIMIT &&
        status != TULLE_ERROR_UNSUPPORTED)
        fail_msg("%s gave status %d", name, status);
    return status;
}

/* Each format's small file: a tetrahedron. */
typedef struct sample {
    char name[16];
    char *bytes;
    size_t size;
    bool is_binary;
} sample;
enum { SAMPLE_COUNT = 6 };
static sample samples[SAMPLE_COUNT];

static const double corners[] = {0, 0, 0, 1.5, 0, 0, 0, 1, 0, 0.25, 0, 1};
static const uint32_t faces[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

static void keep_sample(sample *kept, const char *name, bool is_binary) {
    snprintf(kept->name, sizeof kept->name, "%s", name);
    kept->bytes = get_file(test_path(name), &kept->size);
    kept->is_binary = is_binary;
}

static void write_ply_text(const char *path) {
    put_text(path, "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 4\nproperty list uchar int vertex_indices\n"
                   "end_header\n0 0 0\n1.5 0 0\n0 1 0\n.25 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n"
                   "3 2 0 3\n");
}

static void write_ply_big_endian(const char *path) {
    char bytes[1024] = "ply\nformat binary_big_endian 1.0\nelement other 2\nproperty list uchar "
                       "short a\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
                       "float z\nelement face 4\nproperty list uchar ushort vertex_indices\n"
                       "end_header\n";
    size_t count = strlen(bytes);
    memcpy(bytes + count, "\1\0\7\0", 4);
    count += 4;
    for (size_t i = 0; i < 12; i++, count += 4) {
        unsigned char little[4];
        bytes_store_float(little, (float)corners[i]);
        for (size_t k = 0; k < 4; k++) bytes[count + k] = (char)little[3 - k];
    }
    for (size_t i = 0; i < 12; i++) {
        if (i % 3 == 0) bytes[count++] = 3;
        bytes[count++] = 0;
        bytes[count++] = (char)faces[i];
    }
    put_file(path, bytes, count);
}

static void write_stl_text(const char *path) {
    char text[2048] = "solid t\n";
    for (size_t i = 0; i < 4; i++) {
        strcat(text, "facet normal 0 0 0\nouter loop\n");
        for (size_t k = 0; k < 3; k++) {
            const double *const p = corners + 3 * (size_t)faces[3 * i + k];
            sprintf(text + strlen(text), "vertex %g %g %g\n", p[0], p[1], p[2]);
        }
        strcat(text, "endloop\nendfacet\n");
    }
    strcat(text, "endsolid t\n");
    put_text(path, text);
}

static int make_samples(void **state) {
    if (make_test_folder(state)) return -1;
    tulle_mesh_view const mesh = {corners, 4, faces, 4};
    const char *const written[] = {"a.obj", "b.ply", "c.stl"};
    for (int i = 0; i < 3; i++) {
        if (tulle_mesh_write(test_path(written[i]), mesh, NULL)) return -1;
        keep_sample(&samples[i], written[i], i > 0);
    }
    write_ply_text(test_path("d.ply"));
    keep_sample(&samples[3], "d.ply", false);
    write_ply_big_endian(test_path("e.ply"));
    keep_sample(&samples[4], "e.ply", true);
    write_stl_text(test_path("f.stl"));
    keep_sample(&samples[5], "f.stl", false);
    return 0;
}

static int release_samples(void **state) {
    for (int i = 0; i < SAMPLE_COUNT; i++) free(samples[i].bytes);
    return remove_test_folder(state);
}

static void samples_are_sound(void **state) {
    (void)state;
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        put_file(test_path(samples[i].name), samples[i].bytes, samples[i].size);
        tulle_mesh mesh = {0};
        assert_int_equal(tulle_mesh_read(test_path(samples[i].name), &mesh, NULL), TULLE_OK);
        assert_int_equal(mesh.vertex_count, 4);
        assert_int_equal(mesh.triangle_count, 4);
        tulle_mesh_destroy(&mesh);
    }
}

static void every_truncation(void **state) {
    (void)state;
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        for (size_t size = 0; size < samples[i].size; size++) {
            tulle_status const status = try_bytes(samples[i].name, samples[i].bytes, size);
            /* A text may end early at a place where it is whole; bytes may not. */
            if (samples[i].is_binary) assert_int_equal(status, TULLE_ERROR_PARSE);
        }
    }
}

static void every_flipped_bit(void **state) {
    (void)state;
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        for (size_t bit = 0; bit < 8 * samples[i].size; bit++) {
            samples[i].bytes[bit / 8] ^= (char)(1 << bit % 8);
            try_bytes(samples[i].name, samples[i].bytes, samples[i].size);
            samples[i].bytes[bit / 8] ^= (char)(1 << bit % 8);
        }
    }
}

/* Random bytes, alone and after a sound beginning. */
static void garbage(void **state) {
    (void)state;
    uint64_t seed = 3;
    for (int round = 0; round < 600; round++) {
        const sample *const base = &samples[round % SAMPLE_COUNT];
        char bytes[4096];
        size_t const kept = round % 3 == 0 ? 0 : (size_t)(random_uniform(&seed) * 400.0);
        size_t const begin = kept < base->size ? kept : base->size;
        size_t const size = begin + 1 + (size_t)(random_uniform(&seed) * 3000.0);
        memcpy(bytes, base->bytes, begin);
        for (size_t i = begin; i < size; i++) bytes[i] = (char)random_next(&seed);
        try_bytes(base->name, bytes, size);
    }
}

/* Words of the formats in random order reach deeper than random bytes. */
static void shuffled_words(void **state) {
    (void)state;
    static const char *const words[] = {"v ",
                                        "f ",
                                        "1 ",
                                        "-1 ",
                                        "2/3 ",
                                        "\n",
                                        "\n",
                                        "\r\n",
                                        "0.5 ",
                                        "1e308 ",
                                        "-4e-300 ",
                                        "# ",
                                        "\\\n",
                                        "ply\n",
                                        "format ascii 1.0\n",
                                        "element vertex 1\n",
                                        "element face 3\n",
                                        "property float x\n",
                                        "property int y\n",
                                        "property double z\n",
                                        "property list uchar int vertex_indices\n",
                                        "end_header\n",
                                        "3 0 0 0\n",
                                        "solid\n",
                                        "facet normal 0 0 1\n",
                                        "outer loop\n",
                                        "vertex 0 1 2\n",
                                        "endloop\nendfacet\n",
                                        "endsolid\n",
                                        "99999999999999999999 ",
                                        "format binary_little_endian 1.0\n",
                                        "//1 "};
    uint64_t seed = 5;
    for (int round = 0; round < 3000; round++) {
        char text[4096] = "";
        size_t size = 0;
        for (int i = 0; i < 60; i++) {
            size_t const word =
                (size_t)(random_uniform(&seed) * (double)(sizeof words / sizeof words[0]));
            size += (size_t)sprintf(text + size, "%s", words[word]);
        }
        try_bytes(samples[round % SAMPLE_COUNT].name, text, size);
    }
}

/* Counts of 10^12 and more in headers cost neither memory nor time. */
static void huge_counts(void **state) {
    (void)state;
    static const char *const counts[] = {"5",          "1000000",       "2147483648",
                                         "4294967297", "1000000000000", "9223372036854775807"};
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (int i = 0; i < 3 * 6 * 3; i++) {
        char text[1024];
        const char *const count = counts[i % 6];
        int const place = i / 18;
        int const size = snprintf(
            text, sizeof text,
            "ply\nformat %s 1.0\nelement other %s\nproperty list uchar int l\nelement vertex %s\n"
            "property float x\nproperty float y\nproperty float z\nelement face %s\n"
            "property list uchar int vertex_indices\nend_header\n0 0 0\n1 2 3\n",
            formats[i / 6 % 3], place == 0 ? count : "0", place == 1 ? count : "1",
            place == 2 ? count : "0");
        tulle_status const status = try_bytes("huge.ply", text, (size_t)size);
        assert_true(status == TULLE_ERROR_PARSE || status == TULLE_ERROR_LIMIT);
    }
    char header[84 + 50] = {0};
    bytes_store(header + 80, 4, 0xffffffffu);
    assert_int_equal(try_bytes("huge.stl", header, sizeof header), TULLE_ERROR_PARSE);
}

static void every_failing_allocation(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        const char *const path = test_path(samples[i].name);
        put_file(path, samples[i].bytes, samples[i].size);
        long fail = 0;
        while (read_and_judge(path, samples[i].size, fail) == TULLE_ERROR_OUT_OF_MEMORY) fail++;
        assert_true(fail >= 3); /* the file, its vertices, its triangles at least */
        assert_int_equal(read_and_judge(path, samples[i].size, fail), TULLE_OK);
    }
}

static void every_failing_allocation_while_writing(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    tulle_mesh_view const mesh = {corners, 4, faces, 4};
    assert_int_equal(mkdir(test_path("out"), 0777), 0);
    const char *const path = test_path("out/a.obj");
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    for (long fail = 0; status == TULLE_ERROR_OUT_OF_MEMORY; fail++) {
        assert_true(fail < 100);
        watch_heap(fail);
        status = tulle_mesh_write(path, mesh, NULL);
        unwatch_heap();
        assert_int_equal(count_files(test_path("out")), status ? 0 : 1);
    }
    assert_int_equal(status, TULLE_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_sound),
        cmocka_unit_test(every_truncation),
        cmocka_unit_test(every_flipped_bit),
        cmocka_unit_test(garbage),
        cmocka_unit_test(shuffled_words),
        cmocka_unit_test(huge_counts),
        cmocka_unit_test(every_failing_allocation),
        cmocka_unit_test(every_failing_allocation_while_writing),
    };
    return cmocka_run_group_tests(tests, make_samples, release_samples);
}
