/* io/animation/gltf_scene.h - the nodes, meshes and the animation of a glTF file, and where their
 * vertices are at a time. */
#ifndef TULLE_IO_ANIMATION_GLTF_SCENE_H
#define TULLE_IO_ANIMATION_GLTF_SCENE_H

#include "io/animation/gltf_file.h"

typedef enum gltf_path {
    GLTF_TRANSLATION,
    GLTF_ROTATION,
    GLTF_SCALE,
    GLTF_WEIGHTS,
    GLTF_PATH_COUNT
} gltf_path;
typedef enum gltf_interpolation { GLTF_LINEAR, GLTF_STEP, GLTF_CUBIC } gltf_interpolation;

typedef struct gltf_channel {
    uint32_t keys;   /* number of its times; GLTF_NONE: there is no channel */
    uint32_t values; /* accessor */
    size_t width;    /* numbers of a value */
    gltf_path path;
    gltf_interpolation interpolation;
} gltf_channel;

/* The times of an accessor, rising. */
typedef struct gltf_keys {
    uint32_t accessor;
    size_t first, count; /* in gltf_scene.times */
} gltf_keys;

typedef struct gltf_node {
    const json_value *place;
    uint32_t parent; /* GLTF_NONE: none */
    uint32_t mesh, skin;
    size_t target_count; /* of the mesh */
    bool has_matrix, is_in_scene;
    double matrix[16];                            /* columns one behind the other, as in glTF */
    double translation[3], rotation[4], scale[3]; /* rotation x, y, z, w */
    gltf_channel channels[GLTF_PATH_COUNT];
    const json_value *weights; /* of the node or its mesh; null: all 0 */
    double global[16];         /* of the frame at hand */
} gltf_node;

/* A primitive of a mesh as one node shows it. */
typedef struct gltf_piece {
    uint32_t node, positions;
    const json_value *primitive;
    size_t vertex_count, first_vertex;
    size_t first_target, target_count; /* in gltf_scene.targets */
    size_t first_triangle, triangle_count;
    bool has_side; /* it is known whether a mirror shows it */
} gltf_piece;

typedef struct gltf_scene {
    gltf_file *file;
    ARRAY(gltf_node) nodes;
    ARRAY(uint32_t) order; /* nodes, each behind its parent */
    ARRAY(gltf_piece) pieces;
    ARRAY(uint32_t) targets; /* accessors of positions; GLTF_NONE: the target moves nothing */
    ARRAY(uint32_t) triangles;
    ARRAY(gltf_keys) keys;
    ARRAY(double) times;  /* of all keys */
    ARRAY(double) frames; /* [s] all different times, rising; at least 1 */
    ARRAY(double) scratch, weights;
    size_t vertex_count;
    uint64_t primitive_count; /* of all nodes, also those that are passed over */
    uint64_t passed_primitives, passed_animations; /* lines; all but the first */
    size_t jump_count, turn_count; /* frames that steps and turns have beside those of keys */
    bool is_turning_too_fast;      /* for so many frames */
} gltf_scene;

/* Reads the scene of a file that must live as long. Release with gltf_scene_destroy, also after a
 * failure. */
tulle_status gltf_scene_read(gltf_file *file, gltf_scene *scene, tulle_error *error);
void gltf_scene_destroy(gltf_scene *scene);
/* Refuses a scene that, with `more` bytes, takes too many times those of its files. */
tulle_status gltf_scene_check_size(const gltf_scene *scene, uint64_t more, tulle_error *error);
/* Reads the animation of nodes that have been read: gltf_animation.c. */
tulle_status gltf_animation_read(gltf_scene *scene, tulle_error *error);
/* Turns round the triangles of pieces whose transform mirrors, in the first frame in which it does
 * not flatten them. */
tulle_status gltf_scene_turn(gltf_scene *scene, tulle_error *error);
/* Positions of all vertices at a time [s]: 3 * vertex_count. */
tulle_status gltf_scene_pose(gltf_scene *scene, double time, double *positions, tulle_error *error);

#endif
