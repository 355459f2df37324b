/* app/reproduce.c - `tulle reproduce`: the experiments of the paper again. Runs the scenes that the
 * asked figures need, judges every frame, makes tables, plots and stills of them and one page that
 * shows all that the directory holds.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6. */
#define _POSIX_C_SOURCE 200809L
#include "app/reproduce.h"
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/commands.h"
#include "app/render/options.h"
#include "base/text.h"
#include "base/timer.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { THREADS_MAX = 256, NAMES_MAX = 16, DIRECTORY_MAX = 600 /* [bytes] */ };

typedef struct reproduce_words {
    const char *directory, *scenes, *still_size;
    long threads;
    int is_quick;
} reproduce_words;

static options_outcome read_words(int argc, char **argv, reproduce_words *words,
                                  size_t *operand_count) {
    const option_spec options[] = {
        {"output", 'o', OPTION_TEXT, &words->directory, "DIR",
         "where the results go (default: reproduced, with --quick reproduced-quick)", 0, 0, NULL},
        {"quick", 0, OPTION_FLAG, &words->is_quick, NULL,
         "coarse cloth and short runs: minutes in place of a night", 0, 0, NULL},
        {"scenes", 0, OPTION_TEXT, &words->scenes, "DIR",
         "where the paper's scenes are (default: those that came with the program)", 0, 0, NULL},
        {"size", 0, OPTION_TEXT, &words->still_size, "WxH",
         "pixels of stills (default: 640x400, with --quick 320x200)", 0, 0, NULL},
        {"threads", 't', OPTION_INTEGER, &words->threads, "N",
         "threads; only times depend on it (default: one per processor)", 1, THREADS_MAX, NULL},
    };
    const command_spec command = {
        .name = "reproduce",
        .operands = "FIGURE ...",
        .summary =
            "Makes the experiments of Wong and Baciu (2005) again: fig6, fig7, table1, fig8,\n"
            "fig9, counterexamples, or all of them. Runs the scenes, judges every frame, and\n"
            "writes tables (CSV), plots (SVG, by gnuplot), stills and report.html. Runs that\n"
            "are whole are not made again, others go on where they were cut short: Ctrl-C\n"
            "(130) keeps what there is. Exit code 2 with all else made: a scene is missing,\n"
            "plots without gnuplot, or stills by a program that was built without Embree.",
        .options = options,
        .option_count = sizeof options / sizeof options[0],
        .operand_minimum = 1,
        .operand_maximum = NAMES_MAX};
    return options_parse(&command, argc, argv, operand_count);
}

static const reproduce_figure *find_figure(const char *name) {
    for (size_t i = 0; i < reproduce_figure_count; i++)
        if (strcmp(reproduce_figures[i].name, name) == 0) return &reproduce_figures[i];
    return NULL;
}

/* Sets is_wanted of the figures; false after saying which word is none. */
static bool choose_figures(char **names, size_t count, bool is_wanted[NAMES_MAX]) {
    const char *known[NAMES_MAX] = {"all"};
    for (size_t i = 0; i < reproduce_figure_count; i++) known[i + 1] = reproduce_figures[i].name;
    for (size_t n = 0; n < count; n++) {
        const reproduce_figure *const figure = find_figure(names[n]);
        bool const is_all = strcmp(names[n], "all") == 0;
        for (size_t i = 0; i < reproduce_figure_count; i++)
            is_wanted[i] |= is_all || figure == &reproduce_figures[i];
        if (figure || is_all) continue;
        const char *const nearest = text_find_nearest(names[n], known, reproduce_figure_count + 1);
        app_print_message("reproduce", "there is no figure \"%s\"%s%s%s", names[n],
                          nearest ? "; did you mean \"" : "; --help names them",
                          nearest ? nearest : "", nearest ? "\"?" : "");
        return false;
    }
    return true;
}

/* Makes the directory, or finds it and that files can be made in it; 0 or an errno. */
static int make_directory(const char *path) {
    struct stat facts;
    if (mkdir(path, 0777) == 0) return 0;
    if (errno != EEXIST) return errno;
    if (stat(path, &facts) != 0) return errno;
    if (!S_ISDIR(facts.st_mode)) return ENOTDIR;
    return access(path, W_OK | X_OK) == 0 ? 0 : errno;
}

static int make_directories(const reproduce *self) {
    static const char *const names[] = {"", "/runs", "/made", "/judged", "/measured", "/stills"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char path[REPRODUCE_PATH_SIZE];
        snprintf(path, sizeof path, "%s%s", self->directory, names[i]);
        int const fault = make_directory(path);
        if (!fault) continue;
        app_print_message("reproduce", "-o: %s cannot be made or written to: %s", path,
                          strerror(fault));
        return fault == ENOSPC ? APP_EXIT_CANNOT_GO_ON : APP_EXIT_BAD_INPUT;
    }
    return APP_EXIT_FINE;
}

