/* `tulle check` on run directories: every frame is judged, absent obstacles are left out, threads
 * do not change a byte, and what cannot be judged is refused. */
#define _DEFAULT_SOURCE /* mkdtemp, fork */
#include "app/commands.h"
#include "tulle_io/run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

enum { FRAME_COUNT = 7, OUTPUT_LIMIT = 1 << 16 };

static char work[] = "/tmp/tulle-check-run-XXXXXX";
static char directory[64];

/* A square sheet, a strip beside it, and a spike that stands where the sheet comes by. */
static double sheet[12] = {0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
static double strip[9] = {5, 0, 0, 6, 0, 0, 5, 1, 0};
static double spike[9] = {0.6, 0.2, -1, 0.7, 0.2, -1, 0.6, 0.3, 0.5};
static double ground[9] = {-9, -9, -5, 9, -9, -5, 0, 9, -5};
static const uint32_t square[6] = {0, 1, 2, 0, 2, 3}, triangle[3] = {0, 1, 2};

static void write_frame(tulle_run_writer *writer, uint32_t number) {
    double moved_sheet[12], moved_strip[9];
    memcpy(moved_sheet, sheet, sizeof sheet);
    memcpy(moved_strip, strip, sizeof strip);
    /* The sheet sinks by 0.25 a frame: it meets the spike at z = 0.5, 0.25, 0, -0.25, -0.5. */
    for (int v = 0; v < 4; v++) moved_sheet[3 * v + 2] -= 0.25 * number;
    /* In the last frame the strip stands across the sheet's diagonal. */
    static const double standing[9] = {0.5, 0.5, -1, 0.5, 0.5, 0, 3, 0.5, -1};
    if (number == 6) memcpy(moved_strip, standing, sizeof standing);
    const double *positions[4] = {moved_sheet, moved_strip, spike, NULL};
    int const is_present[4] = {1, 1, number != 3, 1};
    tulle_run_frame const frame = {
        .time = 0.1 * number, .step = number, .positions = positions, .is_present = is_present};
    tulle_error error;
    if (tulle_run_write_frame(writer, &frame, &error) != TULLE_OK) fail_msg("%s", error.message);
}

static void write_run(const char *path, uint32_t frame_count) {
    tulle_run_body const bodies[4] = {
        {.name = "sheet", .mesh = {sheet, 4, square, 2}},
        {.name = "strip", .mesh = {strip, 3, triangle, 1}},
        {.name = "spike", .mesh = {spike, 3, triangle, 1}, .is_obstacle = 1},
        {.name = "ground", .mesh = {ground, 3, triangle, 1}, .is_obstacle = 1, .is_static = 1}};
    tulle_run_def def = tulle_run_def_default();
    def.directory = path;
    def.scene_path = "scene.yaml";
    def.time_step = 0.1;
    def.steps_per_frame = 1;
    def.frame_count = FRAME_COUNT - 1;
    def.bodies = bodies;
    def.body_count = 4;
    tulle_run_writer *writer;
    tulle_error error;
    if (tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    for (uint32_t i = 0; i < frame_count; i++) write_frame(writer, i);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
}

/* Runs app_check with up to six arguments in a child process; returns its exit code and what it
 * wrote to both outputs. */
static int run_check(char *output, const char *const *arguments) {
    char path[64];
    snprintf(path, sizeof path, "%s/output", work);
    fflush(stdout);
    pid_t const child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        char copies[8][128];
        char *argv[9];
        int argc = 0;
        snprintf(copies[argc++], sizeof copies[0], "check");
        for (; *arguments; arguments++)
            snprintf(copies[argc++], sizeof copies[0], "%s", *arguments);
        for (int i = 0; i < argc; i++) argv[i] = copies[i];
        argv[argc] = NULL;
        if (!freopen(path, "w", stdout) || dup2(STDOUT_FILENO, STDERR_FILENO) < 0) _exit(99);
        int const code = app_check(argc, argv);
        fflush(stdout);
        _exit(code);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    FILE *const file = fopen(path, "r");
    assert_non_null(file);
    output[fread(output, 1, OUTPUT_LIMIT - 1, file)] = '\0';
    fclose(file);
    return WEXITSTATUS(status);
}

static void expect_text(const char *output, const char *text) {
    if (!strstr(output, text)) fail_msg("no \"%s\" in:\n%s", text, output);
}

static void every_frame_is_judged(void **unused) {
    (void)unused;
    static char output[OUTPUT_LIMIT];
    assert_int_equal(run_check(output, (const char *const[]){directory, NULL}), APP_EXIT_FALSE);
    expect_text(output, "frame 0 (0 s): 0 intersections\n");
    expect_text(output, "frame 1 (0.1 s): 0 intersections\n");
    expect_text(output, "frame 2 (0.2 s): 1 intersection\n"
                        "  sheet triangle 0 and spike triangle 0 near (0.6");
    expect_text(output, "frame 3 (0.3 s): 0 intersections\n"); /* the spike is away */
    expect_text(output, "frame 4 (0.4 s): 1 intersection\n");
    expect_text(output, "frame 5 (0.5 s): 1 intersection\n");
    expect_text(output, "frame 6 (0.6 s): 3 intersections\n"
                        "  sheet triangle 0 and strip triangle 0 near");
    expect_text(output, "  sheet triangle 1 and strip triangle 0 near");
    expect_text(output, "\n6 intersections in 4 of 7 frames\n");
    expect_text(output, directory);
}

static void threads_change_no_byte(void **unused) {
    (void)unused;
    static char first[OUTPUT_LIMIT], other[OUTPUT_LIMIT];
    static const char *const counts[] = {"2", "3", "16", "0"};
    for (int is_json = 0; is_json < 2; is_json++) {
        const char *const format = is_json ? "--json" : "--list=100";
        assert_int_equal(
            run_check(first, (const char *const[]){directory, "--threads", "1", format, NULL}),
            APP_EXIT_FALSE);
        for (int i = 0; i < 4; i++) {
            run_check(other, (const char *const[]){directory, "-t", counts[i], format, NULL});
            assert_string_equal(first, other);
        }
    }
    expect_text(first, "\"frame\":2,\"time\":0.2,\"intersections\":1,\"pairs\":[{\"a\":\"sheet\"");
    expect_text(first, "{\"frames\":7,\"frames_with_intersections\":4,");
}

static void clean_run_is_fine(void **unused) {
    (void)unused;
    static char output[OUTPUT_LIMIT];
    char path[64];
    snprintf(path, sizeof path, "%s/clean", work);
    write_run(path, 2);
    assert_int_equal(run_check(output, (const char *const[]){path, NULL}), APP_EXIT_FINE);
    expect_text(output, "\n0 intersections in 2 frames\n");
    /* Together with the other run, and again. */
    assert_int_equal(run_check(output, (const char *const[]){path, directory, path, NULL}),
                     APP_EXIT_FALSE);
    expect_text(output, " in 4 of 11 frames\n");
}

static void what_cannot_be_judged_is_refused(void **unused) {
    (void)unused;
    static char output[OUTPUT_LIMIT];
    char path[64];
    snprintf(path, sizeof path, "%s/none", work);
    write_run(path, 0);
    assert_int_equal(run_check(output, (const char *const[]){path, NULL}), APP_EXIT_BAD_INPUT);
    expect_text(output, "no whole frame");
    assert_int_equal(run_check(output, (const char *const[]){work, NULL}), APP_EXIT_BAD_INPUT);
    expect_text(output, "holds no run.json");
    assert_int_equal(run_check(output, (const char *const[]){directory, "--together", NULL}),
                     APP_EXIT_BAD_INPUT);
    assert_int_equal(
        run_check(output, (const char *const[]){directory, "--obstacle", "x.obj", NULL}),
        APP_EXIT_BAD_INPUT);
    /* A cloth's mesh file that is gone. */
    char command[256];
    snprintf(path, sizeof path, "%s/broken", work);
    write_run(path, 2);
    snprintf(command, sizeof command, "rm %s/sheet.obj", path);
    assert_int_equal(system(command), 0);
    assert_int_equal(run_check(output, (const char *const[]){path, NULL}), APP_EXIT_BAD_INPUT);
    expect_text(output, "sheet.obj");
}

static int set_up(void **unused) {
    (void)unused;
    if (!mkdtemp(work)) return -1;
    snprintf(directory, sizeof directory, "%s/run", work);
    write_run(directory, FRAME_COUNT);
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", work);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_frame_is_judged),
        cmocka_unit_test(threads_change_no_byte),
        cmocka_unit_test(clean_run_is_fine),
        cmocka_unit_test(what_cannot_be_judged_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
