/* geom/shapes.h - what the generators of tulle/shapes.h share. A generator takes a def whose ranges
 * are checked and whose derived values are filled in, and makes the mesh. */
#ifndef TULLE_GEOM_SHAPES_H
#define TULLE_GEOM_SHAPES_H

#include "base/memory.h"
#include "math/vec3.h"
#include "tulle/shapes.h"

#define SHAPE_BIT(shape) (UINT32_C(1) << TULLE_SHAPE_##shape)

/* Most vertices of a generated mesh. */
enum { SHAPE_VERTEX_LIMIT = 10000000 };

typedef tulle_status (*shape_generator)(const tulle_shape_def *def, tulle_mesh *mesh,
                                        tulle_error *error);

tulle_status shape_make_sheet(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error);
tulle_status shape_make_slab(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error);
tulle_status shape_make_net(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error);
tulle_status shape_make_rings(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error);
tulle_status shape_make_sphere(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error);
tulle_status shape_make_tetrahedron(const tulle_shape_def *def, tulle_mesh *mesh,
                                    tulle_error *error);

/* Sets the fields that the shape does not use to 0. */
void shape_clear_unused(tulle_shape_def *def);
/* Refuses fields that the shape does not use. Range checks of every field that it uses, then the
 * values that 0 leaves to the shape. */
tulle_status shape_check_def(const tulle_shape_def *def, tulle_error *error);
void shape_derive_def(tulle_shape_def *def);
/* Checks that need the derived values: how the fields fit together. */
tulle_status shape_check_fit(const tulle_shape_def *def, tulle_error *error);

/* An empty mesh to be filled front to back. Counts are exact, as doubles so that no product of
 * resolutions overflows; over the limit: TULLE_ERROR_LIMIT, nothing allocated. */
typedef struct shape_writer {
    tulle_mesh *mesh;
    size_t vertex_count, triangle_count; /* written so far */
} shape_writer;
tulle_status shape_writer_start(shape_writer *writer, double vertex_count, double triangle_count,
                                tulle_mesh *mesh, tulle_error *error);
void shape_write_vertex(shape_writer *writer, double x, double y, double z);
void shape_write_triangle(shape_writer *writer, size_t a, size_t b, size_t c);
/* The quad a b c d, counterclockwise, cut along a c or b d. */
void shape_write_quad(shape_writer *writer, const size_t corners[4], bool is_cut_along_ac);

/* Which way quad (i, j) is cut: alternately, which favours neither diagonal, so that a square sheet
 * of springs drapes the same along x, y and both diagonals; or at random for irregular cloth. */
bool shape_get_cut(const tulle_shape_def *def, size_t i, size_t j);
/* Random bits of a place, the same on every machine. */
uint64_t shape_hash(uint64_t seed, uint64_t a, uint64_t b);

/* Moves inner vertices within the surface by up to a fifth of their shortest edge; triangles keep
 * at least a part of their quality, the boundary stays. */
tulle_status shape_jitter(memory *heap, const tulle_shape_def *def, tulle_mesh *mesh,
                          tulle_error *error);

#endif
