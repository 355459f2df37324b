/* The paper's response in a world: every state is free of intersection, and what it keeps from step
 * to step belongs to the saved state. */
#include "support/paper_options.h"
#include "support/small_world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define TIME_STEP (1.0 / 90.0)

typedef struct scene {
    tulle_mesh sheets[2], sphere;
} scene;

static scene make_scene(void) {
    tulle_shape_def sphere = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    sphere.radius = 0.2;
    sphere.resolution[0] = sphere.resolution[1] = 6;
    return (scene){{small_sheet(0.6, 13, 0.22), small_sheet(0.5, 11, 0.23)},
                   small_shape(sphere, 0.0, 0.0, 0.0)};
}

static void destroy_scene(scene *of) {
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&of->sheets[k]);
    tulle_mesh_destroy(&of->sphere);
}

static tulle_world *make_world(const scene *of, tulle_response response, tulle_motion_space space) {
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    change_paper(&def)->response = response;
    change_paper(&def)->motion_space = space;
    def.threads = 2;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    for (int k = 0; k < 2; k++) small_add_cloth(world, &of->sheets[k]);
    small_add_obstacle(world, &of->sphere);
    return world;
}

static void take_step(const scene *of, tulle_world *world, tulle_step_report *sum) {
    tulle_step_report report;
    tulle_error error = {0};
    if (tulle_world_step(world, TIME_STEP, &report, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    sum->contacts += report.contacts;
    sum->stick_contacts += report.stick_contacts;
    sum->max_stretch =
        report.max_stretch > sum->max_stretch ? report.max_stretch : sum->max_stretch;
    assert_int_equal(small_judge(world, of->sheets, 2, &of->sphere, 1), 0);
}

static void every_state_is_clean(void **state) {
    (void)state;
    scene of = make_scene();
    for (int space = 0; space < 2; space++) {
        tulle_world *world = make_world(&of, TULLE_RESPONSE_PAPER, (tulle_motion_space)space);
        tulle_paper_options const kept = tulle_world_get_paper_options(world);
        assert_int_equal(kept.response, TULLE_RESPONSE_PAPER);
        assert_int_equal(kept.motion_space, space);
        tulle_step_report sum = {0};
        for (int i = 0; i < 45; i++) take_step(&of, world, &sum);
        print_message("space %d: %llu contacts, %llu stick, peak stretch %.3g\n", space,
                      (unsigned long long)sum.contacts, (unsigned long long)sum.stick_contacts,
                      sum.max_stretch);
        assert_true(sum.contacts > 300); /* or nothing was tested */
        tulle_world_destroy(world);
    }
    destroy_scene(&of);
}

/* Goes on from a saved state to the same bits; the state of another response is refused. */
static void saved_states_go_on(void **state) {
    (void)state;
    scene of = make_scene();
    tulle_world *first = make_world(&of, TULLE_RESPONSE_PAPER, TULLE_MOTION_SPACE_CONE);
    tulle_world *second = make_world(&of, TULLE_RESPONSE_PAPER, TULLE_MOTION_SPACE_CONE);
    tulle_world *others[2] = {make_world(&of, TULLE_RESPONSE_PAPER, TULLE_MOTION_SPACE_POLYHEDRAL),
                              make_world(&of, TULLE_RESPONSE_COUPLED, TULLE_MOTION_SPACE_CONE)};
    tulle_step_report sum = {0};
    for (int i = 0; i < 15; i++) take_step(&of, first, &sum);
    assert_true(sum.stick_contacts > 0);
    void *bytes = NULL;
    size_t byte_count = 0;
    tulle_error error = {0};
    assert_int_equal(tulle_world_save_state(first, &bytes, &byte_count, &error), TULLE_OK);
    assert_int_equal(tulle_world_load_state(second, bytes, byte_count, &error), TULLE_OK);
    for (int i = 0; i < 5; i++) {
        assert_true(tulle_world_get_state_hash(first) == tulle_world_get_state_hash(second));
        take_step(&of, first, &sum);
        take_step(&of, second, &sum);
    }
    for (int k = 0; k < 2; k++) {
        assert_int_equal(tulle_world_load_state(others[k], bytes, byte_count, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
        tulle_world_destroy(others[k]);
    }
    tulle_world_free_state(first, bytes, byte_count);
    tulle_world_destroy(first);
    tulle_world_destroy(second);
    destroy_scene(&of);
}

/* Very stiff sheets that stick hard, slide easily and rebound fully, in a world of their own. */
static tulle_world *make_rebounding(const scene *of, tulle_integrator integrator) {
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    change_paper(&def)->motion_space = TULLE_MOTION_SPACE_POLYHEDRAL;
    def.integrator = integrator;
    def.friction_cloth_cloth = 2.0;
    def.dynamic_friction_cloth_cloth = 0.1;
    def.threads = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.material.friction = 2.0;
    cloth.material.dynamic_friction = 0.1;
    cloth.material.restitution = 1.0;
    cloth.material.springs.stretch_stiffness *= 100.0; /* softer ones are torn less */
    for (int k = 0; k < 2; k++) {
        tulle_cloth_id id;
        cloth.mesh = tulle_mesh_get_view(&of->sheets[k]);
        assert_int_equal(tulle_world_add_cloth(world, &cloth, &id, NULL), TULLE_OK);
    }
    tulle_obstacle_def ball = tulle_obstacle_def_default();
    ball.mesh = tulle_mesh_get_view(&of->sphere);
    ball.friction = 2.0;
    ball.dynamic_friction = 0.1;
    ball.restitution = 1.0;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &ball, &id, NULL), TULLE_OK);
    return world;
}

/* Contact by the paper's response can give energy without end. Then the step fails, says so, and
 * leaves the world as it was; what is accepted stays within bounds, and so does the work. */
static void energy_from_contact_ends_in_an_error(void **state) {
    (void)state;
    scene of = make_scene();
    int failures = 0;
    tulle_integrator const integrators[3] = {
        TULLE_INTEGRATOR_IMPLICIT_EULER, TULLE_INTEGRATOR_CRANK_NICOLSON, TULLE_INTEGRATOR_BDF2};
    for (int k = 0; k < 3; k++) {
        tulle_world *world = make_rebounding(&of, integrators[k]);
        tulle_step_report report = {0};
        tulle_error error = {0};
        tulle_status status = TULLE_OK;
        double stretch = 0.0;
        int steps = 0;
        uint64_t contacts = 0, hash = 0;
        for (; steps < 60 && status == TULLE_OK; steps++) {
            hash = tulle_world_get_state_hash(world);
            status = tulle_world_step(world, TIME_STEP, &report, &error);
            stretch = report.max_stretch > stretch ? report.max_stretch : stretch;
            contacts = report.contacts > contacts ? report.contacts : contacts;
        }
        print_message("integrator %d: %d steps, stretch %.3g, %llu contacts, %s\n",
                      (int)integrators[k], steps, stretch, (unsigned long long)contacts,
                      error.message);
        assert_true(stretch < 6.0);
        assert_true(contacts < 4000);
        if (status != TULLE_OK) {
            failures++;
            assert_int_equal(status, TULLE_ERROR_STEP_FAILED);
            assert_non_null(strstr(error.message, "paper's response tears cloth"));
            assert_true(tulle_world_get_state_hash(world) == hash);
        }
        tulle_world_destroy(world);
    }
    assert_true(failures > 0); /* or nothing was tested */
    destroy_scene(&of);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_state_is_clean),
        cmocka_unit_test(saved_states_go_on),
        cmocka_unit_test(energy_from_contact_ends_in_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
