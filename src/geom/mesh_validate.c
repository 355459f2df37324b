/* geom/mesh_validate.c - refuses meshes that cannot be simulated, and says where and why.
 *
 * In: a view and what it is for. Out: TULLE_OK, or an error that names the first offender of the
 * first kind of defect found, its coordinates, how many there are, and what to do. Cost O(n log n)
 * for the duplicates, O(n) for the rest. */
#include "geom/mesh.h"

#include "base/error.h"
#include "base/float_height.h"
#include "geom/union_find.h"
#include "math/vec3.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* [m] Squares and products of larger coordinates would overflow further on. */
static const double COORDINATE_MAX = 1e100;

/* Where the first offender is, and how many there are. */
typedef struct defect {
    size_t count, first;
} defect;

typedef struct place_text {
    char text[96];
} place_text;

typedef struct check {
    memory *heap;
    tulle_mesh_view mesh;
    tulle_mesh_lines lines;
    tulle_error *error;
    topology topo;
    uint32_t *edge_use_counts;
} check;

static void note_defect(defect *found, size_t index) {
    if (found->count++ == 0) found->first = index;
}

/* 0 where lines are not known. */
static uint32_t get_line(const uint32_t *lines, size_t index) { return lines ? lines[index] : 0; }

/* "7", or "7 (line 23)" where lines are known. */
static place_text show_number(const uint32_t *lines, size_t index) {
    place_text shown;
    uint32_t const line = get_line(lines, index);
    if (line > 0)
        snprintf(shown.text, sizeof shown.text, "%zu (line %u)", index, line);
    else
        snprintf(shown.text, sizeof shown.text, "%zu", index);
    return shown;
}

static place_text show_triangle(const check *c, size_t triangle) {
    return show_number(c->lines.triangles, triangle);
}

static place_text show_vertex(const check *c, size_t vertex) {
    return show_number(c->lines.vertices, vertex);
}

/* Refuses the mesh. line: of the first offender, 0 where lines are not known. */
__attribute__((format(printf, 3, 4))) static tulle_status refuse(const check *c, uint32_t line,
                                                                 const char *format, ...) {
    char text[sizeof c->error->message];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return error_set_at(c->error, TULLE_ERROR_INVALID_MESH, NULL, (int)line, 0, "%s", text);
}

/* " (x, y, z)" of a vertex. */
static place_text get_place(tulle_mesh_view mesh, size_t vertex) {
    vec3 const x = vec3_load(mesh.positions, vertex);
    place_text place;
    snprintf(place.text, sizeof place.text, "(%.9g, %.9g, %.9g)", x.x, x.y, x.z);
    return place;
}

/* " (and 4 more like it)", empty when there is one only. */
static place_text get_rest(defect found) {
    place_text rest = {""};
    if (found.count > 1)
        snprintf(rest.text, sizeof rest.text, " (and %zu more like it)", found.count - 1);
    return rest;
}

static tulle_status report_out_of_memory(tulle_error *error, tulle_mesh_view mesh) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                     "no memory to examine a mesh of %zu vertices and %zu triangles",
                     mesh.vertex_count, mesh.triangle_count);
}

static tulle_status check_coordinates(const check *c) {
    defect found = {0, 0};
    for (size_t v = 0; v < c->mesh.vertex_count; v++) {
        const double *const x = c->mesh.positions + 3 * v;
        bool const is_fine = fabs(x[0]) <= COORDINATE_MAX && fabs(x[1]) <= COORDINATE_MAX &&
                             fabs(x[2]) <= COORDINATE_MAX;
        if (!is_fine) note_defect(&found, v);
    }
    if (found.count == 0) return TULLE_OK;
    return refuse(c, get_line(c->lines.vertices, found.first),
                  "vertex %s has the coordinates %s, which are not finite numbers below %g m%s; "
                  "correct them or remove the vertex",
                  show_vertex(c, found.first).text, get_place(c->mesh, found.first).text,
                  COORDINATE_MAX, get_rest(found).text);
}

static bool has_repeated_corner(const uint32_t *corner) {
    return corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0];
}

static tulle_status check_repeated_corners(const check *c) {
    defect found = {0, 0};
    for (size_t t = 0; t < c->mesh.triangle_count; t++)
        if (has_repeated_corner(c->mesh.triangles + 3 * t)) note_defect(&found, t);
    if (found.count == 0) return TULLE_OK;
    const uint32_t *const corner = c->mesh.triangles + 3 * found.first;
    uint32_t const twice = corner[0] == corner[1] || corner[0] == corner[2] ? corner[0] : corner[1];
    return refuse(c, get_line(c->lines.triangles, found.first),
                  "triangle %s (vertices %u, %u, %u) uses vertex %s at %s twice%s; remove "
                  "degenerate triangles",
                  show_triangle(c, found.first).text, corner[0], corner[1], corner[2],
                  show_vertex(c, twice).text, get_place(c->mesh, twice).text, get_rest(found).text);
}

