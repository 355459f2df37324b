/* Arguments of the public functions of tulle_io/run.h, against a run that is good. */
#define _XOPEN_SOURCE 700
#include "io/run_support.h"

#include "api/arguments.h"

static const char *run_path;
static double positions[3 * CLOTH_VERTICES]; /* of whatever is read */

static int set_up(void **state) {
    make_test_folder(state);
    make_bodies();
    run_path = test_path("run");
    run_whole(run_path, 2);
    return 0;
}

ARGUMENTS_OF(tulle_run_state_name) {
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_run_state state;
        SET_CHOICE(state, no_choices[i]);
        assert_null(tulle_run_state_name(state));
    }
}

ARGUMENTS_OF(tulle_run_def_default) { assert_true(tulle_run_def_default().cookie != 0); }

/* A def of a new directory that `change` has spoilt. */
static void refuse_run_def(const tulle_run_def *def) {
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    REFUSED(tulle_run_create(def, TULLE_RUN_REFUSE, &writer, &error));
    assert_null(writer);
    REFUSED(tulle_run_resume(def, &writer, &checkpoint, &error));
    assert_null(writer);
    assert_int_not_equal(access(test_path("new"), F_OK), 0);
}

ARGUMENTS_OF(tulle_run_create) {
    const char *const path = test_path("new");
    tulle_run_def def = make_def(path, 2);
    tulle_run_writer *writer = NULL;
    refuse_run_def(NULL);
    REFUSED(tulle_run_create(&def, TULLE_RUN_REFUSE, NULL, &error));
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_run_existing existing;
        SET_CHOICE(existing, no_choices[i]);
        tulle_run_def const over = make_def(run_path, 2);
        REFUSED(tulle_run_create(&over, existing, &writer, &error));
        assert_int_equal(tulle_run_is_directory(run_path), 1);
    }
    for (int i = 0; i < NO_NUMBER_COUNT - 1; i++) {
        def.time_step = no_numbers[i];
        refuse_run_def(&def);
    }
    def = make_def(NULL, 2);
    refuse_run_def(&def);
    def = make_def(path, 2);
    def.bodies = NULL;
    refuse_run_def(&def);
    size_t const counts[] = {0, SIZE_MAX};
    for (int i = 0; i < 2; i++) {
        def = make_def(path, 2);
        def.body_count = counts[i];
        refuse_run_def(&def);
    }
    def = make_def(path, 2);
    def.steps_per_frame = 0;
    refuse_run_def(&def);
    tulle_run_body bad[BODY_COUNT];
    for (int i = 0; i < 4; i++) {
        memcpy(bad, bodies, sizeof bad);
        if (i == 0) bad[1].name = NULL;
        if (i == 1) bad[1].mesh.positions = NULL;
        if (i == 2) bad[1].mesh.triangles = NULL;
        if (i == 3) bad[1].mesh.vertex_count = SIZE_MAX;
        for (int with_vtp = 0; with_vtp < 2; with_vtp++) {
            def = make_def(path, 2);
            def.writes_vtp = with_vtp;
            def.bodies = bad;
            refuse_run_def(&def);
        }
    }
    def = make_def(path, 2);
    tulle_world_detection detection = tulle_paper_options_default().detection;
    SET_CHOICE(detection.method, no_choices[1]);
    SET_CHOICE(detection.cone, no_choices[0]);
    SET_CHOICE(def.response, no_choices[1]);
    SET_CHOICE(def.motion_space, no_choices[1]);
    def.has_response = 1; /* for the record: what has no name is left out */
    def.detection = &detection;
    def.scene_path = def.scene_text = NULL;
    def.threads = INT_MIN;
    FINE(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, NULL));
    FINE(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, NULL));
}

ARGUMENTS_OF(tulle_run_resume) {
    tulle_run_def const def = make_def(run_path, 2);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    REFUSED(tulle_run_resume(NULL, &writer, &checkpoint, &error));
    REFUSED(tulle_run_resume(&def, NULL, &checkpoint, &error));
    REFUSED(tulle_run_resume(&def, &writer, NULL, &error));
    assert_null(writer);
}

