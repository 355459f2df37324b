/* strips_turned.c - a strip cut out of a square lattice that lies at 22.5 degrees to it: the
 * lattice covers more, is cut along lines, and what lies beyond the border goes. */
#include "validation/strips.h"

#include <math.h>

static double const TURN = 22.5 * VALIDATION_DEGREE; /* [rad] */
/* Vertices nearer to a line, in cells, move onto it, so that no needles are cut off. */
static double const SNAP = 0.25;

typedef struct cut_edge {
    uint32_t ends[2], vertex;
} cut_edge;

typedef struct cutting {
    double (*x)[2]; /* [m] */
    uint32_t (*triangles)[3];
    size_t vertex_count, triangle_count;
    cut_edge *edges; /* of the line that is cut along now */
    size_t edge_count;
    uint32_t *numbers; /* of the vertices that are left */
} cutting;

static cutting cover(validation_run *run, double middle, double radius, double cell) {
    size_t const side = 2 * (size_t)ceil(radius / cell), line = side + 1;
    cutting all = {.vertex_count = line * line, .triangle_count = 2 * side * side};
    /* A cut splits a part of the triangles only. */
    all.x = validate_allocate(run, 3 * all.vertex_count * sizeof *all.x);
    all.triangles = validate_allocate(run, 3 * all.triangle_count * sizeof *all.triangles);
    all.edges = validate_allocate(run, 2 * all.vertex_count * sizeof *all.edges);
    for (size_t v = 0; v < all.vertex_count; v++) {
        double const a = cell * ((double)(v % line) - 0.5 * (double)side);
        double const b = cell * ((double)(v / line) - 0.5 * (double)side);
        all.x[v][0] = middle + cos(TURN) * a - sin(TURN) * b;
        all.x[v][1] = sin(TURN) * a + cos(TURN) * b;
    }
    for (size_t c = 0; c < side * side; c++) {
        uint32_t const at = (uint32_t)(c / side * line + c % side), above = at + (uint32_t)line;
        uint32_t const corners[2][3] = {{at, at + 1, above + 1}, {at, above + 1, above}};
        for (size_t k = 0; k < 6; k++) all.triangles[2 * c + k / 3][k % 3] = corners[k / 3][k % 3];
    }
    return all;
}

/* The vertex where the line x[axis] = at cuts the edge. */
static uint32_t cut_edge_at(cutting *all, uint32_t a, uint32_t b, int axis, double at) {
    uint32_t const low = a < b ? a : b, high = a < b ? b : a;
    for (size_t e = 0; e < all->edge_count; e++)
        if (all->edges[e].ends[0] == low && all->edges[e].ends[1] == high)
            return all->edges[e].vertex;
    uint32_t const vertex = (uint32_t)all->vertex_count++;
    const double *const from = all->x[low];
    const double *const to = all->x[high];
    double const part = (at - from[axis]) / (to[axis] - from[axis]);
    all->x[vertex][1 - axis] = from[1 - axis] + part * (to[1 - axis] - from[1 - axis]);
    all->x[vertex][axis] = at;
    all->edges[all->edge_count++] = (cut_edge){{low, high}, vertex};
    return vertex;
}

static void set_triangle(cutting *all, size_t t, uint32_t a, uint32_t b, uint32_t c) {
    all->triangles[t][0] = a;
    all->triangles[t][1] = b;
    all->triangles[t][2] = c;
}

static int find_side(const cutting *all, uint32_t vertex, int axis, double at) {
    double const distance = all->x[vertex][axis] - at;
    return (distance > 0.0) - (distance < 0.0);
}

/* Splits a triangle that lies on both sides of the line. */
static void split(cutting *all, size_t t, int axis, double at) {
    uint32_t corners[3];
    int sides[3];
    /* Turned until the first corner lies on the line, or alone on its side. */
    for (size_t turn = 0; turn < 3; turn++) {
        for (size_t k = 0; k < 3; k++) {
            corners[k] = all->triangles[t][(k + turn) % 3];
            sides[k] = find_side(all, corners[k], axis, at);
        }
        if (sides[1] * sides[2] == (sides[0] == 0 ? -1 : 1) && sides[0] != sides[1]) break;
    }
    uint32_t const a = corners[0], b = corners[1], c = corners[2];
    if (sides[0] == 0) {
        uint32_t const middle = cut_edge_at(all, b, c, axis, at);
        set_triangle(all, t, a, b, middle);
        set_triangle(all, all->triangle_count++, a, middle, c);
        return;
    }
    uint32_t const left = cut_edge_at(all, a, b, axis, at);
    uint32_t const right = cut_edge_at(all, a, c, axis, at);
    set_triangle(all, t, a, left, right);
    set_triangle(all, all->triangle_count++, left, b, c);
    set_triangle(all, all->triangle_count++, left, c, right);
}

