/* io/animation/usd_scene.h - the surfaces that a USD file shows, and where their vertices are at a
 * time. References within the file are followed; so a prim may be shown several times. */
#ifndef TULLE_IO_ANIMATION_USD_SCENE_H
#define TULLE_IO_ANIMATION_USD_SCENE_H

#include "geom/cut_polygon.h"
#include "io/animation/usd_layer.h"

typedef enum usd_op_kind {
    USD_TRANSLATE,
    USD_SCALE,
    USD_ROTATE, /* about axes, one after the other */
    USD_ORIENT, /* by a quaternion */
    USD_MATRIX
} usd_op_kind;

/* A step of a prim's transform. */
typedef struct usd_op {
    usd_op_kind kind;
    size_t width; /* numbers */
    char axes[4]; /* "X", "XYZ": what the numbers mean where they are not x, y and z */
    bool is_inverse;
    uint32_t attribute;
} usd_op;

typedef struct usd_node {
    uint32_t parent; /* USD_NONE: none */
    size_t first_op, op_count;
    bool is_moving; /* ops have time samples */
    bool is_used;   /* it moves a piece */
    bool resets;    /* parents do not move it */
    double local[16], global[16];
} usd_node;

/* Points, or the points of a mesh, as one node shows them. */
typedef struct usd_piece {
    uint32_t node, points;
    uint32_t face_counts;  /* attribute; USD_NONE: there are no faces */
    uint32_t face_indices; /* the same */
    uint32_t holes;        /* the same, of faces that are left out */
    bool is_left_handed;
    bool has_side; /* it is known whether a mirror shows it */
    size_t vertex_count, first_vertex;
    size_t first_triangle, triangle_count;
    size_t first_kept; /* of its numbers in usd_scene.kept; SIZE_MAX: they move */
} usd_piece;

/* Nodes that move by the arrays of an instancer. */
typedef struct usd_instancer {
    uint32_t positions, orientations, scales; /* attributes; USD_NONE: there are none */
    size_t first_instance, count;             /* in usd_scene.instances */
} usd_instancer;

typedef struct usd_scene {
    usd_layer *layer;
    ARRAY(uint32_t) specs; /* prims of the nodes at hand, of each one the strongest first */
    ARRAY(usd_node) nodes; /* each behind its parent */
    ARRAY(usd_op) ops;
    ARRAY(usd_piece) pieces;
    ARRAY(usd_instancer) instancers;
    ARRAY(uint32_t) instances; /* nodes */
    ARRAY(uint32_t) triangles;
    ARRAY(polygon_fan) fans; /* of the piece at hand, to be cut */
    ARRAY(double) kept;      /* positions of pieces that do not deform */
    ARRAY(double) codes;     /* of each frame */
    ARRAY(double) frames;    /* [s] the same; at least 1 */
    ARRAY(double) scratch;
    polygon_cutter cutter;
    size_t vertex_count;
    size_t turn_count;        /* frames that turns have beside those of samples */
    bool is_turning_too_fast; /* for so many frames */
    int half_turn_line; /* of a matrix to which another turns by nearly half a turn; 0: none */
} usd_scene;

/* Reads the scene of a layer that must live as long. Release with usd_scene_destroy, also after a
 * failure. */
tulle_status usd_scene_read(usd_layer *layer, usd_scene *scene, tulle_error *error);
void usd_scene_destroy(usd_scene *scene);
/* Makes frames of all samples of what is used, and adds those between them where vertices turn. */
tulle_status usd_scene_make_frames(usd_scene *scene, tulle_error *error);
tulle_status usd_scene_add_frames(usd_scene *scene, tulle_error *error);
/* Turns round the triangles of pieces whose transform mirrors, in the first frame in which it does
 * not flatten them. */
tulle_status usd_scene_turn(usd_scene *scene, tulle_error *error);
/* Positions of all vertices at a time code: 3 * vertex_count. */
tulle_status usd_scene_pose(usd_scene *scene, double code, double *positions, tulle_error *error);
/* *turn: [rad] at least what turns anything from one time code to the next; 0 where all vertices go
 * along lines. */
tulle_status usd_scene_find_turn(usd_scene *scene, double from, double to, double *turn,
                                 tulle_error *error);

/* Where the first value of an attribute is. False where it has none. */
bool usd_find_value(const usd_layer *layer, uint32_t attribute, usd_place *place);
/* Counts one for each of `count` instances whose id is in the list at a place. Without ids their
 * numbers are their ids. */
tulle_status usd_count_named(usd_scene *scene, usd_place place, const double *ids, size_t count,
                             uint32_t *named, tulle_error *error);
/* Reads the transform of a node whose steps have no time samples. */
tulle_status usd_node_read_local(usd_scene *scene, usd_node *node, double code, tulle_error *error);
/* Reads elements of an attribute at a time, as many as there is room for. */
tulle_status usd_attribute_read(usd_scene *scene, uint32_t attribute, double code,
                                usd_numbers numbers, tulle_error *error);

#endif
