/* io/run/run_frames.c - frames.csv: a line for each whole frame. A line is appended after the frame
 * is in all caches, so the whole lines count the whole frames. */
#define _POSIX_C_SOURCE 200809L
#include "io/file_data.h"
#include "io/run/run_record.h"
#include "io/text/json_read.h"
#include "io/text/number.h"

#include <float.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

void run_frames_destroy(run_frames *frames) {
    if (!frames->heap) return;
    ARRAY_FREE(frames->heap, &frames->lines);
    ARRAY_FREE(frames->heap, &frames->absent);
    ARRAY_FREE(frames->heap, &frames->lags);
}

bool run_frames_add(run_frames *frames, const tulle_run_frame *frame, size_t body_count) {
    if (!ARRAY_RESERVE(frames->heap, &frames->lines, 1) ||
        !ARRAY_RESERVE(frames->heap, &frames->absent, body_count) ||
        !ARRAY_RESERVE(frames->heap, &frames->lags, frame->lag_count))
        return false;
    run_frame_line line = {.time = frame->time,
                           .step = frame->step,
                           .state_hash = frame->state_hash,
                           .first_absent = frames->absent.count,
                           .first_lag = frames->lags.count,
                           .lag_count = frame->lag_count};
    for (size_t i = 0; i < body_count; i++)
        if (frame->is_present && !frame->is_present[i])
            frames->absent.data[frames->absent.count++] = (uint32_t)i;
    line.absent_count = frames->absent.count - line.first_absent;
    for (size_t i = 0; i < frame->lag_count; i++)
        frames->lags.data[frames->lags.count++] = frame->lags[i];
    frames->lines.data[frames->lines.count++] = line;
    return true;
}

void run_frames_truncate(run_frames *frames, size_t count) {
    if (count >= frames->lines.count) return;
    frames->absent.count = frames->lines.data[count].first_absent;
    frames->lags.count = frames->lines.data[count].first_lag;
    frames->lines.count = count;
}

bool run_frames_is_present(const run_frames *frames, size_t frame, size_t body) {
    const run_frame_line *const line = &frames->lines.data[frame];
    for (size_t i = 0; i < line->absent_count; i++)
        if (frames->absent.data[line->first_absent + i] == body) return false;
    return true;
}

/* For each body the digits of an index, and of a lag: two more, a count and a double. */
enum { LAG_SIZE = 3 * 11 + 21 + NUMBER_TEXT_SIZE };

size_t run_frames_line_size(size_t body_count) { return 150 + (11 + LAG_SIZE) * body_count; }

size_t run_frames_format_last(const run_frames *frames, char *text, size_t size) {
    size_t const index = frames->lines.count - 1;
    const run_frame_line *const line = &frames->lines.data[index];
    char time[NUMBER_TEXT_SIZE];
    number_format_double(line->time, time);
    size_t length =
        (size_t)snprintf(text, size, "%zu,%s,%llu,%016llx,", index, time,
                         (unsigned long long)line->step, (unsigned long long)line->state_hash);
    for (size_t i = 0; i < line->absent_count && length < size; i++)
        length += (size_t)snprintf(text + length, size - length, "%s%u", i ? " " : "",
                                   frames->absent.data[line->first_absent + i]);
    if (length < size) length += (size_t)snprintf(text + length, size - length, ",");
    for (size_t i = 0; i < line->lag_count && length < size; i++) {
        const tulle_run_lag *const lag = &frames->lags.data[line->first_lag + i];
        char way[NUMBER_TEXT_SIZE];
        number_format_double(lag->lag, way);
        length +=
            (size_t)snprintf(text + length, size - length, "%s%u:%u:%s:%llu", i ? " " : "",
                             lag->body, lag->vertex, way, (unsigned long long)lag->drawn_crossings);
    }
    if (length + 2 > size) return 0;
    memcpy(text + length, "\n", 2);
    return length + 1;
}

/* ---- reading ---- */

/* Text up to the next comma, or to the end of the line. */
static text_word take_field(text_cursor *text, const char *line_end) {
    const char *const comma = memchr(text->at, ',', (size_t)(line_end - text->at));
    const char *const end = comma ? comma : line_end;
    text_word const field = {text->at, (size_t)(end - text->at)};
    text->at = comma ? comma + 1 : line_end;
    return field;
}

static tulle_status take_count(text_cursor *text, text_word word, uint64_t limit, uint64_t *value,
                               tulle_error *error) {
    int64_t number = -1;
    if (number_parse_integer(word.text, word.length, &number) != NUMBER_READ || number < 0 ||
        (uint64_t)number >= limit)
        return text_fail(text, word.text, error, "a whole number from 0 to %llu should be here",
                         (unsigned long long)(limit - 1));
    *value = (uint64_t)number;
    return TULLE_OK;
}

static tulle_status read_absent(run_frames *frames, text_cursor *text, const char *line_end,
                                size_t body_count, tulle_error *error) {
    text_cursor words = *text;
    words.end = line_end;
    for (text_word word = text_take_word(&words); word.length > 0; word = text_take_word(&words)) {
        uint64_t body = 0;
        tulle_status const status = take_count(text, word, body_count, &body, error);
        if (status) return status;
        if (!ARRAY_RESERVE(frames->heap, &frames->absent, 1))
            return file_fail_memory(error, text->path);
        frames->absent.data[frames->absent.count++] = (uint32_t)body;
    }
    text->at = line_end;
    return TULLE_OK;
}

