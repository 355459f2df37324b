/* support/spring_system.c - see spring_system.h. */
#include "support/spring_system.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Where a graph has no wide edges of its own, how far after its vertex an isotropic spring ends. */
enum { USUAL_REACH = 5 };

double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

static void append_edge(uint32_t (*edges)[2], size_t *count, size_t a, size_t b) {
    edges[*count][0] = (uint32_t)a;
    edges[(*count)++][1] = (uint32_t)b;
}

static void add_edge(spring_graph *mesh, size_t a, size_t b) {
    if (a == b) return;
    for (size_t e = 0; e < mesh->edge_count; e++)
        if ((mesh->edges[e][0] == a && mesh->edges[e][1] == b) ||
            (mesh->edges[e][0] == b && mesh->edges[e][1] == a))
            return;
    append_edge(mesh->edges, &mesh->edge_count, a, b);
}

static spring_graph make_graph(size_t vertex_count, size_t edge_room) {
    spring_graph mesh = {.vertex_count = vertex_count};
    mesh.edges = malloc((edge_room + 1) * sizeof *mesh.edges);
    return mesh;
}

/* The edges of the sheet that begins at `first`. */
static void add_sheet(const spring_sheets *sheets, size_t first, spring_graph *mesh) {
    static const int ways[SPRING_WAYS][2] = {{0, 2}, {2, 0}, {2, 2}, {-2, 2}, {2, 1}, {-2, 1}};
    size_t const columns = sheets->columns, rows = sheets->rows;
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < columns; i++) {
            size_t const v = first + j * columns + i;
            bool const in_hole = sheets->has_hole && 3 * i > columns && 3 * i < 2 * columns &&
                                 3 * j > rows && 2 * j < rows;
            bool const is_other = sheets->is_crossed && j % 2 == 1;
            size_t const others[3][2] = {{i + 1, j}, {i, j + 1}, {is_other ? i - 1 : i + 1, j + 1}};
            for (size_t k = 0; k < 3 && !in_hole; k++)
                if (others[k][0] < columns && others[k][1] < rows)
                    append_edge(mesh->edges, &mesh->edge_count, v,
                                first + others[k][1] * columns + others[k][0]);
            for (size_t k = 0; k < sheets->wide_count && !in_hole; k++) {
                size_t const column = i + (size_t)ways[k][0], row = j + (size_t)ways[k][1];
                if (column < columns && row < rows)
                    append_edge(mesh->wide, &mesh->wide_count, v, first + row * columns + column);
            }
        }
}

spring_graph spring_graph_make_sheets(const spring_sheets *sheets) {
    size_t const size = sheets->columns * sheets->rows;
    spring_graph mesh = make_graph(size * sheets->count, 3 * size * sheets->count);
    mesh.wide = malloc((SPRING_WAYS * mesh.vertex_count + 1) * sizeof *mesh.wide);
    for (size_t k = 0; k < sheets->count; k++) add_sheet(sheets, size * k, &mesh);
    return mesh;
}

spring_graph spring_graph_make_grid(size_t columns, size_t rows, bool has_hole) {
    spring_sheets const sheet = {
        .columns = columns, .rows = rows, .count = 1, .has_hole = has_hole};
    spring_graph mesh = spring_graph_make_sheets(&sheet);
    free(mesh.wide);
    mesh.wide = NULL;
    return mesh;
}

spring_graph spring_graph_make_random(size_t vertex_count, size_t edge_count, uint64_t seed) {
    spring_graph mesh = make_graph(vertex_count, edge_count + vertex_count);
    for (size_t e = 0; e < edge_count; e++) {
        size_t const a = (size_t)(random_uniform(&seed) * (double)vertex_count);
        size_t const b = (size_t)(random_uniform(&seed) * (double)vertex_count);
        add_edge(&mesh, a, b);
    }
    for (size_t v = 1; v < vertex_count / 3; v++) add_edge(&mesh, 0, v);
    return mesh;
}

static void fill_scalars(const spring_system *system, double stiffness, uint64_t *seed) {
    const block_matrix *const m = &system->matrix;
    memset(system->scalars, 0, m->scalar_count * sizeof(double));
    for (size_t e = 0; e < system->mesh.wide_count; e++) {
        const uint32_t *const ends = system->mesh.wide[e];
        double const k = stiffness * random_uniform(seed);
        for (size_t a = 0; a < 4; a++) {
            uint32_t const row = ends[a / 2], column = ends[a % 2];
            system->scalars[find_in_columns(m->scalar_columns, m->scalar_begin[row],
                                            m->scalar_begin[row + 1], column)] +=
                row == column ? k : -k;
        }
    }
}

void spring_system_fill(spring_system *system, double stiffness, uint64_t seed) {
    block_matrix *const m = &system->matrix;
    memset(m->values, 0, BLOCK_NUMBERS * m->block_count * sizeof(double));
    for (size_t v = 0; v < m->row_count; v++)
        for (size_t i = 0; i < BLOCK_NUMBERS; i++)
            if (block_places[i] % 4 == 0)
                m->values[BLOCK_NUMBERS * (size_t)m->diagonal_positions[v] + i] =
                    0.5 + random_uniform(&seed);
    for (size_t e = 0; e < system->mesh.edge_count; e++) {
        const uint32_t *const ends = system->mesh.edges[e];
        double const n[3] = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        double const k = stiffness * random_uniform(&seed);
        for (size_t i = 0; i < BLOCK_NUMBERS; i++) {
            size_t const at = block_places[i];
            double const value = k * (n[at / 3] * n[at % 3] + (at % 4 == 0 ? 0.1 : 0.0));
            for (size_t a = 0; a < 2; a++) {
                size_t const other = block_matrix_find(m, ends[a], ends[1 - a]);
                m->values[BLOCK_NUMBERS * (size_t)m->diagonal_positions[ends[a]] + i] += value;
                m->values[BLOCK_NUMBERS * other + i] -= value;
            }
        }
    }
    fill_scalars(system, 0.05 * stiffness, &seed);
}

