/* app/convert/source.h - what `tulle convert` reads: a mesh file, a point cache with the mesh that
 * it moves, an animation, a body of a run, or numbered mesh files. All frames have the same
 * vertices and triangles. */
#ifndef TULLE_APP_CONVERT_SOURCE_H
#define TULLE_APP_CONVERT_SOURCE_H

#include "app/cli/axes.h"
#include "app/cli/frame_range.h"
#include "app/cli/mesh_file.h"
#include "app/cli/numbered_files.h"

#include "tulle_io/animation.h"
#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"
#include "tulle_io/run.h"

#include <stdbool.h>
#include <sys/types.h>

typedef enum source_kind {
    SOURCE_MESH,
    SOURCE_CACHE,
    SOURCE_RUN,
    SOURCE_FILES,
    SOURCE_ANIMATION
} source_kind;

/* A file, whatever it is called. */
typedef struct file_identity {
    dev_t device;
    ino_t node;
} file_identity;

typedef struct convert_source {
    source_kind kind;
    const char *path;        /* as the user gave it */
    tulle_mesh mesh;         /* at rest, or in the first frame; no triangles: points alone */
    frame_range frames;      /* that there are */
    bool needs_frames_named; /* the frames there are have gaps, so not all can be meant */
    uint32_t gap;            /* the first of them */
    tulle_pc2 *cache;
    tulle_pc2_info cache_info;
    tulle_animation *animation;
    tulle_animation_info animation_info;
    tulle_run_reader *run;
    bool borrows_run; /* it is that of another source */
    size_t body;
    numbered_files files;
    tulle_mesh_source described; /* by the mesh file; of numbered files the first */
    file_identity *inputs;       /* all files that are read */
    size_t input_count;
    bool keeps_mesh; /* every frame is `mesh` */
} convert_source;

typedef struct source_options {
    const char *path;
    const char *mesh_path; /* --mesh, or null */
    const char *body;      /* --body, or null */
    bool takes_all;        /* of a run without --body all bodies are meant; the first is opened */
} source_options;

/* Opens what the options name; release with convert_source_close, also after a failure. */
tulle_status convert_source_open(const source_options *options, convert_source *source,
                                 tulle_error *error);
void convert_source_close(convert_source *source);
/* Opens a body of the run that another source reads, which must be closed later. */
tulle_status convert_source_open_body(const convert_source *run, size_t body,
                                      convert_source *source, tulle_error *error);

/* Positions of a frame, 3 * mesh.vertex_count, finite. */
tulle_status convert_source_read(convert_source *source, uint32_t frame, double *positions,
                                 tulle_error *error);
/* From now on every frame is `mesh`, which was changed; what the file says of its triangles is
 * forgotten. */
void convert_source_keep_mesh(convert_source *source);
/* Gives *time [s] of a frame that has one, in a run, an animation or an MDD cache; NaN for the
 * others. */
tulle_status convert_source_find_time(const convert_source *source, uint32_t frame, double *time,
                                      tulle_error *error);
/* How its coordinates are meant: as `options` say, whose fields may be null, or the file; z up and
 * metres where neither does. Errors: TULLE_ERROR_INVALID_ARGUMENT for another unit of the file. */
tulle_status convert_source_find_axes(const convert_source *source, axes_frame options,
                                      axes_frame *axes, tulle_error *error);
/* From what the file says to z up and metres, as scenes take it; its unit may be any. */
axes_change convert_source_find_scene_change(const convert_source *source);
/* The name of the body, or of the file. */
const char *convert_source_get_name(const convert_source *source);
/* Whether the path names a file that is read. */
bool convert_source_reads(const convert_source *source, const char *path);
/* Frames of a range in which the body of a run is not in the scene. */
uint32_t convert_source_count_absent(const convert_source *source, frame_range frames);
/* Prints the line "from" of the report; has_all: of a run no body in particular is meant. */
void convert_source_print(const convert_source *source, bool has_all);

#endif
