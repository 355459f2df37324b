/* app/detect/passes.h - asks a detector the same question once or several times, and what came of
 * it: the events, counts and times that `tulle detect` reports. */
#ifndef TULLE_APP_DETECT_PASSES_H
#define TULLE_APP_DETECT_PASSES_H

#include "app/detect/frames.h"

#include "tulle/detect.h"

#include <stdbool.h>

enum { DETECT_REPEAT_MAX = 100000, DETECT_KIND_COUNT = 2, DETECT_STATE_COUNT = 3 };

typedef enum detect_stage {
    DETECT_STAGE_PATCHES,
    DETECT_STAGE_TREES,
    DETECT_STAGE_SEARCH,
    DETECT_STAGE_TRAVERSAL, /* this and the next two: parts of the search */
    DETECT_STAGE_FILTER,
    DETECT_STAGE_IMPACT,
    DETECT_STAGE_EVENTS,
    DETECT_STAGE_TOTAL,
    DETECT_STAGE_COUNT
} detect_stage;

/* [s] of the first call; median and minimum of the further calls, or the first's without any. */
typedef struct detect_times {
    double first, median, minimum;
} detect_times;

typedef struct detect_passes {
    tulle_detect_def def;
    uint32_t repeat_count; /* further calls after the first */
    bool is_earliest;      /* only the earliest event is asked for */

    tulle_detector *detector;   /* owns the events of the result */
    tulle_detect_result result; /* of the last call */
    detect_times times[DETECT_STAGE_COUNT];
    uint64_t event_counts[DETECT_KIND_COUNT][DETECT_STATE_COUNT];
    double earliest_hit; /* of the events that do not touch at the start; infinite without */
    /* The same search without patches, once, untimed; only after a call that used patches. */
    bool has_bare_search;
    uint64_t bare_box_pairs, bare_event_count;
} detect_passes;

/* Runs them; def, repeat_count and is_earliest are set, all else is zero. To be destroyed also
 * after a failure. Errors: those of the detector. */
tulle_status detect_passes_run(detect_passes *passes, const detect_frames *frames,
                               tulle_error *error);
void detect_passes_destroy(detect_passes *passes);

/* Whether the method has patches. */
bool detect_has_patches(const detect_passes *passes);
/* Whether nothing can be missing among the events. */
bool detect_is_complete(const detect_passes *passes);
uint64_t detect_count_state(const detect_passes *passes, tulle_detect_state state);
uint64_t detect_count_kind(const detect_passes *passes, tulle_detect_kind kind);

#endif
