/* check/coplanar.c - see coplanar.h. */
#include "check/coplanar.h"

#include "geom/exact_predicates.h"

int coplanar_orient(int axis, const double *a, const double *b, const double *c,
                    size_t *exact_count) {
    int const u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    return orient2d_sign((double[2]){a[u], a[v]}, (double[2]){b[u], b[v]}, (double[2]){c[u], c[v]},
                         exact_count);
}

int coplanar_choose_axis(const double *a, const double *b, const double *c, size_t *exact_count) {
    for (int axis = 2; axis >= 0; axis--)
        if (coplanar_orient(axis, a, b, c, exact_count) != 0) return axis;
    return -1;
}

bool coplanar_edge_separates(int axis, const double *const triangle[3], const double *const *points,
                             int count, size_t *exact_count) {
    int const turn = coplanar_orient(axis, triangle[0], triangle[1], triangle[2], exact_count);
    for (int i = 0; i < 3; i++) {
        int outside = 0;
        while (outside < count && coplanar_orient(axis, triangle[i], triangle[(i + 1) % 3],
                                                  points[outside], exact_count) == -turn)
            outside++;
        if (outside == count) return true;
    }
    return false;
}

/* Close to the common vertex v each triangle is the cone of directions between its two edges. The
 * triangles share more than v exactly when the closed cones share a direction. Both cones are
 * narrower than half a turn, so then the first edge of one of them lies in the other. A direction
 * lies in a counterclockwise cone when it is not to the right of the first edge and not to the left
 * of the second. */
bool coplanar_triangles_meet_beyond_vertex(int axis, const double *const a[3],
                                           const double *const b[3], size_t *exact_count) {
    const double *const v = a[0];
    bool const is_a_clockwise = coplanar_orient(axis, v, a[1], a[2], exact_count) < 0;
    bool const is_b_clockwise = coplanar_orient(axis, v, b[1], b[2], exact_count) < 0;
    const double *const a1 = a[is_a_clockwise ? 2 : 1], *const a2 = a[is_a_clockwise ? 1 : 2];
    const double *const b1 = b[is_b_clockwise ? 2 : 1], *const b2 = b[is_b_clockwise ? 1 : 2];
    int const a1b1 = coplanar_orient(axis, v, a1, b1, exact_count);
    if (a1b1 >= 0 && coplanar_orient(axis, v, a2, b1, exact_count) <= 0) return true;
    return a1b1 <= 0 && coplanar_orient(axis, v, a1, b2, exact_count) >= 0;
}
