/* app/reproduce_fig7_measure.c - what self-collision detection of a recorded frame costs at one
 * patch angle, by the paper's rules, by patches that are proven and by ours; with obstacles too at
 * some angles. Each frame's times are kept in measured/fig7_ANGLE.csv under the conditions, the run
 * and the angle that they were measured with.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Fig. 7. */
#include "app/cli/interrupt.h"
#include "app/reproduce_fig7.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/timer.h"

#include <inttypes.h>

enum { PARTS = 9 };
const char *const fig7_rules_names[FIG7_RULES] = {"paper", "proven", "patches", "bvox"};

static tulle_detect_def use_rules(tulle_detect_def def, fig7_rules by, double angle) {
    if (by == FIG7_PAPER) return reproduce_use_paper_rules(def, angle);
    tulle_detect_def made = reproduce_use_proof(def, angle);
    if (by == FIG7_PATCHES) made.method = TULLE_DETECT_PATCHES;
    if (by == FIG7_BVOX) made.method = TULLE_DETECT_BVOX;
    return made;
}

tulle_status fig7_pass_begin(fig7_pass *pass, const char *label, tulle_error *error) {
    char frames[REPRODUCE_TEXT_SIZE], head[2 * REPRODUCE_TEXT_SIZE], file[64];
    reproduce_frames_describe(&pass->frames->cloth, frames);
    snprintf(head, sizeof head,
             "# conditions %s build %s %s angle %g%s\n"
             "frame,rules,partition,trees,traversal,intrinsic,total,with_obstacles,events,patches,"
             "patch_triangles\n",
             pass->self->conditions, pass->self->build, frames, pass->angle,
             pass->has_obstacles ? " obstacles" : "");
    snprintf(file, sizeof file, "measured/fig7_%s%g.csv", label, pass->angle);
    return reproduce_kept_open(pass->self, file, head, &pass->kept, error);
}

/* The stages, which the wall clock tells, make up `total`. */
static fig7_times get_times(const tulle_detect_result *result, double total) {
    const tulle_detect_statistics *const s = &result->statistics;
    double const scale = s->total_seconds > 0.0 ? total / s->total_seconds : 1.0;
    return (fig7_times){.partition = scale * s->patch_seconds,
                        .trees = scale * s->tree_seconds,
                        .traversal = scale * s->traversal_seconds,
                        .intrinsic =
                            scale * (s->filter_seconds + s->impact_seconds + s->event_seconds),
                        .total = total,
                        .events = result->event_count,
                        .patches = s->patch_count,
                        .patch_triangles = s->patch_triangles};
}

/* One timed call. A detector that keeps patches is first asked about the frame before, untimed:
 * frames that are looked at do not follow one another. One thread is timed by the processor's time,
 * in which other work on the machine hardly counts; several, which wait for one another, by the
 * wall clock. */
static tulle_status ask(const fig7_pass *pass, tulle_detector *detector,
                        const reproduce_frames *frames, bool warms_up, fig7_times *times,
                        tulle_error *error) {
    bool const is_alone = parallel_resolve_threads(pass->self->threads) == 1;
    tulle_detect_result result = {0};
    tulle_status status = TULLE_OK;
    if (warms_up)
        status = tulle_detector_find_events(detector, frames->start, frames->start, &result, error);
    double const begin = timer_processor_now();
    if (status == TULLE_OK)
        status = tulle_detector_find_events(detector, frames->start, frames->end, &result, error);
    double const taken = timer_processor_now() - begin;
    if (status == TULLE_OK)
        *times = get_times(&result, is_alone ? taken : result.statistics.total_seconds);
    return status;
}

/* A detector that has once been asked about the frames, untimed: its memory is there, wherever the
 * measurement goes on. */
static tulle_status make_detector(const fig7_pass *pass, const reproduce_frames *frames,
                                  fig7_rules by, tulle_detector **detector, tulle_error *error) {
    tulle_detect_def const def =
        use_rules(reproduce_frames_get_def(pass->self, frames), by, pass->angle);
    fig7_times ignored;
    tulle_status const status = tulle_detector_create(&def, detector, error);
    return status == TULLE_OK ? ask(pass, *detector, frames, false, &ignored, error) : status;
}

