/* io/run/run_transforms_read.c - reads where the rigid bodies of a frame are, from the piece of
 * bodies.csv that checksums.csv names. */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_reader.h"
#include "io/run/run_transforms.h"

#include "base/error.h"
#include "io/text/number.h"
#include "io/text/text_cursor.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

enum { VALUE_COUNT = 19 /* numbers of a line */ };

/* The piece of a frame; null: none is on record. Pieces of a file lie one behind the other: the
 * heading, then a piece for each frame. */
static const checksum_line *find_piece(const tulle_run_reader *reader, uint32_t frame) {
    const checksum_line *const heading = checksums_find(&reader->sums, RUN_FILE_BODIES, 0);
    if (!heading) return NULL;
    size_t const place = (size_t)(heading - reader->sums.lines.data);
    if (frame >= reader->sums.lines.count - place - 1) return NULL;
    const checksum_line *const line = heading + 1 + frame;
    bool const is_it = line->frame == (int64_t)frame && strcmp(line->name, RUN_FILE_BODIES) == 0;
    return is_it ? line : NULL;
}

/* Takes a line of numbers apart. */
static tulle_status parse_line(text_cursor *text, double values[VALUE_COUNT], tulle_error *error) {
    const char *const line_end = memchr(text->at, '\n', (size_t)(text->end - text->at));
    const char *at = text->at, *const end = line_end ? line_end : text->end;
    for (int i = 0; i < VALUE_COUNT; i++) {
        const char *const comma = memchr(at, ',', (size_t)(end - at));
        const char *const stop = i + 1 < VALUE_COUNT ? comma : end;
        if (!stop || number_parse_double(at, (size_t)(stop - at), &values[i]) != NUMBER_READ)
            return text_fail(text, at, error, "here number %d of %d should be", i + 1, VALUE_COUNT);
        at = stop + (stop < end);
    }
    text_next_line(text);
    return TULLE_OK;
}

static tulle_status parse_piece(const tulle_run_reader *reader, uint32_t frame, text_cursor *text,
                                tulle_transform *transforms, tulle_error *error) {
    size_t next = 0;
    for (size_t i = 0; i < reader->record.bodies.count; i++) {
        if (!reader->record.bodies.data[i].is_dynamic) continue;
        double values[VALUE_COUNT];
        tulle_status const status = parse_line(text, values, error);
        if (status) return status;
        if (values[0] != (double)frame || values[1] != (double)i)
            return text_fail(text, NULL, error, "before this line body %zu of frame %u should be",
                             i, frame);
        tulle_transform made = {.mass = values[18]};
        memcpy(made.position, values + 2, sizeof made.position);
        memcpy(made.rotation, values + 5, sizeof made.rotation);
        memcpy(made.velocity, values + 9, sizeof made.velocity);
        memcpy(made.angular_velocity, values + 12, sizeof made.angular_velocity);
        memcpy(made.centre, values + 15, sizeof made.centre);
        transforms[next++] = made;
    }
    return TULLE_OK;
}

/* Reads and compares the bytes of a piece. */
static tulle_status load_piece(const char *path, const checksum_line *line, char *bytes,
                               tulle_error *error) {
    size_t const size = (size_t)(line->sum.end - line->sum.begin);
    int const file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) return file_fail(error, path, errno, "cannot be opened");
    ssize_t const count = file_read_at(file, bytes, size, line->sum.begin);
    int const code = errno;
    close(file);
    if (count < 0) return file_fail(error, path, code, "cannot be read");
    file_sum const sum = {.begin = line->sum.begin,
                          .end = line->sum.begin + (uint64_t)count,
                          .hash = hash_bytes(FILE_SUM_SEED, bytes, (size_t)count)};
    if ((size_t)count == size && sum.hash == line->sum.hash) return TULLE_OK;
    return checksum_fail(path, line->frame, &sum, error);
}

tulle_status tulle_run_reader_read_transforms(tulle_run_reader *reader, uint32_t frame,
                                              tulle_transform *transforms, tulle_error *error) {
    if (!reader || !transforms || frame >= reader->frames.lines.count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no frame %u", frame);
    if (transforms_count_bodies(&reader->record) == 0) return TULLE_OK;
    char path[RUN_PATH_SIZE];
    run_join(path, reader->directory, RUN_FILE_BODIES);
    const checksum_line *const line = find_piece(reader, frame);
    if (!line)
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "the run does not say where its bodies are in frame %u", frame);
    size_t const size = (size_t)(line->sum.end - line->sum.begin);
    char *const bytes = memory_allocate(&reader->heap, size);
    if (!bytes) return file_fail_memory(error, path);
    tulle_status status = load_piece(path, line, bytes, error);
    if (status == TULLE_OK) {
        text_cursor text = text_cursor_make(path, bytes, size);
        status = parse_piece(reader, frame, &text, transforms, error);
    }
    memory_release(&reader->heap, bytes, size);
    return run_reader_blame(reader, status, error);
}
