/* tulle/detect.h - collisions of triangle surfaces that move from one state to another, for people
 * who have a solver of their own. No world is needed.
 *
 * Vertex i moves along start[i] + t (end[i] - start[i]), t in [0, 1]. The detector looks at every
 * pair of a vertex and a triangle that does not contain the vertex, and at every pair of edges
 * without a common vertex. Each pair is proven to stay more than its separation apart over the
 * whole motion, or is reported as an event. Nothing is missed, whatever the motion; a few events
 * may be near misses (see tulle_detect_state). Vertices without triangles meet nothing.
 *
 *     tulle_detect_def def = tulle_detect_def_default();
 *     def.triangles = triangles; def.triangle_count = m; def.vertex_count = n;
 *     tulle_detector *detector = NULL;
 *     if (tulle_detector_create(&def, &detector, &error) != TULLE_OK) ...
 *     tulle_detect_result result;
 *     if (tulle_detector_find_events(detector, start, end, &result, &error) != TULLE_OK) ...
 *
 * See docs/guide/detect.md; examples/detect_two_frames.c is a whole program.
 *
 * A detector keeps trees and patches between calls, so use the same detector for step after step.
 * One thread at a time may use it. The same events in the same order come out for any number of
 * threads and any vector width.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.   */
#ifndef TULLE_DETECT_H
#define TULLE_DETECT_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How pairs are found. All methods find the same events, near misses aside; they differ in time. */
typedef enum tulle_detect_method {
    /* one tree for each surface, refitted to the motion; skips pairs within one patch */
    TULLE_DETECT_PATCHES,
    TULLE_DETECT_REFIT, /* one tree for each surface, refitted to the motion; no patches */
    TULLE_DETECT_BVOX,  /* a backward-voxel tree, built again at each call; no patches */
    /* the paper's: a backward-voxel tree for each patch and one for the isolated triangles, joined
     * under a root; patches are grown again at each call */
    TULLE_DETECT_PAPER
} tulle_detect_method;

/* Which cone holds the normals of a triangle while it moves. */
typedef enum tulle_detect_cone {
    TULLE_CONE_BERNSTEIN, /* the smallest cone of the normal's Bernstein coefficients */
    TULLE_CONE_PAPER      /* the paper's bound by the longest normal; wider */
} tulle_detect_cone;

/* A surface: a range of vertices and a range of triangles over them. Surfaces follow one another
 * without gaps and share no vertices. */
typedef struct tulle_detect_surface {
    uint32_t vertex_begin;   /* its first vertex */
    uint32_t vertex_end;     /* one past its last vertex */
    uint32_t triangle_begin; /* its first triangle */
    uint32_t triangle_end;   /* one past its last triangle */
    double thickness;        /* [m] >= 0; two surfaces keep half the sum of their thicknesses */
    int is_obstacle;         /* 1: meets neither itself nor other obstacles */
    /* 1: its vertices stay where the first call has them (checked), so its tree is fitted once */
    int is_static;
    int ignores_self; /* 1: does not meet itself; obstacles never do */
} tulle_detect_surface;

/* Settings of a detector. Made by tulle_detect_def_default. tulle_detector_create copies all
 * arrays.
 */
