/* USD that is read: what is written comes back with the same bits; a file with everything that
 * moves vertices against sums by hand; what is refused, with its line; every truncation, flipped
 * bit and failing allocation. */
#define _XOPEN_SOURCE 700
#include "io/animation/animation_sample.h"

/* ---- what is written ---- */

static void usd_comes_back(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 120; seed++) {
        make_sample(seed, 1 + (uint32_t)(seed % 6));
        made.positions[0][0] = -0.0f;
        assert_int_equal(write_sample(test_path("a.usda"), NULL), TULLE_OK);
        expect_sample(test_path("a.usda"));
        tulle_animation *animation = NULL;
        double positions[3 * VERTEX_MAX];
        tulle_error error = {0};
        assert_int_equal(tulle_animation_open(test_path("a.usda"), &animation, NULL, &error), 0);
        assert_int_equal(tulle_animation_read_frame(animation, 0, positions, &error), 0);
        assert_true(signbit(positions[0]));
        assert_true(tulle_animation_get_time(animation, 0) == made.times[0]);
        tulle_animation_close(animation);
    }
}

/* Times that no whole number of codes gives come back, too. */
static void times_come_back(void **state) {
    (void)state;
    make_sample(11, 9);
    static const double times[] = {-1.0,      -1e-9,       1e-9, 0.1, 0.2, 0.30000000000000004,
                                   1.0 / 3.0, 7.000000001, 1e6};
    memcpy(made.times, times, sizeof times);
    assert_int_equal(write_sample(test_path("t.usda"), NULL), TULLE_OK);
    expect_sample(test_path("t.usda"));
}

/* More frames than the window over the file holds. */
static void many_frames_come_back(void **state) {
    (void)state;
    make_sample(7, FRAME_MAX);
    assert_int_equal(write_sample(test_path("many.usda"), NULL), TULLE_OK);
    expect_sample(test_path("many.usda"));
}

static double get_coordinate(uint32_t frame, size_t i) { return 0.25 * (double)i - frame; }

static tulle_status read_mixed(void *context, size_t surface, uint32_t frame, double *values,
                               tulle_error *error) {
    (void)context;
    (void)error;
    if (surface == 0) {
        for (size_t i = 0; i < 12; i++) values[i] = get_coordinate(frame, i);
        return TULLE_OK;
    }
    double const half = 0.25 * frame; /* about z by twice that angle; then along x */
    double const pose[7] = {(double)surface * 10.0 + frame, 0, 0, cos(half), 0, 0, sin(half)};
    memcpy(values, pose, sizeof pose);
    return TULLE_OK;
}

/* Rigid surfaces that share a mesh, in a class that nobody is to see. */
static void poses_come_back(void **state) {
    (void)state;
    static const double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    static const double times[3] = {0, 0.5, 1};
    tulle_animation_surface surfaces[3];
    for (size_t i = 0; i < 3; i++)
        surfaces[i] = (tulle_animation_surface){.name = i > 0 ? "box" : "sheet",
                                                .mesh = {square, 4, corners, 2},
                                                .motion = i > 0 ? TULLE_ANIMATION_RIGID
                                                                : TULLE_ANIMATION_DEFORMS,
                                                .prototype = i > 0 ? 1 : 0};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = surfaces;
    def.surface_count = 3;
    def.times = times;
    def.frame_count = 3;
    def.is_y_up = 1;
    def.meters_per_unit = 0.01;
    def.read = read_mixed;
    tulle_error error = {0};
    tulle_animation *animation = NULL;
    tulle_animation_info info;
    double p[36];
    if (tulle_animation_write(test_path("p.usda"), &def, &error)) fail_msg("%s", error.message);
    if (tulle_animation_open(test_path("p.usda"), &animation, &info, &error))
        fail_msg("%d:%d %s", error.line, error.column, error.message);
    assert_true(info.vertex_count == 12 && info.triangle_count == 6);
    assert_int_equal(info.frame_count, 3 + info.added_frame_count); /* where the boxes turn */
    assert_true(info.is_y_up && info.meters_per_unit == 0.01 && !info.note[0]);
    for (uint32_t f = 0, at = 0; f < 3; f++) {
        while (at + 1 < info.frame_count && tulle_animation_get_time(animation, at) < times[f])
            at++;
        assert_true(tulle_animation_get_time(animation, at) == times[f]);
        assert_int_equal(tulle_animation_read_frame(animation, at, p, &error), TULLE_OK);
        for (size_t i = 0; i < 12; i++) assert_true(p[i] == get_coordinate(f, i));
        for (size_t box = 1; box < 3; box++)
            for (size_t v = 0; v < 4; v++) {
                double const c = cos(0.5 * f), s = sin(0.5 * f);
                const double *const q = square + 3 * v, *const found = p + 12 * box + 3 * v;
                assert_true(fabs(found[0] - (c * q[0] - s * q[1] + 10.0 * (double)box + f)) <
                            1e-12);
                assert_true(fabs(found[1] - (s * q[0] + c * q[1])) < 1e-12);
                assert_true(fabs(found[2] - (q[2])) < 1e-12);
            }
    }
    tulle_animation_close(animation);
}

