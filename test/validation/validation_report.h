/* validation_report.h - the table of rows as text and as CSV. */
#ifndef TULLE_TEST_VALIDATION_REPORT_H
#define TULLE_TEST_VALIDATION_REPORT_H

#include "validation/validation_run.h"

/* Into the order of the experiments; rows of one keep theirs. */
void validation_sort_table(validation_table *table);
void validation_print_table(const validation_table *table);

/* Writes head and rows; the columns response, motion_space, integrator and quick repeat the
 * options. The file is whole at any time: the new one takes the place of the old. False with
 * errno. */
bool validation_write_csv(const char *path, const validation_table *table,
                          const validation_options *options);

/* Adds the rows of a file that the former wrote, or of several one after the other, and what their
 * totals hold, as they were judged. A file that is not there has none. False, with a message on
 * standard error, for one that cannot be read, is no such table, or is of other options. */
bool validation_read_csv(const char *path, const validation_options *options,
                         validation_table *table, validation_totals *totals);

#endif
