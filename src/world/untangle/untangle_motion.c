/* world/untangle/untangle_motion.c - one round's displacement of the cloth.
 *
 * Votes. A crossing whose wrong end is known pushes this end and the triangle apart until the end
 * lies on the right side of the triangle's plane: the contour so wanders over the wrong region
 * until none is left. An undecided one moves edge and triangle so that the contour gets shorter.
 * Other pairs that are too near are pushed apart. Votes on a vertex are averaged.
 *
 * Spread. Vertices without votes follow their neighbours, less and less with the distance (a
 * screened Laplace equation for the displacement), so what hangs together moves together and
 * wrinkles keep their shape. Then edges that became much longer or shorter than at the start are
 * corrected.
 *
 * Escalation. Where rounds bring no progress, displacements reach farther and the surroundings of
 * contours are smoothed, which unfolds what is crumpled.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003; Volino, Magnenat-Thalmann, Resolving
 * surface collisions through intersection contour minimization, 2006; Mueller et al., Position
 * based dynamics, 2007 (edge lengths). */
#include "geom/distance.h"
#include "world/untangle/untangle_parts.h"

#include <string.h>

/* Pairs are pushed apart to this share of their contact distance. */
static const double GAP_SHARE = 0.6;
/* [of the mean edge] Farthest that one vote asks for. */
static const double VOTE_MAX = 1.0;
/* [of the mean edge] Step of a crossing that shortens its contour. */
static const double SHORTEN_STEP = 0.5;
/* Smallest cosine between an edge and the normal of the triangle that it crosses. */
static const double CROSSING_SLANT = 0.2;
/* Edges keep between these shares of their length at the start. */
static const double SHORTEST_SHARE = 0.7, LONGEST_SHARE = 1.05;
/* Weight of a vertex's own votes over that of one neighbour. */
static const double VOTE_WEIGHT = 20.0;
/* [edges] Reach of displacements at level 0 of each attempt, in turn. It doubles with each level.
 */
static const double REACHES[] = {5.0, 3.0, 8.0, 2.0};
enum { REACH_COUNT = 4 };
enum { SPREAD_SWEEPS = 12, LENGTH_SWEEPS = 4, REACH_LEVEL_MAX = 3 };

/* Votes that move sum w_i x_i by `change`, shared among `count` vertices by
 * mobility. */
static void add_votes(untangling *work, const uint32_t *vertices, const double *weights, int count,
                      vec3 change) {
    double sum = 0.0;
    for (int k = 0; k < count; k++) sum += weights[k] * weights[k] * work->mobility[vertices[k]];
    if (!(sum > 1e-6)) return;
    for (int k = 0; k < count; k++) {
        uint32_t const v = vertices[k];
        double const share = work->mobility[v] * weights[k] / sum;
        if (share == 0.0) continue;
        vec3_store(work->shift, v, vec3_add(vec3_load(work->shift, v), vec3_scale(change, share)));
        work->votes[v] += 1.0;
    }
}

vec3 compute_triangle_normal(const untangling *work, uint32_t triangle) {
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)triangle;
    vec3 const a = vec3_load(work->positions, corners[0]);
    return vec3_normalize(vec3_cross(vec3_sub(vec3_load(work->positions, corners[1]), a),
                                     vec3_sub(vec3_load(work->positions, corners[2]), a)));
}

vec3 compute_edge_direction(const untangling *work, uint32_t edge) {
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)edge;
    return vec3_normalize(
        vec3_sub(vec3_load(work->positions, ends[1]), vec3_load(work->positions, ends[0])));
}

static double compute_gap(const untangling *work, uint32_t a, uint32_t b) {
    const tulle_world *const world = work->world;
    const contact_law *const law =
        &world->model.laws[world->model.vertex_surface[a] * world->model.surface_count +
                           world->model.vertex_surface[b]];
    return GAP_SHARE * law->contact_distance;
}

/* Pushes the wrong end through the triangle. */
static void push_through(untangling *work, const surface_crossing *crossing) {
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    uint32_t const wrong = ends[crossing->wrong_end], right = ends[1 - crossing->wrong_end];
    vec3 normal = compute_triangle_normal(work, crossing->triangle);
    vec3 const origin = vec3_load(work->positions, corners[0]);
    if (vec3_dot(normal, vec3_sub(vec3_load(work->positions, right), origin)) < 0.0)
        normal = vec3_neg(normal);
    double const height = vec3_dot(normal, vec3_sub(vec3_load(work->positions, wrong), origin));
    double const way =
        fmin(compute_gap(work, wrong, corners[0]) - height, VOTE_MAX * work->mean_edge);
    uint32_t const vertices[4] = {wrong, corners[0], corners[1], corners[2]};
    double const weights[4] = {1.0, -crossing->weights[0], -crossing->weights[1],
                               -crossing->weights[2]};
    add_votes(work, vertices, weights, 4, vec3_scale(normal, way));
}

