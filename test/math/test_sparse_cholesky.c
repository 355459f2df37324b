/* Sparse Cholesky factors against dense arithmetic, on meshes of all kinds. */
#include "base/hash.h"
#include "math/kernel_target.h"
#include "math/single_solve.h"
#include "math/vec3.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

/* ---- systems: springs of random directions and stiffnesses along the edges of a graph ---- */

typedef struct graph {
    size_t vertex_count, edge_count;
    uint32_t (*edges)[2];
    double *positions;
} graph;

typedef struct test_system {
    memory heap;
    graph mesh;
    block_matrix matrix;
    uint8_t *is_fixed;
} test_system;

static void add_edge(graph *mesh, size_t a, size_t b) {
    if (a == b) return;
    for (size_t e = 0; e < mesh->edge_count; e++)
        if ((mesh->edges[e][0] == a && mesh->edges[e][1] == b) ||
            (mesh->edges[e][0] == b && mesh->edges[e][1] == a))
            return;
    mesh->edges[mesh->edge_count][0] = (uint32_t)a;
    mesh->edges[mesh->edge_count++][1] = (uint32_t)b;
}

static graph make_graph(size_t vertex_count, size_t edge_room) {
    graph mesh = {.vertex_count = vertex_count};
    mesh.edges = malloc((edge_room + 1) * sizeof *mesh.edges);
    mesh.positions = calloc(3 * vertex_count, sizeof(double));
    return mesh;
}

