/* Events that the host polls: each kind in a scene that has it, against what getters tell of the
 * same steps; order, overflow, rollback, threads. */
#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
enum { EVENTS_MAX = 256 };

static void fine(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("%s", error->message);
}

static void watch(tulle_world *world, const tulle_event_watch *wanted) {
    tulle_error error = {0};
    fine(tulle_world_start(world, &error), &error);
    fine(tulle_world_watch_events(world, wanted, &error), &error);
}

static void watch_all(tulle_world *world) {
    tulle_event_watch const all = tulle_event_watch_default();
    watch(world, &all);
}

/* Steps, and gives the events of the step. */
static size_t step(tulle_world *world, tulle_event events[EVENTS_MAX]) {
    tulle_error error = {0};
    size_t count;
    uint64_t lost;
    fine(tulle_world_step(world, STEP, NULL, &error), &error);
    fine(tulle_world_poll_events(world, events, EVENTS_MAX, &count, &lost, &error), &error);
    assert_true(lost == 0);
    for (size_t i = 0; i < count; i++) {
        assert_true(events[i].step + 1 == tulle_world_get_step_count(world));
        assert_true(events[i].time == tulle_world_get_time(world));
    }
    return count;
}

static size_t count_kind(const tulle_event *events, size_t count, tulle_event_kind kind) {
    size_t sum = 0;
    for (size_t i = 0; i < count; i++) sum += events[i].kind == kind;
    return sum;
}

/* The normal force [N] between two objects by the contacts of the last step. */
static double measure_force(tulle_world *world, uint32_t a, uint32_t b, double substep) {
    const tulle_contact *contacts;
    size_t count;
    double force = 0.0;
    tulle_error error = {0};
    fine(tulle_world_get_contacts(world, &contacts, &count, &error), &error);
    for (size_t i = 0; i < count; i++) {
        const tulle_contact *const c = &contacts[i];
        if ((c->object_a != a || c->object_b != b) && (c->object_a != b || c->object_b != a))
            continue;
        for (int k = 0; k < 3; k++) force += c->impulse[k] * c->normal[k] / substep;
    }
    return force;
}

/* Two boxes and a sheet fall on the ground, one after the other: contact begins and ends where the
 * contacts of the steps say so. Objects: 0 the sheet, 1 the ground, 2 and 3 the boxes. */
static tulle_world *make_falling(int threads) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = threads;
    tulle_world *world = NULL;
    tulle_error error = {0};
    fine(tulle_world_create(&def, &world, &error), &error);
    tulle_mesh sheet = small_sheet(0.3, 7, 0.03);
    tulle_mesh ground = bodies_make_box(2.0, 2.0, 0.2, (double[]){0.0, 0.0, -0.1});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.0, 0.0, 0.15});
    tulle_mesh other = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.6, 0.0, 0.1});
    bodies_add_cloth(world, &sheet, 0.2, 0);
    bodies_add_obstacle(world, &ground, 0.5, NULL);
    tulle_body body = {.is_dynamic = 1, .mass = 2.0};
    bodies_add_obstacle(world, &box, 0.5, &body);
    body.sleep_speed = 0.02;
    body.sleep_time = 0.25;
    bodies_add_obstacle(world, &other, 0.5, &body);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&other);
    return world;
}

static tulle_obstacle_id const hopper = {1, 1}, sleeper = {2, 1};

/* What the host does before step i: one box hops now and then, the other is woken by a throw. */
static void act(tulle_world *world, int i) {
    tulle_error error = {0};
    double const up[3] = {0.0, 0.0, 1.0};
    if (i % 18 == 17) fine(tulle_obstacle_set_velocity(world, hopper, up, NULL, &error), &error);
    if (i == 60)
        fine(tulle_obstacle_set_velocity(world, sleeper, (double[]){0, 0, 2}, NULL, &error),
             &error);
}