/* Cuts along the line x[axis] = at. What lies below it goes where `keep` is 1, what lies above it
 * where that is -1; 0 keeps both. */
static void cut(cutting *all, int axis, double at, int keep, double cell) {
    all->edge_count = 0;
    for (size_t v = 0; v < all->vertex_count; v++)
        if (fabs(all->x[v][axis] - at) < SNAP * cell) all->x[v][axis] = at;
    size_t const count = all->triangle_count;
    for (size_t t = 0; t < count; t++) {
        bool is_above = false, is_below = false;
        for (size_t k = 0; k < 3; k++) {
            int const side = find_side(all, all->triangles[t][k], axis, at);
            is_above |= side > 0, is_below |= side < 0;
        }
        if (is_above && is_below) split(all, t, axis, at);
    }
    size_t kept = 0;
    for (size_t t = 0; t < all->triangle_count; t++) {
        const uint32_t *const corners = all->triangles[t];
        int side = 0;
        for (size_t k = 0; k < 3; k++) side += find_side(all, corners[k], axis, at);
        if (side * keep >= 0) set_triangle(all, kept++, corners[0], corners[1], corners[2]);
    }
    all->triangle_count = kept;
}

static bool is_flat(const cutting *all, const uint32_t corners[3], double cell) {
    const double *const o = all->x[corners[0]];
    const double *const a = all->x[corners[1]];
    const double *const b = all->x[corners[2]];
    return fabs((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])) < 1e-6 * cell * cell;
}

/* Near corners of the border several vertices may have moved to one place, or three onto one line.
 * Drops what triangles have no area then, numbers the places that are left and gives their count.
 */
static uint32_t weld(validation_run *run, cutting *all, double cell) {
    size_t kept = 0;
    for (size_t t = 0; t < all->triangle_count; t++) {
        const uint32_t *const corners = all->triangles[t];
        if (!is_flat(all, corners, cell))
            set_triangle(all, kept++, corners[0], corners[1], corners[2]);
    }
    all->triangle_count = kept;
    all->numbers = validate_allocate(run, all->vertex_count * sizeof *all->numbers);
    for (size_t v = 0; v < all->vertex_count; v++) all->numbers[v] = UINT32_MAX;
    uint32_t *const places = validate_allocate(run, all->vertex_count * sizeof *places);
    uint32_t used = 0;
    for (size_t k = 0; k < 3 * kept; k++) {
        uint32_t const v = all->triangles[k / 3][k % 3];
        if (all->numbers[v] != UINT32_MAX) continue;
        uint32_t number = 0;
        while (number < used && hypot(all->x[v][0] - all->x[places[number]][0],
                                      all->x[v][1] - all->x[places[number]][1]) > 1e-6 * cell)
            number++;
        if (number == used) places[used++] = v;
        all->numbers[v] = number;
    }
    return used;
}

tulle_mesh *strips_make_turned(validation_run *run, const strip *sample) {
    double const length = sample->end - sample->begin, cell = length / sample->columns;
    cutting all = cover(run, 0.5 * (sample->begin + sample->end),
                        0.5 * hypot(length, sample->width) + 2.0 * cell, cell);
    cut(&all, 1, -0.5 * sample->width, 1, cell);
    cut(&all, 1, 0.5 * sample->width, -1, cell);
    cut(&all, 0, sample->begin, 1, cell);
    cut(&all, 0, sample->end, -1, cell);
    for (size_t i = 0; i < 2; i++)
        if (sample->lines[i] > sample->begin && sample->lines[i] < sample->end)
            cut(&all, 0, sample->lines[i], 0, cell);
    uint32_t const used = weld(run, &all, cell);
    tulle_mesh *const mesh = validate_make_mesh(run, used, all.triangle_count);
    for (size_t k = 0; k < 3 * all.triangle_count; k++) {
        uint32_t const v = all.triangles[k / 3][k % 3], number = all.numbers[v];
        mesh->triangles[k] = number;
        mesh->positions[3 * (size_t)number] = all.x[v][0];
        mesh->positions[3 * (size_t)number + 1] = all.x[v][1];
        mesh->positions[3 * (size_t)number + 2] = 0.0;
    }
    return mesh;
}
