/* io/run/run_debug_format.h - the bytes of debug.bin, shared by its writer and its reader. All
 * little endian. */
#ifndef TULLE_IO_RUN_RUN_DEBUG_FORMAT_H
#define TULLE_IO_RUN_RUN_DEBUG_FORMAT_H

#include "io/run/run_debug.h"

enum {
    DEBUG_HEAD_SIZE = 16, /* [bytes] magic of 8 bytes, version, 0 */
    DEBUG_VERSION = 1,
    /* header of a block, by offset [bytes] */
    DEBUG_PLACE_MAGIC = 0,
    DEBUG_PLACE_FRAME = 4,
    DEBUG_PLACE_SIZE = 8, /* of the whole block */
    DEBUG_PLACE_PAYLOAD_HASH = 16,
    DEBUG_PLACE_CONTACTS = 24,
    DEBUG_PLACE_KNOWN = 28,       /* 0: nothing; 1: all; 2: velocities alone */
    DEBUG_PLACE_HEADER_HASH = 32, /* of all before it */
    DEBUG_HEADER_SIZE = 40,
    DEBUG_CONTACT_SIZE = 84, /* objects 2, vertices 4, flags 1, floats 14, of 4 bytes each */
    /* flags of a contact */
    DEBUG_FLAG_EDGES = 1,
    DEBUG_STATE_SHIFT = 1,
    DEBUG_STATE_MASK = 3,
    DEBUG_FLAG_NEW = 8,
    DEBUG_FLAG_HARD = 16,
    DEBUG_FLAGS_END = 32
};

#define DEBUG_MAGIC "TULLEDBG"
#define DEBUG_BLOCK_MAGIC "DBGF"

/* [bytes] of a label where there are so many patches. */
static inline size_t debug_label_size(uint32_t patch_count) {
    return patch_count < 1u << 8 ? 1 : patch_count < 1u << 16 ? 2 : 4;
}

/* Whether a contact's objects, vertices and kinds are those of the run's bodies. */
bool debug_contact_fits(const tulle_contact *contact, const run_record *record);

#endif
