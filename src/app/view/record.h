/* app/view/record.h - bytes that are kept of a live scene, in files without a name: the recording
 * of the world's calls, and the script of what was done by hand. They cost no memory, and are gone
 * with the program. One thread writes; another may read what was there when it asked. */
#ifndef TULLE_APP_VIEW_RECORD_H
#define TULLE_APP_VIEW_RECORD_H

#include "app/view/buffer.h"

#include "tulle/record.h"

#include <stdatomic.h>

typedef struct view_record {
    int file; /* -1: none */
    atomic_ullong byte_count;
    atomic_uint generation; /* counts how often it began anew */
} view_record;

/* [bytes] A recording ends there: hours of a scene. */
#define RECORD_BYTES_MAX ((uint64_t)4 << 30)

bool record_open(view_record *record);
void record_close(view_record *record);
/* False where the disk is full, or beyond RECORD_BYTES_MAX. */
bool record_append(view_record *record, const void *bytes, size_t byte_count);
/* Forgets all from `byte_count` on. */
void record_cut(view_record *record, uint64_t byte_count);
/* Reads up to `byte_count` bytes from `offset` on; the number read, 0 at the end or after an error.
 */
size_t record_read(const view_record *record, void *bytes, size_t byte_count, uint64_t offset);
/* What tulle_world_record takes. */
tulle_record_writer record_get_writer(view_record *record);

#endif
