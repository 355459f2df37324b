/* contact/pairs/pair_rules.c - see pair_rules.h. */
#include "contact/pairs/pair_rules.h"

#include "base/parallel.h"
#include "base/sort.h"

#include <float.h>
#include <stdlib.h>

/* Cloth can be compressed to this part of its rest distances before it touches itself. */
static const double CONTACT_PART_OF_REST = 0.5;
/* Cloth can be compressed to this part of its rest distances before the safe commit holds it. */
static const double MINIMUM_PART_OF_REST = 0.25;
/* Rest distances under this part of the contact distance are no neighbours of one surface but
 * pattern pieces laid over one another: the rest shape then says nothing about the pair. */
static const double OVERLAPPING_REST = 1e-3;
/* Corner gaps: three subtractions or sums and a dot product, generously. */
static const double SLACK_ROUNDINGS = 64.0;

const contact_law *get_contact_law(const contact_scene *scene, const uint32_t vertices[4]) {
    size_t const a = scene->vertex_surface[vertices[0]], b = scene->vertex_surface[vertices[3]];
    return &scene->laws[a * scene->set->surface_count + b];
}

pair_distances compute_pair_distances(const contact_scene *scene, feature_kind kind,
                                      const uint32_t vertices[4], const double *rest_distance) {
    const contact_law *const law = get_contact_law(scene, vertices);
    pair_distances distances = {law->contact_distance, law->separation_distance,
                                scene->settings.minimum_gap};
    if (scene->vertex_surface[vertices[0]] != scene->vertex_surface[vertices[3]]) return distances;
    double rest;
    if (rest_distance) {
        rest = *rest_distance;
    } else {
        vec3 points[4];
        load_points(scene->rest, vertices, points);
        rest = sqrt(closest_of_pair(kind, points).distance2);
    }
    if (rest < OVERLAPPING_REST * law->contact_distance) return distances;
    if (CONTACT_PART_OF_REST * rest < distances.contact) {
        distances.separation *= CONTACT_PART_OF_REST * rest / distances.contact;
        distances.contact = CONTACT_PART_OF_REST * rest;
    }
    if (MINIMUM_PART_OF_REST * rest < distances.minimum)
        distances.minimum = MINIMUM_PART_OF_REST * rest;
    return distances;
}

/* Owners of an edge are those triangles of its first vertex that have the edge: also right where
 * more than two triangles meet. */
bool pair_is_ignored(const contact_scene *scene, feature_kind kind, feature_pair pair) {
    const topology *const topo = scene->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    const uint32_t *const edges = topo->triangle_edges;
    const uint64_t *const ignored = scene->ignored;
    size_t const count = scene->ignored_count;
    if (count == 0) return false;
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        uint32_t const begin = around->begin[pair.first], end = around->begin[pair.first + 1];
        for (uint32_t i = begin; i < end; i++) {
            uint64_t const key = ignored_pair_key(around->items[i], pair.second);
            if (!bsearch(&key, ignored, count, sizeof key, compare_u64)) return false;
        }
        return end > begin;
    }
    uint32_t const a = topo->edges[2 * (size_t)pair.first];
    uint32_t const b = topo->edges[2 * (size_t)pair.second];
    for (uint32_t i = around->begin[a]; i < around->begin[a + 1]; i++) {
        size_t const first = around->items[i];
        if (edges[3 * first] != pair.first && edges[3 * first + 1] != pair.first &&
            edges[3 * first + 2] != pair.first)
            continue;
        for (uint32_t j = around->begin[b]; j < around->begin[b + 1]; j++) {
            size_t const second = around->items[j];
            if (edges[3 * second] != pair.second && edges[3 * second + 1] != pair.second &&
                edges[3 * second + 2] != pair.second)
                continue;
            uint64_t const key = ignored_pair_key((uint32_t)first, (uint32_t)second);
            if (first != second && !bsearch(&key, ignored, count, sizeof key, compare_u64))
                return false;
        }
    }
    return true;
}

/* The search for the largest coordinate: chunks at most, and coordinates of one at least. */
enum { SLACK_CHUNKS = 16, SLACK_CHUNK_LEAST = 8192 };

typedef struct slack_task {
    const double *arrays[2];
    double largest[SLACK_CHUNKS];
} slack_task;

static void find_largest(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    enum { LANES = 8 }; /* several at a time */
    (void)worker;
    slack_task *const task = context;
    double largest[LANES] = {0.0};
    for (int array = 0; array < 2; array++) {
        const double *const values = task->arrays[array];
        size_t i = begin;
        for (; i + LANES <= end; i += LANES)
            for (size_t k = 0; k < LANES; k++) {
                double const size = fabs(values[i + k]);
                largest[k] = size > largest[k] ? size : largest[k];
            }
        for (; i < end; i++)
            largest[0] = fabs(values[i]) > largest[0] ? fabs(values[i]) : largest[0];
    }
    for (size_t k = 1; k < LANES; k++)
        if (largest[k] > largest[0]) largest[0] = largest[k];
    task->largest[chunk] = largest[0];
}

double compute_rounding_slack(const contact_scene *scene, const double *x1) {
    slack_task task = {.arrays = {scene->x0, x1}};
    size_t const count = 3 * scene->vertex_count;
    size_t const even = count / SLACK_CHUNKS + 1;
    size_t const chunk = even > SLACK_CHUNK_LEAST ? even : SLACK_CHUNK_LEAST;
    parallel_for(count, chunk, scene->threads, find_largest, &task);
    double largest = 0.0;
    for (size_t k = 0; k < SLACK_CHUNKS; k++)
        if (task.largest[k] > largest) largest = task.largest[k];
    return SLACK_ROUNDINGS * DBL_EPSILON * largest;
}
