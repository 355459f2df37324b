/* Run directories that meet trouble: killed at any moment, damaged, on a full disk or without
 * memory, they stay readable and can be resumed to the very same bytes. */
#define _GNU_SOURCE /* mount, syncfs */
#include "io/failing_heap.h"
#include "io/run_support.h"
#include "io/watched_flushes.h"

#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>

static int make_whole_run(void **state) {
    if (make_test_folder(state)) return -1;
    make_bodies();
    run_whole(test_path("whole"), FRAME_COUNT);
    return 0;
}

static void a_torn_checkpoint_falls_back(void **state) {
    (void)state;
    const char *const directory = test_path("torn");
    run_whole(directory, 5);
    size_t size;
    char *const bytes = get_file(test_path("torn/checkpoint.bin"), &size);
    tulle_error error;
    for (size_t cut = 0; cut < size; cut += 7) {
        put_file(test_path("torn/checkpoint.bin"), bytes, cut);
        assert_int_equal(resume_run(directory, 5, &error), TULLE_OK);
        assert_int_equal(assert_sound(directory), 6);
    }
    for (size_t bit = 0; bit < 8 * size; bit++) {
        bytes[bit / 8] ^= (char)(1 << bit % 8);
        put_file(test_path("torn/checkpoint.bin"), bytes, size);
        bytes[bit / 8] ^= (char)(1 << bit % 8);
        if (bit % 16 == 0) assert_int_equal(resume_run(directory, 5, &error), TULLE_OK);
    }
    put_file(test_path("torn/checkpoint.bin"), bytes, size - 1);
    put_file(test_path("torn/checkpoint.previous.bin"), bytes, size - 2);
    assert_int_equal(resume_run(directory, 5, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "neither checkpoint"));
    assert_int_equal(assert_sound(directory), 6);
    free(bytes);
}

/* A power failure may keep the count of a cache's frames and lose the frames. */
static void a_count_without_its_frames_is_no_damage(void **state) {
    (void)state;
    const char *const directory = test_path("ahead");
    run_whole(directory, 5);
    assert_int_equal(unlink(test_path("ahead/checkpoint.bin")), 0);
    size_t size;
    char *const bytes = get_file(test_path("ahead/sheet.pc2"), &size);
    bytes[28] = 77; /* frames, as the header says */
    put_file(test_path("ahead/sheet.pc2"), bytes, size);
    free(bytes);
    tulle_error error;
    if (resume_run(directory, FRAME_COUNT, &error)) fail_msg("%s: %s", error.file, error.message);
    assert_same_run(directory, test_path("whole"));
}

/* What a resume takes from under a reader is no damage. */
static void a_resume_misleads_no_reader(void **state) {
    (void)state;
    const char *const directory = test_path("read");
    run_whole(directory, 5);
    tulle_run_reader *reader = NULL;
    tulle_error error;
    assert_int_equal(tulle_run_reader_open(directory, &reader, &error), TULLE_OK);
    uint32_t const last = tulle_run_reader_get_info(reader)->frame_count - 1;
    double positions[3 * CLOTH_VERTICES];
    assert_int_equal(tulle_run_reader_read_positions(reader, last, 0, positions, &error), TULLE_OK);
    assert_int_equal(unlink(test_path("read/checkpoint.bin")), 0); /* so the last frames are cut */
    tulle_run_def const def = make_def(directory, FRAME_COUNT);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error), TULLE_OK);

    const tulle_run_damage *damages;
    const tulle_run_debug *debug;
    size_t count = 1;
    for (int what = 0; what < 3; what++) {
        tulle_status const status =
            what == 0   ? tulle_run_reader_find_damage(reader, &damages, &count, &error)
            : what == 1 ? tulle_run_reader_read_positions(reader, last, 0, positions, &error)
                        : tulle_run_reader_read_debug(reader, last, &debug, &error);
        assert_int_equal(status, TULLE_ERROR_IO);
        assert_non_null(strstr(error.message, "another process changed the run"));
    }
    assert_int_equal(count, 0);
    tulle_run_reader_close(reader);
    assert_sound(directory);
    assert_int_equal(go_on(writer, &checkpoint, FRAME_COUNT, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error), TULLE_OK);
    assert_same_run(directory, test_path("whole"));
}

