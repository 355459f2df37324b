/* app/cli/messages.c - what the subcommands share: exit codes for statuses, error messages on
 * standard error. */
#include "app/commands.h"

#include "base/text.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

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

static void print_names(FILE *stream, const char *format, va_list arguments) {
    char text[8192];
    int const length = vsnprintf(text, sizeof text, format, arguments);
    if (length < 0) return;
    size_t const count = strlen(text);
    bool const ends_line = count > 0 && text[count - 1] == '\n';
    if (ends_line) text[count - 1] = '\0';
    text_hide_controls(text);
    fputs(text, stream);
    if (ends_line) fputc('\n', stream);
}

void app_print_names(FILE *stream, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_names(stream, format, arguments);
    va_end(arguments);
}

void app_print_error(const char *command, const tulle_error *error) {
    fprintf(stderr, "tulle %s: ", command);
    if (error->file[0]) {
        app_print_names(stderr, "%s", error->file);
        if (error->line > 0) fprintf(stderr, ":%d", error->line);
        if (error->line > 0 && error->column > 0) fprintf(stderr, ":%d", error->column);
        fputs(": ", stderr);
    }
    const char *line = error->message[0] ? error->message : tulle_status_text(error->status);
    /* This one has lines, and no names but those of a scene, which have no control characters. */
    while (error->status == TULLE_ERROR_INTERSECTING_START && strchr(line, '\n')) {
        int const length = (int)strcspn(line, "\n");
        app_print_names(stderr, "%.*s", length, line);
        fputc('\n', stderr);
        line += length + 1;
    }
    app_print_names(stderr, "%s", line);
    fputc('\n', stderr);
}

void app_print_message(const char *command, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "tulle %s: ", command);
    print_names(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

tulle_status app_start_world(tulle_world *world, const char *scene_path, tulle_error *error) {
    tulle_status const status = tulle_world_start(world, error);
    if (status != TULLE_OK && !error->file[0])
        snprintf(error->file, sizeof error->file, "%s", scene_path);
    return status;
}

int app_finish_output(const char *command) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return APP_EXIT_FINE;
    app_print_message(command, "standard output could not be written; is the disk full?");
    return APP_EXIT_CANNOT_GO_ON;
}