static tulle_status check_heights(const check *c) {
    defect found = {0, 0};
    for (size_t t = 0; t < c->mesh.triangle_count; t++) {
        double const ratio =
            triangle_get_height_ratio(c->mesh.positions, c->mesh.triangles + 3 * t);
        if (!(ratio >= THIN_TRIANGLE_RATIO)) note_defect(&found, t);
    }
    if (found.count == 0) return TULLE_OK;
    const uint32_t *const corner = c->mesh.triangles + 3 * found.first;
    double const ratio = triangle_get_height_ratio(c->mesh.positions, corner);
    return refuse(c, get_line(c->lines.triangles, found.first),
                  "triangle %s (vertices %s at %s, %s at %s, %s at %s) %s: its height is %.3g of "
                  "its longest edge, at least %g is needed%s; merge or move its vertices",
                  show_triangle(c, found.first).text, show_vertex(c, corner[0]).text,
                  get_place(c->mesh, corner[0]).text, show_vertex(c, corner[1]).text,
                  get_place(c->mesh, corner[1]).text, show_vertex(c, corner[2]).text,
                  get_place(c->mesh, corner[2]).text, ratio > 0.0 ? "is too thin" : "has zero area",
                  ratio, THIN_TRIANGLE_RATIO, get_rest(found).text);
}

/* The shortest and the longest edge of a triangle [m], and the corner at which the first begins. */
typedef struct edge_range {
    double shortest, longest;
    int first;
} edge_range;

static edge_range measure_edges(const check *c, size_t triangle) {
    const uint32_t *const corner = c->mesh.triangles + 3 * triangle;
    edge_range range = {.shortest = (double)INFINITY};
    for (int k = 0; k < 3; k++) {
        vec3 const a = vec3_load(c->mesh.positions, corner[k]);
        double const length =
            vec3_norm(vec3_sub(vec3_load(c->mesh.positions, corner[(k + 1) % 3]), a));
        if (length < range.shortest) range.shortest = length, range.first = k;
        range.longest = fmax(range.longest, length);
    }
    return range;
}

/* Cloth is stored as floats, which hold no edges and heights below some size. Where it lies is
 * judged at the start of a world: here it is taken to lie about the origin, as well as it can. */
static tulle_status check_float_heights(const check *c) {
    double extent = 0.0, height = 0.0;
    defect found = {0, 0};
    for (size_t axis = 0; axis < 3; axis++) {
        double low = (double)INFINITY, high = -(double)INFINITY;
        for (size_t v = 0; v < c->mesh.vertex_count; v++) {
            low = fmin(low, c->mesh.positions[3 * v + axis]);
            high = fmax(high, c->mesh.positions[3 * v + axis]);
        }
        extent = fmax(extent, 0.5 * (high - low));
    }
    for (size_t t = 0; t < c->mesh.triangle_count; t++) {
        double const own = measure_edges(c, t).longest *
                           triangle_get_height_ratio(c->mesh.positions, c->mesh.triangles + 3 * t);
        if (!(own < LEAST_HEIGHT * extent)) continue;
        note_defect(&found, t);
        if (found.count == 1) height = own;
    }
    if (found.count == 0) return TULLE_OK;
    edge_range const edges = measure_edges(c, found.first);
    const uint32_t *const corner = c->mesh.triangles + 3 * found.first;
    uint32_t const ends[2] = {corner[edges.first], corner[(edges.first + 1) % 3]};
    return refuse(c, get_line(c->lines.triangles, found.first),
                  "triangle %s is %.3g m high over its longest edge%s; its shortest edge, from "
                  "vertex %s at %s to %s at %s, is %.3g m long. Floats in files hold no cloth "
                  "lower than %.3g m in a mesh that reaches %.3g m from its middle: merge vertices "
                  "so near, or move them away from the edge that they are so near to",
                  show_triangle(c, found.first).text, height, get_rest(found).text,
                  show_vertex(c, ends[0]).text, get_place(c->mesh, ends[0]).text,
                  show_vertex(c, ends[1]).text, get_place(c->mesh, ends[1]).text, edges.shortest,
                  LEAST_HEIGHT * extent, extent);
}

