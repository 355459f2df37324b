/* The surfaces of animations: which way they face where transforms mirror them, faces that are left
 * out, polygons, classes that are not there, buffers behind links. */
#define _XOPEN_SOURCE 700
#include "io/bytes.h"

#include "io/animation/animation_sample.h"

static tulle_animation *open_text(const char *path, const char *text, tulle_animation_info *info) {
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    put_file(path, text, strlen(text));
    if (tulle_animation_open(path, &animation, info, &error))
        fail_msg("%d:%d %s\n%s", error.line, error.column, error.message, text);
    return animation;
}

/* Of the surface in its last frame: above 0 where it faces outwards. */
static double measure_volume(const char *path, const char *text) {
    enum { MOST = 64 };
    tulle_animation_info info;
    tulle_animation *const animation = open_text(path, text, &info);
    const uint32_t *const t = tulle_animation_get_triangles(animation);
    double x[3 * MOST], sum = 0.0;
    tulle_error error = {0};
    assert_true(info.vertex_count <= MOST && info.triangle_count > 0);
    if (tulle_animation_read_frame(animation, info.frame_count - 1, x, &error))
        fail_msg("%s", error.message);
    for (size_t i = 0; i < info.triangle_count; i++) {
        const double *const a = x + 3 * t[3 * i], *const b = x + 3 * t[3 * i + 1],
                            *const c = x + 3 * t[3 * i + 2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    tulle_animation_close(animation);
    return sum / 6.0;
}

/* ---- USD ---- */

/* A tetrahedron of volume 1/6, which faces outwards. */
#define POINTS "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]\n"
#define COUNTS "int[] faceVertexCounts = [3, 3, 3, 3]\n"
#define OUTWARD "int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]\n"
#define INWARD "int[] faceVertexIndices = [1, 2, 0, 3, 1, 0, 2, 3, 0, 3, 2, 1]\n"
#define MESH(more) "def Mesh \"m\"\n{\n" POINTS COUNTS OUTWARD more "}\n"
#define SCALE(x) "double3 xformOp:scale = (" x ")\n"
#define ORDER(op) "uniform token[] xformOpOrder = [\"xformOp:" op "\"]\n"
#define MIRROR SCALE("-1, 1, 1") ORDER("scale")
#define LEFT "uniform token orientation = \"leftHanded\"\n"
#define INSTANCES(scales, more)                                                                    \
    "def PointInstancer \"i\"\n{\nrel prototypes = </i/m>\nint[] protoIndices = [0]\n"             \
    "point3f[] positions = [(5, 0, 0)]\nfloat3[] scales = [(" scales ")]\n" more                   \
    "def Mesh \"m\" {\n" POINTS COUNTS OUTWARD "}\n}\n"

static void mirrors_of_usd_turn_surfaces_round(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double volume; /* in sixths */
    } cases[] = {
        {MESH(""), 1},
        {MESH(MIRROR), 1},
        {MESH(SCALE("-1, -1, 1") ORDER("scale")), 1},
        {MESH(SCALE("-1, -1, -2") ORDER("scale")), 2},
        {MESH("matrix4d xformOp:transform = ((0, 1, 0, 0), (1, 0, 0, 0), (0, 0, 1, 0), (7, 0, 0, "
              "1))\n" ORDER("transform")),
         1},
        {"def Xform \"a\"\n{\n" MIRROR MESH("") "}\n", 1},
        {"def Xform \"a\"\n{\n" MIRROR MESH(MIRROR) "}\n", 1},
        {"def \"a\" ( references = </m> )\n{\n" MIRROR "}\n" MESH(""), 2},
        {"class \"c\"\n{\n" MESH("") "}\ndef Xform \"a\" ( inherits = </c> )\n{\n" MIRROR "}\n", 1},
        {INSTANCES("-1, 1, 1", ""), 1},
        {INSTANCES("-1, 1, 1", MIRROR), 1},
        {INSTANCES("1, 2, 1", MIRROR), 2},
        {"def Mesh \"m\"\n{\n" POINTS COUNTS INWARD LEFT "}\n", 1},
        {"def Mesh \"m\"\n{\n" POINTS COUNTS INWARD LEFT MIRROR "}\n", 1},
        {MESH(LEFT MIRROR), -1}, /* so it is told */
        {"def \"a\" ( references = </m> )\n{\n" LEFT "}\n" MESH(""), 0},
        {MESH(
             "float3 xformOp:scale.timeSamples = { 0: (0, 0, 0), 1: (-1, 1, 1) }\n" ORDER("scale")),
         1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[2048];
        (void)snprintf(text, sizeof text, "#usda 1.0\n%s", cases[i].text);
        double const volume = measure_volume(test_path("m.usda"), text);
        if (fabs(volume - cases[i].volume / 6.0) > 1e-6)
            fail_msg("%g, not %g sixths, of\n%s", 6.0 * volume, cases[i].volume, text);
    }
}

/* Each choice of holes of four triangles, in any order, leaves the others. */
static void holes_leave_the_other_faces(void **state) {
    (void)state;
    static const int orders[2][4] = {{0, 1, 2, 3}, {2, 0, 3, 1}};
    for (int chosen = 0; chosen < 16; chosen++)
        for (int order = 0; order < 2; order++) {
            char text[1024], holes[64] = "";
            for (int k = 0; k < 4; k++)
                if (chosen >> orders[order][k] & 1)
                    (void)sprintf(holes + strlen(holes), "%d, ", orders[order][k]);
            (void)snprintf(text, sizeof text,
                           "#usda 1.0\ndef Mesh \"m\"\n{\n" POINTS COUNTS OUTWARD
                           "int[] holeIndices = [%s]\n}\n",
                           holes);
            tulle_animation_info info;
            tulle_animation *const animation = open_text(test_path("h.usda"), text, &info);
            static const uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
            const uint32_t *const found = tulle_animation_get_triangles(animation);
            size_t left = 0;
            for (int k = 0; k < 4; k++) {
                if (chosen >> k & 1) continue;
                assert_true(left < info.triangle_count);
                assert_memory_equal(found + 3 * left++, faces[k], sizeof faces[k]);
            }
            assert_int_equal(info.triangle_count, left);
            tulle_animation_close(animation);
        }
}

/* An L is cut within itself, by its first frame; the cut of a mesh is that of its mirror. */
static void polygons_of_usd_are_cut_within(void **state) {
    (void)state;
    tulle_animation_info info;
    tulle_animation *const animation =
        open_text(test_path("l.usda"),
                  "#usda 1.0\ndef Mesh \"m\"\n{\nint[] faceVertexCounts = [4, 6, 4]\n"
                  "int[] faceVertexIndices = [0, 2, 4, 1, 0, 1, 2, 3, 4, 5, 0, 1, 3, 5]\n"
                  "point3f[] points.timeSamples = {\n"
                  "0: [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)],\n"
                  "1: [(0, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0), (1, 2, 1), (0, 2, 0)] }\n}\n"
                  "def \"n\" ( references = </m> )\n{\n" MIRROR "}\n",
                  &info);
    assert_int_equal(info.triangle_count, 16);
    assert_non_null(strstr(info.note, "1 polygon crosses itself or has no area (face 0)"));
    const uint32_t *const t = tulle_animation_get_triangles(animation);
    double x[36], area = 0.0;
    tulle_error error = {0};
    assert_int_equal(tulle_animation_read_frame(animation, 0, x, &error), TULLE_OK);
    for (size_t i = 2; i < 6; i++) {
        const double *const a = x + 3 * t[3 * i], *const b = x + 3 * t[3 * i + 1],
                            *const c = x + 3 * t[3 * i + 2];
        double const part = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert_true(part > 0.1);
        area += 0.5 * part;
    }
    assert_true(area == 3.0);
    for (size_t i = 0; i < 24; i++)
        assert_int_equal(t[24 + i], 6 + t[i % 3 == 0 ? i : i % 3 == 1 ? i + 1 : i - 1]);
    tulle_animation_close(animation);
}

static void classes_may_be_missing(void **state) {
    (void)state;
    static const char *const arcs[] = {"inherits = </c/Coat>", "prepend specializes = [</c/Coat>]"};
    tulle_animation_info info;
    for (size_t i = 0; i < 2; i++) {
        char text[1024];
        (void)snprintf(text, sizeof text, "#usda 1.0\ndef Mesh \"m\" (\n%s\n)\n{\n%s}\n", arcs[i],
                       POINTS COUNTS OUTWARD);
        tulle_animation_close(open_text(test_path("c.usda"), text, &info));
        assert_int_equal(info.triangle_count, 4);
        assert_non_null(
            strstr(info.note, "what prims inherit from 1 that are not there, as </c/Coat>"));
    }
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    put_text(test_path("r.usda"),
             "#usda 1.0\ndef Mesh \"m\" ( references = </c> ) {\n" POINTS "}\n");
    assert_int_equal(tulle_animation_open(test_path("r.usda"), &animation, NULL, &error),
                     TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "there is no prim </c>"));
}

/* Tabs, ends of lines of any system, comments of both kinds. */
static void blanks_of_usd_are_passed_over(void **state) {
    (void)state;
    tulle_animation_info info;
    tulle_animation_close(
        open_text(test_path("b.usda"),
                  "#usda 1.0\r\n# a comment\r\ndef\tMesh\t\"m\"\r\n{\r\t\n\t" POINTS
                  "// another\r\n\t/* and\tone */\t" COUNTS "\r\n" OUTWARD "\t}\r\n",
                  &info));
    assert_int_equal(info.triangle_count, 4);
}

/* ---- glTF ---- */

/* The same tetrahedron, between nodes, and what follows them. */
static void write_gltf(const char *nodes, const char *more, const char *buffer, char *text,
                       size_t size) {
    (void)snprintf(
        text, size,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[%s],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"JOINTS_0\":2,\"WEIGHTS_0\":3},\"indices\":1}]}]%s,"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":0,\"byteOffset\":48,\"componentType\":5121,\"count\":12,\"type\":"
        "\"SCALAR\"},{\"bufferView\":0,\"byteOffset\":60,\"componentType\":5121,\"count\":4,"
        "\"type\":\"VEC4\"},{\"bufferView\":0,\"byteOffset\":76,\"componentType\":5121,"
        "\"normalized\":true,\"count\":4,\"type\":\"VEC4\"},{\"bufferView\":0,\"byteOffset\":92,"
        "\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"},{\"bufferView\":0,"
        "\"byteOffset\":100,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":124}],"
        "\"buffers\":[{\"byteLength\":124,\"uri\":\"%s\"}]}",
        nodes, more, buffer);
}

