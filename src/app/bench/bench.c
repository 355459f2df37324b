/* app/bench/bench.c - `tulle bench`: what the stages of a step cost, scene by scene and size by
 * size, from captured inputs; compared with a baseline if asked for. */
#define _POSIX_C_SOURCE 200809L
#include "app/bench/bench.h"
#include "app/cli/beside_program.h"
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "base/error.h"
#include "base/text.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#ifndef TULLE_SCENES_FROM_PROGRAM
#define TULLE_SCENES_FROM_PROGRAM "../share/tulle/scenes"
#endif

enum {
    OPERANDS_MAX = 64,
    THREADS_MAX = 256,
    REPEATS_DEFAULT = 7,
    REPEATS_QUICK = 2,
    REPEATS_MAX = 1000,
    SECONDS_DEFAULT = 60,
    SECONDS_MAX = 1000000,
    WORD_SIZE = 32
};

/* From the directory of the program: as it is installed, and where it is built. */
static const char *const scene_places[] = {TULLE_SCENES_FROM_PROGRAM, "../../scenes", "../scenes"};

typedef struct bench_words {
    const char *particles, *threads, *csv, *baseline, *inputs, *scenes;
    long repeats, seconds;
    int is_quick, renews, counts_instructions;
    option_list from;
} bench_words;

/* ---- the command line ---- */

static options_outcome read_words(int argc, char **argv, bench_words *words, size_t *count) {
    const option_spec options[] = {
        {"particles", 'p', OPTION_TEXT, &words->particles, "SIZE,...",
         "sizes of cloth: 0.4k, 2k, 9.8k, 40k, 160k, 1m, all (default: 2k,9.8k)", 0, 0, NULL},
        {"threads", 't', OPTION_TEXT, &words->threads, "N,...", "numbers of threads (default: 1,2)",
         0, 0, NULL},
        {"repeat", 'r', OPTION_INTEGER, &words->repeats, "N",
         "how often the steps of a case are made (default: 7)", 1, REPEATS_MAX, NULL},
        {"seconds", 0, OPTION_INTEGER, &words->seconds, "N",
         "no further repeat of a case after N s, but three (default: 60)", 1, SECONDS_MAX, NULL},
        {"quick", 0, OPTION_FLAG, &words->is_quick, NULL,
         "the smallest size on one thread, twice: seconds, to see that it works", 0, 0, NULL},
        {"instructions", 0, OPTION_FLAG, &words->counts_instructions, NULL,
         "also count the instructions of sizes up to 2k, by valgrind", 0, 0, NULL},
        {"csv", 0, OPTION_TEXT, &words->csv, "FILE", "write all measures to FILE", 0, 0, NULL},
        {"compare", 0, OPTION_TEXT, &words->baseline, "FILE",
         "compare with the measures in FILE; exit code 1 if any got worse", 0, 0, NULL},
        {"from", 0, OPTION_LIST, &words->from, "FILE",
         "take the measures from FILE, measure nothing; may be repeated", 0, 0, NULL},
        {"inputs", 0, OPTION_TEXT, &words->inputs, "DIR",
         "where captured inputs are kept (default: bench-inputs)", 0, 0, NULL},
        {"renew", 0, OPTION_FLAG, &words->renews, NULL, "make inputs anew that are there", 0, 0,
         NULL},
        {"scenes", 0, OPTION_TEXT, &words->scenes, "DIR",
         "where the scenes are (default: those that came with the program)", 0, 0, NULL},
    };
    const command_spec command = {
        .name = "bench",
        .operands = "SCENE ...",
        .summary =
            "Measures what each stage of a step takes: needles, sphere, spikes, ribbon, net,\n"
            "boxes, hammock, example_one, or all of them; landing, for what a particle takes in\n"
            "each size, is apart from all, and alone has the size 1m. Each scene is simulated\n"
            "once until contact is in full swing (landing: has begun) and kept; from there the\n"
            "same steps are timed again and again. Prints tables of medians and counts. Ctrl-C "
            "ends it (130); the CSV then has\n"
            "the cases that were whole.",
        .options = options,
        .option_count = sizeof options / sizeof options[0],
        .operand_minimum = 1,
        .operand_maximum = OPERANDS_MAX};
    return options_parse(&command, argc, argv, count);
}

/* Takes the first word off a list "a,b"; false where there is none left. */
static bool take_word(const char **rest, char word[WORD_SIZE]) {
    if (!**rest) return false;
    size_t const length = strcspn(*rest, ",");
    snprintf(word, WORD_SIZE, "%.*s", (int)(length < WORD_SIZE ? length : WORD_SIZE - 1), *rest);
    *rest += length;
    if (**rest == ',') (*rest)++;
    return true;
}