/* Each vertex itself and those that edges join it to, ascending in a row. */
static block_pattern make_pattern(size_t vertex_count, uint32_t (*edges)[2], size_t edge_count) {
    uint32_t *const begin = calloc(vertex_count + 1, 4);
    uint32_t *const columns = malloc((vertex_count + 2 * edge_count) * 4);
    uint32_t *const place = calloc(vertex_count + 1, 4);
    for (size_t v = 0; v < vertex_count; v++) begin[v + 1] = 1;
    for (size_t e = 0; e < edge_count; e++) begin[edges[e][0] + 1]++, begin[edges[e][1] + 1]++;
    for (size_t v = 0; v < vertex_count; v++) begin[v + 1] += begin[v];
    for (size_t v = 0; v < vertex_count; v++) columns[begin[v] + place[v]++] = (uint32_t)v;
    for (size_t e = 0; e < edge_count; e++)
        for (size_t a = 0; a < 2; a++) {
            uint32_t const v = edges[e][a];
            columns[begin[v] + place[v]++] = edges[e][1 - a];
        }
    for (size_t v = 0; v < vertex_count; v++)
        for (uint32_t k = begin[v] + 1; k < begin[v + 1]; k++)
            for (uint32_t l = k; l > begin[v] && columns[l] < columns[l - 1]; l--) {
                uint32_t const kept = columns[l];
                columns[l] = columns[l - 1];
                columns[l - 1] = kept;
            }
    free(place);
    return (block_pattern){begin, columns};
}

spring_system spring_system_make(spring_graph mesh, double stiffness, uint64_t seed) {
    size_t const count = mesh.vertex_count;
    if (!mesh.wide) {
        mesh.wide = malloc(count * sizeof *mesh.wide);
        for (size_t v = 0; v + USUAL_REACH < count; v++)
            append_edge(mesh.wide, &mesh.wide_count, v, v + USUAL_REACH);
    }
    spring_system system = {.heap = memory_default(), .mesh = mesh};
    system.patterns[0] = make_pattern(count, mesh.edges, mesh.edge_count);
    system.patterns[1] = make_pattern(count, mesh.wide, mesh.wide_count);
    assert_int_equal(block_matrix_build(&system.heap, count, system.patterns[0], system.patterns[1],
                                        &system.matrix),
                     TULLE_OK);
    system.scalars = calloc(system.matrix.scalar_count, sizeof(double));
    system.matrix.scalar_parts[0] = system.matrix.scalar_parts[1] = system.scalars;
    system.matrix.scalar_factors[0] = 1.0;
    system.is_fixed = calloc(count, 1);
    spring_system_fill(&system, stiffness, seed);
    return system;
}

void spring_system_destroy(spring_system *system) {
    block_matrix_destroy(&system->heap, &system->matrix);
    for (int i = 0; i < 2; i++) {
        free((void *)system->patterns[i].begin);
        free((void *)system->patterns[i].columns);
    }
    free(system->scalars), free(system->is_fixed);
    free(system->mesh.edges), free(system->mesh.wide);
}

void spring_system_multiply(const spring_system *system, const spring_matrix *matrix,
                            const double *x, double *y) {
    const block_matrix *const m = &system->matrix;
    for (size_t v = 0; v < m->row_count; v++) {
        double sum[3] = {0.0, 0.0, 0.0};
        for (uint32_t k = m->row_begin[v]; k < m->row_begin[v + 1]; k++) {
            if (system->is_fixed[m->columns[k]]) continue;
            for (size_t i = 0; i < BLOCK_NUMBERS; i++) {
                size_t const row = block_places[i] / 3, column = block_places[i] % 3;
                double const value = m->values[BLOCK_NUMBERS * k + i];
                sum[row] += value * x[3 * m->columns[k] + column];
                if (row != column) sum[column] += value * x[3 * m->columns[k] + row];
            }
        }
        for (uint32_t k = m->scalar_begin[v]; k < m->scalar_begin[v + 1]; k++)
            for (size_t i = 0; i < 3 && !system->is_fixed[m->scalar_columns[k]]; i++)
                sum[i] += block_matrix_get_scalar(m, k) * x[3 * m->scalar_columns[k] + i];
        for (size_t i = 0; i < 3; i++) y[3 * v + i] = system->is_fixed[v] ? 0.0 : sum[i];
    }
    for (size_t t = 0; t < matrix->term_count; t++) {
        const matrix_term *const term = &matrix->terms[t];
        double velocity[3] = {0.0, 0.0, 0.0}, pull[3];
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                if (!system->is_fixed[term->vertices[k]])
                    velocity[i] += term->weights[k] * x[3 * term->vertices[k] + i];
        vec3_store(pull, 0, mat3_multiply_vec3(&term->stiffness, vec3_load(velocity, 0)));
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                if (!system->is_fixed[term->vertices[k]])
                    y[3 * term->vertices[k] + i] += term->weights[k] * pull[i];
    }
}
