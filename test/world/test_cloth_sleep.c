/* Cloth that sleeps: it stands still to the bit, costs no solve, and wakes for every cause that
 * tulle/live.h names, with the contacts that it had. What it would have done is told by a twin
 * world in which nothing ever sleeps; what intersects, by the exact judge. */
#include "tulle/tulle.h"

#include "base/hash.h"
#include "support/body_world.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 13, VERTICES = SIDE * SIDE, SETTLE_STEPS = 400 };
static const double STEP = 1.0 / 64.0;        /* [s] */
static const double SPEED = 1e-3, TIME = 0.5; /* [m/s], [s] of sleep */
static const tulle_cloth_id CLOTH = {0, 1}, OTHER = {1, 1};
static const double NO_TURN[4] = {1.0, 0.0, 0.0, 0.0};

static void expect_ok(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("status %d: %s", (int)status, error->message);
}

static tulle_step_report step(tulle_world *world) {
    tulle_error error = {0};
    tulle_step_report report;
    expect_ok(tulle_world_step(world, STEP, &report, &error), &error);
    return report;
}

/* Copies the positions of a cloth; returns how many numbers. */
static size_t copy_positions(const tulle_world *world, tulle_cloth_id id, double *copy) {
    size_t count;
    const double *const positions = tulle_cloth_get_positions(world, id, &count);
    memcpy(copy, positions, 3 * count * sizeof(double));
    return 3 * count;
}

