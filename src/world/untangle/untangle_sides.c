/* world/untangle/untangle_sides.c - which side of a contour is the wrong one.
 *
 * A contour cuts edges on the surfaces that it runs over. Flooding from the ends of cut edges
 * gives regions. Where the cuts part a surface, the largest region is right; the regions at the
 * other ends of its cut edges went through. Area inside a closed obstacle counts nothing, so
 * cloth comes out of obstacles even if most of it is inside. Where the cuts do not part the
 * surface, the crossing stays undecided.
 *
 * Based on: Baraff, Witkin, Kass, Untangling cloth, 2003, section 4. Departures: where an
 * obstacle has an inside, the region outside it is right, not the larger one; contours that end
 * at borders part a surface too. */
#include "world/start/inside.h"
#include "world/untangle/untangle_parts.h"

#include <string.h>

/* Area inside an obstacle still counts this share, to decide among regions that are all inside. */
static const double INSIDE_SHARE = 1e-6;

/* One surface lies along the other where the mean cosine between their directions across the
 * contour is at least this. */
static const double ALONG_COSINE = 0.3;

/* Length of the pull of a crossing that is aimed over a side of its triangle. On a bent contour it
 * is at most 2. */
static const double AIM_PULL = 4.0;

/* Gives `number` to all vertices that hang on `seed` without a cut edge. Returns their weight: the
 * area, of which a vertex at a cut counts the share that its edges reach. */
static double flood_region(untangling *work, uint32_t seed, uint32_t mark, uint32_t number) {
    const adjacency *const around = &work->topo->vertex_edges;
    size_t head = 0, tail = 0;
    double weight = 0.0;
    work->region[seed] = number;
    work->queue[tail++] = seed;
    while (head < tail) {
        uint32_t const vertex = work->queue[head++];
        double reach = 0.0;
        uint32_t const begin = around->begin[vertex], end = around->begin[vertex + 1];
        for (uint32_t i = begin; i < end; i++) {
            uint32_t const edge = around->items[i];
            const uint32_t *const ends = work->topo->edges + 2 * (size_t)edge;
            bool const is_second = ends[1] == vertex;
            if (work->cut[edge] == mark) {
                reach += 2.0 * (is_second ? 1.0 - work->cut_along[edge] : work->cut_along[edge]);
                continue;
            }
            reach += 1.0;
            uint32_t const next = is_second ? ends[0] : ends[1];
            if (work->region[next] == number) continue;
            work->region[next] = number;
            work->queue[tail++] = next;
        }
        double const share = work->is_inside[vertex] ? INSIDE_SHARE : 1.0;
        weight += share * work->areas[vertex] * reach / (double)(end - begin);
    }
    return weight;
}

/* Marks what lies inside an obstacle. Vertices of cloth that hang together without a cut edge are
 * all inside it or all outside, so one winding number tells. */
static void mark_inside(untangling *work, uint32_t surface, uint32_t mark, uint32_t *number) {
    const surface_range *const range = &work->world->work.surfaces[surface];
    const contour_set *const contours = &work->contours;
    for (size_t i = 0; i < contours->count; i++) {
        const surface_crossing *const crossing = &contours->crossings[i];
        if (crossing->triangle < range->triangle_begin || crossing->triangle >= range->triangle_end)
            continue;
        work->cut[crossing->edge] = mark;
        work->cut_along[crossing->edge] = crossing->along;
    }
    size_t const cloth_count = work->world->model.cloth_vertex_count;
    uint32_t const first = *number;
    for (size_t i = 0; i < contours->count; i++) {
        uint32_t const edge = contours->crossings[i].edge;
        if (work->cut[edge] != mark) continue;
        for (size_t k = 0; k < 2; k++) {
            uint32_t const seed = work->topo->edges[2 * (size_t)edge + k];
            if (work->region[seed] >= first) continue;
            vec3 const point = vec3_load(work->positions, seed);
            (void)flood_region(work, seed, mark, *number);
            double const winding = compute_winding_number(
                work->topo->triangles + 3 * (size_t)range->triangle_begin,
                range->triangle_end - range->triangle_begin, work->positions, point);
            for (size_t v = 0; winding > INSIDE_WINDING && v < cloth_count; v++)
                if (work->region[v] == *number) work->is_inside[v] = true;
            (*number)++;
        }
    }
}

