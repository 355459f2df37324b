/* app/reproduce_counterexamples.c - collisions that the paper's rule for patches misses: it skips
 * every pair within a patch, on the strength of the cone of its normals alone.
 *
 * Two motions made here, a spiral ramp that is turned upside down and an open ring whose ends go
 * through each other: the judge finds both ends of the motion clean, the surface passes through
 * itself between them. Then the recorded frames of the paper's scenes. Every time the truth is a
 * search without patches.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, sections 3.2, 3.3 and 7. */
#include "app/commands.h"
#include "app/interrupt.h"
#include "app/reproduce.h"
#include "base/error.h"

#include "tulle/check.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TURN 6.283185307179586         /* [rad] */
static const double BEST_ANGLE = 85.0; /* [degrees] at which the paper's rule is fastest */
enum {
    COLUMNS = 96,
    ROWS = 4,
    VERTICES = (COLUMNS + 1) * (ROWS + 1),
    TRIANGLES = 2 * COLUMNS * ROWS
};
enum { FRAMES_QUICK = 20, FRAMES_FULL = 600 };

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

/* What one search found. */
typedef struct found_events {
    tulle_detect_event *events; /* a copy; null without events */
    size_t count;
    uint64_t patch_count;
} found_events;

static tulle_status find_events(tulle_detector *detector, const double *start, const double *end,
                                found_events *found, tulle_error *error) {
    tulle_detect_result result;
    tulle_status const status = tulle_detector_find_events(detector, start, end, &result, error);
    if (status != TULLE_OK) return status;
    found->count = result.event_count;
    found->patch_count = result.statistics.patch_count;
    tulle_detect_event *const grown =
        realloc(found->events, (result.event_count + 1) * sizeof *found->events);
    if (!grown) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the events");
    found->events = grown;
    if (result.event_count > 0)
        memcpy(found->events, result.events, result.event_count * sizeof *result.events);
    return TULLE_OK;
}

static bool is_same_pair(const tulle_detect_event *a, const tulle_detect_event *b) {
    return a->kind == b->kind && memcmp(a->vertices, b->vertices, sizeof a->vertices) == 0 &&
           a->face == b->face;
}

/* Events of the truth that the other search lacks. Both are in the same order. */
static uint64_t count_missed(const found_events *truth, const found_events *other) {
    uint64_t missed = 0;
    size_t next = 0;
    for (size_t i = 0; i < truth->count; i++) {
        bool const is_there =
            next < other->count && is_same_pair(&truth->events[i], &other->events[next]);
        next += is_there;
        missed += !is_there;
    }
    return missed;
}

/* The same question to three searches: without patches, by the paper's rule, and by patches that
 * are proven. */
enum { SEARCH_TRUTH, SEARCH_PAPER, SEARCH_PROVEN, SEARCH_COUNT };

typedef struct three_searches {
    tulle_detector *detectors[SEARCH_COUNT];
    found_events found[SEARCH_COUNT];
} three_searches;

static tulle_status begin_searches(tulle_detect_def def, three_searches *searches,
                                   tulle_error *error) {
    *searches = (three_searches){0};
    tulle_detect_def defs[SEARCH_COUNT] = {def, reproduce_use_paper_rules(def, BEST_ANGLE),
                                           reproduce_use_proof(def, BEST_ANGLE)};
    defs[SEARCH_TRUTH].method = TULLE_DETECT_BVOX;
    tulle_status status = TULLE_OK;
    for (int i = 0; i < SEARCH_COUNT && status == TULLE_OK; i++)
        status = tulle_detector_create(&defs[i], &searches->detectors[i], error);
    return status;
}

static tulle_status search(three_searches *searches, const double *start, const double *end,
                           tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (int i = 0; i < SEARCH_COUNT && status == TULLE_OK; i++)
        status = find_events(searches->detectors[i], start, end, &searches->found[i], error);
    return status;
}

static void end_searches(three_searches *searches) {
    for (int i = 0; i < SEARCH_COUNT; i++) {
        tulle_detector_destroy(searches->detectors[i]);
        free(searches->found[i].events);
    }
}

/* ---- motions made here ---- */

static tulle_status count_crossings(const band *of, int end, int threads, size_t *count,
                                    tulle_error *error) {
    tulle_check_body const body = {.mesh = {.positions = of->positions[end],
                                            .vertex_count = VERTICES,
                                            .triangles = of->triangles,
                                            .triangle_count = TRIANGLES}};
    tulle_check_result result = {0};
    tulle_status const status = tulle_check_intersections(&body, 1, threads, &result, error);
    *count = result.pair_count;
    tulle_check_result_destroy(&result);
    return status;
}

