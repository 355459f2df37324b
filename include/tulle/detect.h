/* tulle/detect.h - time-domain collision detection between two states of moving triangle surfaces,
 * for people who have a solver of their own. No world is needed.
 *
 * Vertex i moves along start[i] + t (end[i] - start[i]), t in [0, 1]. Every pair of a vertex and a
 * triangle of which it is no corner, and every pair of edges that share no vertex, is proven to
 * stay more than its separation apart over the whole motion, or is reported as an event. Nothing
 * is missed, whatever the motion; a few events may be near misses (see tulle_detect_state).
 * Vertices without triangles meet nothing. How to use it: docs/guide/detect.md, the library.
 *
 *     tulle_detect_def def = tulle_detect_def_default();
 *     def.triangles = triangles; def.triangle_count = m; def.vertex_count = n;
 *     tulle_detector *detector = NULL;
 *     if (tulle_detector_create(&def, &detector, &error) != TULLE_OK) ...
 *     tulle_detect_result result;
 *     if (tulle_detector_find_events(detector, start, end, &result, &error) != TULLE_OK) ...
 *
 * A detector keeps trees and patches between calls, so ask the same one for step after step. It may
 * be used by one thread at a time. The same events in the same order come out for any number of
 * threads and any vector width.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3. */
#ifndef TULLE_DETECT_H
#define TULLE_DETECT_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tulle_detect_method {
    TULLE_DETECT_PATCHES, /* one static tree a surface, refitted, that skips what lies within one
                             kept patch */
    TULLE_DETECT_REFIT,   /* one static tree a surface, refitted; no patches */
    TULLE_DETECT_BVOX,    /* backward-voxel tree, built anew each call; no patches */
    TULLE_DETECT_PAPER    /* the paper's: a backward-voxel tree for each patch and one for the
                             isolated triangles, joined under a root; patches grown anew each call */
} tulle_detect_method;

typedef enum tulle_detect_cone {
    TULLE_CONE_BERNSTEIN, /* smallest cone of the normal's Bernstein coefficients */
    TULLE_CONE_PAPER      /* the paper's bound by the longest normal; wider */
} tulle_detect_cone;

/* Triangles triangle_begin .. triangle_end - 1 over vertices vertex_begin .. vertex_end - 1.
 * Surfaces follow one another without gaps and share no vertices. */
typedef struct tulle_detect_surface {
    uint32_t vertex_begin, vertex_end;
    uint32_t triangle_begin, triangle_end;
    double thickness; /* [m] >= 0; two surfaces keep half the sum of theirs */
    int is_obstacle;  /* obstacles meet neither themselves nor one another */
    int is_static;    /* its vertices stay where the first call has them (checked): its tree is
                         fitted once */
    int ignores_self; /* does not meet itself; obstacles never do */
} tulle_detect_surface;

typedef struct tulle_detect_def {
    uint32_t cookie;           /* set by tulle_detect_def_default */
    const uint32_t *triangles; /* 3 * triangle_count indices; copied */
    size_t triangle_count;     /* 0 .. 2^31 - 1 */
    size_t vertex_count;       /* 1 .. 2^31 - 1 */
    const double *rest; /* [m] 3 * vertex_count from which trees are shaped; null: the start of
                           the first call */
    const tulle_detect_surface *surfaces; /* copied; null: all triangles are one surface */
    size_t surface_count;                 /* 0 with null; at most 4096 */
    const unsigned char *collides; /* surface_count^2, row-major, symmetric: whether two surfaces,
                                      or one and itself, may meet; null: as the surfaces say. What
                                      the surfaces exclude stays excluded */
    double thickness;              /* [m] >= 0 of the one surface when `surfaces` is null */
    double minimum_separation;     /* [m] >= 0, added to half the sum of the thicknesses; all at
                                      most 1e150 */
    tulle_detect_method method;
    tulle_detect_cone cone; /* of methods with patches */
    double max_angle; /* [rad] alpha_max, > 0 and < pi/2: widest cone in which a patch grows. Merged
                         with others, or kept, it may be wider, up to a half-space, while it is
                         certified; with
                         has_certificate 0 it may not */
    int has_certificate;    /* 1: only patches that are proven not to touch themselves are skipped.
                               0: every patch is, the paper's own rule, which misses collisions */
    int grows_patches_anew; /* 1: patches are grown at every call; 0: kept and checked again.
                               TULLE_DETECT_PAPER always grows */
    int threads;            /* 0: one per processor .. 256 */
    tulle_allocator allocator; /* zeroed: malloc without a limit; see tulle/base.h */
} tulle_detect_def;
/* patches, Bernstein cones, 60 degrees, certificate, kept, one thread per processor. */
TULLE_API tulle_detect_def tulle_detect_def_default(void);

typedef enum tulle_detect_kind {
    TULLE_DETECT_VERTEX_FACE,
    TULLE_DETECT_EDGE_EDGE
} tulle_detect_kind;

typedef enum tulle_detect_state {
    TULLE_DETECT_HIT, /* comes within its separation, or so near to it that this cannot be told; the
                         distance exceeds the separation for all t up to `time` */
    TULLE_DETECT_TOUCHING_AT_START, /* not certainly more than its separation apart at t = 0; time 0
                                     */
    TULLE_DETECT_UNRESOLVED         /* as a hit, but the search ended early; rare */
} tulle_detect_state;

