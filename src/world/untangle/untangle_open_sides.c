/* world/untangle/untangle_open_sides.c - sides of a contour that parts nothing.
 *
 * Such a contour ends within a surface, where a border of the other one pierces it. Along the
 * contour the ends of crossed edges still fall into two rows, one on each side; growing from both
 * rows at once parts the surface along the contour and, past its tip, midway between the rows. The
 * smallest part of all surfaces is the one that is easiest to bring to the other side: it is wrong.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003, for closed contours; Wicke, Lanker,
 * Gross, Untangling cloth with boundaries, 2006, which handles tips in another way. */
#include "world/untangle/untangle_parts.h"

#include "geom/union_find.h"

/* Shorter contours that part nothing are shortened, or oriented. */
enum { OPEN_CROSSINGS_MIN = 3 };

/* Joins neighbouring ends on the same side: a triangle that the contour crosses from edge to edge
 * has its third edge on one side. */
static void join_rows(untangling *work, size_t begin, size_t end, uint32_t mark) {
    for (size_t i = begin; i < end; i++) {
        uint32_t const edge = work->contours.crossings[i].edge;
        for (size_t k = 0; k < 2; k++) {
            uint32_t const vertex = work->topo->edges[2 * (size_t)edge + k];
            work->sets[vertex] = vertex;
            work->set_areas[vertex] = 0.0;
        }
    }
    for (size_t i = begin; i < end; i++) {
        size_t const edge = work->contours.crossings[i].edge;
        for (size_t k = 0; k < 2; k++) {
            uint32_t const triangle = work->topo->edge_triangles[2 * edge + k];
            uint32_t uncut = TULLE_NONE;
            size_t cut_count = 0;
            for (size_t side = 0; triangle != TULLE_NONE && side < 3; side++) {
                uint32_t const other = work->topo->triangle_edges[3 * (size_t)triangle + side];
                bool const is_cut = work->cut[other] == mark;
                cut_count += is_cut;
                if (!is_cut) uncut = other;
            }
            if (cut_count != 2) continue;
            union_find_join(work->sets, work->topo->edges[2 * (size_t)uncut],
                            work->topo->edges[2 * (size_t)uncut + 1]);
        }
    }
}

/* Grows all rows at once; their areas are added at the roots. region: root + number. */
static void grow_rows(untangling *work, size_t begin, size_t end, uint32_t mark) {
    const adjacency *const around = &work->topo->vertex_edges;
    size_t head = 0, tail = 0;
    for (size_t i = begin; i < end; i++) {
        for (size_t k = 0; k < 2; k++) {
            uint32_t const vertex =
                work->topo->edges[2 * (size_t)work->contours.crossings[i].edge + k];
            if (work->grown[vertex] == mark) continue;
            work->grown[vertex] = mark;
            work->queue[tail++] = vertex;
        }
    }
    while (head < tail) {
        uint32_t const vertex = work->queue[head++];
        uint32_t const root = union_find_root(work->sets, vertex);
        work->set_areas[root] += work->areas[vertex];
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
            uint32_t const edge = around->items[i];
            const uint32_t *const ends = work->topo->edges + 2 * (size_t)edge;
            uint32_t const next = ends[0] == vertex ? ends[1] : ends[0];
            if (work->cut[edge] == mark || work->grown[next] == mark) continue;
            work->grown[next] = mark;
            work->sets[next] = root;
            work->queue[tail++] = next;
        }
    }
}

void decide_open_contour(untangling *work, const contour_range *range, const flood *regions) {
    size_t const begin = range->begin, end = range->end;
    uint32_t const mark = regions->mark;
    if (end - begin < OPEN_CROSSINGS_MIN) { /* too short for rows */
        mark_astray(work, range, regions);
        orient_short_contour(work, range);
        return;
    }
    join_rows(work, begin, end, mark);
    grow_rows(work, begin, end, mark);
    double smallest = (double)INFINITY;
    uint32_t wrong = TULLE_NONE;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *const ends =
            work->topo->edges + 2 * (size_t)work->contours.crossings[i].edge;
        uint32_t const a = union_find_root(work->sets, ends[0]);
        uint32_t const b = union_find_root(work->sets, ends[1]);
        if (a == b || work->mobility[ends[0]] + work->mobility[ends[1]] == 0.0) continue;
        uint32_t const less = work->set_areas[a] < work->set_areas[b] ? a : b;
        if (work->set_areas[less] >= smallest) continue;
        smallest = work->set_areas[less];
        wrong = less;
    }
    for (size_t i = begin; i < end && wrong != TULLE_NONE; i++) {
        surface_crossing *const crossing = &work->contours.crossings[i];
        const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
        uint32_t const a = union_find_root(work->sets, ends[0]);
        uint32_t const b = union_find_root(work->sets, ends[1]);
        if (a != b && (a == wrong || b == wrong)) {
            crossing->wrong_end = a == wrong ? 0 : 1;
            continue;
        }
        const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
        bool is_wrong[3];
        for (size_t k = 0; k < 3; k++)
            is_wrong[k] =
                work->grown[corners[k]] == mark && union_find_root(work->sets, corners[k]) == wrong;
        aim_over_corners(work, crossing, is_wrong);
    }
    mark_astray(work, range, regions);
}
