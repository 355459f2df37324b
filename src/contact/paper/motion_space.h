/* contact/paper/motion_space.h - where a vertex in contact may move.
 *
 * Gives the paper's algebra of canonical cones, and motion spaces of two kinds behind one
 * interface. Vectors are velocities [m/s] or forces [N]; the half-spaces of forces have offsets 0.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 4 and appendix. */
#ifndef TULLE_CONTACT_PAPER_MOTION_SPACE_H
#define TULLE_CONTACT_PAPER_MOTION_SPACE_H

#include "contact/paper/half_spaces.h"
#include "tulle/paper.h"

/* All directions that make at most `angle` with the axis. With an axis of zero the cone is empty:
 * it holds only the zero vector. */
typedef struct canonical_cone {
    vec3 axis;    /* unit, or zero */
    double angle; /* [rad] 0 .. pi / 2; pi / 2 is a half-space */
} canonical_cone;

/* v . C. If v lies inside the cone this is v. Else it is the projection of v on the direction of
 * the boundary that lies in the plane of v and the axis, or 0 where v points away from that
 * direction. That is the point of C nearest to v. */
vec3 canonical_cone_project(const canonical_cone *cone, vec3 v);
/* The cone of the largest angle inside all half-spaces, as if their offsets were 0. For two
 * half-spaces it is C1 ^ C2. For more, ^ applied pair by pair may give a smaller cone, which
 * depends on the order. */
canonical_cone canonical_cone_inscribe(const half_space *spaces, size_t count);

/* Z(C, N). */
typedef struct motion_space {
    tulle_motion_space kind;
    const half_space *half_spaces; /* N, borrowed; only polyhedral spaces read the offsets */
    size_t count;
    canonical_cone cone; /* C; set for the kind cone only */
} motion_space;

motion_space motion_space_make(tulle_motion_space kind, const half_space *half_spaces,
                               size_t count);

/* Whether v lies in every half-space of N, up to a billionth of its size. */
bool motion_space_contains(const motion_space *space, vec3 v);

/* v . Z = v_T, the part of v that the space allows. v_N is the rest of v.
 *  cone: v if N contains it, else the projection of v on C.
 *  polyhedral: the point of the intersection that is nearest to v. It is too far if it lies further
 *  from v than 20 times the largest violation: the intersection is then a sharp wedge. If there is
 *  no point, or it is too far, offsets drop to min(offset, 0), so that zero is always allowed; the
 *  answer is the nearest point of these half-spaces. If that is too far as well, as between two
 * layers whose normals rounding has tilted, zero would lock the vertex. Then the answer is the
 * point x with the least |x - v|^2 + 400 sum missed^2, for the offsets as given. */
vec3 motion_space_project(const motion_space *space, vec3 v);

#endif
