/* fuzz/support/animation.h - what the targets of animations share. */
#ifndef TULLE_FUZZ_ANIMATION_H
#define TULLE_FUZZ_ANIMATION_H

#include <stddef.h>
#include <stdint.h>

/* Opens the bytes as a file of that name, and reads its first frames. */
void fuzz_read_animation(const char *name, const uint8_t *data, size_t size);
/* Puts an animation of that name among the seeds: a cloth, and with poses a rigid body, too. */
void fuzz_make_animation_seed(const char *name, int has_poses);

#endif
