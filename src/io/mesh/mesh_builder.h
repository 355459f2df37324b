/* io/mesh/mesh_builder.h - a mesh that grows while a file is read. */
#ifndef TULLE_IO_MESH_MESH_BUILDER_H
#define TULLE_IO_MESH_MESH_BUILDER_H

#include "base/memory.h"
#include "geom/cut_polygon.h"
#include "io/file_data.h"

#include "tulle_io/mesh_files.h"

/* What began a part; a statement ends those of its kind. */
typedef enum part_kind { PART_GROUP, PART_OBJECT, PART_MATERIAL, PART_KIND_COUNT } part_kind;
typedef struct named_part {
    part_kind kind;
    size_t name;         /* its place in the names */
    size_t first, count; /* triangles; the count is known at the end */
} named_part;

typedef struct mesh_builder {
    memory *heap;
    ARRAY(double) positions;
    ARRAY(uint32_t) triangles;
    uint32_t fan_first, fan_last; /* of the polygon at hand */
    size_t fan_count;
    ARRAY(polygon_fan) fans; /* of more than one triangle, to be cut when all vertices are known */
    polygon_cutter cutter;
    uint64_t polygons_hash; /* of the fans, from mesh_builder_finish on */
    /* Texture coordinates that corners may name, and those of the corners of triangles: numbers
     * from 0, or MESH_NO_UV. */
    bool keeps_uvs;
    ARRAY(double) uvs;
    ARRAY(uint32_t) corner_uvs;
    uint32_t fan_first_uv, fan_last_uv;
    bool keeps_parts;
    ARRAY(named_part) parts; /* that have ended and have triangles */
    /* That triangles to come belong to, by their kind. */
    ARRAY(named_part) open_parts[PART_KIND_COUNT];
    ARRAY(char) part_names;
    bool keeps_lines; /* of vertices and triangles, for messages */
    uint32_t line;    /* of the file, or number of the polygon, set by the reader */
    ARRAY(uint32_t) vertex_lines;
    ARRAY(uint32_t) triangle_lines;
} mesh_builder;

mesh_builder mesh_builder_make(memory *heap);
void mesh_builder_destroy(mesh_builder *builder);

/* False when memory is short. */
bool mesh_builder_add_vertex(mesh_builder *builder, const double position[3]);
size_t mesh_builder_get_vertex_count(const mesh_builder *builder);

/* A polygon is a fan of triangles around its first corner until the mesh is finished. */
void mesh_builder_begin_polygon(mesh_builder *builder);
bool mesh_builder_add_corner(mesh_builder *builder, uint32_t vertex, uint32_t uv);

/* Texture coordinates; a corner without any has the number MESH_NO_UV. False when memory is short.
 */
#define MESH_NO_UV UINT32_MAX
bool mesh_builder_add_uv(mesh_builder *builder, double u, double v);

/* Ends the parts of a kind: triangles to come do not belong to them. */
bool mesh_builder_end_parts(mesh_builder *builder, part_kind kind);
/* Begins a part, beside the open ones. The name is `length` bytes without a 0. False when memory is
 * short. */
bool mesh_builder_begin_part(mesh_builder *builder, part_kind kind, const char *name,
                             size_t length);

/* Adds a blank and a word to the name begun last. */
bool mesh_builder_extend_name(mesh_builder *builder, const char *word, size_t length);

/* Makes the mesh: checks that there are vertices and that all indices are below their number, and
 * cuts the polygons within themselves, once. `place`: what the line of the builder counts. */
tulle_status mesh_builder_finish(mesh_builder *builder, const char *path, const char *place,
                                 tulle_mesh *mesh, tulle_error *error);

/* Copies the texture coordinates of corners, the parts, and the lines of vertices and triangles
 * where they are kept; ends all parts. TULLE_ERROR_OUT_OF_MEMORY leaves the source empty. */
tulle_status mesh_builder_take_source(mesh_builder *builder, tulle_mesh_source *source);

/* Largest number of vertices and triangles that a mesh may have. */
#define MESH_COUNT_LIMIT ((size_t)0x7fffffff)

/* The readers of each format. `mesh` is untouched on failure. `source` is empty, or null if nobody
 * asks. */
tulle_status obj_read(memory *heap, const char *path, const file_data *data, tulle_mesh *mesh,
                      tulle_mesh_source *source, tulle_error *error);
tulle_status ply_read(memory *heap, const char *path, const file_data *data, tulle_mesh *mesh,
                      tulle_mesh_source *source, tulle_error *error);
tulle_status stl_read_binary(memory *heap, const char *path, const file_data *data,
                             tulle_mesh *mesh, tulle_error *error);
tulle_status stl_read_text(memory *heap, const char *path, const file_data *data, tulle_mesh *mesh,
                           tulle_error *error);
/* Whether the size fits the triangle count in a binary STL header. */
bool stl_has_binary_size(const file_data *data);

#endif