/* ---- what others write ---- */

static tulle_animation *open_text(const char *text, tulle_animation_info *info) {
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    put_file(test_path("x.usda"), text, strlen(text));
    if (tulle_animation_open(test_path("x.usda"), &animation, info, &error))
        fail_msg("%d:%d %s\n%s", error.line, error.column, error.message, text);
    return animation;
}

static void expect_points(tulle_animation *animation, uint32_t frame, const double *wanted,
                          size_t count) {
    double p[3 * 64];
    tulle_error error = {0};
    if (tulle_animation_read_frame(animation, frame, p, &error)) fail_msg("%s", error.message);
    for (size_t i = 0; i < 3 * count; i++)
        if (fabs(p[i] - wanted[i]) > 1e-6)
            fail_msg("frame %u: coordinate %zu of vertex %zu is %g, not %g", frame, i % 3, i / 3,
                     p[i], wanted[i]);
}

/* As Blender exports a mesh that deforms below an empty that moves. */
static const char exported[] =
    "#usda 1.0\n(\n    defaultPrim = \"root\"\n    doc = \"\"\"Blender\n\"v3\" # 4\"\"\"\n"
    "    endTimeCode = 3\n    metersPerUnit = 1\n    startTimeCode = 1\n"
    "    timeCodesPerSecond = 24\n    upAxis = \"Z\"\n)\n\n"
    "def Xform \"root\" (\n    customData = {\n        dictionary Blender = {\n"
    "            bool generated = 1\n        }\n    }\n)\n{\n"
    "    def Xform \"Empty\"\n    {\n"
    "        matrix4d xformOp:transform.timeSamples = {\n"
    "            1: ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (10, 0, 0, 1) ),\n"
    "            3: ( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (14, 0, 0, 1) ),\n        }\n"
    "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n\n"
    "        def Mesh \"Grid\" (\n            prepend apiSchemas = [\"MaterialBindingAPI\"]\n      "
    "  )\n"
    "        {\n            uniform bool doubleSided = 1\n"
    "            float3[] extent.timeSamples = { 1: [(0, 0, 0), (1, 1, 0)] }\n"
    "            int[] faceVertexCounts.timeSamples = {\n                1: [4],\n"
    "                2: [4],\n            }\n"
    "            int[] faceVertexIndices = [0, 1, 3, 2]\n"
    "            rel material:binding = </root/m>\n"
    "            normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] (\n"
    "                interpolation = \"faceVarying\"\n            )\n"
    "            point3f[] points.timeSamples = {\n"
    "                1: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)],\n"
    "                2: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.5)],\n"
    "                3: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1)],\n            }\n"
    "            bool[] primvars:sharp_face = [0] ( interpolation = \"uniform\" )\n"
    "            uniform token subdivisionScheme = \"none\"\n        }\n    }\n"
    "    def Camera \"Camera\"\n    {\n"
    "        float3 xformOp:translate.timeSamples = { 7.5: (1, 2, 3) }\n"
    "        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n    }\n"
    "    def Material \"m\"\n    {\n        token outputs:surface.connect = "
    "</root/m/s.outputs:surface>\n"
    "    }\n}\n";

static void exports_are_read(void **state) {
    (void)state;
    tulle_animation_info info;
    tulle_animation *const animation = open_text(exported, &info);
    assert_true(info.vertex_count == 4 && info.triangle_count == 2 && info.frame_count == 3);
    assert_string_equal(info.note, "");
    static const uint32_t corners[] = {0, 1, 3, 0, 3, 2};
    assert_memory_equal(tulle_animation_get_triangles(animation), corners, sizeof corners);
    for (uint32_t f = 0; f < 3; f++) {
        double const x = 10.0 + 2.0 * f;
        double const wanted[] = {x, 0, 0, x + 1, 0, 0, x, 1, 0, x + 1, 1, 0.5 * f};
        expect_points(animation, f, wanted, 4);
        assert_true(tulle_animation_get_time(animation, f) == (f + 1) / 24.0);
    }
    tulle_animation_close(animation);
}

