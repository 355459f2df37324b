/* support/open_surfaces.c - see open_surfaces.h.
 *
 * Each is a grid of columns and rows, some cells left out, its first and last column joined along
 * some rows, and a shape: a function of u (columns) and v (rows) in [0, 1], one for each end of the
 * motion. */
#include "support/open_surfaces.h"
#include "base/hash.h"
#include "math/vec3.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const double TURN = 6.283185307179586; /* [rad] */

enum { GRID_SIDE = 96, GRID_CELLS = 2048 };

const char *const family_names[FAMILY_COUNT] = {"ramp", "C-ring", "twist",   "annulus", "slit",
                                                "fold", "comb",   "terrain", "fan"};

/* What the functions of the families read; each its own part. */
typedef struct surface_shape {
    surface_family family;
    double turns, width, pitch, sway, twist, wave_count, wave_height;
    double drift[12];
} surface_shape;

typedef struct surface_grid {
    int columns, rows; /* of cells */
    bool is_kept[GRID_CELLS];
    int joined_from, joined_to; /* rows of vertices where the last column is the first */
    bool has_centre;            /* all vertices of row 0 are one */
} surface_grid;

static double random_between(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

static int random_below(uint64_t *seed, int count) {
    return (int)(random_next(seed) % (uint64_t)count);
}

static vec3 random_in_box(uint64_t *seed, double size) {
    double const x = random_between(seed, -size, size), y = random_between(seed, -size, size);
    return vec3_make(x, y, random_between(seed, -size, size));
}

/* ---- shapes ---- */

static vec3 find_on_ring(double angle, double radius, double height) {
    return vec3_make(radius * cos(angle), radius * sin(angle), height);
}

static vec3 find_on_coil(const surface_shape *shape, double u, double v) {
    double const around = shape->turns, phase = TURN * u;
    double const lean = shape->twist * phase + shape->drift[0];
    double const off = shape->width * (v - 0.5);
    double const radius = 1.0 + 0.35 * cos(phase) + off * cos(lean);
    return find_on_ring(TURN * around * u, radius, shape->pitch * sin(phase) + off * sin(lean));
}

/* A meander: the direction of its middle line swings by `sway`. */
static vec3 find_on_meander(const surface_shape *shape, double u, double v) {
    enum { STEPS = 200 };
    double x = 0.0, y = 0.0, direction = shape->sway;
    for (int i = 0; i < STEPS; i++) {
        double const s = u * ((double)i + 0.5) / (double)STEPS;
        direction = shape->sway * sin(TURN * shape->turns * s);
        x += cos(direction) * u / (double)STEPS;
        y += sin(direction) * u / (double)STEPS;
    }
    direction = shape->sway * sin(TURN * shape->turns * u);
    double const off = shape->width * (v - 0.5);
    double const wave = shape->wave_height * sin(TURN * shape->wave_count * u);
    return vec3_make(x - off * sin(direction), y + off * cos(direction),
                     wave + shape->pitch * (u - 0.5));
}

static vec3 find_on_slit_disc(const surface_shape *shape, double u, double v) {
    double const side = 2.0 * u - 1.0;
    bool const is_inner = shape->drift[1] > 0.0; /* the slit runs from the inner rim outwards */
    double const open = is_inner ? fmax(1.0 - 1.4 * v, 0.0) : fmax(1.4 * v - 0.4, 0.0);
    double const near = side * side * side * open; /* most of it near the slit */
    return find_on_ring(TURN * u + shape->sway * near, 0.3 + 0.7 * v, shape->pitch * near);
}

static vec3 find_on_comb(const surface_shape *shape, double u, double v) {
    double const tooth = floor(u * shape->turns * 0.999999);
    double const sign = fmod(tooth, 2.0) == 0.0 ? 1.0 : -1.0, tip = fmax(v - 0.2, 0.0);
    return vec3_make(u + sign * shape->sway * tip * tip, v, sign * shape->pitch * tip);
}

static vec3 find_on_terrain(const surface_shape *shape, double u, double v) {
    const double *const d = shape->drift;
    double const x = u + d[0] * sin(TURN * (u * d[1] + v * d[2] + d[3]));
    double const y = v + d[4] * sin(TURN * (u * d[5] + v * d[6] + d[7]));
    return vec3_make(x, y, shape->pitch * sin(TURN * (u * d[8] + v * d[9])) * cos(3.0 * v + d[10]));
}

static vec3 find_on_shape(const surface_shape *shape, double u, double v) {
    switch (shape->family) {
    case FAMILY_RAMP:
    case FAMILY_C_RING:
        return find_on_ring(TURN * shape->turns * u, 1.0 + shape->width * (v - 0.5),
                            shape->pitch * u);
    case FAMILY_TWIST:
    case FAMILY_ANNULUS: return find_on_coil(shape, u, v);
    case FAMILY_SLIT: return find_on_slit_disc(shape, u, v);
    case FAMILY_FOLD: return find_on_meander(shape, u, v);
    case FAMILY_COMB: return find_on_comb(shape, u, v);
    case FAMILY_TERRAIN: return find_on_terrain(shape, u, v);
    case FAMILY_FAN:
    case FAMILY_COUNT: break;
    }
    return find_on_ring(TURN * shape->turns * u, v, shape->pitch * v * (u - 0.5));
}

/* ---- a grid and both shapes of each family ---- */

static void keep_cells(surface_grid *grid, int columns, int rows) {
    *grid = (surface_grid){.columns = columns, .rows = rows, .joined_from = 1};
    for (int i = 0; i < columns * rows; i++) grid->is_kept[i] = true;
}

static void join_ends(surface_grid *grid, int from, int to) {
    grid->joined_from = from;
    grid->joined_to = to;
}

/* A connected ragged piece: cells join at random sides of cells that are in. */
static void keep_ragged_piece(surface_grid *grid, uint64_t *seed) {
    int const columns = grid->columns, rows = grid->rows, count = columns * rows;
    memset(grid->is_kept, 0, sizeof grid->is_kept);
    grid->is_kept[random_below(seed, count)] = true;
    int kept = 1;
    int const wanted = 4 + random_below(seed, count * 2 / 3);
    for (int tries = 0; tries < 100 * count && kept < wanted; tries++) {
        int const at = random_below(seed, count);
        if (!grid->is_kept[at]) continue;
        static const int steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        int const side = random_below(seed, 4);
        int const column = at % columns + steps[side][0], row = at / columns + steps[side][1];
        if (column < 0 || column >= columns || row < 0 || row >= rows) continue;
        if (!grid->is_kept[row * columns + column]) kept++;
        grid->is_kept[row * columns + column] = true;
    }
}

static void choose_ring(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    bool const is_ramp = shapes[0].family == FAMILY_RAMP;
    keep_cells(grid, 16 + random_below(seed, 24), 1 + random_below(seed, 3));
    shapes[0].turns = is_ramp ? random_between(seed, 1.05, 1.9) : random_between(seed, 0.8, 0.97);
    shapes[0].width = random_between(seed, 0.1, 0.8);
    shapes[0].pitch = is_ramp ? random_between(seed, 0.05, 0.6) : random_between(seed, -0.1, 0.1);
    shapes[1] = shapes[0];
    shapes[1].pitch *= -random_between(seed, 0.5, 1.5);
    if (is_ramp)
        shapes[1].turns += random_between(seed, -0.05, 0.05);
    else
        shapes[1].turns = random_between(seed, 1.0, 1.15);
}

static void choose_coil(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    bool const is_twist = shapes[0].family == FAMILY_TWIST;
    keep_cells(grid, is_twist ? 60 + random_below(seed, 20) : 36 + random_below(seed, 24),
               1 + random_below(seed, 2));
    join_ends(grid, 0, grid->rows);
    shapes[0].turns = is_twist ? 3.0 : 2.0;
    shapes[0].twist = is_twist ? 1.0 : 0.0;
    shapes[0].width = random_between(seed, 0.1, 0.25);
    shapes[0].pitch = random_between(seed, 0.1, 0.4);
    shapes[0].drift[0] = is_twist ? random_between(seed, 0.0, TURN) : random_between(seed, -1, 1);
    shapes[1] = shapes[0];
    shapes[1].pitch *= -random_between(seed, 0.5, 1.5);
    shapes[1].drift[0] += random_between(seed, -0.3, 0.3);
}

static void choose_slit(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    keep_cells(grid, 14 + random_below(seed, 10), 3 + random_below(seed, 4));
    bool const is_inner = random_below(seed, 2) == 0;
    int const middle = 1 + random_below(seed, grid->rows - 1);
    if (is_inner)
        join_ends(grid, middle, grid->rows);
    else
        join_ends(grid, 0, middle);
    shapes[0].drift[1] = is_inner ? 1.0 : -1.0;
    shapes[0].sway = random_between(seed, -0.2, 0.4);
    shapes[0].pitch = random_between(seed, 0.01, 0.4);
    shapes[1] = shapes[0];
    shapes[1].sway = random_between(seed, 0.0, 0.4);
    shapes[1].pitch *= -random_between(seed, 0.2, 1.5);
}

static void choose_fold(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    keep_cells(grid, 40 + random_below(seed, 50), 1 + random_below(seed, 2));
    shapes[0].turns = random_between(seed, 1.0, 2.5);
    shapes[0].width = random_between(seed, 0.01, 0.06);
    shapes[0].sway = random_between(seed, 1.8, 2.5);
    shapes[0].pitch = random_between(seed, -0.1, 0.1);
    shapes[0].wave_count = random_between(seed, 0.0, 0.1 * (double)grid->columns);
    shapes[0].wave_height =
        random_between(seed, 0.0, 0.6) / (TURN * fmax(shapes[0].wave_count, 1.0));
    shapes[1] = shapes[0];
    shapes[1].sway = random_between(seed, 2.1, 2.6);
    shapes[1].pitch *= -random_between(seed, 0.5, 1.5);
}

static void choose_comb(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    int const teeth = 3 + random_below(seed, 3), per_tooth = 1 + random_below(seed, 2);
    keep_cells(grid, teeth * (per_tooth + 1), 4 + random_below(seed, 4));
    for (int row = 1; row < grid->rows; row++)
        for (int column = per_tooth; column < grid->columns; column += per_tooth + 1)
            grid->is_kept[row * grid->columns + column] = false;
    shapes[0].turns = (double)teeth;
    shapes[0].sway = random_between(seed, 0.0, 0.5);
    shapes[0].pitch = random_between(seed, -0.3, 0.3);
    shapes[1] = shapes[0];
    shapes[1].sway = random_between(seed, 0.1, 0.7);
    shapes[1].pitch *= -random_between(seed, 0.2, 1.5);
}

static void choose_terrain(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    keep_cells(grid, 5 + random_below(seed, 9), 5 + random_below(seed, 9));
    keep_ragged_piece(grid, seed);
    for (int end = 0; end < 2; end++) {
        if (end == 1) shapes[1] = shapes[0];
        for (int i = 0; i < 12; i++) shapes[end].drift[i] = random_between(seed, -1.5, 1.5);
        double const strength = end == 0 ? 0.05 : 0.12;
        shapes[end].drift[0] *= strength;
        shapes[end].drift[4] *= strength;
        shapes[end].pitch = random_between(seed, 0.0, 0.3);
    }
}

static void choose_fan(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    keep_cells(grid, 5 + random_below(seed, 16), 1 + random_below(seed, 3));
    grid->has_centre = true;
    if (random_below(seed, 8) == 0) join_ends(grid, 0, grid->rows); /* winds around a cone point */
    bool const is_closed = grid->joined_to >= grid->joined_from;
    shapes[0].turns = is_closed ? 1.0 + random_below(seed, 2) : random_between(seed, 0.9, 1.5);
    shapes[0].pitch = random_between(seed, 0.02, 1.0);
    shapes[1] = shapes[0];
    shapes[1].pitch *= -random_between(seed, 0.3, 1.5);
    if (!is_closed) shapes[1].turns = random_between(seed, 0.97, 1.5);
}

static void choose_shapes(surface_shape shapes[2], surface_grid *grid, uint64_t *seed) {
    switch (shapes[0].family) {
    case FAMILY_RAMP:
    case FAMILY_C_RING: choose_ring(shapes, grid, seed); break;
    case FAMILY_TWIST:
    case FAMILY_ANNULUS: choose_coil(shapes, grid, seed); break;
    case FAMILY_SLIT: choose_slit(shapes, grid, seed); break;
    case FAMILY_FOLD: choose_fold(shapes, grid, seed); break;
    case FAMILY_COMB: choose_comb(shapes, grid, seed); break;
    case FAMILY_TERRAIN: choose_terrain(shapes, grid, seed); break;
    case FAMILY_FAN:
    case FAMILY_COUNT: choose_fan(shapes, grid, seed); break;
    }
}

/* ---- the mesh ---- */

static uint32_t find_grid_vertex(const surface_grid *grid, int column, int row) {
    if (grid->has_centre && row == 0) column = 0;
    bool const is_joined = row >= grid->joined_from && row <= grid->joined_to;
    if (column == grid->columns && is_joined) column = 0;
    return (uint32_t)(row * (grid->columns + 1) + column);
}

static void add_grid_triangle(open_surface *to, uint32_t a, uint32_t b, uint32_t c) {
    if (a == b || b == c || c == a || to->triangle_count == OPEN_TRIANGLES) return;
    const uint32_t corners[3] = {a, b, c};
    memcpy(to->triangles + 3 * to->triangle_count++, corners, sizeof corners);
}

static void add_cells(open_surface *to, const surface_grid *grid, uint64_t *seed) {
    int const pattern = random_below(seed, 3);
    for (int row = 0; row < grid->rows; row++)
        for (int column = 0; column < grid->columns; column++) {
            if (!grid->is_kept[row * grid->columns + column]) continue;
            uint32_t const a = find_grid_vertex(grid, column, row);
            uint32_t const b = find_grid_vertex(grid, column + 1, row);
            uint32_t const c = find_grid_vertex(grid, column + 1, row + 1);
            uint32_t const d = find_grid_vertex(grid, column, row + 1);
            bool const is_other = pattern == 0   ? false
                                  : pattern == 1 ? (row + column) % 2 == 0
                                                 : random_below(seed, 2) == 0;
            add_grid_triangle(to, a, b, is_other ? d : c);
            add_grid_triangle(to, is_other ? b : a, c, d);
        }
}

/* Places vertices of the grid, then leaves out those that no triangle uses. */
static void place_vertices(open_surface *to, const surface_grid *grid,
                           const surface_shape shapes[2]) {
    static uint32_t numbers[(GRID_SIDE + 1) * (GRID_SIDE + 1)];
    memset(numbers, 0xff, sizeof numbers);
    int const stride = grid->columns + 1;
    for (size_t i = 0; i < 3 * to->triangle_count; i++) {
        uint32_t const at = to->triangles[i];
        if (numbers[at] == UINT32_MAX) {
            assert_true(to->vertex_count < OPEN_VERTICES);
            uint32_t const number = numbers[at] = (uint32_t)to->vertex_count++;
            double const u = (double)((int)at % stride) / (double)grid->columns;
            double const v = (double)((int)at / stride) / (double)grid->rows;
            vec3_store(to->x0, number, find_on_shape(&shapes[0], u, v));
            vec3_store(to->x1, number, find_on_shape(&shapes[1], u, v));
        }
        to->triangles[i] = numbers[at];
    }
}

static double measure_edge(const open_surface *of) {
    double sum = 0.0;
    for (size_t t = 0; t < of->triangle_count; t++)
        for (size_t k = 0; k < 3; k++)
            sum += vec3_norm(vec3_sub(vec3_load(of->x0, of->triangles[3 * t + k]),
                                      vec3_load(of->x0, of->triangles[3 * t + (k + 1) % 3])));
    return sum / (3.0 * (double)of->triangle_count);
}

/* Faults that a mesh may have: triangles turned over, given twice, standing on an edge or a vertex
 * of others, vertices made one. */
static void spoil_mesh(open_surface *of, uint64_t *seed) {
    int const triangle_count = (int)of->triangle_count;
    uint32_t *const triangle = of->triangles + 3 * random_below(seed, triangle_count);
    const uint32_t *const other = of->triangles + 3 * random_below(seed, triangle_count);
    uint32_t const far = (uint32_t)random_below(seed, (int)of->vertex_count);
    uint32_t const first = triangle[0];
    switch (random_below(seed, 5)) {
    case 0: triangle[0] = triangle[1], triangle[1] = first; break;
    case 1: add_grid_triangle(of, other[0], other[1], other[2]); break;
    case 2: add_grid_triangle(of, other[1], other[0], far); break;
    case 3: add_grid_triangle(of, other[0], triangle[1], far); break;
    default:
        for (size_t i = 0; i < 3 * of->triangle_count; i++) {
            uint32_t *const corners = of->triangles + i / 3 * 3;
            bool const has_first =
                corners[0] == first || corners[1] == first || corners[2] == first;
            if (of->triangles[i] == far && !has_first) of->triangles[i] = first;
        }
    }
}

/* The whole end turned about one of its vertices, mostly by near half a turn: triangles shrink on
 * the way, and some turn over and back. */
static void turn_end(open_surface *of, uint64_t *seed) {
    vec3 const centre = vec3_load(of->x1, (size_t)random_below(seed, (int)of->vertex_count));
    vec3 const axis =
        random_below(seed, 2) ? vec3_make(0.0, 0.0, 1.0) : vec3_normalize(random_in_box(seed, 1.0));
    double const near_half = random_between(seed, 0.42, 0.5);
    double const angle = TURN * (random_below(seed, 3) ? near_half : random_uniform(seed));
    for (size_t i = 0; i < of->vertex_count; i++) {
        vec3 const from = vec3_sub(vec3_load(of->x1, i), centre);
        vec3 const along = vec3_scale(axis, vec3_dot(axis, from));
        vec3 const off = vec3_sub(from, along), across = vec3_cross(axis, from);
        vec3 const turned = vec3_add_scaled(vec3_scale(off, cos(angle)), across, sin(angle));
        vec3_store(of->x1, i, vec3_add(centre, vec3_add(along, turned)));
    }
}

static void move_all(open_surface *of, uint64_t *seed) {
    double const size = pow(10.0, random_between(seed, -6.0, 6.0));
    double const far = random_below(seed, 2) ? pow(10.0, random_between(seed, 0.0, 7.0)) : 0.0;
    vec3 const shift = random_in_box(seed, far);
    vec3 const x = vec3_normalize(random_in_box(seed, 1.0));
    vec3 const y = vec3_normalize(vec3_cross(x, random_in_box(seed, 1.0))), z = vec3_cross(x, y);
    for (size_t i = 0; i < of->vertex_count; i++)
        for (int end = 0; end < 2; end++) {
            double *const to = end == 0 ? of->x0 : of->x1;
            vec3 const p = vec3_load(to, i);
            vec3 moved = vec3_add_scaled(shift, x, p.x);
            moved = vec3_add_scaled(vec3_add_scaled(moved, y, p.y), z, p.z);
            vec3_store(to, i, vec3_scale(moved, size));
        }
}

static void count_hops(open_surface *of) {
    size_t const count = of->vertex_count;
    const adjacency *const around = &of->topo.vertex_neighbours;
    static uint32_t queue[OPEN_VERTICES];
    memset(of->hops, 255, count * count);
    for (uint32_t from = 0; from < count; from++) {
        unsigned char *const hops = of->hops + from * count;
        size_t joined = 0;
        queue[joined++] = from;
        hops[from] = 0;
        for (size_t next = 0; next < joined; next++) {
            uint32_t const at = queue[next];
            for (uint32_t i = around->begin[at]; i < around->begin[at + 1]; i++) {
                uint32_t const neighbour = around->items[i];
                if (hops[neighbour] != 255 || hops[at] == 254) continue;
                hops[neighbour] = (unsigned char)(hops[at] + 1);
                queue[joined++] = neighbour;
            }
        }
    }
}

void make_open_surface(memory *heap, surface_family family, surface_wishes wishes, uint64_t *seed,
                       open_surface *to) {
    surface_shape shapes[2] = {{.family = family}, {.family = family}};
    static surface_grid grid;
    to->triangle_count = to->vertex_count = 0;
    choose_shapes(shapes, &grid, seed);
    assert_true(grid.columns <= GRID_SIDE && grid.columns * grid.rows <= GRID_CELLS);
    add_cells(to, &grid, seed);
    place_vertices(to, &grid, shapes);
    double const noise =
        random_below(seed, 2) ? measure_edge(to) * random_between(seed, 0.0, 0.1) : 0.0;
    for (size_t i = 0; i < to->vertex_count; i++) {
        vec3_store(to->x0, i, vec3_add(vec3_load(to->x0, i), random_in_box(seed, noise)));
        vec3_store(to->x1, i, vec3_add(vec3_load(to->x1, i), random_in_box(seed, noise)));
    }
    if (!wishes.is_plain) {
        for (int faults = random_below(seed, 8) - 5; faults > 0; faults--) spoil_mesh(to, seed);
        if (random_below(seed, 4) == 0) turn_end(to, seed);
        move_all(to, seed);
    }
    to->edge = measure_edge(to);
    if (!wishes.is_plain && random_below(seed, 3) == 0) { /* many exact coincidences */
        double const spacing = exp2(floor(log2(to->edge)) - random_below(seed, 5));
        for (size_t i = 0; i < 3 * to->vertex_count; i++) {
            to->x0[i] = rint(to->x0[i] / spacing) * spacing;
            to->x1[i] = rint(to->x1[i] / spacing) * spacing;
        }
    }
    assert_int_equal(
        topology_build(heap, to->triangles, to->triangle_count, to->vertex_count, &to->topo), 0);
    to->range = (surface_range){.vertex_end = (uint32_t)to->vertex_count,
                                .edge_end = (uint32_t)to->topo.edge_count,
                                .triangle_end = (uint32_t)to->triangle_count,
                                .is_present = true};
    to->set = (surface_set){.topo = &to->topo, .surfaces = &to->range, .surface_count = 1};
    count_hops(to);
}
