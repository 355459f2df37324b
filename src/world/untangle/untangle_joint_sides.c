/* world/untangle/untangle_joint_sides.c - sides of contours that part a surface only together.
 *
 * A tube that lies half in an obstacle crosses it along two lines from border to border. Neither
 * line parts the tube; both together do. So all contours of one cloth with one obstacle are cut
 * at once if one of them parts nothing alone. The region with the largest area is right (area
 * inside a closed obstacle counts nothing). Of each crossing, the end that is more contours away
 * from that region is the wrong one. Contours that part nothing together either are decided one
 * by one (untangle_open_sides.c).
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003, section 4. */
#include "world/untangle/untangle_parts.h"

#include <stdlib.h>

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
