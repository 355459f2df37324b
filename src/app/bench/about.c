/* app/bench/about.c - rows that say what measured: program, compiler, machine. */
#define _DEFAULT_SOURCE /* sysconf's number of processors */
#include "app/bench/bench.h"
#include "app/commands.h"

#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/* A text that is one field of CSV: no commas, quotes or line ends. */
static bool put_text(bench_session *self, const char *name, const char *text) {
    bench_row row = {.kind = BENCH_ABOUT};
    snprintf(row.name, sizeof row.name, "%s", name);
    snprintf(row.text, sizeof row.text, "%s", text);
    for (char *mark = row.text; *mark; mark++)
        if (strchr(",\"", *mark) || (unsigned char)*mark < ' ') *mark = ' ';
    return bench_rows_put(&self->rows, &row);
}

/* The processor's name as the system has it; that of its family where it has none. */
static void name_processor(char text[BENCH_TEXT_SIZE]) {
    struct utsname names;
    snprintf(text, BENCH_TEXT_SIZE, "%s", uname(&names) == 0 ? names.machine : "unknown");
    FILE *const file = fopen("/proc/cpuinfo", "r");
    char line[256];
    while (file && fgets(line, sizeof line, file)) {
        const char *const colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon) continue;
        line[strcspn(line, "\n")] = '\0';
        snprintf(text, BENCH_TEXT_SIZE, "%.90s", colon + 1 + strspn(colon + 1, " "));
        break;
    }
    if (file) fclose(file);
}

int bench_describe_machine(bench_session *self) {
    char version[32], processor[BENCH_TEXT_SIZE], count[32];
    snprintf(version, sizeof version, "tulle %d.%d.%d", TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR,
             TULLE_VERSION_PATCH);
    snprintf(count, sizeof count, "%ld", sysconf(_SC_NPROCESSORS_ONLN));
    name_processor(processor);
#ifdef __clang__
    const char *const compiler = __VERSION__;
#else
    const char *const compiler = "gcc " __VERSION__;
#endif
    bool const is_put =
        put_text(self, "program", version) && put_text(self, "compiler", compiler) &&
        put_text(self, "processor", processor) && put_text(self, "processors", count);
    if (!is_put) app_print_message("bench", "out of memory for the measures");
    return is_put ? APP_EXIT_FINE : APP_EXIT_OUT_OF_MEMORY;
}
