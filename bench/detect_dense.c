/* bench/detect_dense.c - inputs as dense as cloth gets, made here, the same each time: layers of a
 * crumpled sheet in fast motion, and ribbons twisted into one bundle. The pairs whose tight boxes
 * meet are counted here too, by a sweep along one axis that shares nothing with the trees. */
#include "detect_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double const MS = 1e3;                 /* of a second */
static double const TURN = 6.283185307179586; /* [rad] */
static double const BEND = 0.5;               /* [edge] of a smooth wave that all layers share */
enum {
    SHEET_SIDE = 216, /* vertices along an edge of the sheet */
    PLEATS = 18,
    RIBBONS = 16,
    RIBBON_WIDTH = 11,   /* vertices */
    RIBBON_LENGTH = 251, /* vertices */
    DENSE_COUNT = 4
};

/* How a dense input is made. Lengths are in edges of the grid. */
typedef struct dense_source {
    const char *name;
    int is_bundle;
    double gap;    /* between layers */
    double motion; /* mean of a vertex */
    double noise;  /* share of the motion that each vertex has of its own, 0 .. 1 */
    double across; /* share of that which goes across the layers, 0 .. 1 */
} dense_source;

static const dense_source dense[DENSE_COUNT] = {
    {.name = "storm", .gap = 0.45, .motion = 1.4, .noise = 0.5, .across = 0.2},
    {.name = "gust", .gap = 0.45, .motion = 1.4, .noise = 0.25, .across = 0.5},
    {.name = "rope", .is_bundle = 1, .gap = 0.2, .motion = 0.28, .noise = 0.34, .across = 1.0},
    {.name = "slow", .gap = 0.25, .motion = 0.07, .noise = 0.2, .across = 1.0}};

/* A number in [-1, 1) that depends on both arguments alone. */
static double hash(uint64_t index, uint64_t salt) {
    uint64_t x = index * UINT64_C(0x9e3779b97f4a7c15) + salt * UINT64_C(0xd1b54a32d192ed03) + 1;
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((x ^ x >> 31) >> 11) * 0x1.0p-52 - 1.0;
}

/* A smooth field of space over some thirty edges. */
static double wave(const double x[3], uint64_t salt) {
    double sum = 0.0;
    for (uint64_t k = 0; k < 4; k++)
        sum +=
            sin(TURN *
                ((hash(k, salt) * x[0] + hash(k, salt + 50) * x[1] + hash(k, salt + 150) * x[2]) /
                     30.0 +
                 hash(k, salt + 100)));
    return 0.5 * sum;
}

/* [edge] A grid point in space: pleats on one another, bent along their length to most of a
 * cylinder. Each lies at a height of its own, so none meet. normal: across the layers. */
static void place_sheet(const dense_source *source, int i, int j, double x[3], double normal[3]) {
    int const length = SHEET_SIDE / PLEATS, pleat = i / length, way = i % length;
    double const bend = 0.95 * TURN * j / SHEET_SIDE;
    double const radius = SHEET_SIDE / (0.95 * TURN) + source->gap * (pleat - 0.5 * (PLEATS - 1));
    normal[0] = cos(bend);
    normal[1] = sin(bend);
    normal[2] = 0.0;
    x[0] = radius * normal[0];
    x[1] = radius * normal[1];
    x[2] = pleat % 2 == 0 ? way : length - way;
}

/* [edge] Ribbons on one another, all twisted about one axis. */
static void place_ribbon(const dense_source *source, int ribbon, int i, int j, double x[3],
                         double normal[3]) {
    double const turn = TURN * j / 80.0;
    double const w = i - 0.5 * (RIBBON_WIDTH - 1) + 0.2 * hash((uint64_t)ribbon, 7);
    double const h = source->gap * (ribbon - 0.5 * (RIBBONS - 1));
    normal[0] = -sin(turn);
    normal[1] = cos(turn);
    normal[2] = 0.0;
    x[0] = w * cos(turn) + h * normal[0];
    x[1] = w * sin(turn) + h * normal[1];
    x[2] = j;
}

static void *allocate(size_t count, size_t size) {
    void *const memory = calloc(count, size);
    if (!memory) exit(4);
    return memory;
}

static void add_grid(detect_input *input, int width, int length) {
    size_t const base = input->vertex_count;
    tulle_detect_surface *const surface = &input->surfaces[input->surface_count++];
    *surface = (tulle_detect_surface){.vertex_begin = (uint32_t)base,
                                      .triangle_begin = (uint32_t)input->triangle_count};
    for (int i = 0; i + 1 < width; i++)
        for (int j = 0; j + 1 < length; j++) {
            uint32_t const a = (uint32_t)(base + (size_t)i * (size_t)length + (size_t)j);
            uint32_t const b = a + (uint32_t)length;
            uint32_t const corners[6] = {a, b, a + 1, b, b + 1, a + 1};
            memcpy(input->triangles + 3 * input->triangle_count, corners, sizeof corners);
            input->triangle_count += 2;
        }
    input->vertex_count += (size_t)width * (size_t)length;
    surface->vertex_end = (uint32_t)input->vertex_count;
    surface->triangle_end = (uint32_t)input->triangle_count;
}

