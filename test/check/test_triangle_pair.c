/* triangles_intersect against the rational oracle on small grids, where every degeneracy is common,
 * and its invariance under relabelling, reflection and scaling. */
#include "support/rational_oracle.h"

#include "base/hash.h"
#include "base/timer.h"
#include "tulle/check.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static size_t scaled(size_t count) { return getenv("TULLE_TEST_LONG") ? 20 * count : count; }

typedef struct pair_case {
    double points[6][3];
    check_triangle a, b;
} pair_case;

static int random_below(uint64_t *state, int n) { return (int)(random_next(state) % (uint64_t)n); }

/* Vertices 0 .. 5 on a grid of n^3 points, or in a plane of it; b's first `shared` corners are
 * among a's, in random order. may_repeat: vertex numbers may occur twice in a triangle. */
static void make_case(pair_case *c, uint64_t *state, int n, int shared, bool may_repeat) {
    int const flat = random_below(state, 4); /* 3: a tilted plane x + y + z = const */
    bool const is_flat = random_below(state, 3) == 0;
    for (int v = 0; v < 6; v++)
        for (int k = 0; k < 3; k++) c->points[v][k] = random_below(state, n);
    for (int v = 0; v < 6 && is_flat; v++) {
        if (flat < 3)
            c->points[v][flat] = 1.0;
        else
            c->points[v][2] = 3.0 - c->points[v][0] - c->points[v][1];
    }
    uint32_t first[3] = {0, 1, 2}, second[3] = {3, 4, 5};
    for (uint32_t i = 0; i < (uint32_t)shared; i++) second[i] = i;
    if (may_repeat) {
        second[random_below(state, 3)] = second[random_below(state, 3)];
        first[random_below(state, 3)] = first[random_below(state, 3)];
    }
    int const turn_a = random_below(state, 3), turn_b = random_below(state, 3);
    bool const swap_a = random_below(state, 2), swap_b = random_below(state, 2);
    for (int i = 0; i < 3; i++) {
        c->a.vertices[i] = first[((swap_a ? 2 - i : i) + turn_a) % 3];
        c->b.vertices[i] = second[((swap_b ? 2 - i : i) + turn_b) % 3];
        c->a.corners[i] = c->points[c->a.vertices[i]];
        c->b.corners[i] = c->points[c->b.vertices[i]];
    }
}

static void print_case(const pair_case *c) {
    for (int i = 0; i < 3; i++)
        print_error("a %u (%g %g %g)   b %u (%g %g %g)\n", c->a.vertices[i], c->a.corners[i][0],
                    c->a.corners[i][1], c->a.corners[i][2], c->b.vertices[i], c->b.corners[i][0],
                    c->b.corners[i][1], c->b.corners[i][2]);
}

static void compare_with_oracle(int shared, bool may_repeat, size_t count) {
    uint64_t state = 10 + (uint64_t)shared + 7 * may_repeat;
    size_t positive = 0;
    double const start = timer_now();
    for (size_t k = 0; k < count; k++) {
        pair_case c;
        make_case(&c, &state, 2 + (int)(k % 4), shared, may_repeat);
        bool const expected = oracle_triangles_intersect(&c.a, &c.b, true);
        if (triangles_intersect(&c.a, &c.b, true, NULL) != expected ||
            triangles_intersect(&c.b, &c.a, true, NULL) != expected) {
            print_case(&c);
            fail_msg("%d shared, case %zu: expected %d", shared, k, expected);
        }
        assert_int_equal(tulle_check_triangle_pair(c.points[0], c.a.vertices, c.b.vertices, true),
                         expected);
        positive += expected;
    }
    print_message("%d shared%s: %zu pairs, %zu intersect, %.2f s\n", shared,
                  may_repeat ? ", repeated vertices" : "", count, positive, timer_now() - start);
    if (shared < 3) assert_in_range(positive, count / 50, count - count / 50);
}

