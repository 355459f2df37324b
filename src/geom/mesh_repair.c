/* geom/mesh_repair.c - makes an oriented manifold of a mesh, where that can be done in small steps.
 *
 * In: any triangles. Out: triangles without area and duplicates are gone, boundaries that meet
 * are joined, neighbours face the same way, and a vertex has one fan of triangles.
 *
 * Boundaries first, in passes, since each step may make room for another one: a needle is closed at
 * its short edge; a flat triangle is dropped, and the edge behind it is split at the vertex that
 * lay on it; boundary vertices in the same place become one; a boundary edge on which vertices of
 * other boundary edges lie is split there. Then the mesh is cut: at an edge with three or more
 * triangles the two that go on most straight stay joined, the others come loose, and of the fans at
 * a vertex the largest keeps it. The others get a vertex of their own, a little way inwards, since
 * sheets that touch intersect. Last, triangles are turned as the most of their piece, and vertices
 * without a triangle are left out.
 *
 * What is made is repaired: a second time nothing is done. */
#include "geom/mesh.h"

#include "base/error.h"
#include "base/sort.h"
#include "geom/union_find.h"
#include "math/vec3.h"

#include <string.h>

/* [of the shortest edge at a vertex] How far a fan moves away from what it is cut off. Far above
 * the rounding of floats in files, far below what one sees. */
static const double SHIFT_SHARE = 0.01;
/* [of the tolerance] and at least so far, or a second repair would join it again. */
static const double SHIFT_TOLERANCES = 2.0;

typedef struct repair {
    memory *heap;
    double tolerance;
    tulle_mesh_repairs *report;
    ARRAY(double) positions;    /* 3 * vertices */
    ARRAY(uint32_t) triangles;  /* 3 * triangles */
    ARRAY(uint8_t) is_joined;   /* of each vertex: another one stands for it */
    topology topo;              /* between begin_pass and end_pass */
    uint32_t *uses;             /* triangles of each edge */
    struct line_place *borders; /* boundary vertices along the longest axis */
    size_t border_count;
    int axis;
} repair;

/* Where something lies along a line. */
typedef struct line_place {
    double at;
    uint32_t vertex;
} line_place;

static int compare_places(const void *one, const void *two) {
    const line_place *const a = one, *const b = two;
    if (a->at != b->at) return a->at < b->at ? -1 : 1;
    return (a->vertex > b->vertex) - (a->vertex < b->vertex);
}

static size_t count_triangles(const repair *r) { return r->triangles.count / 3; }
static size_t count_vertices(const repair *r) { return r->positions.count / 3; }
static vec3 get_point(const repair *r, size_t v) { return vec3_load(r->positions.data, v); }
static double get_distance(const repair *r, uint32_t a, uint32_t b) {
    return vec3_norm(vec3_sub(get_point(r, a), get_point(r, b)));
}

static void note(repair *r, tulle_repair kind, vec3 place) {
    if (r->report->counts[kind]++ == 0) vec3_store(r->report->places, (size_t)kind, place);
}

static bool is_line(const uint32_t *corner) {
    return corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0];
}

/* Closes the short edges of needles. False when memory is short. */
static bool close_needles(repair *r) {
    size_t const bytes = count_vertices(r) * sizeof(uint32_t);
    uint32_t *const roots = memory_allocate(r->heap, bytes);
    if (!roots) return false;
    union_find_reset(roots, count_vertices(r));
    for (size_t t = 0; t < count_triangles(r); t++) {
        const uint32_t *const corner = r->triangles.data + 3 * t;
        if (is_line(corner) ||
            triangle_get_height_ratio(r->positions.data, corner) >= THIN_TRIANGLE_RATIO)
            continue;
        double longest = 0.0;
        for (size_t k = 0; k < 3; k++)
            longest = fmax(longest, get_distance(r, corner[k], corner[(k + 1) % 3]));
        for (size_t k = 0; k < 3; k++)
            if (get_distance(r, corner[k], corner[(k + 1) % 3]) <= THIN_TRIANGLE_RATIO * longest)
                union_find_join(roots, corner[k], corner[(k + 1) % 3]);
    }
    for (uint32_t v = 0; v < count_vertices(r); v++)
        if (union_find_root(roots, v) != v) r->is_joined.data[v] = 1;
    for (size_t i = 0; i < r->triangles.count; i++)
        r->triangles.data[i] = union_find_root(roots, r->triangles.data[i]);
    memory_release(r->heap, roots, bytes);
    return true;
}

