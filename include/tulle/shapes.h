/* tulle/shapes.h - generated meshes: cloth in many cuts, and obstacles. All are oriented manifolds,
 * solids are closed. docs/guide/shapes.md lists the fields that each shape uses and their defaults.
 */
#ifndef TULLE_SHAPES_H
#define TULLE_SHAPES_H

#include "tulle/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The shapes. Cloth comes first: flat cloth lies in the plane z = 0, centred at the origin, its
 * normals along +z. Obstacles follow, from TULLE_SHAPE_PLANE on; z is up. */
typedef enum tulle_shape {
    TULLE_SHAPE_RECTANGLE, /* size[0] x size[1], resolution[0] x resolution[1] vertices */
    TULLE_SHAPE_RIBBON,    /* as rectangle: size[0] long, size[1] wide; resolution[0] along */
    TULLE_SHAPE_DISC,      /* radius, resolution[0] rings, resolution[1] vertices on the rim */
    /* open cylinder about z: radius, height, resolution[0] around, resolution[1] along */
    TULLE_SHAPE_TUBE,
    /* sector of a ring about the origin, open towards -x: inner_radius (the neck), radius, angle
     * (2 pi: sewn up); resolution[0] along the hem, resolution[1] from neck to hem */
    TULLE_SHAPE_CAPE,
    TULLE_SHAPE_NET,        /* size[0] x size[1] with cells[0] x cells[1] holes; `strand` wide */
    TULLE_SHAPE_PLANE,      /* size[0] x size[1] at z = 0 */
    TULLE_SHAPE_BOX,        /* size[0..2], centred; resolution[0] vertices along x and y */
    TULLE_SHAPE_SPHERE,     /* radius, centred; geodesic: 10 resolution[0]^2 + 2 vertices */
    TULLE_SHAPE_HEMISPHERE, /* radius, flat side on z = 0, closed */
    TULLE_SHAPE_CYLINDER,   /* radius, height along z from 0, closed */
    TULLE_SHAPE_CONE,       /* radius, height, tip up, closed */
    TULLE_SHAPE_NEEDLE, /* slender cone on a thin shaft: radius of the shaft, height, tip_height */
    /* spike: base a regular triangle with the circumradius `radius`, tip at `height` */
    TULLE_SHAPE_TETRAHEDRON,
    TULLE_SHAPE_TORUS, /* ring about z: radius of the centre line, inner_radius of the tube */
    TULLE_SHAPE_NAIL,  /* radius of the shaft, height, head_radius, head_height */
    TULLE_SHAPE_BUMPY_GROUND,   /* size[0] x size[1], bumps of height and wavelength, seeded */
    TULLE_SHAPE_CRESTED_GROUND, /* size[0] x size[1], sharp ridges of height and wavelength */
    TULLE_SHAPE_TILE,           /* box of size[0..2] with a bumpy top of height and wavelength */
    TULLE_SHAPE_SCEPTRE,        /* a ball of head_radius on a leg of `radius`, together `height` */
    TULLE_SHAPE_COUNT           /* number of the shapes above */
} tulle_shape;

/* A shape to make. Made by tulle_shape_def_default. Fields that a shape does not use must be 0. A
 * length or a resolution of 0 is derived from other fields where the comment says so. Box and
 * sphere have one resolution; resolution[1] may repeat it. */
typedef struct tulle_shape_def {
    uint32_t cookie;     /* set by tulle_shape_def_default, checked on use */
    tulle_shape shape;   /* which one */
    double size[3];      /* [m] along x, y, z; every length that a shape uses: 1e-6 .. 1e6 */
    double radius;       /* [m] */
    double inner_radius; /* [m] < radius; 0: a fifth of radius */
    double height;       /* [m] */
    double tip_height;   /* [m] needle: of the conical tip, < height; 0: 0.4 of it */
    /* [m] nail, sceptre: > radius, of a sceptre < height / 2; 0: 2.5 times radius */
    double head_radius;
    double head_height;     /* [m] nail: < height; 0: radius, at most a quarter of height */
    double angle;           /* [rad] cape: the sector that the cloth fills, 1e-6 .. 2 pi */
    double strand;          /* [m] net: width of a strand; 0: a fifth of a hole and a strand */
    double wavelength;      /* [m] grounds and tile; 0: an eighth (tile: a quarter) of the size */
    uint32_t resolution[2]; /* >= 2, around closed rings >= 3; 0: chosen from the lengths */
    uint32_t cells[2];      /* net: holes along each side, >= 1 */
    uint32_t strand_resolution; /* net: columns of triangles across a strand, >= 1 */
    /* cloth: 1 moves inner vertices and turns diagonals at random; area and outline stay */
    int is_irregular;
    uint64_t seed; /* of irregular cloth and of bumps; equal defs give equal meshes */
} tulle_shape_def;
/* The default of a shape: all lengths that it uses are set. tulle_shape_generate refuses the
 * default of an unknown shape. */
TULLE_API tulle_shape_def tulle_shape_def_default(tulle_shape shape);
/* The name of a shape, as "bumpy-ground"; static. Null out of range. */
TULLE_API const char *tulle_shape_name(tulle_shape shape);
/* 1 if the shape is meant as cloth; 0 out of range. */
TULLE_API int tulle_shape_is_cloth(tulle_shape shape);

/* Makes the mesh; release it with tulle_mesh_destroy. Errors: TULLE_ERROR_INVALID_ARGUMENT (null; a
 * wrong field: the message names it and the fields that the shape takes), TULLE_ERROR_LIMIT (more
 * than 10,000,000 vertices; the message says how many), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_shape_generate(const tulle_shape_def *def, tulle_mesh *mesh,
                                            tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
