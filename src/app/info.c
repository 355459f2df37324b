/* app/info.c - `tulle info`: tells what mesh files, point caches and run directories hold. */
#include "app/info.h"

#include "app/commands.h"
#include "app/info_plot.h"
#include "app/options.h"

#include "tulle/run.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static int wants_plot;
static const char *output_path;

static const option_spec options[] = {
    {"plot", 0, OPTION_FLAG, &wants_plot, NULL,
     "draws the step times, contacts, gaps, energies and solves of a run", 0, 0, NULL},
    {"output", 'o', OPTION_TEXT, &output_path, "FILE",
     "the plot, .svg, .png or .pdf (default: plot.svg)", 0, 0, NULL},
};

static const command_spec command = {
    .name = "info",
    .operands = "FILE|DIR ...",
    .summary =
        "Prints what a mesh (.obj, .ply, .stl, .vtp), a point cache (.pc2) or the directory of\n"
        "a run holds: sizes, topology, quality of the triangles, and whether it can be used\n"
        "as cloth or as an obstacle; frames, bodies and the end of a run.",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .operand_minimum = 1,
    .operand_maximum = SIZE_MAX,
};

static bool has_extension(const char *path, const char *extension) {
    size_t const length = strlen(path);
    size_t const extension_length = strlen(extension);
    return length >= extension_length && strcmp(path + length - extension_length, extension) == 0;
}

static tulle_status print_info(const char *path, tulle_error *error) {
    if (has_extension(path, ".pc2")) return info_print_cache(path, error);
    if (tulle_run_is_directory(path)) return info_print_run(path, error);
    return info_print_mesh(path, error);
}

static int plot(char **paths, size_t path_count) {
    if (path_count != 1) {
        app_print_message(command.name, "--plot takes one directory of a run");
        return APP_EXIT_BAD_INPUT;
    }
    if (!tulle_run_is_directory(paths[0])) {
        app_print_message(command.name, "%s: --plot takes the directory of a run", paths[0]);
        return APP_EXIT_BAD_INPUT;
    }
    return info_plot_run(paths[0], output_path ? output_path : "plot.svg");
}

int app_info(int argc, char **argv) {
    size_t path_count = 0;
    options_outcome const outcome = options_parse(&command, argc, argv, &path_count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    if (wants_plot) return plot(argv, path_count);
    if (output_path) {
        app_print_message(command.name, "--output goes with --plot");
        return APP_EXIT_BAD_INPUT;
    }
    int worst = APP_EXIT_FINE;
    for (size_t i = 0; i < path_count; i++) {
        tulle_error error = {0};
        if (i > 0) putchar('\n');
        tulle_status const status = print_info(argv[i], &error);
        if (status == TULLE_OK) continue;
        app_print_error(command.name, &error);
        int const code = app_exit_for_input(status);
        if (code > worst) worst = code;
    }
    int const written = app_finish_output(command.name);
    return worst != APP_EXIT_FINE ? worst : written;
}
