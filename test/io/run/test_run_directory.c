/* Run directories: what is written comes back, existing directories are spared, runs are resumed.
 */
#define _XOPEN_SOURCE 700
#include "io/run/run_record.h"
#include "io/run/run_report.h"

#include "io/run_support.h"

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

/* Files of bodies that are called like devices of Windows get other names; others keep theirs. */
static void devices_are_no_files(void **state) {
    (void)state;
    static const char *const names[][2] = {
        {"con", "con_.obj"},  {"CON", "CON_-1.obj"},      {"co", "co.obj"},
        {"cons", "cons.obj"}, {"nul.1", "nul_.1.obj"},    {"Com7.x.y", "Com7_.x.y.obj"},
        {"lpt", "lpt.obj"},   {"lptx", "lptx.obj"},       {"prn.", "prn_..obj"},
        {"au", "au.obj"},     {"con.con", "con_.con.obj"}};
    enum { COUNT = sizeof names / sizeof names[0] };
    tulle_run_body shown[COUNT];
    tulle_run_def def = make_def(test_path("devices"), FRAME_COUNT);
    for (int i = 0; i < COUNT; i++) {
        shown[i] = bodies[0];
        shown[i].name = names[i][0];
    }
    def.bodies = shown;
    def.body_count = COUNT;
    tulle_run_writer *writer = NULL;
    tulle_error error = {0};
    if (tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error)) fail_msg("%s", error.message);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, NULL), TULLE_OK);
    tulle_run_reader *reader = NULL;
    assert_int_equal(tulle_run_reader_open(test_path("devices"), &reader, NULL), TULLE_OK);
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    for (int i = 0; i < COUNT; i++) assert_string_equal(info->bodies[i].mesh_file, names[i][1]);
    tulle_run_reader_close(reader);
}

/* A run that has more frames than are wanted stays as it is, its scene too. */
static void fewer_frames_change_nothing(void **state) {
    (void)state;
    const char *const directory = test_path("fewer");
    run_whole(directory, FRAME_COUNT);
    tulle_run_def def = make_def(directory, FRAME_COUNT - 1);
    def.scene_text = "cloth: [] # fewer frames\n";
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    tulle_error error = {0};
    if (tulle_run_resume(&def, &writer, &checkpoint, &error)) fail_msg("%s", error.message);
    assert_non_null(strstr(tulle_run_get_notes(writer),
                           "holds 12 frames after the start, more than the 11 that are wanted"));
    tulle_run_free_checkpoint(&checkpoint);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error), TULLE_OK);
    assert_same_run(directory, test_path("whole"));
    assert_int_equal(assert_sound(directory), FRAME_COUNT + 1);
    assert_int_equal(resume_run(directory, FRAME_COUNT, &error), TULLE_OK);
    assert_same_run(directory, test_path("whole"));
}

/* What is no lag is refused at its place. */
static void lags_are_read_with_care(void **state) {
    (void)state;
    static const struct {
        const char *lags;
        const char *message;
    } cases[] = {{"", NULL},
                 {"1:5:0.25:7", NULL},
                 {"1:5:0.25:7 2:0:1e-9:0", NULL},
                 {"1:5:0.25", "body:vertex:metres:crossings"},
                 {"1:5:0.25:7:", "body:vertex:metres:crossings"},
                 {"4:5:0.25:7", "a whole number from 0 to 3"},
                 {"1:5:-1:7", "a lag in metres"},
                 {"1:5:inf:7", "a lag in metres"},
                 {"1:-5:1:7", "a whole number"},
                 {"1:5:1:x", "a whole number"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[256];
        const char *const lags = cases[k].lags;
        snprintf(text, sizeof text, "frame,time,step,state_hash,absent,lags\n0,0,0,%016x,2,%s\n", 7,
                 lags);
        const char *const path = test_path("lags.csv");
        put_text(path, text);
        memory heap = memory_default();
        run_frames frames;
        tulle_error error = {0};
        tulle_status const status = run_frames_read(&frames, &heap, path, BODY_COUNT, &error);
        assert_int_equal(status, cases[k].message ? TULLE_ERROR_PARSE : TULLE_OK);
        if (cases[k].message && !strstr(error.message, cases[k].message))
            fail_msg("%s: %s", lags, error.message);
        if (cases[k].message) assert_int_equal(error.line, 2);
        size_t const expected = lags[0] ? (strchr(lags, ' ') ? 2 : 1) : 0;
        if (status == TULLE_OK) {
            assert_int_equal(frames.lines.count, 1);
            assert_int_equal(frames.lines.data[0].absent_count, 1);
            assert_int_equal(frames.lines.data[0].lag_count, expected);
        }
        for (size_t i = 0; status == TULLE_OK && i < expected; i++) {
            assert_int_equal(frames.lags.data[i].body, i + 1);
            assert_true(frames.lags.data[i].lag == (i == 0 ? 0.25 : 1e-9));
        }
        run_frames_destroy(&frames);
    }
    tulle_run_def const def = make_def(test_path("lagging"), FRAME_COUNT);
    tulle_run_writer *writer = NULL;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL), TULLE_OK);
    double positions[3 * CLOTH_VERTICES] = {0};
    const double *const pointers[BODY_COUNT] = {positions, positions, positions, NULL};
    tulle_transform const transform = {0};
    tulle_run_lag const bad[][2] = {{{BODY_COUNT, 0, 1.0, 0}, {0}},
                                    {{1, 0, 1.0, 0}, {1, 0, 1.0, 0}},
                                    {{1, 0, 0.0, 0}, {2, 0, 1.0, 0}},
                                    {{1, 0, (double)INFINITY, 0}, {2, 0, 1.0, 0}}};
    for (size_t k = 0; k <= sizeof bad / sizeof bad[0]; k++) {
        tulle_run_frame const frame = {.positions = pointers,
                                       .transforms = &transform,
                                       .lags = k < sizeof bad / sizeof bad[0] ? bad[k] : NULL,
                                       .lag_count = 2};
        assert_int_equal(tulle_run_write_frame(writer, &frame, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    }
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, NULL), TULLE_OK);
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
    assert_non_null(strstr(error.message, "an earlier build of tulle began the run"));
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

