/* io/run/run_rounding.h - whether a frame survives the rounding to float of its point caches.
 *
 * Files hold floats, so vertices move a little where they are written. That motion is searched for
 * collisions like any other: a surface that ends up wholly on the wrong side of another has passed
 * through it on the way, and is found though nothing intersects in the file. */
#ifndef TULLE_IO_RUN_RUN_ROUNDING_H
#define TULLE_IO_RUN_RUN_ROUNDING_H

#include "base/memory.h"

#include "tulle/detect.h"
#include "tulle_io/run.h"

#include <stdbool.h>

/* All bodies of a run as one mesh. */
typedef struct run_rounding {
    memory *heap;
    tulle_detector *detector;       /* null until a frame is judged */
    tulle_detect_surface *surfaces; /* of each body */
    uint32_t *triangles;            /* of vertices of the one mesh */
    double *exact, *rounded;        /* 3 * vertex_count; static bodies are not rounded */
    size_t body_count, vertex_count, triangle_count;
    int threads;
    const char *unit; /* of positions, in messages: m, unless another is set */
} run_rounding;

/* False when memory is short; release it then, too. */
bool run_rounding_make(run_rounding *rounding, memory *heap, const tulle_run_def *def);
void run_rounding_release(run_rounding *rounding);
/* Judges the positions of a frame, which moving bodies have. `written`: null, or of each body where
 * a file will have it, or null where that is its positions as floats. TULLE_ERROR_LIMIT where
 * rounding leads a surface through another or itself; the message ends a sentence: floats "move
 * vertex 3 ...". Frames that intersect before they are rounded are none of its business. */
tulle_status run_rounding_judge(run_rounding *rounding, const tulle_run_frame *frame,
                                const double *const *written,
                                const char *(*get_name)(const void *context, size_t body),
                                const void *context, tulle_error *error);

#endif
