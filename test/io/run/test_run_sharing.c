/* Run directories that hold what is not the run's: files of the user, another run that takes the
 * directory's place. All of it stays as it was. */
#define _DEFAULT_SOURCE
#include "io/run_support.h"

#include <errno.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

/* The system's flock stands aside for this one, which fails with an errno, unless that is 0. */
static int lock_errno;

int flock(int file, int operation) {
    if (lock_errno == 0) return (int)syscall(SYS_flock, file, operation);
    errno = lock_errno;
    return -1;
}

/* File systems that know no locks hold runs, too; any other failure of a lock is told. */
static void a_run_is_written_where_there_are_no_locks(void **state) {
    (void)state;
    static const int unknown[] = {ENOSYS, EOPNOTSUPP, ENOLCK, EINVAL};
    static const struct {
        int code;
        const char *said;
    } failures[] = {{EWOULDBLOCK, "another process is writing a run here"},
                    {EIO, "cannot be locked"},
                    {EINTR, "cannot be locked"}};
    const char *const directory = test_path("unlocked");
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++) {
        lock_errno = unknown[i];
        run_whole(directory, 1);
        remove_tree(directory);
    }
    tulle_run_def const def = make_def(directory, 1);
    for (size_t i = 0; i < sizeof failures / sizeof *failures; i++) {
        tulle_run_writer *writer = NULL;
        tulle_error error;
        lock_errno = failures[i].code;
        assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_ERROR_IO);
        assert_null(writer);
        assert_non_null(strstr(error.message, failures[i].said));
    }
    lock_errno = 0;
    run_whole(directory, 1);
    remove_tree(directory);
}

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

/* A run that cannot be made removes what it made. A file that has the name of one of its files, but
 * is not of the run that it replaces, is somebody's: then nothing is replaced. */
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
    size_t const file_count = count_files(directory);
    def.body_count = BODY_COUNT;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error), TULLE_ERROR_IO);
    assert_non_null(strstr(error.message, "does not belong to the run that is to be replaced"));
    assert_string_equal(error.file, test_path("failure/ground.obj"));
    assert_int_equal(count_files(directory), file_count);
    assert_sound(directory);
    assert_int_equal(unlink(error.file), 0);
    box_positions[5] = NAN; /* found out at the third body */
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error),
                     TULLE_ERROR_INVALID_MESH);
    make_bodies();
    assert_int_equal(count_files(directory), 0);
}

static const char precious[] = "precious";

static void assert_precious(const char *path) {
    size_t size;
    char *const text = get_file(path, &size);
    assert_string_equal(text, precious);
    free(text);
}

/* A run in whose directory a file is a link to a file elsewhere, or a pipe, is neither resumed nor
 * written over, and what the link leads to stays as it is. */
static void links_lead_nowhere(void **state) {
    (void)state;
    const char *const outside = test_path("outside");
    static const char *const more[] = {"frames.csv", "sheet.pvd", "vtp"};
    tulle_error error;
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    for (size_t i = 0; i < FILE_COUNT + 3; i++) {
        const char *const directory = test_path("links");
        tulle_run_def def = make_def(directory, 2);
        def.writes_vtp = 1;
        assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
        checkpoint = (tulle_run_checkpoint){0};
        assert_int_equal(go_on(writer, &checkpoint, 2, &error), TULLE_OK);
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, &error), TULLE_OK);
        const char *const name = i < FILE_COUNT ? all_files[i] : more[i - FILE_COUNT];
        char path[256], inner[300];
        snprintf(path, sizeof path, "%s/%s", directory, name);
        assert_int_equal(rename(path, outside), 0);
        snprintf(inner, sizeof inner, "%s%s", outside,
                 strcmp(name, "vtp") == 0 ? "/sheet.000001.vtp" : "");
        size_t size, size_after;
        char *const before = get_file(inner, &size);
        for (int is_pipe = 0; is_pipe < 2; is_pipe++) {
            if (strcmp(name, "run.json") == 0 && is_pipe) continue; /* then it is not a run */
            assert_int_equal(is_pipe ? mkfifo(path, 0666) : symlink(outside, path), 0);
            assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error), TULLE_ERROR_IO);
            if (!strstr(error.message, is_pipe ? "is not a " : "is a symbolic link"))
                fail_msg("%s: %s", error.file, error.message);
            assert_string_equal(error.file, path);
            assert_int_equal(remove(path), 0);
        }
        assert_int_equal(symlink(outside, path), 0);
        /* A link that has the name of a file of the former run goes; the folder is refused. */
        tulle_status const status = tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error);
        assert_int_equal(status, strcmp(name, "vtp") == 0 ? TULLE_ERROR_IO : TULLE_OK);
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
        char *const after = get_file(inner, &size_after);
        assert_int_equal(size_after, size);
        assert_memory_equal(after, before, size);
        free(before);
        free(after);
        remove_tree(outside);
        remove(path);
        remove_tree(directory);
    }
}

