/* validate_main.c - tulle_validate: runs the experiments and prints measured against expected.
 * Exit code 0: all rows hold; 1: one is off; 2: wrong options. */
#define _POSIX_C_SOURCE 200809L
#include "validation/validation_report.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char usage[] =
    "usage: tulle_validate [OPTION...]\n"
    "  --list               names of the experiments and what they show\n"
    "  --only NAME[,...]    these experiments, or those whose names begin so\n"
    "  --quick              small sizes, short runs\n"
    "  --response NAME      coupled (default) or paper\n"
    "  --motion-space NAME  cone (default) or polyhedral, of the response paper\n"
    "  --integrator NAME    implicit-euler (default), crank-nicolson or bdf2\n"
    "  --threads N          default 1\n"
    "  --csv FILE           the rows\n"
    "  --plots DIR          data and gnuplot scripts of the plots, into a folder that is there\n";

typedef struct command_line {
    validation_options options;
    const char *only, *csv, *plots;
    bool is_list;
} command_line;

_Noreturn static void refuse(const char *what, const char *value) {
    fprintf(stderr, "tulle_validate: %s%s\n%s", what, value, usage);
    exit(2);
}

static const char *take_value(char ***argument) {
    const char *const name = **argument;
    if (!*++*argument) refuse("a value is missing after ", name);
    return **argument;
}

/* A motion space belongs to the response paper only. */
static void complete_options(validation_options *options) {
    bool const is_paper = strcmp(options->response, "paper") == 0;
    if (!options->motion_space) options->motion_space = is_paper ? "cone" : "-";
    if (!is_paper && strcmp(options->motion_space, "-") != 0)
        refuse("only the response paper has a motion space, not ", options->response);
}

static command_line read_command_line(char **argument) {
    command_line line = {
        .options = {.threads = 1, .response = "coupled", .integrator = "implicit-euler"}};
    while (*++argument) {
        const char *const name = *argument;
        if (strcmp(name, "--list") == 0) {
            line.is_list = true;
        } else if (strcmp(name, "--quick") == 0) {
            line.options.is_quick = true;
        } else if (strcmp(name, "--only") == 0) {
            line.only = take_value(&argument);
        } else if (strcmp(name, "--csv") == 0) {
            line.csv = take_value(&argument);
        } else if (strcmp(name, "--plots") == 0) {
            line.plots = take_value(&argument);
        } else if (strcmp(name, "--threads") == 0) {
            line.options.threads = atoi(take_value(&argument));
        } else if (strcmp(name, "--response") == 0) {
            line.options.response = take_value(&argument);
        } else if (strcmp(name, "--motion-space") == 0) {
            line.options.motion_space = take_value(&argument);
        } else if (strcmp(name, "--integrator") == 0) {
            line.options.integrator = take_value(&argument);
        } else {
            refuse("unknown option ", name);
        }
    }
    complete_options(&line.options);
    return line;
}

/* Place of `name` among `names`, which null ends. */
static int choose(const char *const *names, const char *name, const char *what) {
    for (int i = 0; names[i]; i++)
        if (strcmp(name, names[i]) == 0) return i;
    refuse(what, name);
}

/* The fields of the def that the options name. */
static void apply_options(const validation_options *options, tulle_world_def *def) {
    static const char *const integrators[] = {"implicit-euler", "crank-nicolson", "bdf2", NULL};
    static const char *const responses[] = {"coupled", "paper", NULL};
    static const char *const motion_spaces[] = {"cone", "polyhedral", NULL};
    def->integrator =
        (tulle_integrator)choose(integrators, options->integrator, "unknown integrator ");
    def->response = (tulle_response)choose(responses, options->response, "unknown response ");
    if (def->response == TULLE_RESPONSE_PAPER)
        def->motion_space = (tulle_motion_space)choose(motion_spaces, options->motion_space,
                                                       "unknown motion space ");
    def->threads = options->threads;
}

