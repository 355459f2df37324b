/* Rigid bodies: what is refused, scripts that end in free motion, impulses. */
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <string.h>

/* Adding a body to a world must fail with a message that holds `part`. */
static void expect_refusal(const tulle_mesh *mesh, const tulle_body *body, tulle_status wanted,
                           const char *part) {
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_error error = {0};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.name = "thing";
    obstacle.mesh = tulle_mesh_get_view(mesh);
    obstacle.body = *body;
    tulle_status const status = tulle_world_add_obstacle(world, &obstacle, NULL, &error);
    if (status != wanted || !strstr(error.message, part) || !strstr(error.message, "thing"))
        fail_msg("status %d: %s", (int)status, error.message);
    tulle_world_destroy(world);
}

static void bad_bodies_are_refused(void **state) {
    (void)state;
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh open = box;
    open.triangle_count--;
    tulle_status const bad = TULLE_ERROR_INVALID_ARGUMENT;
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1}, bad, "one of mass");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = -1.0}, bad, "mass is -1");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = (double)NAN}, bad, "mass is");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .density = -2.0}, bad, "density is -2");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = 1.0, .density = 2.0}, bad,
                   "only one of");
    expect_refusal(&box,
                   &(tulle_body){.is_dynamic = 1, .mass = 1.0, .velocity = {0.0, (double)INFINITY}},
                   bad, "velocity[1]");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = 1.0, .linear_damping = -1.0}, bad,
                   "linear_damping");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = 1.0, .start_time = (double)NAN},
                   bad, "start_time");
    expect_refusal(&open, &(tulle_body){.is_dynamic = 1, .mass = 1.0}, TULLE_ERROR_INVALID_MESH,
                   "is open at the edge");
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = 1e-307}, bad, "mass is 1e-307");
    for (size_t t = 0; t < box.triangle_count; t++) {
        uint32_t const corner = box.triangles[3 * t];
        box.triangles[3 * t] = box.triangles[3 * t + 1];
        box.triangles[3 * t + 1] = corner;
    }
    expect_refusal(&box, &(tulle_body){.is_dynamic = 1, .mass = 1.0}, TULLE_ERROR_INVALID_MESH,
                   "inside");
    tulle_mesh_destroy(&box);
}

/* Without volume there is no inertia, but a shell has one. */
static void flat_bodies_need_area_density(void **state) {
    (void)state;
    double positions[9] = {0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.1, 0.0};
    uint32_t triangles[6] = {0, 1, 2, 0, 2, 1};
    tulle_mesh const flat = {positions, 3, triangles, 1};
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_body const body = {.is_dynamic = 1, .area_density = 1.0};
    expect_refusal(&flat, &(tulle_body){.is_dynamic = 1, .mass = 1.0}, TULLE_ERROR_INVALID_MESH,
                   "open");
    tulle_obstacle_id const id = bodies_add_obstacle(world, &flat, 0.3, &body);
    bodies_step(world);
    assert_true(fabs(bodies_get_transform(world, id).mass - 0.01) < 1e-12);
    tulle_world_destroy(world);
}

/* At once, whatever is to be done about it: bodies cannot be untangled. */
static void overlaps_at_the_start_are_refused(void **state) {
    (void)state;
    const char *const advice[2] = {
        "move them apart (untangling moves cloth only), or set start_intersections to ignore",
        "(16 of 'obstacle 0' with 'obstacle 1'), and untangling moves cloth only; move the "
        "objects"};
    for (int i = 0; i < 4; i++) {
        int const other_is_body = i % 2, is_untangled = i / 2;
        tulle_world_def def = tulle_world_def_default();
        if (is_untangled) def.start_intersections = TULLE_START_UNTANGLE;
        tulle_world *const world = bodies_make_world(&def, true);
        tulle_mesh a = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
        tulle_mesh b = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.1, 0.05, 0.07});
        tulle_body const body = {.is_dynamic = 1, .mass = 1.0};
        bodies_add_obstacle(world, &a, 0.3, other_is_body ? &body : NULL);
        bodies_add_obstacle(world, &b, 0.3, &body);
        tulle_error error = {0};
        assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INTERSECTING_START);
        assert_non_null(strstr(error.message, "obstacle 1"));
        if (!strstr(error.message, advice[is_untangled])) fail_msg("%s", error.message);
        assert_int_equal(tulle_world_get_untangle_report(world).rounds, 0);
        tulle_mesh_destroy(&a);
        tulle_mesh_destroy(&b);
        tulle_world_destroy(world);
    }
}