/* Drops triangles that have no area or are there twice. False when memory is short. */
static bool drop_triangles(repair *r) {
    size_t next = 0, duplicate_count = 0;
    uint32_t *const all = r->triangles.data;
    for (size_t t = 0; t < count_triangles(r); t++) {
        const uint32_t *const corner = all + 3 * t;
        bool const is_proper =
            !is_line(corner) &&
            triangle_get_height_ratio(r->positions.data, corner) >= THIN_TRIANGLE_RATIO;
        if (is_proper)
            memmove(all + 3 * next++, corner, 3 * sizeof *all);
        else
            note(r, TULLE_REPAIR_DEGENERATE, get_point(r, corner[0]));
    }
    r->triangles.count = 3 * next;
    uint32_t *const originals = memory_allocate(r->heap, next * sizeof *originals);
    tulle_mesh_view const view = {r->positions.data, count_vertices(r), all, next};
    bool const has_memory =
        next == 0 ||
        (originals && mesh_find_duplicates(r->heap, view, originals, &duplicate_count));
    size_t kept = 0;
    for (size_t t = 0; has_memory && t < next; t++) {
        if (originals[t] == TULLE_NONE)
            memmove(all + 3 * kept++, all + 3 * t, 3 * sizeof *all);
        else
            note(r, TULLE_REPAIR_DUPLICATE, get_point(r, all[3 * t]));
    }
    if (has_memory) r->triangles.count = 3 * kept;
    memory_release(r->heap, originals, next * sizeof *originals);
    return has_memory;
}

static void end_pass(repair *r) {
    memory_release(r->heap, r->borders, count_vertices(r) * sizeof *r->borders);
    memory_release(r->heap, r->uses, r->topo.edge_count * sizeof *r->uses);
    topology_destroy(r->heap, &r->topo);
    r->borders = NULL;
    r->uses = NULL;
}

/* Edges, and boundary vertices along the longest axis. end_pass releases them, also after a
 * failure. */
static tulle_status begin_pass(repair *r) {
    r->topo = (topology){0};
    r->border_count = 0;
    tulle_status const status =
        topology_build(r->heap, r->triangles.data, count_triangles(r), count_vertices(r), &r->topo);
    if (status != TULLE_OK) return status;
    r->uses = memory_allocate(r->heap, r->topo.edge_count * sizeof *r->uses);
    r->borders = memory_allocate(r->heap, count_vertices(r) * sizeof *r->borders);
    if (!r->uses || !r->borders) return TULLE_ERROR_OUT_OF_MEMORY;
    topology_count_edge_uses(&r->topo, r->uses);
    for (uint32_t v = 0; v < count_vertices(r); v++) {
        const adjacency *const edges = &r->topo.vertex_edges;
        bool is_border = false;
        for (uint32_t k = edges->begin[v]; k < edges->begin[v + 1]; k++)
            is_border |= r->uses[edges->items[k]] == 1;
        if (is_border) r->borders[r->border_count++] = (line_place){get_point(r, v).x, v};
    }
    vec3 low = {INFINITY, INFINITY, INFINITY}, high = vec3_neg(low);
    for (size_t i = 0; i < r->border_count; i++) {
        vec3 const x = get_point(r, r->borders[i].vertex);
        low = vec3_make(fmin(low.x, x.x), fmin(low.y, x.y), fmin(low.z, x.z));
        high = vec3_make(fmax(high.x, x.x), fmax(high.y, x.y), fmax(high.z, x.z));
    }
    vec3 const size = vec3_sub(high, low);
    r->axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    for (size_t i = 0; i < r->border_count; i++)
        r->borders[i].at = r->positions.data[3 * (size_t)r->borders[i].vertex + (size_t)r->axis];
    sort_in_place(r->borders, r->border_count, sizeof *r->borders, compare_places);
    return TULLE_OK;
}

