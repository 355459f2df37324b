/* tulle/check.h - the judge: which pairs of triangles intersect. It decides by exact arithmetic on
 * the doubles that it is given, without a tolerance. It shares no code with collision detection or
 * response. See docs/method/judge.md. */
#ifndef TULLE_CHECK_H
#define TULLE_CHECK_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One body of a frame. Pairs of triangles are judged within a body and between bodies. Pairs of
 * obstacles are left out: obstacles may intersect themselves and one another. */
typedef struct tulle_check_body {
    tulle_mesh_view mesh; /* borrowed for the call */
    int is_obstacle;      /* 0: cloth */
} tulle_check_body;

/* A pair of triangles that intersects. body_a <= body_b; where the bodies are equal, triangle_a <
 * triangle_b. */
typedef struct tulle_check_pair {
    uint32_t body_a;     /* body of the first triangle */
    uint32_t triangle_a; /* the first triangle, in its body */
    uint32_t body_b;     /* body of the second triangle */
    uint32_t triangle_b; /* the second triangle, in its body */
} tulle_check_pair;

/* The verdict on a frame. */
typedef struct tulle_check_result {
    /* sorted by body_a, triangle_a, body_b, triangle_b; release with tulle_check_result_destroy */
    tulle_check_pair *pairs;
    size_t pair_count;        /* all intersecting pairs */
    size_t tested_pair_count; /* pairs of triangles whose boxes overlap */
    size_t exact_count;       /* signs that floating point could not decide */
} tulle_check_result;

/* Finds every intersecting pair of triangles in `bodies`, `body_count` of them.
 *
 * Two triangles without a shared vertex number intersect if they have a point in common; touching
 * counts. Two triangles of one body may share vertices by number. They intersect if they have a
 * common point outside the shared vertex or edge. So neighbours that are folded flat onto each
 * other intersect. A triangle without area is judged as a segment or a point.
 *
 * `threads`: 1 .. 256, 0 for one per processor; the result does not depend on it. After an error
 * the result is empty. Errors: TULLE_ERROR_INVALID_MESH (an index out of range, a coordinate that
 * is not finite), TULLE_ERROR_LIMIT (more than 2^26 intersecting pairs, or more than 2^31 pairs
 * whose boxes overlap, as in heaps of triangles in one place), TULLE_ERROR_INVALID_ARGUMENT (null,
 * threads out of range; null `bodies` are fine where `body_count` is 0), TULLE_ERROR_OUT_OF_MEMORY.
 */
TULLE_API tulle_status tulle_check_intersections(const tulle_check_body *bodies, size_t body_count,
                                                 int threads, tulle_check_result *result,
                                                 tulle_error *error);
/* Releases the pairs and zeroes the struct. Null is fine. */
TULLE_API void tulle_check_result_destroy(tulle_check_result *result);

/* 1 if two triangles intersect by the rules of tulle_check_intersections; makes no heap call.
 * `first` and `second` are the vertex numbers of their corners; `positions` [m] holds 3 coordinates
 * for each vertex. `is_one_body` 1: equal numbers are a shared vertex; 0: they mean nothing. A
 * triangle with a coordinate that is not finite counts as intersecting, and so does null. */
TULLE_API int tulle_check_triangle_pair(const double *positions, const uint32_t first[3],
                                        const uint32_t second[3], int is_one_body);

#ifdef __cplusplus
}
#endif
#endif