/* An obstacle that appears around a body, added before it or after it: the world says so. */
static void a_body_that_is_caught_is_told(void **state) {
    (void)state;
    for (int is_first = 0; is_first < 2; is_first++) {
        tulle_world_def def = tulle_world_def_default();
        def.start_intersections = TULLE_START_IGNORE;
        tulle_world *const world = bodies_make_world(&def, true);
        tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
        tulle_mesh other = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.1, 0.05, 0.07});
        tulle_body const body = {.is_dynamic = 1, .mass = 1.0};
        tulle_obstacle_def late = tulle_obstacle_def_default();
        late.name = "late";
        late.mesh = tulle_mesh_get_view(&other);
        late.appear_time = 1.5 * BODIES_STEP;
        if (!is_first) bodies_add_obstacle(world, &box, 0.3, &body);
        assert_int_equal(tulle_world_add_obstacle(world, &late, NULL, NULL), TULLE_OK);
        if (is_first) bodies_add_obstacle(world, &box, 0.3, &body);
        const char *const wanted = is_first ? "'obstacle 1' is caught at 0.0222222 s in 'late'"
                                            : "'obstacle 0' is caught at 0.0222222 s in 'late'";
        for (int i = 0; i < 2; i++) {
            bodies_step(world);
            assert_null(strstr(tulle_world_last_message(world), "caught"));
        }
        bodies_step(world);
        if (!strstr(tulle_world_last_message(world), wanted))
            fail_msg("%s", tulle_world_last_message(world));
        tulle_mesh_destroy(&box);
        tulle_mesh_destroy(&other);
        tulle_world_destroy(world);
    }
}

/* Pieces of one body that cross would count twice where they do. */
static void bodies_that_cross_themselves_are_refused(void **state) {
    (void)state;
    tulle_mesh parts[2];
    parts[0] = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
    const double *const corner = parts[0].positions; /* of the second, it lies in the middle */
    parts[1] = bodies_make_box(0.2, 0.2, 0.2, (double[3]){-corner[0], -corner[1], -corner[2]});
    size_t const n = parts[0].vertex_count, m = parts[0].triangle_count;
    tulle_mesh both;
    assert_int_equal(tulle_mesh_create(2 * n, 2 * m, &both, NULL), TULLE_OK);
    for (size_t p = 0; p < 2; p++) {
        memcpy(both.positions + 3 * n * p, parts[p].positions, 3 * n * sizeof(double));
        for (size_t i = 0; i < 3 * m; i++)
            both.triangles[3 * m * p + i] = parts[p].triangles[i] + (uint32_t)(n * p);
        tulle_mesh_destroy(&parts[p]);
    }
    expect_refusal(&both, &(tulle_body){.is_dynamic = 1, .mass = 1.0}, TULLE_ERROR_INVALID_MESH,
                   "overlaps another or lies inside it");
    tulle_mesh_destroy(&both);
}

/* A cube from -size/2 to size/2, of whose surface the inner one faces inward. */
static tulle_mesh make_shell(double size, double inner) {
    tulle_mesh const parts[2] = {bodies_make_box(size, size, size, (double[3]){0.0, 0.0, 0.0}),
                                 bodies_make_box(inner, inner, inner, (double[3]){0.0, 0.0, 0.0})};
    tulle_mesh shell;
    size_t const n = parts[0].vertex_count, m = parts[0].triangle_count;
    assert_int_equal(tulle_mesh_create(2 * n, 2 * m, &shell, NULL), TULLE_OK);
    for (size_t p = 0; p < 2; p++) {
        memcpy(shell.positions + 3 * n * p, parts[p].positions, 3 * n * sizeof(double));
        for (size_t i = 0; i < 3 * m; i++) {
            size_t const from = p == 0 || i % 3 == 0 ? i : i % 3 == 1 ? i + 1 : i - 1;
            shell.triangles[3 * m * p + i] = parts[p].triangles[from] + (uint32_t)(n * p);
        }
    }
    for (int p = 0; p < 2; p++) tulle_mesh_destroy((tulle_mesh *)&parts[p]);
    return shell;
}