/* Whether a vertex has a neighbour that `other` stands for. */
static bool is_near(const repair *r, const uint32_t *stands, uint32_t vertex, uint32_t other) {
    const adjacency *const lists = &r->topo.vertex_neighbours;
    for (uint32_t k = lists->begin[vertex]; k < lists->begin[vertex + 1]; k++)
        if (stands[lists->items[k]] == other) return true;
    return false;
}

/* Boundary vertices in the same place become one, unless an edge joins them. */
static bool join_vertices(repair *r, size_t *changed) {
    size_t const bytes = count_vertices(r) * sizeof(uint32_t);
    uint32_t *const stands = memory_allocate(r->heap, bytes);
    if (!stands) return false;
    union_find_reset(stands, count_vertices(r));
    for (size_t i = 0; i < r->border_count; i++) {
        uint32_t const v = r->borders[i].vertex;
        uint32_t best = v;
        double nearest = r->tolerance;
        /* who stands for others may lie before them by the tolerance once more */
        for (size_t j = i; j-- > 0 && r->borders[i].at - r->borders[j].at <= 2.0 * r->tolerance;) {
            uint32_t const other = stands[r->borders[j].vertex];
            double const distance = get_distance(r, v, other);
            if (distance > nearest || (best != v && distance == nearest && other > best) ||
                is_near(r, stands, v, other))
                continue;
            nearest = distance;
            best = other;
        }
        if (best == v) continue;
        stands[v] = best;
        r->is_joined.data[v] = 1;
        note(r, TULLE_REPAIR_JOINED, get_point(r, v));
        ++*changed;
    }
    for (size_t i = 0; i < r->triangles.count; i++)
        r->triangles.data[i] = stands[r->triangles.data[i]];
    memory_release(r->heap, stands, bytes);
    return true;
}

/* A boundary edge, as its triangle goes along it. */
typedef struct border {
    uint32_t edge, triangle, begin, end, opposite;
    vec3 origin, direction; /* unit */
    double length, tolerance;
} border;

/* Whether a vertex is on the edge, and where along it; the ends are within. */
static bool find_along(const repair *r, const border *b, uint32_t vertex, double *at) {
    vec3 const x = vec3_sub(get_point(r, vertex), b->origin);
    *at = vec3_dot(x, b->direction);
    return *at >= -b->tolerance && *at <= b->length + b->tolerance &&
           vec3_norm(vec3_add_scaled(x, b->direction, -*at)) <= b->tolerance;
}

/* Whether the vertex lies within the edge, and goes on along it by a boundary edge of its own. */
static bool is_hanging(const repair *r, const border *b, uint32_t vertex, double *at) {
    if (vertex == b->begin || vertex == b->end || vertex == b->opposite ||
        !find_along(r, b, vertex, at) || *at <= b->tolerance || *at >= b->length - b->tolerance)
        return false;
    const adjacency *const edges = &r->topo.vertex_edges;
    for (uint32_t k = edges->begin[vertex]; k < edges->begin[vertex + 1]; k++) {
        uint32_t const edge = edges->items[k];
        const uint32_t *const ends = r->topo.edges + 2 * (size_t)edge;
        double unused;
        if (r->uses[edge] == 1 && edge != b->edge &&
            find_along(r, b, ends[0] == vertex ? ends[1] : ends[0], &unused))
            return true;
    }
    return false;
}

/* Splits the triangle at the vertices that lie on its edge, if all parts have an area and face as
 * it does. */
