/* Run directories: what is written comes back; killed at any moment, damaged or on a full disk,
 * they stay readable and can be resumed to the very same bytes. */
#define _DEFAULT_SOURCE /* mount */
#include "base/hash.h"
#include "io/run_report.h"

#include "io/failing_heap.h"
#include "io/io_support.h"
#include "tulle/io.h"
#include "tulle/run.h"

#include <math.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/mount.h>
#include <sys/wait.h>

/* A run without physics: the state is a number that each step mixes, frames follow from it. */
enum { FRAME_COUNT = 12, STEPS_PER_FRAME = 3, BODY_COUNT = 4, CLOTH_VERTICES = 30 };

static double cloth_positions[3 * CLOTH_VERTICES], box_positions[12];
static uint32_t cloth_triangles[3 * (CLOTH_VERTICES - 2)];
static const uint32_t box_triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
static tulle_run_body bodies[BODY_COUNT];

static void make_bodies(void) {
    uint64_t seed = 9;
    for (int i = 0; i < 3 * CLOTH_VERTICES; i++) cloth_positions[i] = random_uniform(&seed);
    for (int i = 0; i < 12; i++) box_positions[i] = random_uniform(&seed);
    for (uint32_t i = 0; i < 3 * (CLOTH_VERTICES - 2); i++) cloth_triangles[i] = i / 3 + i % 3;
    tulle_mesh_view const cloth = {cloth_positions, CLOTH_VERTICES, cloth_triangles,
                                   CLOTH_VERTICES - 2};
    tulle_mesh_view const box = {box_positions, 4, box_triangles, 4};
    bodies[0] = (tulle_run_body){.name = "sheet", .mesh = cloth};
    bodies[1] = (tulle_run_body){.name = "odd name/..", .mesh = cloth};
    bodies[2] = (tulle_run_body){.name = "Sheet", .mesh = box, .is_obstacle = 1};
    bodies[3] = (tulle_run_body){.name = "ground", .mesh = box, .is_obstacle = 1, .is_static = 1};
}

static tulle_run_def make_def(const char *directory, uint32_t frame_count) {
    tulle_run_def def = tulle_run_def_default();
    def.directory = directory;
    def.scene_path = "scenes/test.yaml";
    def.scene_text = "cloth: []\n";
    def.scene_hash = UINT64_C(0x123456789abcdef0);
    def.seed = UINT64_MAX;
    def.time_step = 0.01;
    def.steps_per_frame = STEPS_PER_FRAME;
    def.frame_count = frame_count;
    def.bodies = bodies;
    def.body_count = BODY_COUNT;
    return def;
}

static void find_positions(uint64_t state, int body, double *positions) {
    uint64_t seed = state + (uint64_t)body;
    size_t const count = 3 * bodies[body].mesh.vertex_count;
    for (size_t i = 0; i < count; i++) positions[i] = random_uniform(&seed);
}

static tulle_status write_frame(tulle_run_writer *writer, uint64_t state, uint64_t step,
                                tulle_error *error) {
    double positions[3][3 * CLOTH_VERTICES];
    for (int i = 0; i < 3; i++) find_positions(state, i, positions[i]);
    const double *const pointers[BODY_COUNT] = {positions[0], positions[1], positions[2], NULL};
    int const present[BODY_COUNT] = {1, 1, step < 18, 1};
    tulle_run_frame const frame = {.time = (double)step * 0.01,
                                   .step = step,
                                   .state_hash = hash_mix(state),
                                   .positions = pointers,
                                   .is_present = present};
    return tulle_run_write_frame(writer, &frame, error);
}

static tulle_status write_checkpoint(tulle_run_writer *writer, uint64_t state, uint64_t step,
                                     tulle_error *error) {
    tulle_run_checkpoint const checkpoint = {.bytes = &state,
                                             .byte_count = sizeof state,
                                             .step = step,
                                             .time = (double)step * 0.01,
                                             .state_hash = hash_mix(state)};
    return tulle_run_write_checkpoint(writer, &checkpoint, error);
}

