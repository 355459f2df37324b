/* scene/near_obstacle.c - the vertices of a cloth near the triangles of an obstacle.
 *
 * Vertices lie in the cells of a grid, about as many cells as vertices; a triangle looks at the
 * cells that its box, widened by the distance, meets. */
#include "scene/scene_data.h"

#include <math.h>

typedef struct vertex_grid {
    double low[3], cell; /* [m] */
    size_t counts[3];    /* cells along each axis */
    /* Vertices of cell c: vertices[begins[c]] to vertices[begins[c + 1] - 1]. */
    uint32_t *begins, *vertices;
    size_t cell_count;
} vertex_grid;

/* The cell along an axis, the nearest one for a place outside. */
static size_t find_cell(const vertex_grid *grid, int axis, double place) {
    double const cell = floor((place - grid->low[axis]) / grid->cell);
    return cell <= 0.0 ? 0 : (size_t)fmin(cell, (double)(grid->counts[axis] - 1));
}

static size_t find_cell_of(const vertex_grid *grid, const double *p) {
    size_t const x = find_cell(grid, 0, p[0]), y = find_cell(grid, 1, p[1]);
    return (find_cell(grid, 2, p[2]) * grid->counts[1] + y) * grid->counts[0] + x;
}

static double count_cells(const double extent[3], double cell) {
    double count = 1.0;
    for (int k = 0; k < 3; k++) count *= floor(extent[k] / cell) + 1.0;
    return count;
}

/* Cells as small as they can be so that there are no more than vertices. */
static void lay_grid(const tulle_mesh *mesh, vertex_grid *grid) {
    double high[3] = {-INFINITY, -INFINITY, -INFINITY}, extent[3], largest = 0.0;
    for (int k = 0; k < 3; k++) grid->low[k] = INFINITY;
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        grid->low[i % 3] = fmin(grid->low[i % 3], mesh->positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh->positions[i]);
    }
    for (int k = 0; k < 3; k++) {
        extent[k] = high[k] - grid->low[k];
        largest = fmax(largest, extent[k]);
    }
    grid->cell = 2.0 * largest;
    while (count_cells(extent, 0.75 * grid->cell) <= (double)mesh->vertex_count) grid->cell *= 0.75;
    grid->cell_count = 1;
    for (int k = 0; k < 3; k++) {
        grid->counts[k] = (size_t)floor(extent[k] / grid->cell) + 1;
        grid->cell_count *= grid->counts[k];
    }
}

/* False when memory is short. */
static bool fill_grid(memory *heap, const tulle_mesh *mesh, vertex_grid *grid) {
    lay_grid(mesh, grid);
    grid->begins = memory_allocate_zeroed(heap, grid->cell_count + 2, sizeof *grid->begins);
    grid->vertices = memory_allocate(heap, mesh->vertex_count * sizeof *grid->vertices);
    if (!grid->begins || !grid->vertices) return false;
    /* Counted two cells further on, summed, then each begin is moved on to the end of its cell,
     * which is where the next one begins. */
    for (size_t v = 0; v < mesh->vertex_count; v++)
        grid->begins[find_cell_of(grid, mesh->positions + 3 * v) + 2]++;
    for (size_t c = 2; c < grid->cell_count + 2; c++) grid->begins[c] += grid->begins[c - 1];
    for (size_t v = 0; v < mesh->vertex_count; v++)
        grid->vertices[grid->begins[find_cell_of(grid, mesh->positions + 3 * v) + 1]++] =
            (uint32_t)v;
    return true;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Of a point from a triangle: from its plane where the foot lies inside, else from a side. */
static double measure_to_triangle(const double *const corners[3], const double p[3]) {
    double first[3], second[3], from[3];
    for (int k = 0; k < 3; k++) {
        first[k] = corners[1][k] - corners[0][k];
        second[k] = corners[2][k] - corners[0][k];
        from[k] = p[k] - corners[0][k];
    }
    double const a = dot(first, first), b = dot(first, second), c = dot(second, second);
    double const u = dot(from, first), v = dot(from, second), area = a * c - b * b;
    double const s = (c * u - b * v) / area, t = (a * v - b * u) / area;
    if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) {
        for (int k = 0; k < 3; k++) from[k] -= s * first[k] + t * second[k];
        return sqrt(dot(from, from));
    }
    double const side = fmin(measure_to_segment(corners[0], corners[1], p),
                             measure_to_segment(corners[1], corners[2], p));
    return fmin(side, measure_to_segment(corners[2], corners[0], p));
}

static void mark_near_triangle(const tulle_mesh *mesh, const vertex_grid *grid,
                               const double *const corners[3], double within, unsigned char mark,
                               unsigned char *marks) {
    size_t first[3], last[3];
    for (int k = 0; k < 3; k++) {
        first[k] =
            find_cell(grid, k, fmin(fmin(corners[0][k], corners[1][k]), corners[2][k]) - within);
        last[k] =
            find_cell(grid, k, fmax(fmax(corners[0][k], corners[1][k]), corners[2][k]) + within);
    }
    for (size_t z = first[2]; z <= last[2]; z++)
        for (size_t y = first[1]; y <= last[1]; y++) {
            size_t const row = (z * grid->counts[1] + y) * grid->counts[0];
            uint32_t const end = grid->begins[row + last[0] + 1];
            for (uint32_t i = grid->begins[row + first[0]]; i < end; i++) {
                uint32_t const v = grid->vertices[i];
                const double *const p = mesh->positions + 3 * (size_t)v;
                if (!(marks[v] & mark) && measure_to_triangle(corners, p) <= within)
                    marks[v] |= mark;
            }
        }
}

bool mark_near(const scene_work *work, const tulle_mesh *mesh, const tulle_mesh *obstacle,
               double within, unsigned char mark, unsigned char *marks) {
    memory *const heap = &work->scene->heap;
    vertex_grid grid = {0};
    bool const is_filled = fill_grid(heap, mesh, &grid);
    for (size_t t = 0; is_filled && t < obstacle->triangle_count; t++) {
        const double *corners[3];
        for (size_t k = 0; k < 3; k++)
            corners[k] = obstacle->positions + 3 * (size_t)obstacle->triangles[3 * t + k];
        mark_near_triangle(mesh, &grid, corners, within, mark, marks);
    }
    if (!is_filled) problem_add_memory(work->problems, work->scene->path);
    memory_release(heap, grid.begins, (grid.cell_count + 2) * sizeof *grid.begins);
    memory_release(heap, grid.vertices, mesh->vertex_count * sizeof *grid.vertices);
    return is_filled;
}