/* One point at 1, 2, 3, moved by these statements. */
static void expect_moved(const char *statements, double x, double y, double z) {
    char text[2048];
    tulle_animation_info info;
    snprintf(text, sizeof text,
             "#usda 1.0\ndef Xform \"a\"\n{\n double3 xformOp:translate = (100, 0, 0)\n"
             " uniform token[] xformOpOrder = [\"xformOp:translate\"]\n def Points \"p\"\n {\n"
             "  point3f[] points = [(1, 2, 3)]\n  %s\n }\n}\n",
             statements);
    tulle_animation *const animation = open_text(text, &info);
    double const wanted[3] = {x, y, z};
    expect_points(animation, 0, wanted, 1);
    assert_true(info.is_y_up &&
                info.meters_per_unit == 0.01); /* the standard's, if none are told */
    tulle_animation_close(animation);
}

static void every_transform(void **state) {
    (void)state;
    expect_moved("", 101, 2, 3);
    expect_moved(
        "float3 xformOp:scale = (2, 3, 4)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]", 102,
        6, 12);
    expect_moved(
        "double xformOp:translateY = 5 uniform token[] xformOpOrder = ['xformOp:translateY']", 101,
        7, 3);
    expect_moved(
        "float xformOp:scaleZ = 2; uniform token[] xformOpOrder = [ \"\"\"xformOp:scaleZ\"\"\", ]",
        101, 2, 6);
    expect_moved("float xformOp:rotateZ = 90\nuniform token[] xformOpOrder = [\"xformOp:rotateZ\"]",
                 98, 1, 3);
    expect_moved(
        "float xformOp:rotateX = -90\nuniform token[] xformOpOrder = [\"xformOp:rotateX\"]", 101, 3,
        -2);
    /* First about x: (1, -3, 2); then about y by 90: (2, -3, -1); then about z by 180. */
    expect_moved("float3 xformOp:rotateXYZ = (90, 90, 180)\nuniform token[] xformOpOrder = "
                 "[\"xformOp:rotateXYZ\"]",
                 98, 3, -1);
    /* The same angles, z first: (-1, -2, 3), then y: (3, -2, 1), then x: (3, -1, -2). */
    expect_moved("float3 xformOp:rotateZYX:arm = (90, 90, 180)\nuniform token[] xformOpOrder = "
                 "[\"xformOp:rotateZYX:arm\"]",
                 103, -1, -2);
    expect_moved(
        "quatf xformOp:orient = (0, 0, 0, 2)\nuniform token[] xformOpOrder = [\"xformOp:orient\"]",
        99, -2, 3);
    /* Scaled about a pivot at 1, 1, 1. */
    expect_moved("float3 xformOp:translate:pivot = (1, 1, 1)\nfloat3 xformOp:scale = (2, 2, 2)\n"
                 "uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:scale\", "
                 "\"!invert!xformOp:translate:pivot\"]",
                 101, 3, 5);
    expect_moved(
        "matrix4d xformOp:transform = ((0, 2, 0, 0), (-4, 0, 0, 0), (0, 0, 1, 0), (5, 6, 7, 1))\n"
        "uniform token[] xformOpOrder = [\"xformOp:transform\"]",
        97, 8, 10);
    expect_moved(
        "matrix4d xformOp:transform = ((0, 2, 0, 0), (-4, 0, 0, 0), (0, 0, 1, 0), (5, 6, 7, 1))\n"
        "float3 xformOp:translate = (0, 0, 1)\n"
        "uniform token[] xformOpOrder = [\"!invert!xformOp:transform\", \"xformOp:transform\", "
        "\"xformOp:translate\"]",
        101, 2, 4);
    expect_moved("float3 xformOp:scale = (2, 2, 2)\n"
                 "uniform token[] xformOpOrder = [\"!resetXformStack!\", \"xformOp:scale\"]",
                 2, 4, 6);
}