ARGUMENTS_OF(tulle_run_has_checkpoint) {
    assert_int_equal(tulle_run_has_checkpoint(NULL), 0);
    assert_int_equal(tulle_run_has_checkpoint(""), 0);
}
ARGUMENTS_OF(tulle_run_free_checkpoint) {
    tulle_run_checkpoint empty = {0};
    tulle_run_free_checkpoint(NULL);
    tulle_run_free_checkpoint(&empty);
}

static tulle_run_writer *make_writer(const char *name) {
    tulle_run_def const def = make_def(test_path(name), 2);
    tulle_run_writer *writer = NULL;
    FINE(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error));
    return writer;
}

ARGUMENTS_OF(tulle_run_write_frame) {
    tulle_run_writer *const writer = make_writer("frames");
    const double *all[BODY_COUNT] = {cloth_positions, cloth_positions, box_positions, NULL};
    const double *const some[BODY_COUNT] = {cloth_positions, NULL, box_positions, NULL};
    tulle_transform const transform = {.mass = 1.0};
    tulle_run_frame frame = {.positions = all, .transforms = &transform};
    REFUSED(tulle_run_write_frame(NULL, &frame, &error));
    REFUSED(tulle_run_write_frame(writer, NULL, &error));
    frame.positions = NULL;
    REFUSED(tulle_run_write_frame(writer, &frame, &error));
    frame.positions = some;
    REFUSED(tulle_run_write_frame(writer, &frame, &error));
    frame = (tulle_run_frame){.positions = all};
    REFUSED(tulle_run_write_frame(writer, &frame, &error));
    double bad[3 * CLOTH_VERTICES];
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        memcpy(bad, cloth_positions, sizeof bad);
        bad[3 * CLOTH_VERTICES - 1] = no_numbers[i];
        all[1] = bad;
        frame.transforms = &transform;
        REFUSED(tulle_run_write_frame(writer, &frame, &error));
    }
    all[1] = cloth_positions;
    debug_source source;
    find_debug(1, &source);
    for (int i = 0; i < 4; i++) {
        tulle_run_debug debug = source.debug;
        if (i == 0) debug.velocities = NULL;
        if (i == 1) debug.patch_labels = NULL;
        if (i == 2) debug.patch_counts = NULL;
        if (i == 3) debug.contacts = NULL, debug.contact_count = SIZE_MAX;
        frame.debug = &debug;
        REFUSED(tulle_run_write_frame(writer, &frame, &error));
    }
    assert_int_equal(tulle_run_get_frame_count(writer), 0);
    frame.debug = NULL;
    FINE(tulle_run_write_frame(writer, &frame, NULL));
    assert_int_equal(tulle_run_get_frame_count(writer), 1);
    FINE(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL));
}

ARGUMENTS_OF(tulle_run_write_report) {
    tulle_run_writer *const writer = make_writer("reports");
    tulle_step_report const report = {0};
    REFUSED(tulle_run_write_report(NULL, &report, &error));
    REFUSED(tulle_run_write_report(writer, NULL, &error));
    FINE(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL));
}

ARGUMENTS_OF(tulle_run_write_checkpoint) {
    tulle_run_writer *const writer = make_writer("checkpoints");
    tulle_run_checkpoint const empty = {0}, full = {.bytes = box_positions, .byte_count = 8};
    REFUSED(tulle_run_write_checkpoint(NULL, &full, &error));
    REFUSED(tulle_run_write_checkpoint(writer, NULL, &error));
    REFUSED(tulle_run_write_checkpoint(writer, &empty, &error));
    FINE(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL));
}

ARGUMENTS_OF(tulle_run_get_frame_count) { assert_int_equal(tulle_run_get_frame_count(NULL), 0); }

ARGUMENTS_OF(tulle_run_get_notes) { assert_string_equal(tulle_run_get_notes(NULL), ""); }

ARGUMENTS_OF(tulle_run_get_former_outcome) { assert_null(tulle_run_get_former_outcome(NULL)); }