/* Whether `name` or its beginning is among the comma-separated `list`. */
static bool is_listed(const char *name, const char *list) {
    if (!list) return true;
    while (*list) {
        size_t const length = strcspn(list, ",");
        if (length > 0 && strncmp(name, list, length) == 0) return true;
        list += length;
        if (*list == ',') list++;
    }
    return false;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static bool is_chosen(const experiment *entry, const command_line *line) {
    return is_listed(entry->name, line->only) &&
           !(entry->is_long && line->options.is_quick && !line->only);
}

/* Runs an experiment with a line of progress. */
static void run_one(validation_run *run) {
    double const start = now();
    size_t const first = run->table->count;
    fprintf(stderr, "%-28s ", run->experiment->name);
    fflush(stderr);
    validation_run_experiment(run);
    size_t off = 0;
    for (size_t i = first; i < run->table->count; i++)
        off += run->table->rows[i].verdict == VERDICT_OFF;
    fprintf(stderr, "%7.1f s  %zu rows", now() - start, run->table->count - first);
    if (off > 0) fprintf(stderr, ", %zu OFF", off);
    fprintf(stderr, "\n");
}

/* The rows that hold for all experiments together. */
static void report_totals(validation_run *run) {
    static const experiment all = {.name = "all", .shows = ""};
    const validation_totals *const totals = run->totals;
    run->experiment = &all;
    if (totals->steps == 0) return;
    validate_row(run, "steps", (double)totals->steps, "", nothing(), "");
    validate_row(run, "contacts, summed over steps", (double)totals->contacts, "", nothing(), "");
    validate_row(run, "rescues a contact",
                 totals->contacts > 0 ? (double)totals->rescues / (double)totals->contacts : 0.0,
                 "", at_most(1e-3), "one in 1,000");
    validate_row(run, "smallest gap over the minimum gap", totals->smallest_gap_share, "",
                 at_least(1.0), "the promise of a step");
    validate_row(run, "states judged", (double)totals->judged, "", nothing(), "");
    validate_row(run, "pairs of triangles that cross in them", (double)totals->crossing, "",
                 equals(0.0), "exact judge");
}

static int finish(const validation_run *run, const command_line *line) {
    validation_print_table(run->table);
    size_t off = 0;
    for (size_t i = 0; i < run->table->count; i++)
        off += run->table->rows[i].verdict == VERDICT_OFF;
    printf("%zu rows, %zu off\n", run->table->count, off);
    if (line->csv) {
        FILE *const file = fopen(line->csv, "w");
        if (file) validation_write_csv(file, run->table, run->options);
        if (!file || fclose(file) != 0) {
            fprintf(stderr, "%s: cannot be written: %s\n", line->csv, strerror(errno));
            return 2;
        }
    }
    return off > 0;
}

int main(int count, char **arguments) {
    (void)count;
    command_line const line = read_command_line(arguments);
    validation_table table = {0};
    validation_totals totals = {.smallest_gap_share = (double)INFINITY};
    static validation_run run;
    run = (validation_run){.options = &line.options,
                           .def = tulle_world_def_default(),
                           .table = &table,
                           .totals = &totals,
                           .plot_directory = line.plots};
    apply_options(&line.options, &run.def);
    size_t run_count = 0;
    for (const experiment *const *group = validation_groups; *group; group++) {
        for (const experiment *entry = *group; entry->name; entry++) {
            if (!is_chosen(entry, &line)) continue;
            run_count++;
            if (line.is_list) {
                printf("%-28s %s\n", entry->name, entry->shows);
                continue;
            }
            run.experiment = entry;
            run_one(&run);
        }
    }
    if (run_count == 0) refuse("no experiment has the name ", line.only ? line.only : "");
    if (line.is_list) return 0;
    report_totals(&run);
    int const code = finish(&run, &line);
    free(table.rows);
    return code;
}
