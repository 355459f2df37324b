/* app/info/gnuplot.c - see gnuplot.h. gnuplot is started without a shell. It reads its commands
 * from a temporary file and draws to its standard output, which is a temporary file in the target's
 * folder. So no name that a user gave is ever part of a command. */
#define _POSIX_C_SOURCE 200809L
#include "app/info/gnuplot.h"

#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "app/info/plot.h"
#include "io/file_data.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { PATH_SIZE = 4096, TERMINAL_SIZE = 160 };
enum { PLOT_WIDTH = 1000, PLOT_HEIGHT = 1400 /* [pixels] */ };

typedef struct plot_format {
    const char *extension, *terminal; /* terminal: a format for width and height */
    const char *ending;               /* stands near the end of every whole file */
    double unit;                      /* of the size, in pixels: inches are 1 / 0.007 */
} plot_format;

static const plot_format formats[] = {
    {".svg", "svg size %.0f,%.0f enhanced font 'Helvetica,11' background rgb 'white'", "</svg>",
     1.0},
    {".png", "pngcairo size %.0f,%.0f enhanced font 'Sans,10' background rgb 'white'", "IEND", 1.0},
    {".pdf", "pdfcairo size %.4gin,%.4gin enhanced font 'Sans,9'", "%%EOF", 0.007},
};
/* [bytes] of a file's end that hold its ending. */
enum { ENDING_SIZE = 64 };

static const plot_format *find_format(const char *path) {
    size_t const length = strlen(path);
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        if (length > 4 && strcmp(path + length - 4, formats[i].extension) == 0) return &formats[i];
    return NULL;
}

/* Whether a file ends as its format does. gnuplot ends well although its disk was full. */
static bool is_whole(int file, const plot_format *format) {
    struct stat facts;
    char end[ENDING_SIZE + 1] = {0};
    if (fstat(file, &facts) != 0) return false;
    off_t const from = facts.st_size > ENDING_SIZE ? facts.st_size - ENDING_SIZE : 0;
    ssize_t const count = pread(file, end, ENDING_SIZE, from);
    size_t const length = strlen(format->ending);
    for (ssize_t i = 0; i + (ssize_t)length <= count; i++)
        if (memcmp(end + i, format->ending, length) == 0) return true;
    return false;
}

/* Starts gnuplot with these files; 0 or an errno. */
static int start_gnuplot(int input, int output, int messages, pid_t *process) {
    char name[] = "gnuplot", defaults[] = "-d"; /* -d: no settings of the user's */
    char *const arguments[] = {name, defaults, NULL};
    posix_spawn_file_actions_t actions;
    int code = posix_spawn_file_actions_init(&actions);
    if (code) return code;
    code = posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    if (!code) code = posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    if (!code) code = posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
    if (!code) code = posix_spawnp(process, name, &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    return code;
}

/* The line of gnuplot's messages that says what is wrong: the last that holds letters. */
static void find_reason(FILE *messages, char reason[256]) {
    char line[256];
    strcpy(reason, "it said nothing");
    rewind(messages);
    while (fgets(line, sizeof line, messages)) {
        line[strcspn(line, "\n")] = '\0';
        if (line[strspn(line, " \t^")] != '\0') memcpy(reason, line, sizeof line);
    }
}

/* Runs gnuplot to its end. Prints what went wrong; returns an exit code. */
static int run_gnuplot(FILE *script, int output, FILE *messages) {
    pid_t process = 0;
    rewind(script);
    int const code = start_gnuplot(fileno(script), output, fileno(messages), &process);
    if (code == ENOENT) {
        app_print_message("info", "plots need the program gnuplot, which is not on the PATH; "
                                  "install it (Debian's package is gnuplot-nox)");
        return APP_EXIT_BAD_INPUT;
    }
    if (code) {
        app_print_message("info", "gnuplot cannot be started: %s", strerror(code));
        return APP_EXIT_CANNOT_GO_ON;
    }
    int state = 0;
    while (waitpid(process, &state, 0) < 0)
        if (errno != EINTR) return APP_EXIT_CANNOT_GO_ON;
    if (interrupt_is_pending()) return APP_EXIT_INTERRUPTED;
    if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return APP_EXIT_FINE;
    if (WIFEXITED(state) && WEXITSTATUS(state) == 127) { /* a spawn that could not find it */
        app_print_message("info",
                          "plots need the program gnuplot (Debian's package is gnuplot-nox)");
        return APP_EXIT_BAD_INPUT;
    }
    char reason[256];
    find_reason(messages, reason);
    app_print_message("info", "gnuplot failed: %s", reason);
    return APP_EXIT_CANNOT_GO_ON;
}

static void write_script(FILE *script, const plot_content *content, const plot_format *format) {
    char terminal[TERMINAL_SIZE];
    /* the formats are those of the table above */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    snprintf(terminal, sizeof terminal, format->terminal, PLOT_WIDTH * format->unit,
             PLOT_HEIGHT * format->unit);
#pragma GCC diagnostic pop
    plot_write_script(script, content, terminal);
}

/* Draws to a temporary file in the folder of `path` and renames it. */
static int draw(const plot_content *content, const char *path, const plot_format *format) {
    char temporary[PATH_SIZE];
    int const length = snprintf(temporary, sizeof temporary, "%s.%ld.tmp", path, (long)getpid());
    if (length >= PATH_SIZE) {
        app_print_message("info", "the name of the plot is longer than %d bytes", PATH_SIZE);
        return APP_EXIT_BAD_INPUT;
    }
    struct stat facts;
    bool const is_taken = stat(path, &facts) == 0 && !S_ISREG(facts.st_mode);
    int const output = is_taken ? -1 : open(temporary, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
    if (output < 0) {
        app_print_message("info", "%s: cannot be written: %s", path,
                          is_taken ? "is there and no file" : strerror(errno));
        return !is_taken && errno == ENOSPC ? APP_EXIT_CANNOT_GO_ON : APP_EXIT_BAD_INPUT;
    }
    FILE *const script = tmpfile(), *const messages = tmpfile();
    int code = APP_EXIT_CANNOT_GO_ON;
    if (script && messages) {
        write_script(script, content, format);
        if (fflush(script) == 0 && !ferror(script))
            code = run_gnuplot(script, output, messages);
        else
            app_print_message("info", "a temporary file cannot be written: %s", strerror(errno));
    } else {
        app_print_message("info", "no temporary file can be made: %s", strerror(errno));
    }
    if (script) fclose(script);
    if (messages) fclose(messages);
    if (code == APP_EXIT_FINE && !is_whole(output, format)) {
        app_print_message(
            "info", "%s: gnuplot did not write it to its end; is there room on the disk?", path);
        code = APP_EXIT_CANNOT_GO_ON;
    }
    int failure = close(output) == 0 ? 0 : errno;
    if (code == APP_EXIT_FINE && !failure) failure = file_rename(temporary, path);
    if (code == APP_EXIT_FINE && failure) {
        app_print_message("info", "%s: cannot be written: %s", path, strerror(failure));
        code = APP_EXIT_CANNOT_GO_ON;
    }
    if (code != APP_EXIT_FINE) unlink(temporary);
    return code;
}

int gnuplot_draw(const plot_content *content, const char *path) {
    interrupt_catch();
    return draw(content, path, find_format(path));
}

bool gnuplot_takes(const char *path) { return find_format(path) != NULL; }