/* Everything that puts prims together, in one file, with what is passed over between. */
static const char composed[] =
    "#usda 1.0\n# a comment\n(\n  'what it is'\n  subLayers = [@other.usda@ (offset = 1)]\n  "
    "upAxis = \"Y\"\n"
    "  metersPerUnit = 0.0254; defaultPrim = \"World\"\n  timeCodesPerSecond = 10\n)\n"
    "class \"_base\"\n{\n  def Mesh \"tri\"\n  {\n"
    "    point3d[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
    "    int[] faceVertexCounts = [3]\n    int[] faceVertexIndices = [0, 1, 2,]\n"
    "    uniform token orientation = \"leftHanded\"\n  }\n}\n"
    "over \"Ghost\"\n{\n  def Mesh \"never\" { point3f[] points = [(9, 9, 9)] }\n}\n"
    "def Xform \"World\" (\n  variants = { string look = \"red\" }\n  prepend variantSets = "
    "\"look\"\n"
    "  add references = @far.usd@</A>\n)\n{\n"
    "  variantSet \"look\" = {\n    \"red\" (doc = \"}\") {\n      def Mesh \"m\" { point3f[] "
    "points = [(8, 8, 8)] }\n    }\n  }\n"
    "  def \"a\" ( inherits = </_base> )\n  {\n    double3 xformOp:translate.timeSamples = {\n"
    "      20: (4, 0, 0),\n      0: (0, 0, 0)\n    }\n"
    "    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n  }\n"
    "  def Xform \"b\" ( prepend references = [</_base>] )\n  {\n    over \"tri\"\n    {\n"
    "      point3f[] points.timeSamples = { 0: [(0, 0, 0), (1, 0, 0), (0, 1, 1)], 10: [(0, 0, 0), "
    "(1, 0, 0), (0, 1, 3)] }\n"
    "    }\n  }\n"
    "  def Sphere \"ball\" { double radius = 2 }\n"
    "  def Xform \"hidden\" { token visibility = \"invisible\"\n def Mesh \"m\" { point3f[] points "
    "= [(7, 7, 7)] } }\n"
    "  def Mesh \"guide\" { uniform token purpose = \"guide\"\n point3f[] points = [(7, 7, 7)] }\n"
    "  def Mesh \"off\" ( active = false ) { point3f[] points = [(7, 7, 7)] }\n"
    "  def PointInstancer \"many\"\n  {\n    rel prototypes = [</World/many/p/one>, </_base/tri>]\n"
    "    int[] protoIndices = [1, 0]\n    point3f[] positions = [(10, 0, 0), (20, 0, 0)]\n"
    "    quath[] orientations = [(1, 0, 0, 0), (0.70710678, 0, 0, 0.70710678)]\n"
    "    float3[] scales = [(1, 1, 1), (2, 2, 2)]\n    int64[] ids = [5, 6]\n"
    "    def Scope \"p\"\n    {\n      def Mesh \"one\"\n      {\n        uniform token "
    "subdivisionScheme = \"none\"\n"
    "        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (5, 5, 5)]\n"
    "        int[] faceVertexCounts = [3, 4, 3]\n        int[] faceVertexIndices = [0, 1, 4, 0, 1, "
    "2, 3, 0, 1, 2]\n"
    "        int[] holeIndices = [0]\n      }\n    }\n  }\n"
    "}\n";

static void prims_are_put_together(void **state) {
    (void)state;
    tulle_animation_info info;
    tulle_animation *const animation = open_text(composed, &info);
    assert_string_equal(info.note, "passed over: 2 other files, as @other.usda@, 1 variant sets, "
                                   "1 spheres, curves and the like, 2 that are hidden, the "
                                   "subdivision of 3 meshes");
    assert_true(info.is_y_up && info.meters_per_unit == 0.0254);
    assert_int_equal(info.vertex_count, 3 + 3 + 3 + 5);
    /* Left-handed ones are turned round; the hole is left out. */
    static const uint32_t corners[] = {0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 10, 11, 9, 11, 12, 9, 10, 11};
    assert_int_equal(info.triangle_count, 6);
    assert_memory_equal(tulle_animation_get_triangles(animation), corners, sizeof corners);
    assert_int_equal(info.frame_count, 3); /* 0, 1 and 2 s */
    for (uint32_t f = 0; f < 3; f++) {
        assert_true(tulle_animation_get_time(animation, f) == f);
        double const x = 2.0 * f, z = f == 0 ? 1 : 3;
        double const wanted[] = {x, 0, 0,  x + 1, 0,  0,  x, 1,  0,  0, 0,  0,  1,  0,
                                 0, 0, 1,  z,     10, 0,  0, 11, 0,  0, 10, 1,  0,  20,
                                 0, 0, 20, 2,     0,  18, 2, 0,  18, 0, 0,  10, 10, 10};
        expect_points(animation, f, wanted, 14);
    }
    tulle_animation_close(animation);
}