/* A child is killed while it writes; then the run is resumed, killed again, and so on. */
static void killed_at_any_moment_it_resumes(void **state) {
    (void)state;
    const char *const directory = test_path("killed");
    int const kill_count = getenv("TULLE_TEST_LONG") ? 400 : 60;
    uint64_t seed = 77;
    int kills = 0;
    for (int round = 0; round < kill_count; round++) {
        pid_t const child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            tulle_error error = {0};
            tulle_status const status = resume_run(directory, FRAME_COUNT, &error);
            if (status) fprintf(stderr, "%s: %s\n", error.file, error.message);
            _exit(status ? 1 : 0);
        }
        useconds_t const wait = (useconds_t)(random_uniform(&seed) * 1500.0);
        usleep(wait);
        kill(child, SIGKILL);
        int ended = 0;
        assert_int_equal(waitpid(child, &ended, 0), child);
        kills += WIFSIGNALED(ended);
        assert_true(WIFSIGNALED(ended) || WEXITSTATUS(ended) == 0);
        if (tulle_run_is_directory(directory)) assert_sound(directory);
        if (round % 10 == 9) {
            tulle_error error = {0};
            if (resume_run(directory, FRAME_COUNT, &error))
                fail_msg("%s: %s", error.file, error.message);
            assert_same_run(directory, test_path("whole"));
            remove_tree(directory);
        }
    }
    print_message("%d of %d processes were killed before they ended\n", kills, kill_count);
    assert_true(kills > 0);
}

/* Opens and reads all of a directory whose file was damaged: OK or a clean error. */
static void try_directory(const char *directory) {
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    tulle_status status = tulle_run_reader_open(directory, &reader, &error);
    if (!status) {
        const tulle_run_info *const info = tulle_run_reader_get_info(reader);
        assert_true(info->frame_count <= 3);
        double *const positions = malloc(3 * sizeof(double) * CLOTH_VERTICES);
        for (size_t body = 0; body < info->body_count; body++) {
            tulle_mesh_view mesh;
            if (info->bodies[body].vertex_count > CLOTH_VERTICES ||
                tulle_run_reader_get_mesh(reader, body, &mesh, &error))
                continue;
            for (uint32_t frame = 0; frame < info->frame_count; frame++)
                tulle_run_reader_read_positions(reader, frame, body, positions, &error);
        }
        for (uint32_t frame = 0; frame < info->frame_count; frame++) {
            const tulle_run_debug *debug;
            tulle_run_reader_read_debug(reader, frame, &debug, &error);
        }
        free(positions);
    } else {
        assert_true(error.message[0] != '\0');
    }
    tulle_run_reader_close(reader);
}

static void damaged_files_do_no_harm(void **state) {
    (void)state;
    const char *const directory = test_path("damaged");
    run_whole(directory, 2);
    static const char *const names[] = {"damaged/run.json", "damaged/frames.csv",
                                        "damaged/sheet.pc2", "damaged/sheet.obj",
                                        "damaged/debug.bin"};
    for (int i = 0; i < 5; i++) {
        size_t size;
        char *const bytes = get_file(test_path(names[i]), &size);
        for (size_t cut = 0; cut < size; cut += 5) {
            put_file(test_path(names[i]), bytes, cut);
            try_directory(directory);
        }
        for (size_t bit = 0; bit < 8 * size; bit += 3) {
            bytes[bit / 8] ^= (char)(1 << bit % 8);
            put_file(test_path(names[i]), bytes, size);
            try_directory(directory);
            bytes[bit / 8] ^= (char)(1 << bit % 8);
        }
        put_file(test_path(names[i]), bytes, size);
        free(bytes);
    }
    assert_int_equal(assert_sound(directory), 3);
    remove(test_path("damaged/run.json"));
    tulle_run_reader *reader = NULL;
    assert_int_equal(tulle_run_reader_open(directory, &reader, NULL), TULLE_ERROR_IO);
}

/* A disk of 64 KiB fills up; what is on it stays whole, and the run goes on when there is room. */
static void a_full_disk_keeps_all_whole_frames(void **state) {
    (void)state;
    const char *const disk = test_path("disk");
    const char *const directory = test_path("disk/run");
    assert_int_equal(mkdir(disk, 0777), 0);
    if (geteuid() != 0 || mount("tmpfs", disk, "tmpfs", 0, "size=160k") != 0) {
        print_message("skipped: mounting a small disk needs root\n");
        skip();
    }
    tulle_error error = {0};
    tulle_status const status = resume_run(directory, 1000, &error);
    uint32_t const frame_count = status == TULLE_ERROR_DISK_FULL ? assert_sound(directory) : 0;
    bool const has_more_room = mount("tmpfs", disk, "tmpfs", MS_REMOUNT, "size=2m") == 0;
    tulle_status const resumed = resume_run(directory, frame_count + 2, &error);
    uint32_t const final_count = resumed ? 0 : assert_sound(directory);
    umount(disk);
    assert_int_equal(status, TULLE_ERROR_DISK_FULL);
    assert_true(frame_count > 5);
    assert_true(has_more_room);
    assert_int_equal(resumed, TULLE_OK);
    assert_int_equal(final_count, frame_count + 3);
}

/* Whichever allocation fails: a clean error, a directory that is sound or gone, and no leak that a
 * sanitizer would see. */
