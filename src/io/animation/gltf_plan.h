/* io/animation/gltf_plan.h - where the parts of an animation stand in a glTF file: numbers of
 * meshes and accessors, places in the buffer. The buffer holds, one after the other, the indices of
 * all meshes, their texture coordinates, vectors (positions and normals), and what drives nodes:
 * times, weights, translations and rotations. */
#ifndef TULLE_IO_ANIMATION_GLTF_PLAN_H
#define TULLE_IO_ANIMATION_GLTF_PLAN_H

#include "io/animation/animation.h"

typedef enum gltf_view {
    GLTF_VIEW_INDICES,
    GLTF_VIEW_UVS,
    GLTF_VIEW_VECTORS,
    GLTF_VIEW_DRIVES,
    GLTF_VIEW_COUNT
} gltf_view;

/* Weights of more targets are written sparsely: their number grows with the square. */
enum { GLTF_DENSE_TARGETS = 1024 };

/* A surface; one with a prototype has a node of its own and nothing else. */
typedef struct gltf_part {
    size_t vertex_count;       /* as written */
    const uint32_t *triangles; /* of written vertices */
    /* Only where there are texture coordinates. A vertex with several becomes several: the first
     * keeps its number, the others follow behind all vertices. */
    uint32_t *split_triangles; /* 3 * triangle_count; null: none */
    uint32_t *extra_sources;   /* of the written vertices from mesh.vertex_count on the vertex */
    size_t extra_capacity;
    float *uvs; /* 2 * vertex_count, v downwards */
    size_t uv_capacity;
    bool is_own;           /* has a mesh of its own */
    size_t mesh;           /* number of the mesh */
    size_t target_count;   /* 0: it does not deform */
    size_t first_accessor; /* indices, positions, normals, uvs as there are, then the targets */
    size_t drive_accessor; /* of a rigid one that moves: translations, then rotations */
    uint64_t index_place, uv_place, vector_place; /* [bytes] in their views */
    uint64_t drive_place;
} gltf_part;

typedef struct gltf_plan {
    gltf_part *parts; /* of each surface */
    size_t mesh_count, accessor_count;
    bool has_weights; /* a surface deforms */
    size_t time_accessor, weight_accessor;
    uint64_t weight_place;
    uint64_t sizes[GLTF_VIEW_COUNT]; /* [bytes] */
    uint64_t total;
} gltf_plan;

/* Release with gltf_plan_destroy, also after a failure. */
tulle_status gltf_plan_make(animation_job *job, gltf_plan *plan, tulle_error *error);
void gltf_plan_destroy(animation_job *job, gltf_plan *plan);
/* Bytes before a view. */
uint64_t gltf_plan_get_offset(const gltf_plan *plan, gltf_view view);
/* The number of a view among those that hold something. */
int gltf_plan_get_view(const gltf_plan *plan, gltf_view view);
/* The vertex of the surface that a written one repeats. */
size_t gltf_part_get_source(const gltf_part *part, size_t vertex_count, size_t written);

#endif
