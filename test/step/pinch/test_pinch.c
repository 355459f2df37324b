/* Fingers that close on hanging cloth to nothing: held back before they tear it, while all else
 * goes on; and what the world says of it. */
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 60.0;
static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double OPEN = 0.01;             /* [m] each finger's way to the middle */
enum { FINGERS = 2 };

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not %.17g within %g", value, expected, tolerance);
}

/* A hanging sheet, pinned along its upper edge, and one that falls freely far away; two fingers
 * that close, lift by 5 cm and open. */
typedef struct vise {
    tulle_world *world;
    tulle_mesh sheets[2], fingers[FINGERS];
} vise;

/* [s] of the keyframes after the first at 0.1 s */
typedef struct vise_times {
    double closed, held, lifted, opened;
} vise_times;

static void pin_upper_edge(tulle_world *world, const tulle_mesh *sheet) {
    uint32_t upper[64];
    size_t count = 0;
    for (uint32_t v = 0; v < sheet->vertex_count; v++)
        if (sheet->positions[3 * v + 2] > 0.1499) upper[count++] = v;
    assert_true(count == 13);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(sheet);
    tulle_pin const pin = make_pin(upper, count, (double)INFINITY);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
}

static vise make_vise(tulle_on_pinch choice, vise_times times) {
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.wind.drag_coefficient = 0.0;
    def.on_pinch = choice;
    def.contact_distance = CONTACT_DISTANCE;
    def.threads = 1;
    vise made = {.sheets = {small_sheet(0.3, 13, 0.0), small_sheet(0.1, 3, 2.0)}};
    assert_int_equal(tulle_world_create(&def, &made.world, NULL), TULLE_OK);
    for (size_t v = 0; v < made.sheets[0].vertex_count; v++) { /* upright, in the plane y = 0 */
        double *const x = made.sheets[0].positions + 3 * v;
        x[2] = x[1];
        x[1] = 0.0;
    }
    for (size_t v = 0; v < made.sheets[1].vertex_count; v++) made.sheets[1].positions[3 * v] += 2.0;
    pin_upper_edge(made.world, &made.sheets[0]);
    small_add_cloth(made.world, &made.sheets[1]);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[2] = 0.05;
    box.size[1] = 0.05;
    static const char *const names[FINGERS] = {"left", "right"};
    for (int k = 0; k < FINGERS; k++) {
        double const side = k == 0 ? -1.0 : 1.0, way = -side * OPEN;
        made.fingers[k] = small_shape(box, 0, side * (0.025 + OPEN), 0.0);
        tulle_obstacle_def finger = tulle_obstacle_def_default();
        finger.mesh = tulle_mesh_get_view(&made.fingers[k]);
        finger.name = names[k];
        finger.friction = 0.8;
        tulle_keyframe const keys[] = {{0.1, {0, 0, 0}, {0, 0, 0}},
                                       {times.closed, {0, way, 0}, {0, 0, 0}},
                                       {times.held, {0, way, 0}, {0, 0, 0}},
                                       {times.lifted, {0, way, 0.05}, {0, 0, 0}},
                                       {times.opened, {0, 0, 0.05}, {0, 0, 0}}};
        finger.motion = (tulle_motion){keys, 5, {0, 0, 0}, 0};
        assert_int_equal(tulle_world_add_obstacle(made.world, &finger, NULL, NULL), TULLE_OK);
    }
    return made;
}

static void free_vise(vise *made) {
    tulle_world_destroy(made->world);
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&made->sheets[k]);
    for (int k = 0; k < FINGERS; k++) tulle_mesh_destroy(&made->fingers[k]);
}

/* Position of a finger's first vertex less that at the start. */
static void get_way(const vise *made, uint32_t finger, double way[3]) {
    const double *const x =
        tulle_obstacle_get_positions(made->world, (tulle_obstacle_id){finger, 1}, NULL);
    for (int c = 0; c < 3; c++) way[c] = x[c] - made->fingers[finger].positions[c];
}

/* While the script asks for less than the cloth needs: fingers apart, along with their script
 * otherwise, at the cost of steps without a pinch. */
