/* support/recording.h - recordings in memory for tests: a writer, and the blocks that one has,
 * found by the lengths in their heads alone. */
#ifndef TULLE_TEST_RECORDING_H
#define TULLE_TEST_RECORDING_H

#include "tulle/tulle.h"

#include <stdlib.h>
#include <string.h>

/* Bytes that a world's recording is written to. */
typedef struct recording {
    unsigned char *bytes;
    size_t byte_count;
    int blocks_left; /* the writer takes so many more blocks; below 0: any number */
} recording;

static inline int recording_write(void *context, const void *bytes, size_t byte_count) {
    recording *const self = context;
    if (self->blocks_left-- == 0) return 0;
    unsigned char *const grown = realloc(self->bytes, self->byte_count + byte_count);
    if (!grown) return 0;
    memcpy(grown + self->byte_count, bytes, byte_count);
    self->bytes = grown;
    self->byte_count += byte_count;
    return 1;
}

static inline tulle_record_writer recording_begin(recording *self) {
    *self = (recording){.blocks_left = -1};
    return (tulle_record_writer){recording_write, self};
}

/* The block at `place`: its kind and the place behind it. 0 where no whole one is. */
static inline int recording_next(const unsigned char *bytes, size_t byte_count, size_t *place,
                                 uint32_t *kind) {
    uint64_t length = 0;
    if (byte_count - *place < 24) return 0;
    for (int i = 7; i >= 0; i--) length = length << 8 | bytes[*place + (size_t)i];
    if (length > byte_count - *place - 24) return 0;
    *kind = bytes[*place + 8];
    *place += 24 + (size_t)length;
    return 1;
}

#endif
