/* app/cli/frame_range.c - see frame_range.h. */
#include "app/cli/frame_range.h"

#include "base/error.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { AVAILABLE_SIZE = 80 /* [bytes] of a text about the frames there are */ };

/* A range being read. */
typedef struct range_text {
    const char *option, *text; /* as given, for messages */
    const char *at;
    frame_range available;
} range_text;

frame_range frame_range_make(uint32_t frame_count) {
    return (frame_range){.first = 0, .last = frame_count - 1, .step = 1};
}

uint32_t frame_range_get_count(frame_range range) {
    return (range.last - range.first) / range.step + 1;
}

uint32_t frame_range_get(frame_range range, uint32_t index) {
    return range.first + index * range.step;
}

static tulle_status fail_syntax(const range_text *from, tulle_error *error) {
    bool const is_one = strcmp(from->option, "frame") == 0;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "--%s: \"%.40s\" should be %s",
                     from->option, from->text,
                     is_one ? "the number of one frame, as 12, or last"
                            : "N, A:B or A:B:STEP, as 0:120:10, or all; B is included");
}

static const char *describe_available(frame_range available, char text[AVAILABLE_SIZE]) {
    if (available.first == available.last)
        snprintf(text, AVAILABLE_SIZE, "there is frame %u alone", available.first);
    else if (available.step == 1)
        snprintf(text, AVAILABLE_SIZE, "there are frames %u to %u", available.first,
                 available.last);
    else
        snprintf(text, AVAILABLE_SIZE, "there are frames %u to %u, every %uth", available.first,
                 available.last, available.step);
    return text;
}

/* Digits, or `last`. False when neither stands here or the number is too large. */
static bool take_number(range_text *from, uint32_t *number) {
    if (strncmp(from->at, "last", 4) == 0) {
        from->at += 4;
        *number = from->available.last;
        return true;
    }
    const char *const begin = from->at;
    uint64_t value = 0;
    for (; *from->at >= '0' && *from->at <= '9'; from->at++) {
        value = 10 * value + (uint64_t)(*from->at - '0');
        if (value > UINT32_MAX) return false;
    }
    *number = (uint32_t)value;
    return from->at > begin;
}

static bool take_colon(range_text *from) {
    if (*from->at != ':') return false;
    from->at++;
    return true;
}

/* Reads the text; what is left out takes its value from the frames that are there. */
static bool take_range(range_text *from, frame_range *range) {
    *range = from->available;
    if (strcmp(from->at, "all") == 0) return true;
    bool const has_first = *from->at != ':';
    if (has_first && !take_number(from, &range->first)) return false;
    if (!take_colon(from)) {
        range->last = range->first;
        return has_first && *from->at == '\0';
    }
    if (*from->at && *from->at != ':' && !take_number(from, &range->last)) return false;
    if (take_colon(from) && !take_number(from, &range->step)) return false;
    return *from->at == '\0' && range->step > 0;
}

static bool is_available(frame_range available, uint32_t frame) {
    return frame >= available.first && frame <= available.last &&
           (frame - available.first) % available.step == 0;
}

/* Shortens the range to the last frame that it names. */
static tulle_status check_range(const range_text *from, frame_range *range, tulle_error *error) {
    frame_range const available = from->available;
    char there[AVAILABLE_SIZE];
    describe_available(available, there);
    if (!is_available(available, range->first) || range->last > available.last)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--%s %.40s: frame %u does not exist; %s", from->option, from->text,
                         is_available(available, range->first) ? range->last : range->first, there);
    if (range->first > range->last)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--%s %.40s: the range ends before it begins", from->option, from->text);
    if (range->first != range->last && range->step % available.step != 0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--%s %.40s: a step of %u meets frames that do not exist; %s",
                         from->option, from->text, range->step, there);
    range->last = frame_range_get(*range, frame_range_get_count(*range) - 1);
    return TULLE_OK;
}

tulle_status frame_range_read(const char *frame, const char *frames, frame_range available,
                              frame_range *range, tulle_error *error) {
    if (frame && frames)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--frame names one frame and --frames several; give one of them");
    const char *const text = frame ? frame : frames ? frames : "all";
    range_text from = {
        .option = frame ? "frame" : "frames", .text = text, .at = text, .available = available};
    frame_range read;
    if ((frame && (strchr(frame, ':') || strcmp(frame, "all") == 0)) || !take_range(&from, &read))
        return fail_syntax(&from, error);
    tulle_status const status = check_range(&from, &read, error);
    if (status == TULLE_OK) *range = read;
    return status;
}