typedef struct tulle_detect_def {
    uint32_t cookie;           /* set by tulle_detect_def_default, checked on use */
    const uint32_t *triangles; /* 3 * triangle_count: vertex indices */
    size_t triangle_count;     /* 0 .. 2^31 - 1 */
    size_t vertex_count;       /* 1 .. 2^31 - 1 */
    /* [m] 3 * vertex_count: positions from which trees are shaped; null: the start of the first
     * call
     */
    const double *rest;
    const tulle_detect_surface *surfaces; /* surface_count; null: all triangles are one surface */
    size_t surface_count;                 /* 0 with null; at most 4096 */
    /* surface_count^2, row-major, symmetric: whether two surfaces, or one and itself, may meet;
     * null: as the surfaces say. Pairs that the surfaces exclude stay excluded. */
    const unsigned char *collides;
    double thickness; /* [m] >= 0 of the one surface when `surfaces` is null */
    /* [m] >= 0, added to half the sum of the thicknesses. No separation exceeds 1e150. */
    double minimum_separation;
    tulle_detect_method method; /* default TULLE_DETECT_PATCHES */
    tulle_detect_cone cone;     /* for methods with patches; default TULLE_CONE_BERNSTEIN */
    /* [rad] alpha_max, > 0 and < pi/2: widest cone in which a patch grows; default 60 degrees. A
     * certified patch that is merged with others or kept may be wider, up to a half-space. */
    double max_angle;
    /* 1 (default): only patches that are proven not to touch themselves are skipped. 0: every patch
     * is, the paper's own rule, which misses collisions. */
    int has_certificate;
    /* 1: every call grows patches again. 0 (default): patches are grown at the second call, then
     * kept and checked again. The first call has none, because growing costs more than one call
     * saves. TULLE_DETECT_PAPER always grows them. */
    int grows_patches_anew;
    int threads;               /* 1 .. 256; 0 (default): one per processor */
    tulle_allocator allocator; /* zeroed: malloc without a limit */
} tulle_detect_def;
/* Settings that suit most callers: certified patches that are kept, one thread per processor. */
TULLE_API tulle_detect_def tulle_detect_def_default(void);

/* Which features an event is about. */
typedef enum tulle_detect_kind {
    TULLE_DETECT_VERTEX_FACE, /* a vertex and a triangle */
    TULLE_DETECT_EDGE_EDGE    /* two edges */
} tulle_detect_kind;

/* What happens in an event. */
typedef enum tulle_detect_state {
    /* the pair comes within its separation, or so near to it that rounding leaves it open; the
     * distance exceeds the separation for all t up to `time` */
    TULLE_DETECT_HIT,
    /* the pair is not certainly more than its separation apart at t = 0; `time` is 0 */
    TULLE_DETECT_TOUCHING_AT_START,
    TULLE_DETECT_UNRESOLVED /* as a hit, but the search for its time ended early; rare */
} tulle_detect_state;

/* A pair of features that may come within its separation. */
typedef struct tulle_detect_event {
    tulle_detect_kind kind;   /* vertex and face, or edge and edge */
    tulle_detect_state state; /* hit, touching at the start, or unresolved */
    uint32_t surfaces[2];     /* of the first and of the second feature */
    uint32_t face;            /* vertex/face: index of the triangle; else TULLE_NONE */
    /* vertex/face: the vertex, then the corners of the face; edge/edge: both ends of the first
     * edge, then of the second, the smaller index of an edge first */
    uint32_t vertices[4];
    double time; /* in [0, 1]: the pair is apart before it, see tulle_detect_state */
    /* the closest points at `time`: their difference is sum w[i] x[i]; vertex/face (1, -b0, -b1,
     * -b2), edge/edge (1-s, s, -(1-r), -r) */
    double weights[4];
    /* unit, from the second feature to the first at `time`; the common normal of the features where
     * they touch; zero where there is none */
    double normal[3];
    double distance; /* [m] at `time` */
} tulle_detect_event;

/* What a call did. Times are seconds of wall clock. */
typedef struct tulle_detect_statistics {
    /* vertex/face and edge/edge pairs whose boxes over the motion meet, without those that share a
     * vertex, and without those that patches skip */
    uint64_t box_pairs;
    /* of box_pairs: not shown apart by the first filters, which are axes, diagonals, coplanarity
     * (where the separation is 0) and the closest direction at the start */
    uint64_t filtered_pairs;
    /* of filtered_pairs: not shown apart by the closest direction at the end; these are given to
     * the time of impact */
    uint64_t tested_pairs;
    uint64_t leaf_pairs;  /* pairs of leaves of the trees visited */
    uint64_t patch_count; /* patches in use: certified patches; all if has_certificate is 0 */
    /* kept patches that held no more and were dissolved whole; not those cut or grown again */
    uint64_t uncertified_count;
    uint64_t patch_triangles;      /* triangles in the patches in use */
    uint64_t certified_by_star;    /* patches certified by the star of a vertex */
    uint64_t certified_by_contour; /* patches certified by their contour */
    uint64_t checked_again;        /* patches kept from the last call and found to hold */
    /* 0: the method has no patches, none is proven, or they do not pay, as in the first call */
    int uses_patches;
    double patch_seconds;     /* [s] growing and checking patches */
    double tree_seconds;      /* [s] building and refitting trees */
    double search_seconds;    /* [s] finding pairs and testing them */
    double event_seconds;     /* [s] sorting and filling in events */
    double total_seconds;     /* [s] the whole call */
    double traversal_seconds; /* [s] share of search_seconds: trees */
    double filter_seconds;    /* [s] share of search_seconds: filters */
    double impact_seconds;    /* [s] share of search_seconds: times of impact */
} tulle_detect_statistics;

