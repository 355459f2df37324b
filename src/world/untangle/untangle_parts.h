/* world/untangle/untangle_parts.h - what the files of untangling share: contours of intersection on
 * the present positions, the sides that they cut off, and the displacements of a round. All arrays
 * lie in the world's scratch arena. */
#ifndef TULLE_WORLD_UNTANGLE_UNTANGLE_PARTS_H
#define TULLE_WORLD_UNTANGLE_UNTANGLE_PARTS_H

#include "contact/pairs/pair_rules.h"
#include "world/untangle/orientation.h"
#include "world/world_state.h"

/* Neither end of a crossing edge is known to be on the wrong side. */
enum { CROSSING_UNDECIDED = 2 };

/* An edge that passes through a triangle, both in the world's numbering. */
typedef struct surface_crossing {
    uint32_t edge, triangle;
    double along;      /* 0 .. 1 from the edge's first end to its second */
    double weights[3]; /* of the triangle's corners at the crossing */
    vec3 pull;         /* where the edge goes: sum of unit directions along the contour, or aimed */
    uint32_t contour;
    uint32_t wrong_end; /* 0, 1, or CROSSING_UNDECIDED */
    bool is_joint;      /* of a contour that was decided together with others */
} surface_crossing;

/* Crossings sorted by contour: connected lines of intersection. */
typedef struct contour_set {
    surface_crossing *crossings;
    size_t count;
    tulle_intersection *loose; /* pairs that touch without a crossing */
    size_t loose_count;
} contour_set;

/* Crossings begin .. end - 1 are of one contour, of an edge or triangle of each surface. */
typedef struct contour_range {
    size_t begin, end;
    uint32_t cloth, obstacle;
    bool is_open; /* parts no surface by itself */
} contour_range;

/* Regions into which cut edges part surfaces. */
typedef struct flood {
    uint32_t mark;  /* of cut edges */
    uint32_t begin; /* number of the first region */
    double *weights;
    uint32_t count;
} flood;

typedef struct untangling {
    tulle_world *world;
    const topology *topo;
    double *positions;   /* [m] all vertices, being cleaned */
    double *best;        /* [m] those with fewest pairs so far */
    size_t best_count;   /* of pairs */
    double *recent;      /* [m] those with fewest pairs of this attempt */
    size_t recent_count; /* of pairs */
    int stalled;         /* rounds since */
    int attempt;         /* from 0 */
    broad_phase *broad;
    pair_list pairs;      /* near ones */
    side_history history; /* decided in the last round */
    double *mobility;     /* per vertex: 1, or 0 for pins and obstacles */
    double *lengths;      /* [m] of each edge at the start */
    double *areas;        /* [m^2] of each vertex at the start */
    double mean_edge;     /* [m] of cloth */
    bool *is_closed;      /* per obstacle: every edge has two triangles */

    /* of a round */
    contour_set contours;
    bool *is_inside; /* per cloth vertex: inside a closed obstacle that it crosses */
    bool *is_astray; /* per vertex: on the wrong side of a contour, or at one */
    double *shift;   /* [m] per vertex, sums, then the displacement */
    double *votes;   /* per vertex: how many sums */
    int level;       /* of escalation, 0: none */
    bool has_gap;    /* no pair is nearer than its minimum gap */

    /* marks of floods, by vertex or edge */
    uint32_t *region, *cut, *queue;
    double *cut_along;
    uint32_t *sets, *grown; /* rows of vertices along an open contour */
    double *set_areas;      /* [m^2] */
} untangling;

/* untangle_contours.c: pairs of triangles in which an edge of one passes through the other. */
tulle_status find_crossing_pairs(untangling *work, intersection_list *list);
/* untangle_motion.c: unit normal of a triangle, unit direction of an edge. */
vec3 compute_triangle_normal(const untangling *work, uint32_t triangle);
vec3 compute_edge_direction(const untangling *work, uint32_t edge);
/* untangle_contours.c: crossings of the pairs, joined to contours. */
tulle_status make_contours(untangling *work, const intersection_list *pairs);
/* untangle_contours.c: [m] where the edge passes through the triangle. */
vec3 compute_crossing_point(const untangling *work, const surface_crossing *crossing);
/* untangle_sides.c: wrong ends of crossings, and vertices that went astray. */
tulle_status decide_sides(untangling *work);
/* Cuts the contours' edges at once and numbers the regions that hang on them. */
void flood_contours(untangling *work, const contour_range *ranges, size_t count, flood *regions);
/* Marks the regions at the wrong ends of a contour, and all corners at it. */
void mark_astray(untangling *work, const contour_range *range, const flood *regions);
/* untangle_open_sides.c: decides contours with obstacles together, if one of them alone parts
 * nothing. `regions` are added to those in use. */
tulle_status decide_joint_contours(untangling *work, contour_range *ranges, size_t count,
                                   flood *regions);
/* Aims a crossing across the contour to the wrong corners of its triangle: an edge that is on no
 * wrong side itself has to leave the triangle there. */
void aim_over_corners(const untangling *work, surface_crossing *crossing, const bool is_wrong[3]);
/* untangle_open_sides.c: wrong ends, and vertices astray, if a contour parts nothing. Its edges
 * are cut and `regions` flooded. */
void decide_open_contour(untangling *work, const contour_range *range, const flood *regions);
/* untangle_short_contours.c: undecided crossings of a short contour, if escalation asks for it.
 */
void orient_short_contour(untangling *work, const contour_range *range);
/* Adds the sides of the crossings whose wrong end is known to the history, and settles it. */
tulle_status remember_crossings(untangling *work);
/* untangle_calm.c: where escalation asks for it, less crumpled cloth around contours. */
void calm_surroundings(untangling *work);
/* untangle_motion.c: moves two vertices along their line until they are `low` to `high` [m] apart.
 */
void limit_distance(untangling *work, uint32_t a, uint32_t b, double low, double high);
/* untangle_motion.c: one displacement of all free vertices. */
tulle_status move_apart(untangling *work);

#endif
