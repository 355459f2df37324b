/* app/mend/store.c - see store.h. */
#define _XOPEN_SOURCE 700
#include "app/mend/store.h"

#include "app/cli/numbered_files.h"
#include "base/error.h"
#include "io/file_data.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { VERTEX_SIZE = 3 * sizeof(double) /* [bytes] */ };

tulle_status mend_store_open(const char *path, size_t vertex_count, mend_store *store,
                             tulle_error *error) {
    *store = (mend_store){path, -1, vertex_count};
    char temporary[NUMBERED_PATH_SIZE];
    const char *const slash = strrchr(path, '/');
    int const folder = slash ? (int)(slash - path) + 1 : 0;
    int const length =
        snprintf(temporary, sizeof temporary, "%.*s.tulle-mend.XXXXXX", folder, path);
    if (length < 0 || (size_t)length >= sizeof temporary)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "the path is too long");
    store->file = mkstemp(temporary);
    if (store->file < 0) return file_fail(error, path, errno, "cannot be written");
    unlink(temporary);
    return TULLE_OK;
}

void mend_store_close(mend_store *store) {
    if (store->file >= 0) close(store->file);
    *store = (mend_store){.file = -1};
}

tulle_status mend_store_keep(mend_store *store, uint32_t index, const double *positions,
                             tulle_error *error) {
    size_t const size = store->vertex_count * VERTEX_SIZE;
    for (size_t done = 0; done < size;) {
        ssize_t const count = pwrite(store->file, (const char *)positions + done, size - done,
                                     (off_t)(index * (uint64_t)size + done));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0)
            return file_fail(error, store->path, count < 0 ? errno : EIO,
                             "the frames cannot be kept in the same folder");
        done += (size_t)count;
    }
    return TULLE_OK;
}

tulle_status mend_store_read(const mend_store *store, uint32_t index, size_t first, size_t count,
                             double *positions, tulle_error *error) {
    uint64_t const place = (index * (uint64_t)store->vertex_count + first) * VERTEX_SIZE;
    ssize_t const read = file_read_at(store->file, positions, count * VERTEX_SIZE, place);
    return read == (ssize_t)(count * VERTEX_SIZE)
               ? TULLE_OK
               : file_fail(error, store->path, read < 0 ? errno : EIO,
                           "the frames that were kept cannot be read");
}
