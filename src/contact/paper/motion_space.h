/* contact/paper/motion_space.h - where a vertex in contact may move: the paper's algebra of
 * canonical cones, and motion spaces of two kinds behind one interface.
 *
 * Vectors are velocities [m/s] or forces [N] alike; the half-spaces of forces have offsets 0.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 4 and appendix. */
#ifndef TULLE_CONTACT_PAPER_MOTION_SPACE_H
#define TULLE_CONTACT_PAPER_MOTION_SPACE_H

#include "contact/paper/half_spaces.h"
#include "tulle/world.h"

/* All directions within `angle` of the axis. An axis of zero is the empty cone, which holds nothing
 * but the zero vector. */
typedef struct canonical_cone {
    vec3 axis;    /* unit, or zero */
    double angle; /* [rad] 0 .. pi / 2, the latter: a half-space */
} canonical_cone;

/* v . C: v inside the cone; else its projection on the boundary direction in the plane of v and the
 * axis, where that is positive; else 0. For v outside and these cones the nearest point of C. */
vec3 canonical_cone_project(const canonical_cone *cone, vec3 v);
/* C1 ^ C2: the cone of the largest angle inside both; empty when they have at most their tips in
 * common. */
canonical_cone canonical_cone_intersect(const canonical_cone *a, const canonical_cone *b);
/* The cone of the largest angle inside all half-spaces, as if their offsets were 0. For two it is
 * C1 ^ C2; for more, folding ^ over pairs may give a smaller one that depends on the order. */
canonical_cone canonical_cone_inscribe(const half_space *spaces, size_t count);

/* Z(C, N). */
typedef struct motion_space {
    tulle_motion_space kind;
    const half_space *half_spaces; /* N, borrowed; offsets are read for polyhedral spaces only */
    size_t count;
    canonical_cone cone; /* C, of kind cone */
} motion_space;

motion_space motion_space_make(tulle_motion_space kind, const half_space *half_spaces,
                               size_t count);

/* Whether v lies in every half-space of N, up to a billionth. */
bool motion_space_contains(const motion_space *space, vec3 v);

/* v . Z = v_T; v_N is what is left of v.
 *  cone: v where N contains it, else its projection on C.
 *  polyhedral: the nearest point of the intersection. Where that is empty, or a wedge so sharp that
 *  its nearest point lies further from v than 20 times the largest violation, the offsets drop to
 *  min(offset, 0), which zero satisfies: the answer is the nearest point of what they leave. If
 *  that too is the far end of a wedge, as between two layers whose normals rounding has tilted,
 *  where zero would lock the vertex: the point x with the least |x - v|^2 + 400 sum missed^2, of
 *  the offsets as given. */
vec3 motion_space_project(const motion_space *space, vec3 v);

#endif