/* The answer of a call. */
typedef struct tulle_detect_result {
    /* sorted by kind, first feature, second feature; a feature is a vertex, a face, or an edge in
     * the order of its two vertices. Owned by the detector until its next call, even if that call
     * fails. Equal events have equal bytes. */
    const tulle_detect_event *events;
    size_t event_count;                 /* length of `events` */
    double earliest_time;               /* smallest time of an event; 1 without events */
    tulle_detect_statistics statistics; /* what the call did */
} tulle_detect_result;

/* A detector. Made by tulle_detector_create, released by tulle_detector_destroy. */
typedef struct tulle_detector tulle_detector;

/* Makes a detector; `*detector` is null after an error. Triangles may have no area, be there twice,
 * and share an edge in any number. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, or a field of the
 * def, which the message names); TULLE_ERROR_INVALID_MESH
 * (an index out of range, a corner repeated, a triangle whose vertices lie outside its surface);
 * TULLE_ERROR_OUT_OF_MEMORY; TULLE_ERROR_LIMIT. */
TULLE_API tulle_status tulle_detector_create(const tulle_detect_def *def, tulle_detector **detector,
                                             tulle_error *error);
/* Releases a detector and its results. Null is fine. */
TULLE_API void tulle_detector_destroy(tulle_detector *detector);

/* Finds all events of the motion from `start` to `end`, [m] 3 * vertex_count each. A call that
 * fails leaves `result` untouched and the detector usable. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null; names the vertex that is not finite, or that moves though its surface is static),
 * TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_LIMIT. */
TULLE_API tulle_status tulle_detector_find_events(tulle_detector *detector, const double *start,
                                                  const double *end, tulle_detect_result *result,
                                                  tulle_error *error);

/* Takes events as they come. */
typedef struct tulle_detect_receiver {
    /* gets `count` events, borrowed for the call; anything but 0 asks to stop */
    int (*receive)(void *context, const tulle_detect_event *events, size_t count);
    void *context; /* handed to `receive`; the library never looks at it */
} tulle_detect_receiver;
/* Hands over all events of the motion from `start` to `end`, [m] 3 * vertex_count each, in batches
 * of at most 1024, without keeping them: result->events is null. They are the events of
 * tulle_detector_find_events, in the same order. If the receiver asks to stop, the call ends with
 * TULLE_ERROR_INTERRUPTED. A receiver without a function is refused. A receiver must not call the
 * same detector: finding and streaming are refused with TULLE_ERROR_INVALID_ARGUMENT and leave the
 * stream as it is; destroying is undefined. Other errors as of tulle_detector_find_events. */
TULLE_API tulle_status tulle_detector_stream_events(tulle_detector *detector, const double *start,
                                                    const double *end,
                                                    tulle_detect_receiver receiver,
                                                    tulle_detect_result *result,
                                                    tulle_error *error);

/* Finds only the earliest event of the motion from `start` to `end`, [m] 3 * vertex_count each: the
 * first in order among equals, or none. It leaves out pairs that cannot come earlier, which is
 * cheaper. Errors as of tulle_detector_find_events. */
TULLE_API tulle_status tulle_detector_find_earliest(tulle_detector *detector, const double *start,
                                                    const double *end, tulle_detect_result *result,
                                                    tulle_error *error);

/* The patches in use after the last call: a label for each triangle. A label above 0 is a patch
 * (not every number is used); 0 is an isolated triangle. Borrowed until the next call. Null until
 * patches are in use, for methods without patches and for a null detector. Also null if the last
 * call failed, unless a receiver stopped it. */
TULLE_API const uint32_t *tulle_detector_get_patches(const tulle_detector *detector);

#ifdef __cplusplus
}
#endif
#endif
