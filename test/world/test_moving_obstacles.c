/* Obstacles that appear and obstacles that follow a mesh sequence. */
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0; /* [s] */

static tulle_world *make_world(void) {
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

/* A wide flat box whose top is at height z. */
static tulle_mesh make_floor(double z) {
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 1.0;
    box.size[2] = 0.1;
    return small_shape(box, 0.0, 0.0, z - 0.05);
}

static void one_that_appears_below_catches_the_cloth(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.4, 9, 0.0), floor = make_floor(-0.2);
    tulle_world *const world = make_world();
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&floor);
    def.appear_time = 8.5 * STEP;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    for (int i = 0; i < 45; i++) {
        assert_int_equal(tulle_obstacle_is_present(world, id), i > 9);
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        assert_int_equal(small_judge(world, &sheet, 1, &floor, 1), 0);
    }
    double const height = tulle_cloth_get_positions(world, cloth, NULL)[2];
    assert_true(height > -0.2 && height < -0.15);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
}

static void one_that_appears_in_the_cloth_is_refused(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.4, 9, 0.0), box = make_floor(0.02);
    tulle_world *const world = make_world();
    small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    for (size_t v = 0; v < box.vertex_count; v++) box.positions[3 * v] += 0.5;
    def.appear_time = 2.5 * STEP;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    }
    uint64_t const hash = tulle_world_get_state_hash(world);
    for (int i = 0; i < 2; i++) { /* the second time too: the first changed nothing */
        tulle_error error = {0};
        assert_int_equal(tulle_world_step(world, STEP, NULL, &error),
                         TULLE_ERROR_INTERSECTING_START);
        assert_non_null(strstr(error.message, " s, when 'obstacle 0' appears:\n"));
        assert_null(strstr(error.message, "untangle"));
        assert_true(tulle_world_get_state_hash(world) == hash);
        assert_false(tulle_obstacle_is_present(world, id));
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
}

/* A sequence: the mesh rises by 1 cm a frame. */
typedef struct rising_frames {
    const tulle_mesh *mesh;
    uint32_t bad_frame;   /* that cannot be given */
    double bad_value;     /* put into it... */
    size_t bad_place;     /* ...as this coordinate */
    bool is_bad_by_value; /* else the reader fails */
} rising_frames;

static tulle_status read_rising_frame(void *context, uint32_t frame, double *positions,
                                      tulle_error *error) {
    const rising_frames *const frames = context;
    for (size_t v = 0; v < frames->mesh->vertex_count; v++) {
        for (size_t c = 0; c < 3; c++) positions[3 * v + c] = frames->mesh->positions[3 * v + c];
        positions[3 * v + 2] += 0.01 * frame;
    }
    if (frame != frames->bad_frame) return TULLE_OK;
    if (frames->is_bad_by_value) {
        positions[frames->bad_place] = frames->bad_value;
        return TULLE_OK;
    }
    if (error) {
        error->status = TULLE_ERROR_IO;
        strcpy(error->message, "frame 4 is gone");
    }
    return TULLE_ERROR_IO;
}

/* A sheet over a floor that rises by a sequence; steps until a step fails, 40 at most. */
static tulle_status ride(rising_frames frames, tulle_error *error) {
    tulle_mesh sheet = small_sheet(0.4, 9, 0.0), floor = make_floor(-0.01);
    frames.mesh = &floor;
    tulle_world *const world = make_world();
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&floor);
    def.read_frame = read_rising_frame;
    def.frame_context = &frames;
    def.frame_count = 7;
    def.frame_interval = 2.5 * STEP;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    tulle_status status = tulle_world_start(world, error);
    for (int i = 0; status == TULLE_OK && i < 40; i++) {
        uint64_t const hash = tulle_world_get_state_hash(world);
        status = tulle_world_step(world, STEP, NULL, error);
        if (status != TULLE_OK) assert_true(tulle_world_get_state_hash(world) == hash);
        assert_int_equal(small_judge(world, &sheet, 1, &floor, 1), 0);
        double const frame = fmin(tulle_world_get_time(world) / def.frame_interval, 6.0);
        double const z = tulle_obstacle_get_positions(world, id, NULL)[2];
        assert_true(fabs(z - floor.positions[2] - 0.01 * frame) < 1e-12);
    }
    if (status == TULLE_OK) {
        assert_true(tulle_cloth_get_positions(world, cloth, NULL)[2] > 0.049);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
    return status;
}

static void a_sequence_carries_the_cloth(void **state) {
    (void)state;
    tulle_error error = {0};
    if (ride((rising_frames){.bad_frame = TULLE_NONE}, &error) != TULLE_OK) {
        fail_msg("%s", error.message);
    }
}

