/* validation_plot.c - plots of experiments as tables, which tools/plot_validation.py draws:
 * DIR/NAME.tsv holds lines "# KEY TAB VALUE", then series, x and y. */
#include "validation/validation_run.h"

#include <errno.h>
#include <string.h>

void validate_start_plot(validation_run *run, const validation_plot *plot) {
    validation_end_plot(run);
    if (!run->plot_directory) return;
    char path[4096];
    int const length = snprintf(path, sizeof path, "%s/%s.tsv", run->plot_directory, plot->name);
    run->plot_data = length < (int)sizeof path ? fopen(path, "w") : NULL;
    if (!run->plot_data) {
        fprintf(stderr, "%s: cannot be written: %s\n", path, strerror(errno));
        return;
    }
    fprintf(run->plot_data, "# title\t%s\n# x\t%s\n# y\t%s\n# logarithmic\t%s%s\n", plot->title,
            plot->x_label, plot->y_label, plot->is_x_logarithmic ? "x" : "",
            plot->is_y_logarithmic ? "y" : "");
}

void validate_plot_point(validation_run *run, const char *series, double x, double y) {
    if (!run->plot_data) return;
    fprintf(run->plot_data, "%s\t%.9g\t%.9g\n", series, x, y);
}

void validation_end_plot(validation_run *run) {
    if (run->plot_data) fclose(run->plot_data);
    run->plot_data = NULL;
}
