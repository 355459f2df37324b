/* scene/keys_mesh.c - the table of keys: meshes. */
#include "base/words.h"
#include "scene/keys_table.h"

#include "tulle/shapes.h"

#define BIT(shape) (UINT64_C(1) << TULLE_SHAPE_##shape)
#define ALL_SHAPES ((UINT64_C(1) << TULLE_SHAPE_COUNT) - 1)
#define GROUNDS (BIT(BUMPY_GROUND) | BIT(CRESTED_GROUND))
#define SIZE_2 (BIT(RECTANGLE) | BIT(RIBBON) | BIT(NET) | BIT(PLANE) | GROUNDS)
#define SIZE_3 (BIT(BOX) | BIT(TILE))
#define ROUND                                                                                      \
    (BIT(DISC) | BIT(TUBE) | BIT(CAPE) | BIT(SPHERE) | BIT(HEMISPHERE) | BIT(CYLINDER) |           \
     BIT(CONE) | BIT(NEEDLE) | BIT(TETRAHEDRON) | BIT(TORUS) | BIT(NAIL) | BIT(SCEPTRE))
#define HIGH                                                                                       \
    (BIT(TUBE) | BIT(CYLINDER) | BIT(CONE) | BIT(NEEDLE) | BIT(TETRAHEDRON) | BIT(NAIL) |          \
     GROUNDS | BIT(TILE) | BIT(SCEPTRE))
#define CUT (BIT(RECTANGLE) | BIT(RIBBON) | BIT(DISC) | BIT(TUBE) | BIT(CAPE) | BIT(NET))
#define GRIDS (ALL_SHAPES & ~(BIT(TETRAHEDRON) | BIT(NET)))

size_t shape_size_count(int shape) {
    if (SIZE_3 >> shape & 1) return 3;
    return SIZE_2 >> shape & 1 ? 2 : 0;
}

size_t shape_resolution_count(int shape) {
    if ((BIT(BOX) | BIT(SPHERE)) >> shape & 1) return 1;
    return GRIDS >> shape & 1 ? 2 : 0;
}

#define BY_SHAPE .derived = "by shape"
static const schema_key mesh_table[] = {
    {.name = "file",
     .type = SCHEMA_PATH,
     .flags = SCHEMA_ALTERNATIVE,
     FIELD(mesh_keys, file),
     .meaning =
         "OBJ, PLY or STL file; or an animation (.glb, .gltf, .usda, .npz, .abc), of which the "
         "first frame is taken"},
    {.name = "shape",
     .type = SCHEMA_CHOICE,
     .flags = SCHEMA_ALTERNATIVE,
     .choices = shape_words,
     FIELD(mesh_keys, shape),
     .meaning = "generated mesh, see the table of shapes"},
    {.name = "size",
     .type = SCHEMA_VECTOR,
     .unit = UNIT_LENGTH,
     .least_count = 2,
     .most_count = 3,
     .minimum = 0,
     .maximum = 1e6,
     .flags = SCHEMA_ABOVE_MINIMUM,
     .applies = SIZE_2 | SIZE_3,
     BY_SHAPE,
     FIELD(mesh_keys, size),
     .meaning = "extent along x, y and, of solids, z"},
    {.name = "radius",
     POSITIVE_LENGTH(0),
     .applies = ROUND,
     BY_SHAPE,
     FIELD(mesh_keys, radius),
     .meaning =
         "radius; of a torus: of its centre line; of needle, nail and sceptre: of the shaft"},
    {.name = "inner_radius",
     POSITIVE_LENGTH(0),
     .applies = BIT(CAPE) | BIT(TORUS),
     BY_SHAPE,
     FIELD(mesh_keys, inner_radius),
     .meaning = "radius of a cape's neck or of a torus' tube"},
    {.name = "height",
     POSITIVE_LENGTH(0),
     .applies = HIGH,
     BY_SHAPE,
     FIELD(mesh_keys, height),
     .meaning = "height along z; of grounds and tiles: of their bumps"},
    {.name = "tip_height",
     POSITIVE_LENGTH(0),
     .applies = BIT(NEEDLE),
     BY_SHAPE,
     FIELD(mesh_keys, tip_height),
     .meaning = "height of a needle's conical tip"},
    {.name = "head_radius",
     POSITIVE_LENGTH(0),
     .applies = BIT(NAIL) | BIT(SCEPTRE),
     BY_SHAPE,
     FIELD(mesh_keys, head_radius),
     .meaning = "radius of a nail's or a sceptre's head"},
    {.name = "head_height",
     POSITIVE_LENGTH(0),
     .applies = BIT(NAIL),
     BY_SHAPE,
     FIELD(mesh_keys, head_height),
     .meaning = "height of a nail's head"},
    {.name = "angle",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .minimum = 0,
     .maximum = 6.283185307179586,
     .flags = SCHEMA_ABOVE_MINIMUM,
     .applies = BIT(CAPE),
     BY_SHAPE,
     FIELD(mesh_keys, angle),
     .meaning = "opening of a cape's sector"},
    {.name = "cells",
     .type = SCHEMA_INTEGERS,
     .least_count = 2,
     .most_count = 2,
     .minimum = 1,
     .maximum = 10000,
     .applies = BIT(NET),
     BY_SHAPE,
     FIELD(mesh_keys, cells),
     .meaning = "holes of a net along x and y"},
    {.name = "strand",
     POSITIVE_LENGTH(0),
     .applies = BIT(NET),
     BY_SHAPE,
     FIELD(mesh_keys, strand),
     .meaning = "width of a net's strands"},
    {.name = "strand_resolution",
     .type = SCHEMA_INTEGER,
     .minimum = 1,
     .maximum = 1000,
     .applies = BIT(NET),
     BY_SHAPE,
     FIELD(mesh_keys, strand_resolution),
     .meaning = "columns of triangles across a strand"},
    {.name = "wavelength",
     POSITIVE_LENGTH(0),
     .applies = GROUNDS | BIT(TILE),
     BY_SHAPE,
     FIELD(mesh_keys, wavelength),
     .meaning = "distance of bumps or ridges"},
    {.name = "resolution",
     .type = SCHEMA_INTEGERS,
     .least_count = 1,
     .most_count = 2,
     .minimum = 2,
     .maximum = 10000000,
     .applies = GRIDS,
     BY_SHAPE,
     FIELD(mesh_keys, resolution),
     .meaning =
         "fineness: vertices along x and y, or around and along; one number where a shape has one"},
    {.name = "irregular",
     .type = SCHEMA_BOOL,
     .fallback = "false",
     .applies = CUT,
     FIELD(mesh_keys, irregular),
     .meaning =
         "moves inner vertices and turns diagonals at random; outline and area do not change"},
    {.name = "seed",
     AUTO_SEED,
     FIELD(mesh_keys, seed),
     .beside = "irregular",
     .applies = CUT | BIT(BUMPY_GROUND) | BIT(CRESTED_GROUND) | BIT(TILE),
     .meaning = "seed of irregular meshes and bumps; auto: from the scene's seed"},
};
const schema_map mesh_map = {
    .title = "Mesh",
    .meaning = "Triangles from a file or a generator. Flat cloth lies in the plane z = 0, centred "
               "at the origin; boxes, spheres, tori and tiles are centred there; other obstacles "
               "stand on the plane with z up.",
    MAP_OF(mesh_table, mesh_keys),
    .needs_alternative = true,
    .selector = "shape"};
