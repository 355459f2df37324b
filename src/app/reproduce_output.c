/* app/reproduce_output.c - what `tulle reproduce` writes: tables that appear whole or not at all,
 * and how far it is. */
#define _POSIX_C_SOURCE 200809L
#include "app/commands.h"
#include "app/reproduce.h"
#include "base/timer.h"

#include "tulle/io.h"

#include <stdarg.h>
#include <stdlib.h>

static const double LINE_INTERVAL = 5.0; /* [s] between two lines of JSON: a log stays readable */

bool reproduce_table_begin(reproduce_table *table) {
    *table = (reproduce_table){0};
    table->stream = open_memstream(&table->bytes, &table->byte_count);
    if (!table->stream) app_print_message("reproduce", "out of memory for a table");
    return table->stream != NULL;
}

int reproduce_table_end(const reproduce *self, reproduce_table *table, const char *file) {
    char path[REPRODUCE_PATH_SIZE];
    reproduce_make_path(self, path, "%s", file);
    tulle_error error = {0};
    int code = APP_EXIT_FINE;
    bool const is_whole = !ferror(table->stream);
    if (fclose(table->stream) != 0 || !is_whole) {
        app_print_message("reproduce", "out of memory for %s", file);
        code = APP_EXIT_OUT_OF_MEMORY;
    } else if (tulle_file_write(path, table->bytes, table->byte_count, &error) != TULLE_OK) {
        code = reproduce_fail(&error);
    }
    free(table->bytes);
    *table = (reproduce_table){0};
    return code;
}

void reproduce_table_discard(reproduce_table *table) {
    if (table->stream) fclose(table->stream);
    free(table->bytes);
    *table = (reproduce_table){0};
}

int reproduce_table_finish(const reproduce *self, reproduce_table *table, const char *file,
                           int code) {
    if (code == APP_EXIT_FINE) return reproduce_table_end(self, table, file);
    reproduce_table_discard(table);
    return code;
}

int reproduce_fail(const tulle_error *error) {
    if (error->status == TULLE_ERROR_INTERRUPTED)
        app_print_message("reproduce", "interrupted; the same command goes on from here");
    else
        app_print_error("reproduce", error);
    return app_exit_for_run(error->status);
}

void reproduce_make_path(const reproduce *self, char path[REPRODUCE_PATH_SIZE], const char *format,
                         ...) {
    int const length = snprintf(path, REPRODUCE_PATH_SIZE, "%s/", self->directory);
    va_list arguments;
    va_start(arguments, format);
    if (length > 0 && length < REPRODUCE_PATH_SIZE)
        vsnprintf(path + length, REPRODUCE_PATH_SIZE - (size_t)length, format, arguments);
    va_end(arguments);
}

/* [s] that the runs still take, this one too; less than 0 where nothing tells it yet. */
static double estimate_runs(const reproduce *self) {
    double const left = self->work - self->work_done;
    if (left <= 0.0) return 0.0;
    if (self->work_done <= 0.0) return -1.0;
    return (timer_now() - self->job_begin) / self->work_done * left;
}

void reproduce_show_job(reproduce *self, const char *name, const char *what) {
    double const rest = estimate_runs(self);
    char text[PROGRESS_DURATION_SIZE];
    if (self->bar.is_terminal) {
        fprintf(stderr, "[%zu/%zu] %s: %s", self->job, self->job_count, name, what);
        if (rest > 0.0)
            fprintf(stderr, "; all runs in about %s", progress_format_duration(rest, text));
        fputc('\n', stderr);
    } else {
        snprintf(text, sizeof text, rest < 0.0 ? "null" : "%.1f", rest);
        fprintf(stderr,
                "{\"event\":\"job\",\"job\":%zu,\"jobs\":%zu,\"run\":\"%s\",\"what\":\"%s\","
                "\"rest_seconds\":%s}\n",
                self->job, self->job_count, name, what, text);
    }
    fflush(stderr);
}

void reproduce_begin_work(reproduce *self) {
    self->bar = progress_bar_begin();
    self->told = timer_now();
    self->skipped = 0;
}

void reproduce_skip_work(reproduce *self) { self->skipped++; }

void reproduce_show_work(reproduce *self, const char *name, uint64_t done, uint64_t count) {
    double const rest =
        progress_bar_estimate_rest(&self->bar, done - self->skipped, count - self->skipped);
    char text[PROGRESS_DURATION_SIZE];
    if (self->bar.is_terminal) {
        progress_bar_show(&self->bar, done, count, "%s  %llu of %llu  rest %s", name,
                          (unsigned long long)done, (unsigned long long)count,
                          progress_format_duration(rest, text));
    } else if (timer_now() - self->told >= LINE_INTERVAL) {
        fprintf(stderr,
                "{\"event\":\"work\",\"work\":\"%s\",\"done\":%llu,\"count\":%llu,"
                "\"rest_seconds\":%.1f}\n",
                name, (unsigned long long)done, (unsigned long long)count, rest);
        fflush(stderr);
        self->told = timer_now();
    }
}

void reproduce_end_work(reproduce *self) { progress_bar_end(&self->bar); }
