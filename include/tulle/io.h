/* tulle/io.h - mesh and point-cache files. Every writer writes a temporary name beside the target,
 * then renames: a file appears whole or not at all. Readers name file, line (text) or byte offset
 * (binary) in their errors and have limits on what they allocate: never more than a small multiple
 * of the file's size. */
#ifndef TULLE_IO_H
#define TULLE_IO_H

#include "tulle/base.h"
#include "tulle/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a triangle mesh; the format follows from the contents and the extension (.obj, .ply, .stl).
 * Polygons are triangulated as fans (convexity is not checked). STL corners with the same
 * coordinates become one vertex. Errors: TULLE_ERROR_IO, TULLE_ERROR_PARSE,
 * TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_LIMIT. */
TULLE_API tulle_status tulle_mesh_read(const char *path, tulle_mesh *mesh, tulle_error *error);

/* Writes OBJ, PLY (binary little endian, double) or STL (binary) by extension. OBJ keeps 17
 * significant digits. */
TULLE_API tulle_status tulle_mesh_write(const char *path, tulle_mesh_view mesh, tulle_error *error);

/* A PC2 point cache (float32, as Blender's Mesh Cache modifier reads it), opened for reading. */
typedef struct tulle_pc2 tulle_pc2;
typedef struct tulle_pc2_info {
    uint32_t vertex_count, frame_count;
    double start_frame, frame_step; /* as the header says, in frames */
} tulle_pc2_info;
TULLE_API tulle_status tulle_pc2_open(const char *path, tulle_pc2 **cache, tulle_pc2_info *info,
                                      tulle_error *error);
/* Reads frame `frame` (0 based) into positions, 3 * vertex_count doubles [m]. */
TULLE_API tulle_status tulle_pc2_read_frame(tulle_pc2 *cache, uint32_t frame, double *positions,
                                            tulle_error *error);
TULLE_API void tulle_pc2_close(tulle_pc2 *cache);

/* A PC2 file being written frame by frame. Each append leaves the file valid: data first, then
 * flushed to disk, then the frame count in the header. Opening with `resume_frame_count` > 0 keeps
 * that many frames of an existing file and drops the rest; 0 starts a new file. Doubles are rounded
 * to float here, to nearest. */
typedef struct tulle_pc2_writer tulle_pc2_writer;
TULLE_API tulle_status tulle_pc2_writer_open(const char *path, uint32_t vertex_count,
                                             uint32_t resume_frame_count, tulle_pc2_writer **writer,
                                             tulle_error *error);
TULLE_API tulle_status tulle_pc2_writer_append(tulle_pc2_writer *writer, const double *positions,
                                               tulle_error *error);
/* Appends from now on leave flushing to disk to tulle_pc2_writer_close: faster, and a power failure
 * may lose frames; a killed process loses none. */
TULLE_API void tulle_pc2_writer_defer_flush(tulle_pc2_writer *writer);
TULLE_API tulle_status tulle_pc2_writer_close(tulle_pc2_writer *writer, tulle_error *error);

/* Writes one VTK XML PolyData file (.vtp, base64 binary, float64 points) with optional point data
 * `velocities` [m/s] (may be null). */
TULLE_API tulle_status tulle_vtp_write(const char *path, tulle_mesh_view mesh,
                                       const double *velocities, tulle_error *error);

/* Writes a ParaView collection (.pvd) naming `count` files at the given times [s]; paths relative
 * to the collection. */
TULLE_API tulle_status tulle_pvd_write(const char *path, const char *const *files,
                                       const double *times, size_t count, tulle_error *error);

/* Replaces the file `path` with `byte_count` bytes, whole or not at all (temporary name, fsync,
 * rename). */
TULLE_API tulle_status tulle_file_write(const char *path, const void *bytes, size_t byte_count,
                                        tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