static void every_failing_allocation_while_writing(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    const char *const directory = test_path("memory");
    bool has_failed = true;
    long fail = 0;
    for (; has_failed; fail++) {
        tulle_error error = {0};
        remove_tree(directory);
        watch_heap(fail);
        tulle_status const status = resume_run(directory, 3, &error);
        has_failed = unwatch_heap();
        /* Clearing up leftovers may do without memory. */
        assert_true(status == TULLE_ERROR_OUT_OF_MEMORY || status == TULLE_OK);
        assert_int_equal(error.status, status);
        if (status == TULLE_OK || tulle_run_is_directory(directory)) assert_sound(directory);
    }
    assert_true(fail > 50);
    assert_int_equal(assert_sound(directory), 4);
    /* The same while an existing run is resumed. */
    has_failed = true;
    for (fail = 0; has_failed; fail++) {
        tulle_error error = {0};
        watch_heap(fail);
        tulle_status const status = resume_run(directory, 5, &error);
        has_failed = unwatch_heap();
        assert_true(status == TULLE_ERROR_OUT_OF_MEMORY || status == TULLE_OK);
        assert_true(assert_sound(directory) >= 4);
    }
    assert_int_equal(assert_sound(directory), 6);
    has_failed = true;
    for (fail = 0; has_failed; fail++) {
        tulle_run_reader *reader = NULL;
        watch_heap(fail);
        const tulle_run_debug *debug = NULL;
        tulle_status status = tulle_run_reader_open(directory, &reader, NULL);
        for (uint32_t frame = 0; frame < 6 && !status; frame++)
            status = tulle_run_reader_read_debug(reader, frame, &debug, NULL);
        has_failed = unwatch_heap();
        assert_true(status == TULLE_ERROR_OUT_OF_MEMORY || status == TULLE_OK);
        tulle_run_reader_close(reader);
    }
}

/* Whichever flush to disk fails, of a file, a folder or all: the error is told, and what is there
 * can be gone on with. */
static void every_failing_flush_or_rename_is_told(void **state) {
    (void)state;
    if (!HAS_WATCHED_FLUSHES) skip();
    const char *const directory = test_path("flushes");
    for (int is_resumed = 0; is_resumed < 2; is_resumed++) {
        bool has_failed = true;
        long fail = 0;
        for (; has_failed; fail++) {
            tulle_error error = {0};
            remove_tree(directory);
            if (is_resumed) assert_int_equal(resume_run(directory, 1, &error), TULLE_OK);
            flush_calls = 0;
            flush_fail = fail;
            tulle_status const status = resume_run(directory, 3, &error);
            has_failed = flush_calls > fail;
            flush_fail = -1;
            if (status != (has_failed ? TULLE_ERROR_IO : TULLE_OK))
                fail_msg("call %ld: status %d: %s: %s", fail, status, error.file, error.message);
            if (has_failed) assert_non_null(strstr(error.message, strerror(EIO)));
            if (access(test_path("flushes/checkpoint.bin"), F_OK) != 0)
                assert_int_not_equal(access(test_path("flushes/checkpoint.previous.bin"), F_OK), 0);
            assert_int_equal(resume_run(directory, 3, &error), TULLE_OK);
            assert_int_equal(assert_sound(directory), 4);
        }
        assert_true(fail > 15);
    }
}

/* Before a checkpoint gets its name, all files that were renamed are on the disk, also those that
 * are written anew without a new frame. */
static void a_checkpoint_counts_what_is_on_the_disk(void **state) {
    (void)state;
    if (!HAS_WATCHED_FLUSHES) skip();
    tulle_run_def def = make_def(test_path("on-disk"), 4);
    def.writes_vtp = 1;
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint = {0};
    early_checkpoints = checkpoints_renamed = 0;
    for (int is_resumed = 0; is_resumed < 2; is_resumed++) {
        assert_int_equal(is_resumed ? tulle_run_resume(&def, &writer, &checkpoint, NULL)
                                    : tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL),
                         TULLE_OK);
        assert_int_equal(go_on(writer, &checkpoint, is_resumed ? 4 : 2, NULL), TULLE_OK);
        assert_int_equal(write_checkpoint(writer, 42, 6, NULL), TULLE_OK);
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, NULL), TULLE_OK);
    }
    assert_true(checkpoints_renamed > 6);
    assert_int_equal(early_checkpoints, 0);
}

int main(void) {
    make_bodies();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_torn_checkpoint_falls_back),
        cmocka_unit_test(a_count_without_its_frames_is_no_damage),
        cmocka_unit_test(a_resume_misleads_no_reader),
        cmocka_unit_test(killed_at_any_moment_it_resumes),
        cmocka_unit_test(damaged_files_do_no_harm),
        cmocka_unit_test(a_full_disk_keeps_all_whole_frames),
        cmocka_unit_test(every_failing_allocation_while_writing),
        cmocka_unit_test(every_failing_flush_or_rename_is_told),
        cmocka_unit_test(a_checkpoint_counts_what_is_on_the_disk),
    };
    return cmocka_run_group_tests(tests, make_whole_run, remove_test_folder);
}
