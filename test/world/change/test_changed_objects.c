/* What a change of the objects (tulle/objects.h) does beside: what appears into something, what
 * rests on what goes, attachments, events, filters, laws, saved states, want of memory. */
#include "support/body_world.h"
#include "support/object_world.h"
#include "support/pins.h"
#include "support/test_support.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static tulle_error error;

static tulle_cloth_id as_cloth(tulle_object_id id) {
    return (tulle_cloth_id){id.index, id.generation};
}

static tulle_obstacle_id as_obstacle(tulle_object_id id) {
    return (tulle_obstacle_id){id.index, id.generation};
}

/* ---- what appears into something ---- */

/* A sheet that lies on the ground, and a ball that is put right through it. */
static tulle_world *make_lying(tulle_start_intersections choice) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.start_intersections = choice;
    tulle_world *const world = things_make_world(&def);
    (void)things_add(world, THING_SHEET, 0.0);
    (void)things_add(world, THING_GROUND, 0.0);
    things_start(world);
    things_step(world, 40);
    return world;
}

static tulle_status add_through(tulle_world *world, tulle_obstacle_id *id) {
    tulle_mesh box = bodies_make_box(0.05, 0.05, 0.04, (double[]){0.02, 0.01, 0.021});
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.name = "box through the sheet";
    def.mesh = tulle_mesh_get_view(&box);
    tulle_status const status = tulle_world_add_obstacle(world, &def, id, &error);
    tulle_mesh_destroy(&box);
    return status;
}

static void refused(void **unused) {
    (void)unused;
    tulle_world *const world = make_lying(TULLE_START_REFUSE);
    tulle_world *const other = make_lying(TULLE_START_REFUSE);
    uint64_t const before = tulle_world_get_state_hash(world);
    tulle_obstacle_id id = {7, 7};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(add_through(world, &id), TULLE_ERROR_INTERSECTING_START);
        assert_non_null(strstr(error.message, "when 'box through the sheet' is added"));
        assert_true(id.index == 7);
        assert_true(tulle_world_get_state_hash(world) == before);
        size_t count, overlap_count;
        const tulle_intersection *const pairs = tulle_world_get_intersections(world, &count);
        assert_non_null(tulle_world_get_overlaps(world, &overlap_count));
        assert_true(count > 0 && overlap_count == count);
        for (size_t k = 0; k < count; k++)
            assert_true(pairs[k].object_a == 0 && pairs[k].object_b == 2);
    }
    /* wholly inside the ground nothing intersects, and yet it is refused */
    tulle_mesh inner = small_sheet(0.1, 4, -0.1);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&inner);
    assert_int_equal(tulle_world_add_cloth(world, &def, NULL, &error),
                     TULLE_ERROR_INTERSECTING_START);
    assert_non_null(strstr(error.message, "lies inside"));
    tulle_mesh_destroy(&inner);
    /* so is a shell around the sheet */
    tulle_mesh shell = bodies_make_box(0.9, 0.9, 0.9, (double[]){0.0, 0.0, 0.46});
    for (size_t v = 0; v < shell.vertex_count; v++) shell.positions[3 * v + 2] -= 0.458;
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&shell);
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, &error),
                     TULLE_ERROR_INTERSECTING_START);
    assert_non_null(strstr(error.message, "lies inside"));
    tulle_mesh_destroy(&shell);
    assert_true(tulle_world_get_state_hash(world) == before);
    assert_int_equal(tulle_world_get_counts(world).obstacles, 1);
    things_step(world, 10);
    things_step(other, 10);
    assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(other));
    /* the slot is as if nothing had been there */
    assert_true(things_add(world, THING_KEYS, 0.0).generation == 1);
    tulle_world_destroy(world);
    tulle_world_destroy(other);
}

