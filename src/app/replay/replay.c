/* app/replay/replay.c - `tulle replay`: repeats the recorded calls of a host, and tells the first
 * that comes to something else. */
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/cli/progress_bar.h"
#include "app/commands.h"
#include "base/error.h"
#include "io/file_data.h"

#include <limits.h>
#include <stdbool.h>
#include <stdio.h>

static const char command_name[] = "replay";
enum { THREAD_MAX = 256 };

typedef struct replay_session {
    const char *path;
    long threads, until; /* 0: as recorded; LONG_MAX: to the end */
    progress_bar bar;
    size_t byte_count;
    double time;     /* [s] of the world */
    uint64_t failed; /* calls that ran and failed as they were recorded */
    bool is_interrupted;
} replay_session;

static int observe(void *context, const tulle_world *world, const tulle_replay_report *report) {
    replay_session *const self = context;
    self->time = tulle_world_get_time(world);
    self->failed += report->status != TULLE_OK && !report->is_different;
    progress_bar_show(&self->bar, report->offset, self->byte_count, "step %llu, %.3f s",
                      (unsigned long long)report->steps, self->time);
    self->is_interrupted = interrupt_is_pending();
    return self->is_interrupted || report->steps >= (uint64_t)self->until;
}

static void print_difference(const tulle_replay_report *report) {
    app_print_names(stdout, "%s, call %llu, step %llu, byte %zu of the recording: ", report->call,
                    (unsigned long long)report->calls, (unsigned long long)report->steps,
                    report->offset);
    if (report->status != report->recorded_status)
        app_print_names(stdout, "recorded as \"%s\", now \"%s\"%s%s\n",
                        tulle_status_text(report->recorded_status),
                        tulle_status_text(report->status), report->message[0] ? ": " : "",
                        report->message);
    else
        app_print_names(stdout, "the state has hash %016llx, recorded was %016llx\n",
                        (unsigned long long)report->hash,
                        (unsigned long long)report->recorded_hash);
    app_print_names(stdout, "recorded by tulle %s, repeated by tulle %s\n", report->version,
                    tulle_version());
}

/* What the replay came to; the exit code. */
static int print_outcome(const replay_session *self, const tulle_replay_report *report) {
    if (report->is_different) {
        print_difference(report);
        return APP_EXIT_FALSE;
    }
    printf("%llu calls, %llu steps to %.6g s: the same states, the last %016llx\n",
           (unsigned long long)report->calls, (unsigned long long)report->steps, self->time,
           (unsigned long long)report->hash);
    if (self->failed > 0)
        printf("%llu of these calls failed as they did then\n", (unsigned long long)self->failed);
    if (report->status != TULLE_OK)
        app_print_names(stdout, "the last, %s: %s\n", report->call, report->message);
    if (!report->is_whole && report->steps < (uint64_t)self->until)
        printf("the recording is cut off behind call %llu, %s: its host ended without ending it\n",
               (unsigned long long)report->calls, report->call ? report->call : "none");
    return APP_EXIT_FINE;
}

static int repeat(replay_session *self) {
    memory heap = memory_default();
    file_data file;
    tulle_error error = {0};
    tulle_status status = file_load(&heap, self->path, 0, &file, &error);
    if (status != TULLE_OK) {
        app_print_error(command_name, &error);
        return app_exit_for_input(status);
    }
    self->byte_count = file.byte_count;
    self->bar = progress_bar_begin();
    tulle_replay_options const options = {(int)self->threads, observe, self};
    tulle_replay_report report;
    status = tulle_replay(file.bytes, file.byte_count, &options, &report, &error);
    progress_bar_clear(&self->bar);
    file_release(&heap, &file);
    if (status != TULLE_OK) {
        tulle_error const found = error;
        error_set_at(&error, status, self->path, 0, 0,
                     "%.1500s; %llu calls before it were repeated", found.message,
                     (unsigned long long)report.calls);
        app_print_error(command_name, &error);
        return app_exit_for_input(status);
    }
    int const code = print_outcome(self, &report);
    int const written = app_finish_output(command_name);
    if (written != APP_EXIT_FINE) return written;
    return self->is_interrupted ? APP_EXIT_INTERRUPTED : code;
}

int app_replay(int argc, char **argv) {
    replay_session session = {.until = LONG_MAX};
    const option_spec options[] = {
        INTEGER_OPTION("until", 'n', &session.until, "STEP", 1, LONG_MAX,
                       "end after so many steps (default: the end of the recording)"),
        INTEGER_OPTION("threads", 't', &session.threads, "N", 1, THREAD_MAX,
                       "threads; the result does not depend on it (default: as recorded)"),
    };
    const command_spec command =
        COMMAND(command_name, "FILE", options, 1, 1,
                "Repeats the calls of a host, bit for bit, from a file that tulle_world_record "
                "wrote, and\nnames the first call with another status or another state. Exit code "
                "0: there is none,\n1: there is one, 2: the file is not a recording, or is "
                "damaged. A recording that is cut\noff is repeated up to its end.");
    size_t operand_count = 0;
    options_outcome const outcome = options_parse(&command, argc, argv, &operand_count);
    if (outcome != OPTIONS_READ) return options_exit(outcome);
    session.path = argv[0];
    interrupt_catch();
    return repeat(&session);
}
