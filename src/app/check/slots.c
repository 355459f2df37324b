/* app/check/slots.c - see slots.h. */
#include "app/check/slots.h"

#include "base/error.h"

#include <stdio.h>

size_t check_slots_count(frame_range range, int threads) {
    size_t const frame_count = frame_range_get_count(range);
    return (size_t)threads < frame_count ? (size_t)threads : frame_count;
}

/* Prints the judged slots in order up to the first that failed. */
static tulle_status report_slots(check_slots *slots, size_t count, const check_report *report,
                                 check_totals *totals, tulle_error *error) {
    tulle_status status = TULLE_OK;
    frame_progress_clear(&slots->progress);
    for (size_t slot = 0; slot < count; slot++) {
        check_frame *const frame = &slots->frames[slot];
        if (status == TULLE_OK && frame->status != TULLE_OK)
            status = error_set_at(error, frame->status, slots->source, 0, 0, "frame %ld: %s",
                                  frame->number, frame->error.message);
        else if (status == TULLE_OK)
            check_report_frame(report, frame, totals);
        tulle_check_result_destroy(&frame->result);
    }
    if (report->is_json) fflush(stdout); /* programs read the lines while frames are judged */
    return status;
}

tulle_status check_slots_judge(check_slots *slots, frame_range range, const check_report *report,
                               check_totals *totals, tulle_error *error) {
    uint32_t const frame_count = frame_range_get_count(range);
    tulle_status status = TULLE_OK;
    slots->progress = frame_progress_begin("check", NULL);
    if (report->is_json && slots->progress.kind == PROGRESS_LINES)
        slots->progress.kind = PROGRESS_NONE; /* its lines on standard output tell how far it is */
    for (uint32_t first = 0; first < frame_count && status == TULLE_OK;) {
        size_t count = 0;
        while (count < slots->count && first + count < frame_count && status == TULLE_OK) {
            status = slots->read(slots->context, count,
                                 frame_range_get(range, first + (uint32_t)count), error);
            if (status == TULLE_OK) count++;
        }
        check_frames_judge(slots->frames, count, slots->threads);
        tulle_status const judged = report_slots(slots, count, report, totals, error);
        if (judged != TULLE_OK) status = judged;
        first += (uint32_t)count;
        frame_progress_show(&slots->progress, first, frame_count);
    }
    frame_progress_clear(&slots->progress);
    return status;
}
