/* app/reproduce_plot.h - curves over a common axis, panel above panel, drawn by gnuplot. */
#ifndef TULLE_APP_REPRODUCE_PLOT_H
#define TULLE_APP_REPRODUCE_PLOT_H

#include "app/reproduce.h"

enum { PLOT_SERIES_MAX = 20, PLOT_PANELS_MAX = 4, PLOT_NAME_SIZE = 64 };

typedef struct plot_series {
    char name[PLOT_NAME_SIZE];
    double *points; /* x, y of each */
    size_t count;
    bool is_published; /* of the paper: marks without a line */
} plot_series;

typedef struct plot_panel {
    const char *title, *x_label, *y_label;
    plot_series series[PLOT_SERIES_MAX];
    size_t series_count;
} plot_panel;

typedef struct plot_page {
    plot_panel panels[PLOT_PANELS_MAX];
    size_t panel_count;
    bool has_failed; /* no memory for a point */
} plot_page;

/* The series of that name in the panel, made when it is not there; null when the panel is full. */
plot_series *plot_get_series(plot_panel *panel, const char *name);
void plot_add_point(plot_page *page, plot_series *series, double x, double y);
/* Draws the panels that hold points to an .svg file in the directory of the results. Without
 * gnuplot that is said once, and all goes on. */
int plot_draw(reproduce *self, const plot_page *page, const char *file);
void plot_release(plot_page *page);

#endif
