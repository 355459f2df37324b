/* The paper's response in a world: every state is free of intersection, and what it keeps from step
 * to step belongs to the saved state. */
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
    def.response = response;
    def.motion_space = space;
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
        tulle_motion_space kept = TULLE_MOTION_SPACE_CONE;
        assert_int_equal(tulle_world_get_response(world, &kept), TULLE_RESPONSE_PAPER);
        assert_int_equal(kept, space);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_state_is_clean),
        cmocka_unit_test(saved_states_go_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
