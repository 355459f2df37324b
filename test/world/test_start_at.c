/* Starts amid a motion (tulle_world_start_at): beside the same world that went there step by step.
 */
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 9, VERTICES = SIDE * SIDE };
static double const STEP = 1.0 / 90.0;
static const tulle_cloth_id sheet = {0, 1};
static tulle_error error;

static void expect(tulle_status wanted, tulle_status status, int line) {
    if (status != wanted)
        fail_msg("line %d: status %d, not %d: %s", line, (int)status, (int)wanted, error.message);
}
#define FINE(call) expect(TULLE_OK, (call), __LINE__)
#define REFUSED(call) expect(TULLE_ERROR_INVALID_ARGUMENT, (call), __LINE__)

/* What a world has beside a sheet of which a row follows a pin on keyframes. */
typedef struct setting {
    double gravity, door_appears, door_leaves;
    int attaches, threads;
} setting;

static const setting plain = {
    .gravity = -9.81, .door_appears = -(double)INFINITY, .door_leaves = (double)INFINITY};

/* A recording in memory. */
typedef struct tape_bytes {
    unsigned char *bytes;
    size_t count;
} tape_bytes;

static int write_tape(void *context, const void *bytes, size_t byte_count) {
    tape_bytes *const to = context;
    unsigned char *const longer = realloc(to->bytes, to->count + byte_count);
    if (!longer) return 0;
    memcpy(longer + to->count, bytes, byte_count);
    to->bytes = longer;
    to->count += byte_count;
    return 1;
}

static tulle_world *make_recorded(setting wanted, tape_bytes *to) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.gravity[2] = wanted.gravity;
    world_def.threads = wanted.threads;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&world_def, &world, &error));
    tulle_record_writer const writer = {write_tape, to};
    if (to) FINE(tulle_world_record(world, &writer, &error));
    tulle_mesh mesh = small_sheet(0.4, SIDE, 0.5);
    uint32_t row[SIDE];
    for (uint32_t k = 0; k < SIDE; k++) row[k] = k;
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {.time = 1.0,
                                     .translation = {0.0, 0.2, 0.1},
                                     .rotation_vector = {1.2870022175865687, 0, 0}}};
    tulle_pin pin = make_pin(row, SIDE, 0.6);
    pin.motion = (tulle_motion){.keys = keys, .key_count = 2};
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&mesh);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    FINE(tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.1;
    tulle_mesh box = small_shape(shape, 0.0, 0.35, 0.5);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    def.motion = (tulle_motion){.keys = keys, .key_count = 2};
    def.appear_time = wanted.door_appears;
    def.disappear_time = wanted.door_leaves;
    tulle_obstacle_id id;
    FINE(tulle_world_add_obstacle(world, &def, &id, &error));
    if (wanted.attaches) {
        uint32_t const corner[1] = {VERTICES - 1};
        tulle_attachment_def attachment = tulle_attachment_def_default();
        attachment.cloth = sheet;
        attachment.obstacle = id;
        attachment.vertices = corner;
        attachment.vertex_count = 1;
        tulle_attachment_id made;
        FINE(tulle_world_attach(world, &attachment, &made, &error));
    }
    tulle_mesh_destroy(&mesh);
    tulle_mesh_destroy(&box);
    return world;
}

static tulle_world *make_world(setting wanted) { return make_recorded(wanted, NULL); }

static void step(tulle_world *world, int count) {
    for (int i = 0; i < count; i++) FINE(tulle_world_step(world, STEP, NULL, &error));
}

/* Where a world is; its arrays live until its next step. */
static tulle_moment look(const tulle_world *world) {
    tulle_moment moment = {.time = tulle_world_get_time(world),
                           .step_count = tulle_world_get_step_count(world)};
    moment.positions = tulle_cloth_get_positions(world, sheet, &moment.vertex_count);
    moment.velocities = tulle_cloth_get_velocities(world, sheet, NULL);
    return moment;
}

static double measure_distance(const tulle_world *a, const tulle_world *b) {
    const double *const x = tulle_cloth_get_positions(a, sheet, NULL);
    const double *const y = tulle_cloth_get_positions(b, sheet, NULL);
    double most = 0.0;
    for (size_t i = 0; i < 3 * VERTICES; i++) most = fmax(most, fabs(x[i] - y[i]));
    return most;
}