static void ignored(void **unused) {
    (void)unused;
    tulle_world *const world = make_lying(TULLE_START_IGNORE);
    tulle_obstacle_id id, second;
    assert_int_equal(add_through(world, &id), TULLE_OK);
    size_t const crossing = things_judge(world);
    assert_true(crossing > 0);
    tulle_step_report report;
    things_fine(tulle_world_step(world, THING_STEP, &report, &error), &error);
    assert_true(report.ignored_pairs > 0 && report.ignored_pairs <= crossing);
    /* another one, aside: the pairs of the first stay ignored */
    uint64_t const ignored_pairs = report.ignored_pairs;
    tulle_object_id const aside = things_add(world, THING_KEYS, 0.0);
    things_fine(tulle_world_step(world, THING_STEP, &report, &error), &error);
    assert_true(report.ignored_pairs > 0 && report.ignored_pairs <= ignored_pairs);
    things_remove(world, aside);
    /* and with the first one they go */
    things_fine(tulle_world_remove_obstacle(world, id, &error), &error);
    things_fine(tulle_world_step(world, THING_STEP, &report, &error), &error);
    assert_true(report.ignored_pairs == 0);
    assert_int_equal(things_judge(world), 0);
    assert_int_equal(add_through(world, &second), TULLE_OK);
    assert_true(second.index == id.index && second.generation == id.generation + 1);
    tulle_world_destroy(world);
}

/* A sheet on four pins, over a body that sleeps. A box that is put into the sheet pushes it out,
 * but not what pins and rigid attachments hold; and what sleeps wakes. */
/* Pairs that are ignored with what comes stand where they would from the start on. */
static void ignored_as_from_the_start(void **unused) {
    (void)unused;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.start_intersections = TULLE_START_IGNORE;
    tulle_mesh boxes[2] = {bodies_make_box(0.2, 0.05, 0.04, (double[]){0.0, 0.02, 0.03}),
                           bodies_make_box(0.2, 0.05, 0.04, (double[]){0.0, -0.02, 0.03})};
    tulle_world *worlds[2];
    for (int late = 0; late < 2; late++) {
        tulle_world *const world = worlds[late] = things_make_world(&def);
        (void)things_add(world, THING_SHEET, 0.0);
        (void)small_add_obstacle(world, &boxes[0]);
        if (late) things_start(world);
        (void)small_add_obstacle(world, &boxes[1]);
        things_start(world);
    }
    for (int i = 0; i < 10; i++) {
        assert_true(tulle_world_get_state_hash(worlds[0]) == tulle_world_get_state_hash(worlds[1]));
        things_step(worlds[0], 1);
        things_step(worlds[1], 1);
    }
    for (int i = 0; i < 2; i++) tulle_world_destroy(worlds[i]);
    tulle_mesh_destroy(&boxes[0]);
    tulle_mesh_destroy(&boxes[1]);
}

/* A sheet on four pins, over a body that sleeps. A box that is put into the sheet pushes it out,
 * but not what pins and rigid attachments hold; and what sleeps wakes. */
