/* contact/pairs/pair_rules.c - see pair_rules.h. */
#include "contact/pairs/pair_rules.h"

#include <float.h>

/* Parts of the rest distance of a pair of one cloth: cloth can be compressed to half before it
 * touches itself ... */
#define CONTACT_PART_OF_REST 0.5
/* ... and to a quarter before the safe commit holds it. */
#define MINIMUM_PART_OF_REST 0.25
/* Rest distances under this part of the contact distance are no neighbours of one surface but
 * pattern pieces laid over one another: the rest shape then says nothing about the pair. */
#define OVERLAPPING_REST 1e-3
/* A pair that starts at the minimum gap or nearer (pressed there by the step before, or a bad
 * start) may come nearer by this factor, so that a step can begin; so near to 1 that 10,000 pressed
 * steps take a hundredth. */
#define PART_OF_START (1.0 - 1e-6)
/* Accepted states keep more than xi up to this relative rounding. */
#define MINIMUM_ROUNDING 1e-9
/* Corner gaps: three subtractions or sums and a dot product, generously. */
#define SLACK_ROUNDINGS 64.0

static size_t second_index(feature_kind kind) { return kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2; }

const contact_law *find_contact_law(const contact_scene *scene, const uint32_t vertices[4],
                                    feature_kind kind) {
    size_t const a = scene->vertex_surface[vertices[0]];
    size_t const b = scene->vertex_surface[vertices[second_index(kind)]];
    return &scene->laws[a * scene->set->surface_count + b];
}

static bool is_of_one_surface(const contact_scene *scene, feature_kind kind,
                              const uint32_t vertices[4]) {
    return scene->vertex_surface[vertices[0]] ==
           scene->vertex_surface[vertices[second_index(kind)]];
}

pair_distances limit_pair_distances(const contact_scene *scene, feature_kind kind,
                                    const uint32_t vertices[4], double rest) {
    const contact_law *const law = find_contact_law(scene, vertices, kind);
    pair_distances distances = {law->contact_distance, law->separation_distance,
                                scene->settings.minimum_gap};
    if (!is_of_one_surface(scene, kind, vertices) ||
        rest < OVERLAPPING_REST * law->contact_distance)
        return distances;
    if (CONTACT_PART_OF_REST * rest < distances.contact) {
        distances.separation *= CONTACT_PART_OF_REST * rest / distances.contact;
        distances.contact = CONTACT_PART_OF_REST * rest;
    }
    if (MINIMUM_PART_OF_REST * rest < distances.minimum)
        distances.minimum = MINIMUM_PART_OF_REST * rest;
    return distances;
}

pair_distances find_pair_distances(const contact_scene *scene, feature_kind kind,
                                   const uint32_t vertices[4]) {
    if (!is_of_one_surface(scene, kind, vertices))
        return limit_pair_distances(scene, kind, vertices, 0.0);
    vec3 points[4];
    load_points(scene->rest, vertices, points);
    double const rest = sqrt(closest_of_pair(kind, points).distance2);
    return limit_pair_distances(scene, kind, vertices, rest);
}

double find_minimum_gap(double minimum, double start_distance) {
    if (start_distance > minimum * (1.0 + MINIMUM_ROUNDING)) return minimum;
    double const part = PART_OF_START * start_distance;
    return part < minimum ? part : minimum;
}

/* Triangles that own a feature: those around a vertex or edge, or the triangle itself. */
typedef struct owner_list {
    const uint32_t *triangles;
    size_t count;
} owner_list;

static owner_list find_vertex_owners(const topology *topo, uint32_t vertex) {
    const adjacency *const around = &topo->vertex_triangles;
    uint32_t const begin = around->begin[vertex];
    return (owner_list){around->items + begin, around->begin[vertex + 1] - begin};
}

static bool triangle_has_edge(const topology *topo, uint32_t triangle, uint32_t edge) {
    const uint32_t *const edges = topo->triangle_edges + 3 * (size_t)triangle;
    return edges[0] == edge || edges[1] == edge || edges[2] == edge;
}

static bool is_in_ignored(const contact_scene *scene, uint64_t key) {
    size_t low = 0, high = scene->ignored_count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (scene->ignored[middle] == key) return true;
        if (scene->ignored[middle] < key)
            low = middle + 1;
        else
            high = middle;
    }
    return false;
}

static bool vertex_pair_is_ignored(const contact_scene *scene, feature_pair pair) {
    owner_list const owners = find_vertex_owners(scene->set->topo, pair.first);
    for (size_t i = 0; i < owners.count; i++)
        if (!is_in_ignored(scene, ignored_pair_key(owners.triangles[i], pair.second))) return false;
    return owners.count > 0;
}

/* Owners of an edge are those of its first vertex that have the edge: also right where more than
 * two triangles meet. */
static bool edge_pair_is_ignored(const contact_scene *scene, feature_pair pair) {
    const topology *const topo = scene->set->topo;
    owner_list const first = find_vertex_owners(topo, topo->edges[2 * (size_t)pair.first]);
    owner_list const second = find_vertex_owners(topo, topo->edges[2 * (size_t)pair.second]);
    for (size_t i = 0; i < first.count; i++) {
        if (!triangle_has_edge(topo, first.triangles[i], pair.first)) continue;
        for (size_t j = 0; j < second.count; j++) {
            if (!triangle_has_edge(topo, second.triangles[j], pair.second)) continue;
            uint64_t const key = ignored_pair_key(first.triangles[i], second.triangles[j]);
            if (first.triangles[i] != second.triangles[j] && !is_in_ignored(scene, key))
                return false;
        }
    }
    return true;
}

bool pair_is_ignored(const contact_scene *scene, feature_kind kind, feature_pair pair) {
    if (scene->ignored_count == 0) return false;
    return kind == FEATURE_VERTEX_TRIANGLE ? vertex_pair_is_ignored(scene, pair)
                                           : edge_pair_is_ignored(scene, pair);
}

/* The largest size of a value, of several lanes at a time. */
static double find_largest(const double *values, size_t count) {
    enum { LANES = 8 };
    double largest[LANES] = {0.0};
    size_t i = 0;
    for (; i + LANES <= count; i += LANES)
        for (size_t k = 0; k < LANES; k++) {
            double const size = fabs(values[i + k]);
            largest[k] = size > largest[k] ? size : largest[k];
        }
    for (; i < count; i++) largest[0] = fabs(values[i]) > largest[0] ? fabs(values[i]) : largest[0];
    for (size_t k = 1; k < LANES; k++)
        if (largest[k] > largest[0]) largest[0] = largest[k];
    return largest[0];
}

double find_rounding_slack(const contact_scene *scene, const double *x1) {
    double const before = find_largest(scene->x0, 3 * scene->vertex_count);
    double const after = find_largest(x1, 3 * scene->vertex_count);
    return SLACK_ROUNDINGS * DBL_EPSILON * (before > after ? before : after);
}
