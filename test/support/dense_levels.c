/* support/dense_levels.c - see dense_levels.h. */
#include "support/dense_levels.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

dense_level dense_level_make(size_t count) {
    dense_level const dense = {count, 3 * count, calloc(9 * count * count, sizeof(double)),
                               calloc(9 * count, sizeof(double))};
    assert_true(dense.a && dense.inverse);
    return dense;
}

void dense_level_destroy(const dense_level *dense) { free(dense->a), free(dense->inverse); }

dense_level dense_level_make_above(const aggregate_level *level, const dense_level *below) {
    dense_level const dense = dense_level_make(level->count);
    const weight_list *const by = &level->of_members;
    for (uint32_t m = 0; m < level->member_count; m++)
        for (uint32_t n = 0; n < level->member_count; n++)
            for (uint32_t k = by->begin[m]; k < by->begin[m + 1]; k++)
                for (uint32_t l = by->begin[n]; l < by->begin[n + 1]; l++)
                    for (size_t i = 0; i < 9; i++)
                        *dense_level_get(&dense, by->columns[k], by->columns[l], i / 3, i % 3) +=
                            (double)by->weights[k] * (double)by->weights[l] *
                            *dense_level_get(below, m, n, i / 3, i % 3);
    dense_level_invert(&dense);
    return dense;
}

/* Cramer's rule: rows of the inverse are products of columns. */
void dense_level_invert(const dense_level *dense) {
    for (size_t a = 0; a < dense->count; a++) {
        double *const inverse = dense->inverse + 9 * a;
        double m[9], determinant = 0.0;
        for (size_t i = 0; i < 9; i++) m[i] = *dense_level_get(dense, a, a, i / 3, i % 3);
        for (size_t i = 0; i < 9; i++) {
            size_t const j = (i % 3 + 1) % 3, k = (i % 3 + 2) % 3;
            size_t const p = (i / 3 + 1) % 3, q = (i / 3 + 2) % 3;
            inverse[i] = m[3 * j + p] * m[3 * k + q] - m[3 * j + q] * m[3 * k + p];
        }
        for (size_t i = 0; i < 3; i++) determinant += m[i] * inverse[3 * i];
        for (size_t i = 0; i < 9; i++)
            inverse[i] = determinant > 0.0 ? inverse[i] / determinant : (double)(i % 4 == 0);
    }
}

double dense_level_find_largest(const dense_level *dense) {
    double largest = 0.0;
    for (size_t i = 0; i < dense->size * dense->size; i++)
        largest = fmax(largest, fabs(dense->a[i]));
    return largest;
}

/* ---- the cycle ---- */

/* A step of Jacobi's method from z, by a part of D^-1 r. */
static void take_step(const dense_level *dense, double part, const double *r, double *z) {
    double *const left = malloc(dense->size * sizeof(double));
    for (size_t i = 0; i < dense->size; i++) {
        left[i] = r[i];
        for (size_t j = 0; j < dense->size; j++) left[i] -= dense->a[i * dense->size + j] * z[j];
    }
    for (size_t a = 0; a < dense->count; a++)
        for (size_t i = 0; i < 3; i++)
            for (size_t j = 0; j < 3; j++)
                z[3 * a + i] += part * dense->inverse[9 * a + 3 * i + j] * left[3 * a + j];
    free(left);
}

void dense_levels_run_cycle(const nested_aggregates *all, const dense_level *dense, size_t l,
                            const double *r, double *z) {
    const dense_level *const own = &dense[l];
    double const part = l == 0 ? 0.5 : 0.3;
    bool const is_last = l + 1 == all->level_count;
    bool const takes_two = l > 0 && !is_last && own->count > 256;
    memset(z, 0, own->size * sizeof(double));
    take_step(own, takes_two ? 0.168 : part, r, z);
    if (takes_two) take_step(own, 0.417, r, z);
    if (is_last) {
        for (int i = 1; i < 8; i++) take_step(own, part, r, z);
        return;
    }
    const weight_list *const by = &all->levels[l + 1].of_members;
    double *const rest = calloc(dense[l + 1].size, sizeof(double));
    double *const found = calloc(dense[l + 1].size, sizeof(double));
    for (size_t m = 0; m < own->count; m++)
        for (size_t i = 0; i < 3; i++) {
            double sum = r[3 * m + i];
            for (size_t j = 0; j < own->size; j++)
                sum -= own->a[(3 * m + i) * own->size + j] * z[j];
            for (uint32_t k = by->begin[m]; k < by->begin[m + 1]; k++)
                rest[3 * (size_t)by->columns[k] + i] += (double)by->weights[k] * sum;
        }
    dense_levels_run_cycle(all, dense, l + 1, rest, found);
    for (size_t m = 0; m < own->count; m++)
        for (uint32_t k = by->begin[m]; k < by->begin[m + 1]; k++)
            for (size_t i = 0; i < 3; i++)
                z[3 * m + i] += (double)by->weights[k] * found[3 * (size_t)by->columns[k] + i];
    if (takes_two) take_step(own, 0.417, r, z);
    take_step(own, takes_two ? 0.168 : part, r, z);
    free(rest), free(found);
}

