/* check/degenerate.c - see degenerate.h.
 *
 * A triangle without area is the segment between its two extreme corners; on a line, the first and
 * the last in the lexicographic order of (x, y, z) are the extremes, since this order is monotone
 * along any line. A point is a segment with equal ends.
 */
#include "check/degenerate.h"

#include "check/coplanar.h"
#include "geom/exact_predicates.h"

typedef struct segment {
    const double *low, *high; /* in lexicographic order */
} segment;

static int compare_points(const double *p, const double *q) {
    for (int axis = 0; axis < 3; axis++)
        if (p[axis] != q[axis]) return p[axis] < q[axis] ? -1 : 1;
    return 0;
}

/* The segment between the extremes of points on one line. */
static segment make_hull(const double *const *points, int count) {
    segment hull = {points[0], points[0]};
    for (int i = 1; i < count; i++) {
        if (compare_points(points[i], hull.low) < 0) hull.low = points[i];
        if (compare_points(points[i], hull.high) > 0) hull.high = points[i];
    }
    return hull;
}

/* Whether two segments have a common point. */
static bool segments_meet(segment s, segment t, size_t *exact_count) {
    if (orient3d_sign(s.low, s.high, t.low, t.high, exact_count) != 0) return false;
    int axis = coplanar_choose_axis(s.low, s.high, t.low, exact_count);
    if (axis < 0) axis = coplanar_choose_axis(s.low, s.high, t.high, exact_count);
    if (axis < 0) axis = coplanar_choose_axis(t.low, t.high, s.low, exact_count);
    if (axis < 0) axis = coplanar_choose_axis(t.low, t.high, s.high, exact_count);
    if (axis < 0) /* all on one line: two intervals */
        return compare_points(s.low, t.high) <= 0 && compare_points(t.low, s.high) <= 0;
    /* In their plane, not all on a line: disjoint when the line of one has the other strictly on
     * one side. */
    return coplanar_orient(axis, s.low, s.high, t.low, exact_count) *
                   coplanar_orient(axis, s.low, s.high, t.high, exact_count) <=
               0 &&
           coplanar_orient(axis, t.low, t.high, s.low, exact_count) *
                   coplanar_orient(axis, t.low, t.high, s.high, exact_count) <=
               0;
}

/* Whether a segment and a triangle with area have a common point. The segment meets the triangle's
 * plane in one point if its ends are neither both in the plane nor strictly on one side of it. That
 * point is in the triangle when the segment's line passes all three edges on the same side. */
static bool segment_meets_triangle(segment s, const double *const triangle[3], int axis,
                                   size_t *exact_count) {
    int const low = orient3d_sign(triangle[0], triangle[1], triangle[2], s.low, exact_count);
    int const high = orient3d_sign(triangle[0], triangle[1], triangle[2], s.high, exact_count);
    if (low * high > 0) return false;
    if (low == 0 && high == 0) {
        /* Convex polygons in one plane, of which the segment has two corners. The line of an edge
         * of one of them separates them; it may be that of the segment. */
        const double *const ends[2] = {s.low, s.high};
        if (coplanar_edge_separates(axis, triangle, ends, 2, exact_count)) return false;
        int const side = coplanar_orient(axis, s.low, s.high, triangle[0], exact_count);
        return side == 0 ||
               coplanar_orient(axis, s.low, s.high, triangle[1], exact_count) != side ||
               coplanar_orient(axis, s.low, s.high, triangle[2], exact_count) != side;
    }
    bool has_positive = false, has_negative = false;
    for (int i = 0; i < 3; i++) {
        int const side =
            orient3d_sign(s.low, s.high, triangle[i], triangle[(i + 1) % 3], exact_count);
        has_positive |= side > 0;
        has_negative |= side < 0;
    }
    return !(has_positive && has_negative);
}

bool degenerate_triangles_meet(const double *const a[3], int axis_a, const double *const b[3],
                               int axis_b, int shared_count, size_t *exact_count) {
    segment const s = make_hull(axis_a < 0 ? a : b, 3);
    if (axis_a < 0 && axis_b < 0) {
        segment const t = make_hull(b, 3);
        if (shared_count == 0) return segments_meet(s, t, exact_count);

        /* Both contain the hull of the shared corners. On different lines they meet in one point at
         * most; on one line they are intervals, which may reach beyond that hull. */
        segment const shared = make_hull(a, shared_count);
        const double *const s_ends[2] = {s.low, s.high}, *const t_ends[2] = {t.low, t.high};
        for (int i = 0; i < 2; i++)
            if (coplanar_choose_axis(s.low, s.high, t_ends[i], exact_count) >= 0 ||
                coplanar_choose_axis(t.low, t.high, s_ends[i], exact_count) >= 0)
                return false;
        const double *const low = compare_points(s.low, t.low) > 0 ? s.low : t.low;
        const double *const high = compare_points(s.high, t.high) < 0 ? s.high : t.high;
        return compare_points(low, shared.low) < 0 || compare_points(high, shared.high) > 0;
    }
    const double *const *const triangle = axis_a < 0 ? b : a;
    int const axis = axis_a < 0 ? axis_b : axis_a;
    if (shared_count == 0) return segment_meets_triangle(s, triangle, axis, exact_count);
    if (shared_count == 1) {
        /* The segment contains corner 0. Its part from there to one end reaches beyond the corner
         * in the triangle in two cases: that end is in the triangle, or the part leaves it through
         * the opposite edge, which does not contain the corner. */
        segment const opposite = make_hull(triangle + 1, 2);
        const double *const ends[2] = {s.low, s.high};
        for (int i = 0; i < 2; i++) {
            if (compare_points(ends[i], triangle[0]) == 0) continue;
            segment const part = make_hull((const double *const[]){triangle[0], ends[i]}, 2);
            if (segment_meets_triangle((segment){ends[i], ends[i]}, triangle, axis, exact_count) ||
                segments_meet(part, opposite, exact_count))
                return true;
        }
        return false;
    }
    /* The segment lies on the line of the triangle's edge, where the triangle has that edge only.
     */
    return false;
}