/* Edge and triangle move so that the contour gets shorter. With the unit edge e, the normal n and
 * the sum r of directions along the contour, a shift d of the edge moves the crossing by
 * d - e (n . d) / (n . e), so the steepest way is r - n (e . r) / (n . e). */
static void shorten_contour(untangling *work, const surface_crossing *crossing) {
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    vec3 const normal = compute_triangle_normal(work, crossing->triangle);
    vec3 const edge = compute_edge_direction(work, crossing->edge);
    double slant = vec3_dot(normal, edge);
    if (fabs(slant) < CROSSING_SLANT) slant = slant < 0.0 ? -CROSSING_SLANT : CROSSING_SLANT;
    vec3 const way =
        vec3_add_scaled(crossing->pull, normal, -vec3_dot(edge, crossing->pull) / slant);
    double const step = SHORTEN_STEP * work->mean_edge / sqrt(1.0 + vec3_norm2(way));
    uint32_t const vertices[5] = {ends[0], ends[1], corners[0], corners[1], corners[2]};
    double const weights[5] = {1.0 - crossing->along, crossing->along, -crossing->weights[0],
                               -crossing->weights[1], -crossing->weights[2]};
    add_votes(work, vertices, weights, 5, vec3_scale(way, step));
}

/* Triangles that touch without a crossing, as flat on one another, part along the normal of the
 * second, to the sides on which orient_by_triangles finds them. */
static void part_loose(untangling *work, const tulle_intersection *pair) {
    const surface_range *const surfaces = work->world->work.surfaces;
    uint32_t const first = surfaces[pair->object_a].triangle_begin + pair->triangle_a;
    uint32_t const second = surfaces[pair->object_b].triangle_begin + pair->triangle_b;
    const uint32_t *const a = work->topo->triangles + 3 * (size_t)first;
    const uint32_t *const b = work->topo->triangles + 3 * (size_t)second;
    vec3 const normal = compute_triangle_normal(work, second);
    orientation const side =
        orient_by_triangles(work->topo, work->positions, first, second, normal);
    double const gap = compute_gap(work, a[0], b[0]) * (side == ORIENTATION_AGAINST ? -1.0 : 1.0);
    uint32_t const vertices[6] = {a[0], a[1], a[2], b[0], b[1], b[2]};
    double const third = 1.0 / 3.0, weights[6] = {third, third, third, -third, -third, -third};
    add_votes(work, vertices, weights, 6, vec3_scale(normal, gap));
}

/* Pushes apart pairs that are near but not astray. Remembers on which side of its triangle a near
 * vertex is. */
static tulle_status push_near(untangling *work) {
    tulle_world *const world = work->world;
    contact_scene const scene = {.set = &world->work.set,
                                 .vertex_count = world->model.vertex_count,
                                 .cloth_vertex_count = world->model.cloth_vertex_count,
                                 .vertex_surface = world->model.vertex_surface,
                                 .rest = world->model.rest,
                                 .laws = world->model.laws,
                                 .settings = {.minimum_gap = world->model.minimum_gap}};
    tulle_status status =
        build_trees(work->broad, &world->work.set, work->positions, work->positions,
                    world->model.contact_distance, world->work.threads);
    if (status == TULLE_OK)
        status = find_pairs(work->broad, &world->work.set, world->work.threads, PAIRS_SORTED,
                            &work->pairs, NULL);
    size_t const triangle_pairs = work->pairs.vertex_triangle.count;
    size_t const count = triangle_pairs + work->pairs.edge_edge.count;
    work->has_gap = true;
    work->history.sides.count = 0;
    for (size_t i = 0; status == TULLE_OK && i < count; i++) {
        bool const has_triangle = i < triangle_pairs;
        feature_kind const kind = has_triangle ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
        feature_pair const pair = has_triangle ? work->pairs.vertex_triangle.data[i]
                                               : work->pairs.edge_edge.data[i - triangle_pairs];
        uint32_t v[4];
        feature_pair_vertices(work->topo, kind, pair, v);
        bool is_astray = false;
        double mobility = 0.0;
        for (int k = 0; k < 4; k++) {
            mobility += work->mobility[v[k]];
            is_astray |= work->is_astray[v[k]];
        }
        if (mobility == 0.0) continue;
        vec3 points[4];
        load_points(work->positions, v, points);
        closest_points const closest = closest_of_pair(kind, points);
        double const distance = sqrt(closest.distance2);
        pair_distances const distances = compute_pair_distances(&scene, kind, v, NULL);
        double const wanted = GAP_SHARE * distances.contact;
        if (distance >= wanted) continue;
        if (distance < distances.minimum * (1.0 + 1e-6)) work->has_gap = false;
        if (is_astray) continue;
        vec3 const normal = vec3_normalize(closest.difference);
        add_votes(work, v, closest.weights, 4, vec3_scale(normal, wanted - distance));
        known_side const side = {pair.first, pair.second, normal};
        if (has_triangle) status = remember_side(&work->history, &world->heap, side);
    }
    return status;
}