/* [m] The farthest that a vertex is from where it was. */
static double measure_way(const tulle_world *world, tulle_cloth_id id, const double *from) {
    size_t count;
    const double *const positions = tulle_cloth_get_positions(world, id, &count);
    double most = 0.0;
    for (size_t v = 0; v < count; v++) {
        const double *const x = positions + 3 * v, *const y = from + 3 * v;
        most = fmax(most, sqrt((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
                               (x[2] - y[2]) * (x[2] - y[2])));
    }
    return most;
}

/* ---- scenes ---- */

typedef enum scene_kind { ON_TABLE, OVER_BALL, HANGS } scene_kind;

typedef struct scene {
    tulle_world_def def;
    double height;             /* [m] of a second cloth above the first; 0: there is none */
    bool has_paddle;           /* a small box far off, driven by the host */
    bool has_attached;         /* hangs by an attachment in place of a pin */
    double release_time;       /* [s] of the pin by which it hangs */
    double disappear_time;     /* [s] of what it lies on */
    const tulle_body *body;    /* of a ball over the first cloth, or null */
    tulle_mesh sheet, support; /* made by make_scene */
} scene;

static scene default_scene(void) {
    scene made = {.def = tulle_world_def_default(),
                  .release_time = (double)INFINITY,
                  .disappear_time = (double)INFINITY};
    made.def.sleep_speed = SPEED;
    made.def.sleep_time = TIME;
    made.def.threads = 1;
    return made;
}

/* The support is obstacle 0, the paddle 1; a ball with a body is the last one. */
static tulle_world *make_scene(scene *self, scene_kind kind) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    expect_ok(tulle_world_create(&self->def, &world, &error), &error);
    self->sheet = small_sheet(0.3, SIDE, kind == OVER_BALL ? 0.16 : kind == HANGS ? 0.0 : 0.01);
    uint32_t row[SIDE];
    for (uint32_t k = 0; k < SIDE; k++) row[k] = k;
    tulle_pin const pin = make_pin(row, SIDE, self->release_time);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&self->sheet);
    if (kind == HANGS) cloth.material.air_damping = 3.0; /* sooner at rest */
    if (kind == HANGS && !self->has_attached) {
        cloth.pins = &pin;
        cloth.pin_count = 1;
    }
    expect_ok(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    cloth.pin_count = 0;
    if (self->height > 0.0) {
        tulle_mesh second = small_sheet(0.15, 7, self->height);
        cloth.mesh = tulle_mesh_get_view(&second);
        expect_ok(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
        tulle_mesh_destroy(&second);
    }
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.15;
    self->support =
        kind == OVER_BALL
            ? small_shape(shape, 0.0, 0.0, 0.0)
            : bodies_make_box(1.0, 1.0, 0.1, (double[3]){0.0, 0.0, kind == HANGS ? -3.0 : -0.05});
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&self->support);
    obstacle.disappear_time = self->disappear_time;
    if (!self->body && self->disappear_time == (double)INFINITY)
        obstacle.drive = TULLE_DRIVE_RIGID; /* it may be moved */
    expect_ok(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
    if (self->has_paddle) {
        tulle_mesh box = bodies_make_box(0.05, 0.05, 0.05, (double[3]){2.0, 0.0, 0.1});
        obstacle.mesh = tulle_mesh_get_view(&box);
        obstacle.drive = TULLE_DRIVE_RIGID;
        expect_ok(tulle_world_add_obstacle(world, &obstacle, NULL, &error), &error);
        tulle_mesh_destroy(&box);
    }
    if (self->body) {
        tulle_mesh ball = bodies_make_ball(0.03, 3, (double[3]){0.0, 0.0, 0.3});
        bodies_add_obstacle(world, &ball, 0.5, self->body);
        tulle_mesh_destroy(&ball);
    }
    expect_ok(tulle_world_start(world, &error), &error);
    if (self->has_attached) {
        tulle_attachment_def def = tulle_attachment_def_default();
        tulle_attachment_id id;
        def.cloth = CLOTH;
        def.vertices = row;
        def.vertex_count = SIDE;
        def.points = self->sheet.positions;
        expect_ok(tulle_world_attach(world, &def, &id, &error), &error);
    }
    return world;
}

static void free_scene(scene *self, tulle_world *world) {
    tulle_world_destroy(world);
    tulle_mesh_destroy(&self->sheet);
    tulle_mesh_destroy(&self->support);
}

/* Steps until the first cloth sleeps. */
static int fall_asleep(tulle_world *world) {
    int count = 0;
    while (!tulle_cloth_is_asleep(world, CLOTH)) {
        if (count++ == 4 * SETTLE_STEPS) fail_msg("the cloth does not fall asleep");
        step(world);
    }
    return count;
}

/* ---- asleep ---- */

static void a_sleeper_stands_still(void **state) {
    (void)state;
    for (int kind = ON_TABLE; kind <= HANGS; kind++) {
        scene self = default_scene();
        self.has_attached = kind == HANGS;
        tulle_world *const world = make_scene(&self, (scene_kind)kind);
        tulle_event_watch const watch = tulle_event_watch_default();
        expect_ok(tulle_world_watch_events(world, &watch, NULL), NULL);
        int const count = fall_asleep(world);
        assert_true(count >= (int)(TIME / STEP));
        double before[3 * VERTICES];
        size_t const length = copy_positions(world, CLOTH, before);
        const tulle_contact *contacts;
        size_t contact_count, later_count;
        expect_ok(tulle_world_get_contacts(world, &contacts, &contact_count, NULL), NULL);
        assert_true(kind == HANGS || contact_count > 0);
        double const start = tulle_world_get_time(world);
        uint64_t const first = tulle_world_get_step_count(world);
        for (int i = 1; i <= 100; i++) {
            tulle_step_report const report = step(world);
            assert_int_equal(report.solve_count, 0);
            assert_true(report.kinetic_energy == 0.0);
            assert_true(tulle_cloth_is_asleep(world, CLOTH));
            assert_true(report.time == start + i * STEP);
        }
        assert_int_equal(tulle_world_get_step_count(world), first + 100);
        size_t v_count;
        const double *const velocities = tulle_cloth_get_velocities(world, CLOTH, &v_count);
        for (size_t k = 0; k < length; k++) assert_true(velocities[k] == 0.0);
        double after[3 * VERTICES];
        copy_positions(world, CLOTH, after);
        assert_memory_equal(before, after, length * sizeof(double));
        expect_ok(tulle_world_get_contacts(world, &contacts, &later_count, NULL), NULL);
        assert_int_equal(later_count, contact_count);
        tulle_event events[64];
        size_t event_count, sleeps = 0;
        expect_ok(tulle_world_poll_events(world, events, 64, &event_count, NULL, NULL), NULL);
        for (size_t k = 0; k < event_count; k++) {
            sleeps += events[k].kind == TULLE_EVENT_SLEEP && events[k].object_a == 0 &&
                      events[k].step == first - 1;
            assert_true(events[k].kind != TULLE_EVENT_WAKE);
        }
        assert_int_equal(sleeps, 1);
        expect_ok(tulle_cloth_wake(world, CLOTH, NULL), NULL);
        step(world);
        expect_ok(tulle_world_poll_events(world, events, 64, &event_count, NULL, NULL), NULL);
        size_t wakes = 0;
        for (size_t k = 0; k < event_count; k++) {
            wakes += events[k].kind == TULLE_EVENT_WAKE && events[k].object_a == 0;
            assert_true(events[k].kind != TULLE_EVENT_CONTACT_END);
        }
        assert_int_equal(wakes, 1);
        free_scene(&self, world);
    }
}

/* Woken for no reason and left alone, cloth goes on as it was: it never gets faster than it may be
 * asleep at, and moves no farther than the twin that did not sleep. */
static void waking_is_no_twitch(void **state) {
    (void)state;
    /* on a table in the long form alone */
    for (int kind = getenv("TULLE_TEST_LONG") ? ON_TABLE : OVER_BALL; kind <= HANGS; kind++) {
        scene self = default_scene(), other = default_scene();
        other.def.sleep_speed = 0.0;
        tulle_world *const world = make_scene(&self, (scene_kind)kind);
        tulle_world *const twin = make_scene(&other, (scene_kind)kind);
        for (int i = fall_asleep(world); i > 0; i--) step(twin);
        double from[3 * VERTICES], twin_from[3 * VERTICES];
        copy_positions(world, CLOTH, from);
        copy_positions(twin, CLOTH, twin_from);
        assert_memory_equal(from, twin_from, sizeof from);
        for (int i = 0; i < 30; i++) step(world);
        double way = 0.0, twin_way = 0.0, fastest = 0.0;
        expect_ok(tulle_cloth_wake(world, CLOTH, NULL), NULL);
        for (int i = 0; i < 31; i++) { /* a step less than it may sleep after */
            step(world);
            step(twin);
            assert_false(tulle_cloth_is_asleep(world, CLOTH));
            way = fmax(way, measure_way(world, CLOTH, from));
            twin_way = fmax(twin_way, measure_way(twin, CLOTH, from));
            const double *const v = tulle_cloth_get_velocities(world, CLOTH, NULL);
            for (size_t k = 0; k < VERTICES; k++)
                fastest = fmax(fastest, v[3 * k] * v[3 * k] + v[3 * k + 1] * v[3 * k + 1] +
                                            v[3 * k + 2] * v[3 * k + 2]);
        }
        print_message("kind %d: woken %.3g m, %.3g m/s; never asleep %.3g m\n", kind, way,
                      sqrt(fastest), twin_way);
        assert_true(sqrt(fastest) <= SPEED);
        assert_true(way <= twin_way + 1e-12);
        free_scene(&self, world);
        free_scene(&other, twin);
    }
}

/* What swings slowly is not stopped where anyone sees it: from where it falls asleep the twin never
 * gets farther than a millimetre. And it does not sleep at its turning points. */
static void a_pendulum_comes_to_rest_first(void **state) {
    (void)state;
    scene self = default_scene(), other = default_scene();
    other.def.sleep_speed = 0.0;
    tulle_world *const world = make_scene(&self, HANGS), *const twin = make_scene(&other, HANGS);
    for (int i = fall_asleep(world); i > 0; i--) step(twin);
    double from[3 * VERTICES], way = 0.0;
    copy_positions(world, CLOTH, from);
    for (int i = 0; i < 600; i++) {
        step(twin);
        way = fmax(way, measure_way(twin, CLOTH, from));
    }
    print_message("the twin goes on by %.3g m\n", way);
    assert_true(way > 0.0 && way < 1e-3);
    free_scene(&self, world);
    free_scene(&other, twin);
}

/* Cloth that air lets slide at half of sleep_speed, by the law of its damping, slides on. */
static void slow_sliding_is_no_rest(void **state) {
    (void)state;
    scene self = default_scene();
    self.def.gravity[0] = 0.01;
    self.def.wind.drag_coefficient = 0.0;
    tulle_world *const world = make_scene(&self, ON_TABLE);
    tulle_contact_law const smooth = {0.0, 0.0, 0.0};
    tulle_material material;
    expect_ok(tulle_material_preset("cotton", &material), NULL);
    material.air_damping = 20.0; /* 0.01 m/s^2 / 20 1/s: 0.5 mm/s */
    expect_ok(
        tulle_world_set_cloth_obstacle_law(world, CLOTH, (tulle_obstacle_id){0, 1}, &smooth, NULL),
        NULL);
    expect_ok(tulle_cloth_set_material(world, CLOTH, &material, NULL), NULL);
    double from[3 * VERTICES];
    for (int i = 0; i < 300; i++) {
        if (i == 100) copy_positions(world, CLOTH, from);
        step(world);
        assert_false(tulle_cloth_is_asleep(world, CLOTH));
    }
    double const way = measure_way(world, CLOTH, from), wanted = 200 * STEP * 0.5e-3;
    assert_true(fabs(way - wanted) < 0.05 * wanted);
    free_scene(&self, world);
}

/* ---- awake again ---- */

typedef enum cause {
    BY_CALL,
    BY_GRAVITY,
    BY_WIND,
    BY_MATERIAL,
    BY_THICKNESS,
    BY_LAW,
    BY_SUPPORT_MOVED,
    BY_SUPPORT_JUMP,
    BY_PADDLE,
    BY_ATTACHMENT,
    TABLE_CAUSES,
    BY_PIN = TABLE_CAUSES, /* of what hangs */
    BY_PIN_RELEASE,
    HANGING_CAUSES,
    BY_POINTS = HANGING_CAUSES, /* of what is attached */
    BY_DETACHING,
    CAUSE_COUNT
} cause;

static void act(tulle_world *world, const scene *self, cause what) {
    tulle_obstacle_id const support = {0, 1}, paddle = {1, 1};
    tulle_error error = {0};
    tulle_wind wind = self->def.wind;
    tulle_material material;
    tulle_status status = tulle_material_preset("cotton", &material);
    double moved[3 * SIDE];
    uint32_t const vertex = VERTICES - 1;
    tulle_attachment_def def = tulle_attachment_def_default();
    tulle_attachment_id id;
    double contact;
    tulle_world_get_distances(world, &contact, NULL, NULL);
    memcpy(moved, self->sheet.positions, sizeof moved);
    for (int k = 0; k < SIDE; k++) moved[3 * k] += 1e-4;
    switch (what) {
    case BY_CALL: status = tulle_cloth_wake(world, CLOTH, &error); break;
    case BY_GRAVITY:
        status = tulle_world_set_gravity(world, (double[3]){0.0, 0.0, -9.8}, &error);
        break;
    case BY_WIND:
        wind.velocity[0] = 2.0;
        status = tulle_world_set_wind(world, &wind, &error);
        break;
    case BY_MATERIAL:
        material.area_density *= 1.5;
        status = tulle_cloth_set_material(world, CLOTH, &material, &error);
        break;
    case BY_THICKNESS:
        status = tulle_cloth_set_thickness(world, CLOTH, 0.9 * contact, &error);
        break;
    case BY_LAW: {
        tulle_contact_law const law = {0.05, 0.05, 0.0};
        status = tulle_world_set_cloth_obstacle_law(world, CLOTH, support, &law, &error);
        break;
    }
    case BY_SUPPORT_MOVED:
    case BY_SUPPORT_JUMP:
        status = tulle_obstacle_set_next_transform(
            world, support, (double[3]){0.0, 0.0, -1e-3}, NO_TURN,
            what == BY_SUPPORT_JUMP ? TULLE_TRAVEL_JUMP : TULLE_TRAVEL_MOVE, &error);
        break;
    case BY_PADDLE:
        status = tulle_obstacle_set_next_transform(world, paddle, (double[3]){-1.822, 0.0, -0.07},
                                                   NO_TURN, TULLE_TRAVEL_MOVE, &error);
        break;
    case BY_ATTACHMENT:
        def.cloth = CLOTH;
        def.vertices = &vertex;
        def.vertex_count = 1;
        def.points = moved;
        status = tulle_world_attach(world, &def, &id, &error);
        break;
    case BY_PIN: status = tulle_cloth_set_pin_targets(world, CLOTH, 0, moved, SIDE, &error); break;
    case BY_PIN_RELEASE: status = tulle_cloth_release_pin(world, CLOTH, 0, &error); break;
    case BY_POINTS: status = tulle_attachment_set_points(world, 1, moved, SIDE, &error); break;
    default: status = tulle_attachment_release(world, 1, &error); break;
    }
    expect_ok(status, &error);
}

/* Every cause wakes it within the next step, and the cloth answers from then on. */
static void every_cause_wakes(void **state) {
    (void)state;
    for (int what = 0; what < CAUSE_COUNT; what++) {
        scene self = default_scene();
        self.has_paddle = true;
        self.has_attached = what >= HANGING_CAUSES;
        tulle_world *const world = make_scene(&self, what < TABLE_CAUSES ? ON_TABLE : HANGS);
        fall_asleep(world);
        for (int i = 0; i < 5; i++) step(world);
        double from[3 * VERTICES];
        copy_positions(world, CLOTH, from);
        act(world, &self, (cause)what);
        tulle_step_report const report = step(world);
        if (tulle_cloth_is_asleep(world, CLOTH)) fail_msg("cause %d does not wake", what);
        assert_true(report.solve_count > 0);
        if (what == BY_PIN || what == BY_POINTS)
            assert_true(measure_way(world, CLOTH, from) >= 0.99e-4);
        if (what == BY_PIN_RELEASE || what == BY_DETACHING) { /* free fall of the lowest edge */
            for (int i = 0; i < 15; i++) step(world);
            assert_true(measure_way(world, CLOTH, from) > 0.2);
        }
        assert_int_equal(small_judge(world, &self.sheet, 1, &self.support, 1), 0);
        free_scene(&self, world);
    }
}

/* What changes nothing, or is far off, wakes nothing. */
static void what_is_far_does_not_wake(void **state) {
    (void)state;
    scene self = default_scene();
    self.has_paddle = true;
    tulle_world *const world = make_scene(&self, ON_TABLE);
    fall_asleep(world);
    double from[3 * VERTICES];
    copy_positions(world, CLOTH, from);
    uint64_t const hash = tulle_world_get_state_hash(world);
    expect_ok(tulle_world_set_gravity(world, self.def.gravity, NULL), NULL);
    expect_ok(tulle_world_set_wind(world, &self.def.wind, NULL), NULL);
    assert_true(tulle_world_get_state_hash(world) == hash);
    for (int i = 1; i <= 20; i++) {
        double const place[3] = {-0.01 * i, 0.0, 0.0};
        expect_ok(tulle_obstacle_set_next_transform(world, (tulle_obstacle_id){1, 1}, place,
                                                    NO_TURN, TULLE_TRAVEL_MOVE, NULL),
                  NULL);
        step(world);
        assert_true(tulle_cloth_is_asleep(world, CLOTH));
    }
    assert_true(tulle_obstacle_get_positions(world, (tulle_obstacle_id){1, 1}, NULL)[0] < 1.85);
    /* the table feels the weight of what sleeps on it, which no step has rows of */
    double impulse[3], moment[3], weight = 0.0;
    expect_ok(
        tulle_obstacle_get_contact_impulse(world, (tulle_obstacle_id){0, 1}, impulse, moment, NULL),
        NULL);
    tulle_material material;
    expect_ok(tulle_material_preset("cotton", &material), NULL);
    weight = material.area_density * 0.3 * 0.3 * 9.81 * STEP;
    assert_true(fabs(impulse[2] + weight) < 1e-3 * weight);
    assert_true(measure_way(world, CLOTH, from) == 0.0);
    free_scene(&self, world);
}

/* What comes and goes elsewhere lets it sleep; when what it lies on goes it falls. */
static void what_it_lies_on_is_removed(void **state) {
    (void)state;
    scene self = default_scene();
    self.has_paddle = true;
    tulle_world *const world = make_scene(&self, ON_TABLE);
    fall_asleep(world);
    double from[3 * VERTICES];
    copy_positions(world, CLOTH, from);
    tulle_mesh box = bodies_make_box(0.05, 0.05, 0.05, (double[3]){-2.0, 0.0, 0.1});
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&box);
    expect_ok(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), NULL);
    assert_true(tulle_cloth_is_asleep(world, CLOTH));
    expect_ok(tulle_world_remove_obstacle(world, (tulle_obstacle_id){1, 1}, NULL), NULL);
    for (int i = 0; i < 5; i++) step(world);
    assert_true(tulle_cloth_is_asleep(world, CLOTH));
    assert_true(measure_way(world, CLOTH, from) == 0.0);
    expect_ok(tulle_world_remove_obstacle(world, (tulle_obstacle_id){0, 1}, NULL), NULL);
    assert_false(tulle_cloth_is_asleep(world, CLOTH));
    void *bytes = NULL; /* of a state without a contact */
    size_t size = 0;
    tulle_error error = {0};
    expect_ok(tulle_world_save_state(world, &bytes, &size, &error), &error);
    expect_ok(tulle_world_load_state(world, bytes, size, &error), &error);
    tulle_world_free_state(world, bytes, size);
    for (int i = 0; i < 10; i++) step(world);
    assert_true(measure_way(world, CLOTH, from) > 0.1);
    tulle_mesh_destroy(&box);
    free_scene(&self, world);
}