/* Triangulated grid, without the vertices' edges where `hole` says so. */
static graph make_grid(size_t columns, size_t rows, bool has_hole) {
    graph mesh = make_graph(columns * rows, 3 * columns * rows);
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

/* Vertices anywhere in space and edges between any: also several pieces and high valences. */
static graph make_random(size_t vertex_count, size_t edge_count, uint64_t seed) {
    graph mesh = make_graph(vertex_count, edge_count + vertex_count);
    for (size_t i = 0; i < 3 * vertex_count; i++) mesh.positions[i] = random_signed(&seed);
    for (size_t e = 0; e < edge_count; e++) {
        size_t const a = (size_t)(random_uniform(&seed) * (double)vertex_count);
        size_t const b = (size_t)(random_uniform(&seed) * (double)vertex_count);
        add_edge(&mesh, a, b);
    }
    for (size_t v = 1; v < vertex_count / 3; v++) add_edge(&mesh, 0, v);
    return mesh;
}

static void fill_matrix(test_system *system, double stiffness, uint64_t seed) {
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

static test_system make_system(graph mesh, double stiffness, uint64_t seed) {
    test_system system = {.heap = memory_default(), .mesh = mesh};
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
    fill_matrix(&system, stiffness, seed);
    return system;
}

static void destroy_system(test_system *system) {
    block_matrix_destroy(&system->heap, &system->matrix);
    free(system->mesh.edges), free(system->mesh.positions), free(system->is_fixed);
}

static sparse_cholesky *build_factor(test_system *system) {
    block_pattern const pattern = {system->matrix.row_begin, system->matrix.columns};
    sparse_cholesky *const factor = sparse_cholesky_build(&system->heap, system->matrix.row_count,
                                                          pattern, system->mesh.positions);
    assert_non_null(factor);
    return factor;
}

static cholesky_report run_factor(test_system *system, sparse_cholesky *factor,
                                  const cholesky_matrix *matrix, int threads) {
    arena scratch = arena_make(&system->heap);
    cholesky_report report;
    assert_int_equal(sparse_cholesky_factor(factor, matrix, threads, &scratch, &report), TULLE_OK);
    arena_destroy(&scratch);
    return report;
}

static cholesky_matrix get_matrix(const test_system *system) {
    return (cholesky_matrix){.blocks = system->matrix.values, .is_fixed = system->is_fixed};
}

/* y = matrix x with terms, shifts and fixed vertices as cholesky_matrix says. */
static void multiply(const test_system *system, const cholesky_matrix *matrix, const double *x,
                     double *y) {
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
        double speed = 0.0;
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                if (!matrix->is_fixed[term->vertices[k]])
                    speed += term->weights[k] * term->normal[i] * x[3 * term->vertices[k] + i];
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                if (!matrix->is_fixed[term->vertices[k]])
                    y[3 * term->vertices[k] + i] +=
                        term->scale * term->weights[k] * term->normal[i] * speed;
    }
}

static void solve(sparse_cholesky *factor, size_t size, const double *r, double *z, int threads) {
    float *const single = calloc(2 * size, sizeof(float)), *const result = single + size;
    for (size_t i = 0; i < size; i++) single[i] = (float)r[i];
    sparse_cholesky_solve(factor, single, result, threads);
    for (size_t i = 0; i < size; i++) z[i] = (double)result[i];
    free(single);
}

/* Solves for a random right-hand side and gives the residual over it. */
static double measure_residual(const test_system *system, sparse_cholesky *factor,
                               const cholesky_matrix *matrix, int threads) {
    size_t const size = 3 * system->matrix.row_count;
    double *const r = calloc(size, sizeof(double)), *const z = calloc(size, sizeof(double));
    double *const image = malloc(size * sizeof(double));
    uint64_t random = 5;
    for (size_t i = 0; i < size; i++) r[i] = random_signed(&random);
    solve(factor, size, r, z, threads);
    multiply(system, matrix, z, image);
    double error = 0.0, whole = 0.0;
    for (size_t i = 0; i < size; i++) {
        if (matrix->is_fixed[i / 3]) {
            assert_true(z[i] == 0.0);
            continue;
        }
        error += (r[i] - image[i]) * (r[i] - image[i]);
        whole += r[i] * r[i];
    }
    free(r), free(z), free(image);
    return whole > 0.0 ? sqrt(error / whole) : 0.0;
}

/* ---- tests ---- */

/* The factor keeps sixteen bits: half of 2^-15 times the stiffness over the mass. */
#define RESIDUAL(stiffness) (1.5e-5 * (1.0 + (stiffness)))

static void check_graph(graph mesh, double stiffness, uint64_t seed) {
    test_system system = make_system(mesh, stiffness, seed);
    size_t const held = system.heap.bytes_held;
    sparse_cholesky *const factor = build_factor(&system);
    assert_true(system.heap.bytes_held >= held + sparse_cholesky_measure(factor).bytes);
    cholesky_matrix const matrix = get_matrix(&system);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t v = 0; v < mesh.vertex_count; v++) system.is_fixed[v] = pass == 1 && v % 7 == 3;
        fill_matrix(&system, stiffness, seed + (uint64_t)pass);
        assert_int_equal(run_factor(&system, factor, &matrix, 1).raised_pivots, 0);
        double const residual = measure_residual(&system, factor, &matrix, 1);
        if (!(residual < RESIDUAL(stiffness)))
            fail_msg("%zu vertices, %zu edges: residual %g", mesh.vertex_count, mesh.edge_count,
                     residual);
    }
    sparse_cholesky_destroy(&system.heap, factor);
    assert_int_equal(system.heap.bytes_held, held);
    destroy_system(&system);
}

static void test_meshes(void **state) {
    (void)state;
    check_graph(make_grid(1, 1, false), 10.0, 1);
    check_graph(make_grid(2, 1, false), 10.0, 2);
    check_graph(make_grid(2, 2, false), 10.0, 3);
    for (size_t n = 3; n < 30; n += 4) check_graph(make_grid(n, n + 3, n % 2 == 0), 100.0, n);
    check_graph(make_grid(40, 40, true), 100.0, 4);
    check_graph(make_grid(300, 2, false), 100.0, 5);
    for (uint64_t seed = 1; seed < 30; seed++)
        check_graph(make_random(5 + 7 * seed, 4 * seed * seed % 300, seed), 10.0, seed);
}

