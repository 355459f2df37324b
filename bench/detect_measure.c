/* bench/detect_measure.c - see detect_measure.h. */
#include "detect_measure.h"

#include "detect/detector/detector_parts.h"

#include "base/sort.h"
#include "base/timer.h"

#include <stdio.h>
#include <stdlib.h>

const char *const stage_names[STAGE_COUNT] = {
    "patches", "trees", "traversal", "filters", "impact", "search", "events", "total", "processor"};

/* A detector at work, with the bytes it holds and the times of its passes. */
typedef struct bench_detector {
    tulle_detector *detector;
    size_t bytes_held;
    double times[STAGE_COUNT][ROUNDS_MAX];
} bench_detector;

static void *count_allocate(void *context, size_t byte_count) {
    void *const block = malloc(byte_count);
    if (block) *(size_t *)context += byte_count;
    return block;
}

static void count_release(void *context, void *pointer, size_t byte_count) {
    *(size_t *)context -= byte_count;
    free(pointer);
}

const char *method_name(tulle_detect_method method) {
    static const char *const names[] = {"patches", "refit", "bvox", "paper"};
    return names[method];
}

spread spread_of(double *values, size_t count) {
    qsort(values, count, sizeof *values, compare_doubles);
    return (spread){.median = values[count / 2],
                    .least = values[0],
                    .ninth_decile = values[count * 9 / 10 < count ? count * 9 / 10 : count - 1]};
}

static void take_input(const detect_input *input, tulle_detect_def *def) {
    def->triangles = input->triangles;
    def->triangle_count = input->triangle_count;
    def->vertex_count = input->vertex_count;
    def->rest = input->rest;
    def->surfaces = input->surfaces;
    def->surface_count = input->surface_count;
}

tulle_detector *make_detector(const detect_input *input, measured_run *run) {
    tulle_detector *detector;
    tulle_error error;
    take_input(input, &run->def);
    run->status = tulle_detector_create(&run->def, &detector, &error);
    if (run->status == TULLE_OK) return detector;
    fprintf(stderr, "bench_detect: %s: %s\n", input->name, error.message);
    exit(4);
}

tulle_detect_result find_step(const detect_input *input, tulle_detector *detector, int step) {
    tulle_detect_result result;
    tulle_error error;
    if (tulle_detector_find_events(detector, input->states[step], input->states[step + 1], &result,
                                   &error) == TULLE_OK)
        return result;
    fprintf(stderr, "bench_detect: %s: %s\n", input->name, error.message);
    exit(4);
}

static void create(const detect_input *input, measured_run *run, bench_detector *bench) {
    tulle_detect_def def = run->def;
    tulle_error error;
    take_input(input, &def);
    def.allocator = (tulle_allocator){
        .allocate = count_allocate, .release = count_release, .context = &bench->bytes_held};
    run->status = tulle_detector_create(&def, &bench->detector, &error);
    if (run->status == TULLE_OK) {
        bench->detector->keeps_all_patches = run->keeps_all != 0;
        return;
    }
    fprintf(stderr, "bench_detect: %s: %s: %s\n", input->name, run->name, error.message);
    bench->detector = NULL;
}

/* A pass over step 0 or 1. */
static void run_pass(const detect_input *input, int step, measured_run *run,
                     bench_detector *bench) {
    tulle_detect_result result;
    tulle_error error;
    if (run->status != TULLE_OK) return;
    run->status = tulle_detector_find_events(bench->detector, input->states[step],
                                             input->states[step + 1], &result, &error);
    if (run->status == TULLE_OK) {
        run->counts = result.statistics;
        run->event_count = result.event_count;
    } else {
        fprintf(stderr, "bench_detect: %s: %s: %s\n", input->name, run->name, error.message);
    }
}

static void note_times(const measured_run *run, bench_detector *bench, int round, double total,
                       double processor) {
    const tulle_detect_statistics *const from = &run->counts;
    double const values[STAGE_COUNT] = {[STAGE_PATCHES] = from->patch_seconds,
                                        [STAGE_TREES] = from->tree_seconds,
                                        [STAGE_TRAVERSAL] = from->traversal_seconds,
                                        [STAGE_FILTERS] = from->filter_seconds,
                                        [STAGE_IMPACT] = from->impact_seconds,
                                        [STAGE_SEARCH] = from->search_seconds,
                                        [STAGE_EVENTS] = from->event_seconds,
                                        [STAGE_TOTAL] = total,
                                        [STAGE_PROCESSOR] = processor};
    for (int s = 0; s < STAGE_COUNT; s++) bench->times[s][round] = values[s];
}

static void measure_round(const detect_input *input, measured_run *run, bench_detector *bench,
                          int round) {
    run_pass(input, 0, run, bench);
    double const processor = timer_processor_now(), begin = timer_now();
    run_pass(input, 1, run, bench);
    double const total = timer_now() - begin;
    if (round >= 0) note_times(run, bench, round, total, timer_processor_now() - processor);
}

void measure_runs(const detect_input *input, measured_run *runs, size_t count, int rounds) {
    bench_detector *const benches = calloc(count, sizeof *benches);
    if (!benches) exit(4);
    for (size_t i = 0; i < count; i++) {
        double const begin = timer_now();
        create(input, &runs[i], &benches[i]);
        run_pass(input, 0, &runs[i], &benches[i]);
        runs[i].first_seconds = timer_now() - begin;
    }
    for (int round = -1; round < rounds; round++)
        for (size_t i = 0; i < count; i++) measure_round(input, &runs[i], &benches[i], round);
    for (size_t i = 0; i < count; i++) {
        for (int s = 0; s < STAGE_COUNT; s++)
            runs[i].times[s] = spread_of(benches[i].times[s], (size_t)rounds);
        runs[i].bytes_held = benches[i].bytes_held;
        tulle_detector_destroy(benches[i].detector);
    }
    free(benches);
}
