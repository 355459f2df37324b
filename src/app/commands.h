/* app/commands.h - the subcommands of the program. Each takes its own name as argv[0] and gives the
 * program's exit code. */
#ifndef TULLE_APP_COMMANDS_H
#define TULLE_APP_COMMANDS_H

#include "tulle/tulle.h"

#include <stdio.h>

/* What the program's exit code says. */
typedef enum app_exit {
    APP_EXIT_FINE = 0,
    APP_EXIT_FALSE = 1,         /* the thing asked about is false: check found intersections */
    APP_EXIT_BAD_INPUT = 2,     /* bad usage or bad input */
    APP_EXIT_CANNOT_GO_ON = 3,  /* the run could not go on, or its output could not be written */
    APP_EXIT_OUT_OF_MEMORY = 4, /* out of memory */
    APP_EXIT_INTERRUPTED = 130
} app_exit;

int app_run(int argc, char **argv);
int app_check(int argc, char **argv);
int app_detect(int argc, char **argv);
int app_info(int argc, char **argv);
int app_render(int argc, char **argv);
int app_convert(int argc, char **argv);
int app_mend(int argc, char **argv);
int app_fit(int argc, char **argv);
int app_replay(int argc, char **argv);
int app_view(int argc, char **argv);

/* Exit code for a status that the library returned while input was read. */
int app_exit_for_input(tulle_status status);
/* Exit code for a status that the library returned while a run was under way. */
int app_exit_for_run(tulle_status status);

/* Prints "tulle COMMAND: FILE:LINE:COLUMN: MESSAGE" to standard error, the parts that there are. */
void app_print_error(const char *command, const tulle_error *error);
/* Prints "tulle COMMAND: MESSAGE" to standard error. */
void app_print_message(const char *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Prints text that may hold names from a stranger's file: at most 8 kB, with '?' for each control
 * character but a line end at its end, so that no name moves a cursor or ends a line. */
void app_print_names(FILE *stream, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* tulle_world_start; an error that names no file gets that of the scene. */
tulle_status app_start_world(tulle_world *world, const char *scene_path, tulle_error *error);

/* Flushes standard output; 0 when all of it arrived, else a message and APP_EXIT_CANNOT_GO_ON. */
int app_finish_output(const char *command);

#endif
