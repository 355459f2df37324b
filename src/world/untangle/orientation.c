/* world/untangle/orientation.c - see orientation.h.
 *
 * Only starts that intersect need these rules. In other states the normal is the unit vector
 * between the closest points.
 *
 * The verification has a closed form. Let d_i be the corners' signed distances along the axis.
 * Moving the first triangle by e and the second by -e changes sum d_i^2 by
 * 2 e (sum_1 d - sum_2 d) + 6 e^2. So the axis that points from the second centroid to the first
 * has the larger change.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6. Departures: normals point from the second feature to the first; on borders,
 * where an edge has one opposite vertex, that one decides. */
#include "world/untangle/orientation.h"

#include <stdlib.h>

/* A normal of the history that differs by more than 60 degrees from the line decides nothing. */
static const double LEAST_COSINE = 0.5;

static orientation get_sign(double value) {
    if (value > 0.0) return ORIENTATION_ALONG;
    return value < 0.0 ? ORIENTATION_AGAINST : ORIENTATION_UNDECIDED;
}

tulle_status remember_side(side_history *history, memory *heap, known_side side) {
    if (!ARRAY_RESERVE(heap, &history->sides, 1)) return TULLE_ERROR_OUT_OF_MEMORY;
    history->sides.data[history->sides.count++] = side;
    return TULLE_OK;
}

static int compare_pairs(const void *a, const void *b) {
    const known_side *const x = a, *const y = b;
    if (x->vertex != y->vertex) return x->vertex < y->vertex ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

void settle_history(side_history *history) {
    known_side *const sides = history->sides.data;
    size_t const count = history->sides.count;
    if (count == 0) return;
    qsort(sides, count, sizeof *sides, compare_pairs);
    size_t kept = 0;
    for (size_t begin = 0, end; begin < count; begin = end) {
        bool agree = true;
        for (end = begin + 1; end < count && compare_pairs(&sides[begin], &sides[end]) == 0; end++)
            agree = agree && vec3_dot(sides[begin].normal, sides[end].normal) > 0.0;
        if (agree) sides[kept++] = sides[begin];
    }
    history->sides.count = kept;
}

orientation orient_by_history(const topology *topo, const side_history *history,
                              feature_pair vertex_triangle, vec3 axis) {
    const known_side *const sides = history->sides.data;
    const uint32_t *const corners = topo->triangles + 3 * (size_t)vertex_triangle.second;
    size_t low = 0, high = history->sides.count; /* the first side of the vertex, by bisection */
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (sides[middle].vertex < vertex_triangle.first)
            low = middle + 1;
        else
            high = middle;
    }
    int votes = 0;
    for (size_t i = low; i < history->sides.count && sides[i].vertex == vertex_triangle.first;
         i++) {
        double const cosine = vec3_dot(sides[i].normal, axis);
        orientation const own =
            fabs(cosine) >= LEAST_COSINE ? get_sign(cosine) : ORIENTATION_UNDECIDED;
        if (sides[i].triangle == vertex_triangle.second) return own;
        const uint32_t *const others = topo->triangles + 3 * (size_t)sides[i].triangle;
        bool shares_corner = false;
        for (size_t a = 0; a < 3; a++)
            for (size_t b = 0; b < 3; b++) shares_corner |= others[a] == corners[b];
        if (shares_corner) votes += own;
    }
    return get_sign(votes);
}

static orientation side_of_vertex(const oriented_pair *question, const double *positions,
                                  uint32_t vertex) {
    vec3 const to = vec3_sub(vec3_load(positions, vertex), question->point);
    return get_sign(vec3_dot(question->axis, to));
}

orientation orient_by_neighbours(const topology *topo, const double *positions,
                                 const oriented_pair *question) {
    orientation side = ORIENTATION_UNDECIDED;
    if (question->kind == FEATURE_VERTEX_TRIANGLE) {
        /* the common side of all neighbours, if there is one */
        const adjacency *const around = &topo->vertex_neighbours;
        uint32_t const vertex = question->pair.first;
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
            orientation const own = side_of_vertex(question, positions, around->items[i]);
            if (side != ORIENTATION_UNDECIDED && own != side) return ORIENTATION_UNDECIDED;
            side = own;
        }
        return side;
    }
    const uint32_t edges[2] = {question->pair.first, question->pair.second};
    orientation of_edges[2]; /* the common sides of the vertices opposite them */
    for (int k = 0; k < 2; k++) {
        const uint32_t *const opposites = topo->edge_opposites + 2 * (size_t)edges[k];
        of_edges[k] = ORIENTATION_UNDECIDED;
        if (opposites[0] != TULLE_NONE)
            of_edges[k] = side_of_vertex(question, positions, opposites[0]);
        if (opposites[1] != TULLE_NONE &&
            side_of_vertex(question, positions, opposites[1]) != of_edges[k])
            of_edges[k] = ORIENTATION_UNDECIDED;
    }
    return (int)of_edges[0] == -(int)of_edges[1] ? of_edges[0] : ORIENTATION_UNDECIDED;
}

orientation orient_by_triangles(const topology *topo, const double *positions, uint32_t first,
                                uint32_t second, vec3 axis) {
    vec3 sums[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}; /* of corners */
    for (int triangle = 0; triangle < 2; triangle++) {
        const uint32_t *const corner =
            topo->triangles + 3 * (size_t)(triangle == 0 ? first : second);
        for (int k = 0; k < 3; k++)
            sums[triangle] = vec3_add(sums[triangle], vec3_load(positions, corner[k]));
    }
    return get_sign(vec3_dot(axis, vec3_sub(sums[0], sums[1])));
}