static void a_bad_frame_fails_the_step(void **state) {
    (void)state;
    tulle_error error = {0};
    assert_int_equal(ride((rising_frames){.bad_frame = 4}, &error), TULLE_ERROR_IO);
    assert_string_equal(error.message, "frame 4 is gone");
    double const bad[] = {(double)NAN, (double)INFINITY};
    for (size_t k = 0; k < 6; k++) { /* each coordinate of vertex 1 */
        rising_frames const frames = {.bad_frame = 4,
                                      .bad_value = bad[k % 2],
                                      .bad_place = 3 + k / 2,
                                      .is_bad_by_value = true};
        assert_int_equal(ride(frames, &error), TULLE_ERROR_INVALID_MESH);
        assert_non_null(strstr(error.message, "vertex 1 of frame 4"));
    }
}

/* ---- frames that are made while the world runs ---- */

/* A host that moves a floor: what it has shown so far, and what it shows next. */
typedef struct live_floor {
    const tulle_mesh *mesh;
    double heights[1024]; /* [m] by which each frame is raised */
    uint32_t shown;       /* frames up to this one are known */
    uint32_t early_count; /* how often an unknown one was asked for */
} live_floor;

static tulle_status read_live_frame(void *context, uint32_t frame, double *positions,
                                    tulle_error *error) {
    (void)error;
    live_floor *const live = context;
    live->early_count += frame > live->shown;
    for (size_t i = 0; i < 3 * live->mesh->vertex_count; i++)
        positions[i] = live->mesh->positions[i] + (i % 3 == 2 ? live->heights[frame] : 0.0);
    return TULLE_OK;
}

static tulle_obstacle_id add_live_floor(tulle_world *world, live_floor *live, double interval) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(live->mesh);
    def.read_frame = read_live_frame;
    def.frame_context = live;
    def.frame_count = 1024;
    def.frame_interval = interval;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    return id;
}

/* Steps that end with frames ask for no frame beyond, however the time is rounded, and end exactly
 * where the frame is. */
static void live_frames_do_not_lag(void **state) {
    (void)state;
    static const double RATES[] = {60.0, 90.0, 1000.0 / 7.0}; /* [1/s] */
    tulle_mesh sheet = small_sheet(0.1, 3, 5.0), floor = make_floor(-0.01);
    for (size_t r = 0; r < sizeof RATES / sizeof *RATES; r++) {
        static live_floor live;
        live = (live_floor){.mesh = &floor};
        double const step = 1.0 / RATES[r];
        tulle_world_def def = tulle_world_def_default();
        def.gravity[2] = 0.0;
        tulle_world *world = NULL;
        assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
        small_add_cloth(world, &sheet);
        tulle_obstacle_id const id = add_live_floor(world, &live, step);
        for (uint32_t i = 1; i <= 600; i++) {
            live.shown = i; /* the host has made the frame in which the step ends */
            live.heights[i] = 0.001 * (i % 7);
            assert_int_equal(tulle_world_step(world, step, NULL, NULL), TULLE_OK);
            double const z = tulle_obstacle_get_positions(world, id, NULL)[2];
            if (z != floor.positions[2] + live.heights[i] || live.early_count > 0)
                fail_msg("%g Hz, step %u: at %.17g, %u frames asked too early", RATES[r], i,
                         z - floor.positions[2], live.early_count);
        }
        tulle_world_destroy(world);
    }
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
}

/* After a state was loaded, and after a step that failed, the host may show something else. */
static void live_frames_are_asked_for_again(void **state) {
    (void)state;
    static live_floor live, other;
    tulle_mesh sheet = small_sheet(0.1, 3, 5.0), floor = make_floor(-0.01);
    live = other = (live_floor){.mesh = &floor, .shown = 1024};
    tulle_world *const world = make_world();
    small_add_cloth(world, &sheet);
    tulle_obstacle_id const id = add_live_floor(world, &live, STEP);
    (void)add_live_floor(world, &other, STEP);
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    assert_int_equal(tulle_world_save_state(world, &bytes, &byte_count, NULL), TULLE_OK);
    for (int i = 0; i < 4; i++) {
        live.heights[2] = 0.002 * i;
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        double const z = tulle_obstacle_get_positions(world, id, NULL)[2];
        assert_true(z == floor.positions[2] + live.heights[2]);
        assert_int_equal(tulle_world_load_state(world, bytes, byte_count, NULL), TULLE_OK);
    }
    tulle_world_free_state(world, bytes, byte_count);
    live.heights[2] = 0.5; /* is read, then the other one fails */
    other.heights[2] = (double)NAN;
    assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_ERROR_INVALID_MESH);
    live.heights[2] = 0.001;
    other.heights[2] = 0.0;
    assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    double const z = tulle_obstacle_get_positions(world, id, NULL)[2];
    assert_true(z == floor.positions[2] + live.heights[2]);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
}