static bool split_border(repair *r, const border *b, line_place *found, size_t count,
                         size_t *changed) {
    sort_in_place(found, count, sizeof *found, compare_places);
    vec3 const top = get_point(r, b->opposite);
    vec3 const normal = vec3_cross(b->direction, vec3_sub(top, b->origin));
    for (size_t i = 0; i <= count; i++) {
        uint32_t const corner[3] = {i == 0 ? b->begin : found[i - 1].vertex,
                                    i == count ? b->end : found[i].vertex, b->opposite};
        vec3 const start = get_point(r, corner[0]);
        vec3 const part =
            vec3_cross(vec3_sub(get_point(r, corner[1]), start), vec3_sub(top, start));
        if (is_line(corner) || !(vec3_dot(part, normal) > 0.0) ||
            triangle_get_height_ratio(r->positions.data, corner) < THIN_TRIANGLE_RATIO)
            return true;
    }
    if (!ARRAY_RESERVE(r->heap, &r->triangles, 3 * count)) return false;
    for (size_t i = 0; i <= count; i++) {
        uint32_t const corner[3] = {i == 0 ? b->begin : found[i - 1].vertex,
                                    i == count ? b->end : found[i].vertex, b->opposite};
        size_t const place = i == 0 ? 3 * (size_t)b->triangle : r->triangles.count;
        memcpy(r->triangles.data + place, corner, sizeof corner);
        if (i > 0) r->triangles.count += 3;
        if (i > 0) note(r, TULLE_REPAIR_T_JUNCTION, get_point(r, corner[0]));
    }
    *changed += count;
    return true;
}

/* Splits boundary edges on which vertices of others lie; of a triangle one edge in a pass. */
static bool split_borders(repair *r, size_t *changed) {
    line_place *const found = memory_allocate(r->heap, (r->border_count + 1) * sizeof *found);
    uint8_t *const is_split = memory_allocate_zeroed(r->heap, r->topo.triangle_count + 1, 1);
    bool has_memory = found && is_split;
    for (uint32_t e = 0; has_memory && e < r->topo.edge_count; e++) {
        uint32_t const t = r->topo.edge_triangles[2 * (size_t)e];
        if (r->uses[e] != 1 || is_split[t]) continue;
        const uint32_t *const corner = r->topo.triangles + 3 * (size_t)t;
        size_t k = 0;
        while (r->topo.triangle_edges[3 * (size_t)t + k] != e) k++;
        border b = {.edge = e,
                    .triangle = t,
                    .begin = corner[k],
                    .end = corner[(k + 1) % 3],
                    .opposite = corner[(k + 2) % 3]};
        b.origin = get_point(r, b.begin);
        vec3 const along = vec3_sub(get_point(r, b.end), b.origin);
        b.length = vec3_norm(along);
        b.direction = vec3_scale(along, 1.0 / b.length);
        b.tolerance = fmax(r->tolerance, THIN_TRIANGLE_RATIO * b.length);
        double const first = r->positions.data[3 * (size_t)b.begin + (size_t)r->axis];
        double const last = r->positions.data[3 * (size_t)b.end + (size_t)r->axis];
        double const low = fmin(first, last) - b.tolerance, high = fmax(first, last) + b.tolerance;
        size_t from = 0, to = r->border_count, count = 0;
        while (from < to) { /* the first one at `low` or above */
            size_t const middle = from + (to - from) / 2;
            if (r->borders[middle].at < low)
                from = middle + 1;
            else
                to = middle;
        }
        for (size_t i = from; i < r->border_count && r->borders[i].at <= high; i++) {
            double at;
            if (is_hanging(r, &b, r->borders[i].vertex, &at))
                found[count++] = (line_place){at, r->borders[i].vertex};
        }
        if (count == 0) continue;
        size_t const before = *changed;
        has_memory = split_border(r, &b, found, count, changed);
        is_split[t] = *changed > before;
    }
    memory_release(r->heap, found, (r->border_count + 1) * sizeof *found);
    memory_release(r->heap, is_split, r->topo.triangle_count + 1);
    return has_memory;
}