/* Two triangles that share vertex 0 and nothing else. */
static void public_test_of_a_pair_has_its_own_rules(void **unused) {
    (void)unused;
    double points[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 1}, {0, -1, 1}};
    uint32_t const first[3] = {0, 1, 2}, second[3] = {3, 0, 4};
    assert_false(tulle_check_triangle_pair(points[0], first, second, 1));
    assert_true(tulle_check_triangle_pair(points[0], first, second, 0));
    points[4][1] = (double)NAN;
    assert_true(tulle_check_triangle_pair(points[0], first, second, 1));
}

static void grids_agree_without_shared_vertex(void **unused) {
    (void)unused;
    compare_with_oracle(0, false, scaled(60000));
}
static void grids_agree_with_one_shared_vertex(void **unused) {
    (void)unused;
    compare_with_oracle(1, false, scaled(40000));
}
static void grids_agree_with_a_shared_edge(void **unused) {
    (void)unused;
    compare_with_oracle(2, false, scaled(30000));
}
static void grids_agree_with_the_same_vertices(void **unused) {
    (void)unused;
    compare_with_oracle(3, false, 1000);
}
static void grids_agree_with_repeated_vertices(void **unused) {
    (void)unused;
    for (int shared = 0; shared < 3; shared++) compare_with_oracle(shared, true, scaled(10000));
}

/* Points moved by a few last bits out of a grid: nearly degenerate rather than degenerate. */
static void perturbed_grids_agree(void **unused) {
    (void)unused;
    uint64_t state = 99;
    size_t exact = 0, positive = 0;
    for (size_t k = 0; k < scaled(20000); k++) {
        pair_case c;
        make_case(&c, &state, 3, (int)(k % 3), false);
        for (int v = 0; v < 6; v++)
            for (int axis = 0; axis < 3; axis++)
                c.points[v][axis] =
                    1.0 / 3.0 + c.points[v][axis] * 0.1 + 0x1p-54 * (random_below(&state, 3) - 1);
        bool const expected = oracle_triangles_intersect(&c.a, &c.b, true);
        if (triangles_intersect(&c.a, &c.b, true, &exact) != expected) {
            print_case(&c);
            fail_msg("case %zu: expected %d", k, expected);
        }
        positive += expected;
    }
    print_message("perturbed: %zu intersect, %zu undecided by the filter\n", positive, exact);
    assert_true(exact > 1000);
}

/* Neither the order of corners nor exact motions of space change the answer. */
static void answer_is_invariant(void **unused) {
    (void)unused;
    static const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    uint64_t state = 5;
    for (size_t k = 0; k < scaled(20000); k++) {
        pair_case c;
        make_case(&c, &state, 4, (int)(k % 3), false);
        bool const expected = triangles_intersect(&c.a, &c.b, true, NULL);
        for (int o = 0; o < 36; o++) {
            check_triangle a, b;
            for (int i = 0; i < 3; i++) {
                a.vertices[i] = c.a.vertices[orders[o / 6][i]];
                b.vertices[i] = c.b.vertices[orders[o % 6][i]];
                a.corners[i] = c.a.corners[orders[o / 6][i]];
                b.corners[i] = c.b.corners[orders[o % 6][i]];
            }
            assert_int_equal(triangles_intersect(&a, &b, true, NULL), expected);
            assert_int_equal(triangles_intersect(&b, &a, true, NULL), expected);
        }
        pair_case moved = c;
        int const exponent = random_below(&state, 1800) - 900;
        const int *const axes = orders[k % 6];
        for (int v = 0; v < 6; v++)
            for (int axis = 0; axis < 3; axis++)
                moved.points[v][axis] =
                    ldexp(axis == 1 ? -c.points[v][axes[axis]] : c.points[v][axes[axis]], exponent);
        for (int i = 0; i < 3; i++) {
            moved.a.corners[i] = moved.points[c.a.vertices[i]];
            moved.b.corners[i] = moved.points[c.b.vertices[i]];
        }
        assert_int_equal(triangles_intersect(&moved.a, &moved.b, true, NULL), expected);
    }
}

