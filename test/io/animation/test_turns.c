/* Turns in files that are read: vertices that go along lines from frame to frame stay within a
 * thousandth of the size of their arcs, in glTF and USD, with all interpolations; what goes along
 * lines has frames at its keys alone. */
#define _POSIX_C_SOURCE 200809L
#include "io/io_support.h"
#include "tulle_io/animation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;
enum { LOOKS = 2000 }; /* moments at which a path is looked at */

/* ---- what is expected ---- */

/* Where the vertex at (1, 0, 0) is at a part of the time between two keys. */
typedef void (*expected_path)(double part, double point[3]);

static void half_turn(double part, double point[3]) {
    point[0] = cos(PI * part);
    point[1] = sin(PI * part);
    point[2] = 0.0;
}

static void quarter_turn(double part, double point[3]) { half_turn(0.5 * part, point); }

static void mirrored_quarter(double part, double point[3]) {
    quarter_turn(part, point);
    for (int k = 0; k < 2; k++) point[k] = -point[k];
}

/* A quarter turn of a wheel that grows to twice its size, along x by 10. */
static void growing_wheel(double part, double point[3]) {
    quarter_turn(part, point);
    for (int k = 0; k < 3; k++) point[k] *= 1.0 + part;
    point[0] += 10.0 * part;
}

/* From (1, 0, 0) to (0, 1, 0). */
static void chord(double part, double point[3]) {
    point[0] = 1.0 - part;
    point[1] = part;
    point[2] = 0.0;
}

static void four_turns(double part, double point[3]) { half_turn(8.0 * part, point); }

/* About z, and along x by 10: a wheel. */
static void rolling(double part, double point[3]) {
    half_turn(part, point);
    point[0] += 10.0 * part;
}

static void line(double part, double point[3]) {
    point[0] = 1.0 + 10.0 * part;
    point[1] = point[2] = 0.0;
}

/* x goes from 1 to 2 by 3 s^2 - 2 s^3: a spline with tangents 0. */
static void eased(double part, double point[3]) {
    point[0] = 1.0 + part * part * (3.0 - 2.0 * part);
    point[1] = point[2] = 0.0;
}

/* Scale times a turn. */
static void growing(double part, double point[3]) {
    half_turn(part, point);
    for (int k = 0; k < 3; k++) point[k] *= 1.0 + part;
}

/* Reads all frames from `begin` to `end` seconds and compares the paths of vertex 0 with what is
 * expected; the largest extent of the mesh is `size`. Gives the number of frames. */
static uint32_t expect_path(const char *path, expected_path expected, const double span[2],
                            double size) {
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    if (tulle_animation_open(path, &animation, &info, &error)) fail_msg("%s", error.message);
    assert_string_equal(info.note, "");
    double *const frames = calloc(info.frame_count, 3 * info.vertex_count * sizeof *frames);
    assert_non_null(frames);
    for (uint32_t i = 0; i < info.frame_count; i++)
        assert_int_equal(
            tulle_animation_read_frame(animation, i, frames + 3 * info.vertex_count * i, &error),
            TULLE_OK);
    assert_true(tulle_animation_get_time(animation, 0) == span[0]);
    assert_true(tulle_animation_get_time(animation, info.frame_count - 1) == span[1]);
    uint32_t frame = 0;
    for (int look = 0; look <= LOOKS; look++) {
        double const time = span[0] + (span[1] - span[0]) * look / LOOKS;
        while (frame + 2 < info.frame_count &&
               tulle_animation_get_time(animation, frame + 1) < time)
            frame++;
        double const from = tulle_animation_get_time(animation, frame);
        double const to = tulle_animation_get_time(animation, frame + 1);
        assert_true(to > from);
        const double *const a = frames + 3 * info.vertex_count * frame;
        const double *const b = a + 3 * info.vertex_count;
        double point[3], off = 0.0;
        expected((double)look / LOOKS, point);
        for (int k = 0; k < 3; k++)
            off = hypot(off, a[k] + (time - from) / (to - from) * (b[k] - a[k]) - point[k]);
        if (!(off < 1e-3 * size))
            fail_msg("%s: at %g s the vertex is %g off its path, of a size of %g", path, time, off,
                     size);
    }
    free(frames);
    tulle_animation_close(animation);
    assert_int_equal(info.frame_count, 2 + info.added_frame_count);
    return info.frame_count;
}

/* ---- files ---- */

