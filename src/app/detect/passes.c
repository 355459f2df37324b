/* app/detect/passes.c - see passes.h. */
#include "app/detect/passes.h"

#include "app/cli/progress_bar.h"
#include "base/error.h"
#include "base/sort.h"
#include "base/timer.h"

#include <math.h>
#include <stdlib.h>

static const double SILENT_SECONDS = 1.0; /* work shorter than this shows no progress */

static double get_seconds(const tulle_detect_statistics *statistics, detect_stage stage) {
    switch (stage) {
    case DETECT_STAGE_PATCHES: return statistics->patch_seconds;
    case DETECT_STAGE_TREES: return statistics->tree_seconds;
    case DETECT_STAGE_SEARCH: return statistics->search_seconds;
    case DETECT_STAGE_TRAVERSAL: return statistics->traversal_seconds;
    case DETECT_STAGE_FILTER: return statistics->filter_seconds;
    case DETECT_STAGE_IMPACT: return statistics->impact_seconds;
    case DETECT_STAGE_EVENTS: return statistics->event_seconds;
    default: return statistics->total_seconds;
    }
}

/* Sorts the values; count > 0. */
static double compute_median(double *values, size_t count) {
    qsort(values, count, sizeof *values, compare_doubles);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

/* seconds: of each stage, calls side by side; the first call comes first. */
static void compute_times(detect_passes *passes, double *seconds, size_t call_count) {
    for (int stage = 0; stage < DETECT_STAGE_COUNT; stage++) {
        double *const calls = seconds + (size_t)stage * call_count;
        detect_times *const times = &passes->times[stage];
        times->first = times->median = times->minimum = calls[0];
        if (call_count == 1) continue;
        times->median = compute_median(calls + 1, call_count - 1);
        times->minimum = calls[1];
    }
}

static tulle_status ask(detect_passes *passes, const detect_frames *frames, tulle_error *error) {
    const double *const start = frames->start.positions, *const end = frames->end.positions;
    return passes->is_earliest
               ? tulle_detector_find_earliest(passes->detector, start, end, &passes->result, error)
               : tulle_detector_find_events(passes->detector, start, end, &passes->result, error);
}

static tulle_status ask_repeatedly(detect_passes *passes, const detect_frames *frames,
                                   double *seconds, tulle_error *error) {
    size_t const call_count = (size_t)passes->repeat_count + 1;
    progress_bar bar = progress_bar_begin();
    tulle_status status = TULLE_OK;
    for (size_t call = 0; call < call_count && status == TULLE_OK; call++) {
        status = ask(passes, frames, error);
        for (int stage = 0; stage < DETECT_STAGE_COUNT; stage++)
            seconds[(size_t)stage * call_count + call] =
                get_seconds(&passes->result.statistics, (detect_stage)stage);
        if (timer_now() - bar.begin > SILENT_SECONDS && call + 1 < call_count)
            progress_bar_show(&bar, call + 1, call_count, "%zu of %zu calls", call + 1, call_count);
    }
    progress_bar_clear(&bar);
    if (status == TULLE_OK) compute_times(passes, seconds, call_count);
    return status;
}

static void count_events(detect_passes *passes) {
    passes->earliest_hit = (double)INFINITY;
    for (size_t i = 0; i < passes->result.event_count; i++) {
        const tulle_detect_event *const event = &passes->result.events[i];
        passes->event_counts[event->kind][event->state]++;
        if (event->state != TULLE_DETECT_TOUCHING_AT_START)
            passes->earliest_hit = fmin(passes->earliest_hit, event->time);
    }
}

static int count_batch(void *context, const tulle_detect_event *events, size_t count) {
    (void)events;
    *(uint64_t *)context += count;
    return 0;
}

/* Patches hide the pairs that they save, so these are counted by a search without them: by voxel
 * trees, whose boxes hold whole motions as those of patches do. Refitted trees alone follow paths,
 * which leaves out more pairs. */
static tulle_status search_without_patches(detect_passes *passes, const detect_frames *frames,
                                           tulle_error *error) {
    tulle_detect_def def = passes->def;
    def.method = TULLE_DETECT_BVOX;
    tulle_detector *detector = NULL;
    tulle_status status = tulle_detector_create(&def, &detector, error);
    if (status != TULLE_OK) return status;
    tulle_detect_result result;
    tulle_detect_receiver const receiver = {count_batch, &passes->bare_event_count};
    status = tulle_detector_stream_events(detector, frames->start.positions, frames->end.positions,
                                          receiver, &result, error);
    if (status == TULLE_OK) {
        passes->has_bare_search = true;
        passes->bare_box_pairs = result.statistics.box_pairs;
    }
    tulle_detector_destroy(detector);
    return status;
}

tulle_status detect_passes_run(detect_passes *passes, const detect_frames *frames,
                               tulle_error *error) {
    passes->def.triangles = frames->start.triangles;
    passes->def.triangle_count = frames->start.triangle_count;
    passes->def.vertex_count = frames->start.vertex_count;
    double *const seconds =
        calloc((size_t)DETECT_STAGE_COUNT * ((size_t)passes->repeat_count + 1), sizeof *seconds);
    if (!seconds)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the times of %u calls",
                         (unsigned)passes->repeat_count);
    tulle_status status = tulle_detector_create(&passes->def, &passes->detector, error);
    if (status == TULLE_OK) status = ask_repeatedly(passes, frames, seconds, error);
    free(seconds);
    if (status != TULLE_OK) return status;
    count_events(passes);
    if (passes->is_earliest || !passes->result.statistics.uses_patches) return TULLE_OK;
    return search_without_patches(passes, frames, error);
}

void detect_passes_destroy(detect_passes *passes) {
    tulle_detector_destroy(passes->detector);
    *passes = (detect_passes){0};
}

bool detect_has_patches(const detect_passes *passes) {
    return passes->def.method == TULLE_DETECT_PATCHES || passes->def.method == TULLE_DETECT_PAPER;
}

bool detect_is_complete(const detect_passes *passes) {
    return !passes->is_earliest && (passes->def.has_certificate || !detect_has_patches(passes));
}

uint64_t detect_count_state(const detect_passes *passes, tulle_detect_state state) {
    return passes->event_counts[TULLE_DETECT_VERTEX_FACE][state] +
           passes->event_counts[TULLE_DETECT_EDGE_EDGE][state];
}

uint64_t detect_count_kind(const detect_passes *passes, tulle_detect_kind kind) {
    uint64_t sum = 0;
    for (int state = 0; state < DETECT_STATE_COUNT; state++)
        sum += passes->event_counts[kind][state];
    return sum;
}