static void check_held(const vise *made, const tulle_step_report *report, double lift) {
    double left[3], right[3];
    get_way(made, 0, left);
    get_way(made, 1, right);
    double const opening = 2.0 * OPEN - left[1] + right[1];
    if (!(opening > 0.2 * CONTACT_DISTANCE && opening < 2.0 * CONTACT_DISTANCE))
        fail_msg("step %d: fingers %g m apart", (int)report->step, opening);
    assert_near(left[2], lift, 1e-12);
    assert_near(right[2], lift, 1e-12);
    assert_true(left[0] == 0.0 && right[0] == 0.0);
}

static void close_slowly(vise_times times) {
    vise made = make_vise(TULLE_ON_PINCH_SLOW, times);
    bool has_begun = false, has_ended = false;
    uint32_t most_solves = 0;
    tulle_world *alone = NULL;
    tulle_world_def def = tulle_world_def_default();
    def.wind.drag_coefficient = 0.0;
    assert_int_equal(tulle_world_create(&def, &alone, NULL), TULLE_OK);
    small_add_cloth(alone, &made.sheets[1]);
    tulle_step_report report = {0};
    while (report.time < times.opened + 0.2) {
        tulle_error error = {0};
        assert_int_equal(tulle_world_step(made.world, STEP, &report, &error), TULLE_OK);
        const char *const message = tulle_world_last_message(made.world);
        bool const begins = report.pinched && !has_begun;
        if (begins) {
            assert_non_null(strstr(message, "is pinched near"));
            assert_non_null(strstr(message, "'left', 'right'"));
            assert_non_null(strstr(message, "cloth 0"));
        } else if (has_begun && !has_ended && message[0] != '\0') {
            assert_non_null(strstr(message, "'left', 'right' follow their script again at"));
            has_ended = true;
        } else {
            assert_true(message[0] == '\0'); /* said once */
        }
        has_begun |= begins;
        if (!begins && report.solve_count > most_solves) most_solves = report.solve_count;
        if (!begins && report.substeps > 4)
            fail_msg("step %d: %u substeps", (int)report.step, report.substeps);
        if (report.max_stretch > 1.2 || report.elastic_energy > 0.02)
            fail_msg("step %d: stretch %g, elastic energy %g J", (int)report.step,
                     report.max_stretch, report.elastic_energy);
        double const lift =
            0.05 * fmin(1.0, fmax(0.0, (report.time - times.held) / (times.lifted - times.held)));
        if (report.time > times.closed && report.time < times.lifted) {
            assert_int_equal(report.pinched, 1);
            check_held(&made, &report, lift);
        }
        /* what is elsewhere falls on, as if it were alone: in substeps implicit Euler falls less
         * far, by up to g h t / 2 */
        assert_int_equal(tulle_world_step(alone, STEP, NULL, NULL), TULLE_OK);
        const double *const x = tulle_cloth_get_positions(made.world, (tulle_cloth_id){1, 1}, NULL);
        const double *const y = tulle_cloth_get_positions(alone, (tulle_cloth_id){0, 1}, NULL);
        assert_near(x[2], y[2], 0.5 * 9.81 * STEP * report.time);
    }
    assert_true(has_begun && has_ended);
    if (most_solves > 80) fail_msg("%u solves in a step", most_solves);
    double way[3];
    for (uint32_t k = 0; k < FINGERS; k++) { /* where the script has them, whatever was before */
        get_way(&made, k, way);
        assert_near(way[1], 0.0, 1e-12);
        assert_near(way[2], 0.05, 1e-12);
    }
    assert_int_equal(small_judge(made.world, made.sheets, 2, made.fingers, FINGERS), 0);
    tulle_world_destroy(alone);
    free_vise(&made);
}

static void fingers_that_close_are_held_back(void **state) {
    (void)state;
    close_slowly((vise_times){0.4, 0.5, 0.8, 1.1});
}

/* They come from far beyond a contact distance in one step, and grip it all the same. */
static void fast_fingers_are_held_back(void **state) {
    (void)state;
    close_slowly((vise_times){0.11, 0.3, 0.6, 0.8});
}

