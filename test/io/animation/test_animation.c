/* Animations: what is written as glTF comes back with the same bits; a file with everything that
 * moves vertices against sums by hand; what is refused. */
#define _XOPEN_SOURCE 700
#include "io/animation/everything.h"

static void gltf_comes_back(void **state) {
    (void)state;
    static const char *const paths[] = {"a.glb", "a b \xc3\xa9%20.gltf"};
    for (uint64_t seed = 1; seed <= 60; seed++)
        for (int i = 0; i < 2; i++) {
            make_sample(seed, 1 + (uint32_t)(seed % 6));
            assert_int_equal(write_sample(test_path(paths[i]), NULL), TULLE_OK);
            expect_sample(test_path(paths[i]));
        }
}

/* The .gltf names its .bin in a URI, in which such letters have other meanings. */
static void any_name_comes_back(void **state) {
    (void)state;
    static const char *const names[] = {"a:b.gltf", "..c..gltf", "d%2e #?&\"\\\n\xc3\xa9.GLTF"};
    tulle_error error = {0};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        make_sample(100 + i, 3);
        if (write_sample(test_path(names[i]), &error)) fail_msg("%s", error.message);
        expect_sample(test_path(names[i]));
    }
}

/* Beyond 1024 targets weights are sparse. */
static void many_targets_come_back(void **state) {
    (void)state;
    make_sample(7, FRAME_MAX);
    assert_int_equal(write_sample(test_path("many.glb"), NULL), TULLE_OK);
    struct stat facts;
    assert_int_equal(stat(test_path("many.glb"), &facts), 0);
    assert_true(facts.st_size < 4 * FRAME_MAX * FRAME_MAX);
    expect_sample(test_path("many.glb"));
}

/* A .glb ends at 4 GiB; that is known before a frame is read. */
static void too_large_files_are_refused(void **state) {
    (void)state;
    static double times[400];
    for (int i = 0; i < 400; i++) times[i] = i;
    tulle_animation_surface const surface = {
        .name = "a", .mesh = {NULL, 1000000, NULL, 0}, .motion = TULLE_ANIMATION_DEFORMS};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.times = times;
    def.frame_count = 400;
    def.read = read_sample;
    tulle_error error = {0};
    assert_int_equal(tulle_animation_write(test_path("large.glb"), &def, &error),
                     TULLE_ERROR_LIMIT);
    assert_non_null(strstr(error.message, "write a .gltf"));
    assert_int_not_equal(access(test_path("large.glb"), F_OK), 0);
}

/* ---- a file with everything that moves vertices ---- */

static void expect_point(const double *positions, size_t vertex, double x, double y, double z) {
    const double *const p = positions + 3 * vertex;
    if (fabs(p[0] - x) > 1e-6 || fabs(p[1] - y) > 1e-6 || fabs(p[2] - z) > 1e-6)
        fail_msg("vertex %zu is at %g %g %g, not %g %g %g", vertex, p[0], p[1], p[2], x, y, z);
}

static void everything_moves(void **state) {
    (void)state;
    write_everything(test_path("all.gltf"));
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    double p[24];
    if (tulle_animation_open(test_path("all.gltf"), &animation, &info, &error))
        fail_msg("%d:%d %s", error.line, error.column, error.message);
    assert_int_equal(info.vertex_count, 8);
    assert_int_equal(info.frame_count,
                     3 + info.added_frame_count); /* the turn, the spline, a step */
    uint32_t half_way = 0, last = info.frame_count - 1;
    while (tulle_animation_get_time(animation, half_way) < 0.5) half_way++;
    assert_true(tulle_animation_get_time(animation, half_way) == 0.5);
    assert_true(tulle_animation_get_time(animation, last) == 1.0);
    assert_string_equal(info.note,
                        "passed over: 1 parts of lines, all animations but the first, 1");
    static const uint32_t triangles[] = {0, 1, 2, 1, 3, 2, 4, 5, 6, 4, 6, 7};
    assert_int_equal(info.triangle_count, 4);
    const uint32_t *const found = tulle_animation_get_triangles(animation);
    for (int i = 0; i < 12; i++) /* the strip's indices are 0 1 2 3 */
        assert_int_equal(found[i], triangles[i]);
    /* At the start weights are 0 and 0; the matrix doubles and moves by 10. */
    assert_int_equal(tulle_animation_read_frame(animation, 0, p, &error), TULLE_OK);
    expect_point(p, 1, 12, 0, 0);
    expect_point(p, 2, 10, 2, 0);
    expect_point(p, 5, 1, 0, 0); /* the skin's node does not move it */
    /* Halfway: STEP keeps the weights, the rotation is an eighth of a turn, and the spline with
     * the slope 2 at its start and 0 at its end is at 2 * 0.125 + 0.5 * 4 = 2.25. */
    assert_int_equal(tulle_animation_read_frame(animation, half_way, p, &error), TULLE_OK);
    double const half = sqrt(0.5);
    expect_point(p, 1, 12 * half, 12 * half, 0);
    expect_point(p, 4, 0, 0, 0);
    expect_point(p, 5, 1 + 2.25 / 2, 0, 0);
    expect_point(p, 6, 2.25, 1, 0);
    /* At the end: weights 1 and 0.5, a quarter of a turn, joint 4 at 4. */
    assert_int_equal(tulle_animation_read_frame(animation, last, p, &error), TULLE_OK);
    expect_point(p, 1, 0, 12, 2);
    expect_point(p, 2, -2, 15, 2); /* sparse target: 2.5 along x before all else */
    expect_point(p, 7, 5, 1, 0);
    tulle_animation_close(animation);
}

