/* app/view/record.c - see record.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/view/record.h"

#include "io/file_data.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

bool record_open(view_record *record) {
    const char *folder = getenv("TMPDIR");
    char path[4096];
    atomic_store(&record->byte_count, 0);
    snprintf(path, sizeof path, "%.4000s/tulle_view_XXXXXX", folder && folder[0] ? folder : "/tmp");
    record->file = mkstemp(path);
    if (record->file < 0) return false;
    unlink(path);
    return true;
}

void record_close(view_record *record) {
    if (record->file >= 0) close(record->file);
    record->file = -1;
}

bool record_append(view_record *record, const void *bytes, size_t byte_count) {
    uint64_t const begin = atomic_load(&record->byte_count);
    const char *const from = bytes;
    size_t done = 0;
    if (record->file < 0 || byte_count > RECORD_BYTES_MAX - begin) return false;
    while (done < byte_count) {
        ssize_t const count =
            pwrite(record->file, from + done, byte_count - done, (off_t)(begin + done));
        if (count <= 0) return false;
        done += (size_t)count;
    }
    atomic_store(&record->byte_count, begin + byte_count);
    return true;
}

void record_cut(view_record *record, uint64_t byte_count) {
    if (byte_count == 0) atomic_fetch_add(&record->generation, 1);
    if (byte_count < atomic_load(&record->byte_count))
        atomic_store(&record->byte_count, byte_count);
}

size_t record_read(const view_record *record, void *bytes, size_t byte_count, uint64_t offset) {
    if (record->file < 0) return 0;
    ssize_t const count = file_read_at(record->file, bytes, byte_count, offset);
    return count > 0 ? (size_t)count : 0;
}

static int write_block(void *context, const void *bytes, size_t byte_count) {
    return record_append(context, bytes, byte_count);
}

tulle_record_writer record_get_writer(view_record *record) {
    return (tulle_record_writer){write_block, record};
}