/* A small change of the matrix is seen. */
static void test_residual_is_a_measure(void **state) {
    (void)state;
    test_system system = make_system(make_grid(20, 20, false), 100.0, 8);
    sparse_cholesky *const factor = build_factor(&system);
    cholesky_matrix const matrix = get_matrix(&system);
    run_factor(&system, factor, &matrix, 1);
    system.matrix.values[9 * (size_t)system.matrix.diagonal_positions[57]] += 10.0;
    assert_true(measure_residual(&system, factor, &matrix, 1) > 1e-3);
    sparse_cholesky_destroy(&system.heap, factor);
    destroy_system(&system);
}

static void test_terms_and_shifts(void **state) {
    (void)state;
    enum { SIDE = 24, TERMS = 60 };
    test_system system = make_system(make_grid(SIDE, SIDE, false), 30.0, 6);
    sparse_cholesky *const factor = build_factor(&system);
    cholesky_matrix matrix = get_matrix(&system);
    double *const shifts = calloc(system.matrix.block_count, sizeof(double));
    for (size_t v = 0; v < system.matrix.row_count; v++) {
        shifts[system.matrix.diagonal_positions[v]] = 0.1;
        system.is_fixed[v] = v % 11 == 5;
    }
    matrix.shifts[0] = shifts;
    matrix.shift_factors[0] = 2.0;
    cholesky_term terms[TERMS];
    uint64_t random = 9;
    for (size_t t = 0; t < TERMS; t++) {
        uint32_t const v = (uint32_t)(t * 7 % (SIDE * (SIDE - 1)));
        uint32_t const corner = v % SIDE == SIDE - 1 ? v - 1 : v;
        terms[t] =
            (cholesky_term){.vertices = {TULLE_NONE, corner, corner + 1, corner + SIDE + 1},
                            .weights = {1.0, random_signed(&random), random_signed(&random), 0.4},
                            .normal = {0.6, 0.0, 0.8},
                            .scale = 100.0 * random_uniform(&random),
                            .side = 1};
    }
    matrix.terms = terms;
    matrix.term_count = TERMS;
    cholesky_report const report = run_factor(&system, factor, &matrix, 2);
    assert_int_equal(report.dropped_terms, 0);
    assert_int_equal(report.raised_pivots, 0);
    assert_true(measure_residual(&system, factor, &matrix, 2) < RESIDUAL(100.0));
    /* A term between far corners is outside: its sides are there each for itself. */
    terms[0] = (cholesky_term){.vertices = {1, SIDE * SIDE - 2, TULLE_NONE, TULLE_NONE},
                               .weights = {1.0, -1.0, 0.0, 0.0},
                               .normal = {0.0, 0.0, 1.0},
                               .scale = 50.0,
                               .side = 1};
    assert_int_equal(run_factor(&system, factor, &matrix, 1).dropped_terms, 1);
    double const apart = measure_residual(&system, factor, &matrix, 1);
    cholesky_term split[TERMS + 1];
    memcpy(split, terms, sizeof terms);
    split[0].vertices[1] = TULLE_NONE;
    split[TERMS] = terms[0];
    split[TERMS].vertices[0] = TULLE_NONE;
    matrix.terms = split;
    matrix.term_count = TERMS + 1;
    double const as_sides = measure_residual(&system, factor, &matrix, 1);
    assert_true(apart > 1e-3);
    assert_true(as_sides < RESIDUAL(100.0));
    free(shifts);
    sparse_cholesky_destroy(&system.heap, factor);
    destroy_system(&system);
}

