/* subdivision/loop_subdivision_rules.c - what is sharp in a base mesh, and which rule that gives
 * every vertex and every end of an edge.
 *
 * In: any triangles with three different corners each, positions for the angles. Out: level 0. A
 * corner here is 3 * triangle + k; a sector is the fan of corners of one vertex between two sharp
 * edges, walked counterclockwise. Smooth edges have two triangles of one orientation, so every open
 * sector has one first corner, and a corner that no open sector holds is in a closed fan.
 *
 * Based on: Hoppe, DeRose, Duchamp, Halstead, Jin, McDonald, Schweitzer, Stuetzle, Piecewise smooth
 * surface reconstruction, 1994 (creases, darts, corners); Biermann, Levin, Zorin, Piecewise smooth
 * subdivision surfaces with normal control, 2000, section 3 (the weights of sectors, flatness of
 * concave corners).
 * Departure: corners of a border are found by how far it turns. */
#include "subdivision/loop_subdivision.h"

#include "base/error.h"
#include "math/vec3.h"

#include "tulle_io/subdivision.h"

static const double PI = 3.14159265358979323846;
/* [rad] The weights of a corner's sector divide by the sine of its angle; angles nearer than this
 * to 0, 180 or 360 degrees are taken as this far from them. */
static const double CORNER_MARGIN = 0.5235987755982988; /* 30 degrees */
/* Largest factor by which a concave corner's sector keeps anything but its plane from one level to
 * the next, where the plane itself shrinks by 1/2: 3/8 flattens as fast as a regular border does.
 */
static const double CONCAVE_EIGENVALUE = 0.375;

typedef struct rule_maker {
    memory *heap;
    const topology *topo;
    const double *positions;
    const tulle_subdivision_def *def;
    subdivision_level *level;
    spoke_rule_table *rules;
    uint32_t *sharp_degrees;  /* vertex_count: sharp edges */
    uint32_t *sector_counts;  /* vertex_count: open sectors */
    uint32_t *sector_corners; /* vertex_count: corners in open sectors */
} rule_maker;

/* One open sector. */
typedef struct sector {
    uint32_t first, last; /* corners */
    uint32_t triangle_count;
    double angle; /* [rad] sum of its corners' angles */
} sector;

