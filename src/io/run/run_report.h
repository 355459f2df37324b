/* io/run/run_report.h - report.csv: the columns of a step report as text, and back. */
#ifndef TULLE_IO_RUN_RUN_REPORT_H
#define TULLE_IO_RUN_RUN_REPORT_H

#include "base/memory.h"

#include "tulle/world.h"

enum { RUN_REPORT_LINE_SIZE = 2048 }; /* [bytes] room for the heading or any line */

/* The heading, with its line end; returns the length. */
size_t run_report_format_heading(char text[RUN_REPORT_LINE_SIZE]);
/* One line, with its line end; numbers that are not finite are left empty. */
size_t run_report_format(const tulle_step_report *report, char text[RUN_REPORT_LINE_SIZE]);

typedef ARRAY(tulle_step_report) run_report_rows;

/* Adds the whole lines of a report.csv; a missing or empty file has none. Errors: TULLE_ERROR_IO,
 * TULLE_ERROR_PARSE with line and column, TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status run_report_read(memory *heap, const char *path, run_report_rows *rows,
                             tulle_error *error);

#endif
