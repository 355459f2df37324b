/* tulle/check.h - the judge: which pairs of triangles intersect, decided by exact arithmetic on the
 * given doubles. Shares no code with collision detection or response. */
#ifndef TULLE_CHECK_H
#define TULLE_CHECK_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One body of a frame. Pairs of triangles are judged within and between bodies, except where both
 * bodies are obstacles (obstacles may intersect themselves and one another). */
typedef struct tulle_check_body {
    tulle_mesh_view mesh;
    int is_obstacle; /* 0: cloth */
} tulle_check_body;

/* One intersecting pair: triangle `triangle_a` of body `body_a` and `triangle_b` of `body_b`;
 * body_a <= body_b, and triangle_a < triangle_b where the bodies are equal. */
typedef struct tulle_check_pair {
    uint32_t body_a, triangle_a, body_b, triangle_b;
} tulle_check_pair;

typedef struct tulle_check_result {
    tulle_check_pair *pairs;  /* sorted by (body_a, triangle_a, body_b, triangle_b); release with
                                 tulle_check_result_destroy */
    size_t pair_count;        /* intersecting pairs, all of them */
    size_t tested_pair_count; /* pairs of triangles whose boxes overlapped */
    size_t exact_count;       /* predicates that the floating-point filter could not decide */
} tulle_check_result;

/* Finds every intersecting pair. Two triangles without a shared vertex index intersect when they
 * have a point in common (touching counts). Triangles of one body that share vertices by index
 * intersect when they have a common point outside the shared vertex or edge (so neighbours folded
 * flat onto each other count). Degenerate triangles are judged as the segment or point that they
 * are. Indices must be in range and coordinates finite (TULLE_ERROR_INVALID_MESH). threads: 1 ..
 * 256, 0 for one per processor. The result does not depend on it. More than 2^26 intersecting pairs
 * are refused (TULLE_ERROR_LIMIT). On failure the result is empty. */
TULLE_API tulle_status tulle_check_intersections(const tulle_check_body *bodies, size_t body_count,
                                                 int threads, tulle_check_result *result,
                                                 tulle_error *error);
TULLE_API void tulle_check_result_destroy(tulle_check_result *result);

/* Whether two triangles intersect, by the same rules; makes no heap call. `first` and `second` are
 * the vertex numbers of their corners, positions [m] hold 3 coordinates a vertex. is_one_body:
 * equal numbers are a shared vertex; 0: they mean nothing. Triangles with a coordinate that is not
 * finite count as intersecting. */
TULLE_API int tulle_check_triangle_pair(const double *positions, const uint32_t first[3],
                                        const uint32_t second[3], int is_one_body);

#ifdef __cplusplus
}
#endif
#endif
