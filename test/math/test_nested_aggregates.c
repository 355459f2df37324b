/* Nested aggregates: that they are a partition at every level, and their correction against the
 * formula with the whole matrix, for grids, graphs of any kind, fixed vertices and stiff terms. */
#include "math/nested_aggregates.h"
#include "math/vec3.h"
#include "support/failing_heap.h"
#include "support/spring_system.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The aggregate of each vertex at a level. */
static uint32_t *find_ancestors(const nested_aggregates *all, size_t level) {
    uint32_t *const ancestors = malloc(all->vertex_count * sizeof(uint32_t));
    for (size_t v = 0; v < all->vertex_count; v++) {
        ancestors[v] = all->levels[0].parents[v];
        for (size_t l = 1; l <= level; l++) ancestors[v] = all->levels[l].parents[ancestors[v]];
    }
    return ancestors;
}

static void check_partition(const nested_aggregates *all) {
    size_t count = all->vertex_count;
    for (size_t l = 0; l < all->level_count; l++) {
        const aggregate_level *const level = &all->levels[l];
        assert_int_equal(level->member_count, count);
        assert_int_equal(level->member_begin[0], 0);
        assert_int_equal(level->member_begin[level->count], count);
        size_t alone = 0; /* members that have an aggregate to themselves */
        for (size_t a = 0; a < level->count; a++) {
            assert_true(level->member_begin[a] < level->member_begin[a + 1]);
            alone += level->member_begin[a] + 1 == level->member_begin[a + 1];
            for (uint32_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++) {
                assert_int_equal(level->parents[level->members[i]], a);
                if (i > level->member_begin[a])
                    assert_true(level->members[i] > level->members[i - 1]);
            }
        }
        assert_true(2 * (level->count - alone) <= count - alone);
        count = level->count;
    }
}

/* G of one aggregate, from products of the whole matrix: 9 numbers. */
static void find_block(const spring_system *system, const spring_matrix *matrix,
                       const uint32_t *ancestors, uint32_t aggregate, double *block) {
    size_t const count = system->matrix.row_count;
    double *const x = malloc(3 * count * sizeof(double)), *const y = malloc(3 * count * sizeof *x);
    memset(block, 0, 9 * sizeof(double));
    for (size_t axis = 0; axis < 3; axis++) {
        memset(x, 0, 3 * count * sizeof(double));
        for (size_t v = 0; v < count; v++) x[3 * v + axis] = ancestors[v] == aggregate;
        spring_system_multiply(system, matrix, x, y);
        for (size_t v = 0; v < count; v++)
            for (size_t i = 0; i < 3 && ancestors[v] == aggregate; i++)
                block[3 * axis + i] += y[3 * v + i];
    }
    free(x), free(y);
}

/* Adds P G^-1 P^T r of a level to z; returns r . that. G z = r is checked rather than solved. */
static double check_level(const spring_system *system, const spring_matrix *matrix,
                          const nested_aggregates *all, size_t l, const float *r, double *z) {
    const aggregate_level *const level = &all->levels[l];
    uint32_t *const ancestors = find_ancestors(all, l);
    double dot = 0.0;
    for (uint32_t a = 0; a < level->count; a++) {
        double sum[3] = {0.0, 0.0, 0.0}, block[9], own[3], largest = 0.0;
        for (size_t v = 0; v < all->vertex_count; v++)
            for (size_t i = 0; i < 3 && ancestors[v] == a && !system->is_fixed[v]; i++)
                sum[i] += (double)r[3 * v + i];
        find_block(system, matrix, ancestors, a, block);
        for (size_t i = 0; i < 3; i++) {
            own[i] = 0.0;
            for (size_t j = 0; j < 3; j++)
                own[i] += (double)level->inverse[9 * a + 3 * j + i] * sum[j];
            largest = fmax(largest, fabs(sum[i]));
        }
        bool has_free = false;
        for (size_t v = 0; v < all->vertex_count; v++)
            has_free |= ancestors[v] == a && !system->is_fixed[v];
        for (size_t i = 0; i < 3 && has_free; i++) {
            double const back = block[i] * own[0] + block[3 + i] * own[1] + block[6 + i] * own[2];
            assert_true(fabs(back - sum[i]) < 1e-4 * (largest + 1e-6));
        }
        for (size_t v = 0; v < all->vertex_count; v++)
            for (size_t i = 0; i < 3 && ancestors[v] == a; i++) z[3 * v + i] += own[i];
        for (size_t i = 0; i < 3; i++) dot += own[i] * sum[i];
    }
    free(ancestors);
    return dot;
}

