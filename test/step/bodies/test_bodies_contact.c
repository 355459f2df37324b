/* Rigid bodies among themselves and with obstacles: momentum, tipping, shapes with holes. */
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void add_momenta(const tulle_transform *t, double linear[3], double angular[3]) {
    for (int k = 0; k < 3; k++) {
        int const a = (k + 1) % 3, b = (k + 2) % 3;
        linear[k] += t->mass * t->velocity[k];
        angular[k] += t->mass * (t->position[a] * t->velocity[b] - t->position[b] * t->velocity[a]);
        for (int i = 0; i < 3; i++) angular[k] += t->inertia[3 * k + i] * t->angular_velocity[i];
    }
}

/* Two boxes that spin and collide off their centres, in free flight. */
static void colliding_boxes_keep_momentum(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    for (int k = 0; k < 3; k++) def.gravity[k] = 0.0;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh boxes[2] = {bodies_make_box(0.3, 0.2, 0.1, (double[3]){-0.4, 0.02, 0.01}),
                           bodies_make_box(0.2, 0.25, 0.15, (double[3]){0.3, -0.03, 0.04})};
    tulle_body const first = {.is_dynamic = 1,
                              .mass = 1.0,
                              .velocity = {2.0, 0.1, 0.0},
                              .angular_velocity = {1.0, 2.0, -1.5}};
    tulle_body const second = {.is_dynamic = 1,
                               .mass = 0.4,
                               .velocity = {-1.0, 0.0, 0.2},
                               .angular_velocity = {-2.0, 0.5, 3.0}};
    tulle_obstacle_id const ids[2] = {bodies_add_obstacle(world, &boxes[0], 0.4, &first),
                                      bodies_add_obstacle(world, &boxes[1], 0.4, &second)};
    tulle_error error;
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    double start[2][3] = {{0.0}}, linear = 0.0, angular = 0.0, energy = 0.0, growth = 0.0;
    for (int i = 0; i < 2; i++) {
        tulle_transform const t = bodies_get_transform(world, ids[i]);
        add_momenta(&t, start[0], start[1]);
    }
    uint64_t contacts = 0;
    for (int s = 0; s < 90; s++) {
        tulle_step_report const report = bodies_step(world);
        double now[2][3] = {{0.0}};
        for (int i = 0; i < 2; i++) {
            tulle_transform const t = bodies_get_transform(world, ids[i]);
            add_momenta(&t, now[0], now[1]);
        }
        for (int k = 0; k < 3; k++) {
            linear = fmax(linear, fabs(now[0][k] - start[0][k]));
            angular = fmax(angular, fabs(now[1][k] - start[1][k]));
        }
        if (s > 0) growth = fmax(growth, report.kinetic_energy - energy);
        energy = report.kinetic_energy;
        contacts += report.contacts;
        if (s % 10 == 9) assert_int_equal(bodies_judge(world, NULL, 0, boxes, 2), 0);
    }
    print_message(
        "boxes collide: momentum %.2g, angular %.2g, energy grows by %.2g J, %d contacts\n", linear,
        angular, growth, (int)contacts);
    assert_true(contacts > 0);
    assert_true(linear < 1e-12 && angular < 1e-12);
    assert_true(growth < 1e-12);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&boxes[i]);
    tulle_world_destroy(world);
}

/* Height of a box after a second that lies on a table with its centre so far past the edge. */
static double lay_on_edge(double past) {
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = 0.002;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh meshes[2] = {bodies_make_box(1.0, 1.0, 0.2, (double[3]){-0.5, 0.0, -0.1}),
                            bodies_make_box(0.3, 0.1, 0.1, (double[3]){past, 0.0, 0.052})};
    tulle_body const body = {.is_dynamic = 1, .mass = 1.0};
    bodies_add_obstacle(world, &meshes[0], 0.9, NULL);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &meshes[1], 0.9, &body);
    for (int i = 0; i < 90; i++) {
        bodies_step(world);
        if (i % 10 == 9) assert_int_equal(bodies_judge(world, NULL, 0, meshes, 2), 0);
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message("box %g m past the edge: height %.4f m, turns at %.3g rad/s\n", past,
                  end.position[2], end.angular_velocity[1]);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
    return end.position[2];
}

