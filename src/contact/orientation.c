/* contact/orientation.c - see orientation.h.
 *
 * States that do not intersect need none of this: their normal is the unit vector between the
 * closest points, and the store keeps it as history. The rules serve starts that intersect, and
 * tests.
 *
 * The verification in closed form: with d_i the corners' signed distances along the axis, moving
 * the first triangle by e and the second by -e changes sum d_i^2 by 2 e (sum_1 d - sum_2 d) + 6
 * e^2. The larger change belongs to the axis that points from the second centroid to the first.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6. Departures: normals point from the second feature to the first; on borders,
 * where an edge has one opposite vertex, that one decides. */
#include "contact/orientation.h"

/* Normals of the store that differ by more than 60 degrees from the line say nothing about it. */
#define LEAST_COSINE 0.5

static orientation sign_of(double value) {
    if (value > 0.0) return ORIENTATION_ALONG;
    return value < 0.0 ? ORIENTATION_AGAINST : ORIENTATION_UNDECIDED;
}

static bool features_touch(const topology *topo, feature_kind kind, uint32_t a, uint32_t b) {
    bool const is_triangle = kind == FEATURE_VERTEX_TRIANGLE;
    size_t const size = is_triangle ? 3 : 2;
    const uint32_t *const corners = is_triangle ? topo->triangles : topo->edges;
    for (size_t i = 0; i < size; i++)
        for (size_t j = 0; j < size; j++)
            if (corners[size * a + i] == corners[size * b + j]) return true;
    return false;
}

static orientation compare_normals(const stored_contact *contact, vec3 axis) {
    double const cosine = vec3_dot(vec3_load(contact->normal, 0), axis);
    return fabs(cosine) >= LEAST_COSINE ? sign_of(cosine) : ORIENTATION_UNDECIDED;
}

/* The first contact in the store that is not before (kind, first, 0). */
static size_t find_first(const contact_store *store, feature_kind kind, uint32_t first) {
    size_t low = 0, high = store->contacts.count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        const stored_contact *const contact = &store->contacts.data[middle];
        bool const is_before = contact->kind != (uint32_t)kind ? contact->kind < (uint32_t)kind
                                                               : contact->first < first;
        if (is_before)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

orientation orient_by_history(const topology *topo, const contact_store *store,
                              const oriented_pair *question) {
    feature_pair const pair = question->pair;
    const stored_contact *const own = find_contact(store, question->kind, pair);
    if (own) return compare_normals(own, question->axis);
    bool const is_vertex = question->kind == FEATURE_VERTEX_TRIANGLE;
    size_t const count = is_vertex ? topo->triangle_count : topo->edge_count;
    int votes = 0;
    for (size_t i = find_first(store, question->kind, pair.first); i < store->contacts.count; i++) {
        const stored_contact *const contact = &store->contacts.data[i];
        if (contact->kind != (uint32_t)question->kind || contact->first != pair.first) break;
        if (contact->second < count &&
            features_touch(topo, question->kind, contact->second, pair.second))
            votes += compare_normals(contact, question->axis);
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

orientation orient_pair(const topology *topo, const double *positions, const contact_store *store,
                        const oriented_pair *question) {
    orientation side = orient_by_history(topo, store, question);
    if (side == ORIENTATION_UNDECIDED) side = orient_by_neighbours(topo, positions, question);
    if (side != ORIENTATION_UNDECIDED) return side;
    feature_pair const pair = question->pair;
    bool const is_vertex = question->kind == FEATURE_VERTEX_TRIANGLE;
    const adjacency *const around = &topo->vertex_triangles;
    if (is_vertex && around->begin[pair.first] == around->begin[pair.first + 1]) return side;
    uint32_t const first = is_vertex ? around->items[around->begin[pair.first]]
                                     : topo->edge_triangles[2 * (size_t)pair.first];
    uint32_t const second = is_vertex ? pair.second : topo->edge_triangles[2 * (size_t)pair.second];
    return orient_by_triangles(topo, positions, first, second, question->axis);
}