/* Pins and attachments hold what they held, by their own motion; scripts go on. */
static void the_motion_goes_on(void **state) {
    (void)state;
    for (int attaches = 0; attaches < 2; attaches++) {
        setting wanted = plain;
        wanted.attaches = attaches;
        tulle_world *const before = make_world(wanted), *const after = make_world(wanted);
        step(before, 40);
        tulle_moment const moment = look(before);
        FINE(tulle_world_start_at(after, &moment, &error));
        assert_true(measure_distance(before, after) == 0.0);
        assert_true(tulle_world_get_time(after) == tulle_world_get_time(before));
        assert_int_equal(tulle_world_get_step_count(after), 40);
        const double *const door =
            tulle_obstacle_get_positions(before, (tulle_obstacle_id){0, 1}, NULL);
        assert_memory_equal(door,
                            tulle_obstacle_get_positions(after, (tulle_obstacle_id){0, 1}, NULL),
                            24 * sizeof(double));
        step(before, 60); /* the pin lets go on the way */
        step(after, 60);
        double const distance = measure_distance(before, after);
        if (!(distance < 2e-4)) fail_msg("%g m apart", distance);
        tulle_world_destroy(before);
        tulle_world_destroy(after);
    }
}

static void other_values_count_from_there_on(void **state) {
    (void)state;
    setting heavy = plain;
    heavy.gravity = -20.0;
    tulle_world *const before = make_world(plain), *const after = make_world(heavy);
    step(before, 70); /* the pin has let go */
    tulle_moment const moment = look(before);
    double height = 0.0, fallen = 0.0, wanted = 0.0;
    for (size_t v = 0; v < VERTICES; v++) {
        height += moment.positions[3 * v + 2] / VERTICES;
        wanted += moment.velocities[3 * v + 2] * 9 * STEP / VERTICES;
    }
    FINE(tulle_world_start_at(after, &moment, &error));
    step(after, 9);
    const double *const x = tulle_cloth_get_positions(after, sheet, NULL);
    for (size_t v = 0; v < VERTICES; v++) fallen += x[3 * v + 2] / VERTICES;
    wanted -= 20.0 * STEP * STEP * 45; /* backward Euler: 1 + 2 + ... + 9 */
    assert_true(fabs(fallen - height - wanted) < 0.15 * fabs(wanted)); /* air */
    tulle_world_destroy(before);
    tulle_world_destroy(after);
}

static void obstacles_are_there_by_their_times(void **state) {
    (void)state;
    static const struct {
        double appears, leaves;
        int is_there;
    } cases[] = {{0.2, 0.5, 1}, {0.45, 1.0, 0}, {-(double)INFINITY, 0.4, 0}, {0.0, 0.1, 0}};
    tulle_world *const before = make_world(plain);
    step(before, 40); /* 0.444 s */
    tulle_moment const moment = look(before);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        setting wanted = plain;
        wanted.door_appears = cases[i].appears, wanted.door_leaves = cases[i].leaves;
        tulle_world *const world = make_world(wanted);
        FINE(tulle_world_start_at(world, &moment, &error));
        assert_int_equal(tulle_obstacle_is_present(world, (tulle_obstacle_id){0, 1}),
                         cases[i].is_there);
        step(world, 3);
        tulle_world_destroy(world);
    }
    tulle_world_destroy(before);
}

/* At time 0, from where the defs have it, it is a start as any. */
static void at_time_zero_it_is_the_start(void **state) {
    (void)state;
    tulle_world *const usual = make_world(plain), *const other = make_world(plain);
    FINE(tulle_world_start(usual, &error));
    tulle_moment const moment = look(usual);
    FINE(tulle_world_start_at(other, &moment, &error));
    assert_true(tulle_world_get_state_hash(usual) == tulle_world_get_state_hash(other));
    step(usual, 30);
    step(other, 30);
    assert_true(tulle_world_get_state_hash(usual) == tulle_world_get_state_hash(other));
    tulle_world_destroy(usual);
    tulle_world_destroy(other);
}