ARGUMENTS_OF(tulle_run_outcome_add) {
    tulle_run_outcome outcome = {0};
    tulle_step_report const report = {0};
    tulle_run_outcome_add(NULL, &report);
    tulle_run_outcome_add(&outcome, NULL);
    assert_int_equal(outcome.steps, 0);
    tulle_run_outcome_add(&outcome, &report);
    assert_int_equal(outcome.steps, 1);
}

ARGUMENTS_OF(tulle_run_outcome_place) {
    tulle_run_outcome outcome = {0};
    tulle_stretch const stretch = {0};
    tulle_run_outcome_place(NULL, &stretch, 0);
    tulle_run_outcome_place(&outcome, NULL, 0);
    assert_int_equal(outcome.has_stretch_place, 0);
}

ARGUMENTS_OF(tulle_run_outcome_describe) {
    tulle_run_outcome const outcome = {.has_stretch_place = 1, .largest_stretch = 2.0};
    char text[8] = "before";
    tulle_run_outcome_describe(&outcome, "a", NULL, NULL, 8);
    tulle_run_outcome_describe(&outcome, "a", NULL, text, 0);
    assert_string_equal(text, "before");
    tulle_run_outcome_describe(&outcome, NULL, NULL, text, sizeof text);
    assert_string_equal(text, "cloth w");
    tulle_run_outcome_describe(NULL, "a", "b", text, sizeof text);
    assert_string_equal(text, "");
}

ARGUMENTS_OF(tulle_run_set_outcome) {
    tulle_run_writer *const writer = make_writer("outcomes");
    tulle_run_outcome const far = {
        .has_stretch_place = 1, .stretch_body = UINT32_MAX, .largest_stretch = (double)NAN};
    tulle_run_set_outcome(NULL, &far);
    tulle_run_set_outcome(writer, NULL);
    tulle_run_set_outcome(writer, &far);
    FINE(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL));
}

ARGUMENTS_OF(tulle_run_close) {
    FINE(tulle_run_close(NULL, TULLE_RUN_FINISHED, NULL, NULL));
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        static const char *const names[NO_CHOICE_COUNT] = {"c0", "c1", "c2", "c3"};
        tulle_run_writer *const writer = make_writer(names[i]);
        tulle_run_state state;
        SET_CHOICE(state, no_choices[i]);
        REFUSED(tulle_run_close(writer, state, NULL, &error)); /* released all the same */
        tulle_run_reader *reader = NULL;
        FINE(tulle_run_reader_open(test_path(names[i]), &reader, &error));
        assert_int_equal(tulle_run_reader_get_info(reader)->state, TULLE_RUN_RUNNING);
        tulle_run_reader_close(reader);
    }
}

ARGUMENTS_OF(tulle_run_is_directory) {
    assert_int_equal(tulle_run_is_directory(NULL), 0);
    assert_int_equal(tulle_run_is_directory(""), 0);
}

static tulle_run_reader *make_reader(void) {
    tulle_run_reader *reader = NULL;
    FINE(tulle_run_reader_open(run_path, &reader, &error));
    return reader;
}

ARGUMENTS_OF(tulle_run_reader_open) {
    tulle_run_reader *reader = NULL;
    REFUSED(tulle_run_reader_open(NULL, &reader, &error));
    REFUSED(tulle_run_reader_open(run_path, NULL, &error));
    assert_null(reader);
}
ARGUMENTS_OF(tulle_run_reader_close) { tulle_run_reader_close(NULL); }
ARGUMENTS_OF(tulle_run_reader_get_info) { assert_null(tulle_run_reader_get_info(NULL)); }

