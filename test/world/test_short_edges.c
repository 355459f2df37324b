/* Short edges: cloth with some that are a millionth of its size falls, hangs and lies as cloth of
 * even edges does. What files of floats do not hold is refused, with the edge and the least. */
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

#define STEP (1.0 / 90.0)
enum { SIDE = 11, MIDDLE = SIDE * (SIDE / 2) + SIDE / 2 };

/* Moves a vertex of the sheet to `edge` from its right neighbour. */
static void shorten(tulle_mesh *sheet, size_t vertex, double edge) {
    sheet->positions[3 * vertex] = sheet->positions[3 * (vertex + 1)] - edge;
}

static tulle_world *make_world(const tulle_mesh *sheet, double thickness, size_t pin_count) {
    static const uint32_t corners[2] = {SIDE * (SIDE - 1), SIDE * SIDE - 1};
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_pin pin = tulle_pin_default();
    pin.vertices = corners;
    pin.vertex_count = 2;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(sheet);
    cloth.thickness = thickness;
    cloth.pins = &pin;
    cloth.pin_count = pin_count;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    return world;
}

typedef struct fall {
    double lowest, stretch; /* [m], and the most of all steps */
} fall;

static fall run(tulle_world *world, const tulle_mesh *sheet, const tulle_mesh *obstacle,
                int steps) {
    fall result = {(double)INFINITY, 0.0};
    for (int i = 0; i < steps; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("step %d: %s", i, error.message);
        result.stretch = fmax(result.stretch, report.max_stretch);
    }
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    for (size_t v = 0; v < sheet->vertex_count; v++)
        result.lowest = fmin(result.lowest, x[3 * v + 2]);
    assert_int_equal(small_judge(world, sheet, 1, obstacle, obstacle ? 1 : 0), 0);
    tulle_world_destroy(world);
    return result;
}

/* Pinned at two corners, with one short edge in the middle. */
static void one_short_edge_hangs_as_none(void **state) {
    (void)state;
    tulle_mesh even = small_sheet(0.5, SIDE, 1.0);
    fall const wanted = run(make_world(&even, 0.0, 1), &even, NULL, 45);
    tulle_mesh_destroy(&even);
    double const edges[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 7e-7};
    for (size_t k = 0; k < sizeof edges / sizeof *edges; k++) {
        tulle_mesh sheet = small_sheet(0.5, SIDE, 1.0);
        shorten(&sheet, MIDDLE, edges[k]);
        fall const found = run(make_world(&sheet, 0.0, 1), &sheet, NULL, 45);
        print_message("edge of %g m: lowest %.4f m, stretch %.3g\n", edges[k], found.lowest,
                      found.stretch);
        assert_true(fabs(found.lowest - wanted.lowest) < 2e-3);
        assert_true(found.stretch < 1.05);
        tulle_mesh_destroy(&sheet);
    }
}

/* Many short edges, thrown off by a ball: a substep is as short as they need. */
static void many_short_edges_lie_on_a_ball(void **state) {
    (void)state;
    tulle_shape_def sphere = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    sphere.radius = 0.15;
    tulle_mesh ball = small_shape(sphere, 0.0, 0.0, 0.0);
    tulle_mesh sheet = small_sheet(0.5, SIDE, 0.16);
    for (size_t j = 1; j + 1 < SIDE; j++)
        for (size_t i = 1; i + 2 < SIDE; i++)
            if ((3 * i + 5 * j) % 7 == 0) shorten(&sheet, SIDE * j + i, 3e-5);
    tulle_world *const world = make_world(&sheet, 2e-3, 0);
    small_add_obstacle(world, &ball);
    fall const found = run(world, &sheet, &ball, 30);
    print_message("lowest %.4f m, stretch %.3g\n", found.lowest, found.stretch);
    assert_true(found.lowest < 0.0);
    assert_true(found.stretch < 1.1);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
}

/* Columns whose widths are halved down to 12 um, and grow again. */
static void columns_that_get_finer_hang_as_even_ones(void **state) {
    (void)state;
    enum { FINE = 24, ROWS = 5 };
    tulle_mesh sheet = {.vertex_count = (FINE + 1) * (ROWS + 1), .triangle_count = 2 * FINE * ROWS};
    double positions[3 * (FINE + 1) * (ROWS + 1)];
    uint32_t triangles[6 * FINE * ROWS];
    double columns[FINE + 1] = {0.0};
    for (int i = 0; i < FINE; i++)
        columns[i + 1] = columns[i] + 0.05 * pow(0.5, i < FINE / 2 ? i : FINE - 1 - i);
    for (uint32_t j = 0; j <= ROWS; j++)
        for (uint32_t i = 0; i <= FINE; i++) {
            double *const p = positions + 3 * ((FINE + 1) * j + i);
            p[0] = columns[i], p[1] = 0.04 * j, p[2] = 1.0;
        }
    uint32_t *t = triangles;
    for (uint32_t j = 0; j < ROWS; j++)
        for (uint32_t i = 0; i < FINE; i++) {
            uint32_t const a = (FINE + 1) * j + i, d = a + FINE + 1;
            uint32_t const pair[6] = {a, a + 1, d + 1, a, d + 1, d};
            memcpy(t, pair, sizeof pair);
            t += 6;
        }
    sheet.positions = positions;
    sheet.triangles = triangles;
    tulle_world *const world = make_world(&sheet, 0.0, 0);
    fall const found = run(world, &sheet, NULL, 30);
    tulle_mesh even = small_sheet(0.5, SIDE, 1.0);
    fall const wanted = run(make_world(&even, 0.0, 0), &even, NULL, 30);
    tulle_mesh_destroy(&even);
    print_message("columns: lowest %.6f m, even %.6f m, stretch %.3g\n", found.lowest,
                  wanted.lowest, found.stretch);
    assert_true(found.stretch < 1.001);
    assert_true(fabs(found.lowest - wanted.lowest) < 1e-3);
}

static void what_floats_do_not_hold_is_refused(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.5, SIDE, 1.0);
    tulle_error error = {0};
    shorten(&sheet, MIDDLE, 1e-7);
    assert_int_equal(
        tulle_mesh_validate(tulle_mesh_get_view(&sheet), TULLE_MESH_ROLE_CLOTH, &error),
        TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, " 60 at ("));
    assert_non_null(strstr(error.message, " 61 at ("));
    assert_non_null(strstr(error.message, "is 1e-07 m long"));
    assert_non_null(strstr(error.message, "1.19e-07 m in a mesh that reaches 0.25 m"));
    assert_int_equal(
        tulle_mesh_validate(tulle_mesh_get_view(&sheet), TULLE_MESH_ROLE_OBSTACLE, &error),
        TULLE_OK);
    /* fine by itself; too short where the scene reaches ten metres */
    shorten(&sheet, MIDDLE, 2e-6);
    tulle_mesh far = small_sheet(20.0, 2, -1.0);
    tulle_world *const world = make_world(&sheet, 0.0, 1);
    small_add_obstacle(world, &far);
    assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "the edge from vertex 60 to 61 is 2e-06 m long"));
    assert_non_null(strstr(error.message, "4.77e-06 m where the scene reaches 10 m"));
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&far);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_short_edge_hangs_as_none),
        cmocka_unit_test(many_short_edges_lie_on_a_ball),
        cmocka_unit_test(columns_that_get_finer_hang_as_even_ones),
        cmocka_unit_test(what_floats_do_not_hold_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
