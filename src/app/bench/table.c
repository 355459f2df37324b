/* app/bench/table.c - prints measures as Markdown tables: what each stage of a step takes, and what
 * a step does. */
#include "app/bench/bench.h"

#include <stdlib.h>
#include <string.h>

enum { CELL_SIZE = 48, COLUMN_COUNT = 16, LINE_COUNT = 512 };

/* Cells of a table, filled line by line; widths are those of the widest cells. */
typedef struct text_table {
    char cells[LINE_COUNT][COLUMN_COUNT][CELL_SIZE];
    size_t line_count, column_count;
} text_table;

static void print_table(const text_table *table, FILE *stream) {
    int widths[COLUMN_COUNT] = {0};
    for (size_t i = 0; i < table->line_count; i++)
        for (size_t k = 0; k < table->column_count; k++)
            if ((int)strlen(table->cells[i][k]) > widths[k])
                widths[k] = (int)strlen(table->cells[i][k]);
    for (size_t i = 0; i < table->line_count; i++) {
        for (size_t k = 0; k < table->column_count; k++)
            fprintf(stream, k < 2 ? "| %-*s " : "| %*s ", widths[k], table->cells[i][k]);
        fputs("|\n", stream);
        for (size_t k = 0; i == 0 && k < table->column_count; k++)
            fputs(k < 2 ? "|---" : "|---:", stream);
        if (i == 0) fputs("|\n", stream);
    }
}

/* ---- times ---- */

/* Columns of the first table after scene, size and threads; [ms]. */
static const struct {
    const char *title;
    const char *stage;
} time_columns[] = {
    {"step", "step"},
    {"processor", "processor"},
    {"predict", "predict_paths"},
    {"patches", "update_patches"},
    {"trees", "build_trees"},
    {"pairs", "find_pairs"},
    {"rows", "gather_rows"},
    {"forces", "compute_forces"},
    {"solve", "solve_motion"},
    {"impacts", "resolve_impacts"},
    {"commit", "commit_safely"},
    {"accept", "accept_state"},
};
enum { TIME_COLUMN_COUNT = sizeof time_columns / sizeof time_columns[0] };

static void format_milliseconds(double seconds, char text[CELL_SIZE]) {
    double const value = 1e3 * seconds;
    snprintf(text, CELL_SIZE, value >= 99.95 ? "%.0f" : value >= 9.995 ? "%.1f" : "%.2f", value);
}

static void fill_case(char cells[][CELL_SIZE], const bench_row *of) {
    snprintf(cells[0], CELL_SIZE, "%s", of->scene);
    snprintf(cells[1], CELL_SIZE, "%s", of->size);
    snprintf(cells[2], CELL_SIZE, "%d", of->threads);
}

static void fill_times(text_table *table, const bench_rows *rows, const bench_row *step) {
    char(*const cells)[CELL_SIZE] = table->cells[table->line_count];
    fill_case(cells, step);
    for (size_t k = 0; k < TIME_COLUMN_COUNT; k++) {
        const bench_row *const row =
            bench_rows_find_beside(rows, step, BENCH_TIME, time_columns[k].stage);
        if (row)
            format_milliseconds(row->value, cells[3 + k]);
        else
            snprintf(cells[3 + k], CELL_SIZE, "-");
    }
    char median[CELL_SIZE / 3], least[CELL_SIZE], spread[CELL_SIZE];
    format_milliseconds(step->minimum, least);
    format_milliseconds(step->spread, spread);
    snprintf(median, sizeof median, "%.15s", cells[3]);
    snprintf(cells[3], CELL_SIZE, "%s (%.12s, %.12s)", median, least, spread);
    table->line_count++;
}

static void print_times(const bench_rows *rows, text_table *table, FILE *stream) {
    static const char *const first[3] = {"scene", "size", "threads"};
    *table = (text_table){.line_count = 1, .column_count = 3 + TIME_COLUMN_COUNT};
    for (size_t k = 0; k < table->column_count; k++)
        snprintf(table->cells[0][k], CELL_SIZE, "%s", k < 3 ? first[k] : time_columns[k - 3].title);
    strcpy(table->cells[0][3], "step (least, spread)");
    for (size_t i = 0; i < rows->count && table->line_count < LINE_COUNT; i++)
        if (rows->items[i].kind == BENCH_TIME && strcmp(rows->items[i].name, "step") == 0)
            fill_times(table, rows, &rows->items[i]);
    if (table->line_count == 1) return;
    fputs("Medians of a step [ms]:\n\n", stream);
    print_table(table, stream);
}