/* A weight hangs by an attachment from cloth that is pinned, and nothing touches. When the weight
 * is removed, what it hung from wakes and is shorter again. */
static void what_hangs_on_it_is_removed(void **state) {
    (void)state;
    scene self = default_scene();
    tulle_world *const world = make_scene(&self, HANGS);
    tulle_mesh weight = small_sheet(0.3, SIDE, 0.0);
    for (size_t v = 0; v < weight.vertex_count; v++) weight.positions[3 * v + 1] += 0.4;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&weight);
    def.material.area_density = 2.0;
    def.material.air_damping = 3.0;
    tulle_cloth_id heavy;
    expect_ok(tulle_world_add_cloth(world, &def, &heavy, NULL), NULL);
    uint32_t near[SIDE];
    for (uint32_t k = 0; k < SIDE; k++) near[k] = k; /* the edge towards the pinned cloth */
    tulle_attachment_def tie = tulle_attachment_def_default();
    tulle_attachment_id id;
    tie.cloth = heavy;
    tie.other_cloth = CLOTH;
    tie.vertices = near;
    tie.vertex_count = SIDE;
    expect_ok(tulle_world_attach(world, &tie, &id, NULL), NULL);
    fall_asleep(world);
    assert_true(tulle_cloth_is_asleep(world, heavy));
    expect_ok(tulle_world_remove_cloth(world, heavy, NULL), NULL);
    assert_false(tulle_cloth_is_asleep(world, CLOTH));
    tulle_mesh_destroy(&weight);
    free_scene(&self, world);
}

