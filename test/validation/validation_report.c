/* validation_report.c - see validation_report.h. */
#include "validation/validation_report.h"

#include <string.h>

static const char *const verdict_names[] = {"ok", "OFF", "skipped", "-", "open"};

void validation_expectation_text(expectation expected, char text[48]) {
    switch (expected.kind) {
    case EXPECT_AT_MOST: snprintf(text, 48, "<= %.6g", expected.value); break;
    case EXPECT_AT_LEAST: snprintf(text, 48, ">= %.6g", expected.value); break;
    case EXPECT_WITHIN:
        snprintf(text, 48, "%.6g +- %g%%", expected.value, 100.0 * expected.tolerance);
        break;
    case EXPECT_EQUALS: snprintf(text, 48, "%.15g", expected.value); break;
    case EXPECT_NOTHING: snprintf(text, 48, "-"); break;
    }
}

void validation_print_table(const validation_table *table) {
    printf("%-7s  %-62s %12s %-6s %-18s %s\n", "", "", "measured", "", "expected", "after");
    const char *name = "";
    for (size_t i = 0; i < table->count; i++) {
        const validation_row *const row = &table->rows[i];
        if (strcmp(name, row->experiment) != 0) printf("%s\n", row->experiment);
        name = row->experiment;
        char expected[48];
        validation_expectation_text(row->expected, expected);
        if (row->verdict == VERDICT_SKIPPED)
            printf("%-7s  %-62s %s\n", "skipped", row->what, row->reference);
        else
            printf("%-7s  %-62s %12.6g %-6s %-18s %s\n", verdict_names[row->verdict], row->what,
                   row->measured, row->unit, expected, row->reference);
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

void validation_write_csv(FILE *file, const validation_table *table,
                          const validation_options *options) {
    fprintf(file, "experiment,row,measured,unit,expected,verdict,reference,response,motion_space,"
                  "integrator,quick\n");
    for (size_t i = 0; i < table->count; i++) {
        const validation_row *const row = &table->rows[i];
        char expected[48];
        validation_expectation_text(row->expected, expected);
        write_quoted(file, row->experiment);
        write_quoted(file, row->what);
        fprintf(file, "%.9g,", row->measured);
        write_quoted(file, row->unit);
        write_quoted(file, expected);
        write_quoted(file, verdict_names[row->verdict]);
        write_quoted(file, row->reference);
        write_quoted(file, options->response);
        write_quoted(file, options->motion_space);
        write_quoted(file, options->integrator);
        fprintf(file, "%d\n", options->is_quick);
    }
}
