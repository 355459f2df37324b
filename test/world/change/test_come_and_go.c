/* Objects that come and go while a world runs (tulle/objects.h), against worlds that had them from
 * the start on, and against such that never had them. */
#include "support/body_world.h"
#include "support/object_world.h"
#include "support/paper_options.h"
#include "support/test_support.h"

#include <math.h>
#include <stdbool.h>

enum { STEPS = 40, STEPS_TO_REST = 120 };

static const double ASIDE = 3.0; /* [m] where a thing touches nothing */

/* All things but one, and without bodies where nothing moves them; their ids by thing. */
static tulle_world *make_without(const tulle_world_def *def, thing left_out,
                                 tulle_object_id ids[THING_COUNT]) {
    tulle_world *const world = things_make_world(def);
    bool const has_bodies = !def || get_paper(def).response == TULLE_RESPONSE_COUPLED;
    for (thing what = 0; what < THING_COUNT; what++)
        if (what != left_out && (has_bodies || !thing_is_body(what)))
            ids[what] = things_add(world, what, 0.0);
    return world;
}

static void expect_same(const tulle_world *one, const tulle_world *other, thing what, int step) {
    if (tulle_world_get_state_hash(one) != tulle_world_get_state_hash(other))
        fail_msg("thing %d: another state after step %d", (int)what, step);
}

/* What comes at time 0 after the start comes to the same as what is there before. */
static void as_before_the_start(void **state) {
    (void)state;
    tulle_object_id ids[THING_COUNT];
    for (int integrator = 0; integrator < 3; integrator++) {
        for (thing what = 0; what < THING_COUNT; what++) {
            tulle_world_def def = tulle_world_def_default();
            def.threads = 1;
            def.integrator = (tulle_integrator)integrator;
            tulle_world *const early = make_without(&def, what, ids);
            (void)things_add(early, what, 0.0);
            things_start(early);
            tulle_world *const late = make_without(&def, what, ids);
            things_start(late);
            (void)things_add(late, what, 0.0);
            expect_same(early, late, what, 0);
            for (int i = 1; i <= STEPS; i++) {
                things_step(early, 1);
                things_step(late, 1);
                expect_same(early, late, what, i);
            }
            tulle_world_destroy(early);
            tulle_world_destroy(late);
        }
    }
}

/* Changes what a host may change, so that there is more to keep. */
static void change_settings(tulle_world *world, const tulle_object_id ids[THING_COUNT],
                            thing left_out) {
    tulle_error error = {0};
    tulle_cloth_id const sheet = {ids[THING_SHEET].index, ids[THING_SHEET].generation};
    tulle_cloth_id const pinned = {ids[THING_PINNED].index, ids[THING_PINNED].generation};
    tulle_obstacle_id const ground = {ids[THING_GROUND].index, ids[THING_GROUND].generation};
    tulle_obstacle_id const box = {ids[THING_BOX].index, ids[THING_BOX].generation};
    tulle_wind const wind = {{0.3, 0.0, 0.0}, 0.1, 0.3, 0.5, 7, 0.7};
    tulle_contact_law const law = {0.1, 0.05, 0.0};
    things_fine(tulle_world_set_gravity(world, (double[]){0.0, 0.0, -8.0}, &error), &error);
    things_fine(tulle_world_set_wind(world, &wind, &error), &error);
    if (left_out != THING_SHEET) {
        double distance;
        tulle_world_get_distances(world, &distance, NULL, NULL);
        tulle_material material = tulle_cloth_def_default().material;
        material.area_density *= 1.5;
        things_fine(tulle_cloth_set_material(world, sheet, &material, &error), &error);
        things_fine(tulle_cloth_set_thickness(world, sheet, 0.5 * distance, &error), &error);
        if (left_out != THING_GROUND)
            things_fine(tulle_world_set_cloth_obstacle_law(world, sheet, ground, &law, &error),
                        &error);
    }
    if (left_out != THING_PINNED) {
        things_fine(tulle_cloth_release_pin(world, pinned, 0, &error), &error);
        tulle_attachment_def def = tulle_attachment_def_default();
        double const point[3] = {0.1, 0.1, 0.62};
        uint32_t const vertex = 35;
        tulle_attachment_id id;
        def.cloth = pinned;
        def.vertices = &vertex;
        def.vertex_count = 1;
        def.points = point;
        def.stiffness = 50.0;
        things_fine(tulle_world_attach(world, &def, &id, &error), &error);
    }
    if (left_out != THING_BOX)
        things_fine(tulle_obstacle_set_locks(world, box, 0, 4, &error), &error);
}