/* Without keys the weights of the mesh hold. */
static void weights_without_keys_hold(void **state) {
    (void)state;
    static char text[16384];
    static const char channel[] = "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"weights\"}},";
    write_everything(test_path("all.gltf"));
    size_t size = 0;
    char *const all = get_file(test_path("all.gltf"), &size);
    assert_true(size < sizeof text);
    memcpy(text, all, size);
    free(all);
    char *const place = strstr(text, channel), *const weights = strstr(text, "\"weights\":[0,1]");
    assert_true(place && weights);
    memset(place, ' ', strlen(channel));
    memcpy(strchr(weights, '['), "[3,2]", 5);
    put_file(test_path("still.gltf"), text, size);
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    double p[24];
    if (tulle_animation_open(test_path("still.gltf"), &animation, NULL, &error))
        fail_msg("%d:%d %s", error.line, error.column, error.message);
    assert_int_equal(tulle_animation_read_frame(animation, 0, p, &error), TULLE_OK);
    expect_point(p, 1, 12, 0, 6); /* 3 times up by 1, doubled */
    expect_point(p, 2, 30, 2, 6); /* and 2 times along by 5 */
    tulle_animation_close(animation);
}

/* Corners as whole numbers of each size, which stand for -1 to 1 or 0 to 1. */
static void whole_numbers_stand_for_parts(void **state) {
    (void)state;
    static const struct {
        int type;
        size_t size;
        int64_t numbers[3];
        double x[3];
    } cases[] = {{5120, 1, {127, -128, -127}, {1.0, -1.0, -1.0}},
                 {5121, 1, {255, 51, 0}, {1.0, 0.2, 0.0}},
                 {5122, 2, {32767, -32768, 16384}, {1.0, -1.0, 16384.0 / 32767.0}},
                 {5123, 2, {65535, 13107, 0}, {1.0, 0.2, 0.0}}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned char bytes[24] = {0};
        char data[64], text[1024];
        for (int k = 0; k < 3; k++) /* the second corner; corners lie 8 bytes apart */
            for (size_t b = 0; b < cases[i].size; b++)
                bytes[8 + (size_t)k * cases[i].size + b] =
                    (unsigned char)((uint64_t)cases[i].numbers[k] >> 8 * b);
        bytes[16] = 1;
        encode(bytes, sizeof bytes, data);
        int const length = snprintf(
            text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":["
            "\"KHR_materials_unlit\",\"KHR_mesh_quantization\"],"
            "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
            "\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,"
            "\"componentType\":%d,\"normalized\":true,\"count\":3,\"type\":\"VEC3\"}],"
            "\"bufferViews\":[{\"buffer\":0,\"byteLength\":24,\"byteStride\":8}],\"buffers\":[{"
            "\"byteLength\":24,\"uri\":\"data:application/octet-stream;base64,%s\"}]}",
            cases[i].type, data);
        assert_true(length < (int)sizeof text);
        put_file(test_path("parts.gltf"), text, (size_t)length);
        tulle_animation *animation = NULL;
        tulle_error error = {0};
        double p[9];
        if (tulle_animation_open(test_path("parts.gltf"), &animation, NULL, &error))
            fail_msg("%d:%d %s", error.line, error.column, error.message);
        assert_int_equal(tulle_animation_read_frame(animation, 0, p, &error), TULLE_OK);
        expect_point(p, 0, 0.0, 0.0, 0.0);
        expect_point(p, 1, cases[i].x[0], cases[i].x[1], cases[i].x[2]);
        tulle_animation_close(animation);
    }
}