/* Gives a run the checkpoint of another one, which differs in nothing but the hash of its scene. */
static void plant_checkpoint(const char *from, const char *to, const char *name) {
    char path[1024];
    size_t size;
    snprintf(path, sizeof path, "%s/checkpoint.bin", from);
    char *const bytes = get_file(path, &size);
    snprintf(path, sizeof path, "%s/%s", to, name);
    put_file(path, bytes, size);
    free(bytes);
}

/* The one before takes its place; where there is none, nothing of the other scene is handed out. */
static void a_checkpoint_of_another_scene_is_passed_over(void **state) {
    (void)state;
    const char *const own = test_path("own"), *const other = test_path("other_scene");
    run_whole(own, FRAME_COUNT);
    tulle_run_def def = make_def(other, FRAME_COUNT);
    def.scene_hash++;
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint = {0};
    tulle_error error = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
    assert_int_equal(go_on(writer, &checkpoint, FRAME_COUNT, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error), TULLE_OK);
    plant_checkpoint(other, own, "checkpoint.bin");
    def = make_def(own, FRAME_COUNT);
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error), TULLE_OK);
    assert_non_null(strstr(tulle_run_get_notes(writer),
                           "the checkpoint is of another scene; the "
                           "run continues from the checkpoint before"));
    assert_int_equal(go_on(writer, &checkpoint, FRAME_COUNT, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error), TULLE_OK);
    assert_same_run(own, test_path("whole"));
    plant_checkpoint(other, own, "checkpoint.bin");
    plant_checkpoint(other, own, "checkpoint.previous.bin");
    assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "the checkpoint is of another scene; neither"));
}

static void runs_of_other_versions_are_refused(void **state) {
    (void)state;
    const char *const directory = test_path("older");
    run_whole(directory, 3);
    size_t size;
    char *const text = get_file(test_path("older/run.json"), &size);
    char *const place = strstr(text, "\"format_version\": 3");
    assert_non_null(place);
    place[strlen("\"format_version\": ")] = '2';
    seal_record(text);
    put_file(test_path("older/run.json"), text, size);
    free(text);
    tulle_run_reader *reader = NULL;
    tulle_error error;
    assert_int_equal(tulle_run_reader_open(directory, &reader, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "format version 2, of another version of tulle; only 3"));
    assert_int_equal(resume_run(directory, FRAME_COUNT, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "format version 2, of another version of tulle; only 3"));
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
    assert_int_equal(commas_line, commas_heading);
    assert_non_null(strstr(line, "18446744073709551615,0.25,,"));
    char expected[RUN_REPORT_LINE_SIZE] = "step,time,total_seconds,";
    for (int stage = 0; stage < TULLE_STAGE_COUNT; stage++) {
        size_t const used = strlen(expected);
        snprintf(expected + used, sizeof expected - used, "%s_seconds,", tulle_stage_name(stage));
    }
    assert_memory_equal(heading, expected, strlen(expected));
}

