/* bench/detect_tables.c - see detect_tables.h. */
#include "detect_tables.h"

#include "tulle_io/mesh_files.h"

#include <string.h>

static double const DEGREE = 0.017453292519943295; /* [rad] */
static double const MS = 1e3;                      /* of a second */

/* The frames are those where candidates and motion are as the kind wants them. */
const input_source kinds[KIND_COUNT] = {
    {.name = "crumple",
     .run = "crumple",
     .frame = 140,
     .levels = 2,
     .is_turned = 1,
     .motion = 0.07},
    {.name = "bundle", .run = "bundle", .frame = 210, .levels = 2, .is_turned = 1, .motion = 0.28},
    {.name = "violent", .run = "violent", .frame = 70, .levels = 2, .is_turned = 1, .motion = 1.4},
    {.name = "wave", .run = "wave", .frame = 150, .levels = 2, .is_turned = 1, .motion = 0.12}};

static const input_source recorded[] = {
    {.name = "sphere", .run = "sphere", .frame = 45, .has_obstacles = 1},
    {.name = "needles", .run = "needles", .frame = 45, .has_obstacles = 1},
    {.name = "ribbon", .run = "ribbon", .frame = 150, .has_obstacles = 1},
    {.name = "net", .run = "net", .frame = 60, .has_obstacles = 1}};

enum { ANGLE_COUNT = 6, GROWTH_LEVELS = 5 };
static const int angles[ANGLE_COUNT] = {30, 45, 60, 75, 85, 89}; /* [degree] */
static const char *const angle_names[ANGLE_COUNT] = {"patches 30", "patches 45", "patches 60",
                                                     "patches 75", "patches 85", "patches 89"};

measured_run make_run(tulle_detect_method method, int threads) {
    measured_run run = {.name = method_name(method), .def = tulle_detect_def_default()};
    run.def.method = method;
    run.def.threads = threads;
    return run;
}

void write_csv_header(FILE *csv) {
    if (!csv) return;
    fprintf(csv, "table,input,run,threads,alpha_max,vertices,triangles,edge_m,motion_edges,"
                 "leaf_pairs,box_pairs,filtered_pairs,tested_pairs,events,patches,patch_triangles,"
                 "uses_patches,bytes_held,first_ms");
    for (int s = 0; s < STAGE_COUNT; s++)
        fprintf(csv, ",%s_median_ms,%s_min_ms,%s_p90_ms", stage_names[s], stage_names[s],
                stage_names[s]);
    fputs(",motions,coplanar_pairs,touching,missed,false_alarms,mean_ms,mean_part_ms\n", csv);
}

void write_csv(FILE *csv, const char *table, const detect_input *input, const measured_run *run) {
    const tulle_detect_statistics *const counts = &run->counts;
    if (!csv || run->status != TULLE_OK) return;
    fprintf(csv, "%s,%s,%s,%d,%.0f,%zu,%zu,%g,%.3f", table, input->name, run->name,
            run->def.threads, run->def.max_angle / DEGREE, input->vertex_count,
            input->triangle_count, input->edge, input->motion);
    const uint64_t numbers[] = {counts->leaf_pairs,      counts->box_pairs,
                                counts->filtered_pairs,  counts->tested_pairs,
                                run->event_count,        counts->patch_count,
                                counts->patch_triangles, (uint64_t)(counts->uses_patches != 0),
                                run->bytes_held};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        fprintf(csv, ",%llu", (unsigned long long)numbers[i]);
    fprintf(csv, ",%.3f", MS * run->first_seconds);
    for (int s = 0; s < STAGE_COUNT; s++)
        fprintf(csv, ",%.4f,%.4f,%.4f", MS * run->times[s].median, MS * run->times[s].least,
                MS * run->times[s].ninth_decile);
    fputs(",,,,,,", csv); /* columns of false alarms */
    if (run->mean_seconds > 0.0)
        fprintf(csv, "%.4f,%.4f", MS * run->mean_seconds, MS * run->mean_part_seconds);
    else
        fputc(',', csv);
    fputc('\n', csv);
    fflush(csv);
}

static void print_input(const detect_input *input) {
    printf("\n%s: %zu vertices, %zu triangles, %zu surfaces, edges of %.2f mm, motion %.3f edges\n",
           input->name, input->vertex_count, input->triangle_count, input->surface_count,
           1e3 * input->edge, input->motion);
}

/* Whether the input is wanted and there; loads it. */
static int load(const bench_options *options, const input_source *listed, detect_input *input) {
    input_source changed = *listed;
    const input_source *const source = &changed;
    if (options->frame > 0) {
        changed.frame = options->frame;
        changed.motion = 0.0;
    }
    if (options->only && strcmp(options->only, source->name) != 0) return 0;
    if (!input_exists(options->runs, source)) {
        printf("\n%s: left out, %s/%s has no frame %u; bench/make_inputs.sh makes it\n",
               source->name, options->runs, source->run, source->frame);
        return 0;
    }
    input_load(options->runs, source, input);
    print_input(input);
    return 1;
}