/* Starts a world of two obstacles, bodies where the mass is not 0. */
static tulle_status start_with(const tulle_mesh *first, double first_mass, const tulle_mesh *second,
                               double second_mass, tulle_error *error) {
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_body const bodies[2] = {{.is_dynamic = 1, .mass = first_mass},
                                  {.is_dynamic = 1, .mass = second_mass}};
    bodies_add_obstacle(world, first, 0.3, first_mass > 0.0 ? &bodies[0] : NULL);
    bodies_add_obstacle(world, second, 0.3, second_mass > 0.0 ? &bodies[1] : NULL);
    tulle_status const status = tulle_world_start(world, error);
    tulle_world_destroy(world);
    return status;
}

/* What lies wholly in a solid crosses nothing and is refused all the same, whichever of the two is
 * a body; not in a hollow. Two obstacles may lie as they like. */
static void bodies_in_solids_are_refused(void **state) {
    (void)state;
    tulle_mesh small = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh large = bodies_make_box(1.0, 1.0, 1.0, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh shell = make_shell(1.0, 0.8);
    for (int which = 0; which < 4; which++) {
        double const small_mass = which & 1 ? 1.0 : 0.0, large_mass = which & 2 ? 1.0 : 0.0;
        tulle_error error = {0};
        tulle_status const wanted = which == 0 ? TULLE_OK : TULLE_ERROR_INTERSECTING_START;
        assert_int_equal(start_with(&large, large_mass, &small, small_mass, &error), wanted);
        if (which != 0)
            assert_non_null(strstr(error.message, "'obstacle 1' lies inside 'obstacle 0'"));
        assert_int_equal(start_with(&small, small_mass, &large, large_mass, &error), wanted);
        if (which != 0)
            assert_non_null(strstr(error.message, "'obstacle 0' lies inside 'obstacle 1'"));
        assert_int_equal(start_with(&shell, large_mass, &small, small_mass, &error), TULLE_OK);
    }
    tulle_mesh_destroy(&small);
    tulle_mesh_destroy(&large);
    tulle_mesh_destroy(&shell);
}

/* A body that its script leaves inside a solid cannot come free there; the world stays. */
static void bodies_cannot_come_free_in_solids(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh small = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
    tulle_mesh large = bodies_make_box(1.0, 1.0, 1.0, (double[3]){0.0, 0.0, 0.0});
    tulle_body const body = {.is_dynamic = 1, .mass = 1.0, .start_time = 1.5 * BODIES_STEP};
    bodies_add_obstacle(world, &large, 0.3, NULL);
    bodies_add_obstacle(world, &small, 0.3, &body);
    for (int i = 0; i < 2; i++) bodies_step(world);
    uint64_t const hash = tulle_world_get_state_hash(world);
    tulle_error error = {0};
    for (int i = 0; i < 2; i++)
        assert_int_equal(tulle_world_step(world, BODIES_STEP, NULL, &error),
                         TULLE_ERROR_INTERSECTING_START);
    assert_non_null(strstr(error.message, "'obstacle 1' lies inside 'obstacle 0' when"));
    assert_true(tulle_world_get_state_hash(world) == hash);
    tulle_mesh_destroy(&small);
    tulle_mesh_destroy(&large);
    tulle_world_destroy(world);
}

/* A box swings about a pivot by keyframes, then flies on as it moved. */
static void script_hands_over(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    for (int k = 0; k < 3; k++) def.gravity[k] = 0.0;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh box = bodies_make_box(0.3, 0.2, 0.1, (double[3]){0.0, 0.0, 0.5});
    tulle_keyframe const keys[2] = {
        {.time = 0.0, .rotation_vector = {0, 0, 0}},
        {.time = 1.0, .translation = {1.0, 0.0, 0.0}, .rotation_vector = {0.0, 0.0, 1.0}}};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    tulle_obstacle_id id;
    obstacle.mesh = tulle_mesh_get_view(&box);
    obstacle.motion = (tulle_motion){.keys = keys, .key_count = 2};
    obstacle.body = (tulle_body){.is_dynamic = 1, .mass = 1.0, .start_time = 0.5};
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, &id, NULL), TULLE_OK);
    for (int i = 0; i < 90; i++) bodies_step(world);
    tulle_transform const end = bodies_get_transform(world, id);
    /* a turn of 1 rad/s about z through the origin's axis, where the centre lies */
    assert_true(fabs(end.position[0] - 1.0) < 1e-9 && fabs(end.velocity[0] - 1.0) < 1e-9);
    assert_true(fabs(end.angular_velocity[2] - 1.0) < 1e-9);
    assert_true(fabs(end.rotation[3] - sin(0.5)) < 1e-9);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

