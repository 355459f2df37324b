/* io/animation/npz_archive.h - arrays of a NumPy archive (.npz) that is read: a ZIP file of .npy
 * files, stored or deflated. Numbers are read where they are; only a window of them is in memory.
 */
#ifndef TULLE_IO_ANIMATION_NPZ_ARCHIVE_H
#define TULLE_IO_ANIMATION_NPZ_ARCHIVE_H

#include "base/memory.h"

#include <zlib.h>

enum {
    NPZ_NAME_SIZE = 32,       /* [bytes] of the names that are looked for */
    NPZ_DIMENSION_MAX = 4,    /* of an array */
    NPZ_WINDOW_SIZE = 1 << 14 /* [bytes] */
};

/* A file of the archive. */
typedef struct npz_entry {
    char name[NPZ_NAME_SIZE];          /* "positions.npy" */
    uint64_t place, packed_size, size; /* [bytes] of its data in the archive, and unpacked */
    uint64_t local;                    /* of the head before them */
    uint32_t sum;
    bool is_deflated, is_unreadable; /* encrypted, or of another method */
} npz_entry;

typedef struct npz_array {
    npz_entry entry;
    char kind;    /* f, i or u */
    size_t width; /* [bytes] of a number */
    bool is_big_endian, is_fortran;
    size_t dimension_count;
    uint64_t shape[NPZ_DIMENSION_MAX];
    uint64_t first; /* [bytes] before the numbers */
    /* Bytes of the entry that have been read, and how far it has been inflated. */
    unsigned char *window;
    uint64_t window_offset;
    size_t window_count;
    z_stream stream;
    unsigned char *packed;
    uint64_t packed_done, unpacked_done;
    bool is_streaming;
} npz_array;

typedef struct npz_archive {
    memory *heap;
    const char *path; /* for messages; must live as long */
    int file;
    uint64_t size, directory, directory_size, entry_count;
} npz_archive;

/* Release with npz_archive_close, also after a failure. */
tulle_status npz_archive_open(memory *heap, const char *path, npz_archive *archive,
                              tulle_error *error);
void npz_archive_close(npz_archive *archive);

/* Finds an array, "positions", checks its sum and reads its head. *is_there: false without an error
 * where there is none. Release with npz_array_close, also after a failure. */
tulle_status npz_array_open(npz_archive *archive, const char *name, npz_array *array,
                            bool *is_there, tulle_error *error);
void npz_array_close(npz_archive *archive, npz_array *array);
/* Reads the number of an index of each dimension, as `at` has them. Indices that rise are quick. */
tulle_status npz_array_read(npz_archive *archive, npz_array *array, const uint64_t *at,
                            double *value, tulle_error *error);
/* An error that names the array. */
tulle_status npz_array_fail(const npz_archive *archive, const npz_array *array, tulle_error *error,
                            const char *format, ...) __attribute__((format(printf, 4, 5)));

#endif