static void write_buffer(const char *path) {
    static const float points[12] = {[3] = 1, [7] = 1, [11] = 1};
    static const float keys[8] = {0, 1, 0, 0, 0, -1, 1, 1}; /* times, scales */
    static const unsigned char small[44] = {
        0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3, [28] = 255, [32] = 255, [36] = 255, [40] = 255};
    char bytes[124];
    for (size_t i = 0; i < 12; i++) bytes_store_float((unsigned char *)bytes + 4 * i, points[i]);
    memcpy(bytes + 48, small, sizeof small);
    for (size_t i = 0; i < 8; i++) bytes_store_float((unsigned char *)bytes + 92 + 4 * i, keys[i]);
    put_file(path, bytes, sizeof bytes);
}

static void mirrors_of_gltf_turn_surfaces_round(void **state) {
    (void)state;
    static const struct {
        const char *nodes, *more;
        double volume; /* in sixths */
    } cases[] = {
        {"{\"mesh\":0}", "", 1},
        {"{\"mesh\":0,\"scale\":[-1,1,1]}", "", 1},
        {"{\"mesh\":0,\"scale\":[-1,-1,1]}", "", 1},
        {"{\"mesh\":0,\"matrix\":[0,1,0,0,1,0,0,0,0,0,1,0,7,0,0,1]}", "", 1},
        {"{\"mesh\":0},{\"children\":[0],\"scale\":[1,-2,1]}", "", 2},
        {"{\"mesh\":0,\"scale\":[1,-1,1]},{\"children\":[0],\"scale\":[1,-2,1]}", "", 2},
        {"{\"mesh\":0},{\"mesh\":0,\"scale\":[1,1,-3]}", "", 4},
        /* A skin moves by its joints alone. */
        {"{\"mesh\":0,\"skin\":0},{\"scale\":[-1,1,1]}", ",\"skins\":[{\"joints\":[1]}]", 1},
        {"{\"mesh\":0,\"skin\":0,\"scale\":[-1,1,1]},{}", ",\"skins\":[{\"joints\":[1]}]", 1},
        /* Flat in the first frame. */
        {"{\"mesh\":0}",
         ",\"animations\":[{\"samplers\":[{\"input\":4,\"output\":5}],\"channels\":[{\"sampler\":0,"
         "\"target\":{\"node\":0,\"path\":\"scale\"}}]}]",
         1},
    };
    write_buffer(test_path("b.bin"));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[4096];
        write_gltf(cases[i].nodes, cases[i].more, "b.bin", text, sizeof text);
        double const volume = measure_volume(test_path("m.gltf"), text);
        if (fabs(volume - cases[i].volume / 6.0) > 1e-6)
            fail_msg("%g, not %g sixths, of\n%s", 6.0 * volume, cases[i].volume, text);
    }
}

