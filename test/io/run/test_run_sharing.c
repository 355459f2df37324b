/* Run directories that hold what is not the run's: files of the user, another run that takes the
 * directory's place. All of it stays as it was. */
#define _XOPEN_SOURCE 700
#include "io/run_support.h"

/* The directory of a writer is moved away, and another run takes its place. */
static void a_directory_made_again_is_anothers(void **state) {
    (void)state;
    const char *const directory = test_path("again");
    tulle_run_def const def = make_def(directory, 2);
    tulle_run_writer *writer = NULL;
    tulle_error error;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL), TULLE_OK);
    assert_int_equal(write_frame(writer, 42, 0, NULL), TULLE_OK);
    assert_int_equal(rename(directory, test_path("moved")), 0);
    run_whole(directory, 2);
    run_whole(test_path("same"), 2);
    assert_int_equal(write_frame(writer, 43, 3, &error), TULLE_ERROR_IO);
    assert_non_null(strstr(error.message, "was moved, removed or replaced"));
    assert_int_equal(write_checkpoint(writer, 43, 3, &error), TULLE_ERROR_IO);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FAILED, "moved", &error), TULLE_ERROR_IO);
    assert_same_run(directory, test_path("same"));
}

/* Of files that look like leftovers of killed writers, only those of the run's files go. */
static void only_leftovers_of_the_run_are_removed(void **state) {
    (void)state;
    static const char *const kept[] = {".tmp",           "-.tmp",           "1-2.tmp",
                                       ".1-2.tmp",       "12345678.tmp",    "notes.2024-11.tmp",
                                       "run.json.1-",    "run.json.-1.tmp", "run.json.1-.tmp",
                                       "run.json.12.tmp"};
    static const char *const removed[] = {"run.json.1-2.tmp", "checkpoint.bin.77-10.tmp",
                                          "sheet.pc2.12-0.tmp", "ground.obj.1234567-999.tmp"};
    enum { KEPT = sizeof kept / sizeof kept[0], REMOVED = sizeof removed / sizeof removed[0] };
    const char *const directory = test_path("leftovers");
    run_whole(directory, 2);
    char path[256];
    for (int i = 0; i < KEPT + REMOVED; i++) {
        snprintf(path, sizeof path, "%s/%s", directory, i < KEPT ? kept[i] : removed[i - KEPT]);
        put_text(path, "precious");
    }
    tulle_error error;
    assert_int_equal(resume_run(directory, 3, &error), TULLE_OK);
    tulle_run_def const def = make_def(directory, 2);
    tulle_run_writer *writer = NULL;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
    for (int i = 0; i < KEPT + REMOVED; i++) {
        snprintf(path, sizeof path, "%s/%s", directory, i < KEPT ? kept[i] : removed[i - KEPT]);
        if ((access(path, F_OK) == 0) != (i < KEPT)) fail_msg("%s", path);
    }
}

/* A run that cannot be made removes what it made, and nothing that it had not come to. */
static void a_failure_removes_its_own_files(void **state) {
    (void)state;
    const char *const directory = test_path("failure");
    tulle_run_def def = make_def(directory, 1);
    tulle_run_writer *writer = NULL;
    tulle_error error;
    def.body_count = 2;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
    put_text(test_path("failure/ground.obj"), "precious");
    def.body_count = BODY_COUNT;
    box_positions[5] = NAN; /* found out at the third body */
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error),
                     TULLE_ERROR_INVALID_MESH);
    make_bodies();
    assert_int_equal(count_files(directory), 1);
    size_t size;
    free(get_file(test_path("failure/ground.obj"), &size));
    assert_int_equal(size, strlen("precious"));
}

int main(void) {
    make_bodies();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_directory_made_again_is_anothers),
        cmocka_unit_test(only_leftovers_of_the_run_are_removed),
        cmocka_unit_test(a_failure_removes_its_own_files),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