/* Comes and goes in a world that moves, rests or was changed: no bit is another one. */
static void visit(const tulle_world_def *def, thing what, bool is_changed) {
    static const int moments[] = {0, 1, 12, STEPS_TO_REST};
    tulle_object_id ids[2][THING_COUNT];
    tulle_world *const visited = make_without(def, what, ids[0]);
    tulle_world *const alone = make_without(def, what, ids[1]);
    things_start(visited);
    things_start(alone);
    for (size_t m = 0; m < sizeof moments / sizeof moments[0]; m++) {
        int const steps = moments[m] - (m > 0 ? moments[m - 1] : 0);
        for (int i = 0; i < steps; i++) {
            things_step(visited, 1);
            things_step(alone, 1);
            expect_same(visited, alone, what, moments[m] - steps + i + 1);
        }
        if (m == 2 && is_changed) {
            change_settings(visited, ids[0], what);
            change_settings(alone, ids[1], what);
        }
        uint64_t const before = tulle_world_get_state_hash(visited);
        tulle_object_id const guest = things_add(visited, what, ASIDE);
        assert_true(guest.generation == m + 1);
        if (tulle_world_get_state_hash(visited) == before)
            fail_msg("thing %d: nothing was added", (int)what);
        things_remove(visited, guest);
        expect_same(visited, alone, what, moments[m]);
        assert_true(tulle_world_get_state_hash(visited) == before);
    }
    for (int i = 0; i < 10; i++) {
        things_step(visited, 1);
        things_step(alone, 1);
        expect_same(visited, alone, what, i);
    }
    assert_int_equal(things_judge(visited), 0);
    tulle_world_destroy(visited);
    tulle_world_destroy(alone);
}

static void as_if_never_there(void **state) {
    (void)state;
    for (thing what = 0; what < THING_COUNT; what++) visit(NULL, what, true);
}

/* The paper's response keeps what each vertex does in contact. */
static void with_the_paper_s_response(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    for (thing what = 0; what < THING_COUNT; what++)
        if (!thing_is_body(what)) visit(&def, what, false);
}

/* A box that the host presses on a sheet on the ground, deeper than there is room. */
static tulle_world *make_pressed(tulle_on_pinch choice, tulle_drive drive, tulle_mesh *box) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.on_pinch = choice;
    tulle_world *const world = things_make_world(&def);
    (void)things_add(world, THING_SHEET, 0.0);
    (void)things_add(world, THING_GROUND, 0.0);
    *box = bodies_make_box(0.05, 0.05, 0.05, (double[]){0.02, 0.01, 0.08});
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(box);
    obstacle.drive = drive;
    tulle_error error = {0};
    things_fine(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    things_start(world);
    return world;
}

/* Tells the box where to go in the next step. */
static void press(tulle_world *world, tulle_drive drive, const tulle_mesh *box, int step) {
    static double const turn[4] = {1.0, 0.0, 0.0, 0.0};
    tulle_obstacle_id const id = {1, 1};
    double const shift[3] = {0.0, 0.0, -0.0015 * step};
    double places[3 * 64];
    tulle_error error = {0};
    assert_true(box->vertex_count <= 64);
    for (size_t i = 0; i < 3 * box->vertex_count; i++) places[i] = box->positions[i] + shift[i % 3];
    things_fine(
        drive == TULLE_DRIVE_RIGID
            ? tulle_obstacle_set_next_transform(world, id, shift, turn, TULLE_TRAVEL_MOVE, &error)
            : tulle_obstacle_set_next_positions(world, id, places, box->vertex_count,
                                                TULLE_TRAVEL_MOVE, &error),
        &error);
}

/* Steps; whether something pinched. */
static bool step_pinched(tulle_world *world) {
    tulle_step_report report;
    tulle_error error = {0};
    things_fine(tulle_world_step(world, THING_STEP, &report, &error), &error);
    return report.pinched || report.largest_lag > 0.0;
}

/* Things come and go again, aside. */
static void receive_guests(tulle_world *world) {
    tulle_object_id const guests[] = {things_add(world, THING_PINNED, ASIDE),
                                      things_add(world, THING_FRAMES, ASIDE)};
    things_remove(world, guests[0]);
    things_remove(world, guests[1]);
}

