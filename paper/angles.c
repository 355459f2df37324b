/* angles.c - what self-collision detection of a recorded frame costs at a patch angle: by the
 * paper's rules, by patches that are proven, by ours, which live from frame to frame, and without
 * patches; with obstacles too where the line asks for them.
 *
 * One thread is timed by the processor's time, in which other work on the machine hardly counts;
 * several, which wait for one another, by the wall clock.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Fig. 7. */
#define _POSIX_C_SOURCE 200809L
#include "measure.h"
#include "recorded_frames.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The last one knows no angle: the same work at each, and so what the machine's other load does to
 * the times. */
typedef enum rules { RULES_PAPER, RULES_PROVEN, RULES_PATCHES, RULES_BVOX, RULES_COUNT } rules;
static const char *const rules_names[RULES_COUNT] = {"paper", "proven", "patches", "bvox"};

enum { ANGLES_MAX = 90, LINE_SIZE = 64 /* [bytes] */ };
static const long SETTLE_NANOSECONDS =
    200000; /* a sleep brings the processor's account up to date */

/* The detectors of one angle; made when the angle is asked for first. */
typedef struct angle_detectors {
    double angle; /* [degrees] */
    tulle_detector *alone[RULES_COUNT], *with_obstacles[RULES_COUNT];
} angle_detectors;

typedef struct frame_times {
    double partition, trees, traversal, intrinsic, total; /* [s] */
    uint64_t events, patches, patch_triangles;
} frame_times;

typedef struct angle_search {
    const measure_words *words;
    recorded_frames cloth, all; /* without and with obstacles */
    angle_detectors angles[ANGLES_MAX];
    int angle_count;
} angle_search;

static tulle_detect_def use_rules(tulle_detect_def def, rules by, double angle) {
    if (by == RULES_PAPER) return use_paper_rules(def, angle);
    tulle_detect_def made = use_proof(def, angle);
    if (by == RULES_PATCHES) made.method = TULLE_DETECT_PATCHES;
    if (by == RULES_BVOX) made.method = TULLE_DETECT_BVOX;
    return made;
}

static double get_processor_seconds(void) {
    struct timespec const moment = {.tv_nsec = SETTLE_NANOSECONDS};
    struct timespec now;
    nanosleep(&moment, NULL);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* One timed call. A detector that keeps patches is first asked about the frame before, untimed:
 * frames that are looked at do not follow one another. The wall clock tells the stages; they are
 * scaled to make up the total. */
static frame_times ask(const angle_search *search, tulle_detector *detector,
                       const recorded_frames *frames, rules by) {
    tulle_error error = {0};
    tulle_detect_result result = {0};
    if (by == RULES_PATCHES)
        require(tulle_detector_find_events(detector, frames->start, frames->start, &result, &error),
                &error);
    double const begin = get_processor_seconds();
    require(tulle_detector_find_events(detector, frames->start, frames->end, &result, &error),
            &error);
    double const taken = get_processor_seconds() - begin;
    const tulle_detect_statistics *const s = &result.statistics;
    double const total = search->words->threads == 1 ? taken : s->total_seconds;
    double const scale = s->total_seconds > 0.0 ? total / s->total_seconds : 1.0;
    return (frame_times){.partition = scale * s->patch_seconds,
                         .trees = scale * s->tree_seconds,
                         .traversal = scale * s->traversal_seconds,
                         .intrinsic =
                             scale * (s->filter_seconds + s->impact_seconds + s->event_seconds),
                         .total = total,
                         .events = result.event_count,
                         .patches = s->patch_count,
                         .patch_triangles = s->patch_triangles};
}

/* A detector that has once been asked about the frames, untimed: its memory is there, wherever the
 * measurement goes on. */
static tulle_detector *make_detector(const angle_search *search, const recorded_frames *frames,
                                     rules by, double angle) {
    tulle_detect_def const def =
        use_rules(recorded_frames_get_def(frames, search->words->distance, search->words->threads),
                  by, angle);
    tulle_detector *detector = NULL;
    tulle_error error = {0};
    tulle_detect_result result;
    require(tulle_detector_create(&def, &detector, &error), &error);
    require(tulle_detector_find_events(detector, frames->start, frames->end, &result, &error),
            &error);
    return detector;
}

/* The detectors of the angle; the frames hold a motion. */
static angle_detectors *get_detectors(angle_search *search, double angle, bool has_obstacles) {
    int index = 0;
    while (index < search->angle_count && search->angles[index].angle != angle) index++;
    if (index == ANGLES_MAX) {
        fprintf(stderr, "paper_measure: more than %d angles\n", ANGLES_MAX);
        exit(2);
    }
    angle_detectors *const found = &search->angles[index];
    if (index == search->angle_count) {
        search->angle_count++;
        found->angle = angle;
        for (rules by = 0; by < RULES_COUNT; by++)
            found->alone[by] = make_detector(search, &search->cloth, by, angle);
    }
    for (rules by = 0; has_obstacles && by < RULES_COUNT; by++)
        if (!found->with_obstacles[by])
            found->with_obstacles[by] = make_detector(search, &search->all, by, angle);
    return found;
}

/* All rules on one frame, one after the other; a row each. */
static void measure_frame(angle_search *search, uint32_t frame, double angle, bool has_obstacles) {
    recorded_frames_read(&search->cloth, frame);
    if (has_obstacles) recorded_frames_read(&search->all, frame);
    const angle_detectors *const detectors = get_detectors(search, angle, has_obstacles);
    for (rules by = 0; by < RULES_COUNT; by++) {
        frame_times const times = ask(search, detectors->alone[by], &search->cloth, by);
        double const with = has_obstacles
                                ? ask(search, detectors->with_obstacles[by], &search->all, by).total
                                : 0.0;
        printf("%u,%s,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%" PRIu64 ",%" PRIu64 ",%" PRIu64 "\n",
               (unsigned)frame, rules_names[by], times.partition, times.trees, times.traversal,
               times.intrinsic, times.total, with, times.events, times.patches,
               times.patch_triangles);
    }
    fflush(stdout);
}

void measure_angles(const measure_words *words) {
    angle_search *const search = require_memory(sizeof *search);
    *search = (angle_search){.words = words};
    recorded_frames_open(words->run, false, &search->cloth);
    recorded_frames_open(words->run, true, &search->all);
    char line[LINE_SIZE], word[LINE_SIZE];
    while (fgets(line, sizeof line, stdin)) {
        unsigned frame = 0;
        double angle = 0.0;
        int const count = sscanf(line, "%u %lf %63s", &frame, &angle, word);
        if (count < 2 || (count == 3 && strcmp(word, "obstacles") != 0)) {
            fprintf(stderr, "paper_measure: \"%s\" should be FRAME ANGLE [obstacles]\n", line);
            exit(2);
        }
        measure_frame(search, frame, angle, count == 3);
    }
    for (int i = 0; i < search->angle_count; i++)
        for (rules by = 0; by < RULES_COUNT; by++) {
            tulle_detector_destroy(search->angles[i].alone[by]);
            tulle_detector_destroy(search->angles[i].with_obstacles[by]);
        }
    recorded_frames_close(&search->cloth);
    recorded_frames_close(&search->all);
    free(search);
}
