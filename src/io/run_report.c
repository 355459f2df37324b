/* io/run_report.c - see run_report.h. The table names each column and where its value is in a
 * tulle_step_report; docs/formats.md says what they mean. */
#include "io/run_report.h"

#include "io/number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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
    {"compute_forces_seconds", COLUMN_DOUBLE, STAGE(0)},
    {"gather_contacts_seconds", COLUMN_DOUBLE, STAGE(1)},
    {"solve_motion_seconds", COLUMN_DOUBLE, STAGE(2)},
    {"propose_paths_seconds", COLUMN_DOUBLE, STAGE(3)},
    {"build_patches_seconds", COLUMN_DOUBLE, STAGE(4)},
    {"build_trees_seconds", COLUMN_DOUBLE, STAGE(5)},
    {"find_pairs_seconds", COLUMN_DOUBLE, STAGE(6)},
    {"test_pairs_seconds", COLUMN_DOUBLE, STAGE(7)},
    {"select_admissible_seconds", COLUMN_DOUBLE, STAGE(8)},
    {"resolve_impacts_seconds", COLUMN_DOUBLE, STAGE(9)},
    {"commit_safely_seconds", COLUMN_DOUBLE, STAGE(10)},
    {"update_contacts_seconds", COLUMN_DOUBLE, STAGE(11)},
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
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0] };
_Static_assert(COLUMN_COUNT *(NUMBER_TEXT_SIZE + 1) < RUN_REPORT_LINE_SIZE, "a line must fit");

size_t run_report_get_column_count(void) { return COLUMN_COUNT; }

const char *run_report_get_column_name(size_t index) {
    return index < COLUMN_COUNT ? columns[index].name : NULL;
}

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