/* Averages votes and lets the rest of the cloth follow. */
static void spread_votes(untangling *work) {
    const tulle_world *const world = work->world;
    const adjacency *const around = &work->topo->vertex_neighbours;
    double *const asked = work->shift + 3 * world->model.vertex_count; /* second half */
    int const level = work->level < REACH_LEVEL_MAX ? work->level : REACH_LEVEL_MAX;
    double const reach = REACHES[work->attempt % REACH_COUNT] * (double)(1 << level);
    double const screen = 1.0 + 1.5 / (reach * reach);
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++) {
        if (work->votes[v] > 0.0)
            vec3_store(work->shift, v, vec3_scale(vec3_load(work->shift, v), 1.0 / work->votes[v]));
        vec3_store(asked, v, vec3_load(work->shift, v));
    }
    for (int sweep = 0; sweep < SPREAD_SWEEPS * (1 << level); sweep++) {
        for (size_t i = 0; i < world->model.cloth_vertex_count; i++) {
            size_t const v = sweep % 2 ? world->model.cloth_vertex_count - 1 - i : i;
            uint32_t const begin = around->begin[v], end = around->begin[v + 1];
            if (work->mobility[v] == 0.0 || begin == end) continue;
            double const own = work->votes[v] > 0.0 ? VOTE_WEIGHT : 0.0;
            vec3 sum = vec3_scale(vec3_load(asked, v), own);
            for (uint32_t k = begin; k < end; k++)
                sum = vec3_add(sum, vec3_load(work->shift, around->items[k]));
            vec3_store(work->shift, v,
                       vec3_scale(sum, 1.0 / (own + screen * (double)(end - begin))));
        }
    }
}

void limit_distance(untangling *work, uint32_t a, uint32_t b, double low, double high) {
    double const mobility = work->mobility[a] + work->mobility[b];
    vec3 const pa = vec3_load(work->positions, a), pb = vec3_load(work->positions, b);
    vec3 const way = vec3_sub(pb, pa);
    double const length = vec3_norm(way);
    if (mobility == 0.0 || !(length > 0.0) || (length >= low && length <= high)) return;
    double const excess = (length - (length < low ? low : high)) / (length * mobility);
    vec3_store(work->positions, a, vec3_add_scaled(pa, way, excess * work->mobility[a]));
    vec3_store(work->positions, b, vec3_add_scaled(pb, way, -excess * work->mobility[b]));
}

/* ---- the way out for cloth deep inside an obstacle ----
 *
 * A contour moves only what is next to it. Where a long strip of a tube lies in an obstacle, both
 * its sides pull at it while the rest of the tube holds it back. So every vertex of such a strip
 * votes for the way to the obstacle's surface. Each vertex hands its nearest triangle on to its
 * neighbours, beginning at the contours, and a neighbour goes on to adjoining triangles that are
 * nearer. So neighbours leave by the same wall.
 *
 * What one contour cuts off votes, too; else a fine sleeve does not come off an arm that is wider.
 * But these votes may crumple coarse cloth, so only every other attempt, from the first on, has
 * them.
 *
 * In: wrong ends of crossings and what is inside. Out: votes.
 *
 * Based on: Fisher, Lin, Deformed distance fields for simulation of non-penetrating flexible
 * bodies, 2001 (penetration depth handed on). */

/* [of the mean edge] Farthest that one vote asks for. */
static const double WAY_MAX = 1.0;

/* From a vertex to a triangle of the obstacle. */
typedef struct nearest_point {
    uint32_t triangle;
    double distance2; /* [m^2] */
    vec3 difference;  /* [m] vertex less point */
} nearest_point;

static nearest_point measure_way(const untangling *work, uint32_t vertex, uint32_t triangle) {
    vec3 points[4];
    points[0] = vec3_load(work->positions, vertex);
    for (size_t k = 0; k < 3; k++)
        points[k + 1] = vec3_load(work->positions, work->topo->triangles[3 * (size_t)triangle + k]);
    closest_points const closest = closest_vertex_triangle(points);
    return (nearest_point){triangle, closest.distance2, closest.difference};
}