static tulle_status write_report(tulle_run_writer *writer, uint64_t state, uint64_t step,
                                 tulle_error *error) {
    tulle_step_report const report = {.step = step,
                                      .time = (double)(step + 1) * 0.01,
                                      .contacts = state,
                                      .smallest_gap = INFINITY};
    return tulle_run_write_report(writer, &report, error);
}

/* Goes on from the writer's beginning or the checkpoint to the end; a checkpoint every 4 steps. */
static tulle_status go_on(tulle_run_writer *writer, tulle_run_checkpoint *checkpoint,
                          uint32_t frame_count, tulle_error *error) {
    uint64_t state = 42, step = 0;
    tulle_status status = TULLE_OK;
    if (checkpoint->bytes) {
        assert_int_equal(checkpoint->byte_count, sizeof state);
        memcpy(&state, checkpoint->bytes, sizeof state);
        assert_true(checkpoint->state_hash == hash_mix(state));
        step = checkpoint->step;
        assert_int_equal(checkpoint->frame_count, tulle_run_get_frame_count(writer));
        tulle_run_free_checkpoint(checkpoint);
    } else {
        status = write_frame(writer, state, step, error);
        if (!status) status = write_checkpoint(writer, state, step, error);
    }
    while (!status && step < (uint64_t)frame_count * STEPS_PER_FRAME) {
        state = hash_mix(state + 1);
        status = write_report(writer, state, step, error);
        step++;
        if (!status && step % STEPS_PER_FRAME == 0)
            status = write_frame(writer, state, step, error);
        if (!status && step % 4 == 0) status = write_checkpoint(writer, state, step, error);
    }
    if (!status) status = write_checkpoint(writer, state, step, error);
    return status;
}

static void run_whole(const char *directory, uint32_t frame_count) {
    tulle_run_def const def = make_def(directory, frame_count);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    tulle_error error = {0};
    if (tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error) ||
        go_on(writer, &none, frame_count, &error) ||
        tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error))
        fail_msg("%s: %s", error.file, error.message);
}

static tulle_status resume_run(const char *directory, uint32_t frame_count, tulle_error *error) {
    tulle_run_def const def = make_def(directory, frame_count);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    tulle_status status = tulle_run_resume(&def, &writer, &checkpoint, error);
    if (!status) status = go_on(writer, &checkpoint, frame_count, error);
    if (!status) return tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", error);
    if (writer) tulle_run_close(writer, TULLE_RUN_FAILED, NULL, NULL);
    return status;
}

static void assert_same_file(const char *a, const char *b, const char *name) {
    char path[1024];
    size_t size_a, size_b;
    snprintf(path, sizeof path, "%s/%s", a, name);
    char *const bytes_a = get_file(path, &size_a);
    snprintf(path, sizeof path, "%s/%s", b, name);
    char *const bytes_b = get_file(path, &size_b);
    if (size_a != size_b || memcmp(bytes_a, bytes_b, size_a) != 0)
        fail_msg("%s differs between %s and %s", name, a, b);
    free(bytes_a);
    free(bytes_b);
}

static const char *const all_files[] = {"run.json",
                                        "scene.yaml",
                                        "frames.csv",
                                        "report.csv",
                                        "checkpoint.bin",
                                        "sheet.obj",
                                        "sheet.pc2",
                                        "Sheet-2.obj",
                                        "Sheet-2.pc2",
                                        "ground.obj",
                                        "odd_name_...obj",
                                        "odd_name_...pc2",
                                        "checkpoint.previous.bin"};
enum { FILE_COUNT = sizeof all_files / sizeof all_files[0] };