static bool refuse(const char *what, const char *word, const char *const *known, size_t count) {
    const char *const nearest = text_find_nearest(word, known, count);
    app_print_message("bench", "there is no %s \"%s\"%s%s%s", what, word,
                      nearest ? "; did you mean \"" : "; --help names them", nearest ? nearest : "",
                      nearest ? "\"?" : "");
    return false;
}

static bool choose_scenes(bench_session *self, char **names, size_t count) {
    const char *known[sizeof self->is_scene_wanted + 1] = {"all"};
    for (size_t i = 0; i < bench_scene_count; i++) known[i + 1] = bench_scenes[i].name;
    for (size_t n = 0; n < count; n++) {
        bool const is_all = strcmp(names[n], "all") == 0;
        size_t const found = bench_find_scene(names[n]);
        if (!is_all && found == bench_scene_count)
            return refuse("scene", names[n], known, bench_scene_count + 1);
        for (size_t i = 0; i < bench_scene_count; i++)
            self->is_scene_wanted[i] |= (is_all && !bench_scenes[i].is_apart) || i == found;
    }
    return true;
}

static bool choose_sizes(bench_session *self, const char *list) {
    const char *known[BENCH_SIZE_COUNT + 1] = {"all"};
    for (size_t i = 0; i < BENCH_SIZE_COUNT; i++) known[i + 1] = bench_sizes[i].name;
    char word[WORD_SIZE];
    do {
        bool const is_word = take_word(&list, word);
        bool const is_all = is_word && strcmp(word, "all") == 0;
        size_t const found = is_word ? bench_find_size(word) : BENCH_SIZE_COUNT;
        if (!is_all && found == BENCH_SIZE_COUNT)
            return refuse("size", is_word ? word : "", known, BENCH_SIZE_COUNT + 1);
        for (size_t i = 0; i < BENCH_SIZE_COUNT; i++)
            self->is_size_wanted[i] |=
                i == found || (is_all && !bench_sizes[i].is_quick && !bench_sizes[i].is_apart);
    } while (*list);
    return true;
}

static bool choose_threads(bench_session *self, const char *list) {
    char word[WORD_SIZE] = "";
    do {
        char *end = NULL;
        bool const is_word = take_word(&list, word);
        long const number = is_word ? strtol(word, &end, 10) : 0;
        if (!is_word || *end || number < 1 || number > THREADS_MAX) {
            app_print_message("bench",
                              "--threads: \"%s\" should be whole numbers from 1 to %d, as "
                              "1,2",
                              word, THREADS_MAX);
            return false;
        }
        if (self->threads_count == BENCH_THREADS_MAX) {
            app_print_message("bench", "--threads: has more than %d numbers", BENCH_THREADS_MAX);
            return false;
        }
        self->threads[self->threads_count++] = (int)number;
    } while (*list);
    return true;
}

static int find_scenes(bench_session *self, const char *given) {
    size_t const place_count = sizeof scene_places / sizeof scene_places[0];
    if (!given && beside_program_find(scene_places, place_count, sizeof self->scenes, self->scenes))
        return APP_EXIT_FINE;
    if (!given) {
        app_print_message("bench", "the scenes are not beside the program; name their directory "
                                   "with --scenes DIR");
        return APP_EXIT_BAD_INPUT;
    }
    snprintf(self->scenes, sizeof self->scenes, "%s", given);
    if (strlen(given) < BENCH_PATH_SIZE && is_directory(given)) return APP_EXIT_FINE;
    app_print_message("bench", "--scenes: %s is no directory", given);
    return APP_EXIT_BAD_INPUT;
}

static int make_input_directory(const char *path) {
    int fault = 0;
    if (strlen(path) >= BENCH_PATH_SIZE) fault = ENAMETOOLONG;
    if (!fault && !is_directory(path) && mkdir(path, 0777) != 0) fault = errno;
    if (!fault) return APP_EXIT_FINE;
    app_print_message("bench", "--inputs: %s cannot be made: %s", path, strerror(fault));
    return fault == ENOSPC ? APP_EXIT_CANNOT_GO_ON : APP_EXIT_BAD_INPUT;
}

/* ---- the work ---- */

static int report(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) app_print_error("bench", error);
    return app_exit_for_input(status);
}

/* After each case, so that what was measured is kept whatever happens. */
static int keep_rows(const bench_session *self, const char *csv) {
    tulle_error error = {0};
    tulle_status const status = csv ? bench_csv_write(csv, &self->rows, &error) : TULLE_OK;
    if (status != TULLE_OK) app_print_error("bench", &error);
    return app_exit_for_run(status);
}

