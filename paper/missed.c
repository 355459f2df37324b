/* missed.c - collisions that the paper's rule for patches misses: it skips every pair within a
 * patch, on the strength of the cone of its normals alone. Every time the truth is a search without
 * patches.
 *
 * Two motions made here, a spiral ramp that is turned upside down and an open ring whose ends go
 * through each other: the judge finds both ends of the motion clean, the surface passes through
 * itself between them. And recorded frames of runs.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, sections 3.2, 3.3 and 7. */
#include "measure.h"
#include "recorded_frames.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TURN 6.283185307179586         /* [rad] */
static const double BEST_ANGLE = 85.0; /* [degrees] at which the paper's rule is fastest */
enum {
    COLUMNS = 96,
    ROWS = 4,
    VERTICES = (COLUMNS + 1) * (ROWS + 1),
    TRIANGLES = 2 * COLUMNS * ROWS,
    LINE_SIZE = 64 /* [bytes] */
};

/* A band about the z axis: radius from inner to outer, at both ends of the motion. */
typedef struct band_motion {
    const char *name;
    double inner, outer; /* [m] */
    double angles[2];    /* [rad] that the band goes around */
    double heights[2];   /* [m] its last edge lies higher than its first one by this */
} band_motion;

static const band_motion motions[] = {
    {"ramp", 0.5, 1.0, {1.4 * TURN, 1.4 * TURN}, {0.14, -0.14}},
    {"ring", 0.6, 1.0, {TURN - 0.3, TURN + 0.3}, {-0.06, 0.02}},
};

typedef struct band {
    double positions[2][3 * VERTICES];
    uint32_t triangles[3 * TRIANGLES];
} band;

static void make_band(const band_motion *motion, band *made) {
    for (int end = 0; end < 2; end++)
        for (int i = 0; i <= COLUMNS; i++)
            for (int j = 0; j <= ROWS; j++) {
                double *const x = made->positions[end] + 3 * (i * (ROWS + 1) + j);
                double const along = (double)i / COLUMNS;
                double const angle = motion->angles[end] * (along - 0.5);
                double const radius = motion->inner + (motion->outer - motion->inner) * j / ROWS;
                x[0] = radius * cos(angle);
                x[1] = radius * sin(angle);
                x[2] = motion->heights[end] * along;
            }
    uint32_t *next = made->triangles;
    for (uint32_t i = 0; i < COLUMNS; i++)
        for (uint32_t j = 0; j < ROWS; j++) {
            uint32_t const a = i * (ROWS + 1) + j, b = a + ROWS + 1;
            uint32_t const corners[6] = {a, b, a + 1, b, b + 1, a + 1};
            memcpy(next, corners, sizeof corners);
            next += 6;
        }
}

/* The same question to three searches: without patches, by the paper's rule, and by patches that
 * are proven. */
enum { SEARCH_TRUTH, SEARCH_PAPER, SEARCH_PROVEN, SEARCH_COUNT };

typedef struct three_searches {
    tulle_detector *detectors[SEARCH_COUNT];
    tulle_detect_result results[SEARCH_COUNT]; /* the detectors own the events */
} three_searches;

static void begin_searches(tulle_detect_def def, three_searches *searches) {
    *searches = (three_searches){0};
    tulle_detect_def defs[SEARCH_COUNT] = {def, use_paper_rules(def, BEST_ANGLE),
                                           use_proof(def, BEST_ANGLE)};
    defs[SEARCH_TRUTH].method = TULLE_DETECT_BVOX;
    tulle_error error = {0};
    for (int i = 0; i < SEARCH_COUNT; i++)
        require(tulle_detector_create(&defs[i], &searches->detectors[i], &error), &error);
}

static void search(three_searches *searches, const double *start, const double *end) {
    tulle_error error = {0};
    for (int i = 0; i < SEARCH_COUNT; i++)
        require(tulle_detector_find_events(searches->detectors[i], start, end,
                                           &searches->results[i], &error),
                &error);
}

static void end_searches(three_searches *searches) {
    for (int i = 0; i < SEARCH_COUNT; i++) tulle_detector_destroy(searches->detectors[i]);
}

static bool is_same_pair(const tulle_detect_event *a, const tulle_detect_event *b) {
    return a->kind == b->kind && memcmp(a->vertices, b->vertices, sizeof a->vertices) == 0 &&
           a->face == b->face;
}

/* Events of the truth that the other search lacks. Both are in the same order. */
static uint64_t count_missed(const three_searches *searches, int other_search) {
    const tulle_detect_result *const truth = &searches->results[SEARCH_TRUTH];
    const tulle_detect_result *const other = &searches->results[other_search];
    uint64_t missed = 0;
    size_t next = 0;
    for (size_t i = 0; i < truth->event_count; i++) {
        bool const is_there =
            next < other->event_count && is_same_pair(&truth->events[i], &other->events[next]);
        next += is_there;
        missed += !is_there;
    }
    return missed;
}

/* "events,patches,found,missed,proven_missed" */
static void print_counts(const three_searches *searches) {
    const tulle_detect_result *const results = searches->results;
    printf("%zu,%" PRIu64 ",%zu,%" PRIu64 ",%" PRIu64 "\n", results[SEARCH_TRUTH].event_count,
           (uint64_t)results[SEARCH_PAPER].statistics.patch_count,
           results[SEARCH_PAPER].event_count, count_missed(searches, SEARCH_PAPER),
           count_missed(searches, SEARCH_PROVEN));
}

static size_t count_crossings(const band *of, int end, int threads) {
    tulle_check_body const body = {.mesh = {.positions = of->positions[end],
                                            .vertex_count = VERTICES,
                                            .triangles = of->triangles,
                                            .triangle_count = TRIANGLES}};
    tulle_check_result result = {0};
    tulle_error error = {0};
    require(tulle_check_intersections(&body, 1, threads, &result, &error), &error);
    size_t const count = result.pair_count;
    tulle_check_result_destroy(&result);
    return count;
}

void measure_motions(int threads) {
    band *const made = require_memory(sizeof *made);
    for (size_t i = 0; i < sizeof motions / sizeof motions[0]; i++) {
        make_band(&motions[i], made);
        tulle_detect_def def = tulle_detect_def_default();
        def.triangles = made->triangles;
        def.triangle_count = TRIANGLES;
        def.vertex_count = VERTICES;
        def.threads = threads;
        three_searches searches;
        begin_searches(def, &searches);
        search(&searches, made->positions[0], made->positions[1]);
        printf("%s,%d,%zu,%zu,", motions[i].name, TRIANGLES, count_crossings(made, 0, threads),
               count_crossings(made, 1, threads));
        print_counts(&searches);
        end_searches(&searches);
    }
    free(made);
}

void measure_missed(const measure_words *words) {
    recorded_frames frames;
    recorded_frames_open(words->run, false, &frames);
    three_searches searches;
    begin_searches(recorded_frames_get_def(&frames, words->distance, words->threads), &searches);
    char line[LINE_SIZE];
    while (fgets(line, sizeof line, stdin)) {
        unsigned frame = 0;
        if (sscanf(line, "%u", &frame) != 1) {
            fprintf(stderr, "paper_measure: \"%s\" should be a frame\n", line);
            exit(2);
        }
        recorded_frames_read(&frames, frame);
        search(&searches, frames.start, frames.end);
        printf("%u,", frame);
        print_counts(&searches);
        fflush(stdout);
    }
    end_searches(&searches);
    recorded_frames_close(&frames);
}