static void assert_same_run(const char *a, const char *b) {
    assert_int_equal(count_files(a), FILE_COUNT);
    assert_int_equal(count_files(b), FILE_COUNT);
    /* The generation before depends on where the run was cut. */
    for (size_t i = 0; i + 1 < FILE_COUNT; i++) assert_same_file(a, b, all_files[i]);
}

/* Every whole frame of the directory is what was written; returns their number. */
static uint32_t assert_sound(const char *directory) {
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    if (tulle_run_reader_open(directory, &reader, &error))
        fail_msg("%s: %s", error.file, error.message);
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    uint64_t state = 42;
    for (uint32_t frame = 0; frame < info->frame_count; frame++) {
        double time;
        uint64_t step, hash;
        assert_int_equal(tulle_run_reader_get_frame(reader, frame, &time, &step, &hash), TULLE_OK);
        assert_int_equal(step, frame * STEPS_PER_FRAME);
        assert_true(time == (double)step * 0.01);
        assert_true(hash == hash_mix(state));
        for (int body = 0; body < BODY_COUNT; body++) {
            double expected[3 * CLOTH_VERTICES], read[3 * CLOTH_VERTICES];
            size_t const count = 3 * bodies[body].mesh.vertex_count;
            find_positions(state, body, expected);
            assert_int_equal(
                tulle_run_reader_read_positions(reader, frame, (size_t)body, read, &error),
                TULLE_OK);
            for (size_t i = 0; i < count; i++)
                assert_true(read[i] == (bodies[body].is_static ? box_positions[i]
                                                               : (double)(float)expected[i]));
            assert_int_equal(tulle_run_reader_is_present(reader, frame, (size_t)body),
                             body != 2 || step < 18);
        }
        for (int i = 0; i < STEPS_PER_FRAME; i++) state = hash_mix(state + 1);
    }
    uint32_t const frame_count = info->frame_count;
    tulle_run_reader_close(reader);
    return frame_count;
}

