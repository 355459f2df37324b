/* io/animation/animation_read.h - the files that an animation reads beside the one it was opened
 * by.
 */
#ifndef TULLE_IO_ANIMATION_ANIMATION_READ_H
#define TULLE_IO_ANIMATION_ANIMATION_READ_H

#include "tulle_io/animation.h"

size_t animation_get_buffer_count(const tulle_animation *animation);
/* The descriptor of a buffer's file; -1 where the buffer is in memory. */
int animation_get_buffer_file(const tulle_animation *animation, size_t buffer);

#endif