/* Joins boundaries that meet, and drops what has no area, until nothing changes. */
static tulle_status mend_borders(repair *r) {
    for (size_t changed = 1; changed > 0;) {
        changed = 0;
        if (!close_needles(r) || !drop_triangles(r)) return TULLE_ERROR_OUT_OF_MEMORY;
        if (r->triangles.count == 0) return TULLE_OK;
        tulle_status status = begin_pass(r);
        bool has_memory = status == TULLE_OK && join_vertices(r, &changed);
        if (has_memory && changed == 0) has_memory = split_borders(r, &changed);
        end_pass(r);
        if (!has_memory) return status == TULLE_OK ? TULLE_ERROR_OUT_OF_MEMORY : status;
    }
    return TULLE_OK;
}

/* The direction from an edge into a triangle, a unit vector at right angles to it. */
static vec3 point_inwards(const repair *r, uint32_t edge, uint32_t triangle) {
    const uint32_t *const ends = r->topo.edges + 2 * (size_t)edge;
    const uint32_t *const corner = r->topo.triangles + 3 * (size_t)triangle;
    uint32_t const top = corner[0] + corner[1] + corner[2] - ends[0] - ends[1];
    vec3 const origin = get_point(r, ends[0]);
    vec3 const along = vec3_normalize(vec3_sub(get_point(r, ends[1]), origin));
    return vec3_normalize(vec3_reject(vec3_sub(get_point(r, top), origin), along));
}

/* The corner of a triangle, as 3 * triangle + k, at an end of an edge. */
static uint32_t find_corner(const repair *r, uint32_t triangle, uint32_t edge, size_t end) {
    uint32_t corner = 3 * triangle;
    while (r->topo.triangles[corner] != r->topo.edges[2 * (size_t)edge + end]) corner++;
    return corner;
}

static bool has_edge(const repair *r, uint32_t triangle, uint32_t edge) {
    const uint32_t *const edges = r->topo.triangle_edges + 3 * (size_t)triangle;
    return edges[0] == edge || edges[1] == edge || edges[2] == edge;
}

/* The triangles that stay joined at an edge: both of two, and of more the two that go on most
 * straight. */
static void choose_pair(const repair *r, uint32_t edge, uint32_t pair[2]) {
    memcpy(pair, r->topo.edge_triangles + 2 * (size_t)edge, 2 * sizeof *pair);
    if (r->uses[edge] < 3) return;
    uint32_t const vertex = r->topo.edges[2 * (size_t)edge];
    const adjacency *const lists = &r->topo.vertex_triangles;
    double least = 2.0;
    for (uint32_t i = lists->begin[vertex]; i < lists->begin[vertex + 1]; i++)
        for (uint32_t j = i + 1; j < lists->begin[vertex + 1]; j++) {
            uint32_t const one = lists->items[i], other = lists->items[j];
            if (!has_edge(r, one, edge) || !has_edge(r, other, edge)) continue;
            double const bend =
                vec3_dot(point_inwards(r, edge, one), point_inwards(r, edge, other));
            if (bend >= least) continue;
            least = bend;
            pair[0] = one;
            pair[1] = other;
        }
}

/* Joins corners of one vertex to fans, across edges. Where `is_last`, triangles that are left over
 * at an edge with three or more are joined with none there: all of them meet around its ends, so
 * nothing else parts them. */
static void join_fans(repair *r, uint32_t *fans, bool is_last) {
    uint32_t pair[2];
    union_find_reset(fans, 3 * r->topo.triangle_count);
    for (uint32_t e = 0; e < r->topo.edge_count; e++) {
        const uint32_t *const ends = r->topo.edges + 2 * (size_t)e;
        const adjacency *const lists = &r->topo.vertex_triangles;
        if (r->uses[e] < 3) continue;
        if (!is_last)
            note(r, TULLE_REPAIR_EDGE,
                 vec3_scale(vec3_add(get_point(r, ends[0]), get_point(r, ends[1])), 0.5));
        choose_pair(r, e, pair);
        for (uint32_t i = lists->begin[ends[0]]; is_last && i < lists->begin[ends[0] + 1]; i++) {
            uint32_t const t = lists->items[i];
            if (!has_edge(r, t, e) || t == pair[0] || t == pair[1]) continue;
            for (size_t end = 0; end < 2; end++) fans[find_corner(r, t, e, end)] = TULLE_NONE;
        }
    }
    for (uint32_t e = 0; e < r->topo.edge_count; e++) {
        if (r->uses[e] < 2) continue;
        choose_pair(r, e, pair);
        for (size_t end = 0; end < 2; end++) {
            uint32_t const a = find_corner(r, pair[0], e, end), b = find_corner(r, pair[1], e, end);
            if (fans[a] != TULLE_NONE && fans[b] != TULLE_NONE) union_find_join(fans, a, b);
        }
    }
    for (uint32_t c = 0; c < 3 * r->topo.triangle_count; c++)
        if (fans[c] == TULLE_NONE) fans[c] = c;
}

