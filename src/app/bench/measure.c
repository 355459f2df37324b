/* app/bench/measure.c - times the same steps from the same state again and again.
 *
 * A repeat loads the state, makes one step that is not timed, and times those after it. Every
 * repeat must end in the same state and count the same, on any number of threads: else the measures
 * would be of different work, and an error says so. */
#define _POSIX_C_SOURCE 200809L
#include "app/bench/bench.h"
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/timer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    REPEATS_MIN = 3, /* however long they take, unless fewer are asked for */
    STEP_TIME = TULLE_STAGE_COUNT,
    PROCESSOR_TIME,
    TIME_COUNT /* the stages, the step, its processor time */
};

/* ---- memory ---- */

/* An allocator that counts. */
typedef struct counted_heap {
    size_t held, most; /* [bytes] */
    uint64_t calls;
} counted_heap;

static void *heap_allocate(void *context, size_t byte_count) {
    counted_heap *const heap = context;
    void *const block = memory_allocate_default(byte_count);
    if (!block) return NULL;
    heap->calls++;
    heap->held += byte_count;
    if (heap->held > heap->most) heap->most = heap->held;
    return block;
}

static void heap_release(void *context, void *block, size_t byte_count) {
    counted_heap *const heap = context;
    if (block) heap->held -= byte_count;
    free(block);
}

/* Most that the process held in memory since the last call, input and program and all, in bytes;
 * empty where the system does not tell. From here on what is held now counts. */
static void take_most_resident(char text[BENCH_TEXT_SIZE]) {
    text[0] = '\0';
    FILE *const file = fopen("/proc/self/status", "r");
    char line[256];
    unsigned long kilobytes = 0;
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "VmHWM: %lu kB", &kilobytes) == 1)
            snprintf(text, BENCH_TEXT_SIZE, "%llu", 1024ULL * kilobytes);
    if (file) fclose(file);
    FILE *const reset = fopen("/proc/self/clear_refs", "w");
    if (!reset || fputs("5", reset) < 0) text[0] = '\0';
    if (reset && fclose(reset) != 0) text[0] = '\0';
}

/* ---- counts ---- */

static const char *const count_names[] = {"contacts",
                                          "new_contacts",
                                          "stick_contacts",
                                          "slip_contacts",
                                          "hard_contacts",
                                          "box_pairs",
                                          "tested_pairs",
                                          "turning_pairs",
                                          "pair_searches",
                                          "solve_count",
                                          "cg_iterations",
                                          "impact_rounds",
                                          "rescue_impact_zones",
                                          "rescue_component_scalings",
                                          "rescue_global_scalings",
                                          "substeps",
                                          "patches"};
enum { COUNT_COUNT = sizeof count_names / sizeof count_names[0] };

/* In the order of their names, summed over the steps. */
static void sum_counts(const tulle_step_report *reports, uint32_t count,
                       uint64_t sums[COUNT_COUNT]) {
    memset(sums, 0, COUNT_COUNT * sizeof *sums);
    for (uint32_t i = 0; i < count; i++) {
        const tulle_step_report *const r = &reports[i];
        uint64_t const values[COUNT_COUNT] = {r->contacts,
                                              r->new_contacts,
                                              r->stick_contacts,
                                              r->slip_contacts,
                                              r->hard_contacts,
                                              r->box_pairs,
                                              r->tested_pairs,
                                              r->turning_pairs,
                                              r->pair_searches,
                                              r->solve_count,
                                              r->cg_iterations,
                                              r->impact_rounds,
                                              r->rescue_impact_zones,
                                              r->rescue_component_scalings,
                                              r->rescue_global_scalings,
                                              r->substeps,
                                              r->patches};
        for (size_t k = 0; k < COUNT_COUNT; k++) sums[k] += values[k];
    }
}

/* ---- repeats ---- */

/* What all repeats of a case share, on any number of threads. */
typedef struct case_outcome {
    bool is_known;
    uint64_t start_hash, end_hash, counts[COUNT_COUNT];
} case_outcome;

typedef struct repeats {
    const file_data *state; /* that each repeat begins from */
    const char *state_path; /* for messages; null: the state was not read */
    tulle_world *world;
    double time_step; /* [s] */
    uint32_t step_count, made, wanted;
    double *samples;            /* [s] a step: TIME_COUNT lists of `wanted` */
    tulle_step_report *reports; /* of the timed steps */
    counted_heap *heap;
    case_outcome *outcome;
} repeats;

static int is_stopped(void *context) {
    (void)context;
    return interrupt_is_pending();
}

