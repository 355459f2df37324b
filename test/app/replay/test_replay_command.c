/* `tulle replay` on recordings in files: exit codes, and what it says of whole ones, of ones that
 * are cut off, damaged or foreign, and of one that comes to something else. */
#define _POSIX_C_SOURCE 200809L
#include "app/commands.h"
#include "support/recording.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "world/record/recorded_call.h"

#include <stdio.h>
#include <unistd.h>

static char folder[] = "/tmp/tulle_replay_XXXXXX", file_path[64], output_path[64];
static recording whole;

static void put_file(const void *bytes, size_t byte_count) {
    FILE *const file = fopen(file_path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, byte_count, file), byte_count);
    assert_int_equal(fclose(file), 0);
}

/* Runs the command with both outputs in a file; the exit code and `wanted` in the output. */
static void expect(int code, const char *wanted, const char *option, const char *value) {
    char words[4][64] = {"replay"};
    char *argv[5] = {words[0], words[1], words[2], words[3], NULL};
    snprintf(words[1], sizeof words[1], "%s", file_path);
    if (option) snprintf(words[2], sizeof words[2], "%s", option);
    if (option) snprintf(words[3], sizeof words[3], "%s", value);
    fflush(NULL);
    int const outputs[2] = {dup(STDOUT_FILENO), dup(STDERR_FILENO)};
    FILE *const file = fopen(output_path, "w+");
    assert_non_null(file);
    dup2(fileno(file), STDOUT_FILENO);
    dup2(fileno(file), STDERR_FILENO);
    int const found = app_replay(option ? 4 : 2, argv);
    fflush(NULL);
    dup2(outputs[0], STDOUT_FILENO);
    dup2(outputs[1], STDERR_FILENO);
    close(outputs[0]);
    close(outputs[1]);
    char text[4096] = "";
    rewind(file);
    (void)!fread(text, 1, sizeof text - 1, file);
    fclose(file);
    if (found != code || !strstr(text, wanted))
        fail_msg("exit %d, not %d; \"%s\" in:\n%s", found, code, wanted, text);
}

static int set_up(void **unused) {
    (void)unused;
    if (!mkdtemp(folder)) return 1;
    snprintf(file_path, sizeof file_path, "%s/calls", folder);
    snprintf(output_path, sizeof output_path, "%s/output", folder);
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_record_writer const writer = recording_begin(&whole);
    assert_int_equal(tulle_world_record(world, &writer, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.1, 3, 0.0);
    small_add_cloth(world, &sheet);
    for (int i = 0; i < 6; i++)
        assert_int_equal(tulle_world_step(world, 0.125, NULL, NULL), TULLE_OK);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    free(whole.bytes);
    unlink(file_path);
    unlink(output_path);
    return rmdir(folder);
}

static void whole_ones(void **unused) {
    (void)unused;
    put_file(whole.bytes, whole.byte_count);
    expect(APP_EXIT_FINE, "8 calls, 6 steps to 0.75 s: the same states", NULL, NULL);
    expect(APP_EXIT_FINE, "5 calls, 3 steps to 0.375 s: the same states", "--until", "3");
    expect(APP_EXIT_FINE, "6 steps", "--threads", "2");
    expect(APP_EXIT_BAD_INPUT, "until", "--until", "0");
    expect(APP_EXIT_BAD_INPUT, "threads", "--threads", "257");
}

static void bad_ones(void **unused) {
    (void)unused;
    put_file(whole.bytes, whole.byte_count - 30);
    expect(APP_EXIT_FINE, "the recording is cut off behind call 8, tulle_world_step", NULL, NULL);
    put_file("", 0);
    expect(APP_EXIT_BAD_INPUT, "not a recording of a world", NULL, NULL);
    put_file("TULLREC9", 8);
    expect(APP_EXIT_BAD_INPUT, "another version of the format", NULL, NULL);
    unsigned char *const byte = &whole.bytes[whole.byte_count - 100];
    *byte ^= 4;
    put_file(whole.bytes, whole.byte_count);
    *byte ^= 4;
    expect(APP_EXIT_BAD_INPUT, "damaged; 7 calls before it were repeated", NULL, NULL);
    unlink(file_path);
    expect(APP_EXIT_BAD_INPUT, "No such file", NULL, NULL);
}

/* The hash, then the status in the result of the second step. */
static void different_ones(void **unused) {
    (void)unused;
    for (int k = 0; k < 2; k++) {
        size_t place = RECORD_MAGIC_BYTES, begin = place, results = 0;
        for (uint32_t kind = 0; results < 2; results += kind == RECORD_RESULT) {
            begin = place;
            assert_true(recording_next(whole.bytes, whole.byte_count, &place, &kind));
        }
        unsigned char *const number = whole.bytes + begin + RECORD_HEAD_BYTES + (k == 0 ? 24 : 16);
        unsigned char const old = *number;
        *number = k == 0 ? (unsigned char)(old ^ 2) : TULLE_ERROR_PINCHED;
        record_seal(whole.bytes + begin, place - begin);
        put_file(whole.bytes, whole.byte_count);
        expect(APP_EXIT_FALSE, "tulle_world_step, call 4, step 2, byte ", NULL, NULL);
        expect(APP_EXIT_FALSE, k == 0 ? "the state has hash" : "recorded as \"", NULL, NULL);
        *number = old;
        record_seal(whole.bytes + begin, place - begin);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_ones),
        cmocka_unit_test(bad_ones),
        cmocka_unit_test(different_ones),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
