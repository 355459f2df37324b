/* Worlds in which nothing moves by itself: empty ones, and such with obstacles alone. They step,
 * and what the host gives goes where it says. */
#include "tulle/tulle.h"

#include "support/paper_options.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 64.0; /* [s] */
enum { STEPS = 8 };

static void expect(tulle_status wanted, tulle_status status, const tulle_error *error) {
    if (status != wanted)
        fail_msg("status %d, not %d: %s", (int)status, (int)wanted, error->message);
}

/* An empty world, or one with a box that the host moves. */
static tulle_world *make_world(bool has_box, tulle_detect_method method, int threads) {
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->detection.method = method;
    def.threads = threads;
    tulle_world *world;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    if (!has_box) return world;
    tulle_mesh box = small_shape(tulle_shape_def_default(TULLE_SHAPE_BOX), 0.0, 0.0, 0.0);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&box);
    obstacle.drive = TULLE_DRIVE_RIGID;
    expect(TULLE_OK, tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    tulle_mesh_destroy(&box);
    expect(TULLE_OK, tulle_world_start(world, &error), &error);
    return world;
}

/* Step number i, from 0. */
static uint64_t step(tulle_world *world, int i, bool has_box) {
    tulle_error error = {0};
    tulle_obstacle_id const box = {0, 1};
    double const place[3] = {0.125 * (i + 1), 0.0, 0.0}, turn[4] = {1.0, 0.0, 0.0, 0.0};
    if (has_box)
        expect(
            TULLE_OK,
            tulle_obstacle_set_next_transform(world, box, place, turn, TULLE_TRAVEL_MOVE, &error),
            &error);
    tulle_step_report report;
    expect(TULLE_OK, tulle_world_step(world, STEP, &report, &error), &error);
    assert_true(report.substeps == 1 && report.contacts == 0 && report.cg_converged);
    assert_true(tulle_world_get_time(world) == STEP * (i + 1));
    return tulle_world_get_state_hash(world);
}

static void steps_and_goes_back(void **state) {
    (void)state;
    static const tulle_detect_method methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_PAPER};
    for (int kind = 0; kind < 8; kind++) {
        bool const has_box = kind % 2;
        tulle_detect_method const method = methods[kind / 2 % 2];
        tulle_world *const world = make_world(has_box, method, 1 + kind / 4);
        tulle_world *const fresh = make_world(has_box, method, 1);
        double const start =
            has_box ? tulle_obstacle_get_positions(world, (tulle_obstacle_id){0, 1}, NULL)[0] : 0.0;
        uint64_t hashes[STEPS];
        void *bytes = NULL;
        size_t size = 0;
        tulle_error error = {0};
        for (int i = 0; i < STEPS; i++) {
            hashes[i] = step(world, i, has_box);
            if (i == 3)
                expect(TULLE_OK, tulle_world_save_state(world, &bytes, &size, &error), &error);
        }
        expect(TULLE_OK, tulle_world_load_state(world, bytes, size, &error), &error);
        expect(TULLE_OK, tulle_world_load_state(fresh, bytes, size, &error), &error);
        for (int i = 4; i < STEPS; i++) {
            assert_true(step(world, i, has_box) == hashes[i]);
            assert_true(step(fresh, i, has_box) == hashes[i]);
        }
        if (has_box) {
            const double *const x =
                tulle_obstacle_get_positions(world, (tulle_obstacle_id){0, 1}, NULL);
            assert_true(fabs(x[0] - start - 0.125 * STEPS) < 1e-15);
        }
        double contact, gap;
        tulle_world_get_distances(world, &contact, NULL, &gap);
        assert_true(contact == 0.0 && gap == 0.0); /* nothing meets anything */
        const tulle_contact *contacts;
        size_t count;
        expect(TULLE_OK, tulle_world_get_contacts(world, &contacts, &count, &error), &error);
        assert_int_equal(count, 0);
        tulle_world_free_state(world, bytes, size);
        tulle_world_destroy(world);
        tulle_world_destroy(fresh);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_and_goes_back)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