/* run.json says how pairs were found; what it does not know or does not say is told apart. */
static void detection_comes_back(void **state) {
    (void)state;
    tulle_world_detection const given = {TULLE_DETECT_PAPER, TULLE_CONE_PAPER, 0.75, 0, 1};
    for (int k = 0; k < 2; k++) {
        tulle_run_def def = make_def(test_path(k ? "detection" : "no-detection"), 1);
        def.detection = k ? &given : NULL;
        def.has_response = k;
        def.response = TULLE_RESPONSE_PAPER;
        def.motion_space = TULLE_MOTION_SPACE_CONE;
        tulle_run_writer *writer = NULL;
        assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL), TULLE_OK);
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL), TULLE_OK);
        tulle_run_reader *reader = NULL;
        assert_int_equal(tulle_run_reader_open(def.directory, &reader, NULL), TULLE_OK);
        const tulle_world_detection *const found = tulle_run_reader_get_info(reader)->detection;
        assert_int_equal(found != NULL, k);
        const tulle_run_info *const info = tulle_run_reader_get_info(reader);
        assert_int_equal(info->has_response, k);
        if (k) {
            assert_int_equal(info->response, TULLE_RESPONSE_PAPER);
            assert_int_equal(info->motion_space, TULLE_MOTION_SPACE_CONE);
        }
        if (found) {
            assert_int_equal(found->method, given.method);
            assert_int_equal(found->cone, given.cone);
            assert_true(found->max_angle == given.max_angle);
            assert_int_equal(found->has_certificate, 0);
            assert_int_equal(found->grows_patches_anew, 1);
        }
        tulle_run_reader_close(reader);
    }
}

/* What this version writes comes back; with a column less or more it is refused. */
static void reports_come_back(void **state) {
    (void)state;
    memory heap = memory_default();
    char text[2][RUN_REPORT_LINE_SIZE];
    tulle_step_report report = {.step = 7,
                                .pinched = 1,
                                .turning_pairs = 3,
                                .smallest_gap = 0.5,
                                .overstretched = 9,
                                .largest_lag = 0.25};
    for (int k = 0; k < TULLE_STAGE_COUNT; k++) report.stage_seconds[k] = 0.1 * (k + 1);
    run_report_format_heading(text[0]);
    run_report_format(&report, text[1]);
    static const struct {
        const char *dropped, *added;
        bool is_read;
    } cases[] = {{"", "", true}, {",largest_lag", "", false}, {"", ",more", false}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const char *const path = test_path("whole.csv");
        FILE *const file = fopen(path, "w");
        assert_non_null(file);
        size_t const kept = strlen(text[0]) - 1 - strlen(cases[k].dropped);
        assert_memory_equal(text[0] + kept, cases[k].dropped, strlen(cases[k].dropped));
        size_t dropped = 0;
        for (const char *c = cases[k].dropped; *c; c++) dropped += *c == ',';
        size_t length = strlen(text[1]) - 1;
        for (size_t i = 0; i < dropped; i++)
            while (text[1][--length] != ',') {}
        fprintf(file, "%.*s%s\n%.*s\n", (int)kept, text[0], cases[k].added, (int)length, text[1]);
        fclose(file);
        run_report_rows rows = {0};
        tulle_status const status = run_report_read(&heap, path, &rows, NULL);
        assert_int_equal(status, cases[k].is_read ? TULLE_OK : TULLE_ERROR_PARSE);
        assert_int_equal(rows.count, cases[k].is_read ? 1 : 0);
        for (size_t i = 0; i < rows.count; i++) {
            assert_memory_equal(rows.data[i].stage_seconds, report.stage_seconds,
                                sizeof report.stage_seconds);
            assert_int_equal(rows.data[i].step, 7);
            assert_int_equal(rows.data[i].pinched, 1);
            assert_int_equal(rows.data[i].turning_pairs, 3);
            assert_int_equal(rows.data[i].overstretched, 9);
            assert_true(rows.data[i].largest_lag == 0.25);
            assert_true(rows.data[i].smallest_gap == 0.5);
        }
        ARRAY_FREE(&heap, &rows);
    }
}

/* A run has the files of what it has. */
static void without_bodies_there_is_no_file_of_them(void **state) {
    (void)state;
    tulle_run_def def = make_def(test_path("cloth"), 2);
    def.body_count = 2; /* cloths */
    tulle_run_writer *writer = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
    assert_int_equal(access(test_path("cloth/bodies.csv"), F_OK), -1);
    assert_int_equal(access(test_path("cloth/sheet.pc2"), F_OK), 0);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_RUNNING, NULL, &error), TULLE_OK);
}

int main(void) {
    make_bodies();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_comes_back),
        cmocka_unit_test(devices_are_no_files),
        cmocka_unit_test(fewer_frames_change_nothing),
        cmocka_unit_test(lags_are_read_with_care),
        cmocka_unit_test(existing_directories_are_spared),
        cmocka_unit_test(without_bodies_there_is_no_file_of_them),
        cmocka_unit_test(a_leftover_of_the_first_file_does_not_matter),
        cmocka_unit_test(a_second_writer_is_kept_out),
        cmocka_unit_test(bad_defs_and_places_create_nothing),
        cmocka_unit_test(only_the_same_scene_is_resumed),
        cmocka_unit_test(a_checkpoint_of_another_scene_is_passed_over),
        cmocka_unit_test(runs_of_other_versions_are_refused),
        cmocka_unit_test(paraview_files),
        cmocka_unit_test(report_lines_fit_their_heading),
        cmocka_unit_test(detection_comes_back),
        cmocka_unit_test(reports_come_back),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