/* ---- what is refused ---- */

static void expect_refused(const char *from, const char *to, tulle_status status,
                           const char *message) {
    static char text[16384];
    size_t size = 0;
    char *const all = get_file(test_path("all.gltf"), &size);
    char *const copy = calloc(size + 1, 1);
    memcpy(copy, all, size);
    char *const place = strstr(copy, from);
    assert_non_null(place);
    int const length = snprintf(text, sizeof text, "%.*s%s%s", (int)(place - copy), copy, to,
                                place + strlen(from));
    put_file(test_path("bad.gltf"), text, (size_t)length);
    free(copy);
    free(all);
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    double p[24];
    tulle_status found = tulle_animation_open(test_path("bad.gltf"), &animation, NULL, &error);
    if (!found) found = tulle_animation_read_frame(animation, 0, p, &error);
    tulle_animation_close(animation);
    if (found != status || !strstr(error.message, message))
        fail_msg("%s: status %d, line %d: %s", to, found, error.line, error.message);
}

static void faults_are_told(void **state) {
    (void)state;
    write_everything(test_path("all.gltf"));
    expect_refused("\"2.0\"", "\"1.0\"", TULLE_ERROR_PARSE, "version \"1.0\"");
    expect_refused("\"scene\":0", "\"extensionsRequired\":[\"EXT_x\"],\"scene\":0",
                   TULLE_ERROR_UNSUPPORTED, "extension EXT_x");
    expect_refused("[0,2,3]", "[0,9,3]", TULLE_ERROR_PARSE, "no such node");
    expect_refused("\"children\":[4]", "\"children\":[3]", TULLE_ERROR_PARSE,
                   "children of each other");
    expect_refused("\"children\":[4]", "\"children\":[1]", TULLE_ERROR_PARSE, "two parents");
    expect_refused("\"mesh\":1", "\"mesh\":7", TULLE_ERROR_PARSE, "\"mesh\" is 7");
    expect_refused("\"indices\":6", "\"indices\":7", TULLE_ERROR_PARSE, "elements of 4 numbers");
    expect_refused("\"weights\":[0,1]", "\"weights\":[0]", TULLE_ERROR_PARSE, "should be 2");
    expect_refused("\"output\":4", "\"output\":0", TULLE_ERROR_PARSE, "needs 2 values of 4");
    expect_refused("\"count\":4", "\"count\":99", TULLE_ERROR_PARSE, "beyond the buffer view");
    expect_refused("\"byteLength\":36}],", "\"byteLength\":37}],", TULLE_ERROR_PARSE,
                   "beyond its buffer");
    expect_refused("data:;base64,AA", "data:;base64,A*", TULLE_ERROR_PARSE, "not in base64");
    static const char *const elsewhere[] = {"../../etc/x", "a/../../x", "%2e%2E/x", "%2fx",
                                            "/x",          "file:x",    "x%00"};
    for (size_t i = 0; i < sizeof elsewhere / sizeof elsewhere[0]; i++)
        expect_refused("data:;base64,AA", elsewhere[i], TULLE_ERROR_PARSE, "not in the folder");
    expect_refused("\"joints\":[3,4]", "\"joints\":[3]", TULLE_ERROR_PARSE, "hangs at joint 1");
    expect_refused("CUBICSPLINE", "CUBE", TULLE_ERROR_PARSE, "not known");
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_animation_open(test_path("none.glb"), &animation, NULL, &error),
                     TULLE_ERROR_IO);
    assert_int_equal(tulle_animation_open(test_path("all.abc"), &animation, NULL, &error),
                     TULLE_ERROR_UNSUPPORTED);
}

static void repeat(char **end, const char *text, int count) {
    for (int i = 0; i < count; i++) *end += sprintf(*end, "%s%s", i > 0 ? "," : "", text);
}

/* What is used in a file, and how often. */
typedef struct uses {
    int nodes, primitives, targets, vertices, times;
    tulle_status status;
} uses;
enum { USES_MANY = 4000, USES_KEYS = 20000 };

