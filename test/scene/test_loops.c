/* Mesh sequences that loop, and how fast they play: which frame is shown when, against a count by
 * hand; ends that do not meet are refused. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include <math.h>

#define TIME "time: {frames: 3, step: 10 ms}\n"
#define HEAD                                                                                       \
    TIME "cloth:\n  - {mesh: {shape: rectangle}, translate: [0, 0, 9]}\nobstacles:\n"              \
         "  - motion:\n      sequence: {files: k_%d.obj, first: 1, "

/* Files whose frame i lies at the height heights[i]. */
static void write_frames(const double *heights, int count) {
    for (int i = 0; i < count; i++) {
        char name[20], text[100];
        snprintf(name, sizeof name, "k_%d.obj", i + 1);
        snprintf(text, sizeof text, "v 0 0 %g\nv 1 0 %g\nv 1 1 %g\nf 1 2 3\n", heights[i],
                 heights[i], heights[i]);
        write_text_file(name, text);
    }
}

/* `shown`: the heights of the frames of the world from 0 on. */
static void expect_frames(const char *keys, const double *shown, uint32_t count) {
    char text[400];
    snprintf(text, sizeof text, "%s%s}\n", HEAD, keys);
    tulle_scene *const loaded = load_good(text);
    scene_sequence *const sequence = loaded->obstacles[0].sequence;
    tulle_error error = {0};
    for (uint32_t i = 0; i < count; i++) {
        double positions[9];
        if (sequence_read(sequence, i, positions, &error) != TULLE_OK)
            fail_msg("%s: frame %u: %s", keys, (unsigned)i, error.message);
        if (positions[2] != shown[i])
            fail_msg("%s: frame %u is at %g, not %g", keys, (unsigned)i, positions[2], shown[i]);
    }
    tulle_scene_destroy(loaded);
}

static void test_order_of_frames(void **state) {
    (void)state;
    write_frames((const double[]){0, 1, 3, 2}, 4);
    expect_frames("last: 4, interval: 1, loop: pingpong",
                  (const double[]){0, 1, 3, 2, 3, 1, 0, 1, 3, 2, 3, 1, 0, 1}, 14);
    /* From 2 to 0 is as far as from 1 to 3: an ordinary step. */
    expect_frames("last: 4, interval: 1, loop: repeat",
                  (const double[]){0, 1, 3, 2, 0, 1, 3, 2, 0, 1}, 10);
    expect_frames("last: 2, interval: 1, loop: pingpong", (const double[]){0, 1, 0, 1, 0}, 5);
    /* The last one is the first once more. */
    write_frames((const double[]){0, 1, 0.0005}, 3);
    expect_frames("last: 3, interval: 1, loop: repeat", (const double[]){0, 1, 0, 1, 0, 1}, 6);
    write_frames((const double[]){4, 4}, 2);
    expect_frames("last: 2, interval: 1, loop: repeat", (const double[]){4, 4, 4}, 3);
    tulle_scene *const loaded = load_good(HEAD "last: 2, interval: 1}\n");
    double positions[9];
    tulle_error error = {0};
    assert_int_equal(sequence_read(loaded->obstacles[0].sequence, 2, positions, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_scene_destroy(loaded);
}

/* 50 frames in a second at double speed: a frame in 10 ms, so 35 ms are three and a half frames. */
static void test_speed_in_a_world(void **state) {
    (void)state;
    write_frames((const double[]){0, 1, 3}, 3);
    static const struct {
        const char *keys;
        double height;
    } cases[] = {{"fps: 50, speed: 2, loop: pingpong", 0.5},
                 {"fps: 100, loop: pingpong", 0.5},
                 {"interval: 5 ms, speed: 50 %, loop: pingpong", 0.5},
                 {"interval: 10 ms", 3},
                 {"fps: 100, loop: pingpong, start: 15 ms", 3},
                 {"fps: 100, loop: pingpong, start: 1", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[400];
        snprintf(text, sizeof text, "%slast: 3, %s}\n", HEAD, cases[i].keys);
        tulle_scene *const loaded = load_good(text);
        tulle_scene_world built;
        tulle_error error = {0};
        assert_int_equal(tulle_scene_build_world(loaded, 1, NULL, &built, &error), TULLE_OK);
        for (int k = 0; k < 7; k++)
            if (tulle_world_step(built.world, 0.005, NULL, &error) != TULLE_OK)
                fail_msg("%s", error.message);
        const double *const x = tulle_obstacle_get_positions(built.world, built.obstacles[0], NULL);
        if (!(fabs(x[2] - cases[i].height) < 1e-9))
            fail_msg("%s: at %g, not %g", cases[i].keys, x[2], cases[i].height);
        tulle_scene_destroy_world(&built);
        tulle_scene_destroy(loaded);
    }
}

static void refuse(const char *keys, const char *words) {
    char text[400];
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    snprintf(text, sizeof text, "%s%s}\n", HEAD, keys);
    assert_null(load_text(text, problems));
    if (problems->list[0].line != 6 || !strstr(problems->list[0].message, words))
        fail_msg("%s: line %d: %s", keys, problems->list[0].line, problems->list[0].message);
    free(problems);
}

static void test_problems_have_a_place(void **state) {
    (void)state;
    write_frames((const double[]){0, 1, 2, 2.01}, 4);
    refuse("last: 4, interval: 1, loop: repeat",
           "obstacles[0].motion.sequence.loop: the ends do not meet: from the last frame to the "
           "first vertex 0 goes 2.01 m, between other frames none goes more than 1 m");
    expect_frames("last: 3, interval: 1, loop: repeat", (const double[]){0, 1, 2, 0}, 4);
    refuse("last: 1, interval: 1, loop: pingpong", "loop: there is one frame only");
    refuse("last: 1, interval: 1, loop: repeat", "loop: there is one frame only");
    refuse("last: 2, interval: 1, loop: always", "loop");
    refuse("last: 2", "needs one of the keys interval, fps");
    refuse("last: 2, interval: 1, fps: 24", "may have only one of the keys interval, fps");
    refuse("last: 2, fps: 0", "fps");
    refuse("last: 2, fps: 24, speed: -1", "speed");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_order_of_frames),
        cmocka_unit_test(test_speed_in_a_world),
        cmocka_unit_test(test_problems_have_a_place),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
