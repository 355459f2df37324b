/* bench/detect_alarms.c - false alarms: reported pairs that do not touch, by rational arithmetic,
 * on the recorded runs of scenes and on the four kinds of input. */
#include "detect_tables.h"

#include "support/alarm_count.h"

#include <stdlib.h>
#include <string.h>

enum { FACTOR_COUNT = 3, FRAME_STRIDE = 15, FRAME_MAX = 1000 };
/* Motions as simulated, and longer ones: a frame has three steps. */
static const double factors[FACTOR_COUNT] = {1.0, 3.0, 10.0};
/* [edges] The dense inputs are not made to move farther: too many pairs to judge. */
static const double LONGEST_MOTION = 2.0;

static const input_source scenes[] = {{.name = "sphere", .run = "sphere", .has_obstacles = 1},
                                      {.name = "needles", .run = "needles", .has_obstacles = 1},
                                      {.name = "spikes", .run = "spikes", .has_obstacles = 1},
                                      {.name = "layers", .run = "layers", .has_obstacles = 1},
                                      {.name = "ribbon", .run = "ribbon", .has_obstacles = 1},
                                      {.name = "net", .run = "net", .has_obstacles = 1}};

/* The measured step, its motion `factor` times as long. */
static void count_input(const detect_input *input, double factor, alarm_counts *counts) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = input->triangles;
    def.triangle_count = input->triangle_count;
    def.vertex_count = input->vertex_count;
    def.rest = input->rest;
    def.surfaces = input->surfaces;
    def.surface_count = input->surface_count;
    size_t const number_count = 3 * input->vertex_count;
    double *const end = malloc(number_count * sizeof *end);
    if (!end) exit(4);
    for (size_t i = 0; i < number_count; i++) {
        double const begin = input->states[1][i];
        end[i] =
            factor == 1.0 ? input->states[2][i] : begin + factor * (input->states[2][i] - begin);
    }
    tulle_error error;
    if (alarm_count_add(&def, input->states[1], end, counts, &error) != TULLE_OK) {
        fprintf(stderr, "bench_detect: %s: %s\n", input->name, error.message);
        exit(4);
    }
    free(end);
}

/* The columns of write_csv_header, most of them empty. */
static void write_alarm_csv(FILE *csv, const char *name, double factor, int motion_count,
                            const alarm_counts *counts) {
    fprintf(csv, "alarms,%s,%.0f,,,,,,,,%llu,%llu,%llu,%llu,,,,,", name, factor,
            (unsigned long long)counts->candidates, (unsigned long long)counts->filtered,
            (unsigned long long)counts->tested, (unsigned long long)counts->events);
    for (int s = 0; s < 3 * STAGE_COUNT; s++) fputc(',', csv);
    fprintf(csv, ",%d,%llu,%llu,%llu,%llu,,\n", motion_count, (unsigned long long)counts->coplanar,
            (unsigned long long)counts->touching, (unsigned long long)counts->missed,
            (unsigned long long)counts->false_alarms);
    fflush(csv);
}

static void print_alarm_row(const bench_options *options, const char *name, double factor,
                            int motion_count, const alarm_counts *counts) {
    const uint64_t numbers[] = {counts->candidates, counts->coplanar,    counts->filtered,
                                counts->tested,     counts->events,      counts->touching,
                                counts->missed,     counts->false_alarms};
    printf("%-8s %6.0f %7d", name, factor, motion_count);
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        printf(" %10llu", (unsigned long long)numbers[k]);
    printf(" %7.2f%%\n", alarm_count_share(counts));
    fflush(stdout);
    if (options->csv) write_alarm_csv(options->csv, name, factor, motion_count, counts);
}

/* One motion in FRAME_STRIDE frames of a run. */
static void print_scene_rows(const bench_options *options, const input_source *scene) {
    alarm_counts counts[FACTOR_COUNT] = {{0}};
    int motion_count = 0;
    input_source source = *scene;
    for (source.frame = FRAME_STRIDE; source.frame < FRAME_MAX; source.frame += FRAME_STRIDE) {
        if (options->frame > 0 && options->frame != source.frame) continue;
        if (!input_exists(options->runs, &source)) break;
        detect_input input;
        input_load(options->runs, &source, &input);
        for (int k = 0; k < FACTOR_COUNT; k++) count_input(&input, factors[k], &counts[k]);
        input_destroy(&input);
        motion_count++;
    }
    for (int k = 0; k < FACTOR_COUNT && motion_count > 0; k++)
        print_alarm_row(options, scene->name, factors[k], motion_count, &counts[k]);
    if (motion_count == 0) printf("left out: %s/%s is not there\n", options->runs, scene->name);
}

static void print_kind_rows(const bench_options *options, const input_source *kind) {
    if (!input_exists(options->runs, kind)) {
        printf("left out: %s/%s is not there\n", options->runs, kind->run);
        return;
    }
    detect_input input;
    input_load(options->runs, kind, &input);
    for (int k = 0; k < FACTOR_COUNT; k++) {
        if (k > 0 && factors[k] * input.motion > LONGEST_MOTION) break;
        alarm_counts counts = {0};
        count_input(&input, factors[k], &counts);
        print_alarm_row(options, kind->name, factors[k], 1, &counts);
    }
    input_destroy(&input);
}

static int is_wanted(const bench_options *options, const char *name) {
    return !options->only || strcmp(options->only, name) == 0;
}

void print_alarms(const bench_options *options) {
    printf("\n== False alarms at separation 0: pairs of features. Scenes: every %dth frame of the "
           "run, a step of it and its motion so many times as long\n",
           FRAME_STRIDE);
    printf("%-8s %6s %7s %10s %10s %10s %10s %10s %10s %10s %10s %8s\n", "input", "times",
           "motions", "candidates", "coplanar", "filtered", "tested", "events", "touching",
           "missed", "false", "of tested");
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        if (is_wanted(options, scenes[i].name)) print_scene_rows(options, &scenes[i]);
    for (size_t i = 0; i < KIND_COUNT; i++)
        if (is_wanted(options, kinds[i].name)) print_kind_rows(options, &kinds[i]);
}
