/* check/triangle_pair.c - see triangle_pair.h.
 *
 * All decisions come from signs of orientation determinants, none from computed points.
 *
 * No shared vertex. If the corners of one triangle lie strictly on one side of the other's plane
 * they are disjoint. If the planes differ, the triangles meet exactly when an edge of one meets the
 * other triangle: their intersection is a segment (or point), and its ends lie on the boundary of
 * one of them. An edge whose ends are not strictly on one side of the plane, and not both in it,
 * crosses it in one point, which belongs to the triangle when the edge's line passes the three
 * edges on the same side (or touches): three determinants. Edges that lie in the other's plane can
 * be left out: an end of the intersection on such an edge is an end of the edge, where another edge
 * of the same triangle leaves the plane, or it is on an edge of the other triangle, to which the
 * same applies.
 *
 * One shared vertex v. A common segment that starts in v leaves one of the triangles through its
 * edge opposite to v. So the triangles intersect exactly when such an edge meets the other
 * triangle. Of the three determinants two are plane signs that are known already, and the third,
 * |a1 a2 b1 b2|, is the same for both edges: five determinants decide.
 *
 * Two shared vertices. Different planes meet in the line of the shared edge, where both triangles
 * have just that edge. In one plane the triangles overlap exactly when their third corners are on
 * the same side of it.
 *
 * Two corners in one place, not both shared, are a common point; two shared vertices are left out,
 * because the point may lie on their edge. Else no coordinates are compared.
 *
 * All plane signs zero: the triangles are coplanar (coplanar.h) or without area (degenerate.h).
 *
 * Based on: P. Guigue and O. Devillers, "Fast and Robust Triangle-Triangle Overlap Test Using
 * Orientation Predicates", 2003: the idea of using orientation signs alone. Departure: edges
 * against triangles rather than the order of interval ends on the common line, which needs no
 * relabelling of corners and covers touching and shared vertices by the same argument.
 */
#include "check/triangle_pair.h"

#include "check/coplanar.h"
#include "check/degenerate.h"
#include "geom/exact_predicates.h"

#include <string.h>

static bool is_one_point(const double *p, const double *q) {
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

/* Moves the corners with shared vertex numbers to the front, in the same order in both. Returns how
 * many different ones there are. */
static int sort_shared_first(check_triangle *a, check_triangle *b) {
    int shared_count = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = shared_count; j < 3; j++) {
            if (a->vertices[i] != b->vertices[j]) continue;
            check_triangle const a_before = *a, b_before = *b;
            a->vertices[i] = a_before.vertices[shared_count];
            a->corners[i] = a_before.corners[shared_count];
            b->vertices[j] = b_before.vertices[shared_count];
            b->corners[j] = b_before.corners[shared_count];
            a->vertices[shared_count] = a_before.vertices[i];
            a->corners[shared_count] = a_before.corners[i];
            b->vertices[shared_count] = b_before.vertices[j];
            b->corners[shared_count] = b_before.corners[j];
            shared_count++;
            break;
        }
    }
    return shared_count;
}

/* Whether corners behind the shared ones are one point, outside what is shared. This spares many
 * exact signs where triangles lie on one another. */
static bool corners_coincide(const double *const a[3], const double *const b[3], int shared_count) {
    for (int i = shared_count; i < 3; i++)
        for (int j = shared_count; j < 3; j++)
            if (is_one_point(a[i], b[j]) && !(shared_count == 1 && is_one_point(a[i], a[0])))
                return true;
    return false;
}

/* Coplanar or degenerate triangles, shared corners in front. */
static bool flat_triangles_intersect(const double *const a[3], const double *const b[3],
                                     int shared_count, size_t *exact_count) {
    int const axis_a = coplanar_choose_axis(a[0], a[1], a[2], exact_count);
    int const axis_b = coplanar_choose_axis(b[0], b[1], b[2], exact_count);
    if (axis_a < 0 || axis_b < 0)
        return degenerate_triangles_meet(a, axis_a, b, axis_b, shared_count, exact_count);
    if (shared_count == 0) /* disjoint convex polygons: the line of an edge of one separates them */
        return !coplanar_edge_separates(axis_a, a, b, 3, exact_count) &&
               !coplanar_edge_separates(axis_a, b, a, 3, exact_count);
    if (shared_count == 1) return coplanar_triangles_meet_beyond_vertex(axis_a, a, b, exact_count);
    return coplanar_orient(axis_a, a[0], a[1], a[2], exact_count) ==
           coplanar_orient(axis_a, a[0], a[1], b[2], exact_count);
}

