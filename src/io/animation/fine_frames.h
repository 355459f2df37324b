/* io/animation/fine_frames.h - frames between the keys of an animation, so many that vertices which
 * go from frame to frame along lines stay near the arcs that turns lead them along. */
#ifndef TULLE_IO_ANIMATION_FINE_FRAMES_H
#define TULLE_IO_ANIMATION_FINE_FRAMES_H

#include "base/memory.h"

/* An animation whose frames are at its keys so far. */
typedef struct fine_frames {
    memory *heap;
    const char *path; /* of the file, for errors */
    void *scene;      /* given to the functions */
    /* Positions of all vertices at a moment, which lies between two keys or at one. */
    tulle_status (*pose)(void *scene, double moment, double *positions, tulle_error *error);
    /* *turn: [rad] at least what turns anything from one key to the next; 0 where all vertices go
     * along lines. */
    tulle_status (*find_turn)(void *scene, double from, double to, double *turn,
                              tulle_error *error);
    size_t *first_vertices; /* of each part, and the number of all: part_count + 1 */
    size_t part_count;
    const double *keys; /* moments, rising */
    size_t key_count;
    uint32_t *cuts;     /* into how many intervals the one behind each key is cut: key_count - 1 */
    size_t added_count; /* frames between keys */
    bool is_cut;        /* turns are so many that some of them are joined by lines */
} fine_frames;

/* Makes room for first_vertices, which the caller fills, and cuts. Release it after a failure, too.
 */
tulle_status fine_frames_make(fine_frames *self, tulle_error *error);
void fine_frames_release(fine_frames *self);
/* Finds into how many intervals each one between two keys is cut evenly, and counts the frames that
 * are added. */
tulle_status fine_frames_find(fine_frames *self, tulle_error *error);
/* Puts numbers evenly between those of the keys; `values` has room for all. */
void fine_frames_spread(const fine_frames *self, double *values);

#endif
