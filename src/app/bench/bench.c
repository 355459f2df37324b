/* app/bench/bench.c - `tulle bench`: what the stages of a step cost in a scene, as tables and CSV;
 * compared with an earlier CSV if asked for. */
#include "app/bench/bench.h"
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

enum {
    THREADS_MAX = 256,
    REPEATS_DEFAULT = 7,
    REPEATS_MAX = 1000,
    SECONDS_DEFAULT = 60,
    SECONDS_MAX = 1000000,
    SKIP_DEFAULT = 30,
    SKIP_MAX = 10000000,
    STEPS_DEFAULT = 8,
    STEPS_MAX = 10000,
    WORD_SIZE = 32
};

typedef struct bench_words {
    const char *threads, *csv, *baseline, *state, *name, *size;
    long repeats, seconds, skip, steps;
    option_list overrides, from;
} bench_words;

/* ---- the command line ---- */

static options_outcome read_words(int argc, char **argv, bench_words *words, size_t *count) {
    const option_spec options[] = {
        {"skip", 0, OPTION_INTEGER, &words->skip, "N",
         "steps from the start to those that are timed (default: 30)", 0, SKIP_MAX, NULL},
        {"steps", 0, OPTION_INTEGER, &words->steps, "N", "steps that are timed (default: 8)", 1,
         STEPS_MAX, NULL},
        {"threads", 't', OPTION_TEXT, &words->threads, "N,...", "numbers of threads (default: 1,2)",
         0, 0, NULL},
        {"repeat", 'r', OPTION_INTEGER, &words->repeats, "N",
         "how often these steps are made (default: 7)", 1, REPEATS_MAX, NULL},
        {"seconds", 0, OPTION_INTEGER, &words->seconds, "N",
         "no further repeat after N s, but three (default: 60)", 1, SECONDS_MAX, NULL},
        {"set", 0, OPTION_LIST, &words->overrides, "PATH=VALUE",
         "change a key of the scene; may be repeated", 0, 0, NULL},
        {"csv", 0, OPTION_TEXT, &words->csv, "FILE", "write all measures to FILE", 0, 0, NULL},
        {"compare", 0, OPTION_TEXT, &words->baseline, "FILE",
         "compare with the measures in FILE; exit code 1 if any got worse", 0, 0, NULL},
        {"from", 0, OPTION_LIST, &words->from, "FILE",
         "take the measures from FILE, measure no scene; may be repeated", 0, 0, NULL},
        {"state", 0, OPTION_TEXT, &words->state, "FILE",
         "keep the state after the skipped steps in FILE, or begin from it", 0, 0, NULL},
        {"name", 0, OPTION_TEXT, &words->name, "NAME",
         "name of the scene in tables (default: its file's)", 0, 0, NULL},
        {"size", 0, OPTION_TEXT, &words->size, "NAME",
         "name of its size in tables (default: number of particles)", 0, 0, NULL},
    };
    const command_spec command = {
        .name = "bench",
        .operands = "[SCENE.yaml]",
        .summary =
            "Measures what each stage of a step takes in a scene. The scene is simulated for\n"
            "some steps; from the state that it then has, the same steps are timed again and\n"
            "again. Prints tables of medians and counts. Ctrl-C ends it (130).",
        .options = options,
        .option_count = sizeof options / sizeof options[0],
        .operand_minimum = 0,
        .operand_maximum = 1};
    return options_parse(&command, argc, argv, count);
}

static bool choose_threads(bench_session *self, const char *list) {
    for (;;) {
        char word[WORD_SIZE], *end = NULL;
        size_t const length = strcspn(list, ",");
        snprintf(word, sizeof word, "%.*s", (int)(length < WORD_SIZE ? length : WORD_SIZE - 1),
                 list);
        long const number = strtol(word, &end, 10);
        if (length == 0 || *end || number < 1 || number > THREADS_MAX) {
            app_print_message("bench",
                              "--threads: \"%s\" should be whole numbers from 1 to %d, as 1,2",
                              word, THREADS_MAX);
            return false;
        }
        if (self->threads_count == BENCH_THREADS_MAX) {
            app_print_message("bench", "--threads: has more than %d numbers", BENCH_THREADS_MAX);
            return false;
        }
        self->threads[self->threads_count++] = (int)number;
        if (!list[length]) return true;
        list += length + 1;
    }
}

/* A name that is one field of CSV. */
static bool take_name(const char *option, const char *given, char name[BENCH_NAME_SIZE]) {
    if (!*given || strlen(given) >= BENCH_NAME_SIZE || strpbrk(given, ",\"\n\r")) {
        app_print_message("bench",
                          "--%s: \"%.40s\" should have 1 to %d letters, no commas and no quotes",
                          option, given, BENCH_NAME_SIZE - 1);
        return false;
    }
    strcpy(name, given);
    return true;
}

