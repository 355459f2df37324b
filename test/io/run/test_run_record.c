/* run.json: what it says of how a run went comes back, in words too; a record with a member that is
 * missing, of another kind or out of range is refused with the member's name. The same of
 * report.csv and its columns. */
#define _GNU_SOURCE
#include "io/run/run_report.h"
#include "io/run_support.h"

static const tulle_untangle_report untangled = {
    .intersections = 9, .rounds = 3, .moved_vertices = 17, .largest_displacement = 0.25};
static const tulle_world_detection detection = {TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, 0.75, 1,
                                                0};

/* Of reports: a step that did not converge, was cut, rescued, pinched and overstretched; a finer
 * one; one whose numbers are not finite. */
static tulle_run_outcome make_outcome(void) {
    static const tulle_step_report reports[] = {
        {.time = 0.5,
         .cg_converged = 0,
         .cg_residual = 0.125,
         .max_stretch = 1.5,
         .substeps = 4,
         .rescue_impact_zones = 1,
         .rescue_component_scalings = 2,
         .rescue_global_scalings = 3,
         .pinched = 1,
         .overstretched = 5,
         .largest_lag = 0.03125},
        {.time = 0.75,
         .cg_converged = 0,
         .cg_residual = 0.0625,
         .max_stretch = 1.25,
         .overstretched = 2,
         .substeps = 2,
         .largest_lag = 0.015625},
        {.time = 1.0,
         .cg_converged = 0,
         .cg_residual = (double)NAN,
         .max_stretch = (double)INFINITY,
         .substeps = 1,
         .largest_lag = (double)INFINITY},
        {.time = 1.25,
         .cg_converged = 0,
         .cg_residual = (double)INFINITY,
         .max_stretch = (double)NAN,
         .substeps = 1},
    };
    tulle_run_outcome outcome = {0};
    for (int i = 0; i < 4; i++) tulle_run_outcome_add(&outcome, &reports[i]);
    tulle_run_outcome_add(NULL, &reports[0]);
    tulle_run_outcome_add(&outcome, NULL);
    return outcome;
}

static void place(tulle_run_outcome *outcome, uint32_t body) {
    tulle_stretch const stretch = {.vertices = {4, 7}, .position = {0.5, -0.25, 2.0}};
    tulle_run_outcome_place(outcome, NULL, body);
    tulle_run_outcome_place(NULL, &stretch, body);
    assert_int_equal(outcome->has_stretch_place, 0);
    tulle_run_outcome_place(outcome, &stretch, body);
}

static void steps_are_summed(void **state) {
    (void)state;
    tulle_run_outcome outcome = make_outcome();
    assert_int_equal(outcome.steps, 4);
    assert_int_equal(outcome.unconverged_steps, 4);
    assert_true(outcome.worst_residual == 0.125 && outcome.worst_residual_time == 0.5);
    assert_true(outcome.largest_stretch == 1.5 && outcome.largest_stretch_time == 0.5);
    assert_int_equal(outcome.cut_steps, 2);
    assert_int_equal(outcome.most_substeps, 4);
    assert_int_equal(outcome.rescues, 6);
    assert_int_equal(outcome.pinched_steps, 1);
    assert_int_equal(outcome.overstretched_steps, 2);
    assert_int_equal(outcome.most_overstretched, 5);
    assert_true(outcome.largest_lag == 0.03125 && outcome.largest_lag_time == 0.5);
    place(&outcome, 0);
    tulle_step_report const stretched = {.max_stretch = 1.75, .time = 2.0, .cg_converged = 1};
    tulle_run_outcome_add(&outcome, &stretched);
    assert_int_equal(outcome.has_stretch_place, 0); /* of another edge */
    assert_true(outcome.largest_stretch == 1.75 && outcome.largest_stretch_time == 2.0);
    assert_int_equal(outcome.unconverged_steps, 4);
}