static int measure_all(bench_session *self, const char *csv) {
    for (size_t i = 0; i < bench_scene_count; i++) {
        for (size_t size = 0; size < BENCH_SIZE_COUNT; size++) {
            if (!self->is_scene_wanted[i] || !self->is_size_wanted[size]) continue;
            bench_case const which = {&bench_scenes[i], size};
            if (!bench_has_size(which.scene, size)) {
                app_print_message("bench", "%s is not made in size %s", which.scene->name,
                                  bench_sizes[size].name);
                continue;
            }
            int code = bench_measure_case(self, &which);
            if (code == APP_EXIT_FINE && self->counts_instructions && bench_sizes[size].is_small)
                code = bench_count_instructions(self, &which);
            if (code == APP_EXIT_FINE) code = keep_rows(self, csv);
            if (code != APP_EXIT_FINE) return code;
            self->whole_cases++;
        }
    }
    return APP_EXIT_FINE;
}

static int measure(bench_session *self, const bench_words *words) {
    tulle_error error = {0};
    int code = find_scenes(self, words->scenes);
    if (code == APP_EXIT_FINE) code = make_input_directory(self->inputs);
    if (code == APP_EXIT_FINE)
        code = report(bench_find_fingerprint(&self->fingerprint, &error), &error);
    if (code == APP_EXIT_FINE) code = bench_describe_machine(self);
    if (code == APP_EXIT_FINE) code = measure_all(self, words->csv);
    if (code == APP_EXIT_INTERRUPTED)
        app_print_message("bench", "interrupted after %zu whole cases%s%s", self->whole_cases,
                          words->csv && self->whole_cases > 0 ? ", which are in " : "",
                          words->csv && self->whole_cases > 0 ? words->csv : "");
    return code;
}

/* The rows of the chosen scenes, sizes and threads. */
static int take_rows(bench_session *self, const option_list *files) {
    bench_rows all = {0};
    tulle_error error = {0};
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < files->count && status == TULLE_OK; i++)
        status = bench_csv_read(files->items[i], &all, &error);
    bool is_put = true;
    for (size_t i = 0; i < all.count && status == TULLE_OK && is_put; i++) {
        const bench_row *const row = &all.items[i];
        size_t const which = bench_find_scene(row->scene), size = bench_find_size(row->size);
        bool const is_wanted = which < bench_scene_count && self->is_scene_wanted[which] &&
                               size < BENCH_SIZE_COUNT && self->is_size_wanted[size];
        bool has_threads = false;
        for (size_t k = 0; k < self->threads_count; k++)
            has_threads |= row->threads == self->threads[k];
        if (!row->scene[0] || (is_wanted && has_threads)) is_put = bench_rows_put(&self->rows, row);
    }
    bench_rows_destroy(&all);
    if (!is_put)
        status = error_set(&error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the measures");
    return report(status, &error);
}

/* Measures or takes rows, prints, keeps and compares them. */
static int make_bench(bench_session *self, const bench_words *words) {
    bench_rows baseline = {0};
    tulle_error error = {0};
    int code = APP_EXIT_FINE;
    if (words->baseline) code = report(bench_csv_read(words->baseline, &baseline, &error), &error);
    if (code == APP_EXIT_FINE && words->csv)
        code = report(bench_csv_check(words->csv, &error), &error);
    bool const is_read = words->from.count > 0;
    if (code == APP_EXIT_FINE)
        code = is_read ? take_rows(self, &words->from) : measure(self, words);
    if (code == APP_EXIT_FINE && is_read) code = keep_rows(self, words->csv);
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
    bench_words words = {.inputs = "bench-inputs", .seconds = SECONDS_DEFAULT};
    size_t count = 0;
    options_outcome const outcome = read_words(argc, argv, &words, &count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    if (!words.particles) words.particles = words.is_quick ? "0.4k" : "2k,9.8k";
    if (!words.threads) words.threads = words.is_quick ? "1" : "1,2";
    if (words.repeats == 0) words.repeats = words.is_quick ? REPEATS_QUICK : REPEATS_DEFAULT;
    bench_session self = {.inputs = words.inputs,
                          .repeat_count = (uint32_t)words.repeats,
                          .most_seconds = (double)words.seconds,
                          .renews_inputs = words.renews != 0,
                          .counts_instructions = words.counts_instructions != 0,
                          .bar = progress_bar_begin()};
    if (!choose_scenes(&self, argv, count) || !choose_sizes(&self, words.particles) ||
        !choose_threads(&self, words.threads))
        return APP_EXIT_BAD_INPUT;
    interrupt_catch();
    int const code = make_bench(&self, &words);
    bench_rows_destroy(&self.rows);
    int const written = app_finish_output("bench");
    return code != APP_EXIT_FINE ? code : written;
}
