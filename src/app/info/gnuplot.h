/* app/info/gnuplot.h - a picture drawn by the program gnuplot, which appears whole or not at all.
 */
#ifndef TULLE_APP_INFO_GNUPLOT_H
#define TULLE_APP_INFO_GNUPLOT_H

#include <stdbool.h>
#include <stdio.h>

typedef struct gnuplot_plot {
    /* Writes the commands; terminal is one of gnuplot's, with its options, for `set terminal`. */
    void (*write)(FILE *script, const void *content, const char *terminal);
    const void *content;
    double width, height; /* [pixels] */
} gnuplot_plot;

/* Whether the file's name ends as a picture's: .svg, .png or .pdf. */
bool gnuplot_takes(const char *path);
/* Draws to the file. Prints, in the name of the subcommand, what went wrong; returns the program's
 * exit code: APP_EXIT_BAD_INPUT also where there is no gnuplot. */
int gnuplot_draw(const char *command, const gnuplot_plot *plot, const char *path);

#endif