static void a_run_comes_back(void **state) {
    (void)state;
    const char *const directory = test_path("whole");
    run_whole(directory, FRAME_COUNT);
    assert_int_equal(count_files(directory), FILE_COUNT);
    assert_int_equal(assert_sound(directory), FRAME_COUNT + 1);
    assert_true(tulle_run_is_directory(directory));
    assert_false(tulle_run_is_directory(test_folder));
    tulle_run_reader *reader = NULL;
    assert_int_equal(tulle_run_reader_open(directory, &reader, NULL), TULLE_OK);
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    assert_string_equal(info->scene_path, "scenes/test.yaml");
    assert_string_equal(info->scene_text, "cloth: []\n");
    assert_string_equal(info->message, "all is well");
    assert_int_equal(info->state, TULLE_RUN_FINISHED);
    assert_true(info->scene_hash == UINT64_C(0x123456789abcdef0) && info->seed == UINT64_MAX);
    assert_true(info->time_step == 0.01);
    assert_int_equal(info->steps_per_frame, STEPS_PER_FRAME);
    assert_int_equal(info->wanted_frame_count, FRAME_COUNT);
    assert_int_equal(info->body_count, BODY_COUNT);
    assert_string_equal(info->bodies[1].name, "odd name/..");
    assert_string_equal(info->bodies[2].cache_file, "Sheet-2.pc2");
    assert_null(info->bodies[3].cache_file);
    assert_int_equal(info->has_checkpoint, 1);
    assert_int_equal(info->checkpoint_step, FRAME_COUNT * STEPS_PER_FRAME);
    tulle_mesh_view mesh;
    assert_int_equal(tulle_run_reader_get_mesh(reader, 0, &mesh, NULL), TULLE_OK);
    assert_memory_equal(mesh.positions, cloth_positions, sizeof cloth_positions);
    assert_memory_equal(mesh.triangles, cloth_triangles, sizeof cloth_triangles);
    double positions[3 * CLOTH_VERTICES];
    assert_int_equal(tulle_run_reader_read_positions(reader, FRAME_COUNT + 1, 0, positions, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_run_reader_get_frame(reader, FRAME_COUNT + 1, NULL, NULL, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_run_reader_close(reader);
}

static void existing_directories_are_spared(void **state) {
    (void)state;
    const char *const directory = test_path("spared");
    tulle_run_def const def = make_def(directory, FRAME_COUNT);
    tulle_run_writer *writer = NULL;
    tulle_error error;
    assert_int_equal(mkdir(directory, 0777), 0);
    put_text(test_path("spared/mine.txt"), "precious");
    for (int existing = 0; existing < 2; existing++)
        assert_int_equal(tulle_run_create(&def, (tulle_run_existing)existing, &writer, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
    tulle_run_checkpoint checkpoint;
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(count_files(directory), 1);
    remove(test_path("spared/mine.txt"));
    run_whole(directory, FRAME_COUNT); /* empty: fine */
    put_text(test_path("spared/mine.txt"), "precious");
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(assert_sound(directory), FRAME_COUNT + 1);
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, NULL), TULLE_OK);
    assert_int_equal(assert_sound(directory), 0);
    size_t size;
    free(get_file(test_path("spared/mine.txt"), &size));
    assert_int_equal(size, 8);
}

/* A writer killed while it made its very first file. */
static void a_leftover_of_the_first_file_does_not_matter(void **state) {
    (void)state;
    const char *const directory = test_path("leftover");
    assert_int_equal(mkdir(directory, 0777), 0);
    put_text(test_path("leftover/run.json.12-0.tmp"), "{");
    tulle_error error = {0};
    assert_int_equal(resume_run(directory, FRAME_COUNT, &error), TULLE_OK);
    assert_same_run(directory, test_path("whole"));
}

static void a_second_writer_is_kept_out(void **state) {
    (void)state;
    tulle_run_def const def = make_def(test_path("locked"), FRAME_COUNT);
    tulle_run_writer *writer = NULL, *second = NULL;
    tulle_run_checkpoint checkpoint;
    tulle_error error;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL), TULLE_OK);
    assert_int_equal(tulle_run_resume(&def, &second, &checkpoint, &error), TULLE_ERROR_IO);
    assert_non_null(strstr(error.message, "another process"));
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &second, &error), TULLE_ERROR_IO);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL), TULLE_OK);
}

static void bad_defs_and_places_create_nothing(void **state) {
    (void)state;
    tulle_run_writer *writer = NULL;
    tulle_error error;
    assert_int_equal(mkdir(test_path("bad"), 0777), 0);
    tulle_run_def def = make_def(test_path("bad/run"), 1);
    def.cookie = 0;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    def = make_def(test_path("bad/run"), 1);
    def.time_step = NAN;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    def = make_def(test_path("bad/missing/run"), 1);
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_ERROR_IO);
    def = make_def(test_path("bad/run"), 1);
    box_positions[5] = NAN; /* found out after the directory was made */
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error),
                     TULLE_ERROR_INVALID_MESH);
    make_bodies();
    assert_int_equal(count_files(test_path("bad")), 0);
    put_text(test_path("bad/file"), "x");
    def = make_def(test_path("bad/file"), 1);
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_ERROR_IO);
    assert_int_equal(count_files(test_path("bad")), 1);
}