#define LONG "a_folder_whose_name_goes_on_and_on/and_a_file_of_this_kind"

/* A note tells of all kinds, however many there are. */
static void all_that_is_passed_over_is_told(void **state) {
    (void)state;
    tulle_animation_info info;
    tulle_animation_close(open_text(
        "#usda 1.0\n(\n subLayers = [@" LONG "@]\n)\ndef Xform \"World\" (\n"
        " inherits = </a_class_whose_name_goes_on_and_on_until_the_line_ends>\n)\n{\n"
        " variantSet \"look\" = {\n \"red\" { }\n }\n def Sphere \"ball\" { }\n"
        " def Mesh \"off\" { token visibility = \"invisible\" }\n def Mesh \"shown\"\n {\n"
        "  token visibility.timeSamples = { 0: \"invisible\", 1: \"inherited\" }\n"
        "  int[] faceVertexCounts = [4]\n  int[] faceVertexIndices = [0, 1, 2, 3]\n"
        "  point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)]\n }\n}\n",
        &info));
    static const char *const kinds[] = {
        LONG,      "until_the_line_ends", "1 variant sets",       "1 spheres", "1 that are hidden",
        "visible", "the subdivision of",  "1 polygon is not flat"};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        if (!strstr(info.note, kinds[i])) fail_msg("\"%s\" lacks \"%s\"", info.note, kinds[i]);
    assert_true(strlen(info.note) > 300);
}

/* Instances that are inactive or invisible at all times are left out, by their ids. */
static void hidden_instances_are_left_out(void **state) {
    (void)state;
#define INSTANCER(metadata, more)                                                                  \
    "#usda 1.0\n( upAxis = \"Z\"\n metersPerUnit = 1 )\nclass Points \"p\" { point3f[] points = "  \
    "[(0, "                                                                                        \
    "0, 0)] }\ndef PointInstancer \"i\" " metadata "\n{\n int[] protoIndices = [0, 0, 0]\n rel "   \
    "prototypes = </i/q>\n point3f[] positions = [(10, 0, 0), (20, 0, 0), (30, 0, 0)]\n" more      \
    "\n def Points \"q\" { point3f[] points = [(0, 0, 0)] }\n}\n"
    static const struct {
        const char *text, *note;
        size_t count;
        double x[3];
    } cases[] = {
        {INSTANCER("", ""), "", 3, {10, 20, 30}},
        {INSTANCER("", " int64[] invisibleIds = [1]"),
         "passed over: 1 that are hidden",
         2,
         {10, 30}},
        {INSTANCER("", " int64[] ids = [7, 1, 5]\n int64[] invisibleIds = [5, 0, 7]"),
         "passed over: 2 that are hidden",
         1,
         {20}},
        {INSTANCER("( inactiveIds = [2, 0] )", ""), "", 1, {20}},
        {INSTANCER("( prepend inactiveIds = [2]\n append inactiveIds = [0] )",
                   " int64[] ids = [0, 1, 2]"),
         "",
         1,
         {20}},
        {INSTANCER("( delete inactiveIds = [2] )", ""), "", 3, {10, 20, 30}},
        {INSTANCER("", " int64[] invisibleIds.timeSamples = { 0: [0, 2], 1: [2] }"),
         "passed over: 1 that are hidden, when 1 are visible, so they always are",
         2,
         {10, 20}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        tulle_animation_info info;
        tulle_animation *const animation = open_text(cases[i].text, &info);
        if (info.vertex_count != cases[i].count || strcmp(info.note, cases[i].note) != 0)
            fail_msg("case %zu: %zu vertices, %s", i, (size_t)info.vertex_count, info.note);
        double wanted[9] = {0};
        for (size_t k = 0; k < cases[i].count; k++) wanted[3 * k] = cases[i].x[k];
        expect_points(animation, 0, wanted, cases[i].count);
        tulle_animation_close(animation);
    }
}

/* A name that ends in .usd or .usdc may hold either form. */
static void text_is_read_by_any_name(void **state) {
    (void)state;
    static const char text[] = "#usda 1.0\ndef Points \"p\" { point3f[] points = [(1, 2, 3)] }\n";
    static const char *const names[] = {"a.usd", "a.usdc"};
    for (int i = 0; i < 2; i++) {
        tulle_animation *animation = NULL;
        tulle_animation_info info;
        tulle_error error = {0};
        put_file(test_path(names[i]), text, sizeof text - 1);
        assert_int_equal(tulle_animation_open(test_path(names[i]), &animation, &info, &error),
                         TULLE_OK);
        assert_int_equal(info.vertex_count, 1);
        tulle_animation_close(animation);
        put_file(test_path(names[i]), "PXR-USDC\0\0\0", 11);
        assert_int_equal(tulle_animation_open(test_path(names[i]), &animation, NULL, &error),
                         TULLE_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, "binary form"));
    }
}

