/* tulle_io/animation.h - surfaces over time in one file. glTF, USD and NPZ are written and read,
 * MDD is written. Builds with TULLE_ALEMBIC also write and read Alembic. docs/guide/formats.md
 * describes what each format holds.
 *
 * A writer asks for frames one by one, as often as it needs them, and keeps one at a time. So its
 * memory does not grow with their positions. A file appears whole or not at all.  */
#ifndef TULLE_IO_ANIMATION_H
#define TULLE_IO_ANIMATION_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a surface moves. */
typedef enum tulle_animation_motion {
    TULLE_ANIMATION_STILL,   /* it stays as it is in the first frame */
    TULLE_ANIMATION_DEFORMS, /* every vertex moves */
    TULLE_ANIMATION_RIGID    /* as a whole, by poses */
} tulle_animation_motion;

/* A surface of an animation. */
typedef struct tulle_animation_surface {
    const char *name;     /* UTF-8, not empty */
    tulle_mesh_view mesh; /* positions are used only if it is rigid: its shape without translation
                             and rotation; else they may be null */
    const double *corner_uvs;      /* 6 * triangle_count, NaN where there are none, as in
                                      tulle_mesh_source; null: none */
    tulle_animation_motion motion; /* how it moves */
    size_t prototype; /* index of the first surface with the same mesh; its own index if no earlier
                         surface has this mesh. Only rigid surfaces may name another surface. 0
                         means surface 0. If that surface has another mesh, the call is refused */
    double color[3];  /* red, green, blue, linear, 0 to 1 */
} tulle_animation_surface;

/* Gives frame number `frame`, from 0, of surface number `surface`. `values` gets 3 * vertex_count
 * finite positions or, for a rigid surface, its pose: translation x, y, z and a unit quaternion w,
 * x, y, z. `context` comes from the def. The same frame may be asked for again. An error ends the
 * writing, which returns it; `error` may be null. */
typedef tulle_status (*tulle_animation_reader)(void *context, size_t surface, uint32_t frame,
                                               double *values, tulle_error *error);

/* An animation to write. Made by tulle_animation_def_default. */
typedef struct tulle_animation_def {
    uint32_t cookie;                         /* set by tulle_animation_def_default */
    const tulle_animation_surface *surfaces; /* surface_count */
    size_t surface_count;                    /* at least 1 */
    const double *times;                     /* [s] of each frame, rising; frame_count */
    uint32_t frame_count;                    /* at least 1 */
    double frame_rate;                       /* [1/s] > 0: USD counts time in 1 / frame_rate */
    int is_y_up;            /* 1: y points up in the positions; 0: z. Said by USD; glTF means y */
    double meters_per_unit; /* [m] > 0, a unit of the positions. Said by USD; glTF means 1 */
    int is_stepped;         /* glTF: 1 holds a frame until the next, 0 goes over to it evenly */
    int is_double;          /* NPZ: 1 writes float64, 0 float32 */
    tulle_animation_reader read; /* gives the frames */
    /* 1 where a surface is in the scene at a frame; null: all surfaces are always there. Only USD
     * holds it */
    int (*is_present)(void *context, size_t surface, uint32_t frame);
    /* NPZ: the name of a further array with one number for each frame and vertex, of the same type
     * as the positions. The name has up to 64 letters, digits and _, and differs from the names of
     * the other arrays. Null: no such array */
    const char *vertex_array;
    tulle_animation_reader read_vertex_array; /* gives vertex_count finite numbers for a frame */
    void *context;                            /* of the functions */
} tulle_animation_def;
/* Metres, z up, 24 frames a second, without surfaces, frames, vertex array or functions. */
TULLE_API tulle_animation_def tulle_animation_def_default(void);

/* Writes an animation to the file `path`. The extension chooses the format: .glb or .gltf with a
 * .bin next to it (glTF 2.0), .usda, .mdd (one surface), .npz or .abc. A single frame is written as
 * static meshes. Positions are rounded to float, except in NPZ with is_double. The rounded
 * positions are not judged: if a gap is smaller than a float step at the largest coordinate (0.06
 * um at 1 m, 0.06 mm at 1 km), surfaces may pass through each other. To find out, call
 * tulle_detector_find_earliest from the exact to the rounded positions. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a value out of range, a motion that the format does not
 * have), TULLE_ERROR_INVALID_MESH (an index out of range, a coordinate that is not finite or that
 * float cannot hold), TULLE_ERROR_LIMIT (more than the format can count), TULLE_ERROR_UNSUPPORTED
 * (another extension), TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL, TULLE_ERROR_OUT_OF_MEMORY, and errors
 * of the reader. */
TULLE_API tulle_status tulle_animation_write(const char *path, const tulle_animation_def *def,
                                             tulle_error *error);

/* ---- reading ---- */

/* An animation that is read: one mesh, whose vertices move from frame to frame. Made by
 * tulle_animation_open, released by tulle_animation_close. */
typedef struct tulle_animation tulle_animation;
/* What the file says. */
typedef struct tulle_animation_info {
    size_t vertex_count;        /* of all surfaces together, at least 1 */
    size_t triangle_count;      /* of all surfaces together */
    uint32_t frame_count;       /* at least 1 */
    uint32_t added_frame_count; /* of these, added between keys: see tulle_animation_open */
    int has_times;     /* 1: frames have times; 0: the file has none, and they are 1/24 s apart */
    double start_time; /* [s] of the file's time line, startTimeCode of USD; 0: it does not say */
    int is_y_up;       /* 1: y points up; 0: z */
    double meters_per_unit; /* [m] > 0, a unit of the positions */
    char note[1024];        /* parts of the file that were ignored; or empty */
} tulle_animation_info;

/* Opens the file `path`, .glb or .gltf (glTF 2.0), .usda, .npz or .abc. It makes `*animation`,
 * which is null after an error, and fills `info`, which may be null. All surfaces of the scene are
 * read in order, as one mesh in the scene's coordinates. Vertices are moved by morph targets, node
 * transforms and skins of glTF, and by points and transforms of USD. The frames are at the key
 * times of the first animation (glTF), at the time samples of the visible surfaces (USD, Alembic),
 * or as in the archive (NPZ). A file without motion has one frame. Where something turns or follows
 * a cubic spline, frames are added evenly between two keys. So a vertex that moves in straight
 * lines from frame to frame stays near its path, within a thousandth of its surface's size. At a
 * step of glTF a frame is added just before the key, with the old value. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_IO, TULLE_ERROR_PARSE, TULLE_ERROR_UNSUPPORTED
 * (another file extension; a required glTF extension that is not known; binary USD),
 * TULLE_ERROR_LIMIT, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_animation_open(const char *path, tulle_animation **animation,
                                            tulle_animation_info *info, tulle_error *error);
/* Triangles of the mesh, 3 * triangle_count vertices; owned by the animation. Null if there are no
 * triangles, and for null. */
TULLE_API const uint32_t *tulle_animation_get_triangles(const tulle_animation *animation);
/* [s] of frame number `frame`, from 0; NaN for null and where there is no such frame. */
TULLE_API double tulle_animation_get_time(const tulle_animation *animation, uint32_t frame);
/* Reads frame number `frame`, from 0, into `positions`, 3 * vertex_count. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, no such frame), TULLE_ERROR_IO, TULLE_ERROR_PARSE,
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_animation_read_frame(tulle_animation *animation, uint32_t frame,
                                                  double *positions, tulle_error *error);
/* Releases an animation. Null is fine. */
TULLE_API void tulle_animation_close(tulle_animation *animation);

#ifdef __cplusplus
}
#endif
#endif
