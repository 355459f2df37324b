/* Sparse Cholesky factors against dense arithmetic, on meshes of all kinds. */
#include "base/hash.h"
#include "math/kernel_target.h"
#include "math/vec3.h"
#include "support/spring_system.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void solve(sparse_cholesky *factor, size_t size, const double *r, double *z, int threads) {
    float *const single = calloc(2 * size, sizeof(float)), *const result = single + size;
    for (size_t i = 0; i < size; i++) single[i] = (float)r[i];
    sparse_cholesky_solve(factor, single, result, threads);
    for (size_t i = 0; i < size; i++) z[i] = (double)result[i];
    free(single);
}

/* Solves for a random right-hand side and gives the residual over it. */
static double measure_residual(const spring_system *system, sparse_cholesky *factor,
                               const cholesky_matrix *matrix, int threads) {
    size_t const size = 3 * system->matrix.row_count;
    double *const r = calloc(size, sizeof(double)), *const z = calloc(size, sizeof(double));
    double *const image = malloc(size * sizeof(double));
    uint64_t random = 5;
    for (size_t i = 0; i < size; i++) r[i] = random_signed(&random);
    solve(factor, size, r, z, threads);
    spring_system_multiply(system, matrix, z, image);
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

static void check_graph(spring_graph mesh, double stiffness, uint64_t seed) {
    spring_system system = spring_system_make(mesh, stiffness, seed);
    size_t const held = system.heap.bytes_held;
    sparse_cholesky *const factor = spring_system_build_factor(&system);
    assert_true(system.heap.bytes_held >= held + sparse_cholesky_measure(factor).bytes);
    cholesky_matrix const matrix = spring_system_get_matrix(&system);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t v = 0; v < mesh.vertex_count; v++) system.is_fixed[v] = pass == 1 && v % 7 == 3;
        spring_system_fill(&system, stiffness, seed + (uint64_t)pass);
        assert_int_equal(spring_system_run_factor(&system, factor, &matrix, 1).raised_pivots, 0);
        double const residual = measure_residual(&system, factor, &matrix, 1);
        if (!(residual < RESIDUAL(stiffness)))
            fail_msg("%zu vertices, %zu edges: residual %g", mesh.vertex_count, mesh.edge_count,
                     residual);
    }
    sparse_cholesky_destroy(&system.heap, factor);
    assert_int_equal(system.heap.bytes_held, held);
    spring_system_destroy(&system);
}

static void test_meshes(void **state) {
    (void)state;
    check_graph(spring_graph_make_grid(1, 1, false), 10.0, 1);
    check_graph(spring_graph_make_grid(2, 1, false), 10.0, 2);
    check_graph(spring_graph_make_grid(2, 2, false), 10.0, 3);
    for (size_t n = 3; n < 30; n += 4)
        check_graph(spring_graph_make_grid(n, n + 3, n % 2 == 0), 100.0, n);
    check_graph(spring_graph_make_grid(40, 40, true), 100.0, 4);
    check_graph(spring_graph_make_grid(300, 2, false), 100.0, 5);
    for (uint64_t seed = 1; seed < 30; seed++)
        check_graph(spring_graph_make_random(5 + 7 * seed, 4 * seed * seed % 300, seed), 10.0,
                    seed);
}

/* A small change of the matrix is seen. */
static void test_residual_is_a_measure(void **state) {
    (void)state;
    spring_system system = spring_system_make(spring_graph_make_grid(20, 20, false), 100.0, 8);
    sparse_cholesky *const factor = spring_system_build_factor(&system);
    cholesky_matrix const matrix = spring_system_get_matrix(&system);
    spring_system_run_factor(&system, factor, &matrix, 1);
    system.matrix.values[9 * (size_t)system.matrix.diagonal_positions[57]] += 10.0;
    assert_true(measure_residual(&system, factor, &matrix, 1) > 1e-3);
    sparse_cholesky_destroy(&system.heap, factor);
    spring_system_destroy(&system);
}

