/* world/untangle/untangle_short_contours.c - contours too short to part anything.
 *
 * One or two crossings that part no surface are a corner that looks through a triangle, or two
 * ridges that pass over each other. Where rounds have stalled, the first of three rules that can
 * decide does:
 * - History. The round before left the sides of vertices and triangles: of pairs that were near
 *   but not astray, and of crossings whose wrong end was known. An end of the edge that is now
 *   on the other side went through.
 * - Geometric correction with verification. An end of the edge may be alone on its side of the
 *   triangle, with all its neighbours on the other. It is the wrong one if the edge's triangle
 *   and the crossed one say so too.
 * - Geometric correction of edges. The edge and the nearest side of the triangle are a pair,
 *   which the vertices opposite them orient. They part along their common normal.
 * What stays undecided is shortened.
 *
 * In: undecided crossings of a contour. Out: wrong ends, or the ways that edges go; after all
 * contours, the history for the next round.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6. Departures: pairs of edges have no history, because it hardly ever decides;
 * the verification decides nothing alone, because it always says something and costs rounds. */
#include "world/untangle/orientation.h"
#include "world/untangle/untangle_parts.h"

/* Contours are oriented from this level of escalation on. Before, they are shortened, which frees
 * most of them in fewer rounds. */
enum { ORIENTED_LEVEL = 1 };
/* Length of the pull of a crossing whose edges are oriented. On a bent contour it is at most 2. */
static const double ORIENTED_PULL = 2.0;
/* Least sine between edges that have a common normal. */
static const double CROSSING_SINE = 0.1;

/* An end of a crossing edge and the plane of the triangle. */
typedef struct end_place {
    oriented_pair question;
    double height; /* [m] along the question's axis */
} end_place;

static end_place place_end(const untangling *work, const surface_crossing *crossing, size_t end) {
    uint32_t const vertex = work->topo->edges[2 * (size_t)crossing->edge + end];
    vec3 const point = compute_crossing_point(work, crossing);
    vec3 const normal = compute_triangle_normal(work, crossing->triangle);
    double const height = vec3_dot(normal, vec3_sub(vec3_load(work->positions, vertex), point));
    return (end_place){{FEATURE_VERTEX_TRIANGLE, {vertex, crossing->triangle}, normal, point},
                       height};
}

/* The end of the edge that came from the other side of the triangle, by the sides on which the ends
 * belong. Undecided unless it is exactly one. */
static uint32_t choose_end(const end_place places[2], const orientation sides[2]) {
    bool is_astray[2];
    for (size_t end = 0; end < 2; end++)
        is_astray[end] = (double)sides[end] * places[end].height < 0.0;
    if (is_astray[0] == is_astray[1]) return CROSSING_UNDECIDED;
    return is_astray[0] ? 0 : 1;
}

static uint32_t choose_end_by_history(const untangling *work, const surface_crossing *crossing) {
    end_place places[2];
    orientation sides[2];
    for (size_t end = 0; end < 2; end++) {
        places[end] = place_end(work, crossing, end);
        const oriented_pair *const question = &places[end].question;
        sides[end] = orient_by_history(work->topo, &work->history, question->pair, question->axis);
    }
    return choose_end(places, sides);
}

/* By the neighbours of each end. The edge's triangle and the crossed one must agree. */
static uint32_t choose_end_by_neighbours(const untangling *work, const surface_crossing *crossing) {
    end_place places[2];
    orientation sides[2];
    for (size_t end = 0; end < 2; end++) {
        places[end] = place_end(work, crossing, end);
        sides[end] = orient_by_neighbours(work->topo, work->positions, &places[end].question);
    }
    uint32_t const end = choose_end(places, sides);
    if (end == CROSSING_UNDECIDED) return end;
    uint32_t const owner = work->topo->edge_triangles[2 * (size_t)crossing->edge];
    orientation const side = orient_by_triangles(work->topo, work->positions, owner,
                                                 crossing->triangle, places[end].question.axis);
    return (double)side * places[end].height < 0.0 ? end : CROSSING_UNDECIDED;
}

/* The edge, and the side of the triangle that it crosses nearest to, part along their common
 * normal. */
static void orient_edges(const untangling *work, surface_crossing *crossing) {
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    const uint32_t *const sides = work->topo->triangle_edges + 3 * (size_t)crossing->triangle;
    size_t far = 0;
    for (size_t k = 1; k < 3; k++)
        if (crossing->weights[k] < crossing->weights[far]) far = k;
    uint32_t side = sides[0];
    for (size_t k = 3; k-- > 0;) {
        const uint32_t *const ends = work->topo->edges + 2 * (size_t)sides[k];
        if (ends[0] != corners[far] && ends[1] != corners[far]) side = sides[k];
    }
    vec3 const normal = vec3_cross(compute_edge_direction(work, crossing->edge),
                                   compute_edge_direction(work, side));
    if (vec3_norm(normal) < CROSSING_SINE) return;
    oriented_pair const question = {FEATURE_EDGE_EDGE,
                                    {crossing->edge, side},
                                    vec3_normalize(normal),
                                    compute_crossing_point(work, crossing)};
    orientation const way = orient_by_neighbours(work->topo, work->positions, &question);
    if (way == ORIENTATION_UNDECIDED) return;
    crossing->pull = vec3_scale(question.axis, ORIENTED_PULL * (double)way);
}

void orient_short_contour(untangling *work, const contour_range *range) {
    if (work->level < ORIENTED_LEVEL) return;
    for (size_t i = range->begin; i < range->end; i++) {
        surface_crossing *const crossing = &work->contours.crossings[i];
        if (crossing->wrong_end != CROSSING_UNDECIDED) continue;
        crossing->wrong_end = choose_end_by_history(work, crossing);
        if (crossing->wrong_end == CROSSING_UNDECIDED)
            crossing->wrong_end = choose_end_by_neighbours(work, crossing);
        if (crossing->wrong_end == CROSSING_UNDECIDED) orient_edges(work, crossing);
    }
}

tulle_status remember_crossings(untangling *work) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < work->contours.count && status == TULLE_OK; i++) {
        const surface_crossing *const crossing = &work->contours.crossings[i];
        if (crossing->wrong_end == CROSSING_UNDECIDED) continue;
        /* Both ends of the edge belong where the right one is. */
        end_place const right = place_end(work, crossing, 1 - crossing->wrong_end);
        vec3 const axis = right.question.axis;
        vec3 const normal = right.height < 0.0 ? vec3_neg(axis) : axis;
        for (size_t end = 0; end < 2 && status == TULLE_OK; end++) {
            uint32_t const vertex = work->topo->edges[2 * (size_t)crossing->edge + end];
            status = remember_side(&work->history, &work->world->heap,
                                   (known_side){vertex, crossing->triangle, normal});
        }
    }
    settle_history(&work->history);
    return status;
}