static void steps_are_described(void **state) {
    (void)state;
    tulle_run_outcome placed = make_outcome();
    place(&placed, 0);
    const struct {
        tulle_run_outcome outcome;
        const char *body, *failure, *text;
    } cases[] = {
        {{.steps = 3, .largest_stretch = 1.0},
         NULL,
         NULL,
         "none: every solve converged, no step was cut, nothing was rescued or pinched"},
        {{.steps = 3, .largest_stretch = 1.125, .largest_stretch_time = 0.5},
         NULL,
         NULL,
         "none: every solve converged, no step was cut, nothing was rescued or pinched; cloth was "
         "stretched by at most 12.5 % at 0.5 s"},
        {{.steps = 3}, NULL, "the disk is full", "the run failed: the disk is full"},
        {{.steps = 3, .unconverged_steps = 1},
         NULL,
         NULL,
         "a solve did not converge in 1 of 3 steps"},
        {{.steps = 3, .cut_steps = 1, .most_substeps = 8},
         NULL,
         NULL,
         "1 of 3 steps was cut, into 8 substeps at most"},
        {{.steps = 3,
          .largest_stretch = 1.125,
          .largest_stretch_time = 0.5,
          .overstretched_steps = 2,
          .most_overstretched = 7},
         NULL,
         NULL,
         "cloth was stretched beyond what its material holds in 2 of 3 steps; at 7 triangles at "
         "most, by 12.5 % at 0.5 s"},
        {placed, "sheet", "it tore",
         "the run failed: it tore\n"
         "a solve did not converge in 4 of 4 steps; the largest residual was 0.125 at 0.5 s\n"
         "cloth was stretched by 50 % at 0.5 s, between vertices 4 and 7 of 'sheet', at (0.5, "
         "-0.25, 2)\n"
         "cloth was stretched beyond what its material holds in 2 of 4 steps; at 5 triangles at "
         "most\n"
         "2 of 4 steps were cut, into 4 substeps at most\n"
         "impacts needed 6 rescues\n"
         "cloth was pinched between obstacles in 1 of 4 steps; obstacles lagged behind their "
         "path there, by 31.2 mm at most at 0.5 s"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[1024], shorter[30];
        tulle_run_outcome_describe(&cases[i].outcome, cases[i].body, cases[i].failure, text,
                                   sizeof text);
        assert_string_equal(text, cases[i].text);
        tulle_run_outcome_describe(&cases[i].outcome, cases[i].body, cases[i].failure, shorter,
                                   sizeof shorter);
        assert_int_equal(strlen(shorter), sizeof shorter - 1);
        assert_memory_equal(shorter, cases[i].text, sizeof shorter - 1);
    }
    char text[4] = "abc";
    tulle_run_outcome_describe(NULL, NULL, NULL, text, sizeof text);
    assert_string_equal(text, "");
    tulle_run_outcome_describe(&placed, NULL, NULL, NULL, 4);
    tulle_run_outcome_describe(&placed, NULL, NULL, text, 0);
    assert_string_equal(text, "");
}

/* A run of one frame that says all there is to say, failed. */
static void write_run(const char *directory, const tulle_run_outcome *outcome) {
    tulle_run_def def = make_def(directory, 1);
    def.detection = &detection;
    def.has_response = 1;
    def.response = TULLE_RESPONSE_PAPER;
    def.motion_space = TULLE_MOTION_SPACE_CONE;
    def.untangle = &untangled;
    tulle_run_writer *writer = NULL;
    tulle_error error = {0};
    if (tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error)) fail_msg("%s", error.message);
    assert_int_equal(write_frame(writer, 42, 0, &error), TULLE_OK);
    assert_int_equal(write_checkpoint(writer, 42, 0, &error), TULLE_OK);
    tulle_run_set_outcome(writer, NULL);
    tulle_run_set_outcome(writer, outcome);
    tulle_run_set_outcome(NULL, outcome);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FAILED, "it tore", &error), TULLE_OK);
}