/* A cloth that comes after the start has a sleep of its own, whatever slot its id has. */
static void what_comes_late_sleeps_too(void **state) {
    (void)state;
    scene self = default_scene();
    tulle_world *const world = make_scene(&self, ON_TABLE);
    fall_asleep(world);
    expect_ok(tulle_world_remove_cloth(world, CLOTH, NULL), NULL);
    assert_int_equal(tulle_cloth_is_asleep(world, CLOTH), 0);
    assert_int_equal(tulle_cloth_wake(world, CLOTH, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&self.sheet);
    tulle_cloth_id late;
    expect_ok(tulle_world_add_cloth(world, &def, &late, NULL), NULL);
    assert_int_equal(late.generation, 2);
    int count = 0;
    while (!tulle_cloth_is_asleep(world, late) && count++ < 4 * SETTLE_STEPS) step(world);
    assert_true(tulle_cloth_is_asleep(world, late));
    expect_ok(tulle_cloth_wake(world, late, NULL), NULL);
    assert_false(tulle_cloth_is_asleep(world, late));
    free_scene(&self, world);
}

/* What it lies on leaves; its pin lets go by the def: it falls from the step in which that is. */
static void what_ends_by_the_clock_wakes(void **state) {
    (void)state;
    for (int is_pin = 0; is_pin < 2; is_pin++) {
        scene self = default_scene();
        double const end = 20.0 + 0.25 * STEP;
        if (is_pin)
            self.release_time = end;
        else
            self.disappear_time = end;
        tulle_world *const world = make_scene(&self, is_pin ? HANGS : ON_TABLE);
        fall_asleep(world);
        double from[3 * VERTICES];
        while (tulle_world_get_time(world) < end) {
            assert_true(tulle_cloth_is_asleep(world, CLOTH));
            copy_positions(world, CLOTH, from);
            step(world);
        }
        assert_true(measure_way(world, CLOTH, from) == 0.0);
        step(world);
        assert_false(tulle_cloth_is_asleep(world, CLOTH));
        assert_true(measure_way(world, CLOTH, from) > 0.5 * 9.81 * STEP * STEP);
        free_scene(&self, world);
    }
}

/* A cloth, or a ball, falls on one that sleeps: it sleeps until it is touched, wakes in that very
 * step, nothing ever intersects, and all go to sleep again. */
static void what_falls_on_it_wakes(void **state) {
    (void)state;
    tulle_body const ball = {.is_dynamic = 1,
                             .mass = 0.02,
                             .start_time = 2.0,
                             .linear_damping = 1.0,
                             .angular_damping = 3.0,
                             .sleep_speed = 0.01,
                             .sleep_time = 0.3};
    for (int is_ball = 0; is_ball < 2; is_ball++) {
        scene self = default_scene();
        self.height = is_ball ? 0.0 : 1.6;
        self.body = is_ball ? &ball : NULL;
        tulle_world *const world = make_scene(&self, ON_TABLE);
        fall_asleep(world);
        bool has_woken = false, slept_beside_motion = false;
        for (int i = 0; i < 640; i++) {
            step(world);
            double const low =
                is_ball ? bodies_get_transform(world, (tulle_obstacle_id){1, 1}).position[2] - 0.03
                        : tulle_cloth_get_positions(world, OTHER, NULL)[2];
            bool const is_asleep = tulle_cloth_is_asleep(world, CLOTH);
            if (!has_woken && low > 0.05) assert_true(is_asleep);
            slept_beside_motion |= !has_woken && is_asleep && low > 0.05;
            has_woken |= !is_asleep;
            if (i % 16 == 0) {
                tulle_mesh second = {0};
                tulle_mesh cloths[2] = {self.sheet, second};
                if (!is_ball) cloths[1] = second = small_sheet(0.15, 7, 0.0);
                assert_int_equal(small_judge(world, cloths, is_ball ? 1 : 2, &self.support, 1), 0);
                tulle_mesh_destroy(&second);
            }
        }
        assert_true(has_woken && slept_beside_motion);
        assert_true(tulle_cloth_is_asleep(world, CLOTH));
        if (is_ball)
            assert_true(tulle_obstacle_is_asleep(world, (tulle_obstacle_id){1, 1}));
        else
            assert_true(tulle_cloth_is_asleep(world, OTHER));
        assert_int_equal(step(world).solve_count, 0);
        if (is_ball) { /* the body that lies on it is pushed */
            double const up[3] = {0.0, 0.0, 0.01}, at[3] = {0.0, 0.0, 0.05};
            expect_ok(tulle_obstacle_add_impulse(world, (tulle_obstacle_id){1, 1}, at, up, NULL),
                      NULL);
        } else {
            expect_ok(tulle_cloth_wake(world, OTHER, NULL), NULL);
        }
        step(world);
        assert_false(tulle_cloth_is_asleep(world, CLOTH));
        free_scene(&self, world);
    }
}

/* Gusts come and go in time; while there are any, nothing sleeps. */
static void gusts_keep_awake(void **state) {
    (void)state;
    scene self = default_scene();
    self.def.wind.gust_strength = 1e-9;
    tulle_world *const world = make_scene(&self, ON_TABLE);
    for (int i = 0; i < SETTLE_STEPS; i++) {
        step(world);
        assert_false(tulle_cloth_is_asleep(world, CLOTH));
    }
    tulle_wind wind = self.def.wind;
    wind.gust_strength = 0.0;
    expect_ok(tulle_world_set_wind(world, &wind, NULL), NULL);
    fall_asleep(world);
    wind.gust_strength = 1e-9;
    expect_ok(tulle_world_set_wind(world, &wind, NULL), NULL);
    step(world);
    assert_false(tulle_cloth_is_asleep(world, CLOTH));
    free_scene(&self, world);
}

/* ---- state ---- */

/* A state saved asleep loads asleep, and both worlds go on alike: asleep, and when something comes.
 * So do worlds of other numbers of threads. */
static void sleep_is_state(void **state) {
    (void)state;
    scene selves[3] = {default_scene(), default_scene(), default_scene()};
    tulle_world *worlds[3];
    for (int i = 0; i < 3; i++) {
        selves[i].height = 1.6;
        selves[i].def.threads = i == 1 ? 2 : 1;
        worlds[i] = make_scene(&selves[i], ON_TABLE);
    }
    for (int i = fall_asleep(worlds[0]); i > 0; i--) step(worlds[1]);
    void *bytes;
    size_t size;
    expect_ok(tulle_world_save_state(worlds[0], &bytes, &size, NULL), NULL);
    tulle_error error = {0};
    expect_ok(tulle_world_load_state(worlds[2], bytes, size, &error), &error);
    assert_true(tulle_cloth_is_asleep(worlds[2], CLOTH));
    bool has_woken = false;
    for (int i = 0; i < 500; i++) {
        for (int k = 0; k < 3; k++) step(worlds[k]);
        uint64_t const hash = tulle_world_get_state_hash(worlds[0]);
        assert_true(tulle_world_get_state_hash(worlds[1]) == hash);
        assert_true(tulle_world_get_state_hash(worlds[2]) == hash);
        has_woken |= !tulle_cloth_is_asleep(worlds[0], CLOTH);
    }
    assert_true(has_woken);
    /* back, and the same once more */
    expect_ok(tulle_world_load_state(worlds[0], bytes, size, &error), &error);
    assert_true(tulle_cloth_is_asleep(worlds[0], CLOTH));
    for (int i = 0; i < 500; i++) step(worlds[0]);
    assert_true(tulle_world_get_state_hash(worlds[0]) == tulle_world_get_state_hash(worlds[2]));
    tulle_world_free_state(worlds[0], bytes, size);
    for (int i = 0; i < 3; i++) free_scene(&selves[i], worlds[i]);
}

/* Sleep that no cloth has is refused, though the hash of the state is right. */
static void false_sleep_is_refused(void **state) {
    (void)state;
    enum { HASH_AT = 8, HASHED_FROM = 16 };
    scene self = default_scene();
    tulle_world *const world = make_scene(&self, ON_TABLE);
    fall_asleep(world);
    uint64_t const before = tulle_world_get_state_hash(world);
    void *bytes;
    size_t size, place = 0, found = 0;
    expect_ok(tulle_world_save_state(world, &bytes, &size, NULL), NULL);
    struct {
        uint64_t is_asleep;
        double quiet_time, slept_from;
    } rest, kept;
    for (size_t at = 0; at + sizeof rest <= size; at++) {
        memcpy(&rest, (char *)bytes + at, sizeof rest);
        if (rest.is_asleep != 1 || !(rest.quiet_time >= TIME && rest.quiet_time < TIME + STEP) ||
            rest.slept_from != tulle_world_get_time(world) - STEP)
            continue;
        place = at;
        kept = rest;
        found++;
    }
    assert_int_equal(found, 1);
    for (int i = 0; i < 7; i++) {
        double const wrong[3] = {(double)NAN, -1.0, 1e9};
        rest = kept;
        if (i == 0) rest.is_asleep = 2;
        if (i >= 1 && i < 3) rest.quiet_time = wrong[i - 1];
        if (i >= 3 && i < 6) rest.slept_from = wrong[i - 3];
        memcpy((char *)bytes + place, &rest, sizeof rest);
        uint64_t const hash = hash_block((char *)bytes + HASHED_FROM, size - HASHED_FROM);
        memcpy((char *)bytes + HASH_AT, &hash, sizeof hash);
        tulle_error error = {0};
        tulle_status const status = tulle_world_load_state(world, bytes, size, &error);
        assert_int_equal(status, i < 6 ? TULLE_ERROR_PARSE : TULLE_OK);
        assert_true(tulle_world_get_state_hash(world) == before);
    }
    tulle_world_free_state(world, bytes, size);
    free_scene(&self, world);
}

/* ---- beside what moves ---- */

enum { LARGE = 40, SMALL = 25, WATCHED = SMALL * SMALL };

/* A sheet flies against a ball beside a large one that is pinned, which may sleep or not. */
static tulle_world *make_neighbours(bool may_sleep, tulle_membrane membrane) {
    tulle_error error = {0};
    tulle_world *world;
    tulle_world_def def = tulle_world_def_default();
    memset(def.gravity, 0, sizeof def.gravity);
    def.threads = 2;
    def.membrane = membrane;
    def.sleep_speed = may_sleep ? 1e-6 : 0.0;
    def.sleep_time = 1e-3;
    expect_ok(tulle_world_create(&def, &world, &error), &error);
    tulle_mesh large = small_sheet(1.0, LARGE, 3.0), small = small_sheet(0.5, SMALL, 0.25);
    static uint32_t all[LARGE * LARGE];
    for (uint32_t v = 0; v < LARGE * LARGE; v++) all[v] = v;
    tulle_pin const pin = make_pin(all, LARGE * LARGE, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&large);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    expect_ok(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    cloth.mesh = tulle_mesh_get_view(&small);
    cloth.pin_count = 0;
    cloth.velocity[2] = -3.0;
    expect_ok(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.2;
    tulle_mesh ball = small_shape(shape, 0.02, 0.01, 0.0);
    small_add_obstacle(world, &ball);
    tulle_mesh_destroy(&large);
    tulle_mesh_destroy(&small);
    tulle_mesh_destroy(&ball);
    return world;
}

/* Forces and solves leave a sleeper out. What moves beside it does not notice, to the bit: it goes
 * as beside the same cloth awake, which is pinned and so adds nothing but zeros. */
static void nothing_beside_a_sleeper_is_left_out(void **state) {
    (void)state;
    for (int membrane = 0; membrane < 2; membrane++) {
        tulle_world *const world = make_neighbours(true, (tulle_membrane)membrane);
        tulle_world *const awake = make_neighbours(false, (tulle_membrane)membrane);
        double start[3 * WATCHED], here[3 * WATCHED], there[3 * WATCHED];
        copy_positions(world, OTHER, start);
        for (int i = 0; i < 24; i++) {
            step(world);
            step(awake);
            assert_true(tulle_cloth_is_asleep(world, CLOTH));
            assert_false(tulle_cloth_is_asleep(world, OTHER));
            size_t const count = copy_positions(world, OTHER, here);
            copy_positions(awake, OTHER, there);
            assert_memory_equal(here, there, count * sizeof(double));
        }
        assert_true(measure_way(world, OTHER, start) > 0.1);
        tulle_world_destroy(world);
        tulle_world_destroy(awake);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sleeper_stands_still),
        cmocka_unit_test(waking_is_no_twitch),
        cmocka_unit_test(a_pendulum_comes_to_rest_first),
        cmocka_unit_test(slow_sliding_is_no_rest),
        cmocka_unit_test(every_cause_wakes),
        cmocka_unit_test(what_is_far_does_not_wake),
        cmocka_unit_test(what_it_lies_on_is_removed),
        cmocka_unit_test(what_hangs_on_it_is_removed),
        cmocka_unit_test(what_comes_late_sleeps_too),
        cmocka_unit_test(what_ends_by_the_clock_wakes),
        cmocka_unit_test(what_falls_on_it_wakes),
        cmocka_unit_test(gusts_keep_awake),
        cmocka_unit_test(sleep_is_state),
        cmocka_unit_test(false_sleep_is_refused),
        cmocka_unit_test(nothing_beside_a_sleeper_is_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
