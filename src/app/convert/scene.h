/* app/convert/scene.h - the surfaces that `tulle convert` writes as an animation: one, or all
 * bodies of a run. */
#ifndef TULLE_APP_CONVERT_SCENE_H
#define TULLE_APP_CONVERT_SCENE_H

#include "app/cli/axes.h"
#include "app/cli/frame_progress.h"
#include "app/convert/source.h"
#include "app/convert/target.h"

typedef struct scene_options {
    bool takes_all;             /* all bodies of the source, which is a run */
    const char *fps;            /* --fps, or null */
    const char *up;             /* of what is written: "y" or "z" */
    double meters_per_unit;     /* of the same */
    bool is_stepped, is_double; /* as in tulle_animation_def */
    const axes_change *change;
} scene_options;

/* Gives positions of a frame of the one surface, as they are to be written. */
typedef tulle_status (*scene_reader)(void *context, uint32_t frame, double *positions,
                                     tulle_error *error);

/* What is known of a surface beside what is written. */
typedef struct scene_body {
    convert_source source; /* borrows the run */
    double *mesh;          /* positions of a rigid one without its poses; null: others */
    size_t number;         /* of a rigid one among the rigid bodies of the run */
} scene_body;

typedef struct convert_scene {
    convert_source *source;
    const axes_change *change;
    convert_target *target;
    frame_range frames;   /* that are converted */
    uint32_t first_index; /* of the frames at hand among those */
    double *times;        /* [s] of all of them */
    tulle_animation_surface *surfaces;
    scene_body *bodies; /* of each surface, where all bodies of a run are meant; else null */
    size_t count;       /* surfaces */
    double *poses;      /* 7 numbers of each rigid body of the run, frame after frame */
    size_t rigid_count;
    bool ignores_times;                    /* those of the source do not rise */
    frame_progress *progress;              /* of an animation that is written; null: is not shown */
    uint64_t readings_done, reading_count; /* of frames that move vertices */
    bool is_reading;                       /* a failure is one of the source */
    scene_reader read, read_array;         /* of the one surface; the latter or null */
    void *context;
    tulle_animation_def def;
} convert_scene;

/* Prepares to write frames of the source, with all bodies of the run, or with one surface, which
 * convert_scene_set_surface then gives. Release with convert_scene_close, also after a failure. */
tulle_status convert_scene_open(convert_scene *scene, convert_source *source,
                                convert_target *target, const scene_options *options,
                                frame_range frames, tulle_error *error);
/* Makes one surface of what `read` gives. */
void convert_scene_set_surface(convert_scene *scene, tulle_mesh_view mesh, const double *corner_uvs,
                               scene_reader read, void *context);
/* Adds an array of one number for each of its vertices, which .npz alone has. */
void convert_scene_add_array(convert_scene *scene, const char *name, scene_reader read);
void convert_scene_close(convert_scene *scene);
/* Where a reader of the file finds a rigid surface in one of `frames`: its mesh of floats, turned
 * and moved by its pose as the file has it. Positions: 3 * its vertices. */
void convert_scene_place_rigid(const convert_scene *scene, size_t surface, uint32_t index,
                               double *positions);

/* Writes frames: all, or one of those that the scene was opened for. */
tulle_status convert_scene_write(convert_scene *scene, frame_range frames, tulle_error *error);

#endif
