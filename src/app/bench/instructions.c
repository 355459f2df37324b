/* app/bench/instructions.c - instructions of the timed steps of a small case on one thread: the
 * program runs itself under valgrind's callgrind, which counts within bench_make_steps alone.
 * valgrind shows every processor as one without the widest vectors, so the number is the same on
 * all machines of a build, but for what the C library chooses by the processor. */
#define _POSIX_C_SOURCE 200809L
#include "app/bench/bench.h"
#include "app/cli/interrupt.h"
#include "app/commands.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

enum {
    ARGUMENT_SIZE = BENCH_PATH_SIZE + 64,
    EXIT_NOT_FOUND = 127,
    POLL_INTERVAL = 20000000 /* [ns] */
};

/* Its exit code, -1 if it could not be waited for; an interrupt is handed on to it. */
static int wait_for(pid_t process) {
    int state = 0;
    bool is_told = false;
    for (;;) {
        pid_t const ended = waitpid(process, &state, WNOHANG);
        if (ended == process) return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
        if (ended < 0 && errno != EINTR) return -1;
        if (interrupt_is_pending() && !is_told) is_told = kill(process, SIGINT) == 0;
        nanosleep(&(struct timespec){.tv_nsec = POLL_INTERVAL}, NULL);
    }
}

/* valgrind's exit code, -1 if it could not be waited for, EXIT_NOT_FOUND if it is missing. */
static int run_valgrind(char *const arguments[], int messages) {
    posix_spawn_file_actions_t actions;
    pid_t process = 0;
    int code = posix_spawn_file_actions_init(&actions);
    if (code) return -1;
    code = posix_spawn_file_actions_adddup2(&actions, messages, STDOUT_FILENO);
    if (!code) code = posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
    if (!code) code = posix_spawnp(&process, "valgrind", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (code) return code == ENOENT ? EXIT_NOT_FOUND : -1;
    return wait_for(process);
}

/* The number behind "summary:" or "totals:" of a file that callgrind wrote; 0 if there is none. */
static double read_instructions(const char *path) {
    FILE *const file = fopen(path, "r");
    char line[512];
    double count = 0.0;
    while (file && count <= 0.0 && fgets(line, sizeof line, file))
        if (strncmp(line, "summary: ", 9) == 0 || strncmp(line, "totals: ", 8) == 0)
            count = strtod(strchr(line, ' '), NULL);
    if (file) fclose(file);
    return count;
}

/* Prints what valgrind and the program under it said last. */
static void print_end(FILE *messages) {
    char line[256];
    rewind(messages);
    while (fgets(line, sizeof line, messages)) fputs(line, stderr);
}

/* One repeat of the case by this same program. */
static int count_case(const bench_session *self, const bench_case *which, const char *file,
                      double *count) {
    char program[BENCH_PATH_SIZE], output[ARGUMENT_SIZE], inputs[ARGUMENT_SIZE],
        scenes[ARGUMENT_SIZE], size[ARGUMENT_SIZE];
    ssize_t const length = readlink("/proc/self/exe", program, sizeof program - 1);
    FILE *const messages = tmpfile();
    if (length <= 0 || !messages) {
        app_print_message("bench", "--instructions: %s", strerror(errno));
        if (messages) fclose(messages);
        return APP_EXIT_CANNOT_GO_ON;
    }
    program[length] = '\0';
    snprintf(output, sizeof output, "--callgrind-out-file=%s", file);
    snprintf(inputs, sizeof inputs, "--inputs=%s", self->inputs);
    snprintf(scenes, sizeof scenes, "--scenes=%s", self->scenes);
    snprintf(size, sizeof size, "--particles=%s", bench_sizes[which->size].name);
    char valgrind[] = "valgrind", tool[] = "--tool=callgrind", start[] = "--collect-atstart=no",
         toggle[] = "--toggle-collect=bench_make_steps", bench[] = "bench", threads[] = "-t1",
         repeat[] = "-r1", scene_name[BENCH_NAME_SIZE];
    snprintf(scene_name, sizeof scene_name, "%s", which->scene->name);
    char *const arguments[] = {valgrind, tool,       start,   toggle, output, program, bench,
                               inputs,   scene_name, threads, repeat, size,   scenes,  NULL};
    int const code = run_valgrind(arguments, fileno(messages));
    *count = code == 0 ? read_instructions(file) : 0.0;
    bool const is_interrupted = interrupt_is_pending();
    if (code != EXIT_NOT_FOUND && *count <= 0.0 && !is_interrupted) {
        app_print_message("bench", "valgrind ended with %d and no count; it said:", code);
        print_end(messages);
    }
    fclose(messages);
    if (is_interrupted) return APP_EXIT_INTERRUPTED;
    return code == EXIT_NOT_FOUND || *count > 0.0 ? APP_EXIT_FINE : APP_EXIT_CANNOT_GO_ON;
}

int bench_count_instructions(bench_session *self, const bench_case *which) {
    bench_row row = {.threads = 1, .kind = BENCH_INSTRUCTIONS, .name = "steps"};
    snprintf(row.scene, sizeof row.scene, "%s", which->scene->name);
    snprintf(row.size, sizeof row.size, "%s", bench_sizes[which->size].name);
    char file[] = "/tmp/tulle-bench-XXXXXX";
    int const handle = mkstemp(file);
    if (handle < 0) {
        app_print_message("bench", "--instructions: %s: %s", file, strerror(errno));
        return APP_EXIT_CANNOT_GO_ON;
    }
    close(handle);
    int const code = count_case(self, which, file, &row.value);
    unlink(file);
    if (code != APP_EXIT_FINE) return code;
    if (row.value <= 0.0) {
        app_print_message("bench", "skipped: instructions are counted by valgrind, which is not on "
                                   "the PATH (Debian's package is valgrind)");
        self->counts_instructions = false;
        return APP_EXIT_FINE;
    }
    fprintf(stderr, "%s %s: %.4g million instructions\n", row.scene, row.size, 1e-6 * row.value);
    return bench_rows_put(&self->rows, &row) ? APP_EXIT_FINE : APP_EXIT_OUT_OF_MEMORY;
}