/* ---- checks ---- */

void assert_partition(const nested_aggregates *all) {
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

/* The aggregate of the level below that each vertex belongs to. */
static uint32_t *find_members(const nested_aggregates *all, size_t l) {
    uint32_t *const members = malloc(all->vertex_count * sizeof(uint32_t));
    for (uint32_t v = 0; v < all->vertex_count; v++) {
        members[v] = v;
        for (size_t below = 0; below < l; below++)
            members[v] = all->levels[below].parents[members[v]];
    }
    return members;
}

/* Which members of a level the matrix joins, each to itself, too: count * count. */
static bool *find_neighbours(const nested_aggregates *all, const block_matrix *matrix, size_t l) {
    size_t const count = all->levels[l].member_count;
    bool *const are_neighbours = calloc(count * count, sizeof(bool));
    uint32_t *const members = find_members(all, l);
    for (size_t v = 0; v < all->vertex_count; v++)
        for (uint32_t k = matrix->row_begin[v]; k < matrix->row_begin[v + 1]; k++)
            are_neighbours[members[v] * count + members[matrix->columns[k]]] = true;
    free(members);
    return are_neighbours;
}

/* The weight of an aggregate in a member: the mean over the member and its neighbours, if these are
 * 32 or fewer. */
static double find_weight(const aggregate_level *level, const bool *are_neighbours, uint32_t member,
                          uint32_t aggregate) {
    size_t const count = level->member_count;
    size_t all = 0, of_aggregate = 0;
    for (uint32_t other = 0; other < count; other++) {
        if (!are_neighbours[member * count + other]) continue;
        all++;
        of_aggregate += level->parents[other] == aggregate;
    }
    if (all > 33) return level->parents[member] == aggregate ? 1.0 : 0.0;
    return (double)of_aggregate / (double)all;
}

void assert_weights(const nested_aggregates *all, const block_matrix *matrix, size_t l) {
    const aggregate_level *const level = &all->levels[l];
    bool *const are_neighbours = find_neighbours(all, matrix, l);
    const weight_list *const by = &level->of_members, *const across = &level->of_aggregates;
    assert_int_equal(by->count, across->count);
    assert_int_equal(by->begin[level->member_count], by->count);
    assert_int_equal(across->begin[level->count], across->count);
    double sum_across = 0.0;
    for (uint32_t m = 0; m < level->member_count; m++) {
        double sum = 0.0;
        bool has_parent = false;
        for (uint32_t k = by->begin[m]; k < by->begin[m + 1]; k++) {
            uint32_t const a = by->columns[k];
            sum += (double)by->weights[k];
            assert_true(fabs((double)by->weights[k] - find_weight(level, are_neighbours, m, a)) <
                        1e-6);
            has_parent |= a == level->parents[m];
            bool is_found = false;
            for (uint32_t i = across->begin[a]; i < across->begin[a + 1]; i++)
                is_found |= across->columns[i] == m && across->weights[i] == by->weights[k];
            assert_true(is_found);
        }
        assert_true(has_parent && fabs(sum - 1.0) < 1e-6);
        sum_across += sum;
    }
    assert_true(fabs(sum_across - (double)level->member_count) < 1e-4);
    free(are_neighbours);
}

void assert_entries(const aggregate_level *level, const dense_level *dense) {
    static const size_t places[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    double const largest = dense_level_find_largest(dense);
    for (uint32_t a = 0; a < level->count; a++)
        for (uint32_t b = 0; b < level->count; b++) {
            uint32_t const k = nested_aggregates_find(level, a, b);
            for (size_t i = 0; i < 9; i++) {
                double const expected = *dense_level_get(dense, a, b, i / 3, i % 3);
                double const value =
                    k == TULLE_NONE ? 0.0 : (double)level->values[6 * (size_t)k + places[i]];
                assert_true(fabs(value - expected) <= 1e-6 * largest);
            }
        }
}