/* Keeps the outcome of the first repeat, compares that of others with it. */
static tulle_status judge_outcome(case_outcome *known, const case_outcome *found,
                                  tulle_error *error) {
    if (!known->is_known) {
        *known = *found;
        known->is_known = true;
        return TULLE_OK;
    }
    if (known->start_hash != found->start_hash || known->end_hash != found->end_hash)
        return error_set(error, TULLE_ERROR_STEP_FAILED,
                         "the same steps from the same state end in another one: %016llx, then "
                         "%016llx; this is an error of the program",
                         (unsigned long long)known->end_hash, (unsigned long long)found->end_hash);
    for (size_t i = 0; i < COUNT_COUNT; i++)
        if (known->counts[i] != found->counts[i])
            return error_set(error, TULLE_ERROR_STEP_FAILED,
                             "the same steps from the same state count other %s: %llu, then %llu; "
                             "this is an error of the program",
                             count_names[i], (unsigned long long)known->counts[i],
                             (unsigned long long)found->counts[i]);
    return TULLE_OK;
}

static void add_sample(repeats *self, double processor) {
    double sums[TIME_COUNT] = {0.0};
    for (uint32_t i = 0; i < self->step_count; i++) {
        for (size_t k = 0; k < TULLE_STAGE_COUNT; k++) sums[k] += self->reports[i].stage_seconds[k];
        sums[STEP_TIME] += self->reports[i].total_seconds;
    }
    sums[PROCESSOR_TIME] = processor;
    for (size_t k = 0; k < TIME_COUNT; k++)
        self->samples[k * self->wanted + self->made] = sums[k] / self->step_count;
    self->made++;
}

static tulle_status load_state(const repeats *self, tulle_error *error) {
    tulle_error fault = {0};
    tulle_status const status =
        tulle_world_load_state(self->world, self->state->bytes, self->state->byte_count, &fault);
    if (status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY || !self->state_path) {
        if (status != TULLE_OK) *error = fault;
        return status;
    }
    return error_set_at(error, status, self->state_path, 0, 0,
                        "%.200s; delete it, and it is made again", fault.message);
}

static tulle_status make_repeat(repeats *self, tulle_error *error) {
    case_outcome found = {0};
    tulle_world *const world = self->world;
    tulle_status status = load_state(self, error);
    found.start_hash = tulle_world_get_state_hash(world);
    if (status == TULLE_OK) status = tulle_world_step(world, self->time_step, NULL, error);
    self->heap->calls = 0;
    double const begin = timer_processor_now();
    if (status == TULLE_OK)
        status = bench_make_steps(world, self->time_step, self->step_count, self->reports, error);
    if (status != TULLE_OK) return status;
    add_sample(self, timer_processor_now() - begin);
    found.end_hash = tulle_world_get_state_hash(world);
    sum_counts(self->reports, self->step_count, found.counts);
    return judge_outcome(self->outcome, &found, error);
}

/* The first repeat warms caches and memory and is made again. */
static tulle_status make_repeats(repeats *self, double most_seconds, tulle_error *error) {
    double const begin = timer_now();
    tulle_status status = TULLE_OK;
    if (self->wanted > 1) status = make_repeat(self, error);
    self->made = 0;
    while (status == TULLE_OK && self->made < self->wanted &&
           (self->made < REPEATS_MIN || timer_now() - begin < most_seconds))
        status = make_repeat(self, error);
    return status;
}

/* ---- rows ---- */

static bool put(bench_session *self, bench_row row, bench_kind kind, const char *name) {
    row.kind = kind;
    snprintf(row.name, sizeof row.name, "%s", name);
    return bench_rows_put(&self->rows, &row);
}

static bool put_value(bench_session *self, bench_row row, bench_kind kind, const char *name,
                      double value) {
    row.value = value;
    return put(self, row, kind, name);
}

static bool put_hash(bench_session *self, bench_row row, const char *name, uint64_t hash) {
    snprintf(row.text, sizeof row.text, "%016llx", (unsigned long long)hash);
    return put(self, row, BENCH_HASH, name);
}

static bool put_times(bench_session *self, bench_row row, const repeats *made) {
    bool is_put = true;
    for (int k = 0; k < TIME_COUNT && is_put; k++) {
        const char *const name = k == STEP_TIME        ? "step"
                                 : k == PROCESSOR_TIME ? "processor"
                                                       : tulle_stage_name(k);
        bench_row_summarize(&row, made->samples + (size_t)k * made->wanted, made->made);
        is_put = put(self, row, BENCH_TIME, name);
    }
    return is_put;
}

