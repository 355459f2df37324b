/* scene/frame_cache.h - frames of the same vertices in one file: a point cache (PC2, MDD), or an
 * animation, which has triangles, too. */
#ifndef TULLE_SCENE_FRAME_CACHE_H
#define TULLE_SCENE_FRAME_CACHE_H

#include "tulle/mesh.h"
#include "tulle_io/animation.h"
#include "tulle_io/cache.h"

#include <stdbool.h>

/* What a file says of its coordinates. */
typedef struct file_axes {
    bool is_y_up;           /* else z is up */
    double meters_per_unit; /* [m] > 0 */
} file_axes;

typedef struct frame_cache {
    tulle_pc2 *points; /* one of both, or none: it is not open */
    tulle_animation *animation;
    size_t vertex_count, triangle_count;
    uint32_t frame_count;
    bool has_times;
    double start_time; /* [s] when the file's time line begins; 0 where it does not say */
    double start_frame, frame_step; /* of PC2, counted in frames; else 0 and 1 */
    file_axes axes;
    char note[sizeof((tulle_animation_info *)0)->note]; /* what was passed over; or empty */
} frame_cache;

/* Whether the file is an animation, by its extension: that takes long to open, and has triangles.
 */
bool frame_cache_is_animation(const char *path);
/* Opens a file; cache is not open after an error. */
tulle_status frame_cache_open(const char *path, frame_cache *cache, tulle_error *error);
/* Null fields are fine. */
void frame_cache_close(frame_cache *cache);
/* [s] NaN where there is none. */
double frame_cache_get_time(const frame_cache *cache, uint32_t frame);
/* Whether each frame is later than the one before. */
bool frame_cache_rises(const frame_cache *cache);
tulle_status frame_cache_read(frame_cache *cache, uint32_t frame, double *positions,
                              tulle_error *error);
/* Makes a mesh of a frame of an animation. */
tulle_status frame_cache_make_mesh(frame_cache *cache, uint32_t frame, tulle_mesh *mesh,
                                   tulle_error *error);

#endif
