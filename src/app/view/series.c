/* app/view/series.c - see series.h. */
#include "app/view/series.h"

#include "io/text/number.h"

#include "app/view/document.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct series_column {
    const char *name, *unit;
    double (*get)(const tulle_step_report *report);
} series_column;

#define COLUMN(name, unit, field)                                                                  \
    static double get_##name(const tulle_step_report *report) { return (double)report->field; }
COLUMN(kinetic_energy, "J", kinetic_energy)
COLUMN(gravity_energy, "J", gravity_energy)
COLUMN(elastic_energy, "J", elastic_energy)
COLUMN(contacts, "", contacts)
COLUMN(stick_contacts, "", stick_contacts)
COLUMN(slip_contacts, "", slip_contacts)
COLUMN(cg_iterations, "", cg_iterations)
COLUMN(solves, "", solve_count)
COLUMN(cg_residual, "", cg_residual)
COLUMN(substeps, "", substeps)
COLUMN(smallest_gap, "m", smallest_gap)
COLUMN(max_stretch, "", max_stretch)
COLUMN(tested_pairs, "", tested_pairs)
COLUMN(impact_rounds, "", impact_rounds)
COLUMN(patches, "", patches)
COLUMN(seconds, "s", total_seconds)
#undef COLUMN

static const series_column columns[SERIES_PLAIN] = {{"kinetic_energy", "J", get_kinetic_energy},
                                                    {"gravity_energy", "J", get_gravity_energy},
                                                    {"elastic_energy", "J", get_elastic_energy},
                                                    {"contacts", "", get_contacts},
                                                    {"stick_contacts", "", get_stick_contacts},
                                                    {"slip_contacts", "", get_slip_contacts},
                                                    {"cg_iterations", "", get_cg_iterations},
                                                    {"solves", "", get_solves},
                                                    {"cg_residual", "", get_cg_residual},
                                                    {"substeps", "", get_substeps},
                                                    {"smallest_gap", "m", get_smallest_gap},
                                                    {"max_stretch", "", get_max_stretch},
                                                    {"tested_pairs", "", get_tested_pairs},
                                                    {"impact_rounds", "", get_impact_rounds},
                                                    {"patches", "", get_patches},
                                                    {"seconds", "s", get_seconds}};

enum { NAME_SIZE = 64 };

static void write_name(int column, char name[NAME_SIZE]) {
    if (column < SERIES_PLAIN)
        snprintf(name, NAME_SIZE, "%s", columns[column].name);
    else
        snprintf(name, NAME_SIZE, "seconds_%s", tulle_stage_name(column - SERIES_PLAIN));
    for (char *c = name; *c; c++)
        if (*c == ' ') *c = '_';
}

series_row series_make_row(const tulle_step_report *report) {
    series_row row = {.step = report->step + 1};
    for (int c = 0; c < SERIES_PLAIN; c++) row.values[c] = (float)columns[c].get(report);
    for (int s = 0; s < TULLE_STAGE_COUNT; s++)
        row.values[SERIES_PLAIN + s] = (float)report->stage_seconds[s];
    return row;
}

/* Leaves every second row of the older half. */
static void thin_out(series_table *table) {
    series_row *const rows = table->rows.data;
    size_t const half = table->rows.count / 2, kept = half / 2;
    for (size_t i = 0; i < kept; i++) rows[i] = rows[2 * i];
    memmove(rows + kept, rows + half, (table->rows.count - half) * sizeof *rows);
    table->rows.count -= half - kept;
}

void series_add(series_table *table, const series_row *row, bool is_bounded) {
    while (table->rows.count > 0 && table->rows.data[table->rows.count - 1].step >= row->step)
        table->rows.count--;
    if (is_bounded && table->rows.count >= SERIES_STEP_MAX) thin_out(table);
    if (!ARRAY_RESERVE(&table->heap, &table->rows, 1)) return; /* a plot may have a hole */
    table->rows.data[table->rows.count++] = *row;
}

void series_clear(series_table *table) { ARRAY_FREE(&table->heap, &table->rows); }

int series_find(const char *name) {
    char other[NAME_SIZE];
    for (int c = 0; c < SERIES_COUNT; c++) {
        write_name(c, other);
        if (strcmp(name, other) == 0) return c;
    }
    return SERIES_COUNT;
}

void series_write_names(const view_document *document, view_buffer *buffer) {
    buffer_print(buffer, ",\"series\":[");
    for (int c = 0; c < SERIES_COUNT && document->kind != KIND_MESH; c++) {
        char name[NAME_SIZE];
        write_name(c, name);
        buffer_print(buffer, "%s{\"name\":\"%s\",\"unit\":\"%s\"}", c > 0 ? "," : "", name,
                     c < SERIES_PLAIN ? columns[c].unit : "s");
    }
    buffer_print(buffer, "]");
}

/* The first row with this step or a later one. */
static size_t find_row(const series_table *table, uint64_t step) {
    size_t begin = 0, end = table->rows.count;
    while (begin < end) {
        size_t const middle = begin + (end - begin) / 2;
        if (table->rows.data[middle].step < step)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

/* One bucket's least or greatest value of a column; NAN, written as null, where none is finite. */
static double find_extreme(const series_row *rows, size_t count, int column, bool is_high) {
    double extreme = (double)NAN;
    for (size_t i = 0; i < count; i++) {
        double const value = (double)rows[i].values[column];
        if (!isfinite(value)) continue;
        if (isnan(extreme) || (is_high ? value > extreme : value < extreme)) extreme = value;
    }
    return extreme;
}

/* Rows hold floats, so a value has the digits that give the same float again. */
static void put_value(view_buffer *buffer, double value) {
    char text[NUMBER_TEXT_SIZE];
    if (isfinite(value))
        buffer_put_bytes(buffer, text, number_format_float((float)value, text));
    else
        buffer_print(buffer, "null");
}

void series_write(const series_table *table, series_request request, view_buffer *buffer) {
    size_t const first = find_row(table, request.from);
    size_t const end =
        request.to == UINT64_MAX ? table->rows.count : find_row(table, request.to + 1);
    size_t const count = end > first ? end - first : 0;
    size_t const buckets = count < request.buckets ? count : request.buckets;
    const series_row *const rows = table->rows.data + first;
    char name[NAME_SIZE];
    const char *separator = "";
    buffer_print(buffer, ",\"names\":[");
    for (int c = 0; c < SERIES_COUNT; c++) {
        if (!(request.columns >> c & 1)) continue;
        write_name(c, name);
        buffer_print(buffer, "%s\"%s\"", separator, name);
        separator = ",";
    }
    buffer_print(buffer, "],\"steps\":[");
    for (size_t b = 0; b < buckets; b++)
        buffer_print(buffer, "%s%llu", b > 0 ? "," : "",
                     (unsigned long long)rows[b * count / buckets].step);
    for (int high = 0; high < 2; high++) {
        buffer_print(buffer, high ? "},\"high\":{" : "],\"low\":{");
        separator = "";
        for (int c = 0; c < SERIES_COUNT; c++) {
            if (!(request.columns >> c & 1)) continue;
            write_name(c, name);
            buffer_print(buffer, "%s\"%s\":[", separator, name);
            separator = ",";
            for (size_t b = 0; b < buckets; b++) {
                size_t const begin = b * count / buckets, stop = (b + 1) * count / buckets;
                if (b > 0) buffer_put_u8(buffer, ',');
                put_value(buffer, find_extreme(rows + begin, stop - begin, c, high));
            }
            buffer_put_u8(buffer, ']');
        }
    }
    buffer_put_u8(buffer, '}');
}
