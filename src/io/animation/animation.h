/* io/animation/animation.h - what the writers of animations share: one frame of one surface at a
 * time, as floats, with bounds and normals. */
#ifndef TULLE_IO_ANIMATION_ANIMATION_H
#define TULLE_IO_ANIMATION_ANIMATION_H

#include "base/memory.h"
#include "io/output_file.h"

#include "tulle_io/animation.h"

/* An animation on its way to a file. */
typedef struct animation_job {
    const tulle_animation_def *def;
    const char *path; /* for messages */
    memory heap;
    size_t vertex_limit; /* of the largest surface */
    double *positions;   /* of the frame at hand, 3 * vertex_limit */
    double *sums;        /* of normals, the same */
    float *points, *normals;
} animation_job;

/* Reads a frame of a surface to job->positions and, rounded to float, to job->points. Refuses what
 * is not finite. Rigid surfaces give the positions of their mesh. */
tulle_status animation_read(animation_job *job, size_t surface, uint32_t frame, tulle_error *error);
/* The pose of a rigid surface, 7 numbers; the quaternion is of length 1. */
tulle_status animation_read_pose(animation_job *job, size_t surface, uint32_t frame, double pose[7],
                                 tulle_error *error);
/* Unit normals of job->points, into job->normals: of a vertex the mean of the triangles around,
 * weighted by their areas; +z where these cancel or there are none. */
void animation_compute_normals(animation_job *job, size_t surface);
/* Least and largest coordinates of job->points. */
void animation_measure_bounds(const animation_job *job, size_t surface, float low[3],
                              float high[3]);
/* Whether frames differ: there are several, and the surface does not stand still. */
bool animation_is_moving(const tulle_animation_def *def, size_t surface);

/* The writers of each format; the def has been checked. */
tulle_status gltf_write(animation_job *job, bool is_binary, tulle_error *error);
tulle_status usd_write(animation_job *job, tulle_error *error);
tulle_status mdd_write(animation_job *job, tulle_error *error);
tulle_status npz_write(animation_job *job, tulle_error *error);
tulle_status alembic_write(animation_job *job, tulle_error *error);

#endif