/* Gives a fan of the vertex, but for the largest one, a vertex of its own. `sizes`: of each fan, by
 * its root. */
static bool cut_vertex(repair *r, uint32_t *fans, const uint32_t *sizes, uint32_t v) {
    const adjacency *const lists = &r->topo.vertex_triangles;
    const adjacency *const neighbours = &r->topo.vertex_neighbours;
    uint32_t largest = TULLE_NONE;
    double shortest = INFINITY, copy_count = 0.0;
    for (uint32_t k = neighbours->begin[v]; k < neighbours->begin[v + 1]; k++)
        shortest = fmin(shortest, get_distance(r, v, neighbours->items[k]));
    for (int pass = 0; pass < 2; pass++)
        for (uint32_t k = lists->begin[v]; k < lists->begin[v + 1]; k++) {
            uint32_t corner = 3 * lists->items[k];
            while (r->topo.triangles[corner] != v) corner++;
            if (union_find_root(fans, corner) != corner) continue;
            if (pass == 0 && (largest == TULLE_NONE || sizes[corner] > sizes[largest]))
                largest = corner;
            if (pass == 0 || corner == largest) continue;
            vec3 const x = get_point(r, v);
            vec3 inwards = {0.0, 0.0, 0.0};
            if (!ARRAY_RESERVE(r->heap, &r->positions, 3) ||
                !ARRAY_RESERVE(r->heap, &r->is_joined, 1))
                return false;
            uint32_t const copy = (uint32_t)count_vertices(r);
            for (uint32_t i = lists->begin[v]; i < lists->begin[v + 1]; i++) {
                uint32_t const first = 3 * lists->items[i];
                uint32_t here = first;
                while (r->topo.triangles[here] != v) here++;
                if (union_find_root(fans, here) != corner) continue;
                vec3 const one =
                    vec3_sub(get_point(r, r->topo.triangles[first + (here - first + 1) % 3]), x);
                vec3 const two =
                    vec3_sub(get_point(r, r->topo.triangles[first + (here - first + 2) % 3]), x);
                inwards = vec3_add(
                    inwards, vec3_normalize(vec3_add(vec3_normalize(one), vec3_normalize(two))));
                r->triangles.data[here] = copy;
            }
            /* Each goes farther than the one before, or two that go the same way would meet. */
            double const shift =
                ++copy_count * fmax(SHIFT_SHARE * shortest, SHIFT_TOLERANCES * r->tolerance);
            double const length = vec3_norm(inwards);
            vec3_store(r->positions.data, copy,
                       length > 0.0 ? vec3_add_scaled(x, inwards, shift / length) : x);
            r->positions.count += 3;
            r->is_joined.data[r->is_joined.count++] = 0;
            note(r, TULLE_REPAIR_CUT, x);
        }
    return true;
}

