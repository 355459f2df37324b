/* support/query_file.h - published queries of moving feature pairs (CSV of rational coordinates)
 * and their answers (JSON arrays of booleans). */
#ifndef TULLE_TEST_QUERY_FILE_H
#define TULLE_TEST_QUERY_FILE_H

#include "detect/impact/time_of_impact.h"

#include <stdio.h>

/* The folder that TULLE_DATA_DIR names; null when it is not set, or lacks the file `probe`. */
const char *find_data_path(const char *probe);
/* A file of that folder; fails the test where it is missing. */
FILE *open_data(const char *name);
/* The next 8 points; truth: 1, 0, or -1 when the file does not say. False at the end of the file.
 */
bool read_query(FILE *file, moving_pair *pair, int *truth);
/* The next value of a JSON array of booleans; -1 at its end. */
int read_boolean(FILE *file);

#endif
