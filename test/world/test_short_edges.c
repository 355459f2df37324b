/* Short edges: cloth with some that are a millionth of its size falls, hangs and lies as cloth of
 * even edges does. What files of floats do not hold is refused, with the edge and the least. */
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdbool.h>
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

/* Many triangles that are 30 um high, over a short edge or opposite a long one. */
static void make_low(tulle_mesh *sheet, bool has_caps) {
    double const height = 3e-5;
    size_t const side = SIDE;
    bool is_moved[SIDE * SIDE] = {false};
    size_t count = 0;
    for (size_t t = 0; has_caps && t < 3 * sheet->triangle_count; t++) {
        const uint32_t *const corners = sheet->triangles + t / 3 * 3;
        size_t const v[3] = {corners[t % 3], corners[(t + 1) % 3], corners[(t + 2) % 3]};
        double *const x = sheet->positions;
        bool const is_inside =
            v[0] % side > 0 && v[0] % side + 1 < side && v[0] / side > 0 && v[0] / side + 1 < side;
        double offset[2], length2 = 0.0, long2 = 0.0;
        for (size_t k = 0; k < 2; k++) {
            offset[k] = 0.5 * (x[3 * v[1] + k] + x[3 * v[2] + k]) - x[3 * v[0] + k];
            length2 += offset[k] * offset[k];
            long2 += pow(x[3 * v[1] + k] - x[3 * v[2] + k], 2.0);
        }
        bool const is_corner = fabs(4.0 * length2 - long2) < 1e-9; /* a right angle */
        if (is_moved[v[0]] || is_moved[v[1]] || is_moved[v[2]] || !is_inside || !is_corner)
            continue;
        for (size_t k = 0; k < 2; k++)
            x[3 * v[0] + k] += offset[k] * (1.0 - height / sqrt(length2));
        count++;
        for (size_t w = 0; w < 9; w++) is_moved[v[0] - side - 1 + w % 3 + side * (w / 3)] = true;
    }
    assert_true(!has_caps || count > 8);
    for (size_t j = 1; !has_caps && j + 1 < side; j++)
        for (size_t i = 1; i + 2 < SIDE; i++)
            if ((3 * i + 5 * j) % 7 == 0) shorten(sheet, SIDE * j + i, height);
}

/* Thrown off by a ball: a substep is as short as they need. */
static void many_low_triangles_lie_on_a_ball(void **state) {
    (void)state;
    tulle_shape_def sphere = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    sphere.radius = 0.15;
    tulle_mesh ball = small_shape(sphere, 0.0, 0.0, 0.0);
    for (int has_caps = 0; has_caps < 2; has_caps++) {
        tulle_mesh sheet = small_sheet(0.5, SIDE, 0.16);
        make_low(&sheet, has_caps);
        tulle_world *const world = make_world(&sheet, 2e-3, 0);
        small_add_obstacle(world, &ball);
        fall const found = run(world, &sheet, &ball, 30);
        print_message("lowest %.4f m, stretch %.3g\n", found.lowest, found.stretch);
        assert_true(found.lowest < 0.0);
        assert_true(found.stretch < 1.1);
        tulle_mesh_destroy(&sheet);
    }
    tulle_mesh_destroy(&ball);
}

/* A sheet 0.2 m wide whose columns are halved down to 12 um, and grow again; or with even ones. */
static tulle_mesh make_columns(bool is_even, double z) {
    enum { FINE = 24, EVEN = 10, ROWS = 10 };
    static double positions[3 * (FINE + 1) * (ROWS + 1)];
    static uint32_t triangles[6 * FINE * ROWS];
    uint32_t const count = is_even ? EVEN : FINE;
    double columns[FINE + 1] = {-0.1};
    for (uint32_t i = 0; i < count; i++)
        columns[i + 1] =
            columns[i] + (is_even ? 0.02 : 0.05 * pow(0.5, i < FINE / 2 ? i : FINE - 1 - i));
    for (uint32_t j = 0; j <= ROWS; j++)
        for (uint32_t i = 0; i <= count; i++) {
            double *const p = positions + 3 * ((count + 1) * j + i);
            p[0] = columns[i], p[1] = 0.02 * j - 0.1, p[2] = z;
        }
    uint32_t *t = triangles;
    for (uint32_t j = 0; j < ROWS; j++)
        for (uint32_t i = 0; i < count; i++) {
            uint32_t const a = (count + 1) * j + i, d = a + count + 1;
            uint32_t const pair[6] = {a, a + 1, d + 1, a, d + 1, d};
            memcpy(t, pair, sizeof pair);
            t += 6;
        }
    return (tulle_mesh){.positions = positions,
                        .vertex_count = (count + 1) * (ROWS + 1),
                        .triangles = triangles,
                        .triangle_count = 2 * count * ROWS};
}

/* Falling freely, on a ball, and on a needle whose tip lies under the finest column. */
static void columns_that_get_finer_fall_as_even_ones(void **state) {
    (void)state;
    tulle_shape_def sphere = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    sphere.radius = 0.06;
    tulle_shape_def cone = tulle_shape_def_default(TULLE_SHAPE_CONE);
    cone.radius = 0.02;
    cone.height = 0.2;
    tulle_mesh obstacles[2] = {small_shape(sphere, 0.0, 0.0, 0.0),
                               small_shape(cone, 0.0, 0.0, -0.1)};
    double const heights[3] = {0.07, 0.11, 0.07}, margins[3] = {0.01, 0.02, 1e-3};
    for (int k = 0; k < 3; k++) {
        fall found[2];
        for (int is_even = 0; is_even < 2; is_even++) {
            tulle_mesh const sheet = make_columns(is_even, heights[k]);
            tulle_world *const world = make_world(&sheet, 0.0, 0);
            if (k < 2) small_add_obstacle(world, &obstacles[k]);
            found[is_even] = run(world, &sheet, k < 2 ? &obstacles[k] : NULL, 30);
        }
        print_message("columns: lowest %.4f m, stretch %.3g; even: %.4f m, %.3g\n", found[0].lowest,
                      found[0].stretch, found[1].lowest, found[1].stretch);
        assert_true(fabs(found[0].lowest - found[1].lowest) < margins[k]);
        assert_true(found[0].stretch < (k < 2 ? 1.1 : 1.001));
    }
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&obstacles[k]);
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
        cmocka_unit_test(many_low_triangles_lie_on_a_ball),
        cmocka_unit_test(columns_that_get_finer_fall_as_even_ones),
        cmocka_unit_test(what_floats_do_not_hold_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
