/* world/untangle_orientation.c - contours too short to part anything.
 *
 * One or two crossings that part no surface are a corner that looks through a triangle, or two
 * ridges that pass over each other. There the geometric correction decides. An end of the edge that
 * is alone on its side of the triangle, with all its neighbours on the other, went through: it is
 * the wrong one. Else edge and nearest side of the triangle are a pair of edges, oriented by the
 * vertices opposite them; they part along their common normal. What stays undecided is shortened.
 *
 * In: undecided crossings of a contour. Out: wrong ends, or the ways that edges go.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.6. Departures: there is no history before the first step; the verification by
 * triangles, which always decides, is left out, for it costs more rounds than it saves. */
#include "contact/orientation.h"
#include "world/untangle_parts.h"

/* Of escalation: before, contours are shortened, which frees most of them in fewer rounds. */
enum { ORIENTED_LEVEL = 1 };
/* Of a crossing whose edges are oriented; that of one on a bent contour is at most 2. */
static const double ORIENTED_PULL = 2.0;
/* Least sine between edges that have a common normal. */
static const double CROSSING_SINE = 0.1;

/* Whether the end comes from the other side of the triangle. */
static bool is_astray_by_neighbours(const untangling *work, const surface_crossing *crossing,
                                    size_t end, vec3 point) {
    uint32_t const vertex = work->topo->edges[2 * (size_t)crossing->edge + end];
    vec3 const normal = find_triangle_normal(work, crossing->triangle);
    oriented_pair const question = {
        FEATURE_VERTEX_TRIANGLE, {vertex, crossing->triangle}, normal, point};
    orientation const side = orient_by_neighbours(work->topo, work->positions, &question);
    double const height = vec3_dot(normal, vec3_sub(vec3_load(work->positions, vertex), point));
    return (side == ORIENTATION_ALONG && height < 0.0) ||
           (side == ORIENTATION_AGAINST && height > 0.0);
}

/* The side of the triangle that the crossing is nearest to. */
static uint32_t find_nearest_side(const untangling *work, const surface_crossing *crossing) {
    uint32_t const *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    size_t far = 0;
    for (size_t k = 1; k < 3; k++)
        if (crossing->weights[k] < crossing->weights[far]) far = k;
    for (size_t k = 0; k < 3; k++) {
        uint32_t const side = work->topo->triangle_edges[3 * (size_t)crossing->triangle + k];
        uint32_t const *const ends = work->topo->edges + 2 * (size_t)side;
        if (ends[0] != corners[far] && ends[1] != corners[far]) return side;
    }
    return work->topo->triangle_edges[3 * (size_t)crossing->triangle];
}

static vec3 edge_vector(const untangling *work, uint32_t edge) {
    uint32_t const *const ends = work->topo->edges + 2 * (size_t)edge;
    return vec3_sub(vec3_load(work->positions, ends[1]), vec3_load(work->positions, ends[0]));
}

/* Edge and side part along their common normal. */
static void orient_edges(const untangling *work, surface_crossing *crossing, vec3 point) {
    uint32_t const side = find_nearest_side(work, crossing);
    vec3 const a = vec3_normalize(edge_vector(work, crossing->edge));
    vec3 const b = vec3_normalize(edge_vector(work, side));
    vec3 const normal = vec3_cross(a, b);
    if (vec3_norm(normal) < CROSSING_SINE) return;
    oriented_pair const question = {
        FEATURE_EDGE_EDGE, {crossing->edge, side}, vec3_normalize(normal), point};
    orientation const way = orient_by_neighbours(work->topo, work->positions, &question);
    if (way == ORIENTATION_UNDECIDED) return;
    crossing->pull = vec3_scale(question.axis, ORIENTED_PULL * (double)way);
}

static void orient_crossing(const untangling *work, surface_crossing *crossing) {
    uint32_t const *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
    vec3 const point = vec3_lerp(vec3_load(work->positions, ends[0]),
                                 vec3_load(work->positions, ends[1]), crossing->along);
    bool const is_first = is_astray_by_neighbours(work, crossing, 0, point);
    bool const is_second = is_astray_by_neighbours(work, crossing, 1, point);
    if (is_first != is_second)
        crossing->wrong_end = is_first ? 0 : 1;
    else
        orient_edges(work, crossing, point);
}

void orient_short_contour(untangling *work, size_t begin, size_t end) {
    if (work->level < ORIENTED_LEVEL) return;
    for (size_t i = begin; i < end; i++)
        if (work->contours.crossings[i].wrong_end == CROSSING_UNDECIDED)
            orient_crossing(work, &work->contours.crossings[i]);
}