/* "spikes" of scenes/spikes.yaml, as far as it is a field of CSV. */
static void name_scene(const char *path, char name[BENCH_NAME_SIZE]) {
    const char *const slash = strrchr(path, '/');
    snprintf(name, BENCH_NAME_SIZE, "%.31s", slash ? slash + 1 : path);
    char *const end = strrchr(name, '.');
    if (end && end > name) *end = '\0';
    for (char *mark = name; *mark; mark++)
        if (strchr(",\"", *mark) || (unsigned char)*mark < ' ') *mark = '_';
}

/* ---- the work ---- */

static int report(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) app_print_error("bench", error);
    return app_exit_for_input(status);
}

static int measure(bench_session *self, const bench_words *words) {
    tulle_scene *loaded = NULL;
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) return APP_EXIT_OUT_OF_MEMORY;
    tulle_status const status = tulle_scene_load(self->scene_path, self->overrides.items,
                                                 self->overrides.count, &loaded, problems);
    if (status != TULLE_OK) scene_print_problems(problems, stderr);
    free(problems);
    if (status != TULLE_OK) return app_exit_for_input(status);
    size_t particles = 0;
    for (size_t i = 0; i < tulle_scene_get_cloth_count(loaded); i++)
        particles += tulle_scene_get_cloth_mesh(loaded, i).vertex_count;
    if (!self->size[0]) snprintf(self->size, sizeof self->size, "%zu", particles);
    int code = bench_describe_machine(self);
    if (code == APP_EXIT_FINE) code = bench_measure(self, loaded);
    tulle_scene_destroy(loaded);
    if (code == APP_EXIT_INTERRUPTED) app_print_message("bench", "interrupted");
    if (code != APP_EXIT_FINE || !words->csv) return code;
    tulle_error error = {0};
    tulle_status const kept = bench_csv_write(words->csv, &self->rows, &error);
    if (kept != TULLE_OK) app_print_error("bench", &error);
    return app_exit_for_run(kept);
}

/* Measures or takes rows, prints, keeps and compares them. */
static int make_bench(bench_session *self, const bench_words *words) {
    bench_rows baseline = {0};
    tulle_error error = {0};
    int code = APP_EXIT_FINE;
    if (words->baseline) code = report(bench_csv_read(words->baseline, &baseline, &error), &error);
    if (code == APP_EXIT_FINE && words->csv)
        code = report(bench_csv_check(words->csv, &error), &error);
    for (size_t i = 0; i < words->from.count && code == APP_EXIT_FINE; i++)
        code = report(bench_csv_read(words->from.items[i], &self->rows, &error), &error);
    if (code == APP_EXIT_FINE && self->scene_path) code = measure(self, words);
    if (code == APP_EXIT_FINE && !self->scene_path && words->csv)
        code = report(bench_csv_write(words->csv, &self->rows, &error), &error);
    if (code == APP_EXIT_FINE) bench_print_tables(&self->rows, stdout);
    if (code == APP_EXIT_FINE && words->baseline) {
        fputs("\n", stdout);
        bench_verdict const verdict = bench_compare(&baseline, &self->rows, stdout);
        if (verdict.worse > 0) code = APP_EXIT_FALSE;
        if (verdict.compared == 0) {
            app_print_message("bench", "--compare: %s has nothing to compare with",
                              words->baseline);
            code = APP_EXIT_BAD_INPUT;
        }
    }
    bench_rows_destroy(&baseline);
    return code;
}

int app_bench(int argc, char **argv) {
    bench_words words = {.threads = "1,2",
                         .repeats = REPEATS_DEFAULT,
                         .seconds = SECONDS_DEFAULT,
                         .skip = SKIP_DEFAULT,
                         .steps = STEPS_DEFAULT};
    size_t count = 0;
    options_outcome const outcome = read_words(argc, argv, &words, &count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    if ((count == 0) == (words.from.count == 0)) {
        app_print_message("bench", count == 0
                                       ? "SCENE.yaml is missing; usage: tulle bench SCENE.yaml "
                                         "[options], or tulle bench --from FILE [options]"
                                       : "give a scene to measure, or --from with measures to "
                                         "show, not both");
        return APP_EXIT_BAD_INPUT;
    }
    bench_session self = {.scene_path = count > 0 ? argv[0] : NULL,
                          .overrides = words.overrides,
                          .state_path = words.state,
                          .skip_count = (uint32_t)words.skip,
                          .step_count = (uint32_t)words.steps,
                          .repeat_count = (uint32_t)words.repeats,
                          .most_seconds = (double)words.seconds,
                          .bar = progress_bar_begin()};
    if (self.scene_path) name_scene(self.scene_path, self.name);
    if (!choose_threads(&self, words.threads) ||
        (words.name && !take_name("name", words.name, self.name)) ||
        (words.size && !take_name("size", words.size, self.size)))
        return APP_EXIT_BAD_INPUT;
    interrupt_catch();
    int const code = make_bench(&self, &words);
    bench_rows_destroy(&self.rows);
    int const written = app_finish_output("bench");
    return code != APP_EXIT_FINE ? code : written;
}
