/* io/run/run_outcome.c - how the steps of a run went: sums over their reports, the member "outcome"
 * of run.json, and the same in words. */
#include "io/run/run_record.h"
#include "io/run/run_writer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Beyond this length over rest length cloth looks wrong: woven cloth stretches by a few percent. */
static const double NOTABLE_STRETCH = 1.15;
/* Less is rounding, of cloth that nothing pulls at. */
static const double LEAST_STRETCH = 1.0001;

void tulle_run_outcome_add(tulle_run_outcome *outcome, const tulle_step_report *report) {
    if (!outcome || !report) return;
    outcome->steps++;
    if (report->cg_converged == 0) {
        outcome->unconverged_steps++;
        if (report->cg_residual > outcome->worst_residual && isfinite(report->cg_residual)) {
            outcome->worst_residual = report->cg_residual;
            outcome->worst_residual_time = report->time;
        }
    }
    if (report->max_stretch > outcome->largest_stretch && isfinite(report->max_stretch)) {
        outcome->largest_stretch = report->max_stretch;
        outcome->largest_stretch_time = report->time;
        outcome->has_stretch_place = 0;
    }
    outcome->cut_steps += report->substeps > 1;
    if (report->substeps > outcome->most_substeps) outcome->most_substeps = report->substeps;
    outcome->rescues += report->rescue_impact_zones + report->rescue_component_scalings +
                        report->rescue_global_scalings;
    outcome->pinched_steps += report->pinched != 0;
    outcome->overstretched_steps += report->overstretched > 0;
    if (report->overstretched > outcome->most_overstretched)
        outcome->most_overstretched = report->overstretched;
    if (report->largest_lag > outcome->largest_lag && isfinite(report->largest_lag)) {
        outcome->largest_lag = report->largest_lag;
        outcome->largest_lag_time = report->time;
    }
}

void tulle_run_outcome_place(tulle_run_outcome *outcome, const tulle_stretch *stretch,
                             uint32_t body) {
    if (!outcome || !stretch) return;
    outcome->has_stretch_place = 1;
    outcome->stretch_body = body;
    memcpy(outcome->stretch_vertices, stretch->vertices, sizeof outcome->stretch_vertices);
    memcpy(outcome->stretch_position, stretch->position, sizeof outcome->stretch_position);
}

void tulle_run_set_outcome(tulle_run_writer *writer, const tulle_run_outcome *outcome) {
    if (!writer || !outcome) return;
    writer->record.has_outcome = true;
    writer->record.outcome = *outcome;
}

/* ---- in words ---- */

typedef struct outcome_text {
    char *text;
    size_t size, length;
    int lines;
} outcome_text;

__attribute__((format(printf, 2, 3))) static void add(outcome_text *into, const char *format, ...) {
    if (into->length >= into->size) return;
    va_list arguments;
    va_start(arguments, format);
    into->length +=
        (size_t)vsnprintf(into->text + into->length, into->size - into->length, format, arguments);
    va_end(arguments);
}

static void begin_line(outcome_text *into) {
    if (into->lines++ > 0) add(into, "\n");
}

/* "42 % at 0.5 s, between vertices 88 and 89 of 'sheet', at (0.1, 0.2, 0.3)" */
static void add_stretch(outcome_text *into, const tulle_run_outcome *outcome,
                        const char *body_name) {
    const double *const x = outcome->stretch_position;
    add(into, "%.3g %% at %.6g s", 100.0 * (outcome->largest_stretch - 1.0),
        outcome->largest_stretch_time);
    if (outcome->has_stretch_place)
        add(into, ", between vertices %u and %u of '%s', at (%.4g, %.4g, %.4g)",
            outcome->stretch_vertices[0], outcome->stretch_vertices[1], body_name ? body_name : "",
            x[0], x[1], x[2]);
}

void tulle_run_outcome_describe(const tulle_run_outcome *outcome, const char *body_name,
                                const char *failure, char *text, size_t size) {
    outcome_text into = {.text = text, .size = size};
    if (!text || size == 0) return;
    text[0] = '\0';
    if (!outcome) return;
    unsigned long long const steps = outcome->steps;
    if (failure) {
        begin_line(&into);
        add(&into, "the run failed: %s", failure);
    }
    if (outcome->unconverged_steps > 0) {
        begin_line(&into);
        add(&into, "a solve did not converge in %llu of %llu steps",
            (unsigned long long)outcome->unconverged_steps, steps);
        if (outcome->worst_residual > 0.0) /* else none was finite */
            add(&into, "; the largest residual was %.3g at %.6g s", outcome->worst_residual,
                outcome->worst_residual_time);
    }
    if (outcome->largest_stretch > NOTABLE_STRETCH) {
        begin_line(&into);
        add(&into, "cloth was stretched by ");
        add_stretch(&into, outcome, body_name);
    }
    if (outcome->overstretched_steps > 0) {
        begin_line(&into);
        add(&into, "cloth was stretched beyond what its material holds in %llu of %llu steps",
            (unsigned long long)outcome->overstretched_steps, steps);
        add(&into, "; at %llu triangles at most", (unsigned long long)outcome->most_overstretched);
        if (!(outcome->largest_stretch > NOTABLE_STRETCH)) {
            add(&into, ", by ");
            add_stretch(&into, outcome, body_name);
        }
    }
    if (outcome->cut_steps > 0) {
        begin_line(&into);
        add(&into, "%llu of %llu steps %s cut, into %u substeps at most",
            (unsigned long long)outcome->cut_steps, steps, outcome->cut_steps == 1 ? "was" : "were",
            outcome->most_substeps);
    }
    if (outcome->rescues > 0) {
        begin_line(&into);
        add(&into, "impacts needed %llu rescues", (unsigned long long)outcome->rescues);
    }
    if (outcome->pinched_steps > 0) {
        begin_line(&into);
        add(&into, "cloth was pinched between obstacles in %llu of %llu steps",
            (unsigned long long)outcome->pinched_steps, steps);
        if (outcome->largest_lag > 0.0)
            add(&into, "; obstacles lagged behind their path there, by %.3g mm at most at %.6g s",
                1000.0 * outcome->largest_lag, outcome->largest_lag_time);
    }
    if (into.lines > 0) return;
    add(&into, "none: every solve converged, no step was cut, nothing was rescued or pinched");
    if (outcome->largest_stretch > LEAST_STRETCH) {
        add(&into, "; cloth was stretched by at most ");
        add_stretch(&into, outcome, body_name);
    }
}