/* Vertices of all cloth, triangles of all cloth, triangles of all obstacles. */
static bool put_sizes(bench_session *self, bench_row row, const tulle_scene *loaded) {
    size_t particles = 0, cloth = 0, obstacles = 0;
    for (size_t i = 0; i < tulle_scene_get_cloth_count(loaded); i++) {
        particles += tulle_scene_get_cloth_mesh(loaded, i).vertex_count;
        cloth += tulle_scene_get_cloth_mesh(loaded, i).triangle_count;
    }
    for (size_t i = 0; i < tulle_scene_get_obstacle_count(loaded); i++)
        obstacles += tulle_scene_get_obstacle_mesh(loaded, i).triangle_count;
    return put_value(self, row, BENCH_COUNT, "particles", (double)particles) &&
           put_value(self, row, BENCH_COUNT, "cloth_triangles", (double)cloth) &&
           put_value(self, row, BENCH_COUNT, "obstacle_triangles", (double)obstacles);
}

static bool put_rows(bench_session *self, bench_row row, const tulle_scene *loaded,
                     const repeats *made) {
    const case_outcome *const outcome = made->outcome;
    bool is_put = put_times(self, row, made) && put_sizes(self, row, loaded) &&
                  put_value(self, row, BENCH_COUNT, "steps", made->step_count);
    for (size_t i = 0; i < COUNT_COUNT && is_put; i++)
        is_put = put_value(self, row, BENCH_COUNT, count_names[i], (double)outcome->counts[i]);
    if (is_put) is_put = put_value(self, row, BENCH_MEMORY, "most_bytes", (double)made->heap->most);
    if (is_put)
        is_put = put_value(self, row, BENCH_MEMORY, "allocator_calls", (double)made->heap->calls);
    take_most_resident(row.text);
    if (is_put && row.text[0]) is_put = put(self, row, BENCH_ABOUT, "most_resident");
    if (is_put) is_put = put_hash(self, row, "start", outcome->start_hash);
    if (is_put) is_put = put_hash(self, row, "end", outcome->end_hash);
    snprintf(row.text, sizeof row.text, "%u", made->made);
    return is_put && put(self, row, BENCH_ABOUT, "repeats");
}

static void tell(bench_session *self, const bench_row *case_row, uint32_t repeat_count) {
    const bench_row *const step = bench_rows_find_beside(&self->rows, case_row, BENCH_TIME, "step");
    fprintf(stderr, "%s %s, %d thread%s: %.4g ms a step, least %.4g, spread %.2g; %u repeats%s\n",
            case_row->scene, case_row->size, case_row->threads, case_row->threads == 1 ? "" : "s",
            1e3 * step->value, 1e3 * step->minimum, 1e3 * step->spread, repeat_count,
            bench_rows_were_disturbed(&self->rows, step) ? "; other work ran beside" : "");
}

/* ---- a case ---- */

static tulle_status measure_threads(bench_session *self, repeats *made, bench_row row,
                                    tulle_scene *loaded, tulle_error *error) {
    counted_heap heap = {0};
    tulle_allocator const allocator = {
        .allocate = heap_allocate, .release = heap_release, .context = &heap};
    tulle_scene_world built = {0};
    tulle_status status = tulle_scene_build_world(loaded, row.threads, &allocator, &built, error);
    made->world = built.world;
    made->heap = &heap;
    made->made = 0;
    made->samples = calloc((size_t)TIME_COUNT * made->wanted, sizeof *made->samples);
    made->reports = calloc(made->step_count, sizeof *made->reports);
    if (status == TULLE_OK && (!made->samples || !made->reports))
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the measures");
    if (status == TULLE_OK) {
        char unused[BENCH_TEXT_SIZE];
        tulle_world_set_stop_request(built.world, is_stopped, NULL);
        take_most_resident(unused);
        status = make_repeats(made, self->most_seconds, error);
    }
    tulle_scene_destroy_world(&built);
    if (status == TULLE_OK) {
        if (put_rows(self, row, loaded, made))
            tell(self, &row, made->made);
        else
            status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the measures");
    }
    free(made->samples);
    free(made->reports);
    return status;
}

int bench_measure(bench_session *self, tulle_scene *loaded) {
    memory heap = memory_default();
    file_data state = {0};
    int const code = bench_get_state(self, loaded, &heap, &state);
    if (code != APP_EXIT_FINE) return code;
    case_outcome outcome = {0};
    tulle_error error = {0};
    repeats made = {.state = &state,
                    .state_path = self->state_path,
                    .time_step = tulle_scene_get_time_step(loaded),
                    .step_count = self->step_count,
                    .wanted = self->repeat_count,
                    .outcome = &outcome};
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < self->threads_count && status == TULLE_OK; i++) {
        bench_row row = {.threads = self->threads[i]};
        memcpy(row.scene, self->name, sizeof row.scene);
        memcpy(row.size, self->size, sizeof row.size);
        status = measure_threads(self, &made, row, loaded, &error);
    }
    file_release(&heap, &state);
    if (status != TULLE_OK && status != TULLE_ERROR_INTERRUPTED) app_print_error("bench", &error);
    return app_exit_for_run(status);
}
