/* app/info/gnuplot.h - a picture drawn by the program gnuplot, which appears whole or not at all.
 */
#ifndef TULLE_APP_INFO_GNUPLOT_H
#define TULLE_APP_INFO_GNUPLOT_H

#include "app/info/plot.h"

#include <stdbool.h>

/* Whether the file's name ends as a picture's: .svg, .png or .pdf. */
bool gnuplot_takes(const char *path);
/* Draws to a file that gnuplot_takes. Prints what went wrong; returns the program's exit code:
 * APP_EXIT_BAD_INPUT also where there is no gnuplot. */
int gnuplot_draw(const plot_content *content, const char *path);

#endif
