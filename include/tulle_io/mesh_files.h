/* tulle_io/mesh_files.h - mesh files. docs/guide/formats.md describes the formats.
 *
 * A writer writes to a temporary file in the target's directory, then renames it: a file appears
 * whole or not at all. A reader names the file and the line, or the byte of a binary file, in its
 * errors. It never allocates more than a small multiple of the file's size. */
#ifndef TULLE_IO_MESH_FILES_H
#define TULLE_IO_MESH_FILES_H

#include "tulle/base.h"
#include "tulle/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the triangle mesh in the file `path`; release it with tulle_mesh_destroy. The format
 * follows from the contents and the extension (.obj, .ply, .stl). A polygon of n corners becomes n
 * - 2 triangles that lie within it. They form a fan around its first corner if that fan lies within
 * the polygon, as in a convex polygon. A polygon that crosses itself becomes a fan. The note of
 * tulle_mesh_read_source reports it, and also a polygon that is not flat. STL corners with the same
 * coordinates become one vertex. Errors: TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_IO,
 * TULLE_ERROR_PARSE, TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_LIMIT (also for a polygon of more than
 * 10,000 corners that is not convex). */
TULLE_API tulle_status tulle_mesh_read(const char *path, tulle_mesh *mesh, tulle_error *error);

/* What names a part of an OBJ file. */
typedef enum tulle_mesh_part_kind {
    TULLE_MESH_PART_GROUP,   /* g or o */
    TULLE_MESH_PART_MATERIAL /* usemtl */
} tulle_mesh_part_kind;
/* Triangles that follow each other in an OBJ file and have a name in common. */
typedef struct tulle_mesh_part {
    const char *name;          /* as in the file; several words of o and usemtl have one blank
                                * between them */
    tulle_mesh_part_kind kind; /* what gave the name */
    size_t first;              /* number of the first triangle, as the file has them */
    size_t count;              /* number of triangles, at least 1 */
} tulle_mesh_part;

/* Further contents of a mesh file. Release with tulle_mesh_source_destroy. */
typedef struct tulle_mesh_source {
    size_t vertex_count;      /* vertices of the file */
    size_t triangle_count;    /* triangles of the file */
    uint32_t *vertex_lines;   /* line of each vertex in an OBJ file, from 1; else null */
    uint32_t *triangle_lines; /* line of each triangle in an OBJ file, from 1; else null */
    /* 6 * triangle_count: texture coordinates u, v of the corners of each triangle, `vt` of OBJ and
     * the vertex properties s, t (or u, v, or texture_u, texture_v) of PLY; NaN at a corner without
     * any. Null where no corner has any */
    double *corner_uvs;
    /* part_count parts of an OBJ file, in the order of their ends; a name may have several, and
     * they overlap. Null where no triangle has a name */
    tulle_mesh_part *parts;
    size_t part_count; /* number of parts */
    char *part_names;  /* the names of the parts, each with a 0 behind it; null as parts */
    size_t part_bytes; /* [bytes] of part_names */
    /* hash of the polygons of an OBJ or PLY file before they were cut: files with the same hash
     * have the same faces, though their cuts may differ; else 0 */
    uint64_t polygons_hash;
    char note[1024]; /* parts of the file that were ignored, and polygons that are not flat or cross
                        themselves: kinds, how many, first lines; or empty */
    int has_passed_shape; /* 1: the note names more than names, normals, textures, materials */
} tulle_mesh_source;
/* Reads the mesh in the file `path`, as tulle_mesh_read does, and fills `source`, which may be null
 * and is empty after an error. Errors as of tulle_mesh_read. */
TULLE_API tulle_status tulle_mesh_read_source(const char *path, tulle_mesh *mesh,
                                              tulle_mesh_source *source, tulle_error *error);
/* Releases the arrays and zeroes the struct. Null and empty sources are fine. */
TULLE_API void tulle_mesh_source_destroy(tulle_mesh_source *source);

/* Writes a mesh to the file `path`, as OBJ, PLY or STL by its extension. OBJ has the fewest digits
 * that read back to the same double, PLY is binary, little endian, in doubles, STL is binary.
 * Errors: TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL, TULLE_ERROR_INVALID_ARGUMENT (null, also an array
 * of the mesh), TULLE_ERROR_INVALID_MESH (an index out of range, a coordinate that the format
 * cannot hold), TULLE_ERROR_UNSUPPORTED (another extension), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_write(const char *path, tulle_mesh_view mesh, tulle_error *error);

/* Parts of a VTP file that are ignored. */
typedef struct tulle_vtp_passed_over {
    uint64_t vertex_cells; /* points drawn as dots */
    uint64_t lines;        /* lines and polylines */
    char polygons[256];    /* how many are not flat or cross themselves, and the first; or empty */
} tulle_vtp_passed_over;

/* Reads the polygons of the VTK XML PolyData file `path` (.vtp), as ParaView and VTK write them;
 * release the mesh with tulle_mesh_destroy. The points and polygons of all pieces are read, and
 * polygons are cut as by tulle_mesh_read. Vertices, lines, and point, cell and field data are
 * passed over. `passed_over` counts vertices and lines, and describes polygons; null is fine.
 * Errors name the line: TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_IO, TULLE_ERROR_PARSE,
 * TULLE_ERROR_UNSUPPORTED (triangle strips), TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_LIMIT (more
 * than 2^31 - 1 points or triangles, a polygon as of tulle_mesh_read, or zlib data that expand too
 * much). */
TULLE_API tulle_status tulle_vtp_read(const char *path, tulle_mesh *mesh,
                                      tulle_vtp_passed_over *passed_over, tulle_error *error);

/* Writes a mesh to the VTK XML PolyData file `path` (.vtp; float64 points in base64), with the
 * point data `velocities` [m/s], 3 for each vertex, or null. Errors as of tulle_mesh_write. */
TULLE_API tulle_status tulle_vtp_write(const char *path, tulle_mesh_view mesh,
                                       const double *velocities, tulle_error *error);

/* Writes the ParaView collection `path` (.pvd), which names `count` `files` at their `times` [s].
 * Paths are relative to the collection. With a `count` of 0 both arrays may be null. Paths may not
 * be null. Errors as of tulle_mesh_write. */
TULLE_API tulle_status tulle_pvd_write(const char *path, const char *const *files,
                                       const double *times, size_t count, tulle_error *error);

/* Replaces the file `path` with `byte_count` bytes from `bytes`, whole or not at all: it writes to
 * a temporary name, flushes to disk, and renames. With a `byte_count` of 0 `bytes` may be null.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL. */
TULLE_API tulle_status tulle_file_write(const char *path, const void *bytes, size_t byte_count,
                                        tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