typedef struct known_case {
    const char *name;
    double a[9], b[9];
    int shared; /* the first corners are the same vertices */
    bool expected;
} known_case;

static const known_case known_cases[] = {
    {"crossing", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {.5, .5, -1, .5, .5, 1, 3, 3, 1}, 0, true},
    {"parallel planes", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {0, 0, 1, 2, 0, 1, 0, 2, 1}, 0, false},
    {"tip touches inside", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {.5, .5, 0, 1, 1, 1, 0, 1, 1}, 0, true},
    {"tip touches corner", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {0, 0, 0, 1, 1, 1, 0, 1, 1}, 0, true},
    {"tip beside", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {1.5, 1, 0, 1, 1, 1, 0, 1, 1}, 0, false},
    {"edge touches edge", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {1, 0, 1, 1, 0, -1, 1, -1, 0}, 0, true},
    {"coplanar inside", {0, 0, 0, 8, 0, 0, 0, 8, 0}, {1, 1, 0, 2, 1, 0, 1, 2, 0}, 0, true},
    {"coplanar apart", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {2, 2, 0, 3, 2, 0, 2, 3, 0}, 0, false},
    {"coplanar touching", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {1, 1, 0, 3, 1, 0, 1, 3, 0}, 0, true},
    {"point inside", {0, 0, 0, 4, 0, 0, 0, 4, 0}, {1, 1, 0, 1, 1, 0, 1, 1, 0}, 0, true},
    {"segment through", {0, 0, 0, 4, 0, 0, 0, 4, 0}, {1, 1, -1, 1, 1, 1, 1, 1, 0}, 0, true},
    {"neighbours, flat", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0, 1, -1, 0}, 2, false},
    {"neighbours, folded", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0, 1, 1, 0}, 2, true},
    {"neighbours, almost", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0, 1, 1, 1e-300}, 2, false},
    {"fan, apart", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, -1, 0, 0, 0, -1, 0}, 1, false},
    {"fan, overlapping", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 2, 1, 0, -1, 2, 0}, 1, true},
    {"fan, edge on edge", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 2, 0, 0, 0, -1, 0}, 1, true},
    {"fan, through", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {0, 0, 0, 1, 1, 1, 1, 1, -1}, 1, true},
    {"fan, above", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {0, 0, 0, 1, 1, 1, 1, 2, 1}, 1, false},
    {"same vertices", {0, 0, 0, 2, 0, 0, 0, 2, 0}, {0, 0, 0, 2, 0, 0, 0, 2, 0}, 3, true},
};

static void known_cases_hold(void **unused) {
    (void)unused;
    for (size_t k = 0; k < sizeof known_cases / sizeof known_cases[0]; k++) {
        const known_case *const known = &known_cases[k];
        check_triangle a, b;
        for (uint32_t i = 0; i < 3; i++) {
            a.corners[i] = &known->a[3 * i];
            b.corners[i] = &known->b[3 * i];
            a.vertices[i] = i;
            b.vertices[i] = (int)i < known->shared ? i : i + 3;
        }
        if (triangles_intersect(&a, &b, true, NULL) != known->expected)
            fail_msg("%s: expected %d", known->name, known->expected);
        assert_int_equal(oracle_triangles_intersect(&a, &b, true), known->expected);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_cases_hold),
        cmocka_unit_test(public_test_of_a_pair_has_its_own_rules),
        cmocka_unit_test(grids_agree_without_shared_vertex),
        cmocka_unit_test(grids_agree_with_one_shared_vertex),
        cmocka_unit_test(grids_agree_with_a_shared_edge),
        cmocka_unit_test(grids_agree_with_the_same_vertices),
        cmocka_unit_test(grids_agree_with_repeated_vertices),
        cmocka_unit_test(perturbed_grids_agree),
        cmocka_unit_test(answer_is_invariant),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