/* Every width and number of threads gives the same bits. */
static void test_bits(void **state) {
    (void)state;
    test_system system = make_system(make_grid(45, 38, true), 100.0, 12);
    sparse_cholesky *const factor = build_factor(&system);
    cholesky_matrix const matrix = get_matrix(&system);
    size_t const size = 3 * system.matrix.row_count;
    double *const r = calloc(size, sizeof(double)), *const z = calloc(size, sizeof(double));
    double *const first = malloc(size * sizeof(double));
    uint64_t random = 3;
    for (size_t i = 0; i < size; i++) r[i] = random_signed(&random);
    kernel_target const usual = kernel_target_get();
    bool has_first = false;
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (int threads = 1; threads <= 5; threads += 2) {
            run_factor(&system, factor, &matrix, threads);
            solve(factor, size, r, z, threads);
            if (!has_first) memcpy(first, z, size * sizeof(double));
            has_first = true;
            assert_memory_equal(first, z, size * sizeof(double));
        }
    }
    kernel_target_force(usual);
    free(r), free(z), free(first);
    sparse_cholesky_destroy(&system.heap, factor);
    destroy_system(&system);
}

/* Whatever the matrix is, the factor is positive definite and finite. */
static void test_breakdown(void **state) {
    (void)state;
    test_system system = make_system(make_grid(15, 15, false), 10.0, 7);
    sparse_cholesky *const factor = build_factor(&system);
    cholesky_matrix const matrix = get_matrix(&system);
    size_t const size = 3 * system.matrix.row_count;
    double *const r = calloc(size, sizeof(double)), *const z = calloc(size, sizeof(double));
    uint64_t random = 3;
    for (int kind = 0; kind < 3; kind++) {
        fill_matrix(&system, 10.0, 7);
        for (size_t v = 0; v < system.matrix.row_count; v += 13) {
            double *const block =
                system.matrix.values + 9 * (size_t)system.matrix.diagonal_positions[v];
            if (kind == 0) block[0] = -1.0;
            if (kind == 1) memset(block, 0, 9 * sizeof(double));
            if (kind == 2) block[0] = block[4] = block[8] = 1e-7 * block[0];
        }
        assert_true(run_factor(&system, factor, &matrix, 1).raised_pivots > 0);
        for (int i = 0; i < 20; i++) {
            for (size_t k = 0; k < size; k++) r[k] = random_signed(&random);
            solve(factor, size, r, z, 1);
            double power = 0.0;
            for (size_t k = 0; k < size; k++) power += r[k] * z[k];
            if (isfinite(power)) assert_true(power > 0.0);
        }
    }
    free(r), free(z);
    sparse_cholesky_destroy(&system.heap, factor);
    destroy_system(&system);
}

typedef struct failing_heap {
    size_t left;
} failing_heap;
static void *allocate_or_fail(void *context, size_t bytes) {
    failing_heap *const heap = context;
    if (heap->left-- == 0) {
        heap->left = 0;
        return NULL;
    }
    return malloc(bytes);
}
static void release_it(void *context, void *pointer, size_t bytes) {
    (void)context, (void)bytes;
    free(pointer);
}

