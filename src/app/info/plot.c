/* app/info/plot.c - see plot.h. */
#include "app/info/plot.h"

#include "app/commands.h"
#include "app/info/gnuplot.h"

#include "tulle_io/run.h"

int info_plot_run(const char *directory, const char *path) {
    if (!gnuplot_takes(path)) {
        app_print_message("info", "%s: a plot is an .svg, .png or .pdf file", path);
        return APP_EXIT_BAD_INPUT;
    }
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    plot_content content = {.name = directory};
    tulle_status status = tulle_run_reader_open(directory, &reader, &error);
    if (!status)
        status =
            tulle_run_reader_get_reports(reader, &content.reports, &content.report_count, &error);
    int code = APP_EXIT_FINE;
    if (status) {
        app_print_error("info", &error);
        code = app_exit_for_input(status);
    } else if (content.report_count == 0) {
        app_print_message(
            "info", "%s: report.csv has no whole line yet, so there is nothing to plot", directory);
        code = APP_EXIT_BAD_INPUT;
    } else {
        code = gnuplot_draw(&content, path);
    }
    tulle_run_reader_close(reader);
    return code;
}