static void untangled(void **unused) {
    (void)unused;
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    world_def.start_intersections = TULLE_START_UNTANGLE;
    tulle_world *const world = things_make_world(&world_def);
    (void)things_add(world, THING_GROUND, 0.0);
    tulle_obstacle_id const sleeper = as_obstacle(things_add(world, THING_BOX, 0.0));
    tulle_mesh sheet = small_sheet(0.2, 6, 0.6);
    uint32_t const corners[] = {0, 5, 30, 35}, held = 15;
    tulle_pin const pin = make_pin(corners, 4, (double)INFINITY);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    def.pins = &pin;
    def.pin_count = 1;
    tulle_cloth_id cloth;
    things_fine(tulle_world_add_cloth(world, &def, &cloth, &error), &error);
    things_step(world, 100);
    tulle_attachment_def tie = tulle_attachment_def_default();
    tulle_attachment_id attachment;
    size_t count;
    double before[3 * 36];
    memcpy(before, tulle_cloth_get_positions(world, cloth, &count), sizeof before);
    tie.cloth = cloth;
    tie.vertices = &held;
    tie.vertex_count = 1;
    tie.points = before + 3 * held;
    things_fine(tulle_world_attach(world, &tie, &attachment, &error), &error);
    things_step(world, 2);
    memcpy(before, tulle_cloth_get_positions(world, cloth, &count), sizeof before);
    assert_true(tulle_obstacle_is_asleep(world, sleeper));
    const double *const at = before + 3 * 14;
    tulle_mesh box = bodies_make_box(0.03, 0.03, 0.03, (double[]){at[0], at[1], at[2] + 0.012});
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&box);
    things_fine(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    assert_false(tulle_obstacle_is_asleep(world, sleeper));
    assert_int_equal(things_judge(world), 0);
    assert_true(tulle_world_get_untangle_report(world).moved_vertices > 3);
    const double *const after = tulle_cloth_get_positions(world, cloth, &count);
    for (size_t k = 0; k < 3; k++) {
        assert_true(after[3 * held + k] == before[3 * held + k]);
        for (size_t c = 0; c < 4; c++)
            assert_true(after[3 * corners[c] + k] == before[3 * corners[c] + k]);
    }
    for (int i = 0; i < 20; i++) {
        things_step(world, 1);
        assert_int_equal(things_judge(world), 0);
    }
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* What is not in the scene yet, or no more, meets nothing that comes. */
static void absent_ones_meet_nothing(void **unused) {
    (void)unused;
    tulle_world *const world = things_make_world(NULL);
    (void)things_add(world, THING_SHEET, 0.0);
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[]){0.0, 0.0, 0.6});
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_obstacle_id id, late;
    def.mesh = tulle_mesh_get_view(&box);
    def.appear_time = 1.0;
    things_fine(tulle_world_add_obstacle(world, &def, &id, &error), &error);
    things_start(world);
    things_step(world, 4);
    tulle_object_id const pinned = things_add(world, THING_PINNED, 0.0); /* right through it */
    assert_int_equal(tulle_obstacle_is_present(world, id), 0);
    def.appear_time = 1.1; /* nor does what comes and is not there yet */
    things_fine(tulle_world_add_obstacle(world, &def, &late, &error), &error);
    assert_int_equal(tulle_obstacle_is_present(world, late), 0);
    def.appear_time = 0.0;
    def.disappear_time = 4.0 * THING_STEP;
    things_fine(tulle_world_add_obstacle(world, &def, &late, &error), &error);
    assert_int_equal(tulle_obstacle_is_present(world, late), 0);
    things_step(world, 10);
    def.disappear_time = 2.0;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &late, &error),
                     TULLE_ERROR_INTERSECTING_START);
    things_remove(world, pinned);
    things_fine(tulle_world_add_obstacle(world, &def, &late, &error), &error);
    assert_int_equal(tulle_obstacle_is_present(world, late), 1);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* ---- what rests on what goes ---- */

static void sleepers_wake_when_their_floor_goes(void **unused) {
    (void)unused;
    tulle_world *const world = things_make_world(NULL);
    tulle_object_id const sheet = things_add(world, THING_SHEET, 0.0);
    tulle_object_id const ground = things_add(world, THING_GROUND, 0.0);
    tulle_obstacle_id const box = as_obstacle(things_add(world, THING_BOX, 0.0));
    things_start(world);
    things_step(world, 120);
    assert_true(tulle_obstacle_is_asleep(world, box));
    double const height = bodies_get_transform(world, box).position[2];
    /* what does not touch it comes and goes without waking it */
    things_remove(world, things_add(world, THING_BALL, 0.0));
    assert_true(tulle_obstacle_is_asleep(world, box));
    things_remove(world, sheet);
    assert_true(tulle_obstacle_is_asleep(world, box));
    things_step(world, 3);
    assert_true(tulle_obstacle_is_asleep(world, box));
    things_remove(world, ground);
    assert_false(tulle_obstacle_is_asleep(world, box));
    things_step(world, 16);
    double const fallen = height - bodies_get_transform(world, box).position[2];
    double const time = 16.0 * THING_STEP;
    assert_true(fabs(fallen - 0.5 * 9.81 * time * (time + THING_STEP)) < 1e-6); /* implicit Euler */
    tulle_world_destroy(world);
}

/* Three boxes on one another sleep as a group, and wake when one of them goes; what is apart sleeps
 * on, also in a state that is saved. */
