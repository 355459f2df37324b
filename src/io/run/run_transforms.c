/* io/run/run_transforms.c - see run_transforms.h. Numbers have as many digits as give the same
 * double when they are read. */
#include "io/run/run_transforms.h"

#include "io/text/number.h"

#include <stdio.h>
#include <string.h>

#define HEADING "frame,body,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,centre_x,centre_y,centre_z,mass\n"

enum {
    VALUE_COUNT = 17,                               /* numbers of a line after frame and body */
    LINE_SIZE = 32 + VALUE_COUNT * NUMBER_TEXT_SIZE /* [bytes] with the zero */
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
    size_t next = 0;
    for (size_t i = 0; i < record->bodies.count; i++) {
        if (!record->bodies.data[i].is_dynamic) continue;
        char line[LINE_SIZE];
        size_t const length = format_line(frame, i, &transforms[next++], line);
        tulle_status const status = run_log_append(log, line, length, error);
        if (status == TULLE_OK) continue;
        run_log_cut(log);
        return status;
    }
    return TULLE_OK;
}
