/* app/info/plot.h - `tulle info --plot`: a run's step reports as one picture, drawn by gnuplot. */
#ifndef TULLE_APP_INFO_PLOT_H
#define TULLE_APP_INFO_PLOT_H

#include "tulle/world.h"

#include <stdbool.h>
#include <stdio.h>

/* What the picture shows. */
typedef struct plot_content {
    const char *name; /* of the run, any text */
    const tulle_step_report *reports;
    size_t report_count; /* > 0 */
} plot_content;

/* Writes commands for gnuplot that draw the content to standard output; terminal is one of
 * gnuplot's, with its options. Nothing in the content can become a command. */
void plot_write_script(FILE *script, const plot_content *content, const char *terminal);

/* Draws the reports of a run directory to a file; .svg, .png or .pdf by its name. Prints what went
 * wrong to standard error; returns the program's exit code. */
int info_plot_run(const char *directory, const char *path);

#endif
