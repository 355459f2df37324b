/* app/bench/csv.c - measures as CSV, a line each; lab/benchmarks.md describes the
 * columns. No field holds a comma, a quote or a line end, so none is quoted. */
#define _POSIX_C_SOURCE 200809L
#include "app/bench/rows.h"
#include "base/error.h"
#include "base/text.h"
#include "io/file_data.h"
#include "io/text/number.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FIELD_COUNT = 8, PATH_SIZE = 4096 };

static const char head[] = "scene,size,threads,kind,name,value,minimum,spread";
static const char *const kind_names[BENCH_KIND_COUNT] = {"about",  "time", "count",
                                                         "memory", "hash", "instructions"};

/* ---- reading ---- */

static bool has_text(bench_kind kind) { return kind == BENCH_ABOUT || kind == BENCH_HASH; }

/* Splits a line at its commas, in place; the number of fields, or one more where there are more. */
static size_t split(char *line, char *fields[FIELD_COUNT]) {
    size_t count = 0;
    for (char *rest = line; rest; count++) {
        if (count == FIELD_COUNT) return FIELD_COUNT + 1;
        fields[count] = rest;
        rest = strchr(rest, ',');
        if (rest) *rest++ = '\0';
    }
    return count;
}

static bool read_number(const char *text, double *value) {
    return number_parse_double(text, strlen(text), value) == NUMBER_READ && *value >= 0.0;
}

static bool read_name(const char *text, size_t size, char *name) {
    if (strlen(text) >= size) return false;
    strcpy(name, text);
    return true;
}

/* What is wrong with a row, or null. */
static const char *read_fields(char *fields[FIELD_COUNT], bench_row *row) {
    *row = (bench_row){0};
    double threads = 0.0;
    if (!read_name(fields[0], sizeof row->scene, row->scene)) return "the scene's name is too long";
    if (!read_name(fields[1], sizeof row->size, row->size)) return "the size's name is too long";
    if (fields[2][0] && (!read_number(fields[2], &threads) || threads > 1e6))
        return "\"threads\" should be a number, or empty";
    row->threads = (int)threads;
    while (row->kind < BENCH_KIND_COUNT && strcmp(kind_names[row->kind], fields[3]) != 0)
        row->kind = (bench_kind)(row->kind + 1);
    if (row->kind == BENCH_KIND_COUNT)
        return "\"kind\" should be about, time, count, memory, hash or instructions";
    if (!fields[4][0] || !read_name(fields[4], sizeof row->name, row->name))
        return "\"name\" is empty or too long";
    if (has_text(row->kind))
        return read_name(fields[5], sizeof row->text, row->text) ? NULL : "the text is too long";
    if (!read_number(fields[5], &row->value)) return "\"value\" should be a number of 0 or more";
    if (row->kind == BENCH_TIME &&
        (!read_number(fields[6], &row->minimum) || !read_number(fields[7], &row->spread)))
        return "\"minimum\" and \"spread\" of a time should be numbers of 0 or more";
    return NULL;
}

static tulle_status read_line(const char *path, int line, char *text, bench_rows *rows,
                              tulle_error *error) {
    char *fields[FIELD_COUNT];
    bench_row row;
    if (line == 1) {
        if (strcmp(text, head) == 0) return TULLE_OK;
        return error_set_at(error, TULLE_ERROR_PARSE, path, line, 0,
                            "is no table of `tulle bench`: the first line should be %s", head);
    }
    size_t const count = split(text, fields);
    if (count != FIELD_COUNT)
        return error_set_at(error, TULLE_ERROR_PARSE, path, line, 0,
                            "has %s fields than the %d that it should have",
                            count < FIELD_COUNT ? "fewer" : "more", FIELD_COUNT);
    const char *const fault = read_fields(fields, &row);
    if (fault) return error_set_at(error, TULLE_ERROR_PARSE, path, line, 0, "%s", fault);
    if (!bench_rows_put(rows, &row))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the measures");
    return TULLE_OK;
}

tulle_status bench_csv_read(const char *path, bench_rows *rows, tulle_error *error) {
    memory heap = memory_default();
    file_data data;
    tulle_status status = file_load(&heap, path, 0, &data, error);
    if (status != TULLE_OK) return status;
    char *rest = data.bytes;
    int line = 0;
    while (status == TULLE_OK && (line == 0 || rest < data.bytes + data.byte_count)) {
        char *const end = strchr(rest, '\n');
        if (end) {
            *end = '\0';
            text_hide_controls(rest); /* names of it are shown */
            status = read_line(path, ++line, rest, rows, error);
            rest = end + 1;
        } else {
            status = error_set_at(error, TULLE_ERROR_PARSE, path, line + 1, 0,
                                  "the last line is cut off");
        }
    }
    file_release(&heap, &data);
    return status;
}

/* ---- writing ---- */

static void write_row(const bench_row *row, FILE *file) {
    fprintf(file, "%s,%s,", row->scene, row->size);
    if (row->threads > 0) fprintf(file, "%d", row->threads);
    fprintf(file, ",%s,%s,", kind_names[row->kind], row->name);
    if (has_text(row->kind))
        fprintf(file, "%s,,\n", row->text);
    else if (row->kind == BENCH_TIME)
        fprintf(file, "%.6g,%.6g,%.3g\n", row->value, row->minimum, row->spread);
    else
        fprintf(file, "%.0f,,\n", row->value);
}

static tulle_status open_beside(const char *path, char beside[PATH_SIZE], FILE **file,
                                tulle_error *error) {
    struct stat facts;
    if (stat(path, &facts) == 0 && !S_ISREG(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0,
                            "cannot be written: is there and no file");
    if (snprintf(beside, PATH_SIZE, "%s.%ld.tmp", path, (long)getpid()) >= PATH_SIZE)
        return error_set(error, TULLE_ERROR_IO, "the name of the CSV file is too long");
    *file = fopen(beside, "w");
    return *file ? TULLE_OK : file_fail(error, path, errno, "cannot be written");
}

tulle_status bench_csv_check(const char *path, tulle_error *error) {
    char beside[PATH_SIZE];
    FILE *file = NULL;
    tulle_status const status = open_beside(path, beside, &file, error);
    if (status != TULLE_OK) return status;
    fclose(file);
    unlink(beside);
    return TULLE_OK;
}

tulle_status bench_csv_write(const char *path, const bench_rows *rows, tulle_error *error) {
    char beside[PATH_SIZE];
    FILE *file = NULL;
    tulle_status const status = open_beside(path, beside, &file, error);
    if (status != TULLE_OK) return status;
    fprintf(file, "%s\n", head);
    for (size_t i = 0; i < rows->count; i++) write_row(&rows->items[i], file);
    int code = fflush(file) != 0 || ferror(file) ? errno : 0;
    if (fclose(file) != 0 && !code) code = errno;
    if (!code) code = file_rename(beside, path);
    if (!code) return TULLE_OK;
    unlink(beside);
    return file_fail(error, path, code, "cannot be written");
}
