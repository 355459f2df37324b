/* detect/patches/kept_patches_parts.h - what the files of kept patches share.
 *
 * A patch keeps its triangles in the order in which they joined, so every first part of that list
 * is a disc too. It numbers its vertices in the order in which they came. The corners of its
 * triangles and its boundary are then small numbers, and its projected vertices one dense array.
 * Large patches have their vertices and corners in the order of the mesh instead, for the sake of
 * the cache; after growth it does not matter which corners belong to which triangle. */
#ifndef TULLE_DETECT_PATCHES_KEPT_PATCHES_PARTS_H
#define TULLE_DETECT_PATCHES_KEPT_PATCHES_PARTS_H

#include "detect/patches/certificate.h"
#include "detect/patches/kept_patches.h"
#include "detect/patches/planar_path.h"

/* Instead of a neighbour. NONE: no triangle is there. BARRED: no disc may continue across the edge,
 * because it has more than two triangles or both run along it the same way. */
#define NEIGHBOUR_NONE UINT32_MAX
#define NEIGHBOUR_BARRED (UINT32_MAX - 1)

typedef enum patch_verdict {
    PATCH_HOLDS_BY_STAR,
    PATCH_HOLDS_BY_SWEEP,
    PATCH_HOLDS_BY_CONE,               /* without certificate */
    PATCH_HOLDS = PATCH_HOLDS_BY_CONE, /* up to this verdict a patch holds */
    PATCH_TURNED,                      /* a triangle may turn away from the axis */
    PATCH_CROSSED,                     /* its boundary may touch itself */
    PATCH_LEFT                         /* its surface is absent, or does not meet itself any more */
} patch_verdict;

typedef struct kept_patch {
    vec3 axis;
    uint32_t triangle_begin, triangle_count; /* in `triangles`; count 0: the label is unused */
    uint32_t vertex_begin, vertex_count;     /* in `vertices` */
    uint32_t loop_begin, loop_count;         /* in `loops`; count 0 where no contour is needed */
    uint32_t surface;
    uint32_t verdict; /* patch_verdict of the last check */
} kept_patch;

/* A share of all checks: a part of the check of one large patch, or small patches as a whole. */
typedef enum check_kind { CHECK_PROJECTION, CHECK_CONTOUR, CHECK_TURNS, CHECK_WHOLE } check_kind;
typedef struct check_task {
    uint32_t kind;       /* check_kind */
    uint32_t patch;      /* the large one */
    uint32_t begin, end; /* vertices, triangles or patches */
    uint32_t verdict;    /* result of CHECK_CONTOUR and CHECK_TURNS */
    double size;         /* [m] result of CHECK_PROJECTION */
    double reach;        /* [m] planar, of CHECK_CONTOUR and CHECK_TURNS */
} check_task;

/* What decides when patches are grown; counts only, so that runs can be repeated. */
typedef struct patch_schedule {
    uint64_t call_count;
    uint64_t regrow_at, regrow_wait; /* [calls] */
    uint64_t retry_at, retry_wait;   /* [calls] while switched off */
    uint64_t merge_at, merge_wait;   /* [calls] */
    uint64_t grown_at;               /* [calls] since when patches are in use */
    uint64_t credit;                 /* [pairs of leaves] for repairs and growth */
    uint64_t dead_triangle_count;    /* in `triangles`, of labels not used any more */
    /* [pairs of leaves] seen: by the last search; near: those of them that any search visits;
     * without: of the last search without patches, fading; with: what patches cost when they were
     * let go. */
    uint64_t seen_pairs, near_pairs, pairs_without, pairs_with;
    uint32_t is_off, has_grown, is_told;
    uint32_t has_changed; /* since patches were last merged, some were cut or grown */
} patch_schedule;

/* Scratch of growth; one entry a triangle or a vertex. */
typedef struct growth_scratch {
    normal_cone *cones; /* of triangles without patch; not valid: not to be used. Null, as limits,
                           but while all is grown */
    double *limits;     /* [rad] of triangles: half-angle of the widest patch that they join */
    uint32_t *queue;    /* triangles in the order in which they joined */
    uint32_t *local;    /* vertex: its number in the patch; where stamp is the present one */
    uint32_t *stamps, stamp; /* stamps: of each vertex */
    uint32_t *next;          /* by local number: the next vertex of the boundary */
} growth_scratch;

struct kept_patches {
    memory *heap;
    const topology *topo;
    uint32_t *neighbours; /* 3 * triangle_count */
    uint32_t *triangle_surface;
    uint32_t *labels;
    uint64_t version;          /* of the labels; not 0 */
    ARRAY(kept_patch) patches; /* label k: element k - 1 */
    ARRAY(uint32_t) triangles;
    ARRAY(uint32_t) corners; /* 3 * triangles: local numbers of vertices */
    ARRAY(uint32_t) vertices;
    ARRAY(planar_path) points; /* of vertices, of the last check */
    ARRAY(uint32_t) loops;     /* local numbers of vertices, counterclockwise */
    patch_rules rules;         /* of the last update */
    patch_schedule schedule;
    growth_scratch growth;
    arena *scratch; /* for cones and limits; null: they come from the heap */
    /* Of checks. */
    ARRAY(check_task) tasks;
    bool has_tasks; /* tasks fit the patches */
    ARRAY(unsigned char) contour_scratch;
    size_t scratch_stride; /* [bytes] a worker */
    int worker_count;
};

/* What growth and repairs go by. */
typedef struct growth_input {
    const patch_step *step;
    const patch_rules *rules;
    size_t minimum; /* triangles of the smallest patch that is kept */
} growth_input;