static void threads_and_saved_states_change_nothing(void **state) {
    (void)state;
    setting three = plain;
    three.threads = 3;
    tulle_world *const before = make_world(plain), *const one = make_world(plain);
    tulle_world *const many = make_world(three), *const loaded = make_world(plain);
    step(before, 30);
    tulle_moment const moment = look(before);
    FINE(tulle_world_start_at(one, &moment, &error));
    FINE(tulle_world_start_at(many, &moment, &error));
    step(one, 10);
    step(many, 10);
    void *bytes = NULL;
    size_t byte_count = 0;
    FINE(tulle_world_save_state(one, &bytes, &byte_count, &error));
    FINE(tulle_world_load_state(loaded, bytes, byte_count, &error));
    tulle_world *const worlds[3] = {one, many, loaded};
    for (int i = 0; i < 3; i++) step(worlds[i], 10);
    assert_true(tulle_world_get_state_hash(one) == tulle_world_get_state_hash(many));
    assert_true(tulle_world_get_state_hash(one) == tulle_world_get_state_hash(loaded));
    tulle_world_free_state(one, bytes, byte_count);
    for (int i = 0; i < 3; i++) tulle_world_destroy(worlds[i]);
    tulle_world_destroy(before);
}

/* Three more steps; the recording repeats them, and what was before. */
static void check_recording(tulle_world *world, tape_bytes *tape) {
    step(world, 3);
    uint64_t const hash = tulle_world_get_state_hash(world);
    FINE(tulle_world_record(world, NULL, &error));
    tulle_replay_report report;
    FINE(tulle_replay(tape->bytes, tape->count, NULL, &report, &error));
    assert_true(report.is_whole && !report.is_different);
    assert_int_equal(report.steps, 3);
    assert_true(report.hash == hash);
    free(tape->bytes);
}

static void recordings_repeat_it(void **state) {
    (void)state;
    tape_bytes tape = {0};
    tulle_world *const before = make_world(plain), *const world = make_recorded(plain, &tape);
    step(before, 30);
    tulle_moment moment = look(before);
    moment.time = -1.0;
    REFUSED(tulle_world_start_at(world, &moment, &error));
    moment.time = tulle_world_get_time(before);
    FINE(tulle_world_start_at(world, &moment, &error));
    check_recording(world, &tape);
    tulle_world_destroy(before);
    tulle_world_destroy(world);
}

/* A start that is refused leaves a world that can start in another way, and tells the pairs. */
static void what_intersects_there_is_refused(void **state) {
    (void)state;
    tulle_world *const before = make_world(plain), *const world = make_world(plain);
    step(before, 10);
    tulle_moment moment = look(before);
    double *const pierced = malloc(3 * VERTICES * sizeof *pierced);
    assert_non_null(pierced);
    memcpy(pierced, moment.positions, 3 * VERTICES * sizeof *pierced);
    const double *const door =
        tulle_obstacle_get_positions(before, (tulle_obstacle_id){0, 1}, NULL);
    for (int k = 0; k < 3; k++) pierced[3 * VERTICES - 3 + k] = 0.5 * (door[k] + door[k + 18]);
    moment.positions = pierced;
    expect(TULLE_ERROR_INTERSECTING_START, tulle_world_start_at(world, &moment, &error), __LINE__);
    size_t count = 0;
    assert_non_null(tulle_world_get_intersections(world, &count));
    assert_true(count > 0);
    assert_int_equal(tulle_world_get_step_count(world), 0);
    assert_true(tulle_world_get_time(world) == 0.0);
    moment = look(before);
    FINE(tulle_world_start_at(world, &moment, &error));
    REFUSED(tulle_world_start_at(world, &moment, &error)); /* it has started */
    step(world, 2);
    free(pierced);
    tulle_world_destroy(before);
    tulle_world_destroy(world);
}