static void an_outcome_comes_back(void **state) {
    (void)state;
    for (int is_placed = 0; is_placed < 2; is_placed++) {
        const char *const directory = test_path(is_placed ? "placed" : "anywhere");
        tulle_run_outcome outcome = make_outcome();
        if (is_placed) place(&outcome, 1);
        write_run(directory, &outcome);
        tulle_run_reader *reader = NULL;
        assert_int_equal(tulle_run_reader_open(directory, &reader, NULL), TULLE_OK);
        const tulle_run_info *const info = tulle_run_reader_get_info(reader);
        assert_non_null(info->outcome);
        assert_memory_equal(info->outcome, &outcome, sizeof outcome);
        assert_string_equal(info->message, "it tore");
        tulle_run_reader_close(reader);
        tulle_run_def const def = make_def(directory, 1);
        tulle_run_writer *writer = NULL;
        tulle_run_checkpoint checkpoint = {0};
        assert_int_equal(tulle_run_resume(&def, &writer, &checkpoint, NULL), TULLE_OK);
        assert_memory_equal(tulle_run_get_former_outcome(writer), &outcome, sizeof outcome);
        tulle_run_free_checkpoint(&checkpoint);
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, NULL), TULLE_OK);
        size_t size;
        char path[600];
        snprintf(path, sizeof path, "%s/run.json", directory);
        char *const text = get_file(path, &size);
        assert_non_null(strstr(text, "\"untangle\": {"));
        free(text);
    }
}

/* Members that a reader does without, and those that it never looks at. */
static const char may_miss[] =
    "\"record\" \"detection\" \"response\" \"untangle\" \"outcome\" \"checksums\" "
    "\"largest_stretch_place\" \"checkpoint_step\"";
static const char not_read[] = "\"scene_file\" \"frame_interval\" \"cloth\" \"trouble\"";

/* Values of all kinds, and the members that may have them. */
#define NUMBERS                                                                                    \
    "\"alpha_max\" \"largest_displacement\" \"worst_residual\" \"worst_residual_time\" "           \
    "\"largest_stretch\" \"largest_stretch_time\" \"largest_lag\" \"largest_lag_time\" "
static const struct {
    const char *value, *keys;
} odd_values[] = {
    {"true", "\"vtp\" \"static\" \"certificate\""},
    {"-1", NUMBERS},
    {"1e300", NUMBERS "\"time_step\""},
    {"0.5", NUMBERS "\"time_step\""},
    {"\"odd\"", "\"tulle_version\" \"message\" \"scene_path\" \"name\" \"mesh\""},
    {"[]", ""},
    {"{}", ""},
    {"null", ""},
};
enum { ODD_COUNT = sizeof odd_values / sizeof odd_values[0] };

/* Opens the run with `middle` between the first bytes of a run.json and the rest. */
static tulle_status try_record(const char *text, size_t before, const char *middle,
                               const char *rest, tulle_error *error) {
    char *const changed = calloc(1, strlen(text) + strlen(middle) + 64);
    assert_non_null(changed);
    memcpy(changed, text, before);
    strcat(changed, middle);
    strcat(changed, rest);
    seal_record(changed);
    put_text(test_path("damaged/run.json"), changed);
    free(changed);
    tulle_run_reader *reader = NULL;
    tulle_status const status = tulle_run_reader_open(test_path("damaged"), &reader, error);
    assert_int_equal(reader != NULL, status == TULLE_OK);
    tulle_run_reader_close(reader);
    return status;
}

/* The member `key` of run.json, in quotes, is read, or refused at a line and by its name. */
static void expect(bool is_read, tulle_status status, const char *key, const char *value,
                   const tulle_error *error) {
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strlen(key) - 2, key + 1);
    bool const is_refused = status == TULLE_ERROR_PARSE && error->line > 0 &&
                            strcmp(error->file, test_path("damaged/run.json")) == 0 &&
                            strstr(error->message, name) != NULL;
    if (is_read ? status != TULLE_OK : !is_refused)
        fail_msg("%s %s: status %d, line %d: %s", key, value, (int)status, error->line,
                 error->message);
}