static tulle_status look_at_motion(const reproduce *self, const band_motion *motion, FILE *stream,
                                   tulle_error *error) {
    band *const made = malloc(sizeof *made);
    if (!made) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a band");
    make_band(motion, made);
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = made->triangles;
    def.triangle_count = TRIANGLES;
    def.vertex_count = VERTICES;
    def.threads = self->threads;
    size_t crossings[2] = {0};
    three_searches searches;
    tulle_status status = begin_searches(def, &searches, error);
    for (int end = 0; end < 2 && status == TULLE_OK; end++)
        status = count_crossings(made, end, self->threads, &crossings[end], error);
    if (status == TULLE_OK)
        status = search(&searches, made->positions[0], made->positions[1], error);
    const found_events *const found = searches.found;
    if (status == TULLE_OK)
        fprintf(stream, "%s,%d,%zu,%zu,%zu,%" PRIu64 ",%zu,%" PRIu64 ",%" PRIu64 "\n", motion->name,
                TRIANGLES, crossings[0], crossings[1], found[SEARCH_TRUTH].count,
                found[SEARCH_PAPER].patch_count, found[SEARCH_PAPER].count,
                count_missed(&found[SEARCH_TRUTH], &found[SEARCH_PAPER]),
                count_missed(&found[SEARCH_TRUTH], &found[SEARCH_PROVEN]));
    end_searches(&searches);
    free(made);
    return status;
}

static tulle_status look_at_motions(const reproduce *self, FILE *stream, tulle_error *error) {
    tulle_status status = TULLE_OK;
    fputs("motion,triangles,intersections_start,intersections_end,collisions,paper_patches,"
          "paper_found,paper_missed,proven_missed\n",
          stream);
    for (size_t i = 0; i < sizeof motions / sizeof motions[0] && status == TULLE_OK; i++)
        status = look_at_motion(self, &motions[i], stream, error);
    return status;
}

/* ---- recorded frames ---- */

typedef struct scene_sums {
    uint32_t frames, frames_with_missed;
    uint64_t events, paper_found, paper_missed, proven_missed, patches;
} scene_sums;

static void add_frame(const found_events *found, scene_sums *sums) {
    uint64_t const missed = count_missed(&found[SEARCH_TRUTH], &found[SEARCH_PAPER]);
    sums->frames++;
    sums->frames_with_missed += missed > 0;
    sums->events += found[SEARCH_TRUTH].count;
    sums->paper_found += found[SEARCH_PAPER].count;
    sums->patches += found[SEARCH_PAPER].patch_count;
    sums->paper_missed += missed;
    sums->proven_missed += count_missed(&found[SEARCH_TRUTH], &found[SEARCH_PROVEN]);
}

static tulle_status look_at_frames(reproduce *self, const char *name, reproduce_frames *frames,
                                   three_searches *searches, scene_sums *sums, tulle_error *error) {
    uint32_t const count = frames->info->frame_count;
    uint32_t const stride =
        reproduce_find_stride(count, self->is_quick ? FRAMES_QUICK : FRAMES_FULL);
    tulle_status status = TULLE_OK;
    reproduce_begin_work(self);
    for (uint32_t frame = 1; frame < count && status == TULLE_OK; frame += stride) {
        if (interrupt_is_pending()) status = error_set(error, TULLE_ERROR_INTERRUPTED, "stopped");
        if (status == TULLE_OK) status = reproduce_frames_read(frames, frame, error);
        if (status == TULLE_OK) status = search(searches, frames->start, frames->end, error);
        if (status == TULLE_OK) add_frame(searches->found, sums);
        reproduce_show_work(self, name, frame, count - 1);
    }
    reproduce_end_work(self);
    return status;
}

static tulle_status look_at_run(reproduce *self, const reproduce_run *run, FILE *stream,
                                tulle_error *error) {
    char name[REPRODUCE_PATH_SIZE];
    reproduce_name_run(run, name);
    reproduce_frames frames;
    three_searches searches = {0};
    scene_sums sums = {0};
    tulle_status status = reproduce_frames_open(self, run, false, &frames, error);
    if (status == TULLE_OK)
        status = begin_searches(reproduce_frames_get_def(self, &frames), &searches, error);
    if (status == TULLE_OK) status = look_at_frames(self, name, &frames, &searches, &sums, error);
    if (status == TULLE_OK)
        fprintf(stream, "%s,%u,%.4g,%" PRIu64 ",%.4g,%" PRIu64 ",%" PRIu64 ",%u,%" PRIu64 "\n",
                name, (unsigned)sums.frames, 1000.0 * frames.distance, sums.events,
                (double)sums.patches / (double)sums.frames, sums.paper_found, sums.paper_missed,
                (unsigned)sums.frames_with_missed, sums.proven_missed);
    end_searches(&searches);
    reproduce_frames_close(&frames);
    return status;
}

int reproduce_counterexamples(reproduce *self, const reproduce_figure *figure) {
    tulle_error error = {0};
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    tulle_status status = look_at_motions(self, table.stream, &error);
    int code = reproduce_table_end(self, &table, "counterexamples_motions.csv");
    if (status != TULLE_OK) return reproduce_fail(&error);
    if (code != APP_EXIT_FINE) return code;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("run,frames,contact_distance_mm,events,paper_patches,paper_found,paper_missed,"
          "frames_with_missed,proven_missed\n",
          table.stream);
    for (size_t i = 0; i < figure->run_count && status == TULLE_OK; i++)
        if (reproduce_has_run(self, &figure->runs[i]))
            status = look_at_run(self, &figure->runs[i], table.stream, &error);
    code = reproduce_table_end(self, &table, "counterexamples_scenes.csv");
    return status != TULLE_OK ? reproduce_fail(&error) : code;
}