static size_t write_uses(uses count, char *text) {
    static unsigned char bytes[4 * USES_KEYS];
    static char data[6 * USES_KEYS], primitive[4 * USES_MANY];
    for (int i = 0; i < USES_KEYS; i++) bytes_store_float(bytes + 4 * (size_t)i, (float)i);
    encode(bytes, sizeof bytes, data);
    char *end = primitive + sprintf(primitive, "{\"attributes\":{\"POSITION\":0},\"targets\":[");
    repeat(&end, "{}", count.targets);
    sprintf(end, "]}");
    end = text + sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[");
    repeat(&end, "{\"mesh\":0}", count.nodes);
    end += sprintf(end, "],\"meshes\":[{\"primitives\":[");
    repeat(&end, primitive, count.primitives);
    end += sprintf(end,
                   "]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"buffers\":["
                   "{\"byteLength\":%zu,\"uri\":\"data:;base64,%s\"}],\"accessors\":["
                   "{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},"
                   "{\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"}",
                   sizeof bytes, sizeof bytes, data, count.vertices, USES_KEYS);
    for (int i = 0; i < count.times; i++)
        end += sprintf(
            end, ",{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"SCALAR\"}",
            USES_KEYS);
    end += sprintf(end, "],\"animations\":[{\"samplers\":[");
    for (int i = 0; i < count.times; i++)
        end += sprintf(end, "%s{\"input\":%d,\"output\":1}", i > 0 ? "," : "", 2 + i);
    end += sprintf(end, "],\"channels\":[");
    for (int i = 0; i < count.times; i++)
        end += sprintf(end, "%s{\"sampler\":%d,\"target\":{\"node\":0,\"path\":\"scale\"}}",
                       i > 0 ? "," : "", i);
    return (size_t)(end + sprintf(end, "]}]}") - text);
}

/* A small file whose parts use each other often is not to fill the memory. */
static void uses_are_limited(void **state) {
    (void)state;
    static const uses files[] = {{1, 1, 1, 1, 2, TULLE_OK},
                                 {1, USES_MANY, 1, 1, 1, TULLE_OK},
                                 {USES_MANY, 1, USES_MANY, 1, 1, TULLE_ERROR_LIMIT},
                                 {USES_MANY, USES_MANY, 1, 1, 1, TULLE_ERROR_LIMIT},
                                 {USES_MANY, USES_MANY, 1, 0, 1, TULLE_ERROR_LIMIT},
                                 {1, 1, 1, 1, USES_MANY, TULLE_ERROR_LIMIT}};
    static char text[1 << 20];
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        put_file(test_path("uses.gltf"), text, write_uses(files[i], text));
        tulle_animation *animation = NULL;
        tulle_error error = {0};
        tulle_status const status =
            tulle_animation_open(test_path("uses.gltf"), &animation, NULL, &error);
        tulle_animation_close(animation);
        if (status != files[i].status) fail_msg("file %zu: %d %s", i, status, error.message);
        if (status) assert_non_null(strstr(error.message, "times its size"));
    }
}

/* ---- USD ---- */

static void expect_text(const char *text, const char *part, int count) {
    int found = 0;
    for (const char *c = text; (c = strstr(c, part)); c++) found++;
    if (found != count) fail_msg("%d times %s, not %d:\n%s", found, part, count, text);
}

/* Names that become the same identifier get others, and not one that is there. */
static void usd_names_differ(void **state) {
    (void)state;
    static const char *const names[] = {"a_b__2__", "a_b", "a b", "a/b__2____2__", "\"\n\\\x01"};
    tulle_animation_surface surfaces[5];
    tulle_error error = {0};
    make_sample(3, 1);
    for (int i = 0; i < 5; i++)
        surfaces[i] = (tulle_animation_surface){.name = names[i],
                                                .mesh = {NULL, made.vertex_count, NULL, 0},
                                                .motion = TULLE_ANIMATION_STILL,
                                                .prototype = (size_t)i};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = surfaces;
    def.surface_count = 5;
    def.times = made.times;
    def.frame_count = 1;
    def.read = read_sample;
    if (tulle_animation_write(test_path("names.usda"), &def, &error)) fail_msg("%s", error.message);
    size_t size = 0;
    char *const text = get_file(test_path("names.usda"), &size);
    expect_text(text, "def Points \"a_b__2__\"", 1);
    expect_text(text, "def Points \"a_b\"", 1);
    expect_text(text, "def Points \"a_b__3__\"", 1);
    expect_text(text, "def Points \"a_b__2____2__\"", 1);
    expect_text(text, "def Points \"____\"", 1);
    expect_text(text, "displayName = \"\\\"\\n\\\\\\x01\"", 1);
    free(text);
}

