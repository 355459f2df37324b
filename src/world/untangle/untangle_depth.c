/* world/untangle/untangle_depth.c - the way out for cloth deep inside an obstacle.
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
#include "geom/distance.h"
#include "world/untangle/untangle_parts.h"

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

void push_out_of_depth(untangling *work) {
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
