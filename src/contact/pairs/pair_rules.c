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
/* Rest distances under this part of the contact distance may be those of pattern pieces laid over
 * one another: the rest shape then says nothing about the pair. Unless they are neighbours along
 * the surface, at more than rounding: over this part of the minimum gap, or two steps of float at
 * their largest coordinate. No triangle of cloth is lower than four (LEAST_HEIGHT). */
static const double OVERLAPPING_REST = 1e-3, ROUNDED_REST = 1e-3, ROUNDED_COORDINATE = 0x1p-22;
/* Neighbours along the surface are joined by triangles that come within the contact distance. A way
 * that comes ever nearer has any number of them, also where it goes round a hole. Only where the
 * rest shape is folded does a search look about, at so many triangles. */
enum { FOLDED_TRIANGLES = 64 };
/* Corner gaps: three subtractions or sums and a dot product, generously. */
static const double SLACK_ROUNDINGS = 64.0;

const contact_law *get_contact_law(const contact_scene *scene, const uint32_t vertices[4]) {
    size_t const a = scene->vertex_surface[vertices[0]], b = scene->vertex_surface[vertices[3]];
    return &scene->laws[a * scene->set->surface_count + b];
}

/* A way over the rest shape from triangle to triangle, ever nearer to a point. */
typedef struct surface_walk {
    const contact_scene *scene;
    vec3 aim; /* [m] */
    uint32_t triangle;
    double distance2; /* [m^2] of its nearest side */
    bool is_near[3];  /* its corners at that side's closest point */
} surface_walk;

/* [m^2] How far the side from corner k of a triangle rests from a point; where on it: 0 .. 1. */
static double measure_side(const contact_scene *scene, vec3 point, size_t triangle, size_t k,
                           double *place) {
    const uint32_t *const corners = scene->set->topo->triangles + 3 * triangle;
    vec3 const a = vec3_load(scene->rest, corners[k]);
    vec3 const along = vec3_sub(vec3_load(scene->rest, corners[(k + 1) % 3]), a);
    vec3 const offset = vec3_sub(point, a);
    double const t = vec3_dot(offset, along) / vec3_norm2(along);
    *place = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    return vec3_norm2(vec3_add_scaled(offset, along, -*place));
}

/* Goes to a triangle if one of its sides is nearer. */
static void step_nearer(surface_walk *walk, uint32_t triangle) {
    for (size_t k = 0; k < 3; k++) {
        double place;
        double const distance2 = measure_side(walk->scene, walk->aim, triangle, k, &place);
        if (!(distance2 < walk->distance2)) continue;
        walk->triangle = triangle;
        walk->distance2 = distance2;
        walk->is_near[k] = place < 1.0;
        walk->is_near[(k + 1) % 3] = place > 0.0;
        walk->is_near[(k + 2) % 3] = false;
    }
}

/* Follows the border through a vertex one way, up to its end in the ball, and goes to the nearest
 * triangle on it. */
static void follow_border(surface_walk *walk, uint32_t vertex, int way, double radius) {
    const topology *const topo = walk->scene->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    uint32_t at = vertex;
    do {
        uint32_t next = vertex; /* where it ends or leaves the ball */
        for (uint32_t i = around->begin[at]; i < around->begin[at + 1]; i++) {
            size_t const triangle = around->items[i];
            for (size_t k = 0; k < 3; k++) {
                uint32_t const ends[2] = {topo->triangles[3 * triangle + k],
                                          topo->triangles[3 * triangle + (k + 1) % 3]};
                size_t const edge = topo->triangle_edges[3 * triangle + k];
                if (ends[way] != at || topo->edge_triangles[2 * edge + 1] != TULLE_NONE) continue;
                step_nearer(walk, (uint32_t)triangle);
                vec3 const place = vec3_load(walk->scene->rest, ends[!way]);
                if (vec3_norm2(vec3_sub(place, walk->aim)) <= radius * radius) next = ends[!way];
            }
        }
        at = next;
    } while (at != vertex);
}

