/* validate_main.c - tulle_validate: runs the experiments and prints measured against expected.
 * Exit code 0: all rows hold; 1: one is off; 2: wrong options; 130: interrupted. */
#include "support/paper_options.h"
#include "validation/validation_report.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_WRONG_OPTIONS = 2, EXIT_INTERRUPTED = 130, EXPERIMENTS_MAX = 256 };

static const char usage[] =
    "usage: tulle_validate [OPTION...]\n"
    "  --list               names of the experiments and what they show\n"
    "  --only NAME[,...]    these experiments, or those whose names begin so\n"
    "  --quick              small sizes, short runs\n"
    "  --response NAME      coupled (default) or paper\n"
    "  --motion-space NAME  cone (default) or polyhedral, of the response paper\n"
    "  --integrator NAME    implicit-euler (default), crank-nicolson or bdf2\n"
    "  --threads N          default 1\n"
    "  --csv FILE           the rows, written anew after each experiment\n"
    "  --resume             keep the rows of that file, run the experiments that have none\n"
    "  --plots DIR          data of the plots, into a folder that is there\n";

typedef struct command_line {
    validation_options options;
    const char *only, *csv, *plots;
    bool is_list, is_resumed;
} command_line;

_Noreturn static void refuse(const char *what, const char *value) {
    fprintf(stderr, "tulle_validate: %s%s\n%s", what, value, usage);
    exit(EXIT_WRONG_OPTIONS);
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
        } else if (strcmp(name, "--resume") == 0) {
            line.is_resumed = true;
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
    if (line.is_resumed && !line.csv) refuse("--resume needs ", "--csv FILE");
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
    tulle_paper_options *const paper = change_paper(def);
    paper->response = (tulle_response)choose(responses, options->response, "unknown response ");
    if (paper->response == TULLE_RESPONSE_PAPER)
        paper->motion_space = (tulle_motion_space)choose(motion_spaces, options->motion_space,
                                                         "unknown motion space ");
    def->threads = options->threads;
}

/* How `name` is in the comma-separated `list`: not, by its beginning or whole. */
typedef enum listing { NOT_LISTED, LISTED_BY_BEGINNING, LISTED_WHOLE } listing;

static listing find_listing(const char *name, const char *list) {
    listing best = NOT_LISTED;
    while (*list) {
        size_t const length = strcspn(list, ",");
        if (length > 0 && strncmp(name, list, length) == 0) {
            if (!name[length]) return LISTED_WHOLE;
            best = LISTED_BY_BEGINNING;
        }
        list += length;
        if (*list == ',') list++;
    }
    return best;
}

/* Quick runs leave long experiments out unless they are named whole. */
static bool is_wanted(const experiment *entry, const command_line *line) {
    listing const listed = line->only ? find_listing(entry->name, line->only) : LISTED_BY_BEGINNING;
    bool const is_left_out = entry->is_long && line->options.is_quick;
    return listed >= (is_left_out ? LISTED_WHOLE : LISTED_BY_BEGINNING);
}

static size_t count_off(const validation_table *table, size_t first) {
    size_t off = 0;
    for (size_t i = first; i < table->count; i++) off += table->rows[i].verdict == VERDICT_OFF;
    return off;
}

/* Whether it has rows already. */
static bool is_done(const experiment *entry, const validation_table *table) {
    for (size_t i = 0; i < table->count; i++)
        if (table->rows[i].experiment == entry->name) return true;
    return false;
}

/* The experiments to be run, in the order of the table, into `chosen` if it is not null. */
static size_t choose_experiments(const command_line *line, const validation_table *table,
                                 const experiment **chosen) {
    size_t count = 0;
    for (const experiment *const *group = validation_groups; *group; group++) {
        for (const experiment *entry = *group; entry->name; entry++) {
            if (!is_wanted(entry, line) || is_done(entry, table)) continue;
            if (chosen) chosen[count] = entry;
            count++;
        }
    }
    return count;
}

/* Writes the rows of now with the totals of now. */
static void save(validation_run *run, const command_line *line) {
    if (!line->csv) return;
    validation_sort_table(run->table);
    size_t const count = run->table->count;
    validation_report_totals(run);
    if (!validation_write_csv(line->csv, run->table, run->options)) {
        fprintf(stderr, "%s: cannot be written: %s\n", line->csv, strerror(errno));
        exit(EXIT_WRONG_OPTIONS);
    }
    run->table->count = count;
}

/* False when it was interrupted. */
static bool run_one(validation_run *run, const command_line *line) {
    const experiment *const entry = run->experiment;
    size_t const first = run->table->count;
    validation_progress_start(&run->progress, entry->name);
    if (!validation_run_experiment(run)) return false;
    validation_progress_end(&run->progress, entry->name, run->table->count - first,
                            count_off(run->table, first));
    save(run, line);
    return true;
}

static int finish(validation_run *run, const command_line *line, bool is_interrupted) {
    save(run, line); /* where nothing was left to be run: as one table */
    validation_report_totals(run);
    validation_print_table(run->table);
    size_t const off = count_off(run->table, 0);
    printf("%zu rows, %zu off\n", run->table->count, off);
    if (!is_interrupted) return off > 0;
    progress_bar_clear(&run->progress.bar);
    fprintf(stderr, "interrupted; %s\n",
            line->csv ? "--resume goes on with the experiments that have no rows in the CSV file"
                      : "with --csv FILE it could go on where it was");
    return EXIT_INTERRUPTED;
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
    /* Of experiments of contact; those of cloth itself say woven, and those of the air its drag. */
    run.def.membrane = TULLE_MEMBRANE_SPRINGS;
    run.def.wind.drag_coefficient = 0.0;
    apply_options(&line.options, &run.def);
    if (choose_experiments(&line, &table, NULL) == 0)
        refuse("no experiment has the name ", line.only ? line.only : "");
    if (line.is_resumed && !validation_read_csv(line.csv, &line.options, &table, &totals))
        return EXIT_WRONG_OPTIONS;
    const experiment *chosen[EXPERIMENTS_MAX];
    size_t const chosen_count = choose_experiments(&line, &table, NULL);
    if (chosen_count > EXPERIMENTS_MAX) refuse("too many experiments for ", "this program");
    choose_experiments(&line, &table, chosen);
    validation_catch_interrupts();
    run.progress.experiment_count = chosen_count;
    bool is_interrupted = false;
    for (size_t i = 0; i < chosen_count && !is_interrupted; i++) {
        run.experiment = chosen[i];
        if (line.is_list)
            printf("%-28s %s\n", chosen[i]->name, chosen[i]->shows);
        else
            is_interrupted = !run_one(&run, &line);
    }
    int const code = line.is_list ? 0 : finish(&run, &line, is_interrupted);
    free(table.rows);
    return code;
}
