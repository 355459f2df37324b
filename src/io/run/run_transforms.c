/* io/run/run_transforms.c - see run_transforms.h. Numbers have as many digits as give the same
 * double when they are read. */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_transforms.h"

#include "base/error.h"
#include "io/file_data.h"
#include "io/text/number.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define HEADING "frame,body,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,centre_x,centre_y,centre_z,mass\n"

enum {
    VALUE_COUNT = 17,                                /* numbers of a line after frame and body */
    LINE_SIZE = 32 + VALUE_COUNT * NUMBER_TEXT_SIZE, /* [bytes] with the zero */
    CHUNK_SIZE = 1 << 16                             /* [bytes] read at a time */
};

size_t transforms_count_bodies(const run_record *record) {
    size_t count = 0;
    for (size_t i = 0; i < record->bodies.count; i++)
        count += record->bodies.data[i].is_dynamic != 0;
    return count;
}

tulle_status transforms_create(run_log *log, const run_record *record, const char *directory,
                               tulle_error *error) {
    if (transforms_count_bodies(record) == 0) return TULLE_OK;
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_BODIES);
    return run_log_create(log, path, HEADING, strlen(HEADING), error);
}

/* [bytes] of the first line_count lines; false when there are fewer. */
static bool measure_lines(int file, uint64_t line_count, uint64_t *size) {
    char chunk[CHUNK_SIZE];
    uint64_t lines = 0, before = 0;
    for (ssize_t length = 1; length > 0 && lines < line_count; before += (uint64_t)length) {
        length = read(file, chunk, sizeof chunk);
        for (ssize_t i = 0; i < length && lines < line_count; i++) {
            lines += chunk[i] == '\n';
            *size = before + (uint64_t)i + 1;
        }
        if (length < 0) return false;
    }
    return lines == line_count;
}

tulle_status transforms_resume(run_log *log, const run_record *record, const char *directory,
                               uint32_t frame_count, tulle_error *error) {
    size_t const body_count = transforms_count_bodies(record);
    if (body_count == 0) return TULLE_OK;
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_BODIES);
    int const file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) return file_fail(error, path, errno, "cannot be opened");
    uint64_t size = 0;
    bool const is_whole = measure_lines(file, 1 + (uint64_t)frame_count * body_count, &size);
    close(file);
    if (!is_whole)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "holds less than %u frames of %zu bodies, of which the checkpoint "
                            "knows; replace the run",
                            frame_count, body_count);
    return run_log_resume(log, path, size, error);
}

static size_t format_line(uint32_t frame, size_t body, const tulle_transform *transform,
                          char line[LINE_SIZE]) {
    double values[VALUE_COUNT];
    memcpy(values, transform->position, 3 * sizeof(double));
    memcpy(values + 3, transform->rotation, 4 * sizeof(double));
    memcpy(values + 7, transform->velocity, 3 * sizeof(double));
    memcpy(values + 10, transform->angular_velocity, 3 * sizeof(double));
    memcpy(values + 13, transform->centre, 3 * sizeof(double));
    values[16] = transform->mass;
    size_t length = (size_t)snprintf(line, LINE_SIZE, "%u,%zu", frame, body);
    for (int i = 0; i < VALUE_COUNT; i++) {
        line[length++] = ',';
        length += number_format_double(values[i], line + length);
    }
    line[length++] = '\n';
    return length;
}

tulle_status transforms_append(run_log *log, const run_record *record, uint32_t frame,
                               const tulle_transform *transforms, tulle_error *error) {
    uint64_t const before = log->size;
    size_t next = 0;
    for (size_t i = 0; i < record->bodies.count; i++) {
        if (!record->bodies.data[i].is_dynamic) continue;
        char line[LINE_SIZE];
        size_t const length = format_line(frame, i, &transforms[next++], line);
        tulle_status const status = run_log_append(log, line, length, error);
        if (status == TULLE_OK) continue;
        run_log_cut(log, before);
        return status;
    }
    return TULLE_OK;
}
