/* app/cli/run_damage.h - tells which files of a run are not as the run wrote them. */
#ifndef TULLE_APP_CLI_RUN_DAMAGE_H
#define TULLE_APP_CLI_RUN_DAMAGE_H

#include "tulle_io/run.h"

/* Compares all files of the run with their checksums and prints those that are damaged on standard
 * error; TULLE_ERROR_PARSE if there are some. A run without checksums is fine. */
tulle_status run_damage_report(const char *command, const char *directory, tulle_run_reader *reader,
                               tulle_error *error);

#endif
