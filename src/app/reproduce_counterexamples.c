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
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "app/reproduce_kept.h"
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
enum { FRAMES_QUICK = 50, FRAMES_FULL = 600, COUNTS = 5 /* of a frame, in its row */ };

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

/* What was found in one frame. */
typedef struct frame_counts {
    uint64_t events, patches, paper_found, paper_missed, proven_missed;
} frame_counts;

typedef struct scene_sums {
    uint32_t frames, frames_with_missed;
    frame_counts counts;
} scene_sums;

static void add_frame(const frame_counts *counts, scene_sums *sums) {
    sums->frames++;
    sums->frames_with_missed += counts->paper_missed > 0;
    sums->counts.events += counts->events;
    sums->counts.patches += counts->patches;
    sums->counts.paper_found += counts->paper_found;
    sums->counts.paper_missed += counts->paper_missed;
    sums->counts.proven_missed += counts->proven_missed;
}

/* One run: its frames, the searches, and what was counted in each frame, which is kept. */
typedef struct scene_look {
    reproduce *self;
    char name[REPRODUCE_PATH_SIZE]; /* of the run */
    reproduce_frames frames;
    three_searches searches;
    bool has_searches; /* they are made when the first frame has to be looked at */
    reproduce_kept kept;
} scene_look;

static tulle_status open_kept(scene_look *look, tulle_error *error) {
    char frames[REPRODUCE_TEXT_SIZE], head[2 * REPRODUCE_TEXT_SIZE], file[2 * REPRODUCE_PATH_SIZE];
    reproduce_frames_describe(&look->frames, frames);
    snprintf(head, sizeof head,
             "# build %s %s angle %g\n"
             "frame,events,paper_patches,paper_found,paper_missed,proven_missed\n",
             look->self->build, frames, BEST_ANGLE);
    snprintf(file, sizeof file, "measured/counterexamples_%s.csv", look->name);
    return reproduce_kept_open(look->self, file, head, &look->kept, error);
}

static bool find_counts(scene_look *look, uint32_t frame, frame_counts *counts) {
    char key[16];
    snprintf(key, sizeof key, "%u,", (unsigned)frame);
    const char *const row = reproduce_kept_find(&look->kept, key);
    int length = 0;
    return row &&
           sscanf(row, "%" SCNu64 ",%" SCNu64 ",%" SCNu64 ",%" SCNu64 ",%" SCNu64 "%n",
                  &counts->events, &counts->patches, &counts->paper_found, &counts->paper_missed,
                  &counts->proven_missed, &length) == COUNTS &&
           reproduce_kept_is_end(row, length);
}

static tulle_status search_frame(scene_look *look, uint32_t frame, frame_counts *counts,
                                 tulle_error *error) {
    tulle_status status = reproduce_frames_read(&look->frames, frame, error);
    if (status == TULLE_OK && !look->has_searches)
        status = begin_searches(reproduce_frames_get_def(look->self, &look->frames),
                                &look->searches, error);
    look->has_searches = true;
    if (status == TULLE_OK)
        status = search(&look->searches, look->frames.start, look->frames.end, error);
    if (status != TULLE_OK) return status;
    const found_events *const found = look->searches.found;
    *counts =
        (frame_counts){.events = found[SEARCH_TRUTH].count,
                       .patches = found[SEARCH_PAPER].patch_count,
                       .paper_found = found[SEARCH_PAPER].count,
                       .paper_missed = count_missed(&found[SEARCH_TRUTH], &found[SEARCH_PAPER]),
                       .proven_missed = count_missed(&found[SEARCH_TRUTH], &found[SEARCH_PROVEN])};
    return reproduce_kept_add(&look->kept, error,
                              "%u,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 "\n",
                              (unsigned)frame, counts->events, counts->patches, counts->paper_found,
                              counts->paper_missed, counts->proven_missed);
}

static tulle_status look_at_frame(scene_look *look, uint32_t frame, frame_counts *counts,
                                  tulle_error *error) {
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "stopped");
    if (!find_counts(look, frame, counts)) return search_frame(look, frame, counts, error);
    reproduce_skip_work(look->self);
    return TULLE_OK;
}

static tulle_status look_at_frames(scene_look *look, scene_sums *sums, tulle_error *error) {
    uint32_t const count = look->frames.info->frame_count;
    uint32_t const most = look->self->is_quick ? FRAMES_QUICK : FRAMES_FULL;
    uint32_t const stride = reproduce_find_stride(count, most);
    tulle_status status = TULLE_OK;
    reproduce_begin_work(look->self);
    for (uint32_t frame = 1; frame < count && status == TULLE_OK; frame += stride) {
        frame_counts counts = {0};
        status = look_at_frame(look, frame, &counts, error);
        if (status == TULLE_OK) add_frame(&counts, sums);
        reproduce_show_work(look->self, look->name, sums->frames,
                            reproduce_count_looks(count, most));
    }
    reproduce_end_work(look->self);
    tulle_error ignored = {0};
    tulle_status const saved =
        reproduce_kept_save(&look->kept, status == TULLE_OK ? error : &ignored);
    return status == TULLE_OK ? saved : status;
}

static tulle_status look_at_run(reproduce *self, const reproduce_run *run, FILE *stream,
                                tulle_error *error) {
    scene_look look = {.self = self};
    scene_sums sums = {0};
    reproduce_name_run(run, look.name);
    tulle_status status = reproduce_frames_open(self, run, false, &look.frames, error);
    if (status == TULLE_OK) status = open_kept(&look, error);
    if (status == TULLE_OK) status = look_at_frames(&look, &sums, error);
    const frame_counts *const of = &sums.counts;
    if (status == TULLE_OK)
        fprintf(stream, "%s,%u,%.4g,%" PRIu64 ",%.4g,%" PRIu64 ",%" PRIu64 ",%u,%" PRIu64 "\n",
                look.name, (unsigned)sums.frames, 1000.0 * look.frames.distance, of->events,
                (double)of->patches / (double)sums.frames, of->paper_found, of->paper_missed,
                (unsigned)sums.frames_with_missed, of->proven_missed);
    end_searches(&look.searches);
    reproduce_kept_close(&look.kept);
    reproduce_frames_close(&look.frames);
    return status;
}

static int make_motions(const reproduce *self) {
    tulle_error error = {0};
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    tulle_status const status = look_at_motions(self, table.stream, &error);
    int const code = status == TULLE_OK ? APP_EXIT_FINE : reproduce_fail(&error);
    return reproduce_table_finish(self, &table, "counterexamples_motions.csv", code);
}

int reproduce_counterexamples(reproduce *self, const reproduce_figure *figure) {
    tulle_error error = {0};
    reproduce_table table;
    int code = make_motions(self);
    if (code != APP_EXIT_FINE) return code;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("run,frames,contact_distance_mm,events,paper_patches,paper_found,paper_missed,"
          "frames_with_missed,proven_missed\n",
          table.stream);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < figure->run_count && status == TULLE_OK; i++)
        if (reproduce_has_run(self, &figure->runs[i]))
            status = look_at_run(self, &figure->runs[i], table.stream, &error);
    if (status != TULLE_OK) code = reproduce_fail(&error);
    return reproduce_table_finish(self, &table, "counterexamples_scenes.csv", code);
}
