/* io/run/run_report.c - see run_report.h. The table names each column and where its value is in a
 * tulle_step_report; docs/guide/run_directory.md says what they mean. */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_report.h"

#include "io/file_data.h"
#include "io/text/number.h"
#include "io/text/text_cursor.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

typedef enum column_kind { COLUMN_DOUBLE, COLUMN_U64, COLUMN_U32, COLUMN_INT } column_kind;

typedef struct column {
    const char *name;
    column_kind kind;
    size_t offset;
} column;

#define FIELD(field) offsetof(tulle_step_report, field)
#define STAGE(index) (offsetof(tulle_step_report, stage_seconds) + (index) * sizeof(double))

static const column columns[] = {
    {"step", COLUMN_U64, FIELD(step)},
    {"time", COLUMN_DOUBLE, FIELD(time)},
    {"total_seconds", COLUMN_DOUBLE, FIELD(total_seconds)},
    {"predict_paths_seconds", COLUMN_DOUBLE, STAGE(0)},
    {"update_patches_seconds", COLUMN_DOUBLE, STAGE(1)},
    {"build_trees_seconds", COLUMN_DOUBLE, STAGE(2)},
    {"find_pairs_seconds", COLUMN_DOUBLE, STAGE(3)},
    {"gather_rows_seconds", COLUMN_DOUBLE, STAGE(4)},
    {"compute_forces_seconds", COLUMN_DOUBLE, STAGE(5)},
    {"solve_motion_seconds", COLUMN_DOUBLE, STAGE(6)},
    {"resolve_impacts_seconds", COLUMN_DOUBLE, STAGE(7)},
    {"commit_safely_seconds", COLUMN_DOUBLE, STAGE(8)},
    {"accept_state_seconds", COLUMN_DOUBLE, STAGE(9)},
    {"solve_count", COLUMN_U32, FIELD(solve_count)},
    {"cg_iterations", COLUMN_U32, FIELD(cg_iterations)},
    {"cg_residual", COLUMN_DOUBLE, FIELD(cg_residual)},
    {"cg_converged", COLUMN_INT, FIELD(cg_converged)},
    {"box_pairs", COLUMN_U64, FIELD(box_pairs)},
    {"tested_pairs", COLUMN_U64, FIELD(tested_pairs)},
    {"contacts", COLUMN_U64, FIELD(contacts)},
    {"new_contacts", COLUMN_U64, FIELD(new_contacts)},
    {"stick_contacts", COLUMN_U64, FIELD(stick_contacts)},
    {"slip_contacts", COLUMN_U64, FIELD(slip_contacts)},
    {"hard_contacts", COLUMN_U64, FIELD(hard_contacts)},
    {"impact_rounds", COLUMN_U32, FIELD(impact_rounds)},
    {"rescue_impact_zones", COLUMN_U64, FIELD(rescue_impact_zones)},
    {"rescue_component_scalings", COLUMN_U64, FIELD(rescue_component_scalings)},
    {"rescue_global_scalings", COLUMN_U64, FIELD(rescue_global_scalings)},
    {"substeps", COLUMN_U32, FIELD(substeps)},
    {"ignored_pairs", COLUMN_U64, FIELD(ignored_pairs)},
    {"smallest_gap", COLUMN_DOUBLE, FIELD(smallest_gap)},
    {"kinetic_energy", COLUMN_DOUBLE, FIELD(kinetic_energy)},
    {"gravity_energy", COLUMN_DOUBLE, FIELD(gravity_energy)},
    {"elastic_energy", COLUMN_DOUBLE, FIELD(elastic_energy)},
    {"max_stretch", COLUMN_DOUBLE, FIELD(max_stretch)},
    {"pinched", COLUMN_INT, FIELD(pinched)},
    {"pair_searches", COLUMN_U32, FIELD(pair_searches)},
    {"patches", COLUMN_U64, FIELD(patches)},
    {"patch_triangles", COLUMN_U64, FIELD(patch_triangles)},
    {"patches_certified", COLUMN_U64, FIELD(patches_certified)},
    {"patches_dissolved", COLUMN_U64, FIELD(patches_dissolved)},
    {"turning_pairs", COLUMN_U64, FIELD(turning_pairs)},
    {"overstretched", COLUMN_U64, FIELD(overstretched)},
    {"largest_lag", COLUMN_DOUBLE, FIELD(largest_lag)},
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0] };

_Static_assert(COLUMN_COUNT *(NUMBER_TEXT_SIZE + 1) < RUN_REPORT_LINE_SIZE, "a line must fit");

size_t run_report_format_heading(char text[RUN_REPORT_LINE_SIZE]) {
    size_t length = 0;
    for (size_t i = 0; i < COLUMN_COUNT; i++)
        length += (size_t)snprintf(text + length, RUN_REPORT_LINE_SIZE - length, "%s%s",
                                   i ? "," : "", columns[i].name);
    memcpy(text + length, "\n", 2);
    return length + 1;
}