static void a_group_wakes_when_one_of_it_goes(void **unused) {
    (void)unused;
    enum { STACKED = 3, APART = STACKED, BOXES };
    for (int removed = 0; removed < STACKED; removed++) {
        tulle_world *const world = things_make_world(NULL);
        tulle_body const body = {
            .is_dynamic = 1, .density = 300.0, .sleep_speed = 0.02, .sleep_time = 0.2};
        (void)things_add(world, THING_SHEET, 3.0);
        (void)things_add(world, THING_GROUND, 0.0);
        tulle_obstacle_id ids[BOXES];
        for (int i = 0; i < BOXES; i++) {
            bool const is_apart = i == APART;
            tulle_mesh box = bodies_make_box(
                0.1, 0.1, 0.1,
                (double[]){is_apart ? 0.5 : 0.0, 0.0, is_apart ? 0.06 : 0.06 + 0.11 * i});
            ids[i] = bodies_add_obstacle(world, &box, 0.5, &body);
            tulle_mesh_destroy(&box);
        }
        things_start(world);
        things_step(world, 150);
        for (int i = 0; i < BOXES; i++) assert_true(tulle_obstacle_is_asleep(world, ids[i]));
        double const height = bodies_get_transform(world, ids[1]).position[2];
        things_fine(tulle_world_remove_obstacle(world, ids[removed], &error), &error);
        for (int i = 0; i < BOXES; i++)
            assert_int_equal(tulle_obstacle_is_asleep(world, ids[i]), i == APART);
        void *bytes;
        size_t byte_count;
        uint64_t const hash = tulle_world_get_state_hash(world);
        things_fine(tulle_world_save_state(world, &bytes, &byte_count, &error), &error);
        things_step(world, 60);
        if (removed == 0)
            assert_true(bodies_get_transform(world, ids[1]).position[2] < height - 0.08);
        assert_true(tulle_obstacle_is_asleep(world, ids[APART]));
        things_fine(tulle_world_load_state(world, bytes, byte_count, &error), &error);
        assert_true(tulle_world_get_state_hash(world) == hash);
        tulle_world_free_state(world, bytes, byte_count);
        tulle_world_destroy(world);
    }
}

/* Cloth that comes with a velocity keeps it where nothing acts on it, whatever the integrator. */
static void what_comes_moves_on(void **unused) {
    (void)unused;
    for (int integrator = 0; integrator < 3; integrator++) {
        tulle_world_def def = tulle_world_def_default();
        def.threads = 1;
        def.integrator = (tulle_integrator)integrator;
        memset(def.gravity, 0, sizeof def.gravity);
        def.wind.drag_coefficient = 0.0;
        tulle_world *const world = things_make_world(&def);
        (void)things_add(world, THING_SHEET, 0.0);
        things_step(world, 7);
        tulle_mesh sheet = small_sheet(0.2, 5, 1.0);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        tulle_cloth_id id;
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.material.air_damping = 0.0;
        cloth.velocity[0] = 0.1;
        things_fine(tulle_world_add_cloth(world, &cloth, &id, &error), &error);
        tulle_mesh_destroy(&sheet);
        size_t count;
        const double *x = tulle_cloth_get_positions(world, id, &count);
        double const start = x[0];
        for (int i = 1; i <= 10; i++) {
            things_step(world, 1);
            x = tulle_cloth_get_positions(world, id, &count);
            assert_true(fabs(x[0] - start - 0.1 * i * THING_STEP) < 1e-9);
        }
        tulle_world_destroy(world);
    }
}

/* ---- attachments, events, user data ---- */

static tulle_attachment_id attach(tulle_world *world, tulle_attachment_def def) {
    static uint32_t const vertices[] = {0, 1};
    static double const points[] = {-0.15, -0.15, 0.2, -0.11, -0.15, 0.2};
    tulle_attachment_id id;
    def.vertices = vertices;
    def.vertex_count = 2;
    if (def.obstacle.generation == 0 && def.other_cloth.generation == 0) def.points = points;
    def.stiffness = 20.0;
    things_fine(tulle_world_attach(world, &def, &id, &error), &error);
    return id;
}

/* The next event tells that an attachment of this object has ended. */
static void expect_end(tulle_world *world, tulle_attachment_id id, uint32_t object) {
    tulle_event event;
    size_t count;
    things_fine(tulle_world_poll_events(world, &event, 1, &count, NULL, &error), &error);
    assert_int_equal(count, 1);
    assert_true(event.kind == TULLE_EVENT_ATTACHMENT_END && event.attachment == id);
    assert_true(event.object_a == object && event.object_b == UINT32_MAX);
}

