/* io/animation/expansion.h - how much memory a reader may fill from a file. A mesh may be shown
 * many times, and numbers may be compressed, but nothing is to fill the memory from a small file.
 */
#ifndef TULLE_IO_ANIMATION_EXPANSION_H
#define TULLE_IO_ANIMATION_EXPANSION_H

#include <stdint.h>

/* [bytes] of files of `size` bytes: many times a small file's, fewer times what a large one has
 * more. */
static inline uint64_t expansion_get_limit(uint64_t size) {
    uint64_t const small = UINT64_C(1) << 20, many = 128, few = 16;
    return size <= small ? many * size : many * small + few * (size - small);
}

#endif