static size_t format_field(const column *described, const char *field,
                           char text[NUMBER_TEXT_SIZE]) {
    double real;
    uint64_t large;
    uint32_t small;
    int integer;
    switch (described->kind) {
    case COLUMN_DOUBLE:
        memcpy(&real, field, sizeof real);
        return isfinite(real) ? number_format_double(real, text) : 0;
    case COLUMN_U64:
        memcpy(&large, field, sizeof large);
        return (size_t)snprintf(text, NUMBER_TEXT_SIZE, "%llu", (unsigned long long)large);
    case COLUMN_U32:
        memcpy(&small, field, sizeof small);
        return (size_t)snprintf(text, NUMBER_TEXT_SIZE, "%u", small);
    case COLUMN_INT:
        memcpy(&integer, field, sizeof integer);
        return (size_t)snprintf(text, NUMBER_TEXT_SIZE, "%d", integer);
    }
    return 0;
}

size_t run_report_format(const tulle_step_report *report, char text[RUN_REPORT_LINE_SIZE]) {
    size_t length = 0;
    for (size_t i = 0; i < COLUMN_COUNT; i++) {
        if (i > 0) text[length++] = ',';
        char field[NUMBER_TEXT_SIZE];
        size_t const size =
            format_field(&columns[i], (const char *)report + columns[i].offset, field);
        memcpy(text + length, field, size);
        length += size;
    }
    memcpy(text + length, "\n", 2);
    return length + 1;
}

/* ---- reading ---- */

static bool parse_field(const column *described, text_word word, char *field) {
    if (described->kind == COLUMN_DOUBLE) {
        double real = described->offset == FIELD(smallest_gap) ? INFINITY : NAN;
        if (word.length > 0 && number_parse_double(word.text, word.length, &real) != NUMBER_READ)
            return false;
        memcpy(field, &real, sizeof real);
        return true;
    }
    int64_t whole = 0;
    if (number_parse_integer(word.text, word.length, &whole) != NUMBER_READ || whole < 0)
        return false;
    if (described->kind == COLUMN_U64) {
        memcpy(field, &(uint64_t){(uint64_t)whole}, sizeof(uint64_t));
        return true;
    }
    if (whole > (described->kind == COLUMN_INT ? INT32_MAX : (int64_t)UINT32_MAX)) return false;
    memcpy(field, &(uint32_t){(uint32_t)whole}, sizeof(uint32_t)); /* int: the same bits */
    return true;
}

static tulle_status parse_line(text_cursor *text, const char *line_end, tulle_step_report *report,
                               tulle_error *error) {
    *report = (tulle_step_report){0};
    const char *at = text->at;
    for (size_t i = 0; i < COLUMN_COUNT; i++) {
        const column *const described = &columns[i];
        const char *const comma = memchr(at, ',', (size_t)(line_end - at));
        if ((i + 1 == COLUMN_COUNT) != !comma)
            return text_fail(text, at, error, "the line should have %d columns", COLUMN_COUNT);
        text_word const word = {at, (size_t)((comma ? comma : line_end) - at)};
        if (!parse_field(described, word, (char *)report + described->offset))
            return text_fail(text, at, error, "column %s should hold a %s", described->name,
                             described->kind == COLUMN_DOUBLE ? "number" : "whole number");
        if (comma) at = comma + 1;
    }
    return TULLE_OK;
}

static tulle_status parse_lines(memory *heap, text_cursor *text, run_report_rows *rows,
                                tulle_error *error) {
    const char *const heading_end = memchr(text->at, '\n', (size_t)(text->end - text->at));
    if (!heading_end) return TULLE_OK;
    char heading[RUN_REPORT_LINE_SIZE];
    size_t const size = run_report_format_heading(heading);
    if ((size_t)(heading_end + 1 - text->at) != size || memcmp(text->at, heading, size) != 0)
        return text_fail(text, NULL, error,
                         "the heading names other columns than this version of Tulle, which reads "
                         "no reports of others");
    text_next_line(text);
    while (text->at < text->end) {
        const char *const line_end = memchr(text->at, '\n', (size_t)(text->end - text->at));
        if (!line_end) break; /* killed while it was written */
        if (!ARRAY_RESERVE(heap, rows, 1)) return file_fail_memory(error, text->path);
        tulle_status const status = parse_line(text, line_end, &rows->data[rows->count], error);
        if (status) return status;
        rows->count++;
        text_next_line(text);
    }
    return TULLE_OK;
}

tulle_status run_report_read(memory *heap, const char *path, run_report_rows *rows,
                             tulle_error *error) {
    if (access(path, F_OK) != 0) return TULLE_OK;
    file_data data;
    tulle_status status = file_load(heap, path, 0, &data, error);
    if (status) return status;
    text_cursor text = text_cursor_make(path, data.bytes, data.byte_count);
    status = parse_lines(heap, &text, rows, error);
    file_release(heap, &data);
    return status;
}
