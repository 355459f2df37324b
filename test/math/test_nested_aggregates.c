/* Nested aggregates: that they are a partition at every level, their matrices against products with
 * the whole one, and their cycle against one in double precision, for grids, graphs of any kind,
 * fixed vertices and stiff terms. Here no system has a first level of a grid's blocks: isotropic
 * springs go from the end of a row around to the begin of another. */
#include "math/vec3.h"
#include "support/dense_levels.h"
#include "support/failing_heap.h"
#include "support/spring_system.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Adds a term as the first level counts it. */
static void add_expected_term(const nested_aggregates *all, const matrix_term *term,
                              const dense_level *dense) {
    const aggregate_level *const level = &all->levels[0];
    double *const weights = calloc(level->count, sizeof(double));
    bool is_joined = true;
    for (size_t k = 0; k < 4; k++)
        if (term->vertices[k] != TULLE_NONE && !all->is_fixed[term->vertices[k]])
            weights[level->parents[term->vertices[k]]] += term->weights[k];
    for (uint32_t a = 0; a < level->count; a++)
        for (uint32_t b = 0; b < level->count && weights[a] != 0.0; b++)
            is_joined &= weights[b] == 0.0 || nested_aggregates_find(level, a, b) != TULLE_NONE;
    for (uint32_t a = 0; a < level->count; a++)
        for (uint32_t b = 0; b < level->count && weights[a] != 0.0; b++)
            for (size_t i = 0; i < 9 && weights[b] != 0.0 && (is_joined || a == b); i++)
                *dense_level_get(dense, a, b, i / 3, i % 3) +=
                    weights[a] * weights[b] * term->stiffness.m[i];
    free(weights);
}

/* P^T A P of the whole matrix, and terms. */
static dense_level make_first(const spring_system *system, const spring_matrix *matrix,
                              const nested_aggregates *all) {
    const aggregate_level *const level = &all->levels[0];
    dense_level const dense = dense_level_make(level->count);
    size_t const count = system->matrix.row_count;
    double *const x = malloc(3 * count * sizeof(double)), *const y = malloc(3 * count * sizeof *x);
    spring_matrix const none = {NULL, 0};
    for (uint32_t b = 0; b < level->count; b++)
        for (size_t axis = 0; axis < 3; axis++) {
            memset(x, 0, 3 * count * sizeof(double));
            for (size_t v = 0; v < count; v++)
                x[3 * v + axis] = level->parents[v] == b && !system->is_fixed[v];
            spring_system_multiply(system, &none, x, y);
            for (size_t v = 0; v < count; v++)
                for (size_t i = 0; i < 3 && !system->is_fixed[v]; i++)
                    *dense_level_get(&dense, level->parents[v], b, i, axis) += y[3 * v + i];
        }
    for (size_t t = 0; t < matrix->term_count; t++)
        add_expected_term(all, &matrix->terms[t], &dense);
    dense_level_invert(&dense);
    free(x), free(y);
    return dense;
}

/* P^T r of the first level. */
static double *restrict_first(const nested_aggregates *all, const float *r) {
    double *const sums = calloc(3 * all->levels[0].count, sizeof(double));
    for (size_t v = 0; v < all->vertex_count; v++)
        for (size_t i = 0; i < 3 && !all->is_fixed[v]; i++)
            sums[3 * (size_t)all->levels[0].parents[v] + i] += (double)r[3 * v + i];
    return sums;
}

/* The correction is that of a cycle in double precision; with another residual it tells that the
 * cycle is symmetric. */
static void check_cycle(nested_aggregates *all, const dense_level *dense, const float *r,
                        const float *other) {
    size_t const size = 3 * all->levels[0].count;
    double *const expected = calloc(size, sizeof(double)), scale = 0.0, dot = 0.0;
    double *const sums = restrict_first(all, r), *const others = restrict_first(all, other);
    dense_levels_run_cycle(all, dense, 0, sums, expected);
    single_vectors const vectors = {.residual = (float *)r, .vertex_step = 3, .number_step = 1};
    double const found = nested_aggregates_correct(all, &vectors, 1);
    double across = 0.0, back = 0.0;
    for (size_t i = 0; i < size; i++) {
        scale = fmax(scale, fabs(expected[i]));
        dot += expected[i] * sums[i];
        across += (double)all->levels[0].correction[i] * others[i];
    }
    assert_true(found >= 0.0 && fabs(found - dot) <= 1e-4 * dot);
    for (size_t i = 0; i < size; i++)
        assert_true(fabs((double)all->levels[0].correction[i] - expected[i]) <= 1e-4 * scale);
    single_vectors const vectors2 = {
        .residual = (float *)other, .vertex_step = 3, .number_step = 1};
    double const found2 = nested_aggregates_correct(all, &vectors2, 1);
    for (size_t i = 0; i < size; i++) back += (double)all->levels[0].correction[i] * sums[i];
    assert_true(fabs(across - back) <= 1e-4 * sqrt(found * found2));
    free(expected), free(sums), free(others);
}