/* A buffer may lie in a folder beside the file, and nowhere behind a link. */
static void buffers_behind_links_are_refused(void **state) {
    (void)state;
    char text[4096];
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    assert_int_equal(mkdir(test_path("sub"), 0777), 0);
    write_buffer(test_path("sub/b.bin"));
    assert_int_equal(symlink("sub/b.bin", test_path("link.bin")), 0);
    assert_int_equal(symlink("sub", test_path("other")), 0);
    static const char *const names[] = {"sub/b.bin", "link.bin", "other/b.bin", "./sub//b.bin"};
    for (int i = 0; i < 4; i++) {
        write_gltf("{\"mesh\":0}", "", names[i], text, sizeof text);
        put_text(test_path("l.gltf"), text);
        tulle_status const status =
            tulle_animation_open(test_path("l.gltf"), &animation, NULL, &error);
        assert_int_equal(status, i == 1 || i == 2 ? TULLE_ERROR_PARSE : TULLE_OK);
        if (status) assert_non_null(strstr(error.message, "symbolic link"));
        tulle_animation_close(animation);
    }
    /* The file itself may be behind one. */
    assert_int_equal(symlink("l.gltf", test_path("k.gltf")), 0);
    assert_int_equal(tulle_animation_open(test_path("k.gltf"), &animation, NULL, &error), 0);
    tulle_animation_close(animation);
}