static void bad_moments_are_refused(void **state) {
    (void)state;
    tulle_world *const before = make_world(plain), *const world = make_world(plain);
    step(before, 3);
    tulle_moment const good = look(before);
    double *const numbers = malloc(3 * VERTICES * sizeof *numbers);
    assert_non_null(numbers);
    memcpy(numbers, good.positions, 3 * VERTICES * sizeof *numbers);
    numbers[3 * VERTICES - 1] = (double)NAN;
    tulle_moment bad[7];
    for (size_t i = 0; i < 7; i++) bad[i] = good;
    bad[0].positions = NULL;
    bad[1].velocities = NULL;
    bad[2].vertex_count++;
    bad[3].time = -1e-9;
    bad[4].time = (double)INFINITY;
    bad[5].positions = numbers;
    bad[6].velocities = numbers;
    for (size_t i = 0; i < 7; i++) REFUSED(tulle_world_start_at(world, &bad[i], &error));
    REFUSED(tulle_world_start_at(world, NULL, &error));
    REFUSED(tulle_world_start_at(NULL, &good, &error));
    tulle_obstacle_def body = tulle_obstacle_def_default();
    tulle_mesh box = small_shape(tulle_shape_def_default(TULLE_SHAPE_BOX), 5.0, 0.0, 0.0);
    body.mesh = tulle_mesh_get_view(&box);
    body.body.is_dynamic = 1;
    body.body.mass = 1.0;
    FINE(tulle_world_add_obstacle(world, &body, NULL, &error));
    REFUSED(tulle_world_start_at(world, &good, &error));
    FINE(tulle_world_start(world, &error));
    tulle_mesh_destroy(&box);
    free(numbers);
    tulle_world_destroy(before);
    tulle_world_destroy(world);
}

/* ---- rigid bodies ---- */

enum { THROWN, WAITING, LATE, BODIES, CORNERS = 8 };
static const char *const body_names[BODIES] = {"thrown", "waiting", "late"};

static tulle_obstacle_id get_body_id(size_t body) {
    return (tulle_obstacle_id){(uint32_t)(body + 1), 1}; /* behind the door */
}

/* A body that flies and turns, one that follows a script until 0.3 s, one that comes at 0.35 s. */
static tulle_world *make_world_with_bodies(tape_bytes *to) {
    tulle_world *const world = make_recorded(plain, to);
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {.time = 1.0,
                                     .translation = {1.0, 0.0, 0.0},
                                     .rotation_vector = {0, 1.2870022175865687, 0}}};
    for (size_t b = 0; b < BODIES; b++) {
        tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
        shape.size[0] = 0.1, shape.size[1] = 0.2, shape.size[2] = 0.3;
        tulle_mesh box = small_shape(shape, 2.0 + (double)b, 0.1, 5.0);
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.name = body_names[b];
        def.mesh = tulle_mesh_get_view(&box);
        def.body.is_dynamic = 1;
        def.body.mass = 1.0;
        if (b == WAITING) {
            def.motion = (tulle_motion){.keys = keys, .key_count = 2};
            def.body.start_time = 0.3;
        } else {
            def.body.velocity[1] = 0.7;
            def.body.angular_velocity[0] = 3.0;
            def.body.angular_velocity[2] = 1.0;
        }
        if (b == LATE) def.appear_time = 0.35;
        FINE(tulle_world_add_obstacle(world, &def, NULL, &error));
        tulle_mesh_destroy(&box);
    }
    return world;
}

static void look_at_bodies(const tulle_world *world, tulle_moment *moment,
                           tulle_transform bodies[BODIES]) {
    *moment = look(world);
    for (size_t b = 0; b < BODIES; b++)
        FINE(tulle_obstacle_get_transform(world, get_body_id(b), &bodies[b], &error));
    moment->bodies = bodies;
    moment->body_count = BODIES;
}

static double measure_distance_of_body(const tulle_world *a, const tulle_world *b, size_t body) {
    const double *const x = tulle_obstacle_get_positions(a, get_body_id(body), NULL);
    const double *const y = tulle_obstacle_get_positions(b, get_body_id(body), NULL);
    double most = 0.0;
    for (size_t i = 0; i < 3 * (size_t)CORNERS; i++) most = fmax(most, fabs(x[i] - y[i]));
    return most;
}