static void attachments_end_with_either_side(void **unused) {
    (void)unused;
    for (int is_started = 0; is_started < 2; is_started++) {
        tulle_world *const world = things_make_world(NULL);
        tulle_object_id const first = things_add(world, THING_PINNED, 2.0);
        tulle_object_id const sheet = things_add(world, THING_SHEET, 0.0);
        tulle_object_id const other = things_add(world, THING_SHEET, 1.0);
        tulle_object_id const keys = things_add(world, THING_KEYS, 0.0);
        tulle_object_id const ground = things_add(world, THING_GROUND, 0.0);
        if (is_started) things_start(world);
        tulle_attachment_def def = tulle_attachment_def_default();
        tulle_attachment_id ids[5];
        def.cloth = as_cloth(sheet);
        ids[0] = attach(world, def);
        def.obstacle = as_obstacle(keys);
        ids[1] = attach(world, def);
        def.obstacle = as_obstacle(ground);
        ids[2] = attach(world, def);
        def.obstacle = (tulle_obstacle_id){0, 0};
        def.other_cloth = as_cloth(other);
        ids[3] = attach(world, def);
        def.cloth = as_cloth(other);
        def.other_cloth = as_cloth(sheet);
        ids[4] = attach(world, def);
        tulle_event_watch watch = tulle_event_watch_default();
        watch.kinds = 1u << TULLE_EVENT_ATTACHMENT_END;
        if (is_started) {
            things_fine(tulle_world_watch_events(world, &watch, &error), &error);
            things_step(world, 3);
        }
        things_remove(world, first); /* it had none; all numbers change */
        things_remove(world, keys);
        if (!is_started) {
            things_start(world);
            things_fine(tulle_world_watch_events(world, &watch, &error), &error);
        }
        static const size_t held[5] = {2, 0, 2, 2, 2};
        for (int i = 0; i < 5; i++)
            assert_int_equal(tulle_attachment_get_report(world, ids[i]).held_count, held[i]);
        for (int i = 0; i < 5; i++)
            assert_int_equal(tulle_attachment_holds(world, ids[i], 1), held[i] > 0);
        things_step(world, 3);
        if (is_started) expect_end(world, ids[1], 0);
        things_remove(world, other);
        static const size_t left[5] = {2, 0, 2, 0, 0};
        for (int i = 0; i < 5; i++)
            assert_int_equal(tulle_attachment_get_report(world, ids[i]).held_count, left[i]);
        things_step(world, 3);
        expect_end(world, ids[3], 0);
        expect_end(world, ids[4], UINT32_MAX); /* its cloth has gone */
        def.cloth = as_cloth(sheet);
        def.other_cloth = (tulle_cloth_id){0, 0};
        assert_int_equal(attach(world, def), 6);
        things_step(world, 2);
        things_fine(tulle_attachment_release(world, ids[0], &error), &error);
        things_step(world, 1);
        expect_end(world, ids[0], 0);
        size_t count;
        tulle_event none;
        things_fine(tulle_world_poll_events(world, &none, 1, &count, NULL, &error), &error);
        assert_int_equal(count, 0);
        tulle_world_destroy(world);
    }
}

