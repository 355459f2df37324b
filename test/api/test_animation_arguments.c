/* Arguments of the public functions of tulle_io/animation.h. */
#define _XOPEN_SOURCE 700
#include "io/io_support.h"

#include "api/arguments.h"
#include "tulle_io/animation.h"

static double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
static double times[2] = {0.0, 0.5};
static tulle_animation_surface surface;

static tulle_status read_square(void *context, size_t number, uint32_t frame, double *values,
                                tulle_error *at) {
    (void)context;
    (void)number;
    (void)frame;
    (void)at;
    memcpy(values, square, sizeof square);
    return TULLE_OK;
}

static tulle_status read_infinite(void *context, size_t number, uint32_t frame, double *values,
                                  tulle_error *at) {
    (void)context;
    (void)number;
    (void)at;
    for (int i = 0; i < 4; i++) values[i] = frame == 1 && i == 3 ? 1e39 : 1.0;
    return TULLE_OK;
}

static tulle_status read_pose(void *context, size_t number, uint32_t frame, double *values,
                              tulle_error *at) {
    (void)number;
    (void)frame;
    (void)at;
    double const pose[7] = {1, 2, 3, *(const double *)context, 0, 0, 0};
    memcpy(values, pose, sizeof pose);
    return TULLE_OK;
}

static tulle_animation_def make_def(void) {
    surface = (tulle_animation_surface){
        .name = "sheet", .mesh = {square, 4, corners, 2}, .motion = TULLE_ANIMATION_DEFORMS};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.times = times;
    def.frame_count = 2;
    def.read = read_square;
    return def;
}

ARGUMENTS_OF(tulle_animation_def_default) {
    tulle_animation_def const def = tulle_animation_def_default();
    assert_true(def.cookie != 0 && def.frame_rate == 24.0 && def.meters_per_unit == 1.0);
}

static void refuse(const tulle_animation_def *def) {
    static const char *const names[] = {"a.glb", "a.gltf", "a.usda", "a.mdd", "a.npz"};
    for (int i = 0; i < 5; i++) {
        REFUSED(tulle_animation_write(test_path(names[i]), def, &error));
        assert_int_not_equal(access(test_path(names[i]), F_OK), 0);
    }
}

ARGUMENTS_OF(tulle_animation_write) {
    tulle_animation_def def = make_def();
    REFUSED(tulle_animation_write(NULL, &def, &error));
    refuse(NULL);
    def.cookie = 0;
    refuse(&def);
    for (int i = 0; i < 8; i++) {
        def = make_def();
        if (i == 0) def.surfaces = NULL;
        if (i == 1) def.surface_count = 0;
        if (i == 2) def.times = NULL;
        if (i == 3) def.frame_count = 0;
        if (i == 4) def.read = NULL;
        if (i == 5) surface.name = NULL;
        if (i == 6) surface.mesh.vertex_count = 0;
        if (i == 7) surface.mesh.triangles = NULL;
        refuse(&def);
    }
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        def = make_def();
        def.frame_rate = no_numbers[i];
        refuse(&def);
        def = make_def();
        def.meters_per_unit = no_numbers[i];
        refuse(&def);
        def = make_def();
        surface.color[1] = no_numbers[i];
        refuse(&def);
        def = make_def();
        times[0] = no_numbers[i];
        refuse(&def);
        times[0] = 0.0;
    }
    times[0] = 0.5; /* no time passes between the frames */
    def = make_def();
    refuse(&def);
    times[0] = 0.0;
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        def = make_def();
        SET_CHOICE(surface.motion, no_choices[i]);
        refuse(&def);
    }
    def = make_def();
    surface.prototype = 1;
    refuse(&def);
    def = make_def();
    REFUSED_WITH(TULLE_ERROR_UNSUPPORTED, tulle_animation_write(test_path("a.abc"), &def, &error));
    corners[5] = 4;
    REFUSED_WITH(TULLE_ERROR_INVALID_MESH, tulle_animation_write(test_path("a.glb"), &def, &error));
    corners[5] = 3;
    square[4] = 1e39;
    REFUSED_WITH(TULLE_ERROR_INVALID_MESH, tulle_animation_write(test_path("a.mdd"), &def, &error));
    square[4] = 0.0;
    static const char *const no_array_names[] = {
        "",
        "positions",
        "first_vertices",
        "a/b",
        "a.npy",
        "\xc3\xa4",
        "a1234567890123456789012345678901234567890123456789012345678901234"};
    def.read_vertex_array = read_square;
    for (size_t i = 0; i < sizeof no_array_names / sizeof no_array_names[0]; i++) {
        def.vertex_array = no_array_names[i];
        refuse(&def);
    }
    def.vertex_array = "departure";
    FINE(tulle_animation_write(test_path("a.npz"), &def, NULL));
    FINE(tulle_animation_write(test_path("a.usda"), &def, NULL));
    assert_int_equal(unlink(test_path("a.npz")) + unlink(test_path("a.usda")), 0);
    def.read_vertex_array = read_infinite;
    REFUSED_WITH(TULLE_ERROR_INVALID_MESH, tulle_animation_write(test_path("a.npz"), &def, &error));
    def.read_vertex_array = NULL;
    refuse(&def);
    def.vertex_array = NULL;
    surface.motion = TULLE_ANIMATION_RIGID;
    double real_part = 0.5; /* no unit quaternion */
    def.read = read_pose;
    def.context = &real_part;
    refuse(&def);
    real_part = -1.0;
    FINE(tulle_animation_write(test_path("a.glb"), &def, NULL));
    FINE(tulle_animation_write(test_path("a.usda"), &def, NULL));
    REFUSED(tulle_animation_write(test_path("a.mdd"), &def, &error));
    REFUSED(tulle_animation_write(test_path("a.npz"), &def, &error));
}

