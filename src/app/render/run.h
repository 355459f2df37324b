/* app/render/run.h - a run as something to be drawn: its bodies with their looks, and the surfaces
 * of one frame at a time. */
#ifndef TULLE_APP_RENDER_RUN_H
#define TULLE_APP_RENDER_RUN_H

#include "app/cli/frame_range.h"
#include "app/render/camera.h"
#include "app/render/options.h"
#include "base/arena.h"
#include "render/render.h"

#include "tulle/mesh.h"
#include "tulle_io/run.h"
#include "tulle_io/subdivision.h"

/* A cloth or an obstacle. */
typedef struct picture_body {
    const char *name;
    bool is_obstacle, is_moving;
    bool is_present;                /* in the frame */
    bool is_hidden;                 /* left out of the pictures */
    bool is_ever_absent;            /* from one of the frames that were looked at */
    tulle_mesh_view rest;           /* as its OBJ file holds it */
    tulle_mesh_view mesh;           /* in the frame, as simulated */
    tulle_mesh_view drawn;          /* the same, or subdivided */
    double *positions;              /* of mesh; null where the body never moves */
    double *drawn_positions;        /* of drawn, where it is subdivided */
    double *rest_coordinates;       /* of drawn; null: no pattern */
    tulle_subdivision *subdivision; /* null: none */
    scene_look look;
    render_surface surface; /* all but what changes from frame to frame */
} picture_body;

typedef struct picture_run {
    memory heap;
    arena storage;
    const picture_options *options;
    tulle_run_reader *reader;
    const tulle_run_info *info;
    scene_picture picture;
    frame_range frames; /* those to be drawn */
    picture_body *bodies;
    size_t body_count, cloth_count; /* cloths come first */
    uint32_t frame;                 /* read last */
    picture_view view;              /* what the camera is to see */
    double cloth_size;              /* [m] diagonal of the cloths' box over the frames */
    double edge_length;             /* [m] mean of the cloths' edges */
    uint32_t floor_body;            /* ground that the floor stands for; TULLE_NONE: none */
    bool has_floor;
    double floor_height; /* [m] */
} picture_run;

/* Opens the run with its looks and prepares its bodies; the view and the floor follow from all
 * chosen frames. Errors: those of the reader; TULLE_ERROR_INVALID_ARGUMENT (no frames, no such
 * frame); those of the scene file in the run, whose problems are printed before. picture_run_close
 * also after a failure. */
tulle_status picture_run_open(picture_run *run, const picture_options *options, tulle_error *error);
void picture_run_close(picture_run *run);

/* Reads positions and presence of all bodies, subdivided where asked for. */
tulle_status picture_run_read_frame(picture_run *run, uint32_t frame, tulle_error *error);

/* At most `most` of the chosen frames, spread evenly, the first and the last among them: how many
 * there are, and the one of index `index`. */
uint32_t picture_run_get_sample_count(const picture_run *run, uint32_t most);
uint32_t picture_run_get_sample(const picture_run *run, uint32_t most, uint32_t index);

/* ---- looks (looks.c) ---- */

/* Fills the surfaces of all bodies: colors, pattern, creases. */
void picture_dress_bodies(picture_run *run);
/* sRGB, as scenes give colors, to linear RGB. */
void picture_make_linear(const double srgb[3], float linear[3]);
/* Finds the ground or the height of the floor; `low` is the lowest z of everything, `cloths` the
 * box of the cloths over the frames. */
void picture_choose_floor(picture_run *run, const picture_bounds *cloths, double low);
render_lighting picture_get_lighting(const picture_run *run);

#endif
