/* app/reproduce_plot.c - see reproduce_plot.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/reproduce_plot.h"

#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "app/info/gnuplot.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double WIDTH = 900.0, PANEL_HEIGHT = 330.0; /* [pixels] */
/* Colors that eyes with any color vision tell apart. */
static const char *const colors[] = {"#1b6ab3", "#e8642c", "#2c9a57", "#8030a0",
                                     "#c0a020", "#444444", "#20a0b0", "#d04080"};
enum { COLOR_COUNT = sizeof colors / sizeof colors[0], POINTS_FIRST = 64 };

plot_series *plot_get_series(plot_panel *panel, const char *name) {
    for (size_t i = 0; i < panel->series_count; i++)
        if (strcmp(panel->series[i].name, name) == 0) return &panel->series[i];
    if (panel->series_count == PLOT_SERIES_MAX) return NULL;
    plot_series *const made = &panel->series[panel->series_count++];
    *made = (plot_series){0};
    snprintf(made->name, sizeof made->name, "%s", name);
    return made;
}

void plot_add_point(plot_page *page, plot_series *series, double x, double y) {
    if (!series) return;
    /* room for twice as many whenever a power of two is full */
    size_t const count = series->count;
    if (count == 0 || (count >= POINTS_FIRST && (count & (count - 1)) == 0)) {
        size_t const room = count == 0 ? POINTS_FIRST : 2 * count;
        double *const grown = realloc(series->points, 2 * room * sizeof *grown);
        page->has_failed |= !grown;
        if (!grown) return;
        series->points = grown;
    }
    series->points[2 * count] = x;
    series->points[2 * count + 1] = y;
    series->count++;
}

static bool has_points(const plot_panel *panel) {
    for (size_t i = 0; i < panel->series_count; i++)
        if (panel->series[i].count > 0) return true;
    return false;
}

static size_t count_panels(const plot_page *page) {
    size_t count = 0;
    for (size_t i = 0; i < page->panel_count; i++) count += has_points(&page->panels[i]);
    return count;
}

static void write_data(FILE *script, const plot_page *page) {
    for (size_t p = 0; p < page->panel_count; p++)
        for (size_t s = 0; s < page->panels[p].series_count; s++) {
            const plot_series *const series = &page->panels[p].series[s];
            fprintf(script, "$p%zus%zu << END_OF_POINTS\n", p, s);
            for (size_t i = 0; i < series->count; i++)
                fprintf(script, "%.9g %.9g\n", series->points[2 * i], series->points[2 * i + 1]);
            fputs("END_OF_POINTS\n", script);
        }
}

static void write_panel(FILE *script, const plot_page *page, size_t index) {
    const plot_panel *const panel = &page->panels[index];
    fprintf(script, "set title '%s'\nset xlabel '%s'\nset ylabel '%s'\nplot NaN notitle",
            panel->title, panel->x_label, panel->y_label);
    size_t color = 0; /* the same for the same series, whether published marks are there or not */
    for (size_t s = 0; s < panel->series_count; s++) {
        const plot_series *const series = &panel->series[s];
        size_t const own = color;
        color += !series->is_published;
        if (series->count == 0) continue;
        fprintf(script, ", \\\n $p%zus%zu using 1:2 with ", index, s);
        if (series->is_published)
            fputs("points pt 6 ps 1.4 lw 2 lc rgb '#000000'", script);
        else
            fprintf(script, "%s pt 7 ps 0.5 lw 1.6 lc rgb '%s'",
                    series->count > POINTS_FIRST ? "lines" : "linespoints",
                    colors[own % COLOR_COUNT]);
        fprintf(script, " title '%s'", series->name);
    }
    fputc('\n', script);
}

static void write_script(FILE *script, const void *content, const char *terminal) {
    const plot_page *const page = content;
    write_data(script, page);
    fprintf(
        script,
        "set encoding utf8\nset terminal %s\nset multiplot layout %zu,1\n"
        "set key outside right top Left reverse samplen 1.6 font ',10' noenhanced\n"
        "set border lc rgb '#555555' lw 0.8; set tics font ',10' textcolor rgb '#333333'\n"
        "set grid lc rgb '#dddddd' lt 1 lw 0.6; set yrange [0:*]; set offsets 0,0,graph 0.05,0\n",
        terminal, count_panels(page));
    for (size_t i = 0; i < page->panel_count; i++)
        if (has_points(&page->panels[i])) write_panel(script, page, i);
    fputs("unset multiplot\n", script);
}

/* Whether a program of that name is on the PATH. */
static bool is_on_path(const char *program) {
    const char *from = getenv("PATH");
    while (from && *from) {
        size_t const length = strcspn(from, ":");
        char path[REPRODUCE_PATH_SIZE];
        snprintf(path, sizeof path, "%.*s/%s", (int)length, from, program);
        if (access(path, X_OK) == 0) return true;
        from += length + (from[length] == ':');
    }
    return false;
}

int plot_draw(reproduce *self, const plot_page *page, const char *file) {
    char path[REPRODUCE_PATH_SIZE];
    reproduce_make_path(self, path, "%s", file);
    if (page->has_failed) {
        app_print_message("reproduce", "out of memory for %s", file);
        return APP_EXIT_OUT_OF_MEMORY;
    }
    (void)remove(path); /* an old plot beside new tables would tell another story */
    if (count_panels(page) == 0) return APP_EXIT_FINE;
    if (!is_on_path("gnuplot")) {
        if (!self->has_told_gnuplot)
            app_print_message("reproduce", "no plots are drawn: the program gnuplot is not on the "
                                           "PATH (Debian's package is gnuplot-nox)");
        self->has_told_gnuplot = self->is_lacking = true;
        return APP_EXIT_FINE;
    }
    gnuplot_plot const plot = {write_script, page, WIDTH,
                               PANEL_HEIGHT * (double)count_panels(page)};
    int const code = gnuplot_draw("reproduce", &plot, path);
    self->is_lacking |= code != APP_EXIT_FINE;
    /* a plot that cannot be drawn is said, and the tables are worth going on for */
    return code == APP_EXIT_INTERRUPTED || interrupt_is_pending() ? APP_EXIT_INTERRUPTED
                                                                  : APP_EXIT_FINE;
}

void plot_release(plot_page *page) {
    for (size_t p = 0; p < page->panel_count; p++)
        for (size_t s = 0; s < page->panels[p].series_count; s++)
            free(page->panels[p].series[s].points);
    *page = (plot_page){0};
}