static uint32_t get_next(uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
static uint32_t get_prev(uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

/* The edges that bound a corner, in counterclockwise order. */
static uint32_t get_first_edge(const rule_maker *m, uint32_t corner) {
    return m->topo->triangle_edges[corner];
}
static uint32_t get_last_edge(const rule_maker *m, uint32_t corner) {
    return m->topo->triangle_edges[get_prev(corner)];
}

/* The corner after it around its vertex, across its last edge, which is smooth. */
static uint32_t step_around(const rule_maker *m, uint32_t corner) {
    const uint32_t *const sides = m->topo->edge_triangles + 2 * (size_t)get_last_edge(m, corner);
    uint32_t next = 3 * (sides[0] == corner / 3 ? sides[1] : sides[0]);
    while (m->topo->triangles[next] != m->topo->triangles[corner]) next++;
    return next;
}

static uint32_t get_end(const rule_maker *m, uint32_t edge, uint32_t vertex) {
    return m->topo->edges[2 * (size_t)edge] != vertex;
}

static double measure_angle(vec3 u, vec3 v) {
    return atan2(vec3_norm(vec3_cross(u, v)), vec3_dot(u, v));
}

static vec3 get_normal(const rule_maker *m, uint32_t triangle) {
    const uint32_t *const corners = m->topo->triangles + 3 * (size_t)triangle;
    vec3 const a = vec3_load(m->positions, corners[0]);
    return vec3_cross(vec3_sub(vec3_load(m->positions, corners[1]), a),
                      vec3_sub(vec3_load(m->positions, corners[2]), a));
}

/* Whether the triangle runs along the edge from its end 0 to its end 1. */
static bool runs_forward(const rule_maker *m, uint32_t triangle, uint32_t edge) {
    uint32_t corner = 3 * triangle;
    while (m->topo->triangle_edges[corner] != edge) corner++;
    return m->topo->triangles[corner] == m->topo->edges[2 * (size_t)edge];
}

static bool is_edge_sharp(const rule_maker *m, uint32_t edge, uint32_t use_count) {
    const uint32_t *const sides = m->topo->edge_triangles + 2 * (size_t)edge;
    if (use_count != 2) return true;
    if (runs_forward(m, sides[0], edge) == runs_forward(m, sides[1], edge)) return true;
    return measure_angle(get_normal(m, sides[0]), get_normal(m, sides[1])) > m->def->crease_angle;
}

static tulle_status mark_given_edges(rule_maker *m, tulle_error *error) {
    for (size_t i = 0; i < m->def->crease_edge_count; i++) {
        uint32_t const a = m->def->crease_edges[2 * i], b = m->def->crease_edges[2 * i + 1];
        const adjacency *const lists = &m->topo->vertex_edges;
        uint32_t at = 0, end = 0;
        if (a < m->topo->vertex_count && b < m->topo->vertex_count && a != b) {
            at = lists->begin[a];
            end = lists->begin[a + 1];
        }
        while (at < end && m->topo->edges[2 * (size_t)lists->items[at]] != b &&
               m->topo->edges[2 * (size_t)lists->items[at] + 1] != b)
            at++;
        if (at == end)
            return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                             "crease edge %zu (counted from 0) joins vertices %lu and %lu, but no "
                             "triangle has that edge; name edges of the mesh",
                             i, (unsigned long)a, (unsigned long)b);
        m->level->edge_is_sharp[lists->items[at]] = 1;
    }
    return TULLE_OK;
}

static tulle_status mark_sharp_edges(rule_maker *m, tulle_error *error) {
    size_t const edge_count = m->topo->edge_count;
    uint32_t *const use_counts = memory_allocate(m->heap, edge_count * sizeof *use_counts);
    if (!use_counts) return TULLE_ERROR_OUT_OF_MEMORY;
    topology_count_edge_uses(m->topo, use_counts);
    for (uint32_t e = 0; e < edge_count; e++)
        m->level->edge_is_sharp[e] = is_edge_sharp(m, e, use_counts[e]);
    memory_release(m->heap, use_counts, edge_count * sizeof *use_counts);
    tulle_status const status = mark_given_edges(m, error);
    for (size_t e = 0; e < edge_count; e++) {
        m->sharp_degrees[m->topo->edges[2 * e]] += m->level->edge_is_sharp[e];
        m->sharp_degrees[m->topo->edges[2 * e + 1]] += m->level->edge_is_sharp[e];
    }
    return status;
}

/* Whether an open sector begins with this corner; then the sector. */
static bool find_sector(const rule_maker *m, uint32_t corner, sector *found) {
    if (!m->level->edge_is_sharp[get_first_edge(m, corner)]) return false;
    *found = (sector){.first = corner};
    for (uint32_t at = corner;; at = step_around(m, at)) {
        vec3 const x = vec3_load(m->positions, m->topo->triangles[at]);
        vec3 const y = vec3_load(m->positions, m->topo->triangles[get_next(at)]);
        vec3 const z = vec3_load(m->positions, m->topo->triangles[get_prev(at)]);
        found->angle += measure_angle(vec3_sub(y, x), vec3_sub(z, x));
        found->triangle_count++;
        found->last = at;
        if (m->level->edge_is_sharp[get_last_edge(m, at)]) return true;
    }
}

/* Whether the two sharp edges of a vertex turn there by more than the def's corner angle. */
static bool is_corner_by_angle(const rule_maker *m, uint32_t vertex) {
    const adjacency *const lists = &m->topo->vertex_edges;
    vec3 const x = vec3_load(m->positions, vertex);
    vec3 sides[2] = {{0}};
    size_t count = 0;
    for (uint32_t i = lists->begin[vertex]; i < lists->begin[vertex + 1] && count < 2; i++) {
        uint32_t const edge = lists->items[i];
        if (!m->level->edge_is_sharp[edge]) continue;
        uint32_t const end = get_end(m, edge, vertex);
        sides[count++] = vec3_sub(vec3_load(m->positions, m->topo->edges[2 * edge + 1 - end]), x);
    }
    return measure_angle(vec3_neg(sides[0]), sides[1]) > m->def->corner_angle;
}

/* Whether the triangles of a vertex without sharp edges form one fan. */
static bool is_one_closed_fan(const rule_maker *m, uint32_t vertex) {
    const adjacency *const lists = &m->topo->vertex_triangles;
    uint32_t const first = lists->begin[vertex], count = lists->begin[vertex + 1] - first;
    uint32_t begin = 3 * lists->items[first], walked = 0;
    while (m->topo->triangles[begin] != vertex) begin++;
    uint32_t at = begin;
    do {
        at = step_around(m, at);
        walked++;
    } while (at != begin);
    return walked == count;
}

static vertex_rule decide_vertex(const rule_maker *m, uint32_t v) {
    const uint32_t *const begin = m->topo->vertex_triangles.begin;
    uint32_t const count = begin[v + 1] - begin[v];
    if (count == 0) return VERTEX_FIXED;
    if (m->sharp_degrees[v] == 0) return is_one_closed_fan(m, v) ? VERTEX_SMOOTH : VERTEX_FIXED;
    if (m->sector_corners[v] < count) return VERTEX_FIXED; /* a closed fan meets others here */
    if (m->sharp_degrees[v] == 1) return m->sector_counts[v] == 1 ? VERTEX_DART : VERTEX_FIXED;
    if (m->sharp_degrees[v] == 2) return is_corner_by_angle(m, v) ? VERTEX_FIXED : VERTEX_CREASE;
    return VERTEX_FIXED;
}

/* far_weight 1/2 - cos(theta) / 4 gives the sector's plane the eigenvalue 1/2, as the curves that
 * bound it have; theta is the share of one triangle of 180 degrees, at a corner of its angle. */
static spoke_rule make_crease_rule(const sector *of) {
    return (spoke_rule){.far_weight = 0.5 - 0.25 * cos(PI / of->triangle_count),
                        .dart_position = TULLE_NONE};
}

static double clamp_corner_angle(double angle) {
    if (!(angle > PI)) return fmin(fmax(angle, CORNER_MARGIN), PI - CORNER_MARGIN);
    return fmin(fmax(angle, PI + CORNER_MARGIN), 2.0 * PI - CORNER_MARGIN);
}

/* The rule of the edge that lies `position` triangles after the sector's first edge. */
static spoke_rule make_corner_rule(const rule_maker *m, const sector *of, uint32_t position) {
    uint32_t const count = of->triangle_count, vertex = m->topo->triangles[of->first];
    double const angle = clamp_corner_angle(of->angle), share = angle / count;
    spoke_rule rule = {.far_weight = 0.5 - 0.25 * cos(share), .dart_position = TULLE_NONE};
    if (angle < PI) return rule;
    double const largest = rule.far_weight + 0.25 * cos(PI / count);
    if (largest <= CONCAVE_EIGENVALUE) return rule;
    rule.flatness = 1.0 - CONCAVE_EIGENVALUE / largest;
    rule.side_weights[0] = sin((count - position) * share) / sin(angle);
    rule.side_weights[1] = sin(position * share) / sin(angle);
    rule.side_edges[0] = get_first_edge(m, of->first);
    rule.side_edges[1] = get_last_edge(m, of->last);
    for (int side = 0; side < 2; side++)
        rule.side_ends[side] = get_end(m, rule.side_edges[side], vertex);
    return rule;
}

static bool append_rule(rule_maker *m, spoke_rule rule) {
    if (!ARRAY_RESERVE(m->heap, m->rules, 1)) return false;
    m->rules->data[m->rules->count++] = rule;
    return true;
}

/* Appends the rule and gives it to the edge's end at the vertex. */
static bool add_rule(rule_maker *m, uint32_t edge, uint32_t vertex, spoke_rule rule) {
    m->level->spoke_rules[2 * (size_t)edge + get_end(m, edge, vertex)] = (uint32_t)m->rules->count;
    return append_rule(m, rule);
}

/* Rules for the edges of one sector; a border of regular triangles needs none. */
static bool add_sector_rules(rule_maker *m, const sector *of) {
    uint32_t const vertex = m->topo->triangles[of->first];
    vertex_rule const kind = m->level->vertex_rules[vertex];
    if (kind == VERTEX_DART) {
        spoke_rule const rule = {.far_weight = 0.375, .dart_position = 0};
        if (!add_rule(m, get_first_edge(m, of->first), vertex, rule)) return false;
    }
    if (kind == VERTEX_CREASE && of->triangle_count == 3) return true;
    uint32_t corner = of->first;
    for (uint32_t position = 1; position < of->triangle_count; position++) {
        spoke_rule rule = {.far_weight = 0.375, .dart_position = position};
        if (kind == VERTEX_CREASE) rule = make_crease_rule(of);
        if (kind == VERTEX_FIXED) rule = make_corner_rule(m, of, position);
        if (!add_rule(m, get_last_edge(m, corner), vertex, rule)) return false;
        corner = step_around(m, corner);
    }
    return true;
}

static tulle_status make_rules(rule_maker *m, tulle_error *error) {
    size_t const corner_count = 3 * m->topo->triangle_count;
    sector found;
    tulle_status const status = mark_sharp_edges(m, error);
    if (status != TULLE_OK) return status;
    for (uint32_t corner = 0; corner < corner_count; corner++) {
        if (!find_sector(m, corner, &found)) continue;
        m->sector_counts[m->topo->triangles[corner]]++;
        m->sector_corners[m->topo->triangles[corner]] += found.triangle_count;
    }
    for (uint32_t v = 0; v < m->topo->vertex_count; v++)
        m->level->vertex_rules[v] = (uint8_t)decide_vertex(m, v);
    if (!append_rule(m, (spoke_rule){.far_weight = 0.375, .dart_position = TULLE_NONE}))
        return TULLE_ERROR_OUT_OF_MEMORY;
    for (uint32_t corner = 0; corner < corner_count; corner++)
        if (find_sector(m, corner, &found) && !add_sector_rules(m, &found))
            return TULLE_ERROR_OUT_OF_MEMORY;
    return TULLE_OK;
}

static void copy_topology(const topology *topo, subdivision_level *level) {
    for (size_t i = 0; i < 3 * topo->triangle_count; i++) {
        level->triangles[i] = topo->triangles[i];
        level->triangle_edges[i] = topo->triangle_edges[i];
    }
    for (size_t i = 0; i < 2 * topo->edge_count; i++) {
        level->edges[i] = topo->edges[i];
        level->edge_opposites[i] = topo->edge_opposites[i];
        level->spoke_rules[i] = 0;
    }
}

static tulle_status begin_level(rule_maker *m, tulle_error *error) {
    size_t const vertex_count = m->topo->vertex_count, bytes = vertex_count * sizeof(uint32_t);
    if (!subdivision_level_create(m->heap, vertex_count, m->topo->edge_count,
                                  m->topo->triangle_count, m->level))
        return TULLE_ERROR_OUT_OF_MEMORY;
    copy_topology(m->topo, m->level);
    m->sharp_degrees = memory_allocate_zeroed(m->heap, vertex_count, sizeof(uint32_t));
    m->sector_counts = memory_allocate_zeroed(m->heap, vertex_count, sizeof(uint32_t));
    m->sector_corners = memory_allocate_zeroed(m->heap, vertex_count, sizeof(uint32_t));
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (m->sharp_degrees && m->sector_counts && m->sector_corners) status = make_rules(m, error);
    memory_release(m->heap, m->sharp_degrees, bytes);
    memory_release(m->heap, m->sector_counts, bytes);
    memory_release(m->heap, m->sector_corners, bytes);
    if (status != TULLE_OK) subdivision_level_destroy(m->heap, m->level);
    return status;
}

tulle_status subdivision_level_begin(memory *heap, tulle_mesh_view mesh,
                                     const tulle_subdivision_def *def, subdivision_level *level,
                                     spoke_rule_table *rules, tulle_error *error) {
    topology topo;
    *level = (subdivision_level){0};
    tulle_status status =
        topology_build(heap, mesh.triangles, mesh.triangle_count, mesh.vertex_count, &topo);
    if (status != TULLE_OK) return status;
    rule_maker maker = {.heap = heap,
                        .topo = &topo,
                        .positions = mesh.positions,
                        .def = def,
                        .level = level,
                        .rules = rules};
    status = begin_level(&maker, error);
    topology_destroy(heap, &topo);
    return status;
}
