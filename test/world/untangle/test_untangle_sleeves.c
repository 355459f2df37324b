/* A sleeve that lies across an arm: two lines of intersection from border to border, neither of
 * which parts the tube. It becomes clean where it fits around the arm with room, where it just
 * does not, and where it has to stretch by a tenth; of a coarse mesh and of a fine one. */
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static double const STEP = 1.0 / 90.0; /* [s] */
static double const SLEEVE = 0.05, LENGTH = 0.4;
enum { ROUNDS = 600, AROUND_COARSE = 20, AROUND_FINE = 44 };

static tulle_mesh make_tube(unsigned around) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_TUBE);
    def.radius = SLEEVE;
    def.height = LENGTH;
    def.resolution[0] = around;
    def.resolution[1] = around * 5 / 4;
    return small_shape(def, 0.0, 0.0, 0.0);
}

/* Tilted by 4 degrees, its lower end at (x, 0, z). */
static tulle_mesh make_arm(tulle_shape_def def, double x, double z) {
    tulle_mesh mesh = small_shape(def, 0.0, 0.0, 0.0);
    double const tilt = 0.07;
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        double *const p = mesh.positions + 3 * v;
        double const across = p[0], along = p[2];
        p[0] = cos(tilt) * across + sin(tilt) * along + x;
        p[2] = cos(tilt) * along - sin(tilt) * across + z;
    }
    return mesh;
}

/* Of an edge's length to that in the mesh. */
static double find_largest_stretch(const tulle_mesh *mesh, const double *positions) {
    double most = 0.0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        size_t const a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        double now = 0.0, before = 0.0;
        for (size_t c = 0; c < 3; c++) {
            now += pow(positions[3 * a + c] - positions[3 * b + c], 2.0);
            before += pow(mesh->positions[3 * a + c] - mesh->positions[3 * b + c], 2.0);
        }
        most = fmax(most, sqrt(now / before));
    }
    return most;
}

static void assert_comes_clean(tulle_mesh *sleeve, tulle_mesh *arm, const char *name) {
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_UNTANGLE;
    def.untangle_limit = ROUNDS;
    def.threads = 1;
    tulle_world *world = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_OK);
    tulle_cloth_id const id = small_add_cloth(world, sleeve);
    (void)small_add_obstacle(world, arm);
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s: %s", name, error.message);
    tulle_untangle_report const report = tulle_world_get_untangle_report(world);
    double const stretch = find_largest_stretch(sleeve, tulle_cloth_get_positions(world, id, NULL));
    print_message("%s: %d pairs, %d rounds, %.2f s, largest stretch %.2f\n", name,
                  (int)report.intersections, (int)report.rounds, report.seconds, stretch);
    assert_true(report.intersections > 0);
    assert_true(report.keeps_minimum_gap);
    assert_true(stretch < 1.5);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(small_judge(world, sleeve, 1, arm, 1), 0);
        tulle_step_report step = {0};
        assert_int_equal(tulle_world_step(world, STEP, &step, &error), TULLE_OK);
        assert_int_equal(step.ignored_pairs, 0);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(sleeve);
    tulle_mesh_destroy(arm);
}

static void free_sleeve(unsigned around, double radius, const char *name) {
    tulle_mesh sleeve = make_tube(around);
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    def.radius = radius;
    def.height = 0.5;
    tulle_mesh arm = make_arm(def, 0.01, -0.1);
    assert_comes_clean(&sleeve, &arm, name);
}

static void sleeve_comes_clean(double radius, const char *name) {
    free_sleeve(AROUND_COARSE, radius, name);
    free_sleeve(AROUND_FINE, radius, name);
}

static void arm_with_room(void **state) {
    (void)state;
    sleeve_comes_clean(0.048, "arm with room");
}

static void arm_as_wide(void **state) {
    (void)state;
    sleeve_comes_clean(0.0505, "arm as wide as the sleeve");
}

static void arm_that_is_wider(void **state) {
    (void)state;
    sleeve_comes_clean(0.055, "arm that is wider");
}

/* A thin board lengthwise through a tube: what is beyond it is clean and yet on the wrong side. */
static void board_through_a_tube(void **state) {
    (void)state;
    tulle_mesh sleeve = make_tube(AROUND_COARSE);
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = 0.02;
    def.size[1] = 0.5;
    def.size[2] = 0.6;
    tulle_mesh board = make_arm(def, 0.0, 0.45);
    assert_comes_clean(&sleeve, &board, "board through a tube");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arm_with_room),
        cmocka_unit_test(arm_as_wide),
        cmocka_unit_test(arm_that_is_wider),
        cmocka_unit_test(board_through_a_tube),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
