/* validation_report.c - see validation_report.h. */
#include "validation/validation_report.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const verdict_names[] = {"ok", "OFF", "skipped", "-", "open"};
enum { VERDICT_COUNT = sizeof verdict_names / sizeof *verdict_names };

static const char head[] = "experiment,row,measured,unit,expected,verdict,reference,response,"
                           "motion_space,integrator,quick\n";
/* Columns of the head. */
enum {
    EXPERIMENT,
    ROW,
    MEASURED,
    UNIT,
    EXPECTED,
    VERDICT,
    REFERENCE,
    RESPONSE,
    MOTION_SPACE,
    INTEGRATOR,
    QUICK,
    COLUMN_COUNT
};

/* Places of experiments in the list of all. */
static size_t find_place(const char *name) {
    size_t place = 0;
    for (const experiment *const *group = validation_groups; *group; group++)
        for (const experiment *entry = *group; entry->name; entry++, place++)
            if (entry->name == name) return place;
    return place;
}

void validation_sort_table(validation_table *table) {
    for (size_t i = 1; i < table->count; i++) {
        validation_row const row = table->rows[i];
        size_t const place = find_place(row.experiment);
        size_t to = i;
        for (; to > 0 && find_place(table->rows[to - 1].experiment) > place; to--)
            table->rows[to] = table->rows[to - 1];
        table->rows[to] = row;
    }
}

void validation_print_table(const validation_table *table) {
    printf("%-7s  %-62s %12s %-6s %-18s %s\n", "", "", "measured", "", "expected", "after");
    const char *name = "";
    for (size_t i = 0; i < table->count; i++) {
        const validation_row *const row = &table->rows[i];
        if (strcmp(name, row->experiment) != 0) printf("%s\n", row->experiment);
        name = row->experiment;
        if (row->verdict == VERDICT_SKIPPED)
            printf("%-7s  %-62s %s\n", "skipped", row->what, row->reference);
        else
            printf("%-7s  %-62s %12.6g %-6s %-18s %s\n", verdict_names[row->verdict], row->what,
                   row->measured, row->unit, row->expected, row->reference);
    }
}

/* Text between quotes, those inside doubled. */
static void write_quoted(FILE *file, const char *text) {
    fputc('"', file);
    for (; *text; text++) {
        if (*text == '"') fputc('"', file);
        fputc(*text, file);
    }
    fputs("\",", file);
}

static void write_rows(FILE *file, const validation_table *table,
                       const validation_options *options) {
    fputs(head, file);
    for (size_t i = 0; i < table->count; i++) {
        const validation_row *const row = &table->rows[i];
        write_quoted(file, row->experiment);
        write_quoted(file, row->what);
        fprintf(file, "%.15g,", row->measured);
        write_quoted(file, row->unit);
        write_quoted(file, row->expected);
        write_quoted(file, verdict_names[row->verdict]);
        write_quoted(file, row->reference);
        write_quoted(file, options->response);
        write_quoted(file, options->motion_space);
        write_quoted(file, options->integrator);
        fprintf(file, "%d\n", options->is_quick);
    }
}

bool validation_write_csv(const char *path, const validation_table *table,
                          const validation_options *options) {
    char part[4096];
    if (snprintf(part, sizeof part, "%s.part", path) >= (int)sizeof part) {
        errno = ENAMETOOLONG;
        return false;
    }
    FILE *const file = fopen(part, "w");
    if (!file) return false;
    write_rows(file, table, options);
    bool const is_written = !ferror(file);
    return (fclose(file) == 0) && is_written && rename(part, path) == 0;
}

/* Splits a line into its columns, in place; false when it has more or fewer. */
static bool split_line(char *line, char *columns[COLUMN_COUNT]) {
    size_t count = 0;
    while (count < COLUMN_COUNT) {
        bool const is_quoted = *line == '"';
        char *to = columns[count++] = is_quoted ? ++line : line;
        for (; *line; line++) {
            if (is_quoted ? *line == '"' && line[1] != '"' : *line == ',' || *line == '\n') break;
            if (is_quoted && *line == '"') line++;
            *to++ = *line;
        }
        if (is_quoted && *line) line++;
        bool const is_last = *line != ',';
        line++;
        *to = '\0';
        if (is_last) break;
    }
    return count == COLUMN_COUNT;
}