static int count_shared(const uint32_t corners[3], const uint32_t *vertices, int count) {
    int shared = 0;
    for (int k = 0; k < count; k++)
        shared +=
            vertices[k] == corners[0] || vertices[k] == corners[1] || vertices[k] == corners[2];
    return shared;
}

/* Whether triangles lead from one feature to the other within a ball: it lies about the first
 * feature's closest point at rest and has the contact distance as its radius. A walk begins at the
 * other feature. Where the rest shape is folded so that it must go further away first, it stops.
 * Then triangles are looked at from the first feature on, the next one always the one whose edge is
 * nearest to the other's closest point. */
static bool are_neighbours(const contact_scene *scene, feature_kind kind,
                           const uint32_t vertices[4], double radius, double rest) {
    const topology *const topo = scene->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    struct {
        uint32_t triangle;
        bool is_done;
        double distance2; /* [m^2] */
    } found[FOLDED_TRIANGLES];
    size_t count = 0;
    int const first_count = kind == FEATURE_EDGE_EDGE ? 2 : 1;
    vec3 points[4];
    load_points(scene->rest, vertices, points);
    double largest = 0.0;
    for (int k = 0; k < 4; k++)
        largest =
            fmax(largest, fmax(fabs(points[k].x), fmax(fabs(points[k].y), fabs(points[k].z))));
    double const rounding =
        fmin(ROUNDED_REST * scene->settings.minimum_gap, ROUNDED_COORDINATE * largest);
    if (!(rest > rounding)) return false;
    closest_points const closest = closest_of_pair(kind, points);
    vec3 from = {0.0, 0.0, 0.0};
    uint32_t ends[2]; /* of the first feature, those that the way must come to */
    int end_count = 0;
    for (int k = 0; k < first_count; k++) {
        from = vec3_add_scaled(from, points[k], closest.weights[k]);
        if (closest.weights[k] != 0.0) ends[end_count++] = vertices[k];
    }
    vec3 const to = vec3_sub(from, closest.difference);

    surface_walk walk = {.scene = scene, .aim = from, .distance2 = (double)INFINITY};
    for (uint32_t i = around->begin[vertices[3]]; i < around->begin[vertices[3] + 1]; i++) {
        const uint32_t *const corners = topo->triangles + 3 * (size_t)around->items[i];
        if (count_shared(corners, vertices + first_count, 4 - first_count) == 4 - first_count)
            step_nearer(&walk, around->items[i]);
    }
    if (walk.distance2 > radius * radius) return false;
    for (bool goes_on = true; goes_on;) {
        surface_walk const now = walk;
        const uint32_t *const corners = topo->triangles + 3 * (size_t)now.triangle;
        for (size_t k = 0; k < 3; k++) {
            uint32_t const end = now.is_near[k] ? around->begin[corners[k] + 1] : 0;
            for (uint32_t i = around->begin[corners[k]]; i < end; i++)
                if (count_shared(topo->triangles + 3 * (size_t)around->items[i], ends, end_count) ==
                    end_count)
                    return true;
            for (uint32_t i = around->begin[corners[k]]; i < end; i++)
                step_nearer(&walk, around->items[i]);
        }
        goes_on = walk.distance2 < now.distance2;
        for (int way = 0; way < 6 && !goes_on; way++) {
            if (!now.is_near[way / 2]) continue;
            follow_border(&walk, corners[way / 2], way % 2, radius);
            goes_on = walk.distance2 < now.distance2;
        }
    }

    for (uint32_t i = around->begin[vertices[0]]; i < around->begin[vertices[0] + 1]; i++) {
        const uint32_t *const corners = topo->triangles + 3 * (size_t)around->items[i];
        if (count_shared(corners, vertices, first_count) < first_count || count == FOLDED_TRIANGLES)
            continue;
        found[count].triangle = around->items[i];
        found[count].is_done = false;
        found[count++].distance2 = 0.0;
    }
    for (;;) {
        size_t next = count;
        for (size_t i = 0; i < count; i++)
            if (!found[i].is_done && (next == count || found[i].distance2 < found[next].distance2))
                next = i;
        if (next == count) return false;
        found[next].is_done = true;
        size_t const triangle = found[next].triangle;
        const uint32_t *const corners = topo->triangles + 3 * triangle;
        if (count_shared(corners, vertices + first_count, 4 - first_count) == 4 - first_count)
            return true;
        for (size_t k = 0; k < 3; k++) {
            const uint32_t *const sides =
                topo->edge_triangles + 2 * topo->triangle_edges[3 * triangle + k];
            uint32_t const other = sides[0] == triangle ? sides[1] : sides[0];
            double place;
            bool is_known = other == TULLE_NONE ||
                            measure_side(scene, from, triangle, k, &place) > radius * radius;
            for (size_t i = 0; i < count; i++) is_known |= found[i].triangle == other;
            if (is_known || count == FOLDED_TRIANGLES) continue;
            found[count].triangle = other;
            found[count].is_done = false;
            found[count++].distance2 = measure_side(scene, to, triangle, k, &place);
        }
    }
}

