/* Rigid bodies that spin fast: a substep follows the turn, or the step says that it cannot. */
#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <string.h>

/* Half the bar's length and width, and the post's radius and place [m]. */
static const double TIP = 0.5, HALF_WIDTH = 0.01, POST_RADIUS = 0.002, POST_PLACE = 0.49;

static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    for (int k = 0; k < 3; k++) def.gravity[k] = 0.0;
    def.contact_distance = 0.002;
    return bodies_make_world(&def, false);
}

static tulle_mesh make_post(double x, double y) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    def.radius = POST_RADIUS;
    def.height = 0.2;
    def.resolution[0] = 8;
    def.resolution[1] = 2;
    return small_shape(def, x, y, -0.1);
}

static tulle_obstacle_id add_bar(tulle_world *world, const tulle_mesh *bar, double spin) {
    tulle_body const body = {.is_dynamic = 1, .mass = 1.0, .angular_velocity = {0.0, 0.0, spin}};
    return bodies_add_obstacle(world, bar, 0.1, &body);
}

/* A bar turns about its middle towards a thin post inside the circle of its tips. The centre rests
 * until the blow and moves evenly after it, so its place and velocity tell when that was. */
static void hit_post(double spin, double time_step, double angle) {
    tulle_world *const world = make_world();
    tulle_mesh bar =
        bodies_make_box(2.0 * TIP, 2.0 * HALF_WIDTH, 2.0 * HALF_WIDTH, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh meshes[2] = {make_post(POST_PLACE * cos(angle), POST_PLACE * sin(angle)), bar};
    bodies_add_obstacle(world, &meshes[0], 0.1, NULL);
    tulle_obstacle_id const id = add_bar(world, &meshes[1], spin);
    double const touch = angle - asin((HALF_WIDTH + POST_RADIUS) / POST_PLACE);
    int const steps = (int)(touch / (spin * time_step)) + 1;
    uint64_t substeps = 0;
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    for (int i = 0; i < steps; i++) {
        tulle_transform const now = bodies_get_transform(world, id);
        if (i > 0) assert_true(fabs(now.angular_velocity[2] - spin) < 1e-9 * spin);
        tulle_step_report const report = bodies_step_by(world, time_step);
        substeps += report.substeps;
        assert_int_equal(bodies_judge(world, NULL, 0, meshes, 2), 0);
    }
    tulle_transform const end = bodies_get_transform(world, id);
    double const way = sqrt(end.position[0] * end.position[0] + end.position[1] * end.position[1]);
    double const speed =
        sqrt(end.velocity[0] * end.velocity[0] + end.velocity[1] * end.velocity[1]);
    double const turned = spin * (steps * time_step - way / speed);
    print_message("%g rad/s in steps of %.3g s: touches at %.3f rad, the blow came at %.3f rad, in "
                  "step %d, %d substeps in all; then %.3g rad/s\n",
                  spin, time_step, touch, turned, steps, (int)substeps, end.angular_velocity[2]);
    assert_true(speed > 0.1 * spin * TIP);
    assert_true(end.angular_velocity[2] < 0.5 * spin);
    assert_true(fabs(turned - touch) < 0.06); /* a substep turns it by 0.053 */
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
}

static void a_bar_meets_a_post_on_its_first_turn(void **state) {
    (void)state;
    double const spins[3] = {100.0, 300.0, 1000.0};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 2; k++) {
            hit_post(spins[i], 1.0 / 90.0, k ? 1.5 : 1.0);
            hit_post(spins[i], 1.0 / 30.0, k ? 1.5 : 1.0);
        }
    }
}

/* Spin [rad/s] after a thirtieth of a second, in so many steps, of a bar at rest one end of which a
 * heavy ball strikes with 40 m/s; where has_post, its other end swings against a post. */