/* Bodies are where they were and fly on, whether they were free, scripted or absent. */
static void bodies_go_on(void **state) {
    (void)state;
    static const int counts[] = {10, 29, 40};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        tulle_world *const before = make_world_with_bodies(NULL);
        tulle_world *const after = make_world_with_bodies(NULL);
        tulle_transform bodies[BODIES], there;
        tulle_moment moment;
        step(before, counts[i]);
        look_at_bodies(before, &moment, bodies);
        FINE(tulle_world_start_at(after, &moment, &error));
        for (size_t b = 0; b < BODIES; b++) {
            bool const is_free = b == THROWN || (b == WAITING && moment.time >= 0.3) ||
                                 (b == LATE && moment.time >= 0.35);
            FINE(tulle_obstacle_get_transform(after, get_body_id(b), &there, &error));
            assert_true(!is_free ||
                        memcmp(there.position, bodies[b].position, sizeof there.position) == 0);
            assert_true(!is_free ||
                        memcmp(there.velocity, bodies[b].velocity, sizeof there.velocity) == 0);
            assert_true(measure_distance_of_body(before, after, b) < 1e-14);
        }
        assert_true(measure_distance_of_body(before, after, THROWN) < 1e-14);
        step(before, 30);
        step(after, 30);
        for (size_t b = 0; b < BODIES; b++) {
            double const distance = measure_distance_of_body(before, after, b);
            if (!(distance < 1e-11))
                fail_msg("after %d steps '%s' is %g m apart", counts[i], body_names[b], distance);
        }
        tulle_world_destroy(before);
        tulle_world_destroy(after);
    }
}

static void recordings_repeat_bodies(void **state) {
    (void)state;
    tape_bytes tape = {0};
    tulle_world *const before = make_world_with_bodies(NULL);
    tulle_world *const world = make_world_with_bodies(&tape);
    tulle_transform bodies[BODIES];
    tulle_moment moment;
    step(before, 40);
    look_at_bodies(before, &moment, bodies);
    FINE(tulle_world_start_at(world, &moment, &error));
    check_recording(world, &tape);
    tulle_world_destroy(before);
    tulle_world_destroy(world);
}

static void bad_bodies_are_refused(void **state) {
    (void)state;
    tulle_world *const before = make_world_with_bodies(NULL);
    tulle_world *const world = make_world_with_bodies(NULL);
    tulle_transform bodies[BODIES], bad[BODIES];
    tulle_moment moment;
    step(before, 3);
    look_at_bodies(before, &moment, bodies);
    tulle_moment fewer = moment, none = moment;
    fewer.body_count--;
    none.bodies = NULL;
    REFUSED(tulle_world_start_at(world, &fewer, &error));
    REFUSED(tulle_world_start_at(world, &none, &error));
    double *const numbers[] = {bad[1].position, bad[1].velocity + 2, bad[1].angular_velocity + 1,
                               bad[1].rotation + 3};
    moment.bodies = bad;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        memcpy(bad, bodies, sizeof bad);
        *numbers[i] = (double)NAN;
        REFUSED(tulle_world_start_at(world, &moment, &error));
    }
    memcpy(bad, bodies, sizeof bad);
    bad[2].rotation[0] += 1e-3;
    REFUSED(tulle_world_start_at(world, &moment, &error));
    moment.bodies = bodies;
    FINE(tulle_world_start_at(world, &moment, &error));
    tulle_world_destroy(before);
    tulle_world_destroy(world);
}

/* A body that is where cloth is refuses the start. */
static void a_body_in_cloth_is_refused(void **state) {
    (void)state;
    tulle_world *const before = make_world_with_bodies(NULL);
    tulle_world *const world = make_world_with_bodies(NULL);
    tulle_transform bodies[BODIES];
    tulle_moment moment;
    step(before, 3);
    look_at_bodies(before, &moment, bodies);
    memcpy(bodies[THROWN].position, moment.positions, sizeof bodies[THROWN].position);
    expect(TULLE_ERROR_INTERSECTING_START, tulle_world_start_at(world, &moment, &error), __LINE__);
    tulle_world_destroy(before);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_go_on),
        cmocka_unit_test(recordings_repeat_bodies),
        cmocka_unit_test(bad_bodies_are_refused),
        cmocka_unit_test(a_body_in_cloth_is_refused),
        cmocka_unit_test(the_motion_goes_on),
        cmocka_unit_test(other_values_count_from_there_on),
        cmocka_unit_test(obstacles_are_there_by_their_times),
        cmocka_unit_test(at_time_zero_it_is_the_start),
        cmocka_unit_test(threads_and_saved_states_change_nothing),
        cmocka_unit_test(recordings_repeat_it),
        cmocka_unit_test(what_intersects_there_is_refused),
        cmocka_unit_test(bad_moments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