/* [m] The room of a pair with a contact distance; all of the distance if the start has not chosen
 * it for the cloth. A side of cloth has the room of its narrowest vertex, one of an obstacle that
 * of its point that is nearest at x0: a large face is narrow where it borders on a narrow place. */
static double find_room(const contact_scene *scene, feature_kind kind, const uint32_t v[4],
                        double contact) {
    double const a = scene->automatic[scene->vertex_surface[v[0]]];
    double const b = scene->automatic[scene->vertex_surface[v[3]]];
    bool const is_cloth[2] = {v[0] < scene->cloth_vertex_count, v[3] < scene->cloth_vertex_count};
    bool const has_chosen = !is_cloth[0]   ? contact == b
                            : !is_cloth[1] ? contact == a
                                           : a > 0.0 && b > 0.0 && contact == 0.5 * (a + b);
    if (!has_chosen) return contact;
    double rooms[4], least = contact;
    for (int k = 0; k < 4; k++) {
        rooms[k] = fmin(scene->rooms[v[k]], contact);
        least = fmin(least, rooms[k]);
    }
    if (!(least < contact)) return contact;
    vec3 points[4];
    load_points(scene->x0, v, points);
    closest_points const closest = closest_of_pair(kind, points);
    double room = contact, on_sides[2] = {0.0, 0.0};
    for (int k = 0; k < 4; k++) {
        int const side = k >= (kind == FEATURE_EDGE_EDGE ? 2 : 1);
        if (is_cloth[side]) room = fmin(room, rooms[k]);
        on_sides[side] += fabs(closest.weights[k]) * (is_cloth[side] ? contact : rooms[k]);
    }
    return fmin(room, fmin(on_sides[0], on_sides[1]));
}

pair_distances compute_pair_distances(const contact_scene *scene, feature_kind kind,
                                      const uint32_t vertices[4], const double *rest_distance) {
    const contact_law *const law = get_contact_law(scene, vertices);
    pair_distances distances = {law->contact_distance, law->separation_distance,
                                scene->settings.minimum_gap};
    if (scene->rooms) {
        double const room = find_room(scene, kind, vertices, law->contact_distance);
        if (room < distances.contact) {
            distances.separation *= room / distances.contact;
            distances.contact = room;
        }
    }
    if (scene->vertex_surface[vertices[0]] != scene->vertex_surface[vertices[3]]) return distances;
    double rest;
    if (rest_distance) {
        rest = *rest_distance;
    } else {
        vec3 points[4];
        load_points(scene->rest, vertices, points);
        rest = sqrt(closest_of_pair(kind, points).distance2);
    }
    if (rest < OVERLAPPING_REST * law->contact_distance &&
        !are_neighbours(scene, kind, vertices, law->contact_distance, rest))
        return distances;
    if (CONTACT_PART_OF_REST * rest < distances.contact) {
        distances.separation *= CONTACT_PART_OF_REST * rest / distances.contact;
        distances.contact = CONTACT_PART_OF_REST * rest;
    }
    if (MINIMUM_PART_OF_REST * rest < distances.minimum)
        distances.minimum = MINIMUM_PART_OF_REST * rest;
    return distances;
}

/* Owners of an edge are the triangles of its first vertex that have the edge. This also holds if
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