/* Cuts the mesh so that each vertex has one fan. */
static tulle_status cut(repair *r, bool is_last) {
    tulle_status status = begin_pass(r);
    size_t const corner_count = 3 * r->topo.triangle_count, count = r->topo.vertex_count;
    uint32_t *const fans = memory_allocate(r->heap, corner_count * sizeof *fans);
    uint32_t *const sizes = memory_allocate_zeroed(r->heap, corner_count, sizeof *sizes);
    if (status == TULLE_OK && (!fans || !sizes)) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) {
        join_fans(r, fans, is_last);
        for (uint32_t c = 0; c < corner_count; c++) sizes[union_find_root(fans, c)]++;
        bool has_memory = true;
        for (uint32_t v = 0; has_memory && v < count; v++)
            has_memory = cut_vertex(r, fans, sizes, v);
        if (!has_memory) status = TULLE_ERROR_OUT_OF_MEMORY;
    }
    memory_release(r->heap, fans, corner_count * sizeof *fans);
    memory_release(r->heap, sizes, corner_count * sizeof *sizes);
    memory_release(r->heap, r->borders, count * sizeof *r->borders);
    r->borders = NULL;
    end_pass(r);
    return status;
}

/* Whether the triangle goes along the edge from its smaller to its larger vertex. */
static bool goes_along(const topology *topo, uint32_t triangle, uint32_t edge) {
    size_t k = 0;
    while (topo->triangle_edges[3 * (size_t)triangle + k] != edge) k++;
    return topo->triangles[3 * (size_t)triangle + k] == topo->edges[2 * (size_t)edge];
}

/* Turns triangles as the most of their piece, if it has two sides. */
static tulle_status turn_triangles(repair *r) {
    tulle_status status = begin_pass(r);
    size_t const count = r->topo.triangle_count;
    enum { UNSEEN, KEPT, TURNED };
    uint8_t *const marks = memory_allocate_zeroed(r->heap, count, 1);
    uint32_t *const queue = memory_allocate(r->heap, count * sizeof *queue);
    if (status == TULLE_OK && (!marks || !queue)) status = TULLE_ERROR_OUT_OF_MEMORY;
    for (uint32_t first = 0; status == TULLE_OK && first < count; first++) {
        if (marks[first] != UNSEEN) continue;
        size_t used = 0, turned_count = 0;
        bool has_two_sides = true;
        queue[used++] = first;
        marks[first] = KEPT;
        for (size_t i = 0; i < used; i++) {
            uint32_t const t = queue[i];
            turned_count += marks[t] == TURNED;
            for (size_t k = 0; k < 3; k++) {
                uint32_t const edge = r->topo.triangle_edges[3 * (size_t)t + k];
                const uint32_t *const sides = r->topo.edge_triangles + 2 * (size_t)edge;
                if (r->uses[edge] != 2) continue;
                uint32_t const other = sides[0] == t ? sides[1] : sides[0];
                bool const is_same =
                    goes_along(&r->topo, t, edge) != goes_along(&r->topo, other, edge);
                uint8_t const mark = is_same == (marks[t] == KEPT) ? KEPT : TURNED;
                has_two_sides &= marks[other] == UNSEEN || marks[other] == mark;
                if (marks[other] != UNSEEN) continue;
                marks[other] = mark;
                queue[used++] = other;
            }
        }
        uint8_t const wrong = 2 * turned_count > used ? KEPT : TURNED;
        for (size_t i = 0; i < used && has_two_sides; i++) {
            if (marks[queue[i]] != wrong) continue;
            uint32_t *const corner = r->triangles.data + 3 * (size_t)queue[i];
            uint32_t const second = corner[1];
            corner[1] = corner[2];
            corner[2] = second;
            note(r, TULLE_REPAIR_TURNED, get_point(r, corner[0]));
        }
    }
    memory_release(r->heap, marks, count);
    memory_release(r->heap, queue, count * sizeof *queue);
    end_pass(r);
    return status;
}