static void contact_begins_and_ends(void **state) {
    (void)state;
    tulle_world *const world = make_falling(1);
    watch_all(world);
    tulle_event events[EVENTS_MAX];
    bool touches[4][4] = {{false}};
    size_t begun = 0, ended = 0;
    bool was_asleep = false;
    for (int i = 0; i < 120; i++) {
        act(world, i);
        size_t const count = step(world, events);
        /* ends and beginnings in the order of pairs, then objects */
        for (size_t k = 0; k + 1 < count; k++) {
            bool const is_pair[2] = {events[k].object_b != UINT32_MAX,
                                     events[k + 1].object_b != UINT32_MAX};
            assert_true(is_pair[0] || !is_pair[1]);
            if (is_pair[0] != is_pair[1]) continue;
            uint64_t const first = (uint64_t)events[k].object_a << 32 | events[k].object_b;
            uint64_t const next = (uint64_t)events[k + 1].object_a << 32 | events[k + 1].object_b;
            assert_true(first < next);
        }
        bool const is_asleep = tulle_obstacle_is_asleep(world, sleeper);
        for (uint32_t a = 0; a < 4; a++)
            for (uint32_t b = a; b < 4; b++) {
                /* contacts of what sleeps are not in the list any more */
                if (b == 3 && (is_asleep || was_asleep)) continue;
                double const force = measure_force(world, a, b, STEP);
                bool const is = force > 0.0;
                size_t found = 0;
                for (size_t k = 0; k < count; k++) {
                    if (events[k].object_a != a || events[k].object_b != b) continue;
                    found++;
                    assert_int_equal(events[k].kind,
                                     is ? TULLE_EVENT_CONTACT_BEGIN : TULLE_EVENT_CONTACT_END);
                    if (is) assert_true(fabs(events[k].force - force) <= 0.5 * force);
                }
                assert_int_equal(found, is != touches[a][b]);
                begun += is && !touches[a][b];
                ended += !is && touches[a][b];
                touches[a][b] = is;
            }
        size_t const slept = count_kind(events, count, TULLE_EVENT_SLEEP);
        size_t const woke = count_kind(events, count, TULLE_EVENT_WAKE);
        assert_int_equal(slept, is_asleep && !was_asleep);
        assert_int_equal(woke, !is_asleep && was_asleep);
        for (size_t k = 0; k < count; k++)
            if (events[k].kind == TULLE_EVENT_SLEEP || events[k].kind == TULLE_EVENT_WAKE)
                assert_int_equal(events[k].object_a, 3);
        if (was_asleep && !is_asleep) {
            assert_int_equal(i, 60);
            touches[1][3] = measure_force(world, 1, 3, STEP) > 0.0;
        }
        was_asleep = is_asleep;
    }
    print_message("%zu contacts began, %zu ended\n", begun, ended);
    assert_true(begun >= 4 && ended >= 1);
    tulle_world_destroy(world);
}

/* A threshold on the force: that of a box which rests weighs 19.6 N. */
static void weak_contacts_can_be_left_out(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        tulle_world *const world = make_falling(1);
        tulle_event events[EVENTS_MAX];
        for (int i = 0; i < 50; i++) bodies_step_by(world, STEP); /* all is at rest */
        tulle_event_watch wanted = tulle_event_watch_default();
        wanted.contact_force = k == 0 ? 15.0 : 25.0;
        tulle_error error = {0};
        fine(tulle_world_watch_events(world, &wanted, &error), &error);
        fine(tulle_obstacle_add_force(world, sleeper, NULL, (double[]){0, 0, 8}, &error), &error);
        size_t const less = step(world, events); /* 11.6 N, then 19.6 N again */
        assert_int_equal(count_kind(events, less, TULLE_EVENT_CONTACT_END), k == 0);
        size_t const again = step(world, events);
        assert_int_equal(count_kind(events, again, TULLE_EVENT_CONTACT_BEGIN), k == 0);
        for (size_t e = 0; e < again && k == 0; e++)
            if (events[e].kind == TULLE_EVENT_CONTACT_BEGIN) {
                assert_int_equal(events[e].object_a, 1);
                assert_int_equal(events[e].object_b, 3);
                assert_true(fabs(events[e].force - 19.62) < 0.2);
            }
        tulle_world_destroy(world);
    }
}

/* Events of all steps, one after the other, with what the host does. */
static size_t run(tulle_world *world, int from, int to, tulle_event *all) {
    tulle_event events[EVENTS_MAX];
    size_t sum = 0;
    for (int i = from; i < to; i++) {
        act(world, i);
        size_t const count = step(world, events);
        assert_true(sum + count <= EVENTS_MAX);
        memcpy(all + sum, events, count * sizeof *events);
        sum += count;
    }
    return sum;
}

static void expect_same(const tulle_event *a, const tulle_event *b, size_t count) {
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(a[i].kind, b[i].kind);
        assert_int_equal(a[i].object_a, b[i].object_a);
        assert_int_equal(a[i].object_b, b[i].object_b);
        assert_true(a[i].step == b[i].step && a[i].time == b[i].time && a[i].force == b[i].force);
    }
}

/* The same events for any number of threads, and again after a rollback; and the same states as in
 * a world that watches nothing. */