static void only_the_same_scene_is_resumed(void **state) {
    (void)state;
    const char *const directory = test_path("same");
    run_whole(directory, 3);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    tulle_error error;
    tulle_run_def def = make_def(directory, 3);
    def.scene_hash++;
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "the scene was changed"));
    def = make_def(directory, 3);
    def.body_count = 3;
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    def = make_def(directory, 3);
    def.time_step = 0.02;
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(assert_sound(directory), 4);
    /* Longer than before is fine. */
    assert_int_equal(resume_run(directory, FRAME_COUNT, &error), TULLE_OK);
    assert_same_run(directory, test_path("whole"));
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
                                        "damaged/sheet.pc2", "damaged/sheet.obj"};
    for (int i = 0; i < 4; i++) {
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

static void paraview_files(void **state) {
    (void)state;
    const char *const directory = test_path("vtk");
    tulle_run_def def = make_def(directory, FRAME_COUNT);
    def.writes_vtp = 1;
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL), TULLE_OK);
    assert_int_equal(go_on(writer, &none, FRAME_COUNT, NULL), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL), TULLE_OK);
    assert_int_equal(count_files(directory), FILE_COUNT + BODY_COUNT + 1);
    assert_int_equal(count_files(test_path("vtk/vtp")), 3 * (FRAME_COUNT + 1) + 1);
    size_t size;
    char *text = get_file(test_path("vtk/sheet.pvd"), &size);
    assert_non_null(strstr(text, "timestep=\"0.36\" group=\"\" part=\"0\" "
                                 "file=\"vtp/sheet.000012.vtp\""));
    free(text);
    text = get_file(test_path("vtk/Sheet-2.pvd"), &size); /* gone after step 17 */
    assert_non_null(strstr(text, "vtp/Sheet-2.000005.vtp"));
    assert_null(strstr(text, "vtp/Sheet-2.000006.vtp"));
    free(text);
    free(get_file(test_path("vtk/vtp/ground.vtp"), &size));
    /* Replacing removes them all. */
    def.writes_vtp = 0;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, NULL), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL), TULLE_OK);
    assert_int_equal(count_files(directory), FILE_COUNT - 2);
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
        tulle_status const status = tulle_run_reader_open(directory, &reader, NULL);
        has_failed = unwatch_heap();
        assert_true(status == TULLE_ERROR_OUT_OF_MEMORY || status == TULLE_OK);
        tulle_run_reader_close(reader);
    }
}

static void report_lines_fit_their_heading(void **state) {
    (void)state;
    char heading[RUN_REPORT_LINE_SIZE], line[RUN_REPORT_LINE_SIZE];
    tulle_step_report report;
    memset(&report, 0xff, sizeof report);
    report.smallest_gap = INFINITY;
    report.time = 0.25;
    size_t const length = run_report_format_heading(heading);
    assert_int_equal(length, strlen(heading));
    size_t const line_length = run_report_format(&report, line);
    assert_int_equal(line_length, strlen(line));
    size_t commas_heading = 0, commas_line = 0;
    for (const char *c = heading; *c; c++) commas_heading += *c == ',';
    for (const char *c = line; *c; c++) commas_line += *c == ',';
    assert_int_equal(commas_heading, run_report_get_column_count() - 1);
    assert_int_equal(commas_line, commas_heading);
    assert_non_null(strstr(line, "18446744073709551615,0.25,,"));
    for (int stage = 0; stage < TULLE_STAGE_COUNT; stage++) {
        char name[64];
        snprintf(name, sizeof name, "%s_seconds", tulle_stage_name(stage));
        assert_string_equal(run_report_get_column_name(3 + (size_t)stage), name);
    }
}

int main(void) {
    make_bodies();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_comes_back),
        cmocka_unit_test(existing_directories_are_spared),
        cmocka_unit_test(a_leftover_of_the_first_file_does_not_matter),
        cmocka_unit_test(a_second_writer_is_kept_out),
        cmocka_unit_test(bad_defs_and_places_create_nothing),
        cmocka_unit_test(only_the_same_scene_is_resumed),
        cmocka_unit_test(a_torn_checkpoint_falls_back),
        cmocka_unit_test(killed_at_any_moment_it_resumes),
        cmocka_unit_test(damaged_files_do_no_harm),
        cmocka_unit_test(a_full_disk_keeps_all_whole_frames),
        cmocka_unit_test(paraview_files),
        cmocka_unit_test(every_failing_allocation_while_writing),
        cmocka_unit_test(report_lines_fit_their_heading),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
