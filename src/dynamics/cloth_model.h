/* dynamics/cloth_model.h - everything about the cloth that does not change with time: masses, the
 * membrane (elements, or springs along edges), hinges across edges and their constant bending
 * matrix, and the sparsity pattern of the system matrix. Vertices of all cloths together are 0 ..
 * vertex_count - 1. */
#ifndef TULLE_DYNAMICS_CLOTH_MODEL_H
#define TULLE_DYNAMICS_CLOTH_MODEL_H

#include "dynamics/membrane.h"
#include "geom/topology.h"
#include "math/block_matrix.h"
#include "math/vec3.h"
#include "tulle/world.h"

/* Input of cloth_model_build; borrowed. */
typedef struct cloth_model_def {
    size_t vertex_count;     /* cloth vertices; those of the topology from here on (obstacles)
                                are ignored, with their triangles and edges */
    const topology *surface; /* of the cloths, or of cloths and then obstacles together; outlives
                                the model */
    const double *rest_positions; /* [m] 3 * vertex_count */
    /* [m] 9 a triangle of cloth: its corners at rest, where triangles do not fit together in one
     * shape, as patterns of garments and what shrinks. Only lengths within a triangle count. Null:
     * rest_positions */
    const double *rest_corners;
    /* material_count: at rest nothing of it is folded, whatever rest_positions say; null: none */
    const bool *has_flat_rest;
    /* [rad] by edge: its fold at rest whatever else says, positive for a ridge as seen from the
     * front; NaN: nothing more is said. Null: of no edge */
    const double *edge_folds;
    const tulle_material *materials; /* material_count, whose values were checked */
    size_t material_count;
    const uint32_t *vertex_materials; /* vertex_count indices into materials; null: all use 0 */
    tulle_membrane membrane;
    /* vertex_count: the clamp that holds a vertex for ever, counted from 1; 0: none holds it. The
     * vertices of a clamp move as one rigid body. Null: there are no clamps. Counts for woven cloth
     */
    const uint32_t *vertex_clamps;
    const double *warps; /* 3 a triangle of cloth: along the warp, of any length, in the rest shape;
                            the part in the triangle's plane counts. Null: along x */
    const double *stiffness_factors; /* of each triangle of cloth, > 0, on all stiffness and
                                        hysteresis of its material; null: 1 */
} cloth_model_def;

static inline const tulle_material *cloth_get_material(const cloth_model_def *def,
                                                       uint32_t vertex) {
    return &def->materials[def->vertex_materials ? def->vertex_materials[vertex] : 0];
}

/* A corner of a triangle at rest, the one at `vertex`. */
static inline vec3 cloth_get_rest(const cloth_model_def *def, size_t triangle, uint32_t vertex) {
    if (!def->rest_corners) return vec3_load(def->rest_positions, vertex);
    const uint32_t *const corners = def->surface->triangles + 3 * triangle;
    size_t const corner = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
    return vec3_load(def->rest_corners, 3 * triangle + corner);
}

/* One spring for each mesh edge, where cloth is made of springs. */
typedef struct cloth_spring {
    uint32_t vertices[2];
    double rest_length; /* [m] > 0 */
    double stiffness;   /* [N/m] near the rest length */
    double stiffening;  /* [1/m^2] see spring_compute_law; 0: linear */
    double damping;     /* [N s/m] */
} cloth_spring;

/* One hinge for each edge with two triangles: edge ends 0 and 1, opposite corners 2 and 3. The
 * vector c = sum_k weights[k] x_k is the edge length times the sum of the two triangles' outward
 * unit conormals, about (edge length) * (fold angle) * (hinge normal); it is zero when flat. */
typedef struct cloth_hinge {
    uint32_t vertices[4];
    double weights[4];
    uint32_t sides[2]; /* 3 * triangle + edge there, of the triangle at corner 2 and at 3 */
} cloth_hinge;

/* The rest shape of a hinge, where any hinge is not flat. */
typedef struct cloth_hinge_rest {
    double inv_double_areas[2]; /* [1/m^2] 1 / (2 rest area) of the triangle at corner 2 and at 3 */
    double curvature;           /* [m] rest value of c along the hinge normal, signed; 0: flat */
} cloth_hinge_rest;

/* Bending damping in eight triangles, side by side: of the rates of n . c of the hinges of their
 * edges, n a triangle's normal. All is zero where an edge is no hinge. Edge k joins corners k and
 * k + 1; the far corner is that of the triangle beyond. */
enum { PATCH_LANES = 8 };
typedef struct cloth_patches {
    double weights[3][3][PATCH_LANES]; /* of each hinge: on corners 1 and 2, and on the far one */
    double own[3][PATCH_LANES];        /* [N s/m] coupling of each hinge with itself */
    double cross[3][PATCH_LANES]; /* [N s/m] coupling of the two hinges that are not number k */
    double rest_double_areas[PATCH_LANES]; /* [m^2] */
    double turning_rates[3][PATCH_LANES];  /* [1/s] the sum of own couplings and most triangles at a
                                              corner over corner k's mass */
    uint32_t fars[3][PATCH_LANES];         /* vertices */
} cloth_patches;

