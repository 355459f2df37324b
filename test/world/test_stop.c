/* A step that is asked to stop, at whatever moment, leaves the world bit for bit as it was, and
 * goes on to the same bits as if it had never been asked: with rigid bodies, a moving obstacle,
 * pairs that are ignored, a pinch, and by the paper's response. */
#include "support/body_world.h"
#include "support/paper_options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { STEPS = 14 };

typedef struct stop_script {
    long left;  /* asks that are still answered with no */
    long count; /* asks so far */
    uint32_t most_substeps;
    bool tells_solves; /* the count of solves grew while a substep was under way */
    const tulle_world *world;
    tulle_step_progress last;
} stop_script;

static int answer(void *context) {
    stop_script *const script = context;
    script->count++;
    tulle_step_progress const before = script->last;
    script->last = tulle_world_get_step_progress(script->world);
    if (script->count > 1 && script->last.substep == before.substep)
        script->tells_solves |= script->last.solve_count > before.solve_count;
    if (script->last.substep > script->most_substeps) script->most_substeps = script->last.substep;
    return script->left-- <= 0;
}

typedef struct stop_case {
    const char *name;
    tulle_response response;
    bool has_body, has_pinch, is_caught;
    int threads;
} stop_case;

/* Two sheets fall on a box, at 6 m/s but by the paper's response, under one that comes down; where
 * asked for, a ball falls after them and the second box comes up against the first. */
static tulle_world *make_world(const stop_case *test) {
    tulle_mesh sheets[2] = {small_sheet(0.4, 10, 0.01), small_sheet(0.3, 8, 0.03)};
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.2;
    box.size[2] = 0.1;
    tulle_mesh boxes[2] = {small_shape(box, 0.0, 0.0, -0.055), small_shape(box, 0.0, 0.0, 0.15)};
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.threads = test->threads;
    change_paper(&def)->response = test->response;
    def.start_intersections = TULLE_START_IGNORE;
    def.on_pinch = TULLE_ON_PINCH_SLOW;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    for (int k = 0; k < 2; k++) {
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheets[k]);
        cloth.velocity[2] = test->response == TULLE_RESPONSE_PAPER ? -0.3 : -6.0;
        assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    }
    small_add_obstacle(world, &boxes[0]);
    tulle_obstacle_def pusher = tulle_obstacle_def_default();
    pusher.mesh = tulle_mesh_get_view(&boxes[1]);
    tulle_keyframe const keys[] = {{0.02, {0, 0, 0}, {0, 0, 0}},
                                   {0.12, {0, 0, test->has_pinch ? -0.12 : -0.03}, {0, 0, 0}}};
    pusher.motion = (tulle_motion){keys, 2, {0, 0, 0}, 0};
    assert_int_equal(tulle_world_add_obstacle(world, &pusher, NULL, NULL), TULLE_OK);
    tulle_mesh ball = bodies_make_ball(0.03, 6, (double[3]){0.13, 0.0, 0.09});
    tulle_mesh caught = small_shape(box, 0.2, 0.2, 0.0);
    if (test->has_body) {
        tulle_body const body = {.is_dynamic = 1, .mass = 0.2, .velocity = {0, 0, -3.0}};
        bodies_add_obstacle(world, &ball, 0.3, &body);
    }
    if (test->is_caught) small_add_obstacle(world, &caught);
    for (int k = 0; k < 2; k++) {
        tulle_mesh_destroy(&sheets[k]);
        tulle_mesh_destroy(&boxes[k]);
    }
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&caught);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    return world;
}

static tulle_step_report step(tulle_world *world) {
    tulle_step_report report;
    tulle_error error = {0};
    if (tulle_world_step(world, 1.0 / 100.0, &report, &error) != TULLE_OK)
        fail_msg("step %llu: %s", (unsigned long long)tulle_world_get_step_count(world),
                 error.message);
    return report;
}

typedef struct saved_state {
    void *bytes;
    size_t count;
} saved_state;

