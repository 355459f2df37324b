/* tulle_io/cache.h - point caches: the positions of one body at every frame. docs/guide/formats.md
 * describes the format. */
#ifndef TULLE_IO_CACHE_H
#define TULLE_IO_CACHE_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A point cache that is read, PC2 or MDD: floats, as Blender's Mesh Cache modifier reads them. Made
 * by tulle_pc2_open, released by tulle_pc2_close. */
typedef struct tulle_pc2 tulle_pc2;
/* What the header of a point cache says. */
typedef struct tulle_pc2_info {
    uint32_t vertex_count; /* vertices of each frame */
    uint32_t frame_count;  /* frames in the file */
    double start_frame;    /* number of the first frame; 0 of MDD */
    double frame_step;     /* frames from one to the next; 1 of MDD */
} tulle_pc2_info;
/* Opens the file `path`: MDD if the name ends in .mdd, otherwise PC2. It makes `*cache`, which is
 * null after an error, and fills `info`, which may be null. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null), TULLE_ERROR_IO, TULLE_ERROR_PARSE, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_pc2_open(const char *path, tulle_pc2 **cache, tulle_pc2_info *info,
                                      tulle_error *error);
/* Reads frame number `frame`, from 0, into `positions`, 3 * vertex_count doubles [m]. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, no such frame), TULLE_ERROR_IO, TULLE_ERROR_PARSE (the file
 * became shorter, a coordinate that is not finite). */
TULLE_API tulle_status tulle_pc2_read_frame(tulle_pc2 *cache, uint32_t frame, double *positions,
                                            tulle_error *error);
/* Gives `*time` [s] of frame number `frame`, from 0, as an MDD file has it; NaN of PC2, which has
 * none. Errors: as of tulle_pc2_read_frame. */
TULLE_API tulle_status tulle_pc2_get_time(const tulle_pc2 *cache, uint32_t frame, double *time,
                                          tulle_error *error);
/* Releases a cache. Null is fine. */
TULLE_API void tulle_pc2_close(tulle_pc2 *cache);

/* A PC2 file being written. Made by tulle_pc2_writer_open, released by tulle_pc2_writer_close. */
typedef struct tulle_pc2_writer tulle_pc2_writer;
/* Opens the PC2 file `path` for frames of `vertex_count` vertices and makes `*writer`, which is
 * null after an error. `resume_frame_count` > 0 keeps that many frames of an existing file and
 * drops the rest; 0 starts a new file. Errors: TULLE_ERROR_INVALID_ARGUMENT (null; no vertices, or
 * more than 2^31 - 1), TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL, TULLE_ERROR_PARSE,
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_pc2_writer_open(const char *path, uint32_t vertex_count,
                                             uint32_t resume_frame_count, tulle_pc2_writer **writer,
                                             tulle_error *error);
/* Appends a frame: `positions`, 3 * vertex_count doubles [m], rounded to the nearest floats. The
 * file is valid after each append: data is written first and flushed to disk, then the frame count
 * in the header. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a coordinate that float cannot hold),
 * TULLE_ERROR_LIMIT (more than 2^31 - 1 frames), TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL. */
TULLE_API tulle_status tulle_pc2_writer_append(tulle_pc2_writer *writer, const double *positions,
                                               tulle_error *error);
/* Leaves flushing to disk to tulle_pc2_writer_close, for all appends that follow. This is faster. A
 * power failure may then lose frames; a killed process loses none. Null is fine. */
TULLE_API void tulle_pc2_writer_defer_flush(tulle_pc2_writer *writer);
/* Flushes the file to disk and releases the writer, also when that fails. Null is fine. Errors:
 * TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL. */
TULLE_API tulle_status tulle_pc2_writer_close(tulle_pc2_writer *writer, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
