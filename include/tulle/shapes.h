/* tulle/shapes.h - generated meshes: cloth in many cuts and the obstacles of the paper's scenes.
 * All are oriented manifolds, solids are closed. docs/guide/shapes.md shows which field each shape
 * uses.
 */
#ifndef TULLE_SHAPES_H
#define TULLE_SHAPES_H

#include "tulle/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tulle_shape {
    /* cloth: flat ones lie in the plane z = 0, centred at the origin, normals +z */
    TULLE_SHAPE_RECTANGLE, /* size[0] x size[1], resolution[0] x resolution[1] vertices */
    TULLE_SHAPE_RIBBON,    /* as rectangle: size[0] long, size[1] wide; resolution[0] along */
    TULLE_SHAPE_DISC,      /* radius, resolution[0] rings, resolution[1] vertices on the rim */
    TULLE_SHAPE_TUBE, /* open cylinder about z: radius, height, resolution[0] around, resolution[1]
                         along */
    TULLE_SHAPE_CAPE, /* annulus sector about the origin, open towards -x: inner radius (the neck),
                         radius, angle (2 pi: sewn up); resolution[0] along the hem, resolution[1]
                         from neck to hem */
    TULLE_SHAPE_NET,  /* size[0] x size[1] with cells[0] x cells[1] real holes; strand width
                         `strand` */
    /* obstacles: z is up */
    TULLE_SHAPE_PLANE,       /* size[0] x size[1] at z = 0 */
    TULLE_SHAPE_BOX,         /* size[0..2], centred; resolution[0] vertices along x and y */
    TULLE_SHAPE_SPHERE,      /* radius, centred; geodesic: 10 resolution[0]^2 + 2 vertices */
    TULLE_SHAPE_HEMISPHERE,  /* radius, flat side on z = 0, closed */
    TULLE_SHAPE_CYLINDER,    /* radius, height along z from 0, closed */
    TULLE_SHAPE_CONE,        /* radius, height, tip up, closed */
    TULLE_SHAPE_NEEDLE,      /* slender cone on a thin shaft: radius of shaft, height, tip_height */
    TULLE_SHAPE_TETRAHEDRON, /* spike: regular triangle base with circumradius `radius`, tip at
                                height */
    TULLE_SHAPE_TORUS, /* ring about z: radius of centre line, inner radius = radius of the tube */
    TULLE_SHAPE_NAIL,  /* shaft radius, height, head radius and head_height */
    TULLE_SHAPE_BUMPY_GROUND,   /* size[0] x size[1], bumps of height and wavelength, seeded */
    TULLE_SHAPE_CRESTED_GROUND, /* size[0] x size[1], sharp ridges of height and wavelength */
    TULLE_SHAPE_TILE,           /* box size[0..2] with bumpy top of height and wavelength */
    TULLE_SHAPE_SCEPTRE,        /* a ball of head_radius on a leg of `radius`, together `height` */
    TULLE_SHAPE_COUNT
} tulle_shape;

typedef struct tulle_shape_def {
    uint32_t cookie;
    tulle_shape shape;
    double size[3];      /* [m] all lengths that a shape uses: 1e-6 .. 1e6 */
    double radius;       /* [m] */
    double inner_radius; /* [m] < radius; 0: a fifth of radius */
    double height;       /* [m] */
    double tip_height;   /* [m] needle: height of the conical tip, < height; 0: 0.4 of it */
    double head_radius;  /* [m] nail, sceptre: > radius, of a sceptre < height / 2; 0: 2.5 radii */
    double head_height;  /* [m] nail: < height; 0: radius, at most a quarter of height */
    double angle;        /* [rad] cape: the sector that the cloth fills, 1e-6 .. 2 pi */
    double strand;       /* [m] net: width of the strands; 0: a fifth of a hole and its strand */
    double wavelength;   /* [m] grounds and tile; 0: an eighth (tile: a quarter) of the size */
    uint32_t resolution[2];     /* >= 2, around closed rings >= 3; 0: chosen from the lengths */
    uint32_t cells[2];          /* net: holes along each side */
    uint32_t strand_resolution; /* net: triangles' columns across a strand, >= 1 */
    int is_irregular; /* cloth: jittered vertices and random diagonals, seeded; the area and the
                         outline stay */
    uint64_t seed;
} tulle_shape_def;
TULLE_API tulle_shape_def tulle_shape_def_default(tulle_shape shape);
TULLE_API const char *
tulle_shape_name(tulle_shape shape); /* "rectangle", "bumpy-ground", ...; null out of range */
/* Whether the shape is meant as cloth. */
TULLE_API int tulle_shape_is_cloth(tulle_shape shape);

/* Makes the mesh. Limit: 10,000,000 vertices (TULLE_ERROR_LIMIT with the number asked for). */
TULLE_API tulle_status tulle_shape_generate(const tulle_shape_def *def, tulle_mesh *mesh,
                                            tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