static void write_text(const char *path, const char *text) {
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

/* A square with the corner (1, 0, 0), 2 wide; `steps` moves it. */
static const char *write_usd(const char *steps) {
    static char text[1500];
    snprintf(
        text, sizeof text,
        "#usda 1.0\n(\n upAxis = \"Z\"\n metersPerUnit = 1\n timeCodesPerSecond = 2\n)\n"
        "def Mesh \"m\"\n{\n int[] faceVertexCounts = [4]\n"
        " int[] faceVertexIndices = [0, 1, 2, 3]\n uniform token subdivisionScheme = \"none\"\n"
        " point3f[] points = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]\n%s}\n",
        steps);
    const char *const path = test_path("t.usda");
    write_text(path, text);
    return path;
}

typedef struct gltf_channel_text {
    const char *path, *kind;
    size_t width;
    const float *values;
    size_t value_count; /* numbers */
} gltf_channel_text;

/* The same square in glTF, moved by channels with keys at 1 and 3 s. */
static const char *write_gltf(const gltf_channel_text *channels, size_t count) {
    static const float square[12] = {1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    static const float keys[2] = {1, 3};
    static char text[4000];
    unsigned char bytes[1000];
    size_t size = 0, at = 0;
    memcpy(bytes, square, sizeof square);
    memcpy(bytes + 48, corners, sizeof corners);
    memcpy(bytes + 72, keys, sizeof keys);
    size = 80;
    char accessors[1500], views[1000], samplers[500] = "", targets[500] = "";
    size_t a = (size_t)snprintf(
        accessors, sizeof accessors,
        "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"},"
        "{\"bufferView\":2,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"}");
    size_t v = (size_t)snprintf(views, sizeof views,
                                "{\"buffer\":0,\"byteLength\":48},"
                                "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":24},"
                                "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":8}");
    for (size_t i = 0; i < count; i++) {
        const gltf_channel_text *const c = &channels[i];
        memcpy(bytes + size, c->values, 4 * c->value_count);
        a += (size_t)snprintf(accessors + a, sizeof accessors - a,
                              ",{\"bufferView\":%zu,\"componentType\":5126,\"count\":%zu,"
                              "\"type\":\"VEC%zu\"}",
                              3 + i, c->value_count / c->width, c->width);
        v += (size_t)snprintf(views + v, sizeof views - v,
                              ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", size,
                              4 * c->value_count);
        size_t const s = strlen(samplers), t = strlen(targets);
        snprintf(samplers + s, sizeof samplers - s,
                 "%s{\"input\":2,\"output\":%zu,\"interpolation\":\"%s\"}", i > 0 ? "," : "", 3 + i,
                 c->kind);
        snprintf(targets + t, sizeof targets - t,
                 "%s{\"sampler\":%zu,\"target\":{\"node\":0,\"path\":\"%s\"}}", i > 0 ? "," : "", i,
                 c->path);
        size += 4 * c->value_count;
    }
    at = (size_t)snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":"
        "[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"accessors\":[%s],\"bufferViews\":"
        "[%s],\"animations\":[{\"samplers\":[%s],\"channels\":[%s]}],\"buffers\":[{\"byteLength\":"
        "%zu,\"uri\":\"t.bin\"}]}",
        accessors, views, samplers, targets, size);
    assert_true(at < sizeof text);
    FILE *const file = fopen(test_path("t.bin"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    const char *const path = test_path("t.gltf");
    write_text(path, text);
    return path;
}

#define CHANNEL(path, kind, width, ...)                                                            \
    { path, kind, width, (const float[]){__VA_ARGS__}, sizeof((float[]){__VA_ARGS__}) / 4 }
#define GLTF(...)                                                                                  \
    write_gltf((const gltf_channel_text[]){__VA_ARGS__},                                           \
               sizeof((gltf_channel_text[]){__VA_ARGS__}) / sizeof(gltf_channel_text))

static const double span[2] = {1.0, 3.0};

/* ---- tests ---- */

static void test_gltf(void **state) {
    (void)state;
    uint32_t const turns = expect_path(
        GLTF(CHANNEL("rotation", "LINEAR", 4, 0, 0, 0, 1, 0, 0, 1, 0)), half_turn, span, 2.0);
    assert_in_range(turns, 20, 60);
    expect_path(GLTF(CHANNEL("rotation", "LINEAR", 4, 0, 0, 0, 1, 0, 0, 1, 0),
                     CHANNEL("translation", "LINEAR", 3, 0, 0, 0, 10, 0, 0)),
                rolling, span, 2.0);
    expect_path(GLTF(CHANNEL("rotation", "LINEAR", 4, 0, 0, 0, 1, 0, 0, 1, 0),
                     CHANNEL("scale", "LINEAR", 3, 1, 1, 1, 2, 2, 2)),
                growing, span, 2.0);
    expect_path(GLTF(CHANNEL("translation", "CUBICSPLINE", 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1,
                             0, 0, 0, 0, 0)),
                eased, span, 2.0);
    /* Along a line there are the keys alone, and so where a turn turns nothing. */
    assert_int_equal(
        expect_path(GLTF(CHANNEL("translation", "LINEAR", 3, 0, 0, 0, 10, 0, 0)), line, span, 2.0),
        2);
    assert_int_equal(expect_path(GLTF(CHANNEL("translation", "LINEAR", 3, 0, 0, 0, 10, 0, 0),
                                      CHANNEL("rotation", "LINEAR", 4, 0, 0, 0, 1, 0, 0, 0, 1)),
                                 line, span, 2.0),
                     2);
}

/* A step is held until the next key, where the vertex jumps. */
static void test_steps(void **state) {
    (void)state;
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    const char *const path = GLTF(CHANNEL("translation", "STEP", 3, 0, 0, 0, 10, 0, 0));
    assert_int_equal(tulle_animation_open(path, &animation, &info, &error), TULLE_OK);
    assert_int_equal(info.frame_count, 3);
    assert_int_equal(info.added_frame_count, 1);
    double const times[3] = {1.0, (double)nextafterf(3.0f, 0.0f), 3.0}, places[3] = {1, 1, 11};
    for (uint32_t i = 0; i < 3; i++) {
        double positions[12];
        assert_true(tulle_animation_get_time(animation, i) == times[i]);
        assert_int_equal(tulle_animation_read_frame(animation, i, positions, &error), TULLE_OK);
        assert_true(positions[0] == places[i]);
    }
    tulle_animation_close(animation);
}

#define ORDER(names) " uniform token[] xformOpOrder = [" names "]\n"

static void test_usd(void **state) {
    (void)state;
    expect_path(write_usd(" double xformOp:rotateZ.timeSamples = { 2: 0, 6: 180 }\n" ORDER(
                    "\"xformOp:rotateZ\"")),
                half_turn, span, 2.0);
    /* At both keys, and half way, all is where it was. */
    expect_path(write_usd(" double xformOp:rotateZ.timeSamples = { 2: 0, 6: 1440 }\n" ORDER(
                    "\"xformOp:rotateZ\"")),
                four_turns, span, 2.0);
    expect_path(write_usd(" quatf xformOp:orient.timeSamples = { 2: (1, 0, 0, 0), 6: (0, 0, 0, 1) "
                          "}\n" ORDER("\"xformOp:orient\"")),
                half_turn, span, 2.0);
    expect_path(write_usd(" float3 xformOp:rotateXYZ.timeSamples = { 2: (0, 0, 0), 6: (0, 0, 180) "
                          "}\n double3 xformOp:translate.timeSamples = { 2: (0, 0, 0), 6: (10, 0, "
                          "0) }\n" ORDER("\"xformOp:translate\", \"xformOp:rotateXYZ\"")),
                rolling, span, 2.0);
    expect_path(
        write_usd(" double xformOp:rotateZ.timeSamples = { 2: 0, 6: 180 }\n"
                  " float3 xformOp:scale.timeSamples = { 2: (1, 1, 1), 6: (2, 2, 2) }\n" ORDER(
                      "\"xformOp:rotateZ\", \"xformOp:scale\"")),
        growing, span, 2.0);
    assert_int_equal(
        expect_path(write_usd(" double3 xformOp:translate.timeSamples = { 2: (0, 0, 0), 6: (10, 0, "
                              "0) }\n" ORDER("\"xformOp:translate\"")),
                    line, span, 2.0),
        2);
}

#define MATRICES(from, to)                                                                         \
    write_usd(" matrix4d xformOp:transform.timeSamples = { 2: (" from "), 6: (" to                 \
              ") }\n" ORDER("\"xformOp:transform\""))

/* Matrices that do not shear are poses; all others go number by number. */
static void test_matrices(void **state) {
    (void)state;
    uint32_t const turns =
        expect_path(MATRICES("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)",
                             "(0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)"),
                    quarter_turn, span, 2.0);
    assert_in_range(turns, 10, 30);
    expect_path(MATRICES("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)",
                         "(0, 2, 0, 0), (-2, 0, 0, 0), (0, 0, 2, 0), (10, 0, 0, 1)"),
                growing_wheel, span, 2.0);
    expect_path(MATRICES("(-1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)",
                         "(0, -1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)"),
                mirrored_quarter, span, 2.0);
    /* Through a plane, and where one of them shears. */
    expect_path(MATRICES("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)",
                         "(0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, -1, 0), (0, 0, 0, 1)"),
                chord, span, 2.0);
    expect_path(MATRICES("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)",
                         "(0, 1, 0, 0), (-1, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)"),
                chord, span, 2.0);
    assert_int_equal(
        expect_path(MATRICES("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)",
                             "(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (10, 0, 0, 1)"),
                    line, span, 2.0),
        2);
}

/* Half a turn about each axis goes along an arc, which way is told to be a guess. */
static void test_half_turned_matrices(void **state) {
    (void)state;
    static const char *const rows[3] = {"(1, 0, 0, 0), (0, -1, 0, 0), (0, 0, -1, 0)",
                                        "(-1, 0, 0, 0), (0, 1, 0, 0), (0, 0, -1, 0)",
                                        "(-1, 0, 0, 0), (0, -1, 0, 0), (0, 0, 1, 0)"};
    for (int axis = 0; axis < 3; axis++) {
        char text[500];
        tulle_animation *animation = NULL;
        tulle_animation_info info;
        tulle_error error = {0};
        (void)snprintf(text, sizeof text,
                       " matrix4d xformOp:transform.timeSamples = {\n  2: ((1, 0, 0, 0), (0, 1, 0, "
                       "0), (0, 0, 1, 0), (0, 0, 0, 1)),\n  6: (%s, (0, 0, 0, 1)) }\n" ORDER(
                           "\"xformOp:transform\""),
                       rows[axis]);
        assert_int_equal(tulle_animation_open(write_usd(text), &animation, &info, &error),
                         TULLE_OK);
        assert_string_equal(info.note,
                            "passed over: a turn of half a circle between two matrices, as in "
                            "line 15, has no direction; add a sample between them");
        for (uint32_t i = 0; i < info.frame_count; i++) {
            double p[12];
            assert_int_equal(tulle_animation_read_frame(animation, i, p, &error), TULLE_OK);
            double const width = hypot(hypot(p[0] - p[6], p[1] - p[7]), p[2] - p[8]);
            assert_true(fabs(width - 2.0) < 1e-12);
        }
        tulle_animation_close(animation);
    }
}

static void test_instances(void **state) {
    (void)state;
    const char *const path = test_path("i.usda");
    write_text(path,
               "#usda 1.0\n(\n upAxis = \"Z\"\n metersPerUnit = 1\n timeCodesPerSecond = 2\n)\n"
               "def PointInstancer \"p\"\n{\n int[] protoIndices = [0]\n rel prototypes = </p/m>\n"
               " point3f[] positions = [(0, 0, 0)]\n"
               " quath[] orientations.timeSamples = { 2: [(1, 0, 0, 0)], 6: [(0, 0, 0, 1)] }\n"
               " def Mesh \"m\"\n {\n int[] faceVertexCounts = [3]\n"
               " int[] faceVertexIndices = [0, 1, 2]\n uniform token subdivisionScheme = \"none\"\n"
               " point3f[] points = [(1, 0, 0), (-1, 0, 0), (0, 0, 1)]\n }\n}\n");
    expect_path(path, half_turn, span, 2.0);
}

/* So many turns that they are not followed: told. */
static void test_too_fast(void **state) {
    (void)state;
    const char *const path =
        write_usd(" double xformOp:rotateZ.timeSamples = { 2: 0, 6: 1e9, 8: 1000000090 }\n" ORDER(
            "\"xformOp:rotateZ\""));
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    assert_int_equal(tulle_animation_open(path, &animation, &info, &error), TULLE_OK);
    assert_string_equal(info.note,
                        "passed over: the arcs of turns that need more than 65536 frames");
    assert_true(info.frame_count == 3 + info.added_frame_count);
    tulle_animation_close(animation);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gltf),
        cmocka_unit_test(test_steps),
        cmocka_unit_test(test_usd),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_too_fast),
        cmocka_unit_test(test_matrices),
        cmocka_unit_test(test_half_turned_matrices),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