static void odd_members_are_refused(void **state) {
    (void)state;
    tulle_run_outcome outcome = make_outcome();
    place(&outcome, 1);
    write_run(test_path("damaged"), &outcome);
    size_t size;
    char *const text = get_file(test_path("damaged/run.json"), &size);
    int member_count = 0;
    for (char *line = text; (line = strchr(line, '\n')) != NULL && line < find_seal(text);) {
        line++;
        char *const begin = line + strspn(line, " ");
        char *const end = *begin == '"' ? strchr(begin + 1, '"') + 1 : NULL;
        if (!end) continue;
        char key[64];
        snprintf(key, sizeof key, "%.*s", (int)(end - begin), begin);
        char *const value = end + 2;
        char *value_end = value + strcspn(value, "\n");
        if (value_end[-1] == ',') value_end--;
        bool const is_looked_at = !strstr(not_read, key) && strncmp(value, "null", 4) != 0;
        tulle_error error = {0};
        tulle_status status = try_record(text, (size_t)(begin - text), "\"_\"", end, &error);
        expect(!is_looked_at || strstr(may_miss, key), status, key, "left out", &error);
        if (status != TULLE_OK && !strstr(error.message, "missing"))
            fail_msg("%s left out: %s", key, error.message);
        member_count++;
        for (int i = 0; i < ODD_COUNT; i++) {
            if (*value == '{' || *value == '[') break;
            if (strcmp(key, "\"cache\"") == 0 && odd_values[i].value[0] == '"')
                continue; /* no file */
            error = (tulle_error){0};
            status =
                try_record(text, (size_t)(value - text), odd_values[i].value, value_end, &error);
            expect(!is_looked_at || strstr(odd_values[i].keys, key), status, key,
                   odd_values[i].value, &error);
        }
    }
    assert_true(member_count > 60);
    free(text);
}

/* Reads a report whose only line has `value` in a column, or `value` behind its columns. */
static tulle_status read_line(size_t column, const char *value, size_t *column_count,
                              const char **name, tulle_error *error) {
    static char heading[RUN_REPORT_LINE_SIZE], line[RUN_REPORT_LINE_SIZE];
    tulle_step_report const report = {.step = 7};
    run_report_format_heading(heading);
    run_report_format(&report, line);
    const char *const path = test_path("report.csv");
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs(heading, file);
    char *names = heading, *fields = line;
    *column_count = 0;
    for (char *field; (field = strsep(&fields, ",\n")) != NULL && fields; ++*column_count) {
        const char *const title = strsep(&names, ",\n");
        bool const is_chosen = *column_count == column;
        if (is_chosen) *name = title;
        fprintf(file, "%s%s", *column_count ? "," : "", is_chosen ? value : field);
    }
    if (column >= *column_count) fputs(value, file);
    fputs("\n", file);
    fclose(file);
    memory heap = memory_default();
    run_report_rows rows = {0};
    tulle_status const status = run_report_read(&heap, path, &rows, error);
    assert_int_equal(rows.count, status == TULLE_OK);
    ARRAY_FREE(&heap, &rows);
    return status;
}

static void odd_fields_of_a_report_are_refused(void **state) {
    (void)state;
    static const char *const values[] = {"x", "-1", "0.5", "99999999999999999999", "1e999"};
    tulle_error error = {0};
    const char *name = "";
    size_t count = 1, real_count = 0;
    for (size_t column = 0; column < count; column++) {
        bool const is_real = read_line(column, "0.5", &count, &name, &error) == TULLE_OK;
        real_count += is_real;
        for (int i = 0; i < 5; i++) {
            bool const is_fine = is_real && (i == 1 || i == 2 || i == 3);
            error = (tulle_error){0};
            tulle_status const status = read_line(column, values[i], &count, &name, &error);
            bool const is_told = status == TULLE_ERROR_PARSE && error.line == 2 &&
                                 strstr(error.message, name) != NULL;
            if (is_fine ? status != TULLE_OK : !is_told)
                fail_msg("%s = %s: status %d, %s", name, values[i], (int)status, error.message);
        }
    }
    assert_true(count > 40 && real_count > 10 && real_count < count);
    assert_int_equal(read_line(count, ",1", &count, &name, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "columns"));
    assert_int_equal(read_line(count - 1, "0,", &count, &name, &error), TULLE_ERROR_PARSE);
}

static int set_up(void **state) {
    make_bodies();
    return make_test_folder(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_are_summed),
        cmocka_unit_test(steps_are_described),
        cmocka_unit_test(an_outcome_comes_back),
        cmocka_unit_test(odd_members_are_refused),
        cmocka_unit_test(odd_fields_of_a_report_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, remove_test_folder);
}