static void impulses_act(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    for (int k = 0; k < 3; k++) def.gravity[k] = 0.0;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 0.0});
    tulle_body const body = {.is_dynamic = 1, .mass = 2.0};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.3, &body);
    double const point[3] = {0.0, 0.1, 0.0}, push[3] = {3.0, 0.0, 0.0};
    tulle_error error = {0};
    assert_int_equal(tulle_obstacle_add_impulse(world, id, point, push, &error),
                     TULLE_ERROR_INVALID_ARGUMENT); /* not started */
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    assert_int_equal(tulle_obstacle_add_impulse(world, id, point, push, &error), TULLE_OK);
    tulle_transform const now = bodies_get_transform(world, id);
    double const inertia = 2.0 * 0.04 / 6.0; /* m a^2 / 6 */
    assert_true(fabs(now.velocity[0] - 1.5) < 1e-12);
    assert_true(fabs(now.angular_velocity[2] + 0.3 / inertia) < 1e-9);
    double const nan[3] = {(double)NAN, 0.0, 0.0};
    assert_int_equal(tulle_obstacle_add_impulse(world, id, point, nan, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* What a box that falls askew on the ground gets from contact is all that changes its momentum and
 * spin beside gravity. */
static void contact_impulses_are_told(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh meshes[2] = {bodies_make_box(2.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1}),
                            bodies_make_box(0.3, 0.2, 0.1, (double[3]){0.0, 0.0, 0.3})};
    bodies_rotate_mesh(&meshes[1], 0.3);
    tulle_body const body = {
        .is_dynamic = 1, .mass = 2.0, .velocity = {1.0, 0.3, 0.0}, .angular_velocity = {1.0, 0, 2}};
    tulle_obstacle_id const ground = bodies_add_obstacle(world, &meshes[0], 0.5, NULL);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &meshes[1], 0.5, &body);
    double impulse[3], moment[3], worst = 0.0, largest = 0.0;
    assert_int_equal(tulle_obstacle_get_contact_impulse(world, id, impulse, moment, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT); /* not started */
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    for (int i = 0; i < 90; i++) {
        tulle_transform const before = bodies_get_transform(world, id);
        tulle_step_report const report = bodies_step(world);
        tulle_transform const after = bodies_get_transform(world, id);
        double of_ground[3], about_origin[3];
        assert_int_equal(
            tulle_obstacle_get_contact_impulse(world, ground, of_ground, about_origin, NULL),
            TULLE_OK);
        assert_int_equal(tulle_obstacle_get_contact_impulse(world, id, impulse, moment, NULL),
                         TULLE_OK);
        for (int k = 0; k < 3; k++) assert_true(fabs(of_ground[k] + impulse[k]) < 1e-12);
        if (report.substeps > 1) continue;
        for (int k = 0; k < 3; k++) {
            double spin = 0.0;
            for (int j = 0; j < 3; j++)
                spin += after.inertia[3 * k + j] * after.angular_velocity[j] -
                        before.inertia[3 * k + j] * before.angular_velocity[j];
            double const fall = k == 2 ? -9.81 * BODIES_STEP : 0.0;
            double const change = 2.0 * (after.velocity[k] - before.velocity[k] - fall);
            worst = fmax(worst, fmax(fabs(change - impulse[k]), fabs(spin - moment[k])));
            largest = fmax(largest, fabs(impulse[k]));
        }
    }
    print_message("impulses up to %.3g N s, off by %.2g\n", largest, worst);
    assert_true(largest > 1.0);
    assert_true(worst < 1e-12);
    assert_int_equal(tulle_obstacle_get_contact_impulse(world, id, NULL, moment, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&meshes[i]);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_bodies_are_refused),
        cmocka_unit_test(flat_bodies_need_area_density),
        cmocka_unit_test(overlaps_at_the_start_are_refused),
        cmocka_unit_test(a_body_that_is_caught_is_told),
        cmocka_unit_test(bodies_that_cross_themselves_are_refused),
        cmocka_unit_test(bodies_in_solids_are_refused),
        cmocka_unit_test(bodies_cannot_come_free_in_solids),
        cmocka_unit_test(script_hands_over),
        cmocka_unit_test(impulses_act),
        cmocka_unit_test(contact_impulses_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