static double strike_bar(int steps, bool has_post) {
    tulle_world *const world = make_world();
    tulle_mesh bar =
        bodies_make_box(2.0 * TIP, 2.0 * HALF_WIDTH, 2.0 * HALF_WIDTH, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh ball = bodies_make_ball(0.05, 4, (double[3]){0.45, -0.066, 0.0});
    tulle_mesh post = make_post(-0.44, -0.1);
    tulle_body const heavy = {.is_dynamic = 1, .mass = 100.0, .velocity = {0.0, 40.0, 0.0}};
    bodies_add_obstacle(world, &ball, 0.1, &heavy);
    tulle_obstacle_id const id = add_bar(world, &bar, 0.0);
    if (has_post) bodies_add_obstacle(world, &post, 0.1, NULL);
    uint64_t substeps = 0;
    for (int i = 0; i < steps; i++) {
        tulle_step_report const report = bodies_step_by(world, 1.0 / 30.0 / steps);
        substeps += report.substeps;
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message("struck bar, %s, %d steps, %d substeps: %.4g rad/s, centre at %.3f, %.3f m\n",
                  has_post ? "post" : "free", steps, (int)substeps, end.angular_velocity[2],
                  end.position[0], end.position[1]);
    tulle_mesh_destroy(&bar);
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&post);
    tulle_world_destroy(world);
    return end.angular_velocity[2];
}

static void a_bar_at_rest_is_struck(void **state) {
    (void)state;
    for (int has_post = 0; has_post < 2; has_post++) {
        double const one = strike_bar(1, has_post), many = strike_bar(200, has_post);
        assert_true(fabs(one - many) < 0.03 * many);
    }
}

/* What no step can follow is refused, and nothing moves; half the spin goes on. */
static void too_much_spin_is_refused(void **state) {
    (void)state;
    tulle_error error = {0};
    tulle_world *const world = make_world();
    tulle_mesh bar =
        bodies_make_box(2.0 * TIP, 2.0 * HALF_WIDTH, 2.0 * HALF_WIDTH, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh post = make_post(0.3, 0.4);
    for (size_t i = 0; i < post.vertex_count; i++) post.positions[3 * i + 2] += 1.0;
    bodies_add_obstacle(world, &post, 0.1, NULL);
    tulle_obstacle_id const id = add_bar(world, &bar, 1e4);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    uint64_t const hash = tulle_world_get_state_hash(world);
    assert_int_equal(tulle_world_step(world, 1.0 / 30.0, NULL, &error), TULLE_ERROR_STEP_FAILED);
    print_message("%s\n", error.message);
    assert_non_null(strstr(error.message, "'obstacle 1' spins with 10000 rad/s in step 0"));
    assert_non_null(strstr(error.message, "use a time step of at most 0.0216 s, less spin"));
    assert_true(tulle_world_get_state_hash(world) == hash);
    tulle_step_report const report = bodies_step_by(world, 0.0215);
    assert_true(report.substeps <= 4096);
    assert_true(fabs(bodies_get_transform(world, id).angular_velocity[2] - 1e4) < 1e-5);
    tulle_mesh_destroy(&post);
    tulle_mesh_destroy(&bar);
    tulle_world_destroy(world);
}

/* Substeps of a bar that spins far from cloths of these thicknesses [m]. */
static uint32_t count_substeps(const double *thicknesses, size_t count) {
    static const uint32_t corners[4] = {0, 1, 2, 3};
    tulle_world *const world = make_world();
    for (size_t i = 0; i < count; i++) {
        tulle_mesh sheet = small_sheet(0.1, 2, (double)i + 1.0);
        tulle_pin const pin = make_pin(corners, 4, 1e9);
        tulle_cloth_def def = tulle_cloth_def_default();
        def.mesh = tulle_mesh_get_view(&sheet);
        def.pins = &pin;
        def.pin_count = 1;
        def.thickness = thicknesses[i];
        assert_int_equal(tulle_world_add_cloth(world, &def, NULL, NULL), TULLE_OK);
        tulle_mesh_destroy(&sheet);
    }
    tulle_mesh bar =
        bodies_make_box(2.0 * TIP, 2.0 * HALF_WIDTH, 2.0 * HALF_WIDTH, (double[3]){0.0, 0.0, 0.0});
    (void)add_bar(world, &bar, 300.0);
    tulle_step_report const report = bodies_step_by(world, 1.0 / 90.0);
    tulle_mesh_destroy(&bar);
    tulle_world_destroy(world);
    return (uint32_t)report.substeps;
}

/* A vertex leaves its chord by a share of the least contact distance, and by the square of a
 * substep's turn: four times the distance takes half the substeps. */
static void the_thinnest_cloth_sets_the_turn(void **state) {
    (void)state;
    double const thin = 0.002, thick = 0.008;
    uint32_t const of_thin = count_substeps((double[]){thin}, 1);
    uint32_t const of_thick = count_substeps((double[]){thick}, 1);
    print_message("%u substeps near thin cloth, %u near thick cloth\n", of_thin, of_thick);
    assert_true(of_thick > 10 && of_thin + 1 >= 2 * of_thick - 1 && of_thin <= 2 * of_thick);
    assert_int_equal(count_substeps((double[]){thin, thick}, 2), of_thin);
    assert_int_equal(count_substeps((double[]){thick, thin}, 2), of_thin);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bar_meets_a_post_on_its_first_turn),
        cmocka_unit_test(a_bar_at_rest_is_struck),
        cmocka_unit_test(too_much_spin_is_refused),
        cmocka_unit_test(the_thinnest_cloth_sets_the_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
