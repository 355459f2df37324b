/* io/cache/pc2_format.h - the header of a PC2 point cache: "POINTCACHE2", version 1, counts, start
 * and step in frames; then 3 float32 a vertex and frame; all little endian. */
#ifndef TULLE_IO_CACHE_PC2_FORMAT_H
#define TULLE_IO_CACHE_PC2_FORMAT_H

#include "tulle_io/cache.h"

#include <stdbool.h>

enum {
    PC2_HEADER_SIZE = 32,
    PC2_FRAME_COUNT_PLACE = 28 /* [bytes] offset of the number of frames */
};
#define PC2_COUNT_LIMIT UINT32_C(0x7fffffff)

/* The header of a cache with so many frames. */
void pc2_encode_header(unsigned char header[PC2_HEADER_SIZE], uint32_t vertex_count,
                       uint32_t frame_count);
/* Opens the cache's file and checks header and size; *file is a descriptor the caller closes.
 * may_be_cut: the file may be shorter than the header says; *info then counts the whole frames. */
tulle_status pc2_open_file(const char *path, int flags, bool may_be_cut, int *file,
                           tulle_pc2_info *info, tulle_error *error);
/* [bytes] of so many frames with the header. */
uint64_t pc2_size(uint32_t vertex_count, uint32_t frame_count);

#endif