static tulle_status make_detectors(fig7_pass *pass, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (fig7_rules by = 0; by < FIG7_RULES && status == TULLE_OK; by++) {
        status = make_detector(pass, &pass->frames->cloth, by, &pass->detectors[by], error);
        if (status == TULLE_OK && pass->has_obstacles)
            status = make_detector(pass, &pass->frames->all, by, &pass->with_obstacles[by], error);
    }
    pass->is_begun = true;
    return status;
}

static tulle_status read_frames(fig7_frames *frames, uint32_t frame, tulle_error *error) {
    if (frames->frame == frame) return TULLE_OK;
    tulle_status status = reproduce_frames_read(&frames->cloth, frame, error);
    if (status == TULLE_OK) status = reproduce_frames_read(&frames->all, frame, error);
    frames->frame = status == TULLE_OK ? frame : 0;
    return status;
}

/* All detectors on one frame, one after the other. */
static tulle_status measure(fig7_pass *pass, uint32_t frame, fig7_times times[FIG7_RULES],
                            tulle_error *error) {
    tulle_status status = read_frames(pass->frames, frame, error);
    if (status == TULLE_OK && !pass->is_begun) status = make_detectors(pass, error);
    for (fig7_rules by = 0; by < FIG7_RULES && status == TULLE_OK; by++) {
        bool const warms_up = by == FIG7_PATCHES;
        fig7_times with = {0};
        status = ask(pass, pass->detectors[by], &pass->frames->cloth, warms_up, &times[by], error);
        if (status == TULLE_OK && pass->has_obstacles)
            status =
                ask(pass, pass->with_obstacles[by], &pass->frames->all, warms_up, &with, error);
        times[by].with_obstacles = with.total;
    }
    return status;
}

static bool find(fig7_pass *pass, uint32_t frame, fig7_rules by, fig7_times *times) {
    char key[64];
    snprintf(key, sizeof key, "%u,%s,", (unsigned)frame, fig7_rules_names[by]);
    const char *const row = reproduce_kept_find(&pass->kept, key);
    int length = 0;
    return row &&
           sscanf(row, "%lf,%lf,%lf,%lf,%lf,%lf,%" SCNu64 ",%" SCNu64 ",%" SCNu64 "%n",
                  &times->partition, &times->trees, &times->traversal, &times->intrinsic,
                  &times->total, &times->with_obstacles, &times->events, &times->patches,
                  &times->patch_triangles, &length) == PARTS &&
           reproduce_kept_is_end(row, length);
}

static tulle_status keep(fig7_pass *pass, uint32_t frame, const fig7_times times[FIG7_RULES],
                         tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (fig7_rules by = 0; by < FIG7_RULES && status == TULLE_OK; by++) {
        const fig7_times *const t = &times[by];
        status = reproduce_kept_add(
            &pass->kept, error,
            "%u,%s,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%" PRIu64 ",%" PRIu64 ",%" PRIu64 "\n",
            (unsigned)frame, fig7_rules_names[by], t->partition, t->trees, t->traversal,
            t->intrinsic, t->total, t->with_obstacles, t->events, t->patches, t->patch_triangles);
    }
    return status;
}

tulle_status fig7_pass_look(fig7_pass *pass, uint32_t frame, fig7_times times[FIG7_RULES],
                            tulle_error *error) {
    bool is_there = true;
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "stopped");
    for (fig7_rules by = 0; by < FIG7_RULES && is_there; by++)
        is_there = find(pass, frame, by, &times[by]);
    if (is_there) {
        reproduce_skip_work(pass->self);
        return TULLE_OK;
    }
    bool const is_first = !pass->is_begun; /* saved at once: the file is there from the first on */
    tulle_status status = measure(pass, frame, times, error);
    if (status == TULLE_OK) status = keep(pass, frame, times, error);
    return status == TULLE_OK && is_first ? reproduce_kept_save(&pass->kept, error) : status;
}

tulle_status fig7_pass_end(fig7_pass *pass, tulle_status status, tulle_error *error) {
    if (!pass->self) return status;
    tulle_error ignored = {0};
    tulle_status const saved =
        reproduce_kept_save(&pass->kept, status == TULLE_OK ? error : &ignored);
    for (fig7_rules by = 0; by < FIG7_RULES; by++) {
        tulle_detector_destroy(pass->detectors[by]);
        tulle_detector_destroy(pass->with_obstacles[by]);
    }
    reproduce_kept_close(&pass->kept);
    return status == TULLE_OK ? saved : status;
}