static double get_patch_share(const detect_input *input, const measured_run *run) {
    return 100.0 * (double)run->counts.patch_triangles / (double)input->triangle_count;
}

/* ---- the four kinds ---- */

void write_kinds(const bench_options *options, const char *directory) {
    static const char *const ends[] = {"start", "end"};
    for (size_t i = 0; i < KIND_COUNT; i++) {
        detect_input input;
        if (!load(options, &kinds[i], &input)) continue;
        for (int k = 0; k < 2; k++) {
            char path[1024];
            tulle_error error;
            tulle_mesh_view const mesh = {.positions = input.states[1 + k],
                                          .vertex_count = input.vertex_count,
                                          .triangles = input.triangles,
                                          .triangle_count = input.triangle_count};
            snprintf(path, sizeof path, "%s/%s_%s.ply", directory, input.name, ends[k]);
            if (tulle_mesh_write(path, mesh, &error) != TULLE_OK)
                fprintf(stderr, "bench_detect: %s\n", error.message);
        }
        input_destroy(&input);
    }
}

static void print_kind_row(const detect_input *input, const measured_run *run, double refit) {
    const tulle_detect_statistics *const counts = &run->counts;
    if (run->status != TULLE_OK) {
        printf("%-8s %d  not available\n", run->name, run->def.threads);
        return;
    }
    printf("%-8s %d %9llu %9llu %8llu %7zu %5.1f%%", run->name, run->def.threads,
           (unsigned long long)counts->box_pairs, (unsigned long long)counts->filtered_pairs,
           (unsigned long long)counts->tested_pairs, run->event_count, get_patch_share(input, run));
    for (int s = STAGE_PATCHES; s <= STAGE_EVENTS; s++) printf(" %8.2f", MS * run->times[s].median);
    const spread *const total = &run->times[STAGE_TOTAL];
    printf(" | %8.2f %8.2f %8.2f %8.2f %6.2f\n", MS * total->median, MS * total->least,
           MS * total->ninth_decile, MS * run->times[STAGE_PROCESSOR].median,
           refit > 0.0 ? total->median / refit : 0.0);
}

static void print_kind(const bench_options *options, const detect_input *input) {
    printf("%-8s %s %9s %9s %8s %7s %6s %8s %8s %8s %8s %8s %8s %8s | %8s %8s %8s %8s %6s\n",
           "method", "t", "box pairs", "filtered", "tested", "events", "patch", "patches", "trees",
           "travers.", "filters", "impact", "search", "events", "total", "min", "p90", "cpu",
           "/refit");
    for (const int *threads = options->threads; *threads > 0; threads++) {
        measured_run runs[4];
        size_t count = 0;
        runs[count++] = make_run(TULLE_DETECT_REFIT, *threads);
        runs[count++] = make_run(TULLE_DETECT_PATCHES, *threads);
        runs[count++] = make_run(TULLE_DETECT_BVOX, *threads);
        if (options->has_paper) runs[count++] = make_run(TULLE_DETECT_PAPER, *threads);
        measure_runs(input, runs, count, options->rounds);
        for (size_t i = 0; i < count; i++) {
            print_kind_row(input, &runs[i], runs[0].times[STAGE_TOTAL].median);
            write_csv(options->csv, "kinds", input, &runs[i]);
        }
        fflush(stdout);
    }
}

void print_kinds(const bench_options *options) {
    printf("\n== Kinds of input: times in ms, medians of %d passes\n", options->rounds);
    for (size_t i = 0; i < KIND_COUNT; i++) {
        detect_input input;
        if (!load(options, &kinds[i], &input)) continue;
        print_kind(options, &input);
        input_destroy(&input);
    }
}

/* ---- what patches bring ---- */

static void print_angle_row(const detect_input *input, const measured_run *run,
                            const measured_run *refit, const measured_run *bvox) {
    double const total = run->times[STAGE_TOTAL].median;
    if (run->status != TULLE_OK) {
        printf("%-11s not available\n", run->name);
        return;
    }
    /* boxes of searches with patches hold whole motions, as those of bvox do */
    const measured_run *const alike = run->counts.uses_patches ? bvox : refit;
    double const culled =
        100.0 * (1.0 - (double)run->counts.box_pairs / (double)alike->counts.box_pairs);
    printf("%-11s %8.1f%% %7llu %9llu %7.1f%% %6s %9.3f %9.3f %9.3f %8.2f %8.2f\n", run->name,
           get_patch_share(input, run), (unsigned long long)run->counts.patch_count,
           (unsigned long long)run->counts.box_pairs, culled,
           run->counts.uses_patches ? "yes" : "no", MS * run->times[STAGE_PATCHES].median,
           MS * total, MS * run->times[STAGE_TOTAL].least, total / refit->times[STAGE_TOTAL].median,
           total / bvox->times[STAGE_TOTAL].median);
}

