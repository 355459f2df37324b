/* Options of a subcommand: every form of an option, every refusal; the nearest word. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/options.h"

#include "app/commands.h"
#include "base/text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static struct {
    long frames;
    int resume;
    const char *output, *progress;
    option_list set;
} values;

static const char *const progress_choices[] = {"auto", "json", "none", NULL};
static const option_spec options[] = {
    {"frames", 0, OPTION_INTEGER, &values.frames, "N", "frames", 1, 1000, NULL},
    {"output", 'o', OPTION_TEXT, &values.output, "DIR", "directory", 0, 0, NULL},
    {"resume", 'r', OPTION_FLAG, &values.resume, NULL, "go on", 0, 0, NULL},
    {"progress", 0, OPTION_CHOICE, &values.progress, "WAY", "progress", 0, 0, progress_choices},
    {"set", 's', OPTION_LIST, &values.set, "PATH=VALUE", "change", 0, 0, NULL},
};
static const command_spec command = {"run", "SCENE.yaml", "Runs.", options, 5, 1, 1};

/* Splits a line at blanks and parses it; messages go to a file that read_messages reads. */
static options_outcome parse(const char *line, char **operand) {
    static char words[512];
    char *argv[32] = {0};
    int argc = 0;
    memset(&values, 0, sizeof values);
    snprintf(words, sizeof words, "run %s", line);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " ")) argv[argc++] = word;
    size_t operand_count = 0;
    options_outcome const outcome = options_parse(&command, argc, argv, &operand_count);
    if (operand) *operand = operand_count ? argv[0] : NULL;
    return outcome;
}

static FILE *capture;

/* Parses a line that must be refused with a message that holds `expected`. */
static void assert_refused(const char *line, const char *expected) {
    char message[1024] = "";
    fflush(stderr);
    int const saved = dup(STDERR_FILENO);
    capture = tmpfile();
    assert_non_null(capture);
    dup2(fileno(capture), STDERR_FILENO);
    options_outcome const outcome = parse(line, NULL);
    fflush(stderr);
    dup2(saved, STDERR_FILENO);
    close(saved);
    rewind(capture);
    size_t const length = fread(message, 1, sizeof message - 1, capture);
    message[length] = '\0';
    fclose(capture);
    assert_int_equal(outcome, OPTIONS_REFUSED);
    if (!strstr(message, expected)) fail_msg("\"%s\" lacks \"%s\"", message, expected);
}

static void every_form_is_read(void **state) {
    (void)state;
    char *operand = NULL;
    assert_int_equal(parse("--frames 12 a.yaml -o out --resume", &operand), OPTIONS_READ);
    assert_int_equal(values.frames, 12);
    assert_string_equal(values.output, "out");
    assert_int_equal(values.resume, 1);
    assert_string_equal(operand, "a.yaml");
    assert_int_equal(parse("--frames=7 --progress=json -oout --set a=b -s c=d -- -x", &operand),
                     OPTIONS_READ);
    assert_int_equal(values.frames, 7);
    assert_string_equal(values.output, "out");
    assert_string_equal(values.progress, "json");
    assert_int_equal(values.set.count, 2);
    assert_string_equal(values.set.items[0], "a=b");
    assert_string_equal(values.set.items[1], "c=d");
    assert_string_equal(operand, "-x");
    assert_int_equal(parse("-", &operand), OPTIONS_READ);
    assert_string_equal(operand, "-");
}

static void every_refusal_says_what_would_be_right(void **state) {
    (void)state;
    assert_refused("a.yaml --frame 3", "did you mean --frames?");
    assert_refused("a.yaml --xyzzy", "`tulle run --help`");
    assert_refused("a.yaml -x", "unknown option -x");
    assert_refused("a.yaml --frames", "--frames needs a value: --frames N");
    assert_refused("a.yaml --frames 0", "from 1 to 1000");
    assert_refused("a.yaml --frames 1001", "from 1 to 1000");
    assert_refused("a.yaml --frames 99999999999999999999", "from 1 to 1000");
    assert_refused("a.yaml --frames 3x", "\"3x\" should be a whole number");
    assert_refused("a.yaml --progress loud", "should be one of: auto, json, none");
    assert_refused("a.yaml --resume=1", "takes no value");
    assert_refused("", "SCENE.yaml is missing");
    assert_refused("a.yaml b.yaml", "\"b.yaml\" is one too many");
}

static void a_list_has_an_end(void **state) {
    (void)state;
    static char set[] = "-s", value[] = "a=b", name[] = "run";
    static char *argv[2 * OPTION_LIST_MAX + 3];
    for (size_t count = OPTION_LIST_MAX; count <= OPTION_LIST_MAX + 1; count++) {
        memset(&values, 0, sizeof values);
        argv[0] = name;
        for (size_t i = 0; i < count; i++) {
            argv[2 * i + 1] = set;
            argv[2 * i + 2] = value;
        }
        size_t operand_count = 0;
        command_spec no_operands = command;
        no_operands.operand_minimum = 0;
        options_outcome const outcome =
            options_parse(&no_operands, (int)(2 * count + 1), argv, &operand_count);
        assert_int_equal(outcome, count <= OPTION_LIST_MAX ? OPTIONS_READ : OPTIONS_REFUSED);
    }
}

static void edit_distances_are_known(void **state) {
    (void)state;
    assert_int_equal(text_edit_distance("", ""), 0);
    assert_int_equal(text_edit_distance("", "abc"), 3);
    assert_int_equal(text_edit_distance("abc", ""), 3);
    assert_int_equal(text_edit_distance("kitten", "sitting"), 3);
    assert_int_equal(text_edit_distance("saturday", "sunday"), 3);
    assert_int_equal(text_edit_distance("ab", "ba"), 1);
    assert_int_equal(text_edit_distance("ca", "abc"), 3);
}

static void nearest_word_is_near(void **state) {
    (void)state;
    const char *const words[] = {"frames", "output", "resume"};
    assert_string_equal(text_find_nearest("frmaes", words, 3), "frames");
    assert_string_equal(text_find_nearest("outptu", words, 3), "output");
    assert_null(text_find_nearest("zebra", words, 3));
    assert_null(text_find_nearest("", words, 0));
    char long_word[301];
    memset(long_word, 'a', 300);
    long_word[300] = '\0';
    assert_null(text_find_nearest(long_word, words, 3));
}

static void statuses_have_exit_codes(void **state) {
    (void)state;
    assert_int_equal(app_exit_for_input(TULLE_OK), 0);
    assert_int_equal(app_exit_for_run(TULLE_OK), 0);
    assert_int_equal(app_exit_for_input(TULLE_ERROR_IO), 2);
    assert_int_equal(app_exit_for_run(TULLE_ERROR_IO), 3);
    assert_int_equal(app_exit_for_run(TULLE_ERROR_DISK_FULL), 3);
    assert_int_equal(app_exit_for_run(TULLE_ERROR_OUT_OF_MEMORY), 4);
    assert_int_equal(app_exit_for_run(TULLE_ERROR_INTERRUPTED), 130);
    assert_int_equal(app_exit_for_run(TULLE_ERROR_PARSE), 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_form_is_read),
        cmocka_unit_test(every_refusal_says_what_would_be_right),
        cmocka_unit_test(a_list_has_an_end),
        cmocka_unit_test(edit_distances_are_known),
        cmocka_unit_test(nearest_word_is_near),
        cmocka_unit_test(statuses_have_exit_codes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