static void check_correction(spring_system *system, const spring_matrix *matrix) {
    size_t const size = 3 * system->matrix.row_count;
    arena scratch = arena_make(&system->heap);
    nested_aggregates *const all =
        nested_aggregates_build(&system->heap, &system->matrix, &scratch);
    assert_non_null(all);
    check_partition(all);
    float *const r = calloc(size + 16, sizeof(float));
    double *const expected = calloc(size, sizeof(double));
    uint64_t random = 5;
    for (size_t i = 0; i < size; i++) r[i] = (float)random_signed(&random);
    assert_true(nested_aggregates_set_matrix(all, &system->matrix, system->is_fixed, 2, &scratch));
    nested_aggregates_set_terms(all, matrix->terms, matrix->term_count, 2);
    double dot = 0.0, scale = 0.0;
    for (size_t l = 0; l < all->level_count; l++)
        dot += check_level(system, matrix, all, l, r, expected);
    single_vectors const vectors = {.residual = r, .vertex_step = 3, .number_step = 1};
    double const found = nested_aggregates_correct(all, &vectors, 1);
    assert_true(found >= 0.0 && fabs(found - dot) <= 1e-5 * dot);
    for (size_t i = 0; i < size; i++) scale = fmax(scale, fabs(expected[i]));
    for (size_t i = 0; i < size && all->level_count > 0; i++) {
        const aggregate_level *const first = &all->levels[0];
        double const value = (double)first->correction[3 * (size_t)first->parents[i / 3] + i % 3];
        assert_true(fabs(value - expected[i]) <= 1e-5 * scale);
    }
    for (int threads = 1; threads <= 8; threads *= 2) {
        assert_true(nested_aggregates_set_matrix(all, &system->matrix, system->is_fixed, threads,
                                                 &scratch));
        nested_aggregates_set_terms(all, matrix->terms, matrix->term_count, threads);
        assert_true(nested_aggregates_correct(all, &vectors, threads) == found);
    }
    /* a residual in planes gives the same bits */
    float *const planes = calloc(size, sizeof(float));
    for (size_t i = 0; i < size; i++) planes[i % 3 * (size / 3) + i / 3] = r[i];
    single_vectors const others = {.residual = planes, .vertex_step = 1, .number_step = size / 3};
    assert_true(nested_aggregates_correct(all, &others, 2) == found);
    free(planes);
    arena_destroy(&scratch);
    free(r), free(expected);
    nested_aggregates_destroy(&system->heap, all);
}

enum { TERMS = 20 };
/* Terms of two to four vertices anywhere, on fixed ones too. */
static spring_matrix make_terms(size_t vertex_count, matrix_term *terms, uint64_t seed) {
    for (size_t t = 0; t < TERMS; t++) {
        vec3 const normal = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        terms[t].stiffness = mat3_outer(normal, normal, 1000.0);
        for (size_t k = 0; k < 4; k++) {
            double const place = 0.5 + 0.5 * random_signed(&seed);
            size_t const vertex = (size_t)(place * 0.999 * (double)vertex_count);
            terms[t].vertices[k] = k > 1 + t % 3 ? TULLE_NONE : (uint32_t)vertex;
            terms[t].weights[k] = k == 0 ? 1.0 : -0.4;
        }
    }
    return (spring_matrix){terms, TERMS};
}

static void check_graph(spring_graph graph, double stiffness, size_t fixed_every) {
    spring_system system = spring_system_make(graph, stiffness, 9);
    for (size_t v = 0; fixed_every > 0 && v < graph.vertex_count; v += fixed_every)
        system.is_fixed[v] = 1;
    spring_matrix const none = {NULL, 0};
    check_correction(&system, &none);
    matrix_term terms[TERMS];
    spring_matrix const matrix = make_terms(graph.vertex_count, terms, 17);
    check_correction(&system, &matrix);
    spring_system_destroy(&system);
}

static void test_grids(void **state) {
    (void)state;
    check_graph(spring_graph_make_grid(24, 24, false), 1000.0, 0);
    check_graph(spring_graph_make_grid(30, 17, true), 1000.0, 11);
    check_graph(spring_graph_make_grid(200, 2, false), 1e5, 3);
}

/* A sheet of several chunks: the first level has 400 aggregates. */
static void test_large_grid(void **state) {
    (void)state;
    check_graph(spring_graph_make_grid(60, 60, false), 1000.0, 31);
}

/* Pieces that can join no other do not keep the rest from coarser levels. */
static void test_pieces(void **state) {
    (void)state;
    enum { SIDE = 40, ALONE = 2000 };
    spring_graph graph = spring_graph_make_grid(SIDE, SIDE, false);
    graph.vertex_count += ALONE;
    spring_system system = spring_system_make(graph, 10.0, 2);
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_non_null(all);
    check_partition(all);
    assert_true(all->level_count >= 2);
    size_t const least = all->levels[all->level_count - 1].count - ALONE;
    assert_in_range(least, 1, SIDE * SIDE / 20);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
}

static void test_graphs(void **state) {
    (void)state;
    check_graph(spring_graph_make_random(300, 500, 3), 100.0, 7);
    check_graph(spring_graph_make_random(120, 30, 4), 100.0, 0); /* most pieces are one vertex */
    check_graph(spring_graph_make_random(60, 900, 5), 100.0, 2);
}

/* Where all is fixed, or there is next to nothing to put together. */
static void test_small(void **state) {
    (void)state;
    check_graph(spring_graph_make_grid(2, 2, false), 10.0, 0);
    check_graph(spring_graph_make_grid(3, 3, false), 10.0, 1);
    check_graph(spring_graph_make_grid(7, 1, false), 10.0, 2);
}

/* Whichever allocation fails, all is given back. */
static void test_memory(void **state) {
    (void)state;
    spring_system system = spring_system_make(spring_graph_make_grid(20, 9, false), 10.0, 1);
    nested_aggregates *all = NULL;
    int fails = 0;
    for (; !all; fails++) {
        int left = fails;
        memory heap = failing_heap_make(&left);
        arena scratch = arena_make(&heap);
        all = nested_aggregates_build(&heap, &system.matrix, &scratch);
        arena_destroy(&scratch);
        if (all) {
            left = 0;
            assert_false(nested_aggregates_set_matrix(all, &system.matrix, NULL, 1, &scratch));
            nested_aggregates_destroy(&heap, all);
        }
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(fails > 20);
    spring_system_destroy(&system);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(test_grids),  cmocka_unit_test(test_large_grid),
        cmocka_unit_test(test_pieces), cmocka_unit_test(test_graphs),
        cmocka_unit_test(test_small),  cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