/* ---- reading ---- */

static tulle_animation *open_square(void) {
    tulle_animation_def const def = make_def();
    tulle_animation *animation = NULL;
    FINE(tulle_animation_write(test_path("read.glb"), &def, &error));
    FINE(tulle_animation_open(test_path("read.glb"), &animation, NULL, &error));
    return animation;
}

ARGUMENTS_OF(tulle_animation_open) {
    tulle_animation *animation = open_square();
    tulle_animation_close(animation);
    REFUSED(tulle_animation_open(NULL, &animation, NULL, &error));
    REFUSED(tulle_animation_open(test_path("read.glb"), NULL, NULL, &error));
    FINE(tulle_animation_open(test_path("read.glb"), &animation, NULL, NULL));
    tulle_animation_close(animation);
}

ARGUMENTS_OF(tulle_animation_get_triangles) {
    tulle_animation *const animation = open_square();
    assert_null(tulle_animation_get_triangles(NULL));
    assert_memory_equal(tulle_animation_get_triangles(animation), corners, sizeof corners);
    tulle_animation_close(animation);
}

ARGUMENTS_OF(tulle_animation_get_time) {
    tulle_animation *const animation = open_square();
    assert_true(isnan(tulle_animation_get_time(NULL, 0)));
    assert_true(isnan(tulle_animation_get_time(animation, 2)));
    assert_true(isnan(tulle_animation_get_time(animation, UINT32_MAX)));
    assert_true(tulle_animation_get_time(animation, 1) == 0.5);
    tulle_animation_close(animation);
}

ARGUMENTS_OF(tulle_animation_read_frame) {
    tulle_animation *const animation = open_square();
    double read[12];
    REFUSED(tulle_animation_read_frame(NULL, 0, read, &error));
    REFUSED(tulle_animation_read_frame(animation, 0, NULL, &error));
    REFUSED(tulle_animation_read_frame(animation, 2, read, &error));
    REFUSED(tulle_animation_read_frame(animation, UINT32_MAX, read, &error));
    FINE(tulle_animation_read_frame(animation, 1, read, NULL));
    assert_memory_equal(read, square, sizeof read);
    tulle_animation_close(animation);
}

ARGUMENTS_OF(tulle_animation_close) { tulle_animation_close(NULL); }

int main(void) {
    return run_arguments(HEADERS("tulle_io/animation.h"), make_test_folder, remove_test_folder);
}