static tulle_status check_duplicates(const check *c) {
    size_t const count = c->mesh.triangle_count;
    uint32_t *const originals = memory_allocate(c->heap, count * sizeof *originals);
    size_t duplicate_count = 0;
    if (!originals || !mesh_find_duplicates(c->heap, c->mesh, originals, &duplicate_count)) {
        memory_release(c->heap, originals, count * sizeof *originals);
        return report_out_of_memory(c->error, c->mesh);
    }
    uint32_t first = 0;
    while (first < count && originals[first] == TULLE_NONE) first++;
    uint32_t const original = duplicate_count > 0 ? originals[first] : TULLE_NONE;
    memory_release(c->heap, originals, count * sizeof *originals);
    if (duplicate_count == 0) return TULLE_OK;
    uint32_t const vertex = c->mesh.triangles[3 * (size_t)first];
    return refuse(c, get_line(c->lines.triangles, first),
                  "triangle %s has the same three vertices as triangle %s (first vertex %s at "
                  "%s)%s; remove duplicate triangles",
                  show_triangle(c, first).text, show_triangle(c, original).text,
                  show_vertex(c, vertex).text, get_place(c->mesh, vertex).text,
                  get_rest((defect){duplicate_count, first}).text);
}

static tulle_status check_edge_uses(const check *c) {
    defect found = {0, 0};
    for (size_t e = 0; e < c->topo.edge_count; e++)
        if (c->edge_use_counts[e] > 2) note_defect(&found, e);
    if (found.count == 0) return TULLE_OK;
    const uint32_t *const ends = c->topo.edges + 2 * found.first;
    uint32_t const side = c->topo.edge_triangles[2 * found.first];
    return refuse(
        c, get_line(c->lines.triangles, side),
        "the edge between vertices %s at %s and %s at %s belongs to %u triangles, number %s among "
        "them%s; cloth needs at most 2 (non-manifold edge): separate the sheets there",
        show_vertex(c, ends[0]).text, get_place(c->mesh, ends[0]).text,
        show_vertex(c, ends[1]).text, get_place(c->mesh, ends[1]).text,
        c->edge_use_counts[found.first], show_triangle(c, side).text, get_rest(found).text);
}

/* Whether the triangle goes along the edge from its smaller to its larger vertex. */
static bool is_along_edge(const topology *topo, uint32_t triangle, size_t edge) {
    for (size_t k = 0; k < 3; k++)
        if (topo->triangle_edges[3 * (size_t)triangle + k] == edge)
            return topo->triangles[3 * (size_t)triangle + k] == topo->edges[2 * edge];
    return false;
}

static tulle_status check_orientation(const check *c) {
    defect found = {0, 0};
    for (size_t e = 0; e < c->topo.edge_count; e++) {
        if (c->edge_use_counts[e] != 2) continue;
        const uint32_t *const sides = c->topo.edge_triangles + 2 * e;
        if (is_along_edge(&c->topo, sides[0], e) == is_along_edge(&c->topo, sides[1], e))
            note_defect(&found, e);
    }
    if (found.count == 0) return TULLE_OK;
    const uint32_t *const sides = c->topo.edge_triangles + 2 * found.first;
    const uint32_t *const ends = c->topo.edges + 2 * found.first;
    return refuse(c, get_line(c->lines.triangles, sides[0]),
                  "triangles %s and %s, which share the edge between vertices %u at %s and %u at "
                  "%s, are oriented in opposite ways%s; flip triangles until all normals point to "
                  "one side (a one-sided surface cannot be cloth)",
                  show_triangle(c, sides[0]).text, show_triangle(c, sides[1]).text, ends[0],
                  get_place(c->mesh, ends[0]).text, ends[1], get_place(c->mesh, ends[1]).text,
                  get_rest(found).text);
}

/* How many fans the triangles of a vertex form. */
static size_t count_fans(const topology *topo, uint32_t *fans, uint32_t vertex) {
    const adjacency *const lists = &topo->vertex_triangles;
    size_t fan_count = 0;
    for (uint32_t k = lists->begin[vertex]; k < lists->begin[vertex + 1]; k++) {
        uint32_t corner = 3 * lists->items[k];
        while (topo->triangles[corner] != vertex) corner++;
        if (union_find_root(fans, corner) == corner) fan_count++;
    }
    return fan_count;
}