/* A long box that turns half around in 0.05 s through cloth that lies on it. */
typedef struct flip {
    size_t axis;   /* of the turn */
    double height; /* [m] of the sheet; the box is 0.05 m high */
    unsigned n;    /* vertices a side */
    double step;   /* [s] */
} flip;

static void expect_no_pinch(const flip *tried) {
    static const double TURN_START = 0.3, TURN_TIME = 0.05, TURNED = 0.4; /* [s] */
    static const double PI = 3.14159265358979323846;
    tulle_mesh sheet = small_sheet(0.5, tried->n, tried->height);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = 0.8;
    shape.size[1] = shape.size[2] = 0.05;
    tulle_mesh box = small_shape(shape, 0.0, 0.0, -0.025);
    tulle_world *const world = make_world();
    small_add_cloth(world, &sheet);
    tulle_keyframe keys[5];
    for (int k = 0; k < 5; k++) {
        keys[k] = (tulle_keyframe){TURN_START + 0.25 * k * TURN_TIME, {0}, {0}};
        keys[k].rotation_vector[tried->axis] = 0.25 * PI * k;
    }
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    def.motion = (tulle_motion){keys, 5, {0, 0, 0}, 0};
    assert_int_equal(tulle_world_add_obstacle(world, &def, NULL, NULL), TULLE_OK);
    double minimum_gap = 0.0;
    while (tulle_world_get_time(world) < TURNED) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, tried->step, &report, &error) != TULLE_OK)
            fail_msg("axis %zu, %u vertices a side: %s", tried->axis, tried->n, error.message);
        tulle_world_get_distances(world, NULL, NULL, &minimum_gap);
        assert_true(report.smallest_gap >= minimum_gap);
        assert_int_equal(report.pinched, 0);
        assert_int_equal(small_judge(world, &sheet, 1, &box, 1), 0);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
}

/* Cloth that rides on what turns comes nearer to it on the way, by chords instead of circles: no
 * pinch, there is room. */
static void one_that_turns_fast_does_not_pinch(void **state) {
    (void)state;
    static const flip FLIPS[] = {
        {1, 0.1, 11, 1.0 / 90.0}, {2, 0.1, 11, 1.0 / 90.0}, {1, 0.1, 21, 1.0 / 90.0}};
    for (size_t i = 0; i < sizeof FLIPS / sizeof *FLIPS; i++) expect_no_pinch(&FLIPS[i]);
}

/* Two turns in one step move an arm back to where it was, but it sweeps what is in its way. So do
 * pins that turn as fast. Keyframes that no substeps follow fail the step. */
static void turns_within_a_step_are_followed(void **state) {
    (void)state;
    static const double TURN = 6.283185307179586;
    double const turns[] = {2.0, 3000.0};
    for (int k = 0; k < 4; k++) {
        bool const is_pin = k % 2;
        tulle_mesh sheet = small_sheet(0.1, 5, 0.0);
        for (size_t v = 0; v < sheet.vertex_count; v++) { /* upright, across the arm's way */
            double *const x = sheet.positions + 3 * v;
            x[2] = x[1];
            x[1] = 0.2;
            x[0] += 0.3;
        }
        tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
        shape.size[0] = 1.0;
        shape.size[1] = 0.05;
        shape.size[2] = 0.3;
        tulle_mesh arm = small_shape(shape, 0.0, 0.0, 0.0);
        tulle_keyframe const keys[2] = {{0}, {STEP, {0}, {0.0, 0.0, turns[k / 2] * TURN}}};
        tulle_motion const motion = {keys, 2, {0, 0, 0}, 0};
        static const uint32_t all[25] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                                         13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24};
        tulle_pin pin = tulle_pin_default();
        pin.vertices = all;
        pin.vertex_count = 25;
        tulle_world *const world = make_world();
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        if (is_pin) {
            pin.motion = motion;
            cloth.pins = &pin;
            cloth.pin_count = 1;
        }
        tulle_cloth_id id;
        assert_int_equal(tulle_world_add_cloth(world, &cloth, &id, NULL), TULLE_OK);
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(&arm);
        if (!is_pin) def.motion = motion;
        assert_int_equal(tulle_world_add_obstacle(world, &def, NULL, NULL), TULLE_OK);
        tulle_step_report report;
        tulle_error error = {0};
        tulle_status const status = tulle_world_step(world, STEP, &report, &error);
        if (k / 2 == 1) {
            assert_int_equal(status, TULLE_ERROR_STEP_FAILED);
            assert_non_null(strstr(error.message, "keyframes of"));
        } else if (is_pin) { /* into the arm */
            assert_int_equal(status, TULLE_ERROR_PINCHED);
        } else {
            assert_int_equal(status, TULLE_OK);
            assert_true(report.substeps >= 16);
            assert_int_equal(small_judge(world, &sheet, 1, &arm, 1), 0);
            const double *const x = tulle_cloth_get_positions(world, id, NULL);
            double farthest = 0.0;
            for (size_t i = 0; i < 3 * sheet.vertex_count; i++)
                farthest = fmax(farthest, fabs(x[i] - sheet.positions[i]));
            if (!(farthest > 0.05)) fail_msg("the arm went through cloth that moved %g", farthest);
        }
        tulle_world_destroy(world);
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&arm);
    }
}

