/* world/untangle/untangle_open_sides.c - sides of contours that part a surface only together,
 * or not at all.
 *
 * A contour that parts nothing ends within a surface, where a border of the other one pierces it.
 * Along the contour the ends of crossed edges still fall into two rows, one on each side; growing
 * from both rows at once parts the surface along the contour and, past its tip, midway between the
 * rows. The smallest part of all surfaces is the one that is easiest to bring to the other side: it
 * is wrong.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003, for closed contours; Wicke, Lanker,
 * Gross, Untangling cloth with boundaries, 2006, which handles tips in another way. */
#include "geom/union_find.h"
#include "world/untangle/untangle_parts.h"

#include <stdlib.h>

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

/* ---- contours that part a surface only together ----
 *
 * A tube that lies half in an obstacle crosses it along two lines from border to border. Neither
 * line parts the tube; both together do. So all contours of one cloth with one obstacle are cut
 * at once if one of them parts nothing alone. The region with the largest area is right (area
 * inside a closed obstacle counts nothing). Of each crossing, the end that is more contours away
 * from that region is the wrong one. Contours that part nothing together either are decided one
 * by one, as above.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003, section 4. */

static int compare_ranges(const void *a, const void *b) {
    const contour_range *const x = a, *const y = b;
    if (x->obstacle != y->obstacle) return x->obstacle < y->obstacle ? -1 : 1;
    if (x->cloth != y->cloth) return x->cloth < y->cloth ? -1 : 1;
    return (x->begin > y->begin) - (x->begin < y->begin);
}

static uint32_t get_end_region(const untangling *work, const surface_crossing *crossing,
                               size_t end) {
    return work->region[work->topo->edges[2 * (size_t)crossing->edge + end]];
}

/* Contours of one cloth and one obstacle. */
typedef struct contour_group {
    const contour_range *ranges;
    size_t count;
    const flood *regions;
    uint32_t *distances; /* per region: contours between it and the largest one */
} contour_group;

/* Contours between each region and the largest one of its piece of surface. */
static void compute_distances(const untangling *work, const contour_group *group) {
    const flood *const regions = group->regions;
    uint32_t *const distances = group->distances;
    for (uint32_t r = 0; r < regions->count; r++) distances[r] = TULLE_NONE;
    for (;;) {
        uint32_t largest = TULLE_NONE;
        for (uint32_t r = 0; r < regions->count; r++)
            if (distances[r] == TULLE_NONE &&
                (largest == TULLE_NONE || regions->weights[r] > regions->weights[largest]))
                largest = r;
        if (largest == TULLE_NONE) return;
        distances[largest] = 0;
        /* Both regions of a crossing differ by one contour at most. */
        bool has_changed = true;
        while (has_changed) {
            has_changed = false;
            for (size_t k = 0; k < group->count; k++)
                for (size_t i = group->ranges[k].begin; i < group->ranges[k].end; i++) {
                    const surface_crossing *const crossing = &work->contours.crossings[i];
                    for (size_t end = 0; end < 2; end++) {
                        uint32_t const near = get_end_region(work, crossing, end) - regions->begin;
                        uint32_t const far =
                            get_end_region(work, crossing, 1 - end) - regions->begin;
                        if (distances[near] == TULLE_NONE || distances[far] <= distances[near] + 1)
                            continue;
                        distances[far] = distances[near] + 1;
                        has_changed = true;
                    }
                }
        }
    }
}

/* Wrong ends, and aims where an edge is not parted but its triangle is. */
static void decide_crossing(const untangling *work, const contour_group *group,
                            surface_crossing *crossing) {
    uint32_t const begin = group->regions->begin;
    uint32_t const a = get_end_region(work, crossing, 0) - begin;
    uint32_t const b = get_end_region(work, crossing, 1) - begin;
    const double *const weights = group->regions->weights;
    crossing->is_joint = true;
    if (a != b) {
        bool const is_equal = group->distances[a] == group->distances[b];
        bool const is_first = is_equal
                                  ? weights[a] < weights[b] || (weights[a] == weights[b] && a > b)
                                  : group->distances[a] > group->distances[b];
        crossing->wrong_end = is_first ? 0 : 1;
        return;
    }
    uint32_t distances[3], least = TULLE_NONE;
    for (size_t k = 0; k < 3; k++) {
        uint32_t const corner = work->topo->triangles[3 * (size_t)crossing->triangle + k];
        uint32_t const region = work->region[corner];
        distances[k] = region < begin ? 0 : group->distances[region - begin];
        if (distances[k] < least) least = distances[k];
    }
    bool const is_wrong[3] = {distances[0] > least, distances[1] > least, distances[2] > least};
    aim_over_corners(work, crossing, is_wrong);
}

tulle_status decide_joint_contours(untangling *work, contour_range *ranges, size_t count,
                                   flood *regions) {
    qsort(ranges, count, sizeof *ranges, compare_ranges);
    uint32_t *const distances =
        ARENA_NEW(&work->world->work.scratch, uint32_t, 2 * work->contours.count + 1);
    if (!distances) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t begin = 0, end; begin < count; begin = end) {
        bool has_open = false;
        for (end = begin; end < count && ranges[end].obstacle == ranges[begin].obstacle &&
                          ranges[end].cloth == ranges[begin].cloth;
             end++)
            has_open |= ranges[end].is_open;
        regions->mark++;
        regions->begin += regions->count;
        if (!has_open) continue; /* all are decided already */

        contour_group const group = {ranges + begin, end - begin, regions, distances};
        flood_contours(work, group.ranges, group.count, regions);
        bool is_parted = false; /* some edge has its ends in two regions */
        for (size_t k = begin; k < end; k++)
            for (size_t i = ranges[k].begin; i < ranges[k].end; i++) {
                const surface_crossing *const crossing = &work->contours.crossings[i];
                is_parted |= get_end_region(work, crossing, 0) != get_end_region(work, crossing, 1);
            }
        if (is_parted) compute_distances(work, &group);
        for (size_t k = begin; k < end; k++) {
            const contour_range *const range = &ranges[k];
            if (is_parted) {
                for (size_t i = range->begin; i < range->end; i++)
                    decide_crossing(work, &group, &work->contours.crossings[i]);
                mark_astray(work, range, regions);
            } else if (range->is_open) {
                regions->mark++;
                regions->begin += regions->count;
                flood_contours(work, range, 1, regions);
                decide_open_contour(work, range, regions);
            }
        }
    }
    return TULLE_OK;
}
