/* validation_report.h - the table of rows as text and as CSV. */
#ifndef TULLE_TEST_VALIDATION_REPORT_H
#define TULLE_TEST_VALIDATION_REPORT_H

#include "validation/validation_run.h"

/* "<= 1e-06", "2.548 +- 1%", ... */
void validation_expectation_text(expectation expected, char text[48]);
void validation_print_table(const validation_table *table);
/* Header and rows; the columns response, motion_space and integrator repeat the options. */
void validation_write_csv(FILE *file, const validation_table *table,
                          const validation_options *options);

#endif
