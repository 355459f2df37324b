/* app/convert/rounding.h - whether a surface that does not intersect passes through another or
 * itself where `tulle convert` rounds its positions to float. */
#ifndef TULLE_APP_CONVERT_ROUNDING_H
#define TULLE_APP_CONVERT_ROUNDING_H

#include "app/convert/scene.h"
#include "app/convert/source.h"

/* Gives the positions of a frame of the one surface, as they are written. */
typedef tulle_status (*rounding_reader)(void *context, uint32_t frame, double *positions,
                                        tulle_error *error);

typedef struct convert_rounding {
    bool is_unknown;      /* the mesh cannot be judged; the text says why */
    uint32_t frame_count; /* that are harmed */
    uint32_t first;       /* the first of them */
    char text[512];       /* what happens there: floats "move vertex 3 ..." */
} convert_rounding;

/* What is judged. */
typedef struct rounding_input {
    convert_source *source;
    const axes_change *change;
    frame_range frames;
    tulle_mesh_view mesh;       /* of the one surface */
    rounding_reader read;       /* its positions; null: the source is a run, whose bodies are judged
                                   together, as `change` turns and scales them */
    void *context;              /* of `read` */
    const convert_scene *scene; /* of all bodies of a run, written as an animation; else null */
} rounding_input;

tulle_status convert_rounding_judge(const rounding_input *input, convert_rounding *rounding,
                                    tulle_error *error);

#endif