/* A sheet on a floor that moves, until it moves otherwise. */
typedef struct release {
    double before, after; /* [m/s] of the floor, up, for 28 steps and for as many then */
    tulle_integrator integrator;
} release;

/* [m/s] Of the sheet, up, five steps after the change. */
static double find_speed_after(const release *made) {
    tulle_mesh sheet = small_sheet(0.4, 9, 0.0), floor = make_floor(-0.005);
    tulle_world_def world_def = tulle_world_def_default();
    world_def.integrator = made->integrator;
    world_def.wind.drag_coefficient = 0.0;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&world_def, &world, NULL), TULLE_OK);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_keyframe keys[3] = {{0}};
    double const length = 28.0 * STEP; /* ends with a step */
    for (int k = 0; k < 3; k++) {
        keys[k].time = k * length;
    }
    keys[1].translation[2] = made->before * length;
    keys[2].translation[2] = (made->before + made->after) * length;
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&floor);
    def.motion.keys = keys;
    def.motion.key_count = 3;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    for (int i = 0; i < 33; i++)
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    size_t count;
    const double *const v = tulle_cloth_get_velocities(world, cloth, &count);
    double lowest = (double)INFINITY, highest = -(double)INFINITY;
    for (size_t i = 0; i < count; i++) {
        lowest = fmin(lowest, v[3 * i + 2]);
        highest = fmax(highest, v[3 * i + 2]);
    }
    assert_true(highest - lowest < 0.02); /* it stays flat */
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
    return 0.5 * (lowest + highest);
}

/* Contact pushes only: what leaves cloth does not take it along, and what stops lets it fly on. */
static void one_that_leaves_lets_go(void **state) {
    (void)state;
    static const tulle_integrator INTEGRATORS[] = {
        TULLE_INTEGRATOR_IMPLICIT_EULER, TULLE_INTEGRATOR_CRANK_NICOLSON, TULLE_INTEGRATOR_BDF2};
    /* cloth that is held has the floor's speed, 0.45 m/s off or more; BDF2 starts anew after
     * contact, its velocity a quarter of a step behind */
    double const fall = 9.81 * 5.0 * STEP, half_step = 9.81 * 0.5 * STEP;
    for (int i = 0; i < 3; i++) {
        release const stops = {1.0, 0.0, INTEGRATORS[i]}, slows = {1.0, 0.3, INTEGRATORS[i]};
        release const drops = {0.0, -10.0, INTEGRATORS[i]};
        double const speeds[] = {find_speed_after(&stops), find_speed_after(&slows),
                                 find_speed_after(&drops)};
        print_message("let go: %.4f, %.4f, %.4f m/s\n", speeds[0], speeds[1], speeds[2]);
        assert_true(fabs(speeds[0] - (1.0 - fall)) < half_step);
        assert_true(fabs(speeds[1] - (1.0 - fall)) < half_step);
        assert_true(fabs(speeds[2] + fall) < half_step);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_that_turns_fast_does_not_pinch),
        cmocka_unit_test(turns_within_a_step_are_followed),
        cmocka_unit_test(one_that_leaves_lets_go),
        cmocka_unit_test(one_that_appears_below_catches_the_cloth),
        cmocka_unit_test(one_that_appears_in_the_cloth_is_refused),
        cmocka_unit_test(a_sequence_carries_the_cloth),
        cmocka_unit_test(a_bad_frame_fails_the_step),
        cmocka_unit_test(live_frames_do_not_lag),
        cmocka_unit_test(live_frames_are_asked_for_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