/* BODY:VERTEX:LAG:CROSSINGS */
static tulle_status read_lag(text_cursor *text, text_word word, size_t body_count,
                             tulle_run_lag *lag, tulle_error *error) {
    text_word parts[4];
    const char *const end = word.text + word.length;
    for (int k = 0; k < 4; k++) {
        const char *const colon = memchr(word.text, ':', (size_t)(end - word.text));
        if (!colon != (k == 3))
            return text_fail(text, word.text, error,
                             "a lag should be here: body:vertex:metres:crossings");
        parts[k] = (text_word){word.text, (size_t)((colon ? colon : end) - word.text)};
        word.text = colon ? colon + 1 : end;
    }
    uint64_t body = 0, vertex = 0;
    tulle_status status = take_count(text, parts[0], body_count, &body, error);
    if (!status) status = take_count(text, parts[1], UINT32_MAX, &vertex, error);
    if (!status && (number_parse_double(parts[2].text, parts[2].length, &lag->lag) != NUMBER_READ ||
                    !(lag->lag > 0.0 && lag->lag <= DBL_MAX)))
        status = text_fail(text, parts[2].text, error, "a lag in metres should be here");
    if (!status) status = take_count(text, parts[3], INT64_MAX, &lag->drawn_crossings, error);
    lag->body = (uint32_t)body;
    lag->vertex = (uint32_t)vertex;
    return status;
}

static tulle_status read_lags(run_frames *frames, text_cursor *text, const char *line_end,
                              size_t body_count, tulle_error *error) {
    text_cursor words = *text;
    words.end = line_end;
    for (text_word word = text_take_word(&words); word.length > 0; word = text_take_word(&words)) {
        tulle_run_lag lag = {0};
        tulle_status const status = read_lag(text, word, body_count, &lag, error);
        if (status) return status;
        if (!ARRAY_RESERVE(frames->heap, &frames->lags, 1))
            return file_fail_memory(error, text->path);
        frames->lags.data[frames->lags.count++] = lag;
    }
    text->at = line_end;
    return TULLE_OK;
}

static tulle_status read_line(run_frames *frames, text_cursor *text, const char *line_end,
                              size_t body_count, tulle_error *error) {
    run_frame_line line = {.first_absent = frames->absent.count, .first_lag = frames->lags.count};
    uint64_t index = 0;
    tulle_status status = take_count(text, take_field(text, line_end), INT32_MAX, &index, error);
    if (!status && index != frames->lines.count)
        status = text_fail(text, text->line_start, error, "frame %zu should be here",
                           frames->lines.count);
    if (status) return status;
    text_word const time = take_field(text, line_end);
    if (number_parse_double(time.text, time.length, &line.time) != NUMBER_READ)
        return text_fail(text, time.text, error, "a time in seconds should be here");
    status = take_count(text, take_field(text, line_end), INT64_MAX, &line.step, error);
    if (status) return status;
    text_word const hash = take_field(text, line_end);
    if (!json_parse_hash(hash.text, hash.length, &line.state_hash))
        return text_fail(text, hash.text, error, "hexadecimal digits should be here");
    const char *const comma = memchr(text->at, ',', (size_t)(line_end - text->at));
    if (!comma) return text_fail(text, text->at, error, "the line should have 6 columns");
    status = read_absent(frames, text, comma, body_count, error);
    text->at = comma + 1;
    if (!status) status = read_lags(frames, text, line_end, body_count, error);
    if (status) return status;
    line.lag_count = frames->lags.count - line.first_lag;
    line.absent_count = frames->absent.count - line.first_absent;
    if (!ARRAY_RESERVE(frames->heap, &frames->lines, 1)) return file_fail_memory(error, text->path);
    frames->lines.data[frames->lines.count++] = line;
    return TULLE_OK;
}

static tulle_status read_lines(run_frames *frames, text_cursor *text, size_t body_count,
                               tulle_error *error) {
    size_t const heading = strlen(RUN_FRAMES_HEADING);
    if ((size_t)(text->end - text->at) < heading) return TULLE_OK; /* killed while it was made */
    if (memcmp(text->at, RUN_FRAMES_HEADING, heading) != 0)
        return text_fail(text, NULL, error, "does not begin with \"frame,time,step,...\"");
    text_next_line(text);
    tulle_status status = TULLE_OK;
    while (!status && text->at < text->end) {
        const char *const line_end = memchr(text->at, '\n', (size_t)(text->end - text->at));
        if (!line_end) break; /* killed while it was written */
        status = read_line(frames, text, line_end, body_count, error);
        text_next_line(text);
    }
    return status;
}

tulle_status run_frames_read(run_frames *frames, memory *heap, const char *path, size_t body_count,
                             tulle_error *error) {
    *frames = (run_frames){.heap = heap};
    if (access(path, F_OK) != 0) return TULLE_OK;
    file_data data;
    tulle_status status = file_load(heap, path, 0, &data, error);
    if (status) return status;
    text_cursor text = text_cursor_make(path, data.bytes, data.byte_count);
    status = read_lines(frames, &text, body_count, error);
    file_release(heap, &data);
    return status;
}