static void events_go_on(void **unused) {
    (void)unused;
    tulle_world *const world = things_make_world(NULL);
    tulle_object_id const first = things_add(world, THING_PINNED, 2.0);
    tulle_object_id const sheet = things_add(world, THING_SHEET, 0.0);
    tulle_object_id const keys = things_add(world, THING_KEYS, 0.0);
    tulle_object_id const ground = things_add(world, THING_GROUND, 0.0);
    tulle_object_id const box = things_add(world, THING_BOX, 0.0);
    int data[2];
    things_fine(tulle_object_set_user_data(world, ground, &data[0], &error), &error);
    things_fine(tulle_object_set_user_data(world, sheet, &data[1], &error), &error);
    things_start(world);
    tulle_event_watch const watch = tulle_event_watch_default();
    things_fine(tulle_world_watch_events(world, &watch, &error), &error);
    things_step(world, 60);
    /* what waits in the queue names the same objects by their new numbers */
    things_remove(world, first);
    things_remove(world, keys);
    assert_ptr_equal(tulle_object_get_user_data(world, ground), &data[0]);
    assert_ptr_equal(tulle_object_get_user_data(world, sheet), &data[1]);
    tulle_event events[64];
    size_t count, begins = 0, sleeps = 0;
    uint64_t lost;
    things_fine(tulle_world_poll_events(world, events, 64, &count, &lost, &error), &error);
    for (size_t i = 0; i < count; i++) {
        assert_true(events[i].object_a < 3);
        if (events[i].kind == TULLE_EVENT_CONTACT_BEGIN) {
            tulle_object_id const a = tulle_world_get_object(world, events[i].object_a);
            tulle_object_id const b = tulle_world_get_object(world, events[i].object_b);
            begins += a.kind == TULLE_OBJECT_CLOTH && a.index == sheet.index &&
                      b.kind == TULLE_OBJECT_OBSTACLE && b.index == ground.index;
        }
        sleeps += events[i].kind == TULLE_EVENT_SLEEP &&
                  tulle_world_get_object(world, events[i].object_a).index == box.index;
    }
    assert_true(begins > 0 && sleeps == 1 && lost == 0);
    /* nothing has begun by the change itself; the box wakes, for its floor has gone */
    things_step(world, 1);
    things_fine(tulle_world_poll_events(world, events, 64, &count, &lost, &error), &error);
    for (size_t i = 0; i < count; i++) assert_true(events[i].kind != TULLE_EVENT_CONTACT_BEGIN);
    things_remove(world, ground);
    things_step(world, 1);
    things_fine(tulle_world_poll_events(world, events, 64, &count, &lost, &error), &error);
    assert_int_equal(count, 1);
    assert_true(events[0].kind == TULLE_EVENT_WAKE && events[0].object_a == 1);
    tulle_world_destroy(world);
}

/* ---- filters and laws ---- */

typedef struct asked {
    tulle_object_id pairs[32][2];
    size_t count;
} asked;

/* Lets nothing collide with what is called "ghost"; positions can be read meanwhile. */
static int answer(void *context, const tulle_world *world, tulle_object_id a, tulle_object_id b) {
    asked *const self = context;
    assert_true(self->count < 32);
    self->pairs[self->count][0] = a;
    self->pairs[self->count++][1] = b;
    size_t count = 0;
    assert_non_null(tulle_cloth_get_positions(world, as_cloth(a), &count));
    assert_true(count == tulle_object_get_info(world, a).vertex_count && count > 0);
    tulle_object_info const info = tulle_object_get_info(world, b);
    assert_non_null(info.name);
    return strcmp(info.name, "ghost") != 0;
}

