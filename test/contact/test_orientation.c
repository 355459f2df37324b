/* Orientation: for sheets that do not intersect every rule says what geometry says, or nothing;
 * after a vertex or a whole sheet has passed through, history and neighbours remember the side. */
#include "base/hash.h"
#include "contact/orientation.h"
#include "support/mini_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* A turned sheet over a plane, both rough by 0.1 mm, with its rows stored. */
static void make_stored_sheet(mini_world *world, uint64_t *random) {
    make_coarse_sheet_over_plane(world, random);
    for (size_t i = 0; i < world->vertex_count; i++)
        world->x0[3 * i + 2] += 1e-4 * (random_uniform(random) - 0.5);
    gather_at_rest(world, TIME_STEP);
    assert_int_equal(update_contacts(&world->store, &world->heap, &world->rows, TIME_STEP),
                     TULLE_OK);
}

static oriented_pair ask_about_row(const mini_world *world, const contact_row *row, double sign) {
    vec3 point = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++)
        point = vec3_add_scaled(point, vec3_load(world->x0, row->vertices[k]),
                                0.5 * fabs(row->weights[k]));
    return (oriented_pair){row->kind, row->pair, vec3_scale(row->normal, sign), point};
}

static void rules_agree_with_geometry(void **state) {
    (void)state;
    uint64_t random = 31;
    size_t count = 0, by_neighbours = 0;
    for (int i = 0; i < 20; i++) {
        mini_world world;
        make_stored_sheet(&world, &random);
        for (size_t r = 0; r < world.rows.rows.count; r++) {
            int const sign = random_uniform(&random) < 0.5 ? -1 : 1;
            oriented_pair const question = ask_about_row(&world, &world.rows.rows.data[r], sign);
            assert_int_equal(orient_by_history(&world.topo, &world.store, &question), sign);
            assert_int_equal(orient_pair(&world.topo, world.x0, &world.store, &question), sign);
            int const side = orient_by_neighbours(&world.topo, world.x0, &question);
            assert_true(side == sign || side == ORIENTATION_UNDECIDED);
            contact_store const empty = {0};
            assert_int_equal(orient_pair(&world.topo, world.x0, &empty, &question), sign);
            count++;
            by_neighbours += side == sign;
        }
        mini_world_destroy(&world);
    }
    print_message("%zu of %zu pairs decided by their neighbours\n", by_neighbours, count);
    assert_true(count > 5000 && by_neighbours > count / 2);
}

/* The triangle of the plane under a point, or TULLE_NONE. */
static uint32_t find_triangle_below(const mini_world *world, vec3 point) {
    for (uint32_t t = 0; t < world->topo.triangle_count; t++) {
        const uint32_t *const corners = world->topo.triangles + 3 * (size_t)t;
        if (corners[0] < world->cloth_vertex_count) continue;
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

static void raise_all_but(mini_world *world, uint32_t vertex, double height) {
    for (uint32_t k = 0; k < world->cloth_vertex_count; k++)
        if (k != vertex) world->x0[3 * k + 2] += height;
}

/* The sheet slides by up to a third of a cell and sinks through the plane; or one vertex does. */
static void sides_are_remembered(void **state) {
    (void)state;
    uint64_t random = 32;
    size_t slid = 0;
    for (int i = 0; i < 20; i++) {
        mini_world world;
        make_stored_sheet(&world, &random);
        double const dx = 0.01 * random_uniform(&random), dy = 0.01 * random_uniform(&random);
        for (size_t k = 0; k < world.cloth_vertex_count; k++) {
            world.x0[3 * k] += dx;
            world.x0[3 * k + 1] += dy;
            world.x0[3 * k + 2] -= 5e-3;
        }
        for (uint32_t k = 0; k < world.cloth_vertex_count; k++) {
            vec3 const point = vec3_load(world.x0, k);
            uint32_t const triangle = find_triangle_below(&world, point);
            assert_int_not_equal(triangle, TULLE_NONE);
            oriented_pair const question = {
                FEATURE_VERTEX_TRIANGLE, {k, triangle}, {0.0, 0.0, 1.0}, {point.x, point.y, 0.0}};
            slid += !find_contact(&world.store, FEATURE_VERTEX_TRIANGLE, question.pair);
            assert_int_equal(orient_by_history(&world.topo, &world.store, &question),
                             ORIENTATION_ALONG);
            assert_int_equal(orient_pair(&world.topo, world.x0, &world.store, &question),
                             ORIENTATION_ALONG);
            assert_int_equal(orient_by_neighbours(&world.topo, world.x0, &question),
                             ORIENTATION_AGAINST);
            raise_all_but(&world, k, 7e-3);
            assert_int_equal(orient_by_neighbours(&world.topo, world.x0, &question),
                             ORIENTATION_ALONG);
            raise_all_but(&world, k, -7e-3);
        }
        mini_world_destroy(&world);
    }
    assert_true(slid > 300);
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
        cmocka_unit_test(verification_is_the_printed_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