static void events_follow_from_the_states(void **state) {
    (void)state;
    tulle_event first[EVENTS_MAX], second[EVENTS_MAX];
    tulle_world *const one = make_falling(1), *const four = make_falling(4);
    tulle_world *const blind = make_falling(1);
    watch_all(one);
    watch_all(four);
    tulle_error error = {0};
    fine(tulle_world_start(blind, &error), &error);
    size_t const count = run(one, 0, 45, first);
    assert_true(count > 4);
    assert_int_equal(run(four, 0, 45, second), count);
    expect_same(first, second, count);
    void *bytes;
    size_t size;
    fine(tulle_world_save_state(one, &bytes, &size, &error), &error);
    size_t const later = run(one, 45, 90, first);
    assert_true(later > 2);
    bodies_step_by(one, STEP); /* leaves something in the queue, or not */
    fine(tulle_world_load_state(one, bytes, size, &error), &error);
    size_t left = 1;
    fine(tulle_world_poll_events(one, second, EVENTS_MAX, &left, NULL, &error), &error);
    assert_int_equal(left, 0);
    assert_int_equal(run(one, 45, 90, second), later);
    expect_same(first, second, later);
    fine(tulle_world_load_state(four, bytes, size, &error), &error); /* another world */
    assert_int_equal(run(four, 45, 90, second), later);
    expect_same(first, second, later);
    for (int i = 0; i < 90; i++) {
        act(blind, i);
        bodies_step_by(blind, STEP);
    }
    assert_true(tulle_world_get_state_hash(blind) == tulle_world_get_state_hash(one));
    tulle_world_free_state(one, bytes, size);
    tulle_world_destroy(one);
    tulle_world_destroy(four);
    tulle_world_destroy(blind);
}

/* A queue that is full keeps the oldest events, and tells how many it lost. */
static void overflow_is_told(void **state) {
    (void)state;
    tulle_event all[EVENTS_MAX], few[3];
    tulle_world *const whole = make_falling(1), *const small = make_falling(1);
    watch_all(whole);
    tulle_event_watch wanted = tulle_event_watch_default();
    wanted.capacity = 3;
    watch(small, &wanted);
    size_t const count = run(whole, 0, 45, all);
    assert_true(count > 4);
    for (int i = 0; i < 45; i++) {
        act(small, i);
        bodies_step_by(small, STEP);
    }
    size_t got;
    uint64_t lost;
    tulle_error error = {0};
    fine(tulle_world_poll_events(small, few, 2, &got, NULL, &error), &error);
    assert_int_equal(got, 2);
    expect_same(all, few, 2);
    fine(tulle_world_poll_events(small, few, 3, &got, &lost, &error), &error);
    assert_int_equal(got, 1);
    assert_true(lost == count - 3);
    expect_same(all + 2, few, 1);
    fine(tulle_world_poll_events(small, NULL, 0, &got, &lost, &error), &error);
    assert_true(got == 0 && lost == 0);
    fine(tulle_world_watch_events(small, NULL, &error), &error);
    assert_int_equal(tulle_world_poll_events(small, few, 3, &got, &lost, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_world_destroy(whole);
    tulle_world_destroy(small);
}

/* A plate closes on a sheet to nothing and lifts again; another obstacle comes and goes. Objects: 0
 * the sheet, 1 and 2 the plates, 3 the guest. */
static void pinches_and_presence_are_told(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.on_pinch = TULLE_ON_PINCH_SLOW;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(0.3, 7, 0.0);
    tulle_mesh plates[2] = {bodies_make_box(0.5, 0.5, 0.1, (double[]){0, 0, -0.06}),
                            bodies_make_box(0.5, 0.5, 0.1, (double[]){0, 0, 0.06})};
    tulle_mesh guest = bodies_make_box(0.1, 0.1, 0.1, (double[]){9, 0, 0});
    small_add_cloth(world, &sheet);
    tulle_error error = {0};
    small_add_obstacle(world, &plates[0]);
    tulle_keyframe const keys[3] = {{.rotation_vector = {0, 0, 0}},
                                    {0.2, {0, 0, -0.021}, {0, 0, 0}},
                                    {0.5, {0, 0, 0.1}, {0, 0, 0}}};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&plates[1]);
    obstacle.motion = (tulle_motion){.keys = keys, .key_count = 3};
    fine(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&guest);
    obstacle.appear_time = 0.1;
    obstacle.disappear_time = 0.3;
    tulle_obstacle_id id;
    fine(tulle_world_add_obstacle(world, &obstacle, &id, &error), &error);
    watch_all(world);
    tulle_event events[EVENTS_MAX];
    bool was_pinched = false, was_there = false;
    size_t pinches = 0;
    for (int i = 0; i < 40; i++) {
        tulle_step_report report;
        size_t count;
        fine(tulle_world_step(world, STEP, &report, &error), &error);
        fine(tulle_world_poll_events(world, events, EVENTS_MAX, &count, NULL, &error), &error);
        bool const is_there = tulle_obstacle_is_present(world, id);
        assert_int_equal(count_kind(events, count, TULLE_EVENT_APPEAR), is_there && !was_there);
        assert_int_equal(count_kind(events, count, TULLE_EVENT_LEAVE), !is_there && was_there);
        was_there = is_there;
        /* the report of the step in which it ends still tells of it */
        const char *const said = tulle_world_last_message(world);
        bool const ends = strstr(said, "pinched no more") != NULL;
        bool const begins = report.pinched && !was_pinched;
        /* of the plate that waits */
        assert_int_equal(count_kind(events, count, TULLE_EVENT_PINCH_BEGIN), begins);
        assert_int_equal(count_kind(events, count, TULLE_EVENT_PINCH_END), ends);
        for (size_t k = 0; k < count; k++)
            if (events[k].kind == TULLE_EVENT_PINCH_BEGIN) assert_int_equal(events[k].object_a, 2);
        pinches += begins;
        was_pinched = report.pinched && !ends;
    }
    assert_true(pinches == 1 && !was_pinched && !was_there);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&guest);
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&plates[k]);
    tulle_world_destroy(world);
}