static void the_filter_is_asked_of_what_comes(void **unused) {
    (void)unused;
    tulle_world *const world = things_make_world(NULL);
    asked self = {.count = 0};
    (void)things_add(world, THING_SHEET, 0.0);
    (void)things_add(world, THING_GROUND, 0.0);
    things_fine(tulle_world_set_pair_filter(world, answer, &self, &error), &error);
    things_start(world);
    assert_int_equal(self.count, 1);
    things_step(world, 40);
    tulle_mesh box = bodies_make_box(0.05, 0.05, 0.04, (double[]){0.02, 0.01, 0.021});
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.name = "ghost";
    def.mesh = tulle_mesh_get_view(&box);
    tulle_obstacle_id ghost;
    things_fine(tulle_world_add_obstacle(world, &def, &ghost, &error), &error);
    assert_int_equal(self.count, 2);
    assert_true(self.pairs[1][0].kind == TULLE_OBJECT_CLOTH && self.pairs[1][0].index == 0);
    assert_true(self.pairs[1][1].index == ghost.index &&
                self.pairs[1][1].generation == ghost.generation);
    things_step(world, 5);
    /* the answer holds on through other changes */
    tulle_object_id const other = things_add(world, THING_KEYS, 0.0);
    assert_int_equal(self.count, 3);
    things_remove(world, other);
    assert_int_equal(self.count, 3);
    things_step(world, 5);
    def.name = "not a ghost";
    assert_int_equal(tulle_world_add_obstacle(world, &def, NULL, &error),
                     TULLE_ERROR_INTERSECTING_START);
    assert_int_equal(self.count, 4);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* Laws of pairs and of materials hold for what comes and for what stays: a sheet on a slope slides
 * or sticks by them. */
static void laws_are_kept(void **unused) {
    (void)unused;
    tulle_contact_law const slippery = {0.0, 0.0, 0.0}, rough = {5.0, -1.0, 0.0};
    tulle_world *const late = things_make_world(NULL), *const early = things_make_world(NULL);
    tulle_world *const worlds[2] = {late, early};
    for (int i = 0; i < 2; i++) {
        tulle_world *const world = worlds[i];
        tulle_object_id const gone = things_add(world, THING_PINNED, 3.0);
        tulle_object_id const sheet = things_add(world, THING_SHEET, 0.0);
        tulle_object_id const wall = things_add(world, THING_KEYS, 0.0);
        tulle_object_id const ground = things_add(world, THING_GROUND, 0.0);
        things_fine(tulle_world_set_cloth_obstacle_law(world, as_cloth(gone), as_obstacle(ground),
                                                       &rough, &error),
                    &error);
        things_fine(tulle_world_set_cloth_obstacle_law(world, as_cloth(sheet), as_obstacle(ground),
                                                       &slippery, &error),
                    &error);
        things_fine(tulle_world_set_cloth_obstacle_law(world, as_cloth(sheet), as_obstacle(wall),
                                                       &rough, &error),
                    &error);
        if (i == 0) things_start(world);
        things_remove(world, gone);
        things_remove(world, wall);
        things_start(world);
    }
    things_step(late, 40);
    things_step(early, 40);
    assert_true(tulle_world_get_state_hash(late) == tulle_world_get_state_hash(early));
    size_t count;
    const double *const v = tulle_cloth_get_velocities(late, (tulle_cloth_id){1, 1}, &count);
    double speed = 0.0; /* of what nothing brakes but the air */
    for (size_t k = 0; k < count; k++) speed += v[3 * k] / (double)count;
    assert_true(speed > 0.05);
    tulle_world_destroy(late);
    tulle_world_destroy(early);
}

/* ---- saved states ---- */

static void states_belong_to_their_objects(void **unused) {
    (void)unused;
    tulle_world *const world = things_make_world(NULL);
    tulle_object_id const sheet = things_add(world, THING_SHEET, 0.0);
    (void)things_add(world, THING_GROUND, 0.0);
    things_start(world);
    things_step(world, 10);
    void *before, *after;
    size_t before_size, after_size;
    things_fine(tulle_world_save_state(world, &before, &before_size, &error), &error);
    uint64_t const first = tulle_world_get_state_hash(world);
    tulle_object_id const guest = things_add(world, THING_PINNED, 0.0);
    uint64_t const with_guest = tulle_world_get_state_hash(world);
    assert_int_equal(tulle_world_load_state(world, before, before_size, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "another scene"));
    assert_true(tulle_world_get_state_hash(world) == with_guest);
    /* a change of material after the objects have come is part of the state */
    tulle_material material = tulle_cloth_def_default().material;
    material.area_density *= 2.0;
    things_fine(tulle_cloth_set_material(world, as_cloth(sheet), &material, &error), &error);
    things_step(world, 5);
    things_fine(tulle_world_save_state(world, &after, &after_size, &error), &error);
    uint64_t const saved = tulle_world_get_state_hash(world);
    things_step(world, 8);
    uint64_t const expected = tulle_world_get_state_hash(world);
    things_fine(tulle_world_load_state(world, after, after_size, &error), &error);
    assert_true(tulle_world_get_state_hash(world) == saved);
    things_step(world, 8);
    assert_true(tulle_world_get_state_hash(world) == expected);
    /* a world that has the same objects from its start on takes it, too */
    tulle_world *const other = things_make_world(NULL);
    (void)things_add(other, THING_SHEET, 0.0);
    (void)things_add(other, THING_PINNED, 0.0);
    (void)things_add(other, THING_GROUND, 0.0);
    things_fine(tulle_world_load_state(other, after, after_size, &error), &error);
    things_step(other, 8);
    assert_true(tulle_world_get_state_hash(other) == expected);
    /* without the guest the first state fits again */
    things_remove(world, guest);
    assert_int_equal(tulle_world_load_state(world, after, after_size, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    things_fine(tulle_world_load_state(world, before, before_size, &error), &error);
    assert_true(tulle_world_get_state_hash(world) == first);
    tulle_world_free_state(world, before, before_size);
    tulle_world_free_state(world, after, after_size);
    tulle_world_destroy(world);
    tulle_world_destroy(other);
}

/* ---- want of memory ---- */

static int allocations_left; /* below 0: any number */

static void *allocate(void *context, size_t byte_count) {
    (void)context;
    if (allocations_left == 0) return NULL;
    if (allocations_left > 0) allocations_left--;
    return malloc(byte_count);
}

static void release(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

/* Each call that wants memory fails once; the world is as before until all have gone well. */
static void memory_may_run_out_anywhere(void **unused) {
    (void)unused;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.allocator.allocate = allocate;
    def.allocator.release = release;
    allocations_left = -1;
    tulle_world *const world = things_make_world(&def), *const other = things_make_world(NULL);
    tulle_event_watch const watch = tulle_event_watch_default();
    tulle_object_id ids[2][THING_COUNT];
    for (int i = 0; i < 2; i++) {
        tulle_world *const each = i == 0 ? world : other;
        for (thing what = 0; what < THING_COUNT; what++)
            if (what != THING_PINNED && what != THING_BALL)
                ids[i][what] = things_add(each, what, 0.0);
        things_start(each);
        things_fine(tulle_world_watch_events(each, &watch, &error), &error);
        tulle_attachment_def held = tulle_attachment_def_default();
        held.cloth = as_cloth(ids[i][THING_SHEET]);
        (void)attach(each, held);
        tulle_material material = tulle_cloth_def_default().material;
        material.area_density *= 1.5;
        things_fine(tulle_cloth_set_material(each, held.cloth, &material, &error), &error);
        double distance;
        tulle_world_get_distances(each, &distance, NULL, NULL);
        things_fine(tulle_cloth_set_thickness(each, held.cloth, 0.5 * distance, &error), &error);
        things_step(each, 20);
    }
    tulle_object_id guest = {0};
    for (int call = 0; call < 4; call++) { /* each of two things comes and goes */
        thing const what = call < 2 ? THING_PINNED : THING_BALL;
        uint64_t const before = tulle_world_get_state_hash(world);
        tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
        int failures = 0;
        for (; status == TULLE_ERROR_OUT_OF_MEMORY; failures++) {
            tulle_cloth_id cloth = {0};
            tulle_obstacle_id obstacle = {0};
            allocations_left = failures;
            if (call % 2 == 1)
                status = things_try_remove(world, guest, &error);
            else if (what == THING_PINNED)
                status = things_try_cloth(world, what, 0.0, &cloth, &error);
            else
                status = things_try_obstacle(world, what, 2.0, &obstacle, &error);
            allocations_left = -1;
            if (call % 2 == 0)
                guest = what == THING_PINNED ? tulle_object_from_cloth(cloth)
                                             : tulle_object_from_obstacle(obstacle);
            if (status == TULLE_OK) break;
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            assert_non_null(strstr(error.message, "memory"));
            assert_true(tulle_world_get_state_hash(world) == before);
        }
        assert_true(failures > 30);
        if (call % 2 == 1) continue;
        for (int i = 0; i < 3; i++) { /* the twin gets the same without trouble */
            if (i == 0) ids[1][what] = things_add(other, what, call == 0 ? 0.0 : 2.0);
            things_step(world, 1);
            things_step(other, 1);
            assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(other));
        }
        things_remove(other, ids[1][what]);
    }
    things_step(world, 3);
    things_step(other, 3);
    assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(other));
    tulle_world_destroy(world);
    tulle_world_destroy(other);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refused),
        cmocka_unit_test(ignored),
        cmocka_unit_test(ignored_as_from_the_start),
        cmocka_unit_test(untangled),
        cmocka_unit_test(absent_ones_meet_nothing),
        cmocka_unit_test(sleepers_wake_when_their_floor_goes),
        cmocka_unit_test(a_group_wakes_when_one_of_it_goes),
        cmocka_unit_test(what_comes_moves_on),
        cmocka_unit_test(attachments_end_with_either_side),
        cmocka_unit_test(events_go_on),
        cmocka_unit_test(the_filter_is_asked_of_what_comes),
        cmocka_unit_test(laws_are_kept),
        cmocka_unit_test(states_belong_to_their_objects),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