/* What on_pinch holds back or lets lag is kept, too, and so is what was given for the
 * next step. */
static void while_something_pinches(void **state) {
    (void)state;
    static const tulle_on_pinch choices[] = {TULLE_ON_PINCH_SLOW, TULLE_ON_PINCH_LAG};
    for (size_t c = 0; c < 4; c++) {
        tulle_drive const drive = c % 2 ? TULLE_DRIVE_RIGID : TULLE_DRIVE_DEFORMING;
        if (c == 3) continue; /* what is driven as a whole does not lag */
        tulle_mesh boxes[2];
        tulle_world *const visited = make_pressed(choices[c / 2], drive, &boxes[0]);
        tulle_world *const alone = make_pressed(choices[c / 2], drive, &boxes[1]);
        int pinched = 0;
        for (int i = 0; i < 60; i++) {
            press(visited, drive, &boxes[0], i);
            press(alone, drive, &boxes[1], i);
            if (pinched > 0 && i % 5 == 2) receive_guests(visited);
            pinched += step_pinched(visited);
            (void)step_pinched(alone);
            expect_same(visited, alone, THING_COUNT, i);
            if (pinched > 0 && i % 5 == 0) receive_guests(visited);
            expect_same(visited, alone, THING_COUNT, i);
        }
        if (pinched < 10) fail_msg("case %zu: nothing pinched", c);
        for (int k = 0; k < 2; k++) tulle_mesh_destroy(&boxes[k]);
        tulle_world_destroy(visited);
        tulle_world_destroy(alone);
    }
}

/* A world whose objects go one after the other, and come again, steps at all times. */
static void empties_and_fills(void **state) {
    (void)state;
    tulle_object_id ids[THING_COUNT];
    tulle_world *const world = make_without(NULL, THING_COUNT, ids);
    things_start(world);
    things_step(world, 20);
    for (thing what = 0; what < THING_COUNT; what++) {
        thing const gone = (what * 4 + 2) % THING_COUNT; /* in some other order */
        things_remove(world, ids[gone]);
        tulle_error error = {0};
        assert_int_equal(things_try_remove(world, ids[gone], &error), TULLE_ERROR_INVALID_ARGUMENT);
        assert_null(tulle_object_get_info(world, ids[gone]).name);
        things_step(world, 3);
        assert_int_equal(things_judge(world), 0);
    }
    tulle_counts const counts = tulle_world_get_counts(world);
    assert_true(counts.cloths == 0 && counts.obstacles == 0 && counts.cloth_vertices == 0);
    double const time = tulle_world_get_time(world);
    things_step(world, 2);
    assert_true(tulle_world_get_time(world) == time + 2.0 * THING_STEP);
    for (thing what = 0; what < THING_COUNT; what++) {
        tulle_object_id const id = things_add(world, what, 0.0);
        assert_true(id.generation == 2);
        assert_non_null(tulle_object_get_info(world, id).name);
        assert_null(tulle_object_get_info(world, ids[what]).name);
        things_step(world, 2);
        assert_int_equal(things_judge(world), 0);
    }
    things_step(world, 30);
    assert_int_equal(things_judge(world), 0);
    tulle_world_destroy(world);
}

/* Before the start, after it, and of what comes later. */
static void the_ground_alone_is_static(void **state) {
    (void)state;
    tulle_object_id ids[THING_COUNT];
    tulle_world *const world = make_without(NULL, THING_COUNT, ids);
    for (int when = 0; when < 2; when++) {
        for (thing what = 0; what < THING_COUNT; what++)
            assert_int_equal(tulle_object_get_info(world, ids[what]).is_static,
                             what == THING_GROUND);
        if (when == 0) things_start(world);
    }
    for (int k = 0; k < 2; k++) {
        thing const what = k == 0 ? THING_GROUND : THING_KEYS;
        things_remove(world, ids[what]);
        assert_int_equal(tulle_object_get_info(world, things_add(world, what, 0.0)).is_static,
                         k == 0);
    }
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_before_the_start),       cmocka_unit_test(as_if_never_there),
        cmocka_unit_test(with_the_paper_s_response), cmocka_unit_test(while_something_pinches),
        cmocka_unit_test(empties_and_fills),         cmocka_unit_test(the_ground_alone_is_static),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
