/* validation_run.c - what experiments call: rows, worlds that belong to the run, steps with their
 * counts and the judge. */
#include "validation/validation_run.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* Every so many steps of a world its state is judged. */
enum { STEPS_BETWEEN_JUDGEMENTS = 3 };

const experiment validation_all = {.name = "all", .shows = ""};

void validation_add_row(validation_table *table, const validation_row *row) {
    if (table->count == table->capacity) {
        size_t const capacity = 2 * table->capacity + 32;
        validation_row *const rows = realloc(table->rows, capacity * sizeof *rows);
        if (!rows) {
            fprintf(stderr, "no memory left for rows\n");
            exit(EXIT_FAILURE);
        }
        table->rows = rows;
        table->capacity = capacity;
    }
    table->rows[table->count++] = *row;
}

static validation_row start_row(const validation_run *run, const char *what, const char *unit,
                                const char *reference) {
    validation_row row = {.experiment = run->experiment->name, .expected = "-"};
    snprintf(row.what, sizeof row.what, "%s", what);
    snprintf(row.unit, sizeof row.unit, "%s", unit);
    snprintf(row.reference, sizeof row.reference, "%s", reference);
    return row;
}

static void write_expectation(expectation expected, char text[48]) {
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

static row_verdict judge_row(double measured, expectation expected) {
    bool is_fine = false;
    switch (expected.kind) {
    case EXPECT_AT_MOST: is_fine = measured <= expected.value; break;
    case EXPECT_AT_LEAST: is_fine = measured >= expected.value; break;
    case EXPECT_WITHIN:
        is_fine = fabs(measured - expected.value) <= expected.tolerance * fabs(expected.value);
        break;
    case EXPECT_EQUALS: is_fine = !(measured < expected.value || measured > expected.value); break;
    case EXPECT_NOTHING: return VERDICT_TOLD;
    }
    return is_fine && isfinite(measured) ? VERDICT_FINE : VERDICT_OFF;
}

void validate_row(validation_run *run, const char *what, double measured, const char *unit,
                  expectation expected, const char *reference) {
    validation_row row = start_row(run, what, unit, reference);
    row.measured = measured;
    write_expectation(expected, row.expected);
    row.verdict = judge_row(measured, expected);
    if (row.verdict == VERDICT_OFF && expected.is_open && validate_options(run)->is_quick)
        row.verdict = VERDICT_OPEN;
    validation_add_row(run->table, &row);
}

void validate_skip(validation_run *run, const char *what, const char *why) {
    validation_row row = start_row(run, what, "", why);
    row.verdict = VERDICT_SKIPPED;
    validation_add_row(run->table, &row);
}

void validate_give_up(validation_run *run, const char *format, ...) {
    char text[VALIDATION_TEXT];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    validation_row row = start_row(run, "runs to its end", "", text);
    row.measured = NAN;
    row.verdict = VERDICT_OFF;
    validation_add_row(run->table, &row);
    longjmp(run->leave, 1);
}

const validation_options *validate_options(const validation_run *run) { return run->options; }
const char *validate_subject(const validation_run *run) {
    const char *const dot = strchr(run->experiment->name, '.');
    return dot ? dot + 1 : "";
}
tulle_world_def validate_world_def(const validation_run *run) { return run->def; }

static validation_block *add_block(validation_run *run) {
    validation_block *const block = calloc(1, sizeof *block);
    if (!block) validate_give_up(run, "no memory left");
    block->next = run->blocks;
    run->blocks = block;
    return block;
}

void *validate_allocate(validation_run *run, size_t byte_count) {
    validation_block *const block = add_block(run);
    block->bytes = calloc(1, byte_count);
    if (!block->bytes) validate_give_up(run, "no memory left");
    return block->bytes;
}

void validate_own(validation_run *run, void *object, void (*release)(void *object)) {
    validation_block *const block = calloc(1, sizeof *block);
    if (!block) {
        release(object);
        validate_give_up(run, "no memory left");
    }
    *block = (validation_block){.next = run->blocks, .object = object, .release = release};
    run->blocks = block;
}

tulle_mesh *validate_make_shape(validation_run *run, const tulle_shape_def *def) {
    validation_block *const block = add_block(run);
    tulle_error error = {0};
    if (tulle_shape_generate(def, &block->mesh, &error) != TULLE_OK)
        validate_give_up(run, "shape: %s", error.message);
    return &block->mesh;
}

tulle_mesh *validate_make_mesh(validation_run *run, size_t vertex_count, size_t triangle_count) {
    validation_block *const block = add_block(run);
    tulle_error error = {0};
    if (tulle_mesh_create(vertex_count, triangle_count, &block->mesh, &error) != TULLE_OK)
        validate_give_up(run, "mesh: %s", error.message);
    return &block->mesh;
}

tulle_world *validate_make_world(validation_run *run, const tulle_world_def *def) {
    if (run->world_count == VALIDATION_WORLDS) validate_give_up(run, "too many worlds");
    validation_world *const entry = &run->worlds[run->world_count];
    *entry = (validation_world){0};
    tulle_error error = {0};
    if (tulle_world_create(def, &entry->world, &error) != TULLE_OK)
        validate_give_up(run, "world: %s", error.message);
    run->world_count++;
    return entry->world;
}

static validation_world *find_world(validation_run *run, const tulle_world *world) {
    for (size_t i = run->world_count; i-- > 0;)
        if (run->worlds[i].world == world) return &run->worlds[i];
    validate_give_up(run, "the world is not of this run");
}

tulle_cloth_id validate_add_cloth(validation_run *run, tulle_world *world,
                                  const tulle_cloth_def *def) {
    validation_world *const entry = find_world(run, world);
    tulle_cloth_id id = {0};
    tulle_error error = {0};
    if (entry->cloth_count == VALIDATION_BODIES) validate_give_up(run, "too many cloths");
    if (tulle_world_add_cloth(world, def, &id, &error) != TULLE_OK)
        validate_give_up(run, "cloth: %s", error.message);
    entry->cloths[entry->cloth_count] = def->mesh;
    entry->cloth_ids[entry->cloth_count++] = id;
    return id;
}

tulle_obstacle_id validate_add_obstacle(validation_run *run, tulle_world *world,
                                        const tulle_obstacle_def *def) {
    validation_world *const entry = find_world(run, world);
    tulle_obstacle_id id = {0};
    tulle_error error = {0};
    if (entry->obstacle_count == VALIDATION_BODIES) validate_give_up(run, "too many obstacles");
    if (tulle_world_add_obstacle(world, def, &id, &error) != TULLE_OK)
        validate_give_up(run, "obstacle: %s", error.message);
    entry->obstacles[entry->obstacle_count] = def->mesh;
    entry->obstacle_ids[entry->obstacle_count++] = id;
    return id;
}

void validate_count_judgement(validation_run *run, size_t crossing) {
    run->totals->judged++;
    run->totals->crossing += crossing;
}

/* Counts the pairs of triangles that cross, by the exact judge. */
static size_t judge_world(validation_run *run, const validation_world *entry) {
    tulle_check_body bodies[2 * VALIDATION_BODIES];
    size_t count = 0;
    for (size_t i = 0; i < entry->cloth_count; i++) {
        bodies[count] = (tulle_check_body){.mesh = entry->cloths[i]};
        bodies[count++].mesh.positions =
            tulle_cloth_get_positions(entry->world, entry->cloth_ids[i], NULL);
    }
    for (size_t i = 0; i < entry->obstacle_count; i++) {
        if (!tulle_obstacle_is_present(entry->world, entry->obstacle_ids[i])) continue;
        bodies[count] = (tulle_check_body){.mesh = entry->obstacles[i], .is_obstacle = 1};
        bodies[count++].mesh.positions =
            tulle_obstacle_get_positions(entry->world, entry->obstacle_ids[i], NULL);
    }
    tulle_check_result result = {0};
    tulle_error error = {0};
    if (tulle_check_intersections(bodies, count, 1, &result, &error) != TULLE_OK)
        validate_give_up(run, "judge: %s", error.message);
    size_t const crossing = result.pair_count;
    validate_count_judgement(run, crossing);
    tulle_check_result_destroy(&result);
    return crossing;
}

size_t validate_judge(validation_run *run, const tulle_world *world) {
    return judge_world(run, find_world(run, world));
}

void validate_plan(validation_run *run, long steps) {
    run->progress.planned += (uint64_t)(steps > 0 ? steps : 0);
}

void validate_count_step(validation_run *run, const tulle_step_report *report, double minimum_gap) {
    validation_totals *const totals = run->totals;
    totals->steps++;
    totals->contacts += report->contacts;
    totals->rescues += report->rescue_impact_zones + report->rescue_component_scalings +
                       report->rescue_global_scalings;
    totals->smallest_gap_share =
        fmin(totals->smallest_gap_share, report->smallest_gap / minimum_gap);
    validation_progress_step(&run->progress, run->experiment->name);
    if (validation_is_interrupted()) longjmp(run->leave, 1);
}

tulle_step_report validate_step(validation_run *run, tulle_world *world, double time_step) {
    validation_world *const entry = find_world(run, world);
    tulle_step_report report = {0};
    tulle_error error = {0};
    if (tulle_world_step(world, time_step, &report, &error) != TULLE_OK)
        validate_give_up(run, "step at %g s: %s", tulle_world_get_time(world), error.message);
    if (!(entry->minimum_gap > 0.0))
        tulle_world_get_distances(world, NULL, NULL, &entry->minimum_gap);
    validate_count_step(run, &report, entry->minimum_gap);
    if (report.step % STEPS_BETWEEN_JUDGEMENTS == 0) judge_world(run, entry);
    return report;
}

void validate_simulate(validation_run *run, tulle_world *world, double seconds) {
    long const steps = lround(seconds / VALIDATION_STEP);
    for (long i = 0; i < steps; i++) validate_step(run, world, VALIDATION_STEP);
}

static void find_mean(const double *values, size_t count, double mean[3]) {
    for (size_t c = 0; c < 3; c++) {
        double sum = 0.0;
        for (size_t i = 0; i < count; i++) sum += values[3 * i + c];
        mean[c] = sum / (double)count;
    }
}

void validate_mean_position(const tulle_world *world, tulle_cloth_id id, double mean[3]) {
    size_t count = 0;
    const double *const values = tulle_cloth_get_positions(world, id, &count);
    find_mean(values, count, mean);
}

void validate_mean_velocity(const tulle_world *world, tulle_cloth_id id, double mean[3]) {
    size_t count = 0;
    const double *const values = tulle_cloth_get_velocities(world, id, &count);
    find_mean(values, count, mean);
}

static void release(validation_run *run) {
    for (size_t i = 0; i < run->world_count; i++) tulle_world_destroy(run->worlds[i].world);
    run->world_count = 0;
    while (run->blocks) {
        validation_block *const block = run->blocks;
        run->blocks = block->next;
        if (block->release) block->release(block->object);
        tulle_mesh_destroy(&block->mesh);
        free(block->bytes);
        free(block);
    }
    validation_end_plot(run);
}

bool validation_run_experiment(validation_run *run) {
    size_t const first = run->table->count;
    validation_totals const before = *run->totals;
    if (setjmp(run->leave) == 0) {
        run->experiment->run(run);
        for (size_t i = 0; i < run->world_count; i++)
            if (tulle_world_get_step_count(run->worlds[i].world) > 0)
                judge_world(run, &run->worlds[i]);
    }
    release(run);
    if (!validation_is_interrupted()) return true;
    run->table->count = first;
    *run->totals = before;
    return false;
}

void validation_report_totals(validation_run *run) {
    const validation_totals *const totals = run->totals;
    if (totals->steps == 0) return;
    run->experiment = &validation_all;
    validate_row(run, "steps", (double)totals->steps, "", nothing(), "");
    validate_row(run, "contacts, summed over steps", (double)totals->contacts, "", nothing(), "");
    validate_row(run, "rescues a contact",
                 totals->contacts > 0 ? (double)totals->rescues / (double)totals->contacts : 0.0,
                 "", at_most(1e-3), "one in 1,000");
    if (isfinite(totals->smallest_gap_share))
        validate_row(run, "smallest gap over the minimum gap", totals->smallest_gap_share, "",
                     at_least(1.0), "the promise of a step");
    else
        validate_skip(run, "smallest gap over the minimum gap", "nothing was in contact");
    validate_row(run, "states judged", (double)totals->judged, "", nothing(), "");
    validate_row(run, "pairs of triangles that cross in them", (double)totals->crossing, "",
                 equals(0.0), "exact judge");
}
