/* bench/detect_lasting.c - what patches of several widths cost as cloth goes on moving: passes over
 * consecutive steps of a run, with all repairs and growth but the first. */
#include "detect_tables.h"

#include "base/timer.h"

#include <stdlib.h>
#include <string.h>

enum { STEP_COUNT = 60, RUN_COUNT = 7, MOST_FRAMES = 100000 };
static double const DEGREE = 0.017453292519943295; /* [rad] */
static double const MS = 1e3;                      /* of a second */

/* [degree] 0: no patches */
static const int widths[RUN_COUNT] = {0, 30, 45, 60, 75, 80, 85};
static const char *const names[RUN_COUNT] = {"refit",      "patches 30", "patches 45", "patches 60",
                                             "patches 75", "patches 80", "patches 85"};

/* As simulated, and so finely that a cloth takes some milliseconds. */
static const input_source sources[] = {
    {.name = "wave", .run = "wave", .levels = 2, .is_turned = 1},
    {.name = "drape", .run = "drape", .levels = 2, .is_turned = 1},
    {.name = "crumple", .run = "crumple", .levels = 2, .is_turned = 1},
    {.name = "bundle", .run = "bundle", .levels = 2, .is_turned = 1},
    {.name = "violent", .run = "violent", .levels = 2, .is_turned = 1},
    {.name = "sphere", .run = "sphere", .levels = 1, .has_obstacles = 1},
    {.name = "needles", .run = "needles", .levels = 1, .has_obstacles = 1},
    {.name = "ribbon", .run = "ribbon", .levels = 1, .has_obstacles = 1},
    {.name = "net", .run = "net", .levels = 1, .has_obstacles = 1}};

/* One detector and its passes. */
typedef struct lasting_run {
    measured_run measured;
    tulle_detector *detector;
    double seconds[STAGE_COUNT][STEP_COUNT];
    double share, patch_count, checked_share; /* sums over the passes */
} lasting_run;

static void create(const detect_input *input, int threads, int width, lasting_run *run) {
    *run = (lasting_run){0};
    run->measured = make_run(width > 0 ? TULLE_DETECT_PATCHES : TULLE_DETECT_REFIT, threads);
    if (width > 0) run->measured.def.max_angle = width * DEGREE;
    run->detector = make_detector(input, &run->measured);
}

/* step < 0: not measured. */
static void run_pass(const detect_input *input, lasting_run *run, int step) {
    double const begin = timer_now();
    tulle_detect_result const result = find_step(input, run->detector, 1);
    double const total = timer_now() - begin;
    run->measured.counts = result.statistics;
    run->measured.event_count = result.event_count;
    if (step < 0) return;
    const tulle_detect_statistics *const counts = &result.statistics;
    run->seconds[STAGE_PATCHES][step] = counts->patch_seconds;
    run->seconds[STAGE_TREES][step] = counts->tree_seconds;
    run->seconds[STAGE_SEARCH][step] = counts->search_seconds;
    run->seconds[STAGE_TOTAL][step] = total;
    run->share += (double)counts->patch_triangles / (double)input->triangle_count / STEP_COUNT;
    run->patch_count += (double)counts->patch_count / STEP_COUNT;
    if (counts->patch_count > 0)
        run->checked_share +=
            (double)counts->checked_again / (double)counts->patch_count / STEP_COUNT;
}

static double find_mean(const double values[STEP_COUNT]) {
    double sum = 0.0;
    for (int i = 0; i < STEP_COUNT; i++) sum += values[i];
    return sum / STEP_COUNT;
}

static void print_row(const bench_options *options, const detect_input *input, const char *name,
                      lasting_run *run, double refit) {
    double const mean = find_mean(run->seconds[STAGE_TOTAL]);
    double const patches = find_mean(run->seconds[STAGE_PATCHES]);
    double const search = find_mean(run->seconds[STAGE_SEARCH]);
    for (int s = 0; s < STAGE_COUNT; s++)
        run->measured.times[s] = spread_of(run->seconds[s], STEP_COUNT);
    double const most = run->seconds[STAGE_TOTAL][STEP_COUNT - 1]; /* sorted by now */
    const spread *const total = &run->measured.times[STAGE_TOTAL];
    printf("%-11s %8.1f%% %8.1f %8.1f%% %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f %7.2f %7.2f %7.2f\n",
           name, 100.0 * run->share, run->patch_count, 100.0 * run->checked_share, MS * patches,
           MS * search, MS * mean, MS * total->median, MS * total->ninth_decile, MS * most,
           mean / refit, total->median / refit, (patches + search) / refit);
    run->measured.name = name;
    run->measured.mean_seconds = mean;
    run->measured.mean_part_seconds = patches + search;
    run->measured.counts.patch_count = (uint64_t)(run->patch_count + 0.5);
    run->measured.counts.patch_triangles =
        (uint64_t)(run->share * (double)input->triangle_count + 0.5);
    write_csv(options->csv, "lasting", input, &run->measured);
    fflush(stdout);
}

static uint32_t find_last_frame(const char *runs, const input_source *listed) {
    input_source source = *listed;
    for (source.frame = 0; source.frame < MOST_FRAMES && input_exists(runs, &source);)
        source.frame++;
    return source.frame > 0 ? source.frame - 1 : 0;
}

static void measure_source(const bench_options *options, const input_source *listed) {
    input_source source = *listed;
    uint32_t const last = find_last_frame(options->runs, listed);
    if (last < STEP_COUNT + 2) {
        printf("\n%s: left out, %s/%s has fewer than %d frames\n", listed->name, options->runs,
               listed->run, STEP_COUNT + 3);
        return;
    }
    lasting_run *const runs = calloc(RUN_COUNT, sizeof *runs);
    if (!runs) exit(4);
    detect_input input;
    for (int step = -1; step < STEP_COUNT; step++) {
        source.frame = last - STEP_COUNT + (uint32_t)(step + 1);
        input_load(options->runs, &source, &input);
        /* what rests in one step may move in another */
        for (size_t s = 0; s < input.surface_count; s++) input.surfaces[s].is_static = 0;
        for (int i = 0; i < RUN_COUNT; i++) {
            if (step < 0) create(&input, options->threads[0], widths[i], &runs[i]);
            run_pass(&input, &runs[i], step);
        }
        if (step + 1 < STEP_COUNT) input_destroy(&input);
    }
    printf("\n%s: %zu triangles, %d steps\n", listed->name, input.triangle_count, STEP_COUNT);
    printf("%-11s %9s %8s %9s %9s %9s %9s %9s %9s %9s %7s %7s %7s\n", "run", "triangles", "patches",
           "kept", "patching", "search", "mean", "median", "p90", "most", "/refit", "median",
           "part");
    double const refit = find_mean(runs[0].seconds[STAGE_TOTAL]);
    for (int i = 0; i < RUN_COUNT; i++) {
        print_row(options, &input, names[i], &runs[i], refit);
        tulle_detector_destroy(runs[i].detector);
    }
    input_destroy(&input);
    free(runs);
}

void print_lasting(const bench_options *options) {
    printf("\n== Patches over %d consecutive steps, repairs and growth but the first among them: "
           "%d threads, times of a pass in ms\n",
           STEP_COUNT, options->threads[0]);
    for (size_t i = 0; i < sizeof sources / sizeof *sources; i++)
        if (!options->only || strcmp(options->only, sources[i].name) == 0)
            measure_source(options, &sources[i]);
}