typedef struct tulle_detect_event {
    tulle_detect_kind kind;
    tulle_detect_state state;
    uint32_t surfaces[2]; /* of the first and of the second feature */
    uint32_t face;        /* vertex/face: index of the triangle; else TULLE_NONE */
    uint32_t vertices[4]; /* vertex/face: vertex, corners of the face; edge/edge: both ends of the
                             first edge, both of the second; the smaller index of an edge first */
    double time;          /* in [0, 1]; safe lower bound, see tulle_detect_state */
    double weights[4];    /* the closest points at `time`: their difference is sum w[i] x[i], so
                             vertex/face (1, -b0, -b1, -b2), edge/edge (1-s, s, -(1-r), -r) */
    double normal[3];     /* unit, from the second feature to the first at `time`; the common normal
                             of the features where they touch; zero where there is none */
    double distance;      /* [m] at `time` */
} tulle_detect_event;

/* What the passes did; times in seconds of wall clock, those within the joint search as a share of
 * it. */
typedef struct tulle_detect_statistics {
    uint64_t box_pairs;         /* vertex/face and edge/edge pairs that boxes over the motion do not
                                   show apart, after patches; without those that share a vertex */
    uint64_t filtered_pairs;    /* of these not shown apart by the first filters: coplanarity
                                   (where the separation is 0), axes, the direction at the start */
    uint64_t tested_pairs;      /* of these not shown apart by the direction at the end either:
                                   given to the time of impact */
    uint64_t leaf_pairs;        /* pairs of leaves visited */
    uint64_t patch_count;       /* patches in use: certified, or all with has_certificate 0 */
    uint64_t uncertified_count; /* kept patches that held no more and were dissolved whole in
                                   this call; not those that were cut or grown again */
    uint64_t patch_triangles;   /* triangles in patches in use */
    uint64_t certified_by_star, certified_by_contour; /* patches */
    uint64_t checked_again; /* patches kept from the last call and found to hold */
    int uses_patches;       /* 0: the method has none, no patch is proven, or they were switched
                               off for this call because they did not pay */
    double patch_seconds, tree_seconds, search_seconds, event_seconds, total_seconds;
    double traversal_seconds, filter_seconds, impact_seconds; /* parts of search_seconds */
} tulle_detect_statistics;

typedef struct tulle_detect_result {
    const tulle_detect_event *events; /* sorted by (kind, first feature, second feature), where a
                                         feature is a vertex, a face or an edge in the order of its
                                         two vertices; owned by the detector, until its next call,
                                         also one that fails. Equal events have equal bytes */
    size_t event_count;
    double earliest_time; /* smallest time of an event; 1 without events */
    tulle_detect_statistics statistics;
} tulle_detect_result;

typedef struct tulle_detector tulle_detector;

/* Errors: INVALID_ARGUMENT, INVALID_MESH (an index out of range, a corner repeated, a triangle
 * whose vertices lie outside its surface), OUT_OF_MEMORY, LIMIT. Triangles may be of no area, be
 * there twice, and share an edge in any number. */
TULLE_API tulle_status tulle_detector_create(const tulle_detect_def *def, tulle_detector **detector,
                                             tulle_error *error);
TULLE_API void tulle_detector_destroy(tulle_detector *detector);

/* All events. start, end: [m] 3 * vertex_count. A call that fails leaves `result` untouched and the
 * detector usable. INVALID_ARGUMENT names the vertex that is not finite, or moves though it is
 * static. */
TULLE_API tulle_status tulle_detector_find_events(tulle_detector *detector, const double *start,
                                                  const double *end, tulle_detect_result *result,
                                                  tulle_error *error);

/* Takes events as they come, `context` with each call; not 0 asks to stop. */
typedef struct tulle_detect_receiver {
    int (*receive)(void *context, const tulle_detect_event *events, size_t count);
    void *context;
} tulle_detect_receiver;
/* The same events in the same order, in batches of at most 1024, without keeping them:
 * result->events is null. A receiver that does not return 0 ends the call with
 * TULLE_ERROR_INTERRUPTED. A receiver must not call the same detector: finding and streaming from
 * it are refused with INVALID_ARGUMENT and leave the stream as it is; destroying is undefined. */
TULLE_API tulle_status tulle_detector_stream_events(tulle_detector *detector, const double *start,
                                                    const double *end,
                                                    tulle_detect_receiver receiver,
                                                    tulle_detect_result *result,
                                                    tulle_error *error);

/* Only the earliest event (the first in order among equals), or none: cheaper, pairs that cannot
 * come earlier are left out. */
TULLE_API tulle_status tulle_detector_find_earliest(tulle_detector *detector, const double *start,
                                                    const double *end, tulle_detect_result *result,
                                                    tulle_error *error);

/* Labels of the patches in use after the last call, one a triangle: a number above 0 for each
 * patch, not every number used; 0 for isolated triangles. Valid until the next call. Null before
 * the first call, where the last one failed (but for a receiver that stopped it), and for methods
 * without patches. */
TULLE_API const uint32_t *tulle_detector_get_patches(const tulle_detector *detector);

#ifdef __cplusplus
}
#endif
#endif
