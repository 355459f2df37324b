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
    KEY(mesh_keys, file, .type = SCHEMA_PATH, .flags = SCHEMA_ALTERNATIVE,
        .meaning = "OBJ, PLY or STL file; or an animation (.glb, .gltf, .usda, .npz, .abc), of "
                   "which the first frame is taken"),
    KEY(mesh_keys, shape, .type = SCHEMA_CHOICE, .flags = SCHEMA_ALTERNATIVE,
        .choices = shape_words, .meaning = "generated mesh, see the table of shapes"),
    KEY(mesh_keys, size, .type = SCHEMA_VECTOR, BY_SHAPE, .unit = UNIT_LENGTH, .least_count = 2,
        .most_count = 3, .minimum = 0, .maximum = 1e6, .flags = SCHEMA_ABOVE_MINIMUM,
        .applies = SIZE_2 | SIZE_3, .meaning = "extent along x, y and, of solids, z"),
    KEY(mesh_keys, radius, POSITIVE_LENGTH(0), BY_SHAPE, .applies = ROUND,
        .meaning =
            "radius; of a torus: of its centre line; of needle, nail and sceptre: of the shaft"),
    KEY(mesh_keys, inner_radius, POSITIVE_LENGTH(0), BY_SHAPE, .applies = BIT(CAPE) | BIT(TORUS),
        .meaning = "radius of a cape's neck or of a torus' tube"),
    KEY(mesh_keys, height, POSITIVE_LENGTH(0), BY_SHAPE, .applies = HIGH,
        .meaning = "height along z; of grounds and tiles: of their bumps"),
    KEY(mesh_keys, tip_height, POSITIVE_LENGTH(0), BY_SHAPE, .applies = BIT(NEEDLE),
        .meaning = "height of a needle's conical tip"),
    KEY(mesh_keys, head_radius, POSITIVE_LENGTH(0), BY_SHAPE, .applies = BIT(NAIL) | BIT(SCEPTRE),
        .meaning = "radius of a nail's or a sceptre's head"),
    KEY(mesh_keys, head_height, POSITIVE_LENGTH(0), BY_SHAPE, .applies = BIT(NAIL),
        .meaning = "height of a nail's head"),
    KEY(mesh_keys, angle, BY_SHAPE, QUANTITY(UNIT_ANGLE, 0, 6.283185307179586),
        .flags = SCHEMA_ABOVE_MINIMUM, .applies = BIT(CAPE),
        .meaning = "opening of a cape's sector"),
    KEY(mesh_keys, cells, .type = SCHEMA_INTEGERS, BY_SHAPE, .least_count = 2, .most_count = 2,
        .minimum = 1, .maximum = 10000, .applies = BIT(NET),
        .meaning = "holes of a net along x and y"),
    KEY(mesh_keys, strand, POSITIVE_LENGTH(0), BY_SHAPE, .applies = BIT(NET),
        .meaning = "width of a net's strands"),
    KEY(mesh_keys, strand_resolution, BY_SHAPE, INTEGER(1, 1000), .applies = BIT(NET),
        .meaning = "columns of triangles across a strand"),
    KEY(mesh_keys, wavelength, POSITIVE_LENGTH(0), BY_SHAPE, .applies = GROUNDS | BIT(TILE),
        .meaning = "distance of bumps or ridges"),
    KEY(mesh_keys, resolution, .type = SCHEMA_INTEGERS, BY_SHAPE, .least_count = 1, .most_count = 2,
        .minimum = 2, .maximum = 10000000, .applies = GRIDS,
        .meaning = "fineness: vertices along x and y, or around and along; one number where a "
                   "shape has one"),
    KEY(mesh_keys, irregular, .type = SCHEMA_BOOL, .fallback = "false", .applies = CUT,
        .meaning =
            "moves inner vertices and turns diagonals at random; outline and area do not change"),
    KEY(mesh_keys, seed, AUTO_SEED, .beside = "irregular",
        .applies = CUT | BIT(BUMPY_GROUND) | BIT(CRESTED_GROUND) | BIT(TILE),
        .meaning = "seed of irregular meshes and bumps; auto: from the scene's seed"),
};
const schema_map mesh_map =
    MAP_OF(mesh_table, mesh_keys, .title = "Mesh", .needs_alternative = true, .selector = "shape",
           .meaning = "Triangles from a file or a generator. Flat cloth lies in the plane z = 0, "
                      "centred at the origin; boxes, spheres, tori and tiles are centred there; "
                      "other obstacles stand on the plane with z up.");