/* A hinge, and two hinges in each of its triangles. */
enum { HINGE_COUPLINGS = 5 };

typedef struct cloth_model {
    size_t vertex_count, edge_count, hinge_count, triangle_count, fabric_count;
    double *masses;        /* [kg] vertex_count, each > 0: a third of every triangle around it */
    double *air_damping;   /* [1/s] vertex_count */
    cloth_spring *springs; /* edge_count; null where cloth is woven */
    membrane_element *elements; /* triangle_count; null where cloth is made of springs */
    membrane_fabric *fabrics;   /* fabric_count, of the elements */
    /* Of edges: 3 * triangle + edge there, of both triangles; cloth_count_places for none. Only of
     * woven cloth. */
    uint32_t *edge_places;
    cloth_hinge *hinges; /* these, triangle_hinges and vertex_hinges are null where cloth bends by
                            its matrix and has no sliders */
    const topology *surface;       /* borrowed; its first edge_count edges are those of cloth */
    cloth_hinge_rest *hinge_rests; /* null where all are flat */
    /* Hinges of edges of triangles: edge k joins corners k and k + 1; TULLE_NONE on the border. */
    uint32_t *triangle_hinges;
    /* Bending energy is 1/2 sum_ij couplings_ij d_i . d_j over hinges i, j, with d_i = c_i - rest.
     * Compressed rows of a symmetric matrix; null with springs, which bend by side_couplings. Both
     * are null where cloth bends by its matrix. */
    uint32_t *coupling_begin, *coupling_hinges;
    double *couplings; /* [N/m] */
    /* Couplings within triangles, as if half of each kink counted in each. Damping is these times
     * its time. Of a hinge: with itself, then with the next two edges in the order of each
     * triangle, the one at corner 2 first; see bend_list_sides. Of woven cloth null once the model
     * is built. */
    double *side_couplings, *damping_couplings; /* [N/m]; [N s/m] while the model is built */
    adjacency vertex_hinges;                    /* 4 * hinge + corner */
    uint32_t *vertex_corners; /* 3 * triangle + corner, beside the items of the surface's
                                 vertex_triangles */
    cloth_patches *patches;   /* of triangles 8 i .. 8 i + 7; null without bending damping */
    adjacency vertex_fars;    /* 3 * triangle + edge, where a vertex is the far corner; none without
                                 bending damping */
    /* The system matrix's patterns and the constant bending matrix on them (stiffness [N/m] and
     * damping [N s/m]): one scalar for each block and each scalar position. */
    uint32_t *block_begin, *block_columns;
    uint32_t *scalar_begin, *scalar_columns;
    double *bend_blocks, *bend_block_damping, *bend_scalars, *bend_scalar_damping;
    size_t block_count, scalar_count;
    bool has_curved_rest, has_bend_damping, has_bending;
    bool bends_by_matrix; /* flat at rest: its bending force is minus the bending matrix times the
                             positions */
    struct cloth_sliders *sliders; /* hysteresis.h; null: no cloth has any */
    /* Borrowed, set by the user before a step: not 0 for vertices, and triangles, of cloth that
     * does not move in it. Forces do not matter there and are not computed. Null: all may move. */
    const uint8_t *idle_vertices, *idle_triangles;
    const double *shape; /* [m] the same: flat cloth bends by how it differs from that; or null */
} cloth_model;

static inline size_t cloth_count_patches(const cloth_model *model) {
    return (model->triangle_count + PATCH_LANES - 1) / PATCH_LANES;
}

/* Room for three of each triangle, in whole patches. */
static inline size_t cloth_count_places(const cloth_model *model) {
    return 3 * PATCH_LANES * cloth_count_patches(model);
}

/* Builds the model. Vertices without a triangle, triangles without area and edges of no length are
 * TULLE_ERROR_INVALID_MESH (the vertices are named). */
tulle_status cloth_model_build(memory *heap, const cloth_model_def *def, cloth_model *model,
                               tulle_error *error);
void cloth_model_destroy(memory *heap, cloth_model *model);

/* A yarn within a triangle of woven cloth. */
typedef struct yarn_stretch {
    double strain;     /* -1: there is no woven cloth */
    double limit;      /* of the fabric */
    uint32_t triangle; /* among those of all cloth */
    int yarn;          /* YARN_WARP or YARN_WEFT */
    int edge;          /* of the triangle: the one that lies most along the yarn at rest */
} yarn_stretch;
/* The yarn that is longest relative to its rest length or, with `by_limit`, to its limit.
 */
yarn_stretch cloth_find_longest_yarn(const cloth_model *model, const double *positions,
                                     bool by_limit);

/* Whether a yarn of a triangle is longer than its fabric holds; false with springs. */
bool cloth_is_overstretched(const cloth_model *model, const double *positions, size_t triangle);

#endif