/* Makes a mesh of what is left, without vertices that no triangle has. */
static tulle_status finish(repair *r, tulle_mesh *made, tulle_error *error) {
    size_t const bytes = count_vertices(r) * sizeof(uint32_t);
    uint32_t *const numbers = memory_allocate(r->heap, bytes);
    if (!numbers) return TULLE_ERROR_OUT_OF_MEMORY;
    memset(numbers, 0, bytes);
    for (size_t i = 0; i < r->triangles.count; i++) numbers[r->triangles.data[i]] = 1;
    uint32_t used = 0;
    for (size_t v = 0; v < count_vertices(r); v++) {
        if (!numbers[v] && !r->is_joined.data[v]) note(r, TULLE_REPAIR_LOOSE, get_point(r, v));
        numbers[v] = numbers[v] ? used++ : TULLE_NONE;
    }
    tulle_status const status = tulle_mesh_create(used, count_triangles(r), made, error);
    for (size_t v = 0; status == TULLE_OK && v < count_vertices(r); v++)
        if (numbers[v] != TULLE_NONE) vec3_store(made->positions, numbers[v], get_point(r, v));
    for (size_t i = 0; status == TULLE_OK && i < r->triangles.count; i++)
        made->triangles[i] = numbers[r->triangles.data[i]];
    memory_release(r->heap, numbers, bytes);
    return status;
}

static tulle_status check_input(const tulle_mesh *mesh, double tolerance,
                                const tulle_mesh_repairs *repairs, tulle_error *error) {
    if (!mesh || !repairs)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "mesh and result may not be null");
    if (!(tolerance >= 0.0 && tolerance <= 1e100))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the tolerance is %g; it should be a length, 0 or more", tolerance);
    tulle_status const status = mesh_check_indices(tulle_mesh_get_view(mesh), error);
    for (size_t i = 0; status == TULLE_OK && i < 3 * mesh->vertex_count; i++)
        if (!(fabs(mesh->positions[i]) <= 1e100))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "vertex %zu has a coordinate that is not a finite number below 1e100; "
                             "this cannot be repaired",
                             i / 3);
    return status;
}

tulle_status tulle_mesh_repair(tulle_mesh *mesh, double tolerance, tulle_mesh_repairs *repairs,
                               tulle_error *error) {
    tulle_status status = check_input(mesh, tolerance, repairs, error);
    if (status != TULLE_OK) return status;
    memory heap = memory_default();
    tulle_mesh_repairs done = {{0}, {0}};
    repair r = {.heap = &heap, .tolerance = tolerance, .report = &done};
    size_t const vertices = mesh->vertex_count, corners = 3 * mesh->triangle_count;
    tulle_mesh made = {0};
    if (!ARRAY_RESERVE(&heap, &r.positions, 3 * vertices + 1) ||
        !ARRAY_RESERVE(&heap, &r.triangles, corners + 1) ||
        !ARRAY_RESERVE(&heap, &r.is_joined, vertices + 1)) {
        status = TULLE_ERROR_OUT_OF_MEMORY;
    } else {
        if (vertices > 0) memcpy(r.positions.data, mesh->positions, 3 * vertices * sizeof(double));
        if (corners > 0) memcpy(r.triangles.data, mesh->triangles, corners * sizeof(uint32_t));
        memset(r.is_joined.data, 0, vertices + 1);
        r.positions.count = 3 * vertices;
        r.triangles.count = corners;
        r.is_joined.count = vertices;
        status = mend_borders(&r);
        if (status == TULLE_OK && r.triangles.count > 0) status = cut(&r, false);
        bool const has_edges = done.counts[TULLE_REPAIR_EDGE] > 0;
        if (status == TULLE_OK && has_edges) status = cut(&r, true);
        if (status == TULLE_OK && has_edges) status = cut(&r, false); /* bow ties of that cut */
        if (status == TULLE_OK && r.triangles.count > 0) status = turn_triangles(&r);
        if (status == TULLE_OK) status = finish(&r, &made, error);
    }
    ARRAY_FREE(&heap, &r.positions);
    ARRAY_FREE(&heap, &r.triangles);
    ARRAY_FREE(&heap, &r.is_joined);
    if (status != TULLE_OK)
        return error_set(error, status,
                         "no memory to repair a mesh of %zu vertices and %zu triangles",
                         mesh->vertex_count, mesh->triangle_count);
    tulle_mesh_destroy(mesh);
    *mesh = made;
    *repairs = done;
    return TULLE_OK;
}