void flood_contours(untangling *work, const contour_range *ranges, size_t count, flood *regions) {
    const surface_crossing *const crossings = work->contours.crossings;
    regions->count = 0;
    for (size_t k = 0; k < count; k++)
        for (size_t i = ranges[k].begin; i < ranges[k].end; i++) {
            work->cut[crossings[i].edge] = regions->mark;
            work->cut_along[crossings[i].edge] = crossings[i].along;
        }
    for (size_t k = 0; k < count; k++)
        for (size_t i = ranges[k].begin; i < ranges[k].end; i++)
            for (size_t end = 0; end < 2; end++) {
                uint32_t const seed = work->topo->edges[2 * (size_t)crossings[i].edge + end];
                if (work->region[seed] >= regions->begin) continue;
                uint32_t const number = regions->begin + regions->count;
                regions->weights[regions->count++] =
                    flood_region(work, seed, regions->mark, number);
            }
}

static vec3 leave_out(vec3 a, vec3 unit) {
    return vec3_normalize(vec3_add_scaled(a, unit, -vec3_dot(a, unit)));
}

/* Mean cosine between two directions across the contour: towards the second end of the crossing's
 * edge, and towards a corner of the triangle. Corners that are not in `region` count negative. */
static double compare_sides(const untangling *work, const surface_crossing *crossing,
                            uint32_t region) {
    const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    uint32_t const owner = work->topo->edge_triangles[2 * (size_t)crossing->edge];
    vec3 const tangent = vec3_normalize(vec3_cross(
        compute_triangle_normal(work, owner), compute_triangle_normal(work, crossing->triangle)));
    vec3 const a = vec3_load(work->positions, ends[0]), b = vec3_load(work->positions, ends[1]);
    vec3 const point = vec3_lerp(a, b, crossing->along);
    vec3 const way = leave_out(vec3_sub(b, a), tangent);
    double sum = 0.0;
    for (size_t k = 0; k < 3; k++) {
        vec3 const there = vec3_sub(vec3_load(work->positions, corners[k]), point);
        double const cosine = vec3_dot(way, leave_out(there, tangent));
        sum += work->region[corners[k]] == region ? cosine : -cosine;
    }
    return sum / 3.0;
}

/* Where two surfaces are each parted in two and lie along one another at the contour, what is
 * above and what is below is one decision for both. Adds to each region the weight of the one
 * that lies along it. */
static void join_sides(untangling *work, size_t begin, size_t end, flood *regions) {
    if (regions->count != 4) return;
    uint32_t pair[2][2];
    int pair_count = 0;
    for (size_t i = begin; i < end && pair_count < 2; i++) {
        const uint32_t *const ends =
            work->topo->edges + 2 * (size_t)work->contours.crossings[i].edge;
        uint32_t const a = work->region[ends[0]], b = work->region[ends[1]];
        if (a == b) return;
        if (pair_count == 1 && (a == pair[0][0] || a == pair[0][1])) continue;
        pair[pair_count][0] = a;
        pair[pair_count++][1] = b;
    }
    if (pair_count < 2) return;
    double sum = 0.0;
    for (size_t i = begin; i < end; i++) {
        const surface_crossing *const crossing = &work->contours.crossings[i];
        uint32_t const second = work->region[work->topo->edges[2 * (size_t)crossing->edge + 1]];
        bool const is_first = second == pair[0][0] || second == pair[0][1];
        const uint32_t *const own = pair[is_first ? 0 : 1], *const other = pair[is_first ? 1 : 0];
        double const cosine = compare_sides(work, crossing, other[0]);
        sum += second == own[0] ? cosine : -cosine;
    }
    double const cosine = sum / (double)(end - begin);
    if (fabs(cosine) < ALONG_COSINE) return;
    for (uint32_t k = 0; k < 2; k++) {
        double *const one = &regions->weights[pair[0][k] - regions->begin];
        double *const two = &regions->weights[pair[1][cosine > 0.0 ? k : 1 - k] - regions->begin];
        *one = *two = *one + *two;
    }
}

void aim_over_corners(const untangling *work, surface_crossing *crossing, const bool is_wrong[3]) {
    const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
    int const wrong_count = is_wrong[0] + is_wrong[1] + is_wrong[2];
    if (wrong_count == 0 || wrong_count == 3) return;
    uint32_t const owner = work->topo->edge_triangles[2 * (size_t)crossing->edge];
    vec3 const tangent = vec3_normalize(vec3_cross(
        compute_triangle_normal(work, owner), compute_triangle_normal(work, crossing->triangle)));
    vec3 way = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < 3; k++) {
        double const share = is_wrong[k] ? 1.0 / wrong_count : -1.0 / (3 - wrong_count);
        way = vec3_add_scaled(way, vec3_load(work->positions, corners[k]), share);
    }
    crossing->pull = vec3_scale(leave_out(way, tangent), AIM_PULL);
}

