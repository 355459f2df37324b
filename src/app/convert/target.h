/* app/convert/target.h - what `tulle convert` writes: one mesh file, a point cache, an animation,
 * or numbered files of meshes. One file appears whole or not at all; of numbered files each does.
 */
#ifndef TULLE_APP_CONVERT_TARGET_H
#define TULLE_APP_CONVERT_TARGET_H

#include "app/convert/names.h"
#include "app/convert/source.h"

#include "tulle_io/animation.h"
#include "tulle_io/cache.h"

typedef struct convert_target {
    const char *path; /* as the user gave it */
    convert_format format;
    bool is_numbered;
    name_pattern pattern;     /* of numbered files */
    const char *pvd_path;     /* a collection of numbered VTP files, or null */
    tulle_pc2_writer *writer; /* of a point cache, under the temporary name */
    char temporary[NUMBERED_PATH_SIZE], final[NUMBERED_PATH_SIZE];
    uint32_t written_count;             /* frames */
    uint32_t first_number, last_number; /* of those */
    double worst_rounding;              /* in the output's unit; 0: every number is a float */
} convert_target;

/* Whether a file may be made at `path`. Errors: TULLE_ERROR_INVALID_ARGUMENT. */
tulle_status convert_target_check_place(const char *path, tulle_error *error);
/* Takes the name apart and looks whether files may be made there. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT. */
tulle_status convert_target_open(const char *path, const char *pvd_path, convert_target *target,
                                 tulle_error *error);
/* Whether it is a file of one mesh. */
bool convert_target_is_one_mesh(const convert_target *target);
/* Refuses targets that are read, and several frames for one mesh file. */
tulle_status convert_target_check(const convert_target *target, const convert_source *source,
                                  frame_range frames, tulle_error *error);

/* Looks at positions that are to become floats. Errors: TULLE_ERROR_INVALID_MESH where float cannot
 * hold one. */
tulle_status convert_target_measure(convert_target *target, const double *positions,
                                    size_t vertex_count, tulle_error *error);
/* Writes an animation of the frames: one file for all, or, where
 * names are numbered, for the one frame that there is. */
tulle_status convert_target_write_animation(convert_target *target, frame_range frames,
                                            const tulle_animation_def *def, tulle_error *error);

/* Writes a frame; its positions must be finite. Not for animations. */
tulle_status convert_target_write(convert_target *target, uint32_t frame, tulle_mesh_view mesh,
                                  tulle_error *error);
/* Gives a point cache its name, writes the collection. */
tulle_status convert_target_finish(convert_target *target, const convert_source *source,
                                   frame_range frames, tulle_error *error);
/* Removes what is not finished; null fields are fine. */
void convert_target_close(convert_target *target);

/* Whether positions are rounded to float. */
bool convert_target_is_float(const convert_target *target);
/* Prints which files are there: "out.obj" or "out_0000.vtp to out_0020.vtp, 21 files"; false when
 * none is. */
bool convert_target_describe(const convert_target *target, char *text, size_t size);

#endif
