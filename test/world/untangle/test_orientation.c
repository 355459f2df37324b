/* Orientation: for sheets that do not intersect every rule says what geometry says, or nothing;
 * after a vertex or a whole sheet has passed through, history and neighbours remember the side. */
#include "base/hash.h"
#include "support/contact_world.h"
#include "support/test_support.h"
#include "world/untangle/orientation.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* A turned sheet over a plane, both rough by 0.1 mm, with its rows found. */
static void make_sheet(contact_world *world, uint64_t *random) {
    make_coarse_sheet_over_cloth(world, random);
    for (size_t i = 0; i < world->vertex_count; i++)
        world->x0[3 * i + 2] += 1e-4 * (random_uniform(random) - 0.5);
    gather_at_rest(world, TIME_STEP);
}

/* What the rows of vertices and triangles say. */
static side_history remember_rows(contact_world *world) {
    side_history history = {0};
    for (size_t r = 0; r < world->rows->rows.count; r++) {
        const contact_row *const row = &world->rows->rows.data[r];
        if (row->frame.kind != FEATURE_VERTEX_TRIANGLE) continue;
        known_side const side = {row->frame.pair.first, row->frame.pair.second, row->frame.normal};
        assert_int_equal(remember_side(&history, world->heap, side), TULLE_OK);
    }
    settle_history(&history);
    return history;
}

static oriented_pair ask_about_row(const contact_world *world, const contact_row *row,
                                   double sign) {
    vec3 point = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++)
        point = vec3_add_scaled(point, vec3_load(world->x0, row->frame.vertices[k]),
                                0.5 * fabs(row->frame.weights[k]));
    return (oriented_pair){row->frame.kind, row->frame.pair, vec3_scale(row->frame.normal, sign),
                           point};
}

/* By the first triangle of each feature. */
static orientation verify(const contact_world *world, const oriented_pair *question) {
    const topology *const topo = world->topo;
    feature_pair const pair = question->pair;
    bool const is_vertex = question->kind == FEATURE_VERTEX_TRIANGLE;
    const adjacency *const around = &topo->vertex_triangles;
    uint32_t const first = is_vertex ? around->items[around->begin[pair.first]]
                                     : topo->edge_triangles[2 * (size_t)pair.first];
    uint32_t const second = is_vertex ? pair.second : topo->edge_triangles[2 * (size_t)pair.second];
    return orient_by_triangles(topo, world->x0, first, second, question->axis);
}

static void rules_agree_with_geometry(void **state) {
    (void)state;
    uint64_t random = 31;
    size_t count = 0, by_neighbours = 0, by_history = 0;
    for (int i = 0; i < 20; i++) {
        contact_world world;
        make_sheet(&world, &random);
        side_history history = remember_rows(&world);
        for (size_t r = 0; r < world.rows->rows.count; r++) {
            int const sign = random_uniform(&random) < 0.5 ? -1 : 1;
            oriented_pair const question = ask_about_row(&world, &world.rows->rows.data[r], sign);
            if (question.kind == FEATURE_VERTEX_TRIANGLE) {
                assert_int_equal(
                    orient_by_history(world.topo, &history, question.pair, question.axis), sign);
                by_history++;
            }
            int const side = orient_by_neighbours(world.topo, world.x0, &question);
            assert_true(side == sign || side == ORIENTATION_UNDECIDED);
            assert_int_equal(verify(&world, &question), sign);
            count++;
            by_neighbours += side == sign;
        }
        ARRAY_FREE(world.heap, &history.sides);
        contact_world_destroy(&world);
    }
    print_message("%zu of %zu pairs decided by their neighbours\n", by_neighbours, count);
    assert_true(count > 5000 && by_neighbours > count / 2 && by_history > 1000);
}

/* The triangle of the plane under a point, or TULLE_NONE. */
static uint32_t find_triangle_below(const contact_world *world, vec3 point) {
    for (uint32_t t = 0; t < world->topo->triangle_count; t++) {
        const uint32_t *const corners = world->topo->triangles + 3 * (size_t)t;
        if (corners[0] < count_sheet_vertices(world)) continue;
        bool is_inside = true;
        double last = 0.0;
        for (int k = 0; k < 3; k++) {
            vec3 const a = vec3_load(world->x0, corners[k]);
            vec3 const b = vec3_load(world->x0, corners[(k + 1) % 3]);
            double const area = (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x);
            if (last * area < 0.0) is_inside = false;
            last = area;
        }
        if (is_inside) return t;
    }
    return TULLE_NONE;
}

static void raise_all_but(contact_world *world, uint32_t vertex, double height) {
    for (uint32_t k = 0; k < count_sheet_vertices(world); k++)
        if (k != vertex) world->x0[3 * k + 2] += height;
}

static bool remembers(const side_history *history, feature_pair pair) {
    for (size_t i = 0; i < history->sides.count; i++)
        if (history->sides.data[i].vertex == pair.first &&
            history->sides.data[i].triangle == pair.second)
            return true;
    return false;
}