/* Regions of one contour, and the wrong ends of its crossings. False when it parts nothing. */
static bool decide_contour(untangling *work, const contour_range *range, flood *regions) {
    size_t const begin = range->begin, end = range->end;
    flood_contours(work, range, 1, regions);
    join_sides(work, begin, end, regions);
    bool is_open = true;
    for (size_t i = begin; i < end; i++) {
        surface_crossing *const crossing = &work->contours.crossings[i];
        const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
        uint32_t const a = work->region[ends[0]], b = work->region[ends[1]];
        if (a == b) continue;
        is_open = false;
        double const weight_a = regions->weights[a - regions->begin];
        double const weight_b = regions->weights[b - regions->begin];
        crossing->wrong_end = weight_a < weight_b || (weight_a == weight_b && a > b) ? 0 : 1;
    }
    if (is_open) return false;
    /* Aims crossings whose edge is not parted, but whose triangle is. */
    for (size_t i = begin; i < end; i++) {
        surface_crossing *const crossing = &work->contours.crossings[i];
        if (crossing->wrong_end != CROSSING_UNDECIDED) continue;
        const uint32_t *const corners = work->topo->triangles + 3 * (size_t)crossing->triangle;
        double weights[3], most = 0.0;
        for (size_t k = 0; k < 3; k++) {
            uint32_t const region = work->region[corners[k]];
            weights[k] = region < regions->begin ? 0.0 : regions->weights[region - regions->begin];
            most = fmax(most, weights[k]);
        }
        bool const is_wrong[3] = {weights[0] < most, weights[1] < most, weights[2] < most};
        aim_over_corners(work, crossing, is_wrong);
    }
    return true;
}

void mark_astray(untangling *work, const contour_range *range, const flood *regions) {
    for (size_t i = range->begin; i < range->end; i++) {
        const surface_crossing *const crossing = &work->contours.crossings[i];
        const uint32_t *const ends = work->topo->edges + 2 * (size_t)crossing->edge;
        for (size_t k = 0; k < 3; k++)
            work->is_astray[work->topo->triangles[3 * (size_t)crossing->triangle + k]] = true;
        work->is_astray[ends[0]] = work->is_astray[ends[1]] = true;
        if (crossing->wrong_end == CROSSING_UNDECIDED) continue;
        uint32_t const region = work->region[ends[crossing->wrong_end]];
        double *const weight = &regions->weights[region - regions->begin];
        if (*weight < 0.0) continue;
        *weight = -1.0; /* marked */
        for (size_t v = 0; v < work->world->model.vertex_count; v++)
            if (work->region[v] == region) work->is_astray[v] = true;
    }
}

tulle_status decide_sides(untangling *work) {
    tulle_world *const world = work->world;
    const contour_set *const contours = &work->contours;
    size_t const n = world->model.vertex_count;
    memset(work->is_inside, 0, n * sizeof(bool));
    memset(work->is_astray, 0, n * sizeof(bool));
    memset(work->region, 0, n * sizeof *work->region);
    memset(work->grown, 0, n * sizeof *work->grown);
    memset(work->cut, 0, work->topo->edge_count * sizeof *work->cut);
    flood regions = {.mark = 1, .begin = 1};
    regions.weights = ARENA_NEW(&world->work.scratch, double, 2 * contours->count);
    contour_range *const ranges = ARENA_NEW(&world->work.scratch, contour_range, contours->count);
    if (!regions.weights || !ranges) return TULLE_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; i < world->model.obstacles.count; i++)
        if (work->is_closed[i])
            mark_inside(work, (uint32_t)world->model.cloths.count + i, regions.mark++,
                        &regions.begin);

    /* Contours that part a surface each; open ones with obstacles are decided together below. */
    size_t range_count = 0;
    contour_range range;
    for (size_t begin = 0; begin < contours->count; begin = range.end) {
        const surface_crossing *const first = &contours->crossings[begin];
        uint32_t const a = world->model.vertex_surface[work->topo->edges[2 * (size_t)first->edge]];
        uint32_t const b =
            world->model.vertex_surface[work->topo->triangles[3 * (size_t)first->triangle]];
        range = (contour_range){
            .begin = begin, .end = begin + 1, .cloth = a < b ? a : b, .obstacle = a < b ? b : a};
        while (range.end < contours->count &&
               contours->crossings[range.end].contour == first->contour)
            range.end++;
        regions.mark++;
        regions.begin += regions.count;
        range.is_open = !decide_contour(work, &range, &regions);
        bool const is_of_obstacle = range.obstacle >= world->model.cloths.count;
        if (is_of_obstacle) ranges[range_count++] = range;
        if (!range.is_open)
            mark_astray(work, &range, &regions);
        else if (!is_of_obstacle)
            decide_open_contour(work, &range, &regions);
    }
    return decide_joint_contours(work, ranges, range_count, &regions);
}