static void box_tips_when_its_centre_passes_the_edge(void **state) {
    (void)state;
    assert_true(fabs(lay_on_edge(-0.01) - 0.052) < 1e-4);
    assert_true(lay_on_edge(0.01) < 0.0);
}

/* A ring falls a little onto a rod through it, and hangs there. */
/* Over the seam of two tables of one height at 1 m/s, without friction. */
static void box_slides_over_a_seam(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = 0.003;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh meshes[3] = {bodies_make_box(0.6, 1.0, 0.2, (double[3]){0.0, 0.017, -0.1}),
                            bodies_make_box(2.0, 1.0, 0.2, (double[3]){1.3, 0.017, -0.1}),
                            bodies_make_box(0.2, 0.2, 0.1, (double[3]){0.1, 0.0, 0.053})};
    for (int i = 0; i < 2; i++) bodies_add_obstacle(world, &meshes[i], 0.0, NULL);
    tulle_body const body = {.is_dynamic = 1, .mass = 2.0, .velocity = {1.0, 0.0, 0.0}};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &meshes[2], 0.0, &body);
    tulle_error error;
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    double const height = bodies_get_transform(world, id).position[2];
    double rise = 0.0;
    for (int s = 0; s < 45; s++) {
        bodies_step(world);
        rise = fmax(rise, fabs(bodies_get_transform(world, id).position[2] - height));
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message("box over a seam: %.6f m/s, rises by %.2g m, spins by %.2g rad/s\n",
                  end.velocity[0], rise, fabs(end.angular_velocity[2]));
    assert_true(fabs(end.velocity[0] - 1.0) < 1e-9);
    assert_true(rise < 1e-9 && fabs(end.angular_velocity[2]) < 1e-9);
    for (int i = 0; i < 3; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
}

static void ring_hangs_on_a_rod(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = 0.002;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_shape_def torus = tulle_shape_def_default(TULLE_SHAPE_TORUS);
    torus.radius = 0.1;
    torus.inner_radius = 0.01;
    torus.resolution[0] = 24;
    torus.resolution[1] = 8;
    tulle_mesh meshes[2] = {bodies_make_box(0.03, 0.03, 0.6, (double[3]){0.0, 0.0, 0.0}),
                            small_shape(torus, 0.02, 0.03, 0.1)};
    bodies_rotate_mesh(&meshes[0], acos(0.0)); /* along x */
    bodies_rotate_mesh(&meshes[1], 1.2);
    for (size_t i = 0; i < meshes[1].vertex_count; i++) meshes[1].positions[3 * i] -= 0.1;
    for (size_t i = 0; i < meshes[1].vertex_count; i++) meshes[1].positions[3 * i + 2] -= 0.06;
    tulle_body const body = {.is_dynamic = 1, .area_density = 2.0, .angular_damping = 1.0};
    bodies_add_obstacle(world, &meshes[0], 0.4, NULL);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &meshes[1], 0.4, &body);
    uint64_t rescues = 0, contacts = 0;
    for (int i = 0; i < 360; i++) {
        tulle_step_report const report = bodies_step(world);
        rescues += report.rescue_component_scalings + report.rescue_global_scalings;
        contacts += report.contacts;
        if (i % 10 == 9) assert_int_equal(bodies_judge(world, NULL, 0, meshes, 2), 0);
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message("ring: centre at %.4f, %.4f, %.4f m, speed %.3g m/s, %d contacts, %d rescues\n",
                  end.position[0], end.position[1], end.position[2], fabs(end.velocity[2]),
                  (int)contacts, (int)rescues);
    assert_true(contacts > 100);
    assert_true(end.position[2] > -0.12 && end.position[2] < -0.05); /* it hangs */
    assert_true(rescues * 1000 <= contacts);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
}

/* Boxes and rings of several masses, fast and spinning, into a light sheet over a floor. */
static void pile_holds_no_intersection(void **state) {
    (void)state;
    enum { COUNT = 9 };
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(1.0, 13, 0.15);
    tulle_mesh meshes[COUNT + 1];
    bodies_add_cloth(world, &sheet, 0.1, 1);
    meshes[0] = bodies_make_box(3.0, 3.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    bodies_add_obstacle(world, &meshes[0], 0.5, NULL);
    for (int i = 1; i <= COUNT; i++) {
        double const at[3] = {0.22 * (i % 3 - 1) + 0.013 * i, 0.22 * (i / 3 - 1), 0.4 + 0.05 * i};
        tulle_shape_def torus = tulle_shape_def_default(TULLE_SHAPE_TORUS);
        torus.radius = 0.07;
        torus.inner_radius = 0.015;
        torus.resolution[0] = 16;
        torus.resolution[1] = 6;
        meshes[i] = i % 3 == 0 ? small_shape(torus, at[0], at[1], at[2])
                               : bodies_make_box(0.1, 0.14, 0.06, at);
        tulle_body const body = {.is_dynamic = 1,
                                 .mass = i % 2 ? 0.02 : 1.0,
                                 .velocity = {0.3 * (i % 2), 0.2, -4.0},
                                 .angular_velocity = {4.0, -3.0 * i, 2.0}};
        bodies_add_obstacle(world, &meshes[i], 0.5, &body);
    }
    uint64_t scalings = 0, shortened = 0, contacts = 0, substeps = 0;
    double stretch = 0.0;
    for (int i = 0; i < 180; i++) {
        tulle_step_report const report = bodies_step(world);
        scalings += report.rescue_component_scalings;
        shortened += report.rescue_global_scalings;
        contacts += report.contacts;
        substeps += report.substeps;
        stretch = fmax(stretch, report.max_stretch);
        if (i % 6 == 5) assert_int_equal(bodies_judge(world, &sheet, 1, meshes, COUNT + 1), 0);
    }
    print_message("pile: %d contacts in %d substeps, %d components scaled, %d times shortened, "
                  "stretch %.3g\n",
                  (int)contacts, (int)substeps, (int)scalings, (int)shortened, stretch);
    assert_true((scalings + shortened) * 1000 <= contacts);
    for (int i = 0; i <= COUNT; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

/* Speed at which a ball of restitution 0.64 leaves a floor of 0.36, falling with 2 m/s. */
static double bounce(const tulle_contact_law *law, bool is_without_gravity) {
    tulle_world_def def = tulle_world_def_default();
    if (is_without_gravity) def.gravity[2] = 0.0;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh meshes[2] = {bodies_make_box(1.0, 1.0, 0.2, (double[3]){0.0, 0.0, -0.1}),
                            bodies_make_ball(0.1, 6, (double[3]){0.0, 0.0, 0.15})};
    tulle_obstacle_id ids[2];
    for (int i = 0; i < 2; i++) {
        tulle_obstacle_def obstacle = tulle_obstacle_def_default();
        obstacle.mesh = tulle_mesh_get_view(&meshes[i]);
        obstacle.friction = 0.3;
        obstacle.restitution = i ? 0.64 : 0.36;
        if (i) obstacle.body = (tulle_body){.is_dynamic = 1, .mass = 1.0, .velocity = {0, 0, -2.0}};
        assert_int_equal(tulle_world_add_obstacle(world, &obstacle, &ids[i], NULL), TULLE_OK);
    }
    if (law) {
        assert_int_equal(tulle_world_set_obstacle_obstacle_law(world, ids[0], ids[0], law, NULL),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_int_equal(tulle_world_set_obstacle_obstacle_law(world, ids[1], ids[0], law, NULL),
                         TULLE_OK);
    }
    double impact = 0.0, fastest = 0.0;
    for (int i = 0; i < 30; i++) {
        double const before = i ? bodies_get_transform(world, ids[1]).velocity[2] : -2.0;
        bodies_step(world);
        double const now = bodies_get_transform(world, ids[1]).velocity[2];
        impact = fmin(impact, fmin(before, now));
        fastest = fmax(fastest, now);
        assert_int_equal(bodies_judge(world, NULL, 0, meshes, 2), 0);
    }
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
    return fastest / -impact;
}

/* Restitution is the geometric mean of both, or that of the pair's law. */
static void ball_bounces(void **state) {
    (void)state;
    tulle_contact_law const full = {0.3, 0.3, 1.0}, none = {0.3, 0.3, 0.0};
    double const mean = bounce(NULL, true), falling = bounce(NULL, false);
    double const all = bounce(&full, true), nothing = bounce(&none, true);
    print_message("ball bounces: %.4f (%.4f with gravity), by law %.4f and %.4f\n", mean, falling,
                  all, nothing);
    assert_true(fabs(mean - 0.48) < 1e-9);
    assert_true(fabs(falling - 0.48) < 0.03);
    assert_true(fabs(all - 1.0) < 1e-9);
    assert_true(nothing < 1e-9);
}

/* A ball that falls as fast as the air lets it gets no faster until it strikes, so it leaves with
 * just the restitution's part of that. */
static void damped_ball_bounces(void **state) {
    (void)state;
    double const damping = 20.0, restitution = 0.8;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh meshes[2] = {bodies_make_box(1.0, 1.0, 0.2, (double[3]){0.0, 0.0, -0.1}),
                            bodies_make_ball(0.1, 6, (double[3]){0.0, 0.0, 0.15})};
    tulle_obstacle_id ids[2];
    double const terminal = 9.81 / damping;
    for (int i = 0; i < 2; i++) {
        tulle_obstacle_def obstacle = tulle_obstacle_def_default();
        obstacle.mesh = tulle_mesh_get_view(&meshes[i]);
        obstacle.restitution = restitution;
        if (i)
            obstacle.body = (tulle_body){.is_dynamic = 1,
                                         .mass = 1.0,
                                         .linear_damping = damping,
                                         .velocity = {0.0, 0.0, -terminal}};
        assert_int_equal(tulle_world_add_obstacle(world, &obstacle, &ids[i], NULL), TULLE_OK);
    }
    double fastest = 0.0;
    for (int i = 0; i < 30; i++) {
        bodies_step(world);
        fastest = fmax(fastest, bodies_get_transform(world, ids[1]).velocity[2]);
    }
    print_message("a damped ball leaves with %.6f of its speed\n", fastest / terminal);
    assert_true(fabs(fastest - restitution * terminal) < 1e-9);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
}

/* Without any cloth: a box falls on another and lies there. */
static void worlds_need_no_cloth(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh meshes[2] = {bodies_make_box(1.0, 1.0, 0.2, (double[3]){0.0, 0.0, -0.1}),
                            bodies_make_box(0.2, 0.1, 0.1, (double[3]){0.0, 0.0, 0.3})};
    bodies_rotate_mesh(&meshes[1], 0.5);
    tulle_body const body = {.is_dynamic = 1, .density = 500.0};
    bodies_add_obstacle(world, &meshes[0], 0.5, NULL);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &meshes[1], 0.5, &body);
    for (int i = 0; i < 180; i++) {
        bodies_step(world);
        if (i % 10 == 9) assert_int_equal(bodies_judge(world, NULL, 0, meshes, 2), 0);
    }
    tulle_transform const end = bodies_get_transform(world, id);
    print_message("without cloth: height %.5f m\n", end.position[2]);
    assert_true(fabs(end.position[2] - 0.055) < 1e-4); /* flat, 5 mm above the ground */
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_save_state(world, &bytes, &byte_count, NULL), TULLE_OK);
    assert_int_equal(tulle_world_load_state(world, bytes, byte_count, NULL), TULLE_OK);
    tulle_world_free_state(world, bytes, byte_count);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
}

/* Laws of two obstacles need a body among them. */
static void laws_of_what_never_touches_are_refused(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh box = bodies_make_box(1.0, 1.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_obstacle_id const a = bodies_add_obstacle(world, &box, 0.3, NULL);
    tulle_obstacle_id const b = bodies_add_obstacle(world, &box, 0.3, NULL);
    tulle_contact_law const law = {0.3, 0.3, 0.0};
    tulle_error error = {0};
    assert_int_equal(tulle_world_set_obstacle_obstacle_law(world, a, b, &law, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "do not touch"));
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colliding_boxes_keep_momentum),
        cmocka_unit_test(box_tips_when_its_centre_passes_the_edge),
        cmocka_unit_test(box_slides_over_a_seam),
        cmocka_unit_test(ring_hangs_on_a_rod),
        cmocka_unit_test(ball_bounces),
        cmocka_unit_test(damped_ball_bounces),
        cmocka_unit_test(worlds_need_no_cloth),
        cmocka_unit_test(laws_of_what_never_touches_are_refused),
        cmocka_unit_test(pile_holds_no_intersection),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