/* A run that goes on from what was saved while fingers are held back is the same. */
static void what_is_held_back_is_saved(void **state) {
    (void)state;
    vise_times const times = {0.2, 0.3, 0.4, 0.5};
    vise a = make_vise(TULLE_ON_PINCH_SLOW, times), b = make_vise(TULLE_ON_PINCH_SLOW, times);
    tulle_step_report report = {0};
    for (int i = 0; i < 15; i++)
        assert_int_equal(tulle_world_step(a.world, STEP, &report, NULL), TULLE_OK);
    assert_int_equal(report.pinched, 1);
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_save_state(a.world, &bytes, &byte_count, NULL), TULLE_OK);
    assert_int_equal(tulle_world_load_state(b.world, bytes, byte_count, NULL), TULLE_OK);
    for (int i = 0; i < 21; i++) {
        assert_true(tulle_world_get_state_hash(a.world) == tulle_world_get_state_hash(b.world));
        assert_int_equal(tulle_world_step(a.world, STEP, &report, NULL), TULLE_OK);
        assert_int_equal(tulle_world_step(b.world, STEP, NULL, NULL), TULLE_OK);
    }
    assert_int_equal(report.pinched, 0);
    assert_true(tulle_world_get_state_hash(a.world) == tulle_world_get_state_hash(b.world));
    tulle_world_free_state(a.world, bytes, byte_count);
    free_vise(&a);
    free_vise(&b);
}

/* The state that is kept is one before anything was torn. */
static void stop_comes_before_the_cloth_is_torn(void **state) {
    (void)state;
    vise made = make_vise(TULLE_ON_PINCH_STOP, (vise_times){0.4, 0.5, 0.8, 1.1});
    tulle_step_report report = {0}, last = {0};
    tulle_status status = TULLE_OK;
    while (status == TULLE_OK) {
        tulle_error error = {0};
        last = report;
        status = tulle_world_step(made.world, STEP, &report, &error);
        assert_true(report.time < 0.5);
        if (status != TULLE_OK) assert_non_null(strstr(error.message, "between 'left', 'right'"));
    }
    assert_int_equal(status, TULLE_ERROR_PINCHED);
    if (!(last.max_stretch < 1.1 && last.elastic_energy < 2e-3))
        fail_msg("stretch %g, elastic energy %g J", last.max_stretch, last.elastic_energy);
    free_vise(&made);
}

/* A moving obstacle runs into cloth that pins hold: it alone is held back. */
static void one_that_runs_into_held_cloth_waits(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.2, 5, 0.0);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = box.size[2] = 0.1;
    tulle_mesh mesh = small_shape(box, 0, 0, -0.1);
    tulle_world_def def = tulle_world_def_default();
    def.on_pinch = TULLE_ON_PINCH_SLOW;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    uint32_t all[25];
    for (uint32_t v = 0; v < 25; v++) all[v] = v;
    tulle_pin const pin = make_pin(all, 25, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_obstacle_def rising = tulle_obstacle_def_default();
    rising.mesh = tulle_mesh_get_view(&mesh);
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}},
                                   {0.2, {0.1, 0, 0.1}, {0, 0, 0}},
                                   {0.4, {0.2, 0, 0}, {0, 0, 0}}};
    rising.motion = (tulle_motion){keys, 3, {0, 0, 0}, 0};
    assert_int_equal(tulle_world_add_obstacle(world, &rising, NULL, NULL), TULLE_OK);
    tulle_step_report report = {0};
    bool was_pinched = false;
    for (int i = 0; i < 30; i++) {
        assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
        was_pinched |= report.pinched != 0;
        const double *const x =
            tulle_obstacle_get_positions(world, (tulle_obstacle_id){0, 1}, NULL);
        double const rise = 0.1 * fmax(0.0, 1.0 - fabs(report.time / 0.2 - 1.0));
        double const got = x[2] - mesh.positions[2];
        assert_near(x[0] - mesh.positions[0], fmin(0.5 * report.time, 0.2), 1e-12);
        assert_true(got < rise + 1e-12 && got < 0.05);
    }
    assert_true(was_pinched);
    assert_int_equal(report.pinched, 0);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fingers_that_close_are_held_back),
        cmocka_unit_test(fast_fingers_are_held_back),
        cmocka_unit_test(what_is_held_back_is_saved),
        cmocka_unit_test(stop_comes_before_the_cloth_is_torn),
        cmocka_unit_test(one_that_runs_into_held_cloth_waits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