static tulle_status check_fans(const check *c) {
    size_t const corner_count = 3 * c->mesh.triangle_count;
    uint32_t *const fans = memory_allocate(c->heap, corner_count * sizeof *fans);
    if (!fans) return report_out_of_memory(c->error, c->mesh);
    mesh_join_fans(&c->topo, c->edge_use_counts, fans);
    defect found = {0, 0};
    size_t first_fan_count = 0;
    for (uint32_t v = 0; v < c->mesh.vertex_count; v++) {
        size_t const fan_count = count_fans(&c->topo, fans, v);
        if (fan_count < 2) continue;
        if (found.count == 0) first_fan_count = fan_count;
        note_defect(&found, v);
    }
    memory_release(c->heap, fans, corner_count * sizeof *fans);
    if (found.count == 0) return TULLE_OK;
    return refuse(c, get_line(c->lines.vertices, found.first),
                  "vertex %s at %s joins %zu separate fans of triangles that share no edge%s (bow "
                  "tie); give each fan a vertex of its own",
                  show_vertex(c, found.first).text, get_place(c->mesh, found.first).text,
                  first_fan_count, get_rest(found).text);
}

static tulle_status check_unreferenced(const check *c) {
    const uint32_t *const begin = c->topo.vertex_triangles.begin;
    defect found = {0, 0};
    for (size_t v = 0; v < c->mesh.vertex_count; v++)
        if (begin[v] == begin[v + 1]) note_defect(&found, v);
    if (found.count == 0) return TULLE_OK;
    return refuse(c, get_line(c->lines.vertices, found.first),
                  "vertex %s at %s belongs to no triangle%s; remove unreferenced vertices",
                  show_vertex(c, found.first).text, get_place(c->mesh, found.first).text,
                  get_rest(found).text);
}

/* What cloth needs beyond sound triangles: an oriented 2-manifold. */
static tulle_status check_manifold(check *c) {
    tulle_status status = topology_build(c->heap, c->mesh.triangles, c->mesh.triangle_count,
                                         c->mesh.vertex_count, &c->topo);
    if (status == TULLE_ERROR_LIMIT)
        return error_set(c->error, status, "the mesh has %zu triangles, too many for cloth",
                         c->mesh.triangle_count);
    if (status != TULLE_OK) return report_out_of_memory(c->error, c->mesh);
    size_t const byte_count = c->topo.edge_count * sizeof *c->edge_use_counts;
    c->edge_use_counts = memory_allocate(c->heap, byte_count);
    if (c->edge_use_counts) {
        topology_count_edge_uses(&c->topo, c->edge_use_counts);
        status = check_edge_uses(c);
        if (status == TULLE_OK) status = check_orientation(c);
        if (status == TULLE_OK) status = check_fans(c);
        if (status == TULLE_OK) status = check_unreferenced(c);
        memory_release(c->heap, c->edge_use_counts, byte_count);
    } else {
        status = report_out_of_memory(c->error, c->mesh);
    }
    topology_destroy(c->heap, &c->topo);
    return status;
}

tulle_status mesh_validate(memory *heap, tulle_mesh_view mesh, tulle_mesh_role role,
                           tulle_mesh_lines lines, tulle_error *error) {
    check c = {.heap = heap, .mesh = mesh, .lines = lines, .error = error};
    if ((int)role < TULLE_MESH_ROLE_CLOTH || (int)role > TULLE_MESH_ROLE_DEFORMING)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "role %d is not a value of tulle_mesh_role", (int)role);
    if (mesh.triangle_count == 0)
        return error_set(error, TULLE_ERROR_INVALID_MESH,
                         "the mesh has no triangles (%zu vertices); at least one is needed",
                         mesh.vertex_count);
    tulle_status status = mesh_check_indices(mesh, error);
    if (status == TULLE_OK) status = check_coordinates(&c);
    if (status == TULLE_OK) status = check_repeated_corners(&c);
    if (status == TULLE_OK && role != TULLE_MESH_ROLE_DEFORMING) status = check_heights(&c);
    if (status == TULLE_OK) status = check_duplicates(&c);
    if (status == TULLE_OK && role == TULLE_MESH_ROLE_CLOTH) status = check_float_heights(&c);
    if (status == TULLE_OK && role == TULLE_MESH_ROLE_CLOTH) status = check_manifold(&c);
    return status;
}

tulle_status tulle_mesh_validate(tulle_mesh_view mesh, tulle_mesh_role role, tulle_error *error) {
    return tulle_mesh_validate_lines(mesh, role, (tulle_mesh_lines){0}, error);
}

tulle_status tulle_mesh_validate_lines(tulle_mesh_view mesh, tulle_mesh_role role,
                                       tulle_mesh_lines lines, tulle_error *error) {
    memory heap = memory_default();
    return mesh_validate(&heap, mesh, role, lines, error);
}
