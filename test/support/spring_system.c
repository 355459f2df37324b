/* support/spring_system.c - see spring_system.h. */
#include "support/spring_system.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

static void add_edge(spring_graph *mesh, size_t a, size_t b) {
    if (a == b) return;
    for (size_t e = 0; e < mesh->edge_count; e++)
        if ((mesh->edges[e][0] == a && mesh->edges[e][1] == b) ||
            (mesh->edges[e][0] == b && mesh->edges[e][1] == a))
            return;
    mesh->edges[mesh->edge_count][0] = (uint32_t)a;
    mesh->edges[mesh->edge_count++][1] = (uint32_t)b;
}

static spring_graph make_graph(size_t vertex_count, size_t edge_room) {
    spring_graph mesh = {.vertex_count = vertex_count};
    mesh.edges = malloc((edge_room + 1) * sizeof *mesh.edges);
    mesh.positions = calloc(3 * vertex_count, sizeof(double));
    return mesh;
}

spring_graph spring_graph_make_grid(size_t columns, size_t rows, bool has_hole) {
    spring_graph mesh = make_graph(columns * rows, 3 * columns * rows);
    size_t count = 0;
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < columns; i++) {
            size_t const v = j * columns + i;
            mesh.positions[3 * v] = 0.02 * (double)i;
            mesh.positions[3 * v + 1] = 0.02 * (double)j;
            bool const in_hole =
                has_hole && 3 * i > columns && 3 * i < 2 * columns && 3 * j > rows && 2 * j < rows;
            size_t const others[3][2] = {{i + 1, j}, {i, j + 1}, {i + 1, j + 1}};
            for (size_t k = 0; k < 3 && !in_hole; k++)
                if (others[k][0] < columns && others[k][1] < rows) {
                    mesh.edges[count][0] = (uint32_t)v;
                    mesh.edges[count++][1] = (uint32_t)(others[k][1] * columns + others[k][0]);
                }
        }
    mesh.edge_count = count;
    return mesh;
}

spring_graph spring_graph_make_random(size_t vertex_count, size_t edge_count, uint64_t seed) {
    spring_graph mesh = make_graph(vertex_count, edge_count + vertex_count);
    for (size_t i = 0; i < 3 * vertex_count; i++) mesh.positions[i] = random_signed(&seed);
    for (size_t e = 0; e < edge_count; e++) {
        size_t const a = (size_t)(random_uniform(&seed) * (double)vertex_count);
        size_t const b = (size_t)(random_uniform(&seed) * (double)vertex_count);
        add_edge(&mesh, a, b);
    }
    for (size_t v = 1; v < vertex_count / 3; v++) add_edge(&mesh, 0, v);
    return mesh;
}

void spring_system_fill(spring_system *system, double stiffness, uint64_t seed) {
    block_matrix *const m = &system->matrix;
    memset(m->values, 0, 9 * m->block_count * sizeof(double));
    for (size_t v = 0; v < m->row_count; v++)
        for (size_t i = 0; i < 9; i += 4)
            m->values[9 * (size_t)m->diagonal_positions[v] + i] = 0.5 + random_uniform(&seed);
    for (size_t e = 0; e < system->mesh.edge_count; e++) {
        const uint32_t *const ends = system->mesh.edges[e];
        double const n[3] = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        double const k = stiffness * random_uniform(&seed);
        for (size_t i = 0; i < 9; i++) {
            double const value = k * (n[i / 3] * n[i % 3] + (i % 4 == 0 ? 0.1 : 0.0));
            for (size_t a = 0; a < 2; a++) {
                m->values[9 * (size_t)m->diagonal_positions[ends[a]] + i] += value;
                m->values[9 * (size_t)block_matrix_find(m, ends[a], ends[1 - a]) + i] -= value;
            }
        }
    }
}