ARGUMENTS_OF(tulle_run_reader_get_mesh) {
    tulle_run_reader *const reader = make_reader();
    tulle_mesh_view mesh;
    REFUSED(tulle_run_reader_get_mesh(NULL, 0, &mesh, &error));
    REFUSED(tulle_run_reader_get_mesh(reader, 0, NULL, &error));
    REFUSED(tulle_run_reader_get_mesh(reader, BODY_COUNT, &mesh, &error));
    REFUSED(tulle_run_reader_get_mesh(reader, SIZE_MAX, &mesh, &error));
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_get_frame) {
    tulle_run_reader *const reader = make_reader();
    double time = 7.0;
    assert_int_equal(tulle_run_reader_get_frame(NULL, 0, &time, NULL, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_run_reader_get_frame(reader, UINT32_MAX, &time, NULL, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_true(time == 7.0);
    FINE(tulle_run_reader_get_frame(reader, 0, NULL, NULL, NULL));
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_get_lags) {
    tulle_run_reader *const reader = make_reader();
    const tulle_run_lag *lags = NULL;
    size_t count = 7;
    assert_int_equal(tulle_run_reader_get_lags(NULL, 0, &lags, &count),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_run_reader_get_lags(reader, UINT32_MAX, &lags, &count),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_run_reader_get_lags(reader, 0, NULL, &count),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_run_reader_get_lags(reader, 0, &lags, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(count, 7);
    assert_int_equal(tulle_run_reader_get_lags(reader, 0, &lags, &count), TULLE_OK);
    assert_int_equal(count, 0);
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_is_present) {
    tulle_run_reader *const reader = make_reader();
    assert_int_equal(tulle_run_reader_is_present(NULL, 0, 0), 0);
    assert_int_equal(tulle_run_reader_is_present(reader, UINT32_MAX, 0), 0);
    assert_int_equal(tulle_run_reader_is_present(reader, 0, SIZE_MAX), 0);
    assert_int_equal(tulle_run_reader_is_present(reader, 0, 0), 1);
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_read_positions) {
    tulle_run_reader *const reader = make_reader();
    REFUSED(tulle_run_reader_read_positions(NULL, 0, 0, positions, &error));
    REFUSED(tulle_run_reader_read_positions(reader, 0, 0, NULL, &error));
    REFUSED(tulle_run_reader_read_positions(reader, UINT32_MAX, 0, positions, &error));
    REFUSED(tulle_run_reader_read_positions(reader, 0, SIZE_MAX, positions, &error));
    FINE(tulle_run_reader_read_positions(reader, 0, 0, positions, NULL));
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_read_transforms) {
    tulle_run_reader *const reader = make_reader();
    tulle_transform transforms[BODY_COUNT];
    REFUSED(tulle_run_reader_read_transforms(NULL, 0, transforms, &error));
    REFUSED(tulle_run_reader_read_transforms(reader, 0, NULL, &error));
    REFUSED(tulle_run_reader_read_transforms(reader, UINT32_MAX, transforms, &error));
    FINE(tulle_run_reader_read_transforms(reader, 0, transforms, NULL));
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_read_debug) {
    tulle_run_reader *const reader = make_reader();
    const tulle_run_debug *debug = NULL;
    REFUSED(tulle_run_reader_read_debug(NULL, 0, &debug, &error));
    REFUSED(tulle_run_reader_read_debug(reader, 0, NULL, &error));
    REFUSED(tulle_run_reader_read_debug(reader, UINT32_MAX, &debug, &error));
    assert_null(debug);
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_get_reports) {
    tulle_run_reader *const reader = make_reader();
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    REFUSED(tulle_run_reader_get_reports(NULL, &reports, &count, &error));
    REFUSED(tulle_run_reader_get_reports(reader, NULL, &count, &error));
    REFUSED(tulle_run_reader_get_reports(reader, &reports, NULL, &error));
    tulle_run_reader_close(reader);
}

ARGUMENTS_OF(tulle_run_reader_find_damage) {
    tulle_run_reader *const reader = make_reader();
    const tulle_run_damage *damages = NULL;
    size_t count = 0;
    REFUSED(tulle_run_reader_find_damage(NULL, &damages, &count, &error));
    REFUSED(tulle_run_reader_find_damage(reader, NULL, &count, &error));
    REFUSED(tulle_run_reader_find_damage(reader, &damages, NULL, &error));
    FINE(tulle_run_reader_find_damage(reader, &damages, &count, NULL));
    assert_int_equal(count, 0);
    tulle_run_reader_close(reader);
}

int main(void) { return run_arguments(HEADERS("tulle_io/run.h"), set_up, remove_test_folder); }
