/* detect/patches/planar_contour.c - see planar_contour.h.
 *
 * Star test: o(t) is the mean of the points. If cross(a - o, b - o) > 0 for every edge a, b at all
 * times, the angle about o rises along the polygon. It rises by a whole number of turns, which
 * cannot change with time, as no point ever meets o. If that number is one, the polygon is simple.
 *
 * Else all pairs of edges are tested. Two edges that share a point must meet nowhere else, all
 * others must not meet. A tree of boxes over runs of edges finds the pairs that could meet. It
 * tries the two halves of each run against one another. So for a polygon that is nowhere near
 * itself the work grows with the number of edges. */
#include "detect/patches/planar_contour.h"

#include <float.h>

/* ---- star ---- */

/* Any centre will do. Its reach is that of a point: this asks for more than is needed, but costs
 * little. */
static bool is_star(const planar_path *points, size_t count, double reach) {
    planar_path middle = {{0.0, 0.0}, {0.0, 0.0}};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 2; k++) middle.x[k] += points[i].x[k], middle.y[k] += points[i].y[k];
    double const share = 1.0 / (double)count;
    for (int k = 0; k < 2; k++) middle.x[k] *= share, middle.y[k] *= share;
    size_t turn_count = 0;
    for (size_t i = 0; i < count; i++) {
        const planar_path *const a = &points[i], *const b = &points[i + 1 < count ? i + 1 : 0];
        if (compute_turn_sign(&middle, a, b, reach) != 1) return false;
        /* Each edge turns by less than half a turn to the left, so one that comes from below the
         * ray to the right of o to it, or above, crosses it. The differences as rounded are those
         * of points within the reach, for which all turns have the same sign. */
        if (a->y[0] - middle.y[0] < 0.0 && b->y[0] - middle.y[0] >= 0.0) turn_count++;
    }
    return turn_count == 1;
}

/* ---- pairs of edges ---- */

typedef struct planar_box {
    double low[2], high[2];
} planar_box;

size_t contour_scratch_size(size_t vertex_count) {
    /* The points, and a tree of fewer than four boxes an edge. */
    return vertex_count * (sizeof(planar_path) + 4 * sizeof(planar_box));
}

/* Whether direction (x, y), the same at all times, keeps edge a, b before edge c, d by more than
 * twice the reach at both ends of the step, hence always: along it all points move linearly. */
static bool keeps_apart(const planar_path *const edge[4], double x, double y, double reach) {
    double const gap_min = 2.0 * reach * bound_length(x, y);
    for (int k = 0; k < 2; k++) {
        double along[4];
        for (int i = 0; i < 4; i++) along[i] = x * edge[i]->x[k] + y * edge[i]->y[k];
        double const last = along[0] > along[1] ? along[0] : along[1];
        double const first = along[2] < along[3] ? along[2] : along[3];
        if (!(first - last > gap_min)) return false;
    }
    return true;
}

/* Edges a, b and c, d that share no point. */
static bool are_apart(const planar_path *a, const planar_path *b, const planar_path *c,
                      const planar_path *d, double reach) {
    const planar_path *const edge[4] = {a, b, c, d};
    for (int k = 0; k < 2; k++) {
        double const x = (c->x[k] + d->x[k]) - (a->x[k] + b->x[k]);
        double const y = (c->y[k] + d->y[k]) - (a->y[k] + b->y[k]);
        if (keeps_apart(edge, x, y, reach)) return true;
    }
    int const side_c = compute_turn_sign(a, b, c, reach);
    if (side_c != 0 && side_c == compute_turn_sign(a, b, d, reach)) return true;
    int const side_a = compute_turn_sign(c, d, a, reach);
    if (side_a != 0 && side_a == compute_turn_sign(c, d, b, reach)) return true;
    for (int k = 0; k < 2; k++) { /* along either edge, from the first to the second */
        double const ux = b->x[k] - a->x[k], uy = b->y[k] - a->y[k];
        double const vx = d->x[k] - c->x[k], vy = d->y[k] - c->y[k];
        if (keeps_apart(edge, ux, uy, reach) || keeps_apart(edge, -ux, -uy, reach) ||
            keeps_apart(edge, vx, vy, reach) || keeps_apart(edge, -vx, -vy, reach))
            return true;
    }
    return false;
}