/* What extensions say that a file could do without is told, unless it is no matter of surfaces. */
static void extensions_are_told(void **state) {
    (void)state;
    char text[4096];
    tulle_animation_info info;
    write_buffer(test_path("b.bin"));
    write_gltf("{\"mesh\":0}", "", "b.bin", text, sizeof text);
    tulle_animation_close(open_text(test_path("plain.gltf"), text, &info));
    assert_string_equal(info.note, "");
    static const char used[] =
        "{\"extensionsUsed\":[\"KHR_materials_unlit\",\"EXT_mesh_gpu_instancing\","
        "\"KHR_draco_mesh_compression\",\"KHR_node_visibility\"],";
    char more[sizeof text + sizeof used];
    assert_true(text[0] == '{');
    snprintf(more, sizeof more, "%s%s", used, text + 1);
    tulle_animation_close(open_text(test_path("used.gltf"), more, &info));
    assert_string_equal(info.note, "passed over: what the extension EXT_mesh_gpu_instancing says, "
                                   "what the extension KHR_node_visibility says");
}

static void utf16_is_told(void **state) {
    (void)state;
    tulle_animation *animation = NULL;
    static const char *const names[] = {"u.gltf", "u.usda"};
    static const char *const starts[] = {"{\"asset\":{}}", "#usda 1.0\n"};
    for (int i = 0; i < 2; i++) {
        char wide[64] = "";
        size_t const count = strlen(starts[i]);
        for (size_t k = 0; k < count; k++) wide[2 * k] = starts[i][k];
        put_file(test_path(names[i]), wide, 2 * count);
        tulle_error error = {0};
        assert_int_equal(tulle_animation_open(test_path(names[i]), &animation, NULL, &error),
                         TULLE_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, "UTF-16"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirrors_of_usd_turn_surfaces_round),
        cmocka_unit_test(holes_leave_the_other_faces),
        cmocka_unit_test(polygons_of_usd_are_cut_within),
        cmocka_unit_test(classes_may_be_missing),
        cmocka_unit_test(blanks_of_usd_are_passed_over),
        cmocka_unit_test(mirrors_of_gltf_turn_surfaces_round),
        cmocka_unit_test(buffers_behind_links_are_refused),
        cmocka_unit_test(extensions_are_told),
        cmocka_unit_test(utf16_is_told),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
