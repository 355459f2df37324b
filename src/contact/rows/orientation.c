/* contact/rows/orientation.c - see orientation.h.
 *
 * States that do not intersect need none of this: their normal is the unit vector between the
 * closest points. The rules serve starts that intersect.
 *
 * The verification in closed form: with d_i the corners' signed distances along the axis, moving
 * the first triangle by e and the second by -e changes sum d_i^2 by 2 e (sum_1 d - sum_2 d) + 6
 * e^2. The larger change belongs to the axis that points from the second centroid to the first.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6. Departures: normals point from the second feature to the first; on borders,
 * where an edge has one opposite vertex, that one decides. */
#include "contact/rows/orientation.h"

#include <stdlib.h>

/* Normals of the history that differ by more than 60 degrees from the line say nothing about it. */
#define LEAST_COSINE 0.5

static orientation sign_of(double value) {
    if (value > 0.0) return ORIENTATION_ALONG;
    return value < 0.0 ? ORIENTATION_AGAINST : ORIENTATION_UNDECIDED;
}

tulle_status remember_side(side_history *history, memory *heap, known_side side) {
    if (!ARRAY_RESERVE(heap, &history->sides, 1)) return TULLE_ERROR_OUT_OF_MEMORY;
    history->sides.data[history->sides.count++] = side;
    return TULLE_OK;
}

void side_history_destroy(side_history *history, memory *heap) {
    ARRAY_FREE(heap, &history->sides);
}

static int compare_pairs(const void *a, const void *b) {
    known_side const *const x = a, *const y = b;
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

/* The first side in the history that is not before those of a vertex. */
static size_t find_first(const side_history *history, uint32_t vertex) {
    size_t low = 0, high = history->sides.count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (history->sides.data[middle].vertex < vertex)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool share_a_corner(const topology *topo, uint32_t a, uint32_t b) {
    for (size_t i = 0; i < 3; i++)
        for (size_t j = 0; j < 3; j++)
            if (topo->triangles[3 * (size_t)a + i] == topo->triangles[3 * (size_t)b + j])
                return true;
    return false;
}

static orientation compare_normals(vec3 normal, vec3 axis) {
    double const cosine = vec3_dot(normal, axis);
    return fabs(cosine) >= LEAST_COSINE ? sign_of(cosine) : ORIENTATION_UNDECIDED;
}

orientation orient_by_history(const topology *topo, const side_history *history,
                              feature_pair vertex_triangle, vec3 axis) {
    int votes = 0;
    for (size_t i = find_first(history, vertex_triangle.first); i < history->sides.count; i++) {
        known_side const *const side = &history->sides.data[i];
        if (side->vertex != vertex_triangle.first) break;
        orientation const own = compare_normals(side->normal, axis);
        if (side->triangle == vertex_triangle.second) return own;
        if (share_a_corner(topo, side->triangle, vertex_triangle.second)) votes += own;
    }
    return sign_of(votes);
}

static orientation side_of_vertex(const oriented_pair *question, const double *positions,
                                  uint32_t vertex) {
    vec3 const to = vec3_sub(vec3_load(positions, vertex), question->point);
    return sign_of(vec3_dot(question->axis, to));
}

/* The common side of all neighbours, if there is one. */
static orientation side_of_neighbours(const topology *topo, const double *positions,
                                      const oriented_pair *question) {
    const adjacency *const around = &topo->vertex_neighbours;
    uint32_t const vertex = question->pair.first;
    orientation side = ORIENTATION_UNDECIDED;
    for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
        orientation const own = side_of_vertex(question, positions, around->items[i]);
        if (side != ORIENTATION_UNDECIDED && own != side) return ORIENTATION_UNDECIDED;
        side = own;
    }
    return side;
}

/* The common side of the vertices opposite an edge. */
static orientation side_of_opposites(const topology *topo, const double *positions,
                                     const oriented_pair *question, uint32_t edge) {
    const uint32_t *const opposites = topo->edge_opposites + 2 * (size_t)edge;
    orientation sides[2] = {ORIENTATION_UNDECIDED, ORIENTATION_UNDECIDED};
    for (int k = 0; k < 2; k++)
        if (opposites[k] != TULLE_NONE)
            sides[k] = side_of_vertex(question, positions, opposites[k]);
    if (opposites[1] == TULLE_NONE) return sides[0];
    return sides[0] == sides[1] ? sides[0] : ORIENTATION_UNDECIDED;
}

orientation orient_by_neighbours(const topology *topo, const double *positions,
                                 const oriented_pair *question) {
    if (question->kind == FEATURE_VERTEX_TRIANGLE)
        return side_of_neighbours(topo, positions, question);
    orientation const first = side_of_opposites(topo, positions, question, question->pair.first);
    orientation const second = side_of_opposites(topo, positions, question, question->pair.second);
    return (int)first == -(int)second ? first : ORIENTATION_UNDECIDED;
}

static vec3 sum_corners(const topology *topo, const double *positions, uint32_t triangle) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < 3; k++)
        sum = vec3_add(sum, vec3_load(positions, topo->triangles[3 * (size_t)triangle + k]));
    return sum;
}

orientation orient_by_triangles(const topology *topo, const double *positions, uint32_t first,
                                uint32_t second, vec3 axis) {
    vec3 const difference =
        vec3_sub(sum_corners(topo, positions, first), sum_corners(topo, positions, second));
    return sign_of(vec3_dot(axis, difference));
}
