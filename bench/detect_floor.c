/* bench/detect_floor.c - where a pass without patches stands against the machine: the bytes that
 * each stage has to move, how fast it does, and how fast as many are copied or read in the same
 * round; one thread. */
#include "detect_tables.h"

#include "detect/detector/detector_parts.h"
#include "detect/trees/broad_phase_parts.h"

#include "base/timer.h"

#include <stdlib.h>
#include <string.h>

enum { FLOOR_STAGES = 3 };
static double const NS = 1e9; /* of a second */
static double const MB = 1e-6;

/* A stage: `count` items, and bytes as they go through it once. */
typedef struct floor_stage {
    const char *name, *item;
    uint64_t count;
    size_t bytes;
    int is_copied; /* else only read */
    double seconds, floor_seconds;
} floor_stage;

/* Trees: positions in, records, boxes, slabs, blocks and nodes out. Pairs of leaves: both blocks.
 * Filters: the records of four vertices. */
static void fill_stages(const detect_input *input, const broad_phase *broad,
                        const tulle_detect_statistics *counts, floor_stage stages[FLOOR_STAGES]) {
    size_t const vertex_bytes =
        6 * sizeof(double) + sizeof *broad->records + sizeof *broad->vertex_boxes;
    size_t nodes = 0, leaves = 0;
    for (size_t s = 0; s < broad->surface_count; s++) {
        nodes += broad->trees[s].nodes.count;
        leaves += broad->trees[s].leaf_count;
    }
    size_t const block_bytes = broad->block_capacity * sizeof *broad->blocks;
    stages[0] = (floor_stage){.name = "trees",
                              .item = "triangle",
                              .count = input->triangle_count,
                              .bytes = input->vertex_count * vertex_bytes + block_bytes +
                                       leaves * sizeof *broad->slabs + nodes * sizeof(tree_node),
                              .is_copied = 1};
    stages[1] = (floor_stage){.name = "traversal",
                              .item = "pair of leaves",
                              .count = counts->leaf_pairs,
                              .bytes = 2 * counts->leaf_pairs * (block_bytes / leaves)};
    stages[2] = (floor_stage){.name = "filters",
                              .item = "candidate",
                              .count = counts->box_pairs,
                              .bytes = 4 * counts->box_pairs * sizeof *broad->records};
}

/* [s] To go through as many bytes, `size` of them over and over. */
static double time_reading(const double *from, size_t size, size_t bytes, double *sink) {
    typedef double lanes __attribute__((vector_size(64)));
    lanes sums[4] = {{0.0}};
    double const begin = timer_now();
    for (size_t done = 0; done < bytes; done += size) {
        size_t const count = (bytes - done < size ? bytes - done : size) / sizeof(lanes);
        for (size_t i = 0; i + 4 <= count; i += 4) {
            for (size_t k = 0; k < 4; k++) {
                lanes own;
                memcpy(&own, from + 8 * (i + k), sizeof own);
                sums[k] += own;
            }
        }
    }
    for (int k = 0; k < 4; k++) *sink += sums[k][0];
    return timer_now() - begin;
}

static double time_copying(const double *from, double *to, size_t bytes) {
    double const begin = timer_now();
    memcpy(to, from, bytes / 2);
    return timer_now() - begin;
}

static void keep_less(double *least, double seconds) {
    if (*least == 0.0 || seconds < *least) *least = seconds;
}

/* What is read lies in a working set of the blocks, or the records, of the whole cloth. */
static void measure_rounds(const bench_options *options, const detect_input *input,
                           floor_stage stages[FLOOR_STAGES]) {
    measured_run run = make_run(TULLE_DETECT_REFIT, 1);
    tulle_detector *const detector = make_detector(input, &run);
    (void)find_step(input, detector, 0);
    tulle_detect_statistics counts = find_step(input, detector, 1).statistics;
    const broad_phase *const broad = detector->broad;
    fill_stages(input, broad, &counts, stages);
    size_t const sets[FLOOR_STAGES] = {0, broad->block_capacity * sizeof *broad->blocks,
                                       input->vertex_count * sizeof *broad->records};
    size_t room = stages[0].bytes;
    for (int k = 1; k < FLOOR_STAGES; k++) room = sets[k] > room ? sets[k] : room;
    double *const from = calloc(room + 64, 1), *const to = calloc(room + 64, 1), sink = 0.0;
    if (!from || !to) exit(4);
    memset(to, 1, room); /* pages are there */
    memset(from, 1, room);
    for (int round = 0; round < options->rounds; round++) {
        (void)find_step(input, detector, 0);
        counts = find_step(input, detector, 1).statistics;
        double const seconds[FLOOR_STAGES] = {counts.tree_seconds, counts.traversal_seconds,
                                              counts.filter_seconds};
        for (int k = 0; k < FLOOR_STAGES; k++) {
            keep_less(&stages[k].seconds, seconds[k]);
            keep_less(&stages[k].floor_seconds,
                      stages[k].is_copied ? time_copying(from, to, stages[k].bytes)
                                          : time_reading(from, sets[k], stages[k].bytes, &sink));
        }
    }
    if (sink == 1.0) printf("\n"); /* what was read is used */
    free(from);
    free(to);
    tulle_detector_destroy(detector);
}

static void print_stage(const detect_input *input, const floor_stage *of) {
    printf("| `%s` | %s | %llu | %s | %.1f | %.2f | %.1f | %.1f | %.1f | %.1f |\n", input->name,
           of->name, (unsigned long long)of->count, of->item, NS * of->seconds / (double)of->count,
           1e3 * of->seconds, MB * (double)of->bytes, 1e-9 * (double)of->bytes / of->seconds,
           1e-9 * (double)of->bytes / of->floor_seconds, of->seconds / of->floor_seconds);
}

void print_floor(const bench_options *options) {
    printf(
        "\n== Bytes and time of each stage without patches, beside copying (trees) or reading as "
        "many; one thread, least of %d passes\n\n",
        options->rounds);
    printf("| input | stage | count | of | ns each | ms | MB | GB/s | GB/s of the machine | times "
           "its |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < KIND_COUNT; i++) {
        detect_input input;
        floor_stage stages[FLOOR_STAGES];
        if (options->only && strcmp(options->only, kinds[i].name) != 0) continue;
        if (!input_exists(options->runs, &kinds[i])) {
            printf("left out: %s/%s is not there\n", options->runs, kinds[i].run);
            continue;
        }
        input_load(options->runs, &kinds[i], &input);
        measure_rounds(options, &input, stages);
        for (int k = 0; k < FLOOR_STAGES; k++) print_stage(&input, &stages[k]);
        input_destroy(&input);
    }
    fflush(stdout);
}