static void print_angle_table(const bench_options *options, const detect_input *input) {
    measured_run runs[ANGLE_COUNT + 4]; /* refit, bvox, the default, the paper's */
    size_t count = 0;
    runs[count++] = make_run(TULLE_DETECT_REFIT, options->threads[0]);
    runs[count++] = make_run(TULLE_DETECT_BVOX, options->threads[0]);
    for (int i = 0; i < ANGLE_COUNT; i++) {
        runs[count] = make_run(TULLE_DETECT_PATCHES, options->threads[0]);
        runs[count].name = angle_names[i];
        runs[count].keeps_all = 1;
        runs[count++].def.max_angle = angles[i] * DEGREE;
    }
    runs[count++] = make_run(TULLE_DETECT_PATCHES, options->threads[0]);
    if (options->has_paper) runs[count++] = make_run(TULLE_DETECT_PAPER, options->threads[0]);
    measure_runs(input, runs, count, options->rounds);
    printf("%-11s %9s %7s %9s %8s %6s %9s %9s %9s %8s %8s\n", "run", "triangles", "patches",
           "box pairs", "culled", "in use", "patches", "total", "min", "/refit", "/bvox");
    for (size_t i = 0; i < count; i++) {
        print_angle_row(input, &runs[i], &runs[0], &runs[1]);
        write_csv(options->csv, "angles", input, &runs[i]);
    }
    fflush(stdout);
}

void print_angles(const bench_options *options) {
    printf("\n== What patches bring, by alpha_max in degrees, kept whatever they save, and as they "
           "are, "
           "switched off where they do not pay: %d threads, times in ms, medians of %d passes\n",
           options->threads[0], options->rounds);
    for (size_t i = 0; i < sizeof recorded / sizeof *recorded; i++) {
        detect_input input;
        if (!load(options, &recorded[i], &input)) continue;
        print_angle_table(options, &input);
        input_destroy(&input);
    }
    for (size_t i = 0; i < KIND_COUNT; i++) {
        detect_input input;
        if (!load(options, &kinds[i], &input)) continue;
        print_angle_table(options, &input);
        input_destroy(&input);
    }
}

/* ---- growth ---- */

/* ns and bytes for each triangle; ratio: to the time of 20k triangles. */
static void print_growth_row(const detect_input *input, const measured_run *run, double base) {
    double const triangles = (double)input->triangle_count;
    double const each = 1e9 * run->times[STAGE_TOTAL].median / triangles;
    printf("%-8s %9zu %7.3f %9.3f %10llu %9zu %9.2f %9.1f %9.1f %7.2f %9.0f %9.1f\n", run->name,
           input->triangle_count, input->motion, MS * run->first_seconds,
           (unsigned long long)run->counts.box_pairs, run->event_count,
           MS * run->times[STAGE_TOTAL].median, each,
           1e9 * run->times[STAGE_PROCESSOR].median / triangles, base > 0.0 ? each / base : 0.0,
           (double)run->bytes_held / triangles, get_patch_share(input, run));
}

static void print_growth_table(const bench_options *options, double motion, int level_max) {
    double base[2] = {0.0, 0.0}; /* [ns] of 20k triangles */
    printf("%-8s %9s %7s %9s %10s %9s %9s %9s %9s %7s %9s %9s\n", "method", "triangles", "motion",
           "first ms", "box pairs", "events", "total ms", "ns/tri", "cpu ns", "/20k", "bytes/tri",
           "patch %");
    for (int level = 0; level < level_max; level++) {
        input_source const source = {
            .name = "drape", .run = "drape", .frame = 100, .levels = level, .motion = motion};
        if (!input_exists(options->runs, &source)) {
            printf("left out: %s/drape is not there\n", options->runs);
            return;
        }
        detect_input input;
        input_load(options->runs, &source, &input);
        measured_run runs[2] = {make_run(TULLE_DETECT_REFIT, options->threads[0]),
                                make_run(TULLE_DETECT_PATCHES, options->threads[0])};
        measure_runs(&input, runs, 2, level < 3 ? options->rounds : (options->rounds + 2) / 3);
        for (int i = 0; i < 2; i++) {
            if (runs[i].status != TULLE_OK) continue;
            if (level == 1)
                base[i] = 1e9 * runs[i].times[STAGE_TOTAL].median / (double)input.triangle_count;
            print_growth_row(&input, &runs[i], base[i]);
            write_csv(options->csv, motion > 0.0 ? "growth" : "growth-same-motion", &input,
                      &runs[i]);
        }
        fflush(stdout);
        input_destroy(&input);
    }
}

void print_growth(const bench_options *options) {
    printf("\n== Growth: one draped cloth, subdivided; %d threads. Motion of 0.1 edges at every "
           "size\n",
           options->threads[0]);
    print_growth_table(options, 0.1, GROWTH_LEVELS);
    printf("\nThe motion as simulated, the same in metres at every size\n");
    print_growth_table(options, 0.0, GROWTH_LEVELS);
}