static void test_allocation_failures(void **state) {
    (void)state;
    test_system system = make_system(make_grid(12, 12, false), 10.0, 7);
    block_pattern const pattern = {system.matrix.row_begin, system.matrix.columns};
    cholesky_term const term = {.vertices = {0, 1, TULLE_NONE, TULLE_NONE},
                                .weights = {1.0, -1.0, 0.0, 0.0},
                                .normal = {1.0, 0.0, 0.0},
                                .scale = 1.0,
                                .side = 1};
    cholesky_matrix matrix = get_matrix(&system);
    matrix.terms = &term;
    matrix.term_count = 1;
    bool has_worked = false;
    size_t failures = 0;
    for (size_t left = 0; !has_worked && left < 1000; left++) {
        failing_heap failing = {left};
        memory heap = memory_make((tulle_allocator){
            .allocate = allocate_or_fail, .release = release_it, .context = &failing});
        sparse_cholesky *const factor =
            sparse_cholesky_build(&heap, system.matrix.row_count, pattern, system.mesh.positions);
        arena scratch = arena_make(&heap);
        cholesky_report report;
        if (factor) {
            tulle_status const status =
                sparse_cholesky_factor(factor, &matrix, 1, &scratch, &report);
            has_worked = status == TULLE_OK;
            assert_true(has_worked || status == TULLE_ERROR_OUT_OF_MEMORY);
        }
        failures += !has_worked;
        arena_destroy(&scratch);
        sparse_cholesky_destroy(&heap, factor);
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(has_worked);
    assert_true(failures > 20);
    destroy_system(&system);
}

/* ---- as a preconditioner ---- */

typedef struct solve_context {
    const test_system *system;
    const cholesky_matrix *matrix;
} solve_context;
static void apply_matrix(void *context, const double *x, double *y) {
    const solve_context *const work = context;
    multiply(work->system, work->matrix, x, y);
}
/* The factor knows nothing of ten stiff rows: conjugate gradients find the same solution in far
 * fewer iterations, the residual being measured in the same way. */
static void test_preconditioner(void **state) {
    (void)state;
    enum { SIDE = 40, SIZE = 3 * SIDE * SIDE, TERMS = 10 };
    test_system system = make_system(make_grid(SIDE, SIDE, false), 1000.0, 6);
    for (size_t v = 0; v < SIDE; v++) system.is_fixed[v] = 1;
    sparse_cholesky *const factor = build_factor(&system);
    cholesky_matrix matrix = get_matrix(&system);
    run_factor(&system, factor, &matrix, 2);
    cholesky_term terms[TERMS];
    for (uint32_t t = 0; t < TERMS; t++)
        terms[t] = (cholesky_term){
            .vertices = {SIDE + 5 * t, SIDE * SIDE - 9 * t - 1, TULLE_NONE, TULLE_NONE},
            .weights = {1.0, -1.0, 0.0, 0.0},
            .normal = {0.0, 0.6, 0.8},
            .scale = 500.0};
    matrix.terms = terms;
    matrix.term_count = TERMS;
    double *const b = malloc(SIZE * sizeof(double));
    double *const diagonal = malloc(3 * SIZE * sizeof(double));
    double *const plain = calloc(SIZE, sizeof(double)), *const x = calloc(SIZE, sizeof(double));
    uint64_t random = 3;
    for (size_t i = 0; i < SIZE; i++) b[i] = random_signed(&random);
    block_matrix_get_diagonal(&system.matrix, diagonal);
    solve_context context = {&system, &matrix};
    conjugate_gradients_problem problem = {.vertex_count = SIDE * SIDE,
                                           .apply = apply_matrix,
                                           .apply_context = &context,
                                           .right_hand_side = b,
                                           .diagonal = diagonal,
                                           .is_fixed = system.is_fixed,
                                           .tolerance = 1e-9,
                                           .max_iterations = 3000,
                                           .threads = 2};
    arena scratch = arena_make(&system.heap);
    conjugate_gradients_result slow, quick;
    assert_int_equal(conjugate_gradients_solve(&problem, plain, &scratch, &slow), TULLE_OK);
    problem.reference = slow.reference;
    single_system single;
    assert_true(single_system_make(&system.matrix, terms, TERMS, 2, &scratch, &single));
    assert_int_equal(single.apart_count, TERMS);
    assert_int_equal(single_solve(&problem, &single, factor, x, &scratch, &quick), TULLE_OK);
    assert_int_equal(slow.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_int_equal(quick.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_true(quick.reference == slow.reference && quick.residual <= 1e-9);
    assert_in_range(quick.iterations, 2, 40);
    assert_true(slow.iterations > 5 * quick.iterations);
    double largest = 0.0, difference = 0.0;
    for (size_t i = 0; i < SIZE; i++) {
        largest = fmax(largest, fabs(plain[i]));
        difference = fmax(difference, fabs(plain[i] - x[i]));
    }
    assert_true(difference < 1e-6 * largest);
    arena_destroy(&scratch);
    free(b), free(diagonal), free(plain), free(x);
    sparse_cholesky_destroy(&system.heap, factor);
    destroy_system(&system);
}

/* Single precision with residuals in double ends at the same residual as double precision, far
 * under what single precision can tell; the same bits for every width and number of threads. */
static void test_single_solve(void **state) {
    (void)state;
    enum { SIDE = 33, SIZE = 3 * SIDE * SIDE, TERMS = 12 };
    test_system system = make_system(make_grid(SIDE, SIDE, true), 300.0, 4);
    for (size_t v = 0; v < SIDE; v++) system.is_fixed[7 * v] = 1;
    cholesky_matrix matrix = get_matrix(&system);
    cholesky_term terms[TERMS];
    for (uint32_t t = 0; t < TERMS; t++) /* every other one between vertices far apart */
        terms[t] =
            (cholesky_term){.vertices = {40 + t, t % 2 ? 41 + t : 700 + t, TULLE_NONE, TULLE_NONE},
                            .weights = {1.0, -0.7, 0.0, 0.0},
                            .normal = {0.48, 0.6, 0.64},
                            .scale = 90.0};
    matrix.terms = terms;
    matrix.term_count = TERMS;
    double *const b = calloc(SIZE, sizeof(double)), *const x = calloc(SIZE, sizeof(double));
    double *const first = calloc(SIZE, sizeof(double));
    double *const plain = calloc(SIZE, sizeof(double));
    double *const diagonal = calloc(3 * SIZE, sizeof(double));
    uint64_t random = 3;
    for (size_t i = 0; i < SIZE; i++) b[i] = random_signed(&random);
    block_matrix_get_diagonal(&system.matrix, diagonal);
    solve_context context = {&system, &matrix};
    conjugate_gradients_problem problem = {.vertex_count = SIDE * SIDE,
                                           .apply = apply_matrix,
                                           .apply_context = &context,
                                           .right_hand_side = b,
                                           .diagonal = diagonal,
                                           .is_fixed = system.is_fixed,
                                           .tolerance = 1e-10,
                                           .max_iterations = 5000};
    arena scratch = arena_make(&system.heap);
    conjugate_gradients_result result;
    assert_int_equal(conjugate_gradients_solve(&problem, plain, &scratch, &result), TULLE_OK);
    problem.reference = result.reference;
    kernel_target const usual = kernel_target_get();
    bool has_first = false;
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (problem.threads = 1; problem.threads <= 4; problem.threads += 3) {
            single_system single;
            assert_true(single_system_make(&system.matrix, terms, TERMS, problem.threads, &scratch,
                                           &single));
            assert_int_equal(single.apart_count, TERMS / 2);
            memset(x, 0, SIZE * sizeof(double));
            assert_int_equal(single_solve(&problem, &single, NULL, x, &scratch, &result), TULLE_OK);
            assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
            assert_true(result.residual <= 1e-10 && result.iterations > 20);
            if (!has_first) memcpy(first, x, SIZE * sizeof(double));
            has_first = true;
            assert_memory_equal(first, x, SIZE * sizeof(double));
        }
    }
    kernel_target_force(usual);
    for (size_t i = 0; i < SIZE; i++) {
        assert_true(fabs(x[i] - plain[i]) < 1e-6);
        if (system.is_fixed[i / 3]) assert_true(x[i] == 0.0);
    }
    problem.max_iterations = 3;
    single_system single;
    assert_true(single_system_make(&system.matrix, terms, TERMS, 1, &scratch, &single));
    memset(x, 0, SIZE * sizeof(double));
    assert_int_equal(single_solve(&problem, &single, NULL, x, &scratch, &result), TULLE_OK);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_ITERATION_LIMIT);
    assert_int_equal(result.iterations, 3);
    assert_true(x[3 * 50] != 0.0);
    arena_destroy(&scratch);
    free(b), free(x), free(first), free(plain), free(diagonal);
    destroy_system(&system);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(test_meshes),           cmocka_unit_test(test_residual_is_a_measure),
        cmocka_unit_test(test_terms_and_shifts), cmocka_unit_test(test_bits),
        cmocka_unit_test(test_breakdown),        cmocka_unit_test(test_allocation_failures),
        cmocka_unit_test(test_preconditioner),   cmocka_unit_test(test_single_solve),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