static void check_correction(spring_system *system, const spring_matrix *matrix) {
    size_t const size = 3 * system->matrix.row_count;
    arena scratch = arena_make(&system->heap);
    nested_aggregates *const all =
        nested_aggregates_build(&system->heap, &system->matrix, &scratch);
    assert_non_null(all);
    assert_null(all->grid);
    assert_partition(all);
    float *const r = calloc(size + 16, sizeof(float)), *const other = calloc(size + 16, sizeof *r);
    uint64_t random = 5;
    for (size_t i = 0; i < size; i++) r[i] = (float)random_signed(&random);
    for (size_t i = 0; i < size; i++) other[i] = (float)random_signed(&random);
    aggregated_system const given = {&system->matrix, system->is_fixed, matrix->terms,
                                     matrix->term_count, false};
    assert_true(nested_aggregates_set(all, &given, 2, &scratch));
    dense_level dense[AGGREGATE_LEVELS_MAX];
    for (size_t l = 0; l < all->level_count; l++) {
        if (l > 0) assert_weights(all, &system->matrix, l);
        dense[l] = l == 0 ? make_first(system, matrix, all)
                          : dense_level_make_above(&all->levels[l], &dense[l - 1]);
        assert_entries(&all->levels[l], &dense[l]);
    }
    if (all->level_count > 0) check_cycle(all, dense, r, other);
    for (size_t l = 0; l < all->level_count; l++) dense_level_destroy(&dense[l]);
    single_vectors const vectors = {.residual = r, .vertex_step = 3, .number_step = 1};
    double const found = nested_aggregates_correct(all, &vectors, 1);
    for (int threads = 1; threads <= 8; threads *= 2) {
        assert_true(nested_aggregates_set(all, &given, threads, &scratch));
        assert_true(nested_aggregates_correct(all, &vectors, threads) == found);
    }
    /* a matrix that is said to be known is not read again */
    aggregated_system known = given;
    known.is_known = true;
    for (size_t i = 0; i < BLOCK_NUMBERS * system->matrix.block_count; i++)
        system->matrix.values[i] *= 2.0;
    assert_true(nested_aggregates_set(all, &known, 2, &scratch));
    assert_true(nested_aggregates_correct(all, &vectors, 1) == found);
    assert_true(nested_aggregates_set(all, &given, 2, &scratch));
    assert_true(found == 0.0 || nested_aggregates_correct(all, &vectors, 1) != found);
    for (size_t i = 0; i < BLOCK_NUMBERS * system->matrix.block_count; i++)
        system->matrix.values[i] *= 0.5;
    assert_true(nested_aggregates_set(all, &given, 2, &scratch));
    /* a residual in planes gives the same bits */
    float *const planes = calloc(size, sizeof(float));
    for (size_t i = 0; i < size; i++) planes[i % 3 * (size / 3) + i / 3] = r[i];
    single_vectors const others = {.residual = planes, .vertex_step = 1, .number_step = size / 3};
    assert_true(nested_aggregates_correct(all, &others, 2) == found);
    free(planes);
    arena_destroy(&scratch);
    free(r), free(other);
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

/* A ribbon so long that a level above the first has over 256 aggregates, and takes two steps. */
static void test_long_ribbon(void **state) {
    (void)state;
    spring_graph const graph = spring_graph_make_grid(2600, 1, false);
    spring_system system = spring_system_make(graph, 1000.0, 9);
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_non_null(all);
    assert_true(all->level_count > 2 && all->levels[1].count > 256);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
    check_graph(spring_graph_make_grid(2600, 1, false), 1000.0, 17);
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
    assert_partition(all);
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

/* Rings around a hub, from the outer one in, joined along spokes; `is_web`: along the rings, too.
 * The hub is the last vertex; the inner ring is numbered the other way round, so that the hub's
 * aggregate is one of the last. */
static spring_graph make_rings(size_t spokes, size_t rings, bool is_web) {
    spring_graph graph = {.vertex_count = spokes * rings + 1};
    graph.edges = malloc(2 * graph.vertex_count * sizeof *graph.edges);
    assert_non_null(graph.edges);
    for (size_t ring = 0; ring < rings; ring++)
        for (size_t i = 0; i < spokes; i++) {
            size_t const last = rings - 1, next = (i + 1) % spokes;
            size_t const in = ring + 1 < last ? i : spokes - 1 - i;
            size_t const inward = ring == last ? spokes * rings : (ring + 1) * spokes + in;
            size_t const place = ring == last ? spokes - 1 - i : i;
            size_t const beside = ring == last ? spokes - 1 - next : next;
            size_t const vertex = ring * spokes + place;
            graph.edges[graph.edge_count][0] = (uint32_t)vertex;
            graph.edges[graph.edge_count++][1] = (uint32_t)inward;
            if (!is_web) continue;
            graph.edges[graph.edge_count][0] = (uint32_t)vertex;
            graph.edges[graph.edge_count++][1] = (uint32_t)(ring * spokes + beside);
        }
    return graph;
}

/* Rows with more entries than a place of one byte can name. */
static void test_long_rows(void **state) {
    (void)state;
    check_graph(make_rings(900, 2, true), 1000.0, 0);
    check_graph(make_rings(900, 2, true), 1000.0, 13);
}

/* A vertex with many neighbours does not join all that is around it to each other. */
static void test_hub(void **state) {
    (void)state;
    spring_system system = spring_system_make(make_rings(500, 14, false), 10.0, 3);
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_non_null(all);
    assert_partition(all);
    assert_true(all->level_count >= 3);
    for (size_t l = 0; l < all->level_count; l++) {
        if (l > 0) assert_weights(all, &system.matrix, l);
        assert_in_range(all->levels[l].entry_count, 1, 12 * all->levels[l].count);
    }
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
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
            aggregated_system const given = {&system.matrix, NULL, NULL, 0, false};
            assert_false(nested_aggregates_set(all, &given, 1, &scratch));
            nested_aggregates_destroy(&heap, all);
        }
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(fails > 20);
    spring_system_destroy(&system);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(test_grids),       cmocka_unit_test(test_large_grid),
        cmocka_unit_test(test_long_ribbon), cmocka_unit_test(test_pieces),
        cmocka_unit_test(test_graphs),      cmocka_unit_test(test_small),
        cmocka_unit_test(test_memory),      cmocka_unit_test(test_long_rows),
        cmocka_unit_test(test_hub),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