/* Edges a, v and v, b meet only at v. */
static bool meet_only_at(const planar_path *a, const planar_path *v, const planar_path *b,
                         double reach) {
    /* The angle at v stays over a right one: dot(a - v, b - v) < 0, whose error by displacements is
     * at most 2 r (|a - v| + |b - v|) + 4 r^2. */
    double ux[2], uy[2], wx[2], wy[2], length[2];
    for (int k = 0; k < 2; k++) {
        ux[k] = a->x[k] - v->x[k], uy[k] = a->y[k] - v->y[k];
        wx[k] = b->x[k] - v->x[k], wy[k] = b->y[k] - v->y[k];
        length[k] = bound_length(ux[k], uy[k]) + bound_length(wx[k], wy[k]);
    }
    double const second = 4.0 * reach * reach;
    double const mixed = 0.5 * ((ux[0] * wx[1] + uy[0] * wy[1]) + (ux[1] * wx[0] + uy[1] * wy[0]));
    if (-(ux[0] * wx[0] + uy[0] * wy[0]) > 2.0 * reach * length[0] + second &&
        -mixed > reach * (length[0] + length[1]) + second &&
        -(ux[1] * wx[1] + uy[1] * wy[1]) > 2.0 * reach * length[1] + second)
        return true;
    if (compute_turn_sign(v, a, b, reach) != 0) return true;
    for (int i = 0; i < 2; i++) { /* or one fixed direction keeps a ahead of v and b behind it */
        double const x = a->x[i] - b->x[i], y = a->y[i] - b->y[i];
        double const gap_min = 2.0 * reach * bound_length(x, y);
        bool is_ordered = true;
        for (int k = 0; k < 2 && is_ordered; k++) {
            double const middle = x * v->x[k] + y * v->y[k];
            is_ordered = (x * a->x[k] + y * a->y[k]) - middle > gap_min &&
                         middle - (x * b->x[k] + y * b->y[k]) > gap_min;
        }
        if (is_ordered) return true;
    }
    return false;
}

/* A pair of nodes to look at; the same twice: a node against itself. */
typedef struct node_pair {
    uint32_t first, second;
} node_pair;
/* Of 32 levels, each leaves at most three pairs behind. */
enum { SWEEP_STACK_SIZE = 3 * 32 + 4 };

contour_proof prove_planar_contour(const planar_path *points, size_t count, double reach,
                                   size_t max_tests, void *scratch) {
    if (count < 3 || count > UINT32_MAX / 4 || !(reach > 0.0)) return CONTOUR_UNPROVEN;
    if (is_star(points, count, reach)) return CONTOUR_STAR;

    /* A tree of boxes over the whole step. The root is node 1, the children of node i are 2 i and
     * 2 i + 1, and the leaves are the edges: edge i joins points i and i + 1. */
    planar_box *const boxes = scratch;
    size_t leaf_count = 1;
    while (leaf_count < count) leaf_count *= 2;
    for (size_t i = 0; i < leaf_count; i++) {
        planar_box *const box = &boxes[leaf_count + i];
        *box = (planar_box){{DBL_MAX, DBL_MAX}, {-DBL_MAX, -DBL_MAX}};
        if (i >= count) continue;
        const planar_path *const a = &points[i], *const b = &points[i + 1 < count ? i + 1 : 0];
        const double *const sides[2][2] = {{a->x, b->x}, {a->y, b->y}};
        for (int k = 0; k < 2; k++) {
            double low = sides[k][0][0], high = low;
            for (int corner = 1; corner < 4; corner++) {
                double const at = sides[k][corner / 2][corner % 2];
                low = at < low ? at : low;
                high = at > high ? at : high;
            }
            box->low[k] = low - reach;
            box->high[k] = high + reach;
        }
    }
    for (size_t i = leaf_count - 1; i > 0; i--) {
        const planar_box *const a = &boxes[2 * i], *const b = a + 1;
        for (int k = 0; k < 2; k++) {
            boxes[i].low[k] = a->low[k] < b->low[k] ? a->low[k] : b->low[k];
            boxes[i].high[k] = a->high[k] > b->high[k] ? a->high[k] : b->high[k];
        }
    }

    /* All pairs of nodes whose boxes meet, down to pairs of edges. */
    node_pair stack[SWEEP_STACK_SIZE] = {{1, 1}};
    size_t depth = 1;
    while (depth > 0) {
        node_pair const pair = stack[--depth];
        if (pair.first == pair.second) {
            if (pair.first >= leaf_count) continue;
            uint32_t const child = 2 * pair.first;
            stack[depth++] = (node_pair){child, child};
            stack[depth++] = (node_pair){child + 1, child + 1};
            stack[depth++] = (node_pair){child, child + 1};
            continue;
        }
        if (max_tests-- == 0) return CONTOUR_UNPROVEN;
        const planar_box *const one = &boxes[pair.first], *const two = &boxes[pair.second];
        bool const may_meet = one->low[0] <= two->high[0] && two->low[0] <= one->high[0] &&
                              one->low[1] <= two->high[1] && two->low[1] <= one->high[1];
        if (!may_meet) continue;
        if (pair.first < leaf_count) {
            for (uint32_t i = 0; i < 4; i++)
                stack[depth++] = (node_pair){2 * pair.first + (i >> 1), 2 * pair.second + (i & 1)};
            continue;
        }

        /* Edges a, b and c, d, of which the first comes before the second; b may be c, or d a. */
        size_t const first = pair.first - leaf_count, second = pair.second - leaf_count;
        const planar_path *const a = &points[first], *const b = a + 1, *const c = &points[second];
        const planar_path *const d = &points[second + 1 < count ? second + 1 : 0];
        bool const is_apart = b == c   ? meet_only_at(a, b, d, reach)
                              : d == a ? meet_only_at(c, d, b, reach)
                                       : are_apart(a, b, c, d, reach);
        if (!is_apart) return CONTOUR_UNPROVEN;
    }
    return CONTOUR_SWEPT;
}