/* The runs whose scenes are there; says which are not. */
static size_t leave_out_missing(reproduce *self, const reproduce_run **runs, size_t count) {
    size_t kept = 0;
    const char *told = "";
    for (size_t i = 0; i < count; i++) {
        if (reproduce_has_scene(self, runs[i])) {
            runs[kept++] = runs[i];
            continue;
        }
        self->is_lacking = true;
        if (strcmp(told, runs[i]->scene) != 0)
            app_print_message("reproduce", "%s/%s.yaml is missing; what needs it is left out",
                              self->scenes, runs[i]->scene);
        told = runs[i]->scene;
    }
    return kept;
}

/* Foretells the work of each run; a scene that cannot be read is found before any is made. */
static int weigh_runs(reproduce *self, const reproduce_run **runs, size_t count,
                      double work[REPRODUCE_RUNS_MAX]) {
    int code = APP_EXIT_FINE;
    for (size_t i = 0; i < count && code == APP_EXIT_FINE; i++) {
        code = reproduce_weigh_run(self, runs[i], &work[i]);
        self->work += work[i];
    }
    self->job_count = count;
    self->job_begin = timer_now();
    return code;
}

/* Makes and judges the runs. One that could not go on is judged up to there, and the rest is made.
 */
static int make_runs(reproduce *self, const reproduce_run **runs, size_t count) {
    double work[REPRODUCE_RUNS_MAX] = {0};
    int worst = weigh_runs(self, runs, count, work);
    if (worst != APP_EXIT_FINE) return worst;
    for (size_t i = 0; i < count; i++) {
        self->job = i + 1;
        int code = reproduce_make_run(self, runs[i]);
        bool const goes_on = code == APP_EXIT_FINE || code == APP_EXIT_CANNOT_GO_ON;
        if (code != APP_EXIT_FINE) worst = code;
        self->work_done += work[i];
        if (goes_on && reproduce_has_run(self, runs[i])) {
            code = reproduce_judge(self, runs[i]);
            self->is_lacking |= !reproduce_has_reports(self, runs[i]);
        }
        if (code == APP_EXIT_INTERRUPTED || interrupt_is_pending()) return APP_EXIT_INTERRUPTED;
        if (code != APP_EXIT_FINE) worst = code;
        if (!goes_on) return worst;
    }
    return worst;
}

static int make_figures(reproduce *self, const bool is_wanted[NAMES_MAX]) {
    const reproduce_run *runs[REPRODUCE_RUNS_MAX];
    size_t count = 0;
    for (size_t i = 0; i < reproduce_figure_count; i++)
        if (is_wanted[i]) count = reproduce_add_runs(&reproduce_figures[i], runs, count);
    count = leave_out_missing(self, runs, count);
    int worst = make_runs(self, runs, count);
    if (worst != APP_EXIT_FINE && worst != APP_EXIT_CANNOT_GO_ON) return worst;
    int code = reproduce_write_runs(self);
    for (size_t i = 0; i < reproduce_figure_count && code == APP_EXIT_FINE; i++)
        if (is_wanted[i]) code = reproduce_figures[i].make(self, &reproduce_figures[i]);
    if (code == APP_EXIT_FINE) code = reproduce_write_report(self);
    if (code != APP_EXIT_FINE) return code;
    printf("report: %s/report.html\n", self->directory);
    if (worst == APP_EXIT_FINE && self->is_lacking) worst = APP_EXIT_BAD_INPUT;
    return worst;
}

static reproduce make_session(const reproduce_words *words) {
    return (reproduce){.directory = words->directory  ? words->directory
                                    : words->is_quick ? "reproduced-quick"
                                                      : "reproduced",
                       .is_quick = words->is_quick != 0,
                       .still_size = words->still_size ? words->still_size
                                     : words->is_quick ? "320x200"
                                                       : "640x400",
                       .threads = (int)words->threads,
                       .bar = progress_bar_begin()};
}

/* What can be wrong with the words before anything is made. */
static int check_session(const reproduce *self) {
    if (strlen(self->directory) > DIRECTORY_MAX) {
        app_print_message("reproduce", "the name of the directory is longer than %d bytes",
                          DIRECTORY_MAX);
        return APP_EXIT_BAD_INPUT;
    }
    uint32_t width = 0, height = 0;
    tulle_error error = {0};
    if (picture_read_size(self->still_size, &width, &height, &error) == TULLE_OK)
        return APP_EXIT_FINE;
    app_print_error("reproduce", &error);
    return APP_EXIT_BAD_INPUT;
}

int app_reproduce(int argc, char **argv) {
    reproduce_words words = {0};
    size_t name_count = 0;
    options_outcome const outcome = read_words(argc, argv, &words, &name_count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    bool is_wanted[NAMES_MAX] = {false};
    if (!choose_figures(argv, name_count, is_wanted)) return APP_EXIT_BAD_INPUT;
    reproduce self = make_session(&words);
    int code = check_session(&self);
    if (code != APP_EXIT_FINE) return code;
    interrupt_catch();
    code = reproduce_find_scenes(&self, words.scenes);
    if (code == APP_EXIT_FINE) code = make_directories(&self);
    if (code == APP_EXIT_FINE) code = reproduce_find_conditions(&self);
    if (code == APP_EXIT_FINE) code = make_figures(&self, is_wanted);
    int const written = app_finish_output("reproduce");
    return code != APP_EXIT_FINE ? code : written;
}