/* Between samples rotations go the short way at constant speed; visibility may change. */
static void samples_are_joined(void **state) {
    (void)state;
    tulle_animation_info info;
    tulle_animation *const animation = open_text(
        "#usda 1.0\n( upAxis = \"Z\"\n metersPerUnit = 1 )\ndef Points \"p\"\n{\n"
        " token visibility.timeSamples = { 0: \"invisible\", 1: \"inherited\" }\n"
        " point3f[] points.timeSamples = { 0: [(1, 0, 0)], 12: [(1, 0, 0)], 24: [(2, 0, 0)] }\n"
        " quatd xformOp:orient.timeSamples = { 0: (1, 0, 0, 0), 24: (-0.7071067811865476, 0, 0, "
        "-0.7071067811865476) }\n"
        " uniform token[] xformOpOrder = [\"xformOp:orient\"]\n}\n",
        &info);
    assert_string_equal(info.note, "passed over: when 1 are visible, so they always are");
    assert_int_equal(info.frame_count, 3);
    double const half = sqrt(0.5);
    double const wanted[3][3] = {{1, 0, 0}, {half, half, 0}, {0, 2, 0}};
    for (uint32_t f = 0; f < 3; f++) expect_points(animation, f, wanted[f], 1);
    assert_true(tulle_animation_get_time(animation, 1) == 0.5);
    tulle_animation_close(animation);
}

/* ---- what is refused ---- */

static void expect_refused(const char *text, int line, int column, const char *message) {
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    double p[3 * 64];
    put_file(test_path("bad.usda"), text, strlen(text));
    tulle_status status = tulle_animation_open(test_path("bad.usda"), &animation, NULL, &error);
    for (uint32_t f = 0; f < 2 && !status; f++)
        status = tulle_animation_read_frame(animation, f, p, &error);
    tulle_animation_close(animation);
    if (status != TULLE_ERROR_PARSE || error.line != line || error.column != column ||
        !strstr(error.message, message) || strcmp(error.file, test_path("bad.usda")) != 0)
        fail_msg("%s\nstatus %d at %d:%d: %s", text, status, error.line, error.column,
                 error.message);
}

#define MESH(inside)                                                                               \
    "#usda 1.0\ndef Mesh \"m\"\n{\n point3f[] points = [(0,0,0), (1,0,0), (0,1,0)]\n" inside "\n}" \
    "\n"

