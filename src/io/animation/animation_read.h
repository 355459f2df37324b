/* io/animation/animation_read.h - what the readers of animations have in common, and the files that
 * an animation reads beside the one it was opened by. */
#ifndef TULLE_IO_ANIMATION_ANIMATION_READ_H
#define TULLE_IO_ANIMATION_ANIMATION_READ_H

#include "base/memory.h"

#include "tulle_io/animation.h"

/* What was passed over where turns are too many to follow. */
#define ANIMATION_TOO_FAST "the arcs of turns that need more than 65536 frames"

/* What a reader found. Its arrays live as long as its state. */
typedef struct animation_content {
    tulle_animation_info info;
    const uint32_t *triangles; /* 3 * info.triangle_count */
    const double *times;       /* [s] info.frame_count */
    size_t file_count;         /* read beside the one that was opened, or with it */
} animation_content;

/* Adds a part to the note of what is passed over, with commas between the parts. */
void animation_add_note(tulle_animation_info *info, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The reader of a format. */
typedef struct animation_reader {
    const char *extensions[3]; /* from the second one on they may be null */
    size_t state_size;         /* [bytes] of the state, zeroed at first */
    /* Opens a file; `path` and the heap live as long as the state. close follows, also after a
     * failure. */
    tulle_status (*open)(memory *heap, const char *path, void *state, animation_content *content,
                         tulle_error *error);
    tulle_status (*read)(void *state, uint32_t frame, double *positions, tulle_error *error);
    void (*close)(void *state);
    /* The descriptor of such a file. Null where there are none. */
    int (*get_file)(const void *state, size_t number);
} animation_reader;

extern const animation_reader gltf_reader, usd_reader, npz_reader, alembic_reader;

size_t animation_get_file_count(const tulle_animation *animation);
int animation_get_file(const tulle_animation *animation, size_t number);

#endif