/* The tip of a cone that sticks in a sheet from the start is drawn out. */
static void tangles_that_come_apart_are_told(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_IGNORE;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(0.2, 3, 0.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_CONE);
    shape.radius = 0.01;
    shape.height = 0.05;
    tulle_mesh cone = small_shape(shape, 0.03, 0.06, -0.049);
    bodies_add_cloth(world, &sheet, 0.2, 1);
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {0.25, {0, 0, -0.1}, {0, 0, 0}}};
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&cone);
    obstacle.motion = (tulle_motion){.keys = keys, .key_count = 2};
    tulle_error error = {0};
    fine(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    watch_all(world);
    tulle_event events[EVENTS_MAX];
    bool was_tangled = true;
    size_t untangled = 0;
    for (int i = 0; i < 20; i++) {
        tulle_step_report report;
        size_t count;
        fine(tulle_world_step(world, STEP, &report, &error), &error);
        fine(tulle_world_poll_events(world, events, EVENTS_MAX, &count, NULL, &error), &error);
        bool const is_tangled = report.ignored_pairs > 0;
        size_t const told = count_kind(events, count, TULLE_EVENT_UNTANGLED);
        assert_int_equal(told, was_tangled && !is_tangled);
        if (told > 0) assert_true(events[count - 1].object_a == UINT32_MAX);
        untangled += told;
        was_tangled = is_tangled;
    }
    assert_int_equal(untangled, 1);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&cone);
    tulle_world_destroy(world);
}

/* Of two sheets one is pulled beyond what its yarns hold, and let go of. */
static void overstretch_is_told(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.gravity[2] = 0.0;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh calm = small_sheet(0.2, 3, 1.0), sheet = small_sheet(0.2, 3, 0.0);
    small_add_cloth(world, &calm);
    uint32_t all[9];
    for (uint32_t v = 0; v < 9; v++) all[v] = v;
    tulle_pin const pin = make_pin(all, 9, (double)INFINITY);
    tulle_cloth_def pulled = tulle_cloth_def_default();
    pulled.mesh = tulle_mesh_get_view(&sheet);
    pulled.pins = &pin;
    pulled.pin_count = 1;
    tulle_cloth_id cloth;
    tulle_error error = {0};
    fine(tulle_world_add_cloth(world, &pulled, &cloth, &error), &error);
    watch_all(world);
    double const limit = fmin(pulled.material.warp.limit, pulled.material.weft.limit);
    tulle_event events[EVENTS_MAX];
    size_t began = 0, ended = 0;
    bool was = false;
    for (int i = 0; i < 40; i++) {
        double const strain = 1.5 * limit * sin(0.15 * i);
        double targets[27];
        for (int v = 0; v < 27; v++) targets[v] = sheet.positions[v] * (1.0 + fmax(strain, 0.0));
        fine(tulle_cloth_set_pin_targets(world, cloth, 0, targets, 9, &error), &error);
        size_t const count = step(world, events);
        bool const is = strain > limit; /* by both yarns alike */
        assert_int_equal(count_kind(events, count, TULLE_EVENT_OVERSTRETCH_BEGIN), is && !was);
        assert_int_equal(count_kind(events, count, TULLE_EVENT_OVERSTRETCH_END), !is && was);
        for (size_t k = 0; k < count; k++) assert_int_equal(events[k].object_a, 1);
        began += is && !was;
        ended += !is && was;
        was = is;
    }
    assert_true(began == 1 && ended == 1);
    tulle_mesh_destroy(&calm);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contact_begins_and_ends),
        cmocka_unit_test(weak_contacts_can_be_left_out),
        cmocka_unit_test(events_follow_from_the_states),
        cmocka_unit_test(overflow_is_told),
        cmocka_unit_test(pinches_and_presence_are_told),
        cmocka_unit_test(tangles_that_come_apart_are_told),
        cmocka_unit_test(overstretch_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