/* Goes from triangle to triangle while one that shares a corner is nearer. */
static nearest_point find_nearest(const untangling *work, uint32_t vertex, uint32_t triangle) {
    const adjacency *const around = &work->topo->vertex_triangles;
    nearest_point best = measure_way(work, vertex, triangle);
    for (uint32_t from = TULLE_NONE; from != best.triangle;) {
        from = best.triangle;
        for (size_t k = 0; k < 3; k++) {
            uint32_t const corner = work->topo->triangles[3 * (size_t)from + k];
            for (uint32_t i = around->begin[corner]; i < around->begin[corner + 1]; i++) {
                nearest_point const other = measure_way(work, vertex, around->items[i]);
                if (other.distance2 < best.distance2) best = other;
            }
        }
    }
    return best;
}

/* Votes of cloth in an obstacle that reaches from one contour to another. */
static void push_out_of_depth(untangling *work) {
    const adjacency *const around = &work->topo->vertex_neighbours;
    uint32_t *const nearest = work->grown;
    for (size_t v = 0; v < work->world->model.cloth_vertex_count; v++) nearest[v] = TULLE_NONE;
    /* Begins with wrong ends inside, each with the triangle that its edge crosses. */
    bool const has_joint_only = work->attempt % 2 == 1;
    size_t count = 0;
    for (size_t i = 0; i < work->contours.count; i++) {
        const surface_crossing *const crossing = &work->contours.crossings[i];
        if (crossing->wrong_end == CROSSING_UNDECIDED || (!crossing->is_joint && has_joint_only))
            continue;
        uint32_t const vertex = work->topo->edges[2 * (size_t)crossing->edge + crossing->wrong_end];
        uint32_t const corner = work->topo->triangles[3 * (size_t)crossing->triangle];
        if (corner < work->world->model.cloth_vertex_count)
            continue; /* no way out of an obstacle */
        if (vertex >= work->world->model.cloth_vertex_count || !work->is_inside[vertex] ||
            nearest[vertex] != TULLE_NONE)
            continue;
        nearest[vertex] = crossing->triangle;
        work->queue[count++] = vertex;
    }
    for (size_t head = 0; head < count; head++) {
        uint32_t const vertex = work->queue[head];
        nearest_point const point = find_nearest(work, vertex, nearest[vertex]);
        nearest[vertex] = point.triangle;
        double const depth = sqrt(point.distance2);
        double const way =
            depth + compute_gap(work, vertex, work->topo->triangles[3 * (size_t)point.triangle]);
        if (depth > 0.0)
            add_votes(work, &vertex, (const double[]){1.0}, 1,
                      vec3_scale(point.difference, -fmin(way, WAY_MAX * work->mean_edge) / depth));
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
            uint32_t const next = around->items[i];
            if (!work->is_inside[next] || nearest[next] != TULLE_NONE) continue;
            nearest[next] = point.triangle;
            work->queue[count++] = next;
        }
    }
}

/* ---- a round ---- */

tulle_status move_apart(untangling *work) {
    const tulle_world *const world = work->world;
    memset(work->shift, 0, 3 * world->model.vertex_count * sizeof *work->shift);
    memset(work->votes, 0, world->model.vertex_count * sizeof *work->votes);
    tulle_status status = push_near(work);
    if (status == TULLE_OK) status = remember_crossings(work);
    if (status != TULLE_OK) return status;
    bool const is_clean = work->contours.count == 0 && work->contours.loose_count == 0;
    if (is_clean && work->has_gap) return TULLE_OK;
    for (size_t i = 0; i < work->contours.count; i++) {
        const surface_crossing *const crossing = &work->contours.crossings[i];
        if (crossing->wrong_end == CROSSING_UNDECIDED)
            shorten_contour(work, crossing);
        else
            push_through(work, crossing);
    }
    for (size_t i = 0; i < work->contours.loose_count; i++)
        part_loose(work, &work->contours.loose[i]);
    push_out_of_depth(work);
    spread_votes(work);
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        vec3_store(work->positions, v,
                   vec3_add(vec3_load(work->positions, v), vec3_load(work->shift, v)));
    calm_surroundings(work);
    uint32_t const edge_end = world->model.cloth_edge_count;
    for (int sweep = 0; sweep < LENGTH_SWEEPS; sweep++) {
        for (uint32_t i = 0; i < edge_end; i++) {
            uint32_t const e = sweep % 2 ? edge_end - 1 - i : i;
            const uint32_t *const ends = work->topo->edges + 2 * (size_t)e;
            double const length = work->lengths[e];
            limit_distance(work, ends[0], ends[1], SHORTEST_SHARE * length, LONGEST_SHARE * length);
        }
    }
    return TULLE_OK;
}