static void faults_are_told(void **state) {
    (void)state;
    expect_refused("", 1, 1, "should begin with");
    expect_refused("#usda 1.0\n", 0, 0, "shows no meshes; it needs a Mesh");
    expect_refused("#usda 1.0\ndef Xform \"a\" ( references = @b.usd@ ) {}", 2, 30,
                   "@b.usd@ and other files that it refers to are not read: write all into one");
    expect_refused("#usda 1.0\ndef Sphere \"a\" {}", 0, 0, "of which it has 1, are not read");
    expect_refused("#usda 1.0\ndef Mesh \"a\" { token visibility = \"invisible\" }", 0, 0,
                   "1 prims are hidden: set visibility or purpose");
    expect_refused("#usda 1.0\nMesh", 2, 1, "\"Mesh\" should be def, over or class");
    expect_refused("#usda 1.0\n}\n", 2, 1, "should be def");
    expect_refused("#usda 1.0\ndef Mesh m\n", 2, 10, "name of a prim in quotes");
    expect_refused("#usda 1.0\ndef Mesh \"m\n\"", 2, 10, "has no end");
    expect_refused("#usda 1.0\n(\n upAxis = \"X\"\n)", 3, 11, "\"Y\" or \"Z\"");
    expect_refused("#usda 1.0\n(\n metersPerUnit = 0\n)", 3, 18, "above 0");
    expect_refused("#usda 1.0\ndef Mesh \"m\" {\n point3f[] points = [(0, 0, 0}]\n}", 3, 30,
                   "\"}\" should be \")\"");
    expect_refused("#usda 1.0\ndef Mesh \"m\" {\n point3f[] points = [(0, 0, 0)\n}", 4, 1,
                   "should be \"]\"");
    expect_refused("#usda 1.0\ndef Mesh \"m\" {\n", 2, 14, "is not closed");
    expect_refused("#usda 1.0\ndef Mesh \"m\" {}\ndef Mesh \"m\" {}", 3, 10, "another name");
    expect_refused("#usda 1.0\ndef Mesh \"m\" { point3f[] points = [(0, 0)] }", 2, 41,
                   "should be \",\"");
    expect_refused("#usda 1.0\ndef Mesh \"m\" { point3f[] points = [(0, 0, nan)] }", 2, 43,
                   "a finite number");
    expect_refused("#usda 1.0\ndef Mesh \"m\" { point3f[] points = [(0, 0, 1e39)] }", 2, 35,
                   "too large for its type");
    expect_refused("#usda 1.0\ndef Mesh \"m\" { point3f[] points = [(0, 0, 1e999)] }", 2, 43,
                   "too large");
    expect_refused("#usda 1.0\ndef Mesh \"m\" { point3f[] points = [(0, 0, 1x)] }", 2, 43,
                   "\"1x\" should be a number");
    expect_refused(MESH(" int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 3]"), 6,
                   28, "corner 2 is vertex 3");
    expect_refused(MESH(" int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, -1]"), 6,
                   28, "vertex -1");
    expect_refused(MESH(" int[] faceVertexCounts = [2]\n int[] faceVertexIndices = [0, 1]"), 5, 27,
                   "face 0 has 2 corners");
    expect_refused(MESH(" int[] faceVertexCounts = [4]\n int[] faceVertexIndices = [0, 1, 2]"), 5,
                   27, "face 0 has 4 corners");
    expect_refused(MESH(" int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2, 0]"),
                   6, 28, "there are 4 corners");
    expect_refused(MESH(" int[] faceVertexIndices = [0, 1, 2]\n int[] faceVertexCounts.timeSamples "
                        "= {\n 0: [3],\n 1: []\n }"),
                   8, 5, "changes in time");
    expect_refused(MESH(" point3f[] points.timeSamples = { 0: [(0,0,0)], 1: [] }"), 5, 52,
                   "their number may not change");
    expect_refused(MESH(" point3f[] points.timeSamples = { 0: [(0,0,0)], 0: [(0,0,0)] }"), 5, 52,
                   "two samples");
    expect_refused(MESH(" point3f[] points.timeSamples = { 0: None }"), 5, 38, "without a value");
    expect_refused(MESH(" uniform token[] xformOpOrder = [\"xformOp:spin\"]"), 5, 34,
                   "that is known");
    expect_refused(MESH(" uniform token[] xformOpOrder = [\"xformOp:rotateXX\"]"), 5, 34,
                   "that is known");
    expect_refused(MESH(" uniform token[] xformOpOrder = [\"xformOp:scale\"]"), 5, 34,
                   "that has a value");
    expect_refused(MESH(" float3 xformOp:scale = (0, 1, 1)\n uniform token[] xformOpOrder = "
                        "[\"!invert!xformOp:scale\"]"),
                   5, 9, "no inverse");
    expect_refused(MESH(" matrix4d xformOp:transform = ((1,0,0,1),(0,1,0,0),(0,0,1,0),(0,0,0,1))\n "
                        "uniform token[] xformOpOrder = [\"xformOp:transform\"]"),
                   5, 11, "projection");
    expect_refused("#usda 1.0\ndef Xform \"a\" (\n references = </b>\n) {}", 3, 15, "no prim </b>");
    expect_refused("#usda 1.0\ndef Xform \"a\" (\n references = </a> (offset = 2)\n) {}", 3, 20,
                   "another time");
    expect_refused("#usda 1.0\ndef Xform \"a\" ( references = </b> ) {}\ndef Xform \"b\" ( "
                   "references = </a> ) {}",
                   3, 11, "circle");
    expect_refused(
        "#usda 1.0\ndef PointInstancer \"a\" { int[] protoIndices = [0]\n rel prototypes = </b> }",
        3, 19, "path of a prim");
    expect_refused("#usda 1.0\ndef PointInstancer \"a\" { int[] protoIndices = [1]\n rel "
                   "prototypes = </b> }\ndef Mesh \"b\" {}",
                   0, 0, "prototype 1");
    expect_refused(INSTANCER("", " int64[] ids = [1]"), 10, 10, "1 ids for 3 instances");
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_animation_open(test_path("none.usda"), &animation, NULL, &error),
                     TULLE_ERROR_IO);
    put_file(test_path("crate.usda"), "PXR-USDC\0\0\0", 11);
    assert_int_equal(tulle_animation_open(test_path("crate.usda"), &animation, NULL, &error),
                     TULLE_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "binary form"));
}