static void test_terms_and_shifts(void **state) {
    (void)state;
    enum { SIDE = 24, TERMS = 60 };
    spring_system system = spring_system_make(spring_graph_make_grid(SIDE, SIDE, false), 30.0, 6);
    sparse_cholesky *const factor = spring_system_build_factor(&system);
    cholesky_matrix matrix = spring_system_get_matrix(&system);
    double *const shifts = calloc(system.matrix.block_count, sizeof(double));
    for (size_t v = 0; v < system.matrix.row_count; v++) {
        shifts[system.matrix.diagonal_positions[v]] = 0.1;
        system.is_fixed[v] = v % 11 == 5;
    }
    matrix.shifts[0] = shifts;
    matrix.shift_factors[0] = 2.0;
    cholesky_term terms[TERMS];
    vec3 const normal = {0.6, 0.0, 0.8}, up = {0.0, 0.0, 1.0};
    uint64_t random = 9;
    for (size_t t = 0; t < TERMS; t++) {
        uint32_t const v = (uint32_t)(t * 7 % (SIDE * (SIDE - 1)));
        uint32_t const corner = v % SIDE == SIDE - 1 ? v - 1 : v;
        terms[t] = (cholesky_term){
            .vertices = {TULLE_NONE, corner, corner + 1, corner + SIDE + 1},
            .weights = {1.0, random_signed(&random), random_signed(&random), 0.4},
            .stiffness = mat3_outer(normal, normal, 100.0 * random_uniform(&random)),
            .side = 1};
    }
    matrix.terms = terms;
    matrix.term_count = TERMS;
    cholesky_report const report = spring_system_run_factor(&system, factor, &matrix, 2);
    assert_int_equal(report.dropped_terms, 0);
    assert_int_equal(report.raised_pivots, 0);
    assert_true(measure_residual(&system, factor, &matrix, 2) < RESIDUAL(100.0));
    /* A term between far corners is outside: its sides are there each for itself. */
    terms[0] = (cholesky_term){.vertices = {1, SIDE * SIDE - 2, TULLE_NONE, TULLE_NONE},
                               .weights = {1.0, -1.0, 0.0, 0.0},
                               .stiffness = mat3_outer(up, up, 50.0),
                               .side = 1};
    assert_int_equal(spring_system_run_factor(&system, factor, &matrix, 1).dropped_terms, 1);
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
    spring_system_destroy(&system);
}

/* Every width and number of threads gives the same bits. */
static void test_bits(void **state) {
    (void)state;
    spring_system system = spring_system_make(spring_graph_make_grid(45, 38, true), 100.0, 12);
    sparse_cholesky *const factor = spring_system_build_factor(&system);
    cholesky_matrix const matrix = spring_system_get_matrix(&system);
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
            spring_system_run_factor(&system, factor, &matrix, threads);
            solve(factor, size, r, z, threads);
            if (!has_first) memcpy(first, z, size * sizeof(double));
            has_first = true;
            assert_memory_equal(first, z, size * sizeof(double));
        }
    }
    kernel_target_force(usual);
    free(r), free(z), free(first);
    sparse_cholesky_destroy(&system.heap, factor);
    spring_system_destroy(&system);
}

/* Whatever the matrix is, the factor is positive definite and finite. */
static void test_breakdown(void **state) {
    (void)state;
    spring_system system = spring_system_make(spring_graph_make_grid(15, 15, false), 10.0, 7);
    sparse_cholesky *const factor = spring_system_build_factor(&system);
    cholesky_matrix const matrix = spring_system_get_matrix(&system);
    size_t const size = 3 * system.matrix.row_count;
    double *const r = calloc(size, sizeof(double)), *const z = calloc(size, sizeof(double));
    uint64_t random = 3;
    for (int kind = 0; kind < 3; kind++) {
        spring_system_fill(&system, 10.0, 7);
        for (size_t v = 0; v < system.matrix.row_count; v += 13) {
            double *const block =
                system.matrix.values + 9 * (size_t)system.matrix.diagonal_positions[v];
            if (kind == 0) block[0] = -1.0;
            if (kind == 1) memset(block, 0, 9 * sizeof(double));
            if (kind == 2) block[0] = block[4] = block[8] = 1e-7 * block[0];
        }
        assert_true(spring_system_run_factor(&system, factor, &matrix, 1).raised_pivots > 0);
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
    spring_system_destroy(&system);
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
    spring_system system = spring_system_make(spring_graph_make_grid(12, 12, false), 10.0, 7);
    block_pattern const pattern = {system.matrix.row_begin, system.matrix.columns};
    cholesky_term const term = {.vertices = {0, 1, TULLE_NONE, TULLE_NONE},
                                .weights = {1.0, -1.0, 0.0, 0.0},
                                .stiffness = {{1.0}},
                                .side = 1};
    cholesky_matrix matrix = spring_system_get_matrix(&system);
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
    spring_system_destroy(&system);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(test_meshes),           cmocka_unit_test(test_residual_is_a_measure),
        cmocka_unit_test(test_terms_and_shifts), cmocka_unit_test(test_bits),
        cmocka_unit_test(test_breakdown),        cmocka_unit_test(test_allocation_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
