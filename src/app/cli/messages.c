/* app/cli/messages.c - what the subcommands share: exit codes for statuses, error messages on
 * standard error. */
#include "app/commands.h"

#include <stdarg.h>
#include <stdio.h>

int app_exit_for_input(tulle_status status) {
    switch (status) {
    case TULLE_OK: return APP_EXIT_FINE;
    case TULLE_ERROR_OUT_OF_MEMORY: return APP_EXIT_OUT_OF_MEMORY;
    case TULLE_ERROR_INTERRUPTED: return APP_EXIT_INTERRUPTED;
    default: return APP_EXIT_BAD_INPUT;
    }
}

int app_exit_for_run(tulle_status status) {
    switch (status) {
    case TULLE_ERROR_IO:
    case TULLE_ERROR_DISK_FULL:
    case TULLE_ERROR_PINCHED:
    case TULLE_ERROR_INTERSECTING_START: /* by an obstacle that appears */
    case TULLE_ERROR_STEP_FAILED:
    case TULLE_ERROR_LIMIT: return APP_EXIT_CANNOT_GO_ON;
    default: return app_exit_for_input(status);
    }
}

void app_print_error(const char *command, const tulle_error *error) {
    fprintf(stderr, "tulle %s: ", command);
    if (error->file[0]) {
        fputs(error->file, stderr);
        if (error->line > 0) fprintf(stderr, ":%d", error->line);
        if (error->line > 0 && error->column > 0) fprintf(stderr, ":%d", error->column);
        fputs(": ", stderr);
    }
    fprintf(stderr, "%s\n", error->message[0] ? error->message : tulle_status_text(error->status));
}

void app_print_message(const char *command, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "tulle %s: ", command);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

int app_finish_output(const char *command) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return APP_EXIT_FINE;
    app_print_message(command, "standard output could not be written; is the disk full?");
    return APP_EXIT_CANNOT_GO_ON;
}