/* Whether an edge of `a` that crosses or touches the plane of `b`, and does not lie in it, meets
 * `b`. sides: of a's corners with respect to that plane. */
static bool edges_meet_triangle(const double *const a[3], const int sides[3],
                                const double *const b[3], size_t *exact_count) {
    for (int i = 0; i < 3; i++) {
        int const j = (i + 1) % 3;
        if (sides[i] * sides[j] > 0 || (sides[i] == 0 && sides[j] == 0)) continue;
        bool has_positive = false, has_negative = false;
        for (int k = 0; k < 3 && !(has_positive && has_negative); k++) {
            int const side = orient3d_sign(a[i], a[j], b[k], b[(k + 1) % 3], exact_count);
            has_positive |= side > 0;
            has_negative |= side < 0;
        }
        if (!(has_positive && has_negative)) return true;
    }
    return false;
}

/* Triangles without a shared vertex. */
static bool separate_triangles_intersect(const double *const a[3], const double *const b[3],
                                         size_t *exact_count) {
    const double *const *const triangles[2] = {a, b};
    int sides[2][3]; /* of each triangle's corners with respect to the other's plane */
    bool is_flat = false;
    for (int own = 1; own >= 0; own--) {
        const double *const *const plane = triangles[1 - own];
        int *const side = sides[own];
        for (int k = 0; k < 3; k++)
            side[k] = orient3d_sign(plane[0], plane[1], plane[2], triangles[own][k], exact_count);
        bool const is_one_side = side[0] == side[1] && side[1] == side[2];
        if (is_one_side && side[0] != 0) return false;
        is_flat = is_flat || is_one_side;
    }
    if (is_flat) return flat_triangles_intersect(a, b, 0, exact_count);
    return edges_meet_triangle(a, sides[0], b, exact_count) ||
           edges_meet_triangle(b, sides[1], a, exact_count);
}

/* Triangles that share corner 0. */
static bool vertex_neighbours_intersect(const double *const a[3], const double *const b[3],
                                        size_t *exact_count) {
    int const b1 = orient3d_sign(a[0], a[1], a[2], b[1], exact_count);
    int const b2 = orient3d_sign(a[0], a[1], a[2], b[2], exact_count);
    if (b1 * b2 > 0) return false;
    int const a1 = orient3d_sign(b[0], b[1], b[2], a[1], exact_count);
    int const a2 = orient3d_sign(b[0], b[1], b[2], a[2], exact_count);
    if (a1 * a2 > 0) return false;
    if ((b1 == 0 && b2 == 0) || (a1 == 0 && a2 == 0))
        return flat_triangles_intersect(a, b, 1, exact_count);
    /* Edge a1 a2 passes the edges v b1, b1 b2, b2 v of b with signs b1, across, -b2; edge b1 b2
     * those of a with signs a1, across, -a2. */
    int const across = orient3d_sign(a[1], a[2], b[1], b[2], exact_count);
    return across == 0 || across == (b1 ? b1 : -b2) || across == (a1 ? a1 : -a2);
}

bool triangles_intersect(const check_triangle *a, const check_triangle *b, bool can_share,
                         size_t *exact_count) {
    if (can_share && memcmp(a->vertices, b->vertices, sizeof a->vertices) == 0) return true;
    check_triangle first = *a, second = *b;
    int const shared_count = can_share ? sort_shared_first(&first, &second) : 0;
    const double *const *const p = first.corners;
    const double *const *const q = second.corners;
    if (shared_count < 2 && corners_coincide(p, q, shared_count)) return true;
    switch (shared_count) {
    case 0: return separate_triangles_intersect(p, q, exact_count);
    case 1: return vertex_neighbours_intersect(p, q, exact_count);
    case 2:
        return orient3d_sign(p[0], p[1], p[2], q[2], exact_count) == 0 &&
               flat_triangles_intersect(p, q, 2, exact_count);
    default: return true;
    }
}
