/* io/run/run_checksums_format.h - the text of checksums.csv, shared by its writer and its reader.
 */
#ifndef TULLE_IO_RUN_RUN_CHECKSUMS_FORMAT_H
#define TULLE_IO_RUN_RUN_CHECKSUMS_FORMAT_H

#include "io/run/run_checksums.h"

#include <string.h>

#define CHECKSUMS_HEADING "file,frame,begin,end,hash,chain\n"

enum {
    CHECKSUM_CHAIN_SIZE = 17, /* [bytes] 16 hexadecimal digits and the line's end */
    CHECKSUM_LINE_SIZE = 120  /* [bytes] of a line without its file's name, with room to spare */
};

/* Of a file that has only its heading. */
static inline checksum_mark checksums_get_first_mark(void) {
    size_t const size = strlen(CHECKSUMS_HEADING);
    return (checksum_mark){.size = size, .chain = hash_bytes(HASH_SEED, CHECKSUMS_HEADING, size)};
}

#endif