static void make_dense(const dense_source *source, detect_input *input) {
    int const grids = source->is_bundle ? RIBBONS : 1;
    int const width = source->is_bundle ? RIBBON_WIDTH : SHEET_SIDE;
    int const length = source->is_bundle ? RIBBON_LENGTH : SHEET_SIDE;
    size_t const most = (size_t)grids * (size_t)width * (size_t)length;
    *input = (detect_input){.name = source->name, .edge = 1.0, .motion = source->motion};
    input->rest = allocate(3 * most, sizeof(double));
    for (int k = 0; k < 3; k++) input->states[k] = allocate(3 * most, sizeof(double));
    input->triangles = allocate(6 * most, sizeof(uint32_t));
    for (int g = 0; g < grids; g++) add_grid(input, width, length);
    double moved = 0.0;
    for (size_t v = 0; v < most; v++) {
        int const j = (int)(v % (size_t)length), row = (int)(v / (size_t)length);
        int const g = row / width, i = row % width;
        double x[3], by[3], normal[3], at[3], across = 0.0;
        if (source->is_bundle)
            place_ribbon(source, g, i, j, at, normal);
        else
            place_sheet(source, i, j, at, normal);
        for (uint64_t k = 0; k < 3; k++) {
            x[k] = at[k] + BEND * wave(at, 1 + k);
            by[k] = source->noise * hash(v, 30 + k);
            across += by[k] * normal[k];
        }
        for (uint64_t k = 0; k < 3; k++)
            by[k] += (1.0 - source->noise) * wave(at, 20 + k) -
                     (1.0 - source->across) * across * normal[k];
        moved += sqrt(by[0] * by[0] + by[1] * by[1] + by[2] * by[2]);
        for (int k = 0; k < 3; k++) {
            input->rest[3 * v + (size_t)k] = k == 0 ? 1.5 * width * g + i : k == 1 ? j : 0.0;
            input->states[1][3 * v + (size_t)k] = x[k];
            input->states[2][3 * v + (size_t)k] = by[k];
        }
    }
    double const factor = source->motion * (double)most / moved;
    for (size_t i = 0; i < 3 * most; i++) {
        double const x = input->states[1][i], by = factor * input->states[2][i];
        input->states[0][i] = x - by;
        input->states[2][i] = x + by;
    }
}

/* ---- counts by tight boxes ---- */

typedef struct feature_box {
    double low[3], high[3];
    uint32_t corners[3], corner_count;
} feature_box;

static int compare_boxes(const void *a, const void *b) {
    double const x = ((const feature_box *)a)->low[0], y = ((const feature_box *)b)->low[0];
    return x < y ? -1 : x > y;
}

static feature_box box_of(const detect_input *input, const uint32_t *corners, uint32_t count) {
    feature_box box = {.corner_count = count};
    for (int k = 0; k < 3; k++) {
        box.low[k] = INFINITY;
        box.high[k] = -INFINITY;
    }
    for (uint32_t c = 0; c < count; c++) {
        box.corners[c] = corners[c];
        for (int s = 1; s < 3; s++)
            for (int k = 0; k < 3; k++) {
                double const x = input->states[s][3 * (size_t)corners[c] + (size_t)k];
                box.low[k] = x < box.low[k] ? x : box.low[k];
                box.high[k] = x > box.high[k] ? x : box.high[k];
            }
    }
    return box;
}

static int is_pair(const feature_box *a, const feature_box *b) {
    for (int k = 0; k < 3; k++)
        if (a->low[k] > b->high[k] || b->low[k] > a->high[k]) return 0;
    for (uint32_t i = 0; i < a->corner_count; i++)
        for (uint32_t k = 0; k < b->corner_count; k++)
            if (a->corners[i] == b->corners[k]) return 0;
    return 1;
}

/* Pairs of a feature of each kind, or of two of `own` where `others` is null. */
static size_t sweep(feature_box *own, size_t own_count, size_t first_kind) {
    size_t count = 0;
    qsort(own, own_count, sizeof *own, compare_boxes);
    for (size_t i = 0; i < own_count; i++)
        for (size_t k = i + 1; k < own_count && own[k].low[0] <= own[i].high[0]; k++)
            if ((first_kind == 2 || own[i].corner_count != own[k].corner_count) &&
                is_pair(&own[i], &own[k]))
                count++;
    return count;
}

static int compare_edges(const void *a, const void *b) {
    const uint32_t *const x = a, *const y = b;
    if (x[0] != y[0]) return x[0] < y[0] ? -1 : 1;
    return x[1] < y[1] ? -1 : x[1] > y[1];
}