/* Links that no former run explains are refused before anything is written. */
static void a_new_run_is_not_written_through_links(void **state) {
    (void)state;
    const char *const directory = test_path("new");
    put_text(test_path("important"), precious);
    static const char *const names[] = {"new/ground.obj", "new/sheet.pc2", "new/bodies.csv"};
    for (int i = 0; i < 3; i++) {
        tulle_run_def def = make_def(directory, 1);
        tulle_run_writer *writer = NULL;
        tulle_error error;
        assert_int_equal(mkdir(directory, 0777), 0);
        put_text(test_path("new/run.json"), "{}"); /* of a run, but damaged */
        assert_int_equal(symlink(test_path("important"), test_path(names[i])), 0);
        assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error),
                         TULLE_ERROR_IO);
        assert_non_null(strstr(error.message, "is a symbolic link"));
        assert_precious(test_path("important"));
        assert_int_equal(count_files(directory), 2); /* run.json and the link */
        remove_tree(directory);
    }
}

/* Files of bodies that run.json puts elsewhere are neither read nor removed. */
static void names_lead_nowhere(void **state) {
    (void)state;
    const char *const directory = test_path("names");
    put_text(test_path("x.obj"), precious);
    put_text(test_path("x.pc2"), precious);
    char absolute[300];
    snprintf(absolute, sizeof absolute, "%s/x.obj", test_folder);
    const char *const names[] = {"../x.obj", "../x.pc2", absolute, "vtp/../../x.obj", "..",
                                 ".",        "",         ".x",     "a/b.obj"};
    static const char *const keys[] = {"\"mesh\": \"sheet.obj\"", "\"cache\": \"sheet.pc2\""};
    run_whole(directory, 1);
    size_t size;
    char *const text = get_file(test_path("names/run.json"), &size);
    for (size_t i = 0; i < 2 * sizeof names / sizeof names[0]; i++) {
        const char *const place = strstr(text, keys[i % 2]);
        assert_non_null(place);
        size_t const room = size + strlen(names[i / 2]) + 16;
        char *const changed = malloc(room);
        snprintf(changed, room, "%.*s\"%s\": \"%s\"%s", (int)(place - text), text,
                 i % 2 ? "cache" : "mesh", names[i / 2], place + strlen(keys[i % 2]));
        seal_record(changed);
        put_text(test_path("names/run.json"), changed);
        free(changed);
        tulle_run_reader *reader = NULL;
        tulle_error error;
        assert_int_equal(tulle_run_reader_open(directory, &reader, &error), TULLE_ERROR_PARSE);
        assert_non_null(strstr(error.message, "should be file names in this directory"));
        assert_int_equal(resume_run(directory, 1, &error), TULLE_ERROR_PARSE);
        tulle_run_def const def = make_def(directory, 1);
        tulle_run_writer *writer = NULL;
        assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error), TULLE_OK);
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
        assert_precious(test_path("x.obj"));
        assert_precious(test_path("x.pc2"));
    }
    free(text);
}

int main(void) {
    make_bodies();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_is_written_where_there_are_no_locks),
        cmocka_unit_test(a_directory_made_again_is_anothers),
        cmocka_unit_test(only_leftovers_of_the_run_are_removed),
        cmocka_unit_test(a_failure_removes_its_own_files),
        cmocka_unit_test(links_lead_nowhere),
        cmocka_unit_test(a_new_run_is_not_written_through_links),
        cmocka_unit_test(names_lead_nowhere),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