static saved_state save(const tulle_world *world) {
    saved_state state = {0};
    assert_int_equal(tulle_world_save_state(world, &state.bytes, &state.count, NULL), TULLE_OK);
    return state;
}

/* Stops the coming step after so many asks; false when it was over before. */
static bool stop_step(tulle_world *world, stop_script *script, long asks) {
    saved_state const before = save(world);
    tulle_error error = {0};
    tulle_step_report report;
    uint64_t const hash = tulle_world_get_state_hash(world);
    script->left = asks;
    script->count = 0;
    tulle_status const status = tulle_world_step(world, 1.0 / 100.0, &report, &error);
    bool const is_stopped = status == TULLE_ERROR_INTERRUPTED;
    if (is_stopped) {
        saved_state const after = save(world);
        assert_int_equal(script->count, asks + 1); /* once is enough */
        assert_true(script->last.is_under_way);
        assert_in_range(script->last.step, report.step, report.step);
        assert_true(script->last.share >= 0.0 && script->last.share <= 1.0);
        assert_int_equal(hash, tulle_world_get_state_hash(world));
        assert_int_equal(before.count, after.count);
        assert_memory_equal(before.bytes, after.bytes, before.count);
        assert_non_null(strstr(error.message, "interrupted"));
        tulle_world_free_state(world, after.bytes, after.count);
    } else {
        assert_int_equal(status, TULLE_OK);
    }
    assert_false(tulle_world_get_step_progress(world).is_under_way);
    tulle_world_free_state(world, before.bytes, before.count);
    return is_stopped;
}

static void stopped_steps_leave_no_trace(const stop_case *test) {
    tulle_world *const plain = make_world(test), *const stopped = make_world(test);
    stop_script script = {.world = stopped};
    uint64_t substeps = 0, rescues = 0, pinched = 0, most_ignored = 0, stops = 0;
    for (int i = 0; i < STEPS; i++) {
        tulle_step_report const report = step(plain);
        substeps += report.substeps;
        rescues += report.rescue_impact_zones + report.rescue_component_scalings;
        pinched += report.pinched != 0;
        if (report.ignored_pairs > most_ignored) most_ignored = report.ignored_pairs;
        tulle_world_set_stop_request(stopped, answer, &script);
        long asks = 0;
        while (stop_step(stopped, &script, asks)) { /* nearer and nearer to the end of the step */
            asks = 3 * asks + 1 + i % 3;
            stops++;
        }
        if (tulle_world_get_state_hash(plain) != tulle_world_get_state_hash(stopped))
            fail_msg("%s: other bits after step %d", test->name, i);
    }
    tulle_world_set_stop_request(stopped, NULL, NULL);
    step(plain), step(stopped);
    assert_int_equal(tulle_world_get_state_hash(plain), tulle_world_get_state_hash(stopped));
    print_message("%s: %llu stops, %llu substeps, %llu rescues, %llu pinched, %llu ignored\n",
                  test->name, (unsigned long long)stops, (unsigned long long)substeps,
                  (unsigned long long)rescues, (unsigned long long)pinched,
                  (unsigned long long)most_ignored);
    assert_true(stops > 3 * STEPS);
    assert_true(script.most_substeps >= 1);
    assert_true(script.tells_solves);
    if (test->has_pinch) assert_true(pinched > 0);
    if (test->is_caught) assert_true(most_ignored > 0);
    tulle_world_destroy(plain);
    tulle_world_destroy(stopped);
}

static void steps_can_be_stopped(void **state) {
    (void)state;
    const stop_case cases[] = {
        {.name = "plain", .threads = 1},
        {.name = "two threads", .threads = 2},
        {.name = "body", .has_body = true, .threads = 1},
        {.name = "pinch", .has_pinch = true, .threads = 1},
        {.name = "caught", .is_caught = true, .threads = 2},
        {.name = "paper", .response = TULLE_RESPONSE_PAPER, .threads = 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        stopped_steps_leave_no_trace(&cases[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_can_be_stopped)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