static void count_tight(const detect_input *input, size_t *vertex_pairs, size_t *edge_pairs) {
    size_t const triangles = input->triangle_count, vertices = input->vertex_count;
    feature_box *const boxes = allocate(3 * triangles + vertices, sizeof *boxes);
    uint32_t(*const edges)[2] = allocate(3 * triangles, sizeof *edges);
    for (size_t i = 0; i < 3 * triangles; i++) {
        uint32_t const a = input->triangles[i];
        uint32_t const b = input->triangles[i % 3 == 2 ? i - 2 : i + 1];
        edges[i][0] = a < b ? a : b;
        edges[i][1] = a < b ? b : a;
    }
    qsort(edges, 3 * triangles, sizeof *edges, compare_edges);
    size_t count = 0;
    for (size_t i = 0; i < 3 * triangles; i++)
        if (i == 0 || compare_edges(edges[i], edges[i - 1]) != 0)
            boxes[count++] = box_of(input, edges[i], 2);
    *edge_pairs = sweep(boxes, count, 2);
    count = 0;
    for (size_t t = 0; t < triangles; t++)
        boxes[count++] = box_of(input, input->triangles + 3 * t, 3);
    for (uint32_t v = 0; v < vertices; v++) boxes[count++] = box_of(input, &v, 1);
    *vertex_pairs = sweep(boxes, count, 1);
    free(edges);
    free(boxes);
}

/* ---- the table ---- */

typedef struct event_counts {
    size_t all, unresolved, at_start;
} event_counts;

static event_counts count_events(const detect_input *input) {
    measured_run run = make_run(TULLE_DETECT_REFIT, 1);
    tulle_detector *const detector = make_detector(input, &run);
    tulle_detect_result const result = find_step(input, detector, 1);
    event_counts counts = {.all = result.event_count};
    for (size_t i = 0; i < result.event_count; i++) {
        counts.unresolved += result.events[i].state == TULLE_DETECT_UNRESOLVED;
        counts.at_start += result.events[i].state == TULLE_DETECT_TOUCHING_AT_START;
    }
    tulle_detector_destroy(detector);
    return counts;
}

static void print_dense_row(const measured_run *run) {
    const tulle_detect_statistics *const counts = &run->counts;
    printf("%-8s %d %10llu %9llu %8llu", run->name, run->def.threads,
           (unsigned long long)counts->box_pairs, (unsigned long long)counts->filtered_pairs,
           (unsigned long long)counts->tested_pairs);
    for (int s = STAGE_PATCHES; s <= STAGE_EVENTS; s++) printf(" %8.2f", MS * run->times[s].median);
    printf(" | %8.2f %8.2f %8.2f %8.1f\n", MS * run->times[STAGE_TOTAL].median,
           MS * run->times[STAGE_TOTAL].least, MS * run->first_seconds,
           1e9 * run->def.threads * run->times[STAGE_FILTERS].median / (double)counts->box_pairs);
}

void print_dense(const bench_options *options) {
    printf("\n== Dense inputs: times in ms, medians of %d passes\n", options->rounds);
    for (size_t d = 0; d < DENSE_COUNT; d++) {
        detect_input input;
        if (options->only && strcmp(options->only, dense[d].name) != 0) continue;
        make_dense(&dense[d], &input);
        size_t vertex_pairs, edge_pairs;
        count_tight(&input, &vertex_pairs, &edge_pairs);
        event_counts const events = count_events(&input);
        printf("\n%s: %zu vertices, %zu triangles, motion %.2f edges; by tight boxes %zu + %zu = "
               "%zu pairs; %zu events, %zu touch at the start, %zu unresolved (%.2f %%)\n",
               input.name, input.vertex_count, input.triangle_count, input.motion, vertex_pairs,
               edge_pairs, vertex_pairs + edge_pairs, events.all, events.at_start,
               events.unresolved,
               events.all ? 100.0 * (double)events.unresolved / (double)events.all : 0.0);
        printf("%-8s %s %10s %9s %8s %8s %8s %8s %8s %8s %8s %8s | %8s %8s %8s %8s\n", "method",
               "t", "box pairs", "filtered", "tested", "patches", "trees", "travers.", "filters",
               "impact", "search", "events", "total", "min", "first", "ns/pair");
        for (const int *threads = options->threads; *threads > 0; threads++) {
            measured_run runs[2] = {make_run(TULLE_DETECT_REFIT, *threads),
                                    make_run(TULLE_DETECT_PATCHES, *threads)};
            measure_runs(&input, runs, 2, options->rounds);
            for (size_t i = 0; i < 2; i++) {
                print_dense_row(&runs[i]);
                write_csv(options->csv, "dense", &input, &runs[i]);
            }
            fflush(stdout);
        }
        input_destroy(&input);
    }
}