typedef struct patch_cover {
    uint64_t meeting; /* triangles of surfaces that may have patches */
    uint64_t covered; /* in patches */
    uint64_t useful;  /* in patches and not near their boundaries */
    uint64_t rims;    /* edges on boundaries */
} patch_cover;

/* kept_patches.c */
patch_cover measure_cover(const kept_patches *patches, const surface_set *set);
/* Leaves no patches. */
void drop_patches(kept_patches *patches);
/* Closes the gaps between patches, which lie in the same order in all arrays, and between labels,
 * whose order stays. Then there are at most as many labels as triangles. */
void compact_patches(kept_patches *patches);
/* Frees what patches took, and the scratch of growth. */
void release_patches(kept_patches *patches);

/* patch_schedule.c */
/* Whether a saved one may have come about. */
bool schedule_is_possible(const patch_schedule *schedule, uint64_t triangle_count,
                          uint64_t kept_triangle_count);
/* Begins a call: judges by the last search whether patches in use pay, and lets them go where they
 * do not. edge_count: of all boundaries. */
void judge_last_search(kept_patches *patches, uint64_t edge_count);
/* Lets patches go until the next try, and gives back what they took. */
void let_patches_go(kept_patches *patches);
/* Takes the cost of repairing a patch off the credit. False: the credit is too small, and stays. */
bool pay_for_repair(patch_schedule *schedule, uint32_t triangle_count);
/* Grows patches over everything, and merges them. */
tulle_status grow_first(kept_patches *patches, const growth_input *input, patch_counts *counts);
/* Grows patches where much is isolated, pays for it and says when the next growth may be. */
tulle_status grow_when_due(kept_patches *patches, const growth_input *input, patch_counts *counts,
                           bool *has_grown);
/* Merges certified patches where some were cut or grown, pays for it and says when the next merging
 * may be. */
tulle_status merge_when_due(kept_patches *patches, const growth_input *input, patch_counts *counts);

/* kept_patches_check.c */
/* Checks a patch as a whole. scratch: contour_scratch_size bytes for a contour of loop_count
 * vertices. */
patch_verdict check_patch(kept_patches *patches, const kept_patch *patch, const patch_step *step,
                          const patch_rules *rules, void *scratch);
/* Whether triangles begin .. end - 1 of a patch keep within max_angle of its axis. */
bool patch_faces_axis(const kept_patches *patches, const kept_patch *patch, const patch_step *step,
                      double max_angle, size_t begin, size_t end);
/* Projects local vertices begin .. end - 1 of a patch, and returns their size. */
double project_patch(kept_patches *patches, const kept_patch *patch, const patch_step *step,
                     size_t begin, size_t end);
/* Prepares tasks and scratch after patches have changed. */
tulle_status prepare_checks(kept_patches *patches, int threads);
/* Checks all patches and fills their verdicts. */
void check_patches(kept_patches *patches, const patch_step *step, const patch_rules *rules);

/* patch_merging.c: joins patches that are certified together; looks at some `budget` triangles at
 * most. */
tulle_status merge_patches(kept_patches *patches, const growth_input *input, uint64_t budget,
                           patch_counts *counts);

/* patch_growth.c */
/* Grows patches over all triangles without a label. */
tulle_status grow_kept_patches(kept_patches *patches, const growth_input *input,
                               patch_counts *counts);
/* While a patch is grown again: may join. */
#define LABEL_PASSED UINT32_MAX
/* Grows a patch of that label from a triangle: fills the queue, and returns how many joined. With a
 * cone it takes triangles without a patch, and is a disc if the rules ask for a certificate. The
 * cone becomes that of the patch; it stays within the limit of every triangle, so all of them face
 * its axis. Without a cone it takes triangles that bear LABEL_PASSED, and is a disc. */
size_t spread_patch(kept_patches *patches, const patch_rules *rules, uint32_t seed, uint32_t label,
                    normal_cone *cone);
void label_triangles(kept_patches *patches, const uint32_t *list, size_t count, uint32_t label);
/* Writes the first `count` triangles of the queue, which bear the label, behind all patches and
 * checks them; patch->verdict says what came of it. */
tulle_status stage_and_check(kept_patches *patches, const growth_input *input, size_t count,
                             uint32_t label, kept_patch *patch);
/* Repairs or dissolves patches that have failed. Large ones are not repaired: cut about their own
 * axis they lose most of their triangles, so they are grown again instead. */
tulle_status mend_patches(kept_patches *patches, const growth_input *input, patch_counts *counts);
/* Appends a patch of triangles of one surface, with is_disc those of a disc in this order.
 * INVALID_ARGUMENT where they are none. */
tulle_status append_patch(kept_patches *patches, const uint32_t *triangles, size_t count, vec3 axis,
                          bool is_disc);

/* patch_staging.c */
/* Allocates scratch of growth but for cones and limits, when there is none. */
tulle_status reserve_growth(kept_patches *patches);
/* Frees cones and limits. */
void release_cones(kept_patches *patches);
/* From now on no vertex is in the patch that grows. */
void start_patch(kept_patches *patches);
static inline bool is_in_patch(const growth_scratch *growth, uint32_t vertex) {
    return growth->stamps[vertex] == growth->stamp;
}
/* Writes the first `count` triangles of `list`, which bear the label, behind all patches, with
 * their corners and vertices, room for points, and of a disc the boundary. Then loop_count is 0
 * where that is not one loop through each of its vertices once. */
tulle_status stage_patch(kept_patches *patches, const uint32_t *list, size_t count, uint32_t label,
                         bool is_disc, kept_patch *patch);
/* Makes a staged patch that of its label. */
void commit_patch(kept_patches *patches, const kept_patch *patch, uint32_t label);

#endif