/* A rigid surface whose prototype was left at 0 would show the mesh of surface 0. */
static void another_prototype_is_refused(void **state) {
    (void)state;
    static const double one[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                        other[9] = {0, 0, 0, 2, 0, 0, 0, 1, 0};
    static const uint32_t corners[3] = {0, 1, 2}, turned[3] = {0, 2, 1};
    static const double time = 0.0;
    tulle_animation_surface surfaces[2] = {
        {.name = "one", .mesh = {one, 3, corners, 1}, .motion = TULLE_ANIMATION_RIGID},
        {.name = "other", .mesh = {other, 3, corners, 1}, .motion = TULLE_ANIMATION_RIGID}};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = surfaces;
    def.surface_count = 2;
    def.times = &time;
    def.frame_count = 1;
    def.read = read_sample;
    tulle_error error = {0};
    for (int i = 0; i < 2; i++) { /* other corners, then the same in another order */
        error.message[0] = '\0';
        assert_int_equal(tulle_animation_write(test_path("prototype.gltf"), &def, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "other: its prototype, surface 0, has another mesh"));
        surfaces[1].mesh = (tulle_mesh_view){one, 3, turned, 1};
    }
}

/* Frames nearly at a whole time code are at it, but no two at the same. */
static void usd_times_differ(void **state) {
    (void)state;
    static const double times[] = {-1.0, -1e-9, 0.5, 1.0, 1.000000001, 1.000000002, 2.000000001};
    tulle_error error = {0};
    make_sample(5, 7);
    for (uint32_t i = 0; i < 7; i++) made.times[i] = times[i];
    tulle_animation_surface const surface = {.name = "points",
                                             .mesh = {NULL, made.vertex_count, NULL, 0},
                                             .motion = TULLE_ANIMATION_DEFORMS};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.times = made.times;
    def.frame_count = 7;
    def.frame_rate = 1.0;
    def.read = read_sample;
    if (tulle_animation_write(test_path("times.usda"), &def, &error)) fail_msg("%s", error.message);
    size_t size = 0;
    char *const text = get_file(test_path("times.usda"), &size);
    static const char *const codes[] = {" -1: [",          " 0: [",           " 0.5: [", " 1: [",
                                        " 1.000000001: [", " 1.000000002: [", " 2: ["};
    for (int i = 0; i < 7; i++) expect_text(text, codes[i], 3); /* extent, points, velocities */
    expect_text(text, " endTimeCode = 2\n", 1);
    free(text);
}

/* Some programs put a byte order mark before the JSON text. */
static void byte_order_marks_are_read(void **state) {
    (void)state;
    FILE *const file = fopen(test_path("mark.gltf"), "wb");
    assert_non_null(file);
    fputs("\xef\xbb\xbf{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": "
          "[0]}], "
          "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [{\"attributes\": "
          "{\"POSITION\": 0}}]}], \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, "
          "\"count\": 3, \"type\": \"VEC3\"}], \"bufferViews\": [{\"buffer\": 0, \"byteLength\": "
          "36}], "
          "\"buffers\": [{\"byteLength\": 36, \"uri\": \"data:application/octet-stream;base64,"
          "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA\"}]}",
          file);
    assert_int_equal(fclose(file), 0);
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    tulle_error error = {0};
    if (tulle_animation_open(test_path("mark.gltf"), &animation, &info, &error) != TULLE_OK)
        fail_msg("%d:%d: %s", error.line, error.column, error.message);
    assert_int_equal(info.vertex_count, 3);
    tulle_animation_close(animation);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(byte_order_marks_are_read),
        cmocka_unit_test(gltf_comes_back),
        cmocka_unit_test(any_name_comes_back),
        cmocka_unit_test(many_targets_come_back),
        cmocka_unit_test(too_large_files_are_refused),
        cmocka_unit_test(everything_moves),
        cmocka_unit_test(weights_without_keys_hold),
        cmocka_unit_test(whole_numbers_stand_for_parts),
        cmocka_unit_test(faults_are_told),
        cmocka_unit_test(uses_are_limited),
        cmocka_unit_test(usd_names_differ),
        cmocka_unit_test(another_prototype_is_refused),
        cmocka_unit_test(usd_times_differ),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
