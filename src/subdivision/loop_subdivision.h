/* subdivision/loop_subdivision.h - the parts of Loop subdivision: what is sharp in a mesh, how its
 * connections refine, and the masks as rows of a sparse matrix from one level to the next.
 *
 * Numbering. A level has vertices, edges (a, b) and triangles (v0, v1, v2). Edge k of a triangle
 * joins its corners k and k + 1. In the next level:
 *   - A vertex keeps its number. The midpoint of edge e is vertex vertex_count + e.
 *   - Edge e becomes 2 e (its end 0 and the midpoint) and 2 e + 1 (the midpoint and its end 1).
 *   - Triangle t adds the edges 2 edge_count + 3 t + k, which cut off its corners k.
 *   - Triangle t becomes 4 t + k (at corner k) and 4 t + 3 (the middle one).
 * After d levels the part of base edge e next to its end i is edge e 2^d + i (2^d - 1). It has the
 * same end. */
#ifndef TULLE_SUBDIVISION_LOOP_SUBDIVISION_H
#define TULLE_SUBDIVISION_LOOP_SUBDIVISION_H

#include "geom/topology.h"
#include "tulle_io/subdivision.h"

/* How a vertex of one level moves in the next. */
typedef enum vertex_rule {
    VERTEX_FIXED,  /* a corner, or a vertex without triangles */
    VERTEX_SMOOTH, /* one closed fan without sharp edges */
    VERTEX_DART,   /* one closed fan with one sharp edge, the end of a crease */
    VERTEX_CREASE  /* on a border or crease curve: two sharp edges */
} vertex_rule;

/* Changes the standard masks (3/8, 3/8, 1/8, 1/8) of one smooth edge at a sharp end of it, or
 * numbers an edge at a dart. Kept with the end of the edge through all levels. */
typedef struct spoke_rule {
    /* A sector is the fan of triangles between two neighbouring sharp edges of the end. The edge
     * point weighs the other end by far_weight and this one by 3/4 - far_weight. */
    double far_weight;
    /* At a concave corner the edge point is drawn to the plane of the sector's sharp edges: by this
     * fraction, 0 .. 1, to corner + 1/2 sum_i side_weights[i] (side_i - corner), side_i the
     * neighbour along base edge side_edges[i], of which the corner is end side_ends[i]. */
    double flatness;
    double side_weights[2];
    uint32_t side_edges[2], side_ends[2];
    uint32_t
        dart_position; /* how many triangles after the dart's sharp edge; TULLE_NONE: no dart */
} spoke_rule;

/* Rule 0 says nothing: no change. */
typedef ARRAY(spoke_rule) spoke_rule_table;

typedef struct subdivision_level {
    int depth; /* 0: the base mesh */
    size_t vertex_count, edge_count, triangle_count;
    uint32_t *triangles;      /* 3 * triangle_count */
    uint32_t *triangle_edges; /* 3 * triangle_count */
    uint32_t *edges;          /* 2 * edge_count */
    uint32_t *edge_opposites; /* 2 * edge_count: the third vertices of the first two triangles */
    uint32_t *spoke_rules;    /* 2 * edge_count: the rule of each end */
    uint8_t *edge_is_sharp;   /* edge_count */
    uint8_t *vertex_rules;    /* vertex_count, of vertex_rule */
} subdivision_level;

/* Rows of a sparse matrix: result r is the sum of weights[i] * value[columns[i]] over i =
 * begin[r] .. begin[r + 1] - 1. */
typedef struct subdivision_rows {
    size_t row_count, column_count, entry_count;
    uint32_t *begin; /* row_count + 1 */
    uint32_t *columns;
    double *weights;
} subdivision_rows;

struct tulle_subdivision {
    memory heap;
    int levels;
    size_t vertex_count, triangle_count, base_vertex_count;
    uint32_t *triangles; /* 3 * triangle_count */
    size_t step_count;   /* levels, and one more if moved to the limit */
    subdivision_rows steps[TULLE_SUBDIVISION_LEVELS_MAX + 1];
};

/* As tulle_subdivision_create, with all memory from a copy of the heap. */
tulle_status subdivision_create(memory heap, tulle_mesh_view mesh, const tulle_subdivision_def *def,
                                tulle_subdivision **subdivision, tulle_error *error);

/* Allocates the arrays for the given counts; false when memory is short, the level is then empty.
 */
bool subdivision_level_create(memory *heap, size_t vertex_count, size_t edge_count,
                              size_t triangle_count, subdivision_level *level);
void subdivision_level_destroy(memory *heap, subdivision_level *level);
/* Level 0 with everything sharp found and every rule decided. The mesh has been checked. */
tulle_status subdivision_level_begin(memory *heap, tulle_mesh_view mesh,
                                     const tulle_subdivision_def *def, subdivision_level *level,
                                     spoke_rule_table *rules, tulle_error *error);
/* The level after it; false when memory is short. */
bool subdivision_level_refine(memory *heap, const subdivision_level *coarse,
                              subdivision_level *fine);

/* From the vertices of a level to those of the next; or, for a level that has depth 1 at least, to
 * the limits of its vertices. False when memory is short. */
bool subdivision_rows_refine(memory *heap, const subdivision_level *level,
                             const spoke_rule_table *rules, subdivision_rows *rows);
bool subdivision_rows_limit(memory *heap, const subdivision_level *level,
                            const spoke_rule_table *rules, subdivision_rows *rows);
void subdivision_rows_destroy(memory *heap, subdivision_rows *rows);

/* Weight of each of n >= 2 neighbours of a smooth vertex, in the next level and in the limit. */
double subdivision_get_neighbour_weight(uint32_t n);
double subdivision_get_limit_weight(uint32_t n);

#endif