/* ---- counts ---- */

/* Columns of the second table after scene and size. */
static const struct {
    const char *title;
    bench_kind kind;
    bool is_a_step; /* sums over the steps are divided by their number */
    double unit;
    const char *names[3]; /* that are added */
} count_columns[] = {
    {"particles", BENCH_COUNT, false, 1.0, {"particles"}},
    {"triangles", BENCH_COUNT, false, 1.0, {"cloth_triangles"}},
    {"of obstacles", BENCH_COUNT, false, 1.0, {"obstacle_triangles"}},
    {"contacts", BENCH_COUNT, true, 1.0, {"contacts"}},
    {"candidates", BENCH_COUNT, true, 1.0, {"box_pairs"}},
    {"tested", BENCH_COUNT, true, 1.0, {"tested_pairs"}},
    {"searches", BENCH_COUNT, true, 1.0, {"pair_searches"}},
    {"solves", BENCH_COUNT, true, 1.0, {"solve_count"}},
    {"iterations", BENCH_COUNT, true, 1.0, {"cg_iterations"}},
    {"substeps", BENCH_COUNT, true, 1.0, {"substeps"}},
    {"rescues",
     BENCH_COUNT,
     true,
     1.0,
     {"rescue_impact_zones", "rescue_component_scalings", "rescue_global_scalings"}},
    {"allocations", BENCH_MEMORY, true, 1.0, {"allocator_calls"}},
    {"MB", BENCH_MEMORY, false, 1e-6, {"most_bytes"}},
    {"M instructions", BENCH_INSTRUCTIONS, true, 1e-6, {"steps"}},
};
enum { COUNT_COLUMN_COUNT = sizeof count_columns / sizeof count_columns[0] };

static void fill_counts(text_table *table, const bench_rows *rows, const bench_row *steps) {
    char(*const cells)[CELL_SIZE] = table->cells[table->line_count];
    fill_case(cells, steps);
    for (size_t k = 0; k < COUNT_COLUMN_COUNT; k++) {
        double sum = 0.0;
        bool is_known = false;
        for (size_t i = 0; i < 3 && count_columns[k].names[i]; i++) {
            const bench_row *const row = bench_rows_find_beside(rows, steps, count_columns[k].kind,
                                                                count_columns[k].names[i]);
            is_known |= row != NULL;
            if (row) sum += row->value * count_columns[k].unit;
        }
        bool const is_mean = count_columns[k].is_a_step && steps->value > 0.0;
        double const value = is_mean ? sum / steps->value : sum;
        bool const has_decimals = (is_mean || count_columns[k].unit < 1.0) && value < 999.95;
        if (is_known)
            snprintf(cells[2 + k], CELL_SIZE, has_decimals ? "%.1f" : "%.0f", value);
        else
            strcpy(cells[2 + k], "");
    }
    table->line_count++;
}

/* One line a scene and size: counts do not depend on threads. */
static void print_counts(const bench_rows *rows, text_table *table, FILE *stream) {
    *table = (text_table){.line_count = 1, .column_count = 2 + COUNT_COLUMN_COUNT};
    strcpy(table->cells[0][0], "scene");
    strcpy(table->cells[0][1], "size");
    for (size_t k = 0; k < COUNT_COLUMN_COUNT; k++)
        strcpy(table->cells[0][2 + k], count_columns[k].title);
    const bench_row *last = NULL;
    for (size_t i = 0; i < rows->count && table->line_count < LINE_COUNT; i++) {
        const bench_row *const row = &rows->items[i];
        if (row->kind != BENCH_COUNT || strcmp(row->name, "steps") != 0) continue;
        bool const is_again =
            last && strcmp(last->scene, row->scene) == 0 && strcmp(last->size, row->size) == 0;
        if (!is_again) fill_counts(table, rows, row);
        last = row;
    }
    if (table->line_count == 1) return;
    fputs("\nCounts, means of a step:\n\n", stream);
    print_table(table, stream);
}

void bench_print_tables(const bench_rows *rows, FILE *stream) {
    text_table *const table = malloc(sizeof *table);
    if (!table) return;
    print_times(rows, table, stream);
    print_counts(rows, table, stream);
    free(table);
}