/* The sheet slides by up to a third of a cell and sinks through the plane; or one vertex does. */
static void sides_are_remembered(void **state) {
    (void)state;
    uint64_t random = 32;
    size_t slid = 0;
    for (int i = 0; i < 20; i++) {
        contact_world world;
        make_sheet(&world, &random);
        side_history history = remember_rows(&world);
        double const dx = 0.01 * random_uniform(&random), dy = 0.01 * random_uniform(&random);
        for (size_t k = 0; k < count_sheet_vertices(&world); k++) {
            world.x0[3 * k] += dx;
            world.x0[3 * k + 1] += dy;
            world.x0[3 * k + 2] -= 5e-3;
        }
        for (uint32_t k = 0; k < count_sheet_vertices(&world); k++) {
            vec3 const point = vec3_load(world.x0, k);
            uint32_t const triangle = find_triangle_below(&world, point);
            assert_int_not_equal(triangle, TULLE_NONE);
            oriented_pair const question = {
                FEATURE_VERTEX_TRIANGLE, {k, triangle}, {0.0, 0.0, 1.0}, {point.x, point.y, 0.0}};
            slid += !remembers(&history, question.pair);
            assert_int_equal(orient_by_history(world.topo, &history, question.pair, question.axis),
                             ORIENTATION_ALONG);
            assert_int_equal(orient_by_neighbours(world.topo, world.x0, &question),
                             ORIENTATION_AGAINST);
            raise_all_but(&world, k, 7e-3);
            assert_int_equal(orient_by_neighbours(world.topo, world.x0, &question),
                             ORIENTATION_ALONG);
            raise_all_but(&world, k, -7e-3);
        }
        ARRAY_FREE(world.heap, &history.sides);
        contact_world_destroy(&world);
    }
    assert_true(slid > 300);
}

/* Four triangles in a row, each sharing an edge with the next, and vertex 9: sides that are given
 * twice count once, those that contradict one another not at all, in any order; others vote. */
static void histories_settle(void **state) {
    (void)state;
    memory heap = memory_default();
    uint32_t const triangles[12] = {0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4};
    topology topo;
    assert_int_equal(topology_build(&heap, triangles, 4, 10, &topo), TULLE_OK);
    vec3 const up = {0.0, 0.0, 1.0}, down = {0.0, 0.0, -1.0}, across = {1.0, 0.0, 0.0};
    known_side const sides[7] = {{9, 3, down}, {9, 1, up},   {9, 2, up},    {8, 0, down},
                                 {9, 1, up},   {9, 2, down}, {9, 0, across}};
    for (size_t turn = 0; turn < 7; turn++) {
        side_history history = {0};
        settle_history(&history);
        assert_int_equal(history.sides.count, 0);
        for (size_t i = 0; i < 7; i++)
            assert_int_equal(remember_side(&history, &heap, sides[(i + turn) % 7]), TULLE_OK);
        settle_history(&history);
        assert_int_equal(history.sides.count, 4);
        static int const expected[4] = {0, 1, 0, -1}; /* triangle 2: one vote up, one down */
        for (uint32_t t = 0; t < 4; t++) {
            assert_int_equal(orient_by_history(&topo, &history, (feature_pair){9, t}, up),
                             expected[t]);
            assert_int_equal(orient_by_history(&topo, &history, (feature_pair){9, t}, down),
                             -expected[t]);
        }
        assert_int_equal(orient_by_history(&topo, &history, (feature_pair){8, 1}, up), -1);
        assert_int_equal(orient_by_history(&topo, &history, (feature_pair){8, 3}, up), 0);
        ARRAY_FREE(&heap, &history.sides);
    }
    topology_destroy(&heap, &topo);
    assert_int_equal(heap.bytes_held, 0);
}

/* The rule as it is printed: both choices, moved, summed. */
static double sum_squares(const double *x, const topology *topo, vec3 axis, vec3 point,
                          double move) {
    double sum = 0.0;
    for (size_t t = 0; t < 2; t++)
        for (size_t k = 0; k < 3; k++) {
            vec3 const to = vec3_sub(vec3_load(x, topo->triangles[3 * t + k]), point);
            double const d = vec3_dot(axis, to) + (t == 0 ? move : -move);
            sum += d * d;
        }
    return sum;
}

static void verification_is_the_printed_rule(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t random = 33;
    uint32_t const triangles[6] = {0, 1, 2, 3, 4, 5};
    topology topo;
    assert_int_equal(topology_build(&heap, triangles, 2, 6, &topo), TULLE_OK);
    for (int i = 0; i < 2000; i++) {
        double x[18], a[6];
        for (int k = 0; k < 18; k++) x[k] = random_uniform(&random);
        for (int k = 0; k < 6; k++) a[k] = random_uniform(&random) - 0.5;
        vec3 const axis = vec3_normalize(vec3_load(a, 0)), point = vec3_load(a, 1);
        double const forth = sum_squares(x, &topo, axis, point, 1e-3);
        double const back = sum_squares(x, &topo, axis, point, -1e-3);
        if (fabs(forth - back) < 1e-9) continue;
        assert_int_equal(orient_by_triangles(&topo, x, 0, 1, axis), forth > back ? 1 : -1);
    }
    topology_destroy(&heap, &topo);
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rules_agree_with_geometry),
        cmocka_unit_test(sides_are_remembered),
        cmocka_unit_test(histories_settle),
        cmocka_unit_test(verification_is_the_printed_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
