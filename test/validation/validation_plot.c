/* validation_plot.c - plots of experiments: DIR/NAME.tsv holds (series, x, y), DIR/NAME.gnuplot
 * draws it to NAME.png when gnuplot runs it in DIR. */
#include "validation/validation_run.h"

#include <errno.h>
#include <string.h>

static FILE *open_file(validation_run *run, const char *extension) {
    char path[4096];
    int const length =
        snprintf(path, sizeof path, "%s/%s.%s", run->plot_directory, run->plot.name, extension);
    FILE *const file = length < (int)sizeof path ? fopen(path, "w") : NULL;
    if (!file) fprintf(stderr, "%s: cannot be written: %s\n", path, strerror(errno));
    return file;
}

void validate_start_plot(validation_run *run, const validation_plot *plot) {
    validation_end_plot(run);
    if (!run->plot_directory) return;
    run->plot = *plot;
    run->series_count = 0;
    run->plot_data = open_file(run, "tsv");
}

void validate_plot_point(validation_run *run, const char *series, double x, double y) {
    if (!run->plot_data) return;
    size_t index = 0;
    while (index < run->series_count && strcmp(run->plot_series[index], series) != 0) index++;
    if (index == VALIDATION_SERIES) return;
    if (index == run->series_count)
        snprintf(run->plot_series[run->series_count++], VALIDATION_TEXT, "%s", series);
    fprintf(run->plot_data, "%zu\t%.9g\t%.9g\n", index, x, y);
}

void validation_end_plot(validation_run *run) {
    if (!run->plot_data) return;
    fclose(run->plot_data);
    run->plot_data = NULL;
    FILE *const script = open_file(run, "gnuplot");
    if (!script) return;
    const validation_plot *const plot = &run->plot;
    fprintf(script, "set terminal pngcairo size 720,420 font 'Sans,10' background rgb 'white'\n");
    fprintf(script, "set output '%s.png'\nset title \"%s\" noenhanced\n", plot->name, plot->title);
    fprintf(script, "set xlabel \"%s\" noenhanced\nset ylabel \"%s\" noenhanced\n", plot->x_label,
            plot->y_label);
    fprintf(script, "set grid lt 1 lc rgb '#dddddd'\nset offsets 0, 0, graph 0.03, graph 0.03\n");
    fprintf(script, "set key outside right noenhanced\nset datafile missing NaN\n%s%s",
            plot->is_x_logarithmic ? "set logscale x\nset format x '10^{%T}'\n" : "",
            plot->is_y_logarithmic ? "set logscale y\nset format y '10^{%T}'\n"
                                   : "set format y '%g'\n");
    for (size_t i = 0; i < run->series_count; i++) {
        const char *const name = run->plot_series[i];
        bool const has_points = name[0] == '*';
        fprintf(script, "%s '%s.tsv' using ($1==%zu?$2:NaN):3 with %s title \"%s\"",
                i == 0 ? "plot" : ", \\\n    ", plot->name, i,
                has_points ? "points pt 7 ps 1" : "lines lw 2", name + has_points);
    }
    fprintf(script, "\n");
    fclose(script);
}