/* Prims within their own references, and instances of instances: a small file is not to fill the
 * memory. */
static void uses_are_limited(void **state) {
    (void)state;
    static char text[1 << 16];
    char *end =
        text +
        sprintf(
            text,
            "#usda 1.0\ndef Xform \"p0\" { def Points \"x\" { point3f[] points = [(0,0,0)] } }\n");
    for (int i = 1; i < 24; i++)
        end += sprintf(end,
                       "def Xform \"p%d\" {\n def Xform \"a\" ( references = </p%d> ) {}\n def "
                       "Xform \"b\" ( references = </p%d> ) {}\n}\n",
                       i, i - 1, i - 1);
    tulle_animation *animation = NULL;
    tulle_error error = {0};
    put_file(test_path("uses.usda"), text, (size_t)(end - text));
    assert_int_equal(tulle_animation_open(test_path("uses.usda"), &animation, NULL, &error),
                     TULLE_ERROR_LIMIT);
    assert_non_null(strstr(error.message, "times its size"));
    end = text + sprintf(text, "#usda 1.0\n");
    for (int i = 0; i < 1000; i++) end += sprintf(end, "def \"a\" {");
    put_file(test_path("deep.usda"), text, (size_t)(end - text));
    assert_int_equal(tulle_animation_open(test_path("deep.usda"), &animation, NULL, &error),
                     TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "in each other"));
    end = text + sprintf(text, "#usda 1.0\ndef \"a\" { int a = ");
    for (int i = 0; i < 1000; i++) *end++ = '[';
    put_file(test_path("deep.usda"), text, (size_t)(end - text));
    assert_int_equal(tulle_animation_open(test_path("deep.usda"), &animation, NULL, &error),
                     TULLE_ERROR_PARSE);
}

/* ---- damage ---- */

static void damage_is_found(void **state) {
    (void)state;
    static const char *const texts[] = {exported, composed};
    for (int i = 0; i < 2; i++) {
        size_t const size = strlen(texts[i]);
        char *const bytes = malloc(size);
        memcpy(bytes, texts[i], size);
        for (size_t cut = 0; cut < size; cut++) try_bytes(test_path("d.usda"), bytes, cut);
        for (size_t bit = 0; bit < 8 * size; bit++) {
            bytes[bit / 8] ^= (char)(1 << bit % 8);
            try_bytes(test_path("d.usda"), bytes, size);
            bytes[bit / 8] ^= (char)(1 << bit % 8);
        }
        free(bytes);
    }
}

static void every_failing_allocation(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    put_file(test_path("m.usda"), composed, strlen(composed));
    long fail = 0;
    while (read_and_judge(test_path("m.usda"), strlen(composed), fail) == TULLE_ERROR_OUT_OF_MEMORY)
        fail++;
    assert_true(fail > 20);
    assert_int_equal(read_and_judge(test_path("m.usda"), strlen(composed), fail), TULLE_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(usd_comes_back),
        cmocka_unit_test(times_come_back),
        cmocka_unit_test(many_frames_come_back),
        cmocka_unit_test(poses_come_back),
        cmocka_unit_test(exports_are_read),
        cmocka_unit_test(every_transform),
        cmocka_unit_test(prims_are_put_together),
        cmocka_unit_test(all_that_is_passed_over_is_told),
        cmocka_unit_test(hidden_instances_are_left_out),
        cmocka_unit_test(text_is_read_by_any_name),
        cmocka_unit_test(samples_are_joined),
        cmocka_unit_test(faults_are_told),
        cmocka_unit_test(uses_are_limited),
        cmocka_unit_test(damage_is_found),
        cmocka_unit_test(every_failing_allocation),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