/* ---- to and from run.json ---- */

#define AT(kind, name)                                                                             \
    { #name, JSON_##kind, offsetof(tulle_run_outcome, name) }
static const json_field members[] = {AT(COUNT, steps),
                                     AT(COUNT, unconverged_steps),
                                     AT(DOUBLE, worst_residual),
                                     AT(DOUBLE, worst_residual_time),
                                     AT(COUNT, cut_steps),
                                     AT(WHOLE, most_substeps),
                                     AT(COUNT, rescues),
                                     AT(COUNT, pinched_steps),
                                     AT(COUNT, overstretched_steps),
                                     AT(COUNT, most_overstretched),
                                     AT(DOUBLE, largest_lag),
                                     AT(DOUBLE, largest_lag_time),
                                     AT(DOUBLE, largest_stretch),
                                     AT(DOUBLE, largest_stretch_time)};
enum { MEMBERS = sizeof members / sizeof members[0] };

void run_outcome_write(json_writer *writer, const run_record *record) {
    const tulle_run_outcome *const outcome = &record->outcome;
    if (!record->has_outcome) return;
    json_begin(writer, "outcome", '{');
    json_put_fields(writer, members, MEMBERS, outcome);
    const char *name = NULL;
    if (outcome->has_stretch_place && outcome->stretch_body < record->bodies.count) {
        name = run_record_text(record, record->bodies.data[outcome->stretch_body].name);
        json_begin(writer, "largest_stretch_place", '{');
        json_put_string(writer, "cloth", name);
        json_put_unsigned(writer, "body", outcome->stretch_body);
        json_begin(writer, "vertices", '[');
        for (int k = 0; k < 2; k++) json_put_unsigned(writer, NULL, outcome->stretch_vertices[k]);
        json_end(writer, ']');
        json_begin(writer, "position", '[');
        for (int k = 0; k < 3; k++) json_put_double(writer, NULL, outcome->stretch_position[k]);
        json_end(writer, ']');
        json_end(writer, '}');
    }
    char text[2048];
    const char *const failure =
        record->state == TULLE_RUN_FAILED ? run_record_text(record, record->message) : NULL;
    tulle_run_outcome_describe(outcome, name, failure, text, sizeof text);
    json_put_string(writer, "trouble", text);
    json_end(writer, '}');
}

static tulle_status read_place(const json_document *document, const json_value *object,
                               size_t body_count, tulle_run_outcome *outcome, tulle_error *error) {
    const json_value *place = NULL, *vertices = NULL, *position = NULL;
    if (!json_find(document, object, "largest_stretch_place")) return TULLE_OK;
    tulle_status status =
        json_take_member(document, object, "largest_stretch_place", JSON_OBJECT, &place, error);
    if (!status) status = json_take_whole(document, place, "body", &outcome->stretch_body, error);
    if (!status)
        status = json_take_member(document, place, "vertices", JSON_ARRAY, &vertices, error);
    if (!status)
        status = json_take_member(document, place, "position", JSON_ARRAY, &position, error);
    if (status) return status;
    if (outcome->stretch_body >= body_count || vertices->count != 2 || position->count != 3)
        return json_fail(document, place, error,
                         "\"largest_stretch_place\" should name a body, two vertices and a place");
    const json_value *item = json_get_first(document, vertices);
    for (int k = 0; k < 2 && item; k++, item = json_get_next(document, item)) {
        if (item->type != JSON_NUMBER || !(item->number >= 0.0 && item->number <= UINT32_MAX) ||
            item->number != floor(item->number))
            return json_fail(document, item, error, "a vertex should be a whole number");
        outcome->stretch_vertices[k] = (uint32_t)item->number;
    }
    item = json_get_first(document, position);
    for (int k = 0; k < 3 && item; k++, item = json_get_next(document, item)) {
        if (item->type != JSON_NUMBER)
            return json_fail(document, item, error, "a coordinate should be a number");
        outcome->stretch_position[k] = item->number;
    }
    outcome->has_stretch_place = 1;
    return TULLE_OK;
}

tulle_status run_outcome_read(run_record *record, const json_document *document,
                              const json_value *root, tulle_error *error) {
    if (!json_find(document, root, "outcome")) return TULLE_OK;
    tulle_run_outcome outcome = {0};
    const json_value *object = NULL;
    tulle_status status = json_take_member(document, root, "outcome", JSON_OBJECT, &object, error);
    if (!status) status = json_take_fields(document, object, members, MEMBERS, &outcome, error);
    if (!status) status = read_place(document, object, record->bodies.count, &outcome, error);
    if (status) return status;
    record->has_outcome = true;
    record->outcome = outcome;
    return TULLE_OK;
}