spring_system spring_system_make(spring_graph mesh, double stiffness, uint64_t seed) {
    spring_system system = {.heap = memory_default(), .mesh = mesh};
    size_t const count = mesh.vertex_count;
    uint32_t *const begin = calloc(count + 1, 4);
    uint32_t *const columns = malloc((count + 2 * mesh.edge_count) * 4);
    uint32_t *const place = calloc(count + 1, 4);
    for (size_t v = 0; v < count; v++) begin[v + 1] = 1;
    for (size_t e = 0; e < mesh.edge_count; e++)
        begin[mesh.edges[e][0] + 1]++, begin[mesh.edges[e][1] + 1]++;
    for (size_t v = 0; v < count; v++) begin[v + 1] += begin[v];
    for (size_t v = 0; v < count; v++) columns[begin[v] + place[v]++] = (uint32_t)v;
    for (size_t e = 0; e < mesh.edge_count; e++)
        for (size_t a = 0; a < 2; a++) {
            uint32_t const v = mesh.edges[e][a];
            columns[begin[v] + place[v]++] = mesh.edges[e][1 - a];
        }
    for (size_t v = 0; v < count; v++)
        for (uint32_t k = begin[v] + 1; k < begin[v + 1]; k++)
            for (uint32_t l = k; l > begin[v] && columns[l] < columns[l - 1]; l--) {
                uint32_t const kept = columns[l];
                columns[l] = columns[l - 1];
                columns[l - 1] = kept;
            }
    assert_int_equal(block_matrix_build(&system.heap, count, (block_pattern){begin, columns},
                                        (block_pattern){NULL, NULL}, &system.matrix),
                     TULLE_OK);
    free(begin), free(columns), free(place);
    system.is_fixed = calloc(count, 1);
    spring_system_fill(&system, stiffness, seed);
    return system;
}

void spring_system_destroy(spring_system *system) {
    block_matrix_destroy(&system->heap, &system->matrix);
    free(system->mesh.edges), free(system->mesh.positions), free(system->is_fixed);
}

sparse_cholesky *spring_system_build_factor(spring_system *system) {
    block_pattern const pattern = {system->matrix.row_begin, system->matrix.columns};
    sparse_cholesky *const factor = sparse_cholesky_build(&system->heap, system->matrix.row_count,
                                                          pattern, system->mesh.positions);
    assert_non_null(factor);
    return factor;
}

cholesky_report spring_system_run_factor(spring_system *system, sparse_cholesky *factor,
                                         const cholesky_matrix *matrix, int threads) {
    arena scratch = arena_make(&system->heap);
    cholesky_report report;
    assert_int_equal(sparse_cholesky_factor(factor, matrix, threads, &scratch, &report), TULLE_OK);
    arena_destroy(&scratch);
    return report;
}

cholesky_matrix spring_system_get_matrix(const spring_system *system) {
    return (cholesky_matrix){.blocks = system->matrix.values, .is_fixed = system->is_fixed};
}

void spring_system_multiply(const spring_system *system, const cholesky_matrix *matrix,
                            const double *x, double *y) {
    const block_matrix *const m = &system->matrix;
    for (size_t v = 0; v < m->row_count; v++) {
        double sum[3] = {0.0, 0.0, 0.0};
        for (uint32_t k = m->row_begin[v]; k < m->row_begin[v + 1]; k++) {
            double const shift =
                matrix->shifts[0] ? matrix->shift_factors[0] * matrix->shifts[0][k] : 0.0;
            if (matrix->is_fixed[m->columns[k]]) continue;
            for (size_t i = 0; i < 3; i++)
                for (size_t j = 0; j < 3; j++)
                    sum[i] += (m->values[9 * k + 3 * j + i] - (i == j ? shift : 0.0)) *
                              x[3 * m->columns[k] + j];
        }
        for (size_t i = 0; i < 3; i++) y[3 * v + i] = matrix->is_fixed[v] ? 0.0 : sum[i];
    }
    for (size_t t = 0; t < matrix->term_count; t++) {
        const cholesky_term *const term = &matrix->terms[t];
        double velocity[3] = {0.0, 0.0, 0.0}, pull[3];
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                if (!matrix->is_fixed[term->vertices[k]])
                    velocity[i] += term->weights[k] * x[3 * term->vertices[k] + i];
        vec3_store(pull, 0, mat3_multiply_vec3(&term->stiffness, vec3_load(velocity, 0)));
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                if (!matrix->is_fixed[term->vertices[k]])
                    y[3 * term->vertices[k] + i] += term->weights[k] * pull[i];
    }
}