/* The name of an experiment of this program; null if it has none of it. */
static const char *find_experiment(const char *name) {
    if (strcmp(name, validation_all.name) == 0) return validation_all.name;
    for (const experiment *const *group = validation_groups; *group; group++)
        for (const experiment *entry = *group; entry->name; entry++)
            if (strcmp(entry->name, name) == 0) return entry->name;
    return NULL;
}

/* Rows of the totals of one run follow each other, so contacts are known before rescues. A row that
 * was skipped has measured nothing. */
static void add_total(validation_totals *totals, char *const columns[COLUMN_COUNT],
                      double *contacts) {
    if (strcmp(columns[VERDICT], verdict_names[VERDICT_SKIPPED]) == 0) return;
    const char *const what = columns[ROW];
    double const measured = strtod(columns[MEASURED], NULL);
    uint64_t const count = (uint64_t)llround(measured);
    if (strcmp(what, "steps") == 0) totals->steps += count;
    if (strcmp(what, "contacts, summed over steps") == 0) {
        *contacts = measured;
        totals->contacts += count;
    }
    if (strcmp(what, "rescues a contact") == 0)
        totals->rescues += (uint64_t)llround(measured * *contacts);
    if (strcmp(what, "smallest gap over the minimum gap") == 0)
        totals->smallest_gap_share = fmin(totals->smallest_gap_share, measured);
    if (strcmp(what, "states judged") == 0) totals->judged += count;
    if (strcmp(what, "pairs of triangles that cross in them") == 0) totals->crossing += count;
}

static bool is_of_options(char *const columns[COLUMN_COUNT], const validation_options *options) {
    return strcmp(columns[RESPONSE], options->response) == 0 &&
           strcmp(columns[MOTION_SPACE], options->motion_space) == 0 &&
           strcmp(columns[INTEGRATOR], options->integrator) == 0 &&
           (columns[QUICK][0] == '1') == options->is_quick;
}

static void take_row(char *const columns[COLUMN_COUNT], const char *name, validation_table *table) {
    validation_row row = {.experiment = name, .measured = strtod(columns[MEASURED], NULL)};
    snprintf(row.what, sizeof row.what, "%s", columns[ROW]);
    snprintf(row.unit, sizeof row.unit, "%s", columns[UNIT]);
    snprintf(row.expected, sizeof row.expected, "%s", columns[EXPECTED]);
    snprintf(row.reference, sizeof row.reference, "%s", columns[REFERENCE]);
    for (int i = 0; i < VERDICT_COUNT; i++)
        if (strcmp(verdict_names[i], columns[VERDICT]) == 0) row.verdict = (row_verdict)i;
    validation_add_row(table, &row);
}

bool validation_read_csv(const char *path, const validation_options *options,
                         validation_table *table, validation_totals *totals) {
    FILE *const file = fopen(path, "r");
    if (!file && errno == ENOENT) return true;
    const char *problem = file ? NULL : strerror(errno);
    char line[2048], *columns[COLUMN_COUNT];
    double contacts = 0.0;
    unsigned long number = 0;
    while (!problem && fgets(line, sizeof line, file)) {
        number++;
        if (strcmp(line, head) == 0) continue;
        const char *name = NULL;
        if (number == 1 || !split_line(line, columns))
            problem = "no table of this program";
        else if (!is_of_options(columns, options))
            problem = "a row of other options";
        else if (!(name = find_experiment(columns[EXPERIMENT])))
            problem = "an experiment that there is none of";
        else if (name == validation_all.name)
            add_total(totals, columns, &contacts);
        else
            take_row(columns, name, table);
    }
    if (problem) fprintf(stderr, "%s:%lu: %s\n", path, number, problem);
    if (file) fclose(file);
    return !problem;
}
