/* Rollback as of a game over a network: the host learns some frames late what the player did, goes
 * back to the last state that it is sure of, and makes the frames since then again. After 600
 * frames it has the state of a host that knew everything at once. A cape hangs from pins that the
 * host moves over a ball that it moves, beside a box that falls and is pushed; wind and friction
 * change. Then violent motion, of which each step is made again from states that leave out what
 * never changes. */
#include "tulle/live.h"

#include "base/hash.h"
#include "support/body_world.h"
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/test_support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { FRAMES = 600, LATE_MOST = 8, SIDE = 7 };
static const double STEP = 1.0 / 60.0; /* [s] */
static const tulle_cloth_id CAPE = {0, 1};
static const tulle_obstacle_id BALL = {0, 1}, BOX = {2, 1};

typedef struct saved {
    void *bytes;
    size_t byte_count;
} saved;

typedef struct host {
    tulle_world *world;
    double anchors[3 * SIDE];  /* [m] the pins as modelled */
    saved states[FRAMES];      /* before each frame */
    uint64_t rollbacks, again; /* how often; frames made again */
} host;

static void expect_ok(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("%s", error->message);
}

static void make_host(host *made) {
    memset(made, 0, sizeof *made);
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    tulle_error error = {0};
    expect_ok(tulle_world_create(&world_def, &made->world, &error), &error);
    tulle_mesh sheet = small_sheet(0.4, SIDE, 0.0);
    uint32_t row[SIDE];
    for (uint32_t k = 0; k < SIDE; k++) row[k] = k;
    memcpy(made->anchors, sheet.positions, sizeof made->anchors);
    tulle_pin const pin = make_pin(row, SIDE, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    expect_ok(tulle_world_add_cloth(made->world, &cloth, NULL, &error), &error);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.12;
    shape.resolution[0] = 5;
    tulle_mesh ball = small_shape(shape, 0.0, 0.1, -0.2);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&ball);
    def.drive = TULLE_DRIVE_RIGID;
    expect_ok(tulle_world_add_obstacle(made->world, &def, NULL, &error), &error);
    tulle_mesh ground = bodies_make_box(3.0, 3.0, 0.1, (double[]){0, 0, -1.0});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.8, 0, -0.8});
    small_add_obstacle(made->world, &ground);
    tulle_body const body = {
        .is_dynamic = 1, .density = 300.0, .sleep_speed = 0.05, .sleep_time = 0.2};
    bodies_add_obstacle(made->world, &box, 0.5, &body);
    expect_ok(tulle_world_start(made->world, &error), &error);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&box);
}

/* One frame: what the player does in it, or what the host guesses, that he does nothing. */
static void make_frame(host *self, int frame, bool is_known) {
    tulle_world *const world = self->world;
    tulle_error error = {0};
    double const phase = is_known ? 0.05 * frame : 0.0;
    double const way[3] = {0.1 * sin(phase), 0.05 * sin(2.3 * phase), 0.0};
    double const turn[4] = {cos(phase), 0.0, sin(phase), 0.0};
    double anchors[3 * SIDE];
    for (size_t k = 0; k < 3 * SIDE; k++) anchors[k] = self->anchors[k] + way[k % 3];
    expect_ok(tulle_cloth_set_pin_targets(world, CAPE, 0, anchors, SIDE, &error), &error);
    expect_ok(tulle_obstacle_set_next_transform(world, BALL, way, turn, TULLE_TRAVEL_MOVE, &error),
              &error);
    if (is_known && frame % 50 == 20) {
        tulle_wind wind = tulle_world_def_default().wind;
        wind.velocity[1] = frame % 100 == 20 ? 4.0 : 0.0;
        tulle_contact_law const law = {frame % 100 == 20 ? 0.1 : 0.8, -1.0, 0.2};
        double const point[3] = {0.8, 0.0, -0.9}, push[3] = {0.0, 0.02, 0.1};
        expect_ok(tulle_world_set_wind(world, &wind, &error), &error);
        expect_ok(tulle_world_set_cloth_obstacle_law(world, CAPE, BALL, &law, &error), &error);
        expect_ok(tulle_obstacle_add_impulse(world, BOX, point, push, &error), &error);
    }
    expect_ok(tulle_world_step(world, STEP, NULL, &error), &error);
}

/* Keeps the state before a frame, in place of what was kept for it. */
static void keep_state(host *self, int frame) {
    saved *const kept = &self->states[frame];
    tulle_error error = {0};
    tulle_world_free_state(self->world, kept->bytes, kept->byte_count);
    expect_ok(tulle_world_save_state(self->world, &kept->bytes, &kept->byte_count, &error), &error);
}

/* Makes frames begin .. end - 1 again, of which all is known now. */
static void roll_back(host *self, int begin, int end) {
    const saved *const from = &self->states[begin];
    tulle_error error = {0};
    expect_ok(tulle_world_load_state(self->world, from->bytes, from->byte_count, &error), &error);
    for (int frame = begin; frame < end; frame++) {
        keep_state(self, frame);
        make_frame(self, frame, true);
    }
    self->rollbacks++;
    self->again += (uint64_t)(end - begin);
}

static void late_news_lead_to_the_same_state(void **state) {
    (void)state;
    static host knows, learns;
    make_host(&knows);
    make_host(&learns);
    for (int frame = 0; frame < FRAMES; frame++) make_frame(&knows, frame, true);
    uint64_t random = 11;
    int sure = 0; /* frames that need not be made again */
    for (int frame = 0; frame < FRAMES; frame++) {
        bool const is_known = sure == frame && random_next(&random) % 4 == 0;
        keep_state(&learns, frame);
        make_frame(&learns, frame, is_known);
        if (is_known) sure = frame + 1;
        bool const is_news = frame + 1 - sure == LATE_MOST || random_next(&random) % 6 == 0;
        if (sure > frame || !(is_news || frame == FRAMES - 1)) continue;
        roll_back(&learns, sure, frame + 1);
        sure = frame + 1;
    }
    print_message("%d rollbacks, %d frames made again\n", (int)learns.rollbacks, (int)learns.again);
    assert_true(learns.rollbacks > 50);
    assert_true(tulle_world_get_state_hash(learns.world) ==
                tulle_world_get_state_hash(knows.world));
    for (int frame = 0; frame < FRAMES; frame++)
        tulle_world_free_state(learns.world, learns.states[frame].bytes,
                               learns.states[frame].byte_count);
    tulle_world_destroy(knows.world);
    tulle_world_destroy(learns.world);
}

/* ---- violent motion ---- */

enum { VIOLENT_STEPS = 36, AGAIN = 5 };
typedef enum violence { PLAIN, HISTORY, WITHOUT_IMPULSES } violence;

/* Two sheets are thrown against a ball that never moves, whose centre has a zero with a sign, and a
 * plate on keyframes hits them from behind; a body is in the way. Gusts. */
static tulle_world *make_violent(violence kind, uint32_t resolution) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = 1;
    if (kind == HISTORY) world_def.integrator = TULLE_INTEGRATOR_BDF2;
    if (kind == WITHOUT_IMPULSES) {
        tulle_paper_options *const paper = change_paper(&world_def);
        paper->impact_rounds = 0;
        paper->solve_rounds = paper->impulse_sweeps = 1;
        world_def.quality = TULLE_QUALITY_DRAFT;
    }
    world_def.wind = (tulle_wind){.velocity = {0, 8, 0},
                                  .gust_strength = 6.0,
                                  .gust_length = 0.3,
                                  .gust_time = 0.1,
                                  .seed = 5,
                                  .drag_coefficient = 0.7};
    tulle_world *world = NULL;
    tulle_error error = {0};
    expect_ok(tulle_world_create(&world_def, &world, &error), &error);
    for (int i = 0; i < 2; i++) {
        tulle_mesh sheet = small_sheet(0.4, 10, 0.6 + 0.06 * i);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.velocity[0] = i == 0 ? 1.0 : -1.0;
        cloth.velocity[2] = -8.0;
        cloth.material.bend_hysteresis_warp = 1e-5;
        expect_ok(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
        tulle_mesh_destroy(&sheet);
    }
    tulle_mesh box = bodies_make_box(0.08, 0.08, 0.08, (double[]){0.15, 0.1, 0.1});
    tulle_body const body = {.is_dynamic = 1, .density = 200.0};
    bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.1;
    shape.resolution[0] = resolution;
    tulle_mesh ball = small_shape(shape, -0.0, -0.0, -0.0);
    for (size_t i = 0; i < 3 * ball.vertex_count; i++)
        if (ball.positions[i] == 0.0) ball.positions[i] = -0.0;
    small_add_obstacle(world, &ball);
    tulle_mesh plate = bodies_make_box(0.3, 0.3, 0.02, (double[]){0, 0, 0.9});
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}},
                                   {0.1, {0, 0, -0.75}, {0, 0, 0}},
                                   {0.3, {0.2, 0, 0.1}, {0, 0, 0}}};
    def.mesh = tulle_mesh_get_view(&plate);
    def.motion = (tulle_motion){keys, 3, {0, 0, 0}, 0};
    expect_ok(tulle_world_add_obstacle(world, &def, NULL, &error), &error);
    tulle_mesh far = bodies_make_box(1.0, 1.0, 0.1, (double[]){0, 0, -3.0});
    small_add_obstacle(world, &far);
    expect_ok(tulle_world_start(world, &error), &error);
    tulle_mesh_destroy(&box);
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&plate);
    tulle_mesh_destroy(&far);
    return world;
}

/* Loads the state of before step `begin` and makes some steps: each has the hash that it had. */
static void go_again(tulle_world *world, const saved *from, const uint64_t *hashes, int begin) {
    tulle_error error = {0};
    expect_ok(tulle_world_load_state(world, from->bytes, from->byte_count, &error), &error);
    for (int step = begin; step <= VIOLENT_STEPS && step <= begin + AGAIN; step++) {
        if (tulle_world_get_state_hash(world) != hashes[step])
            fail_msg("from step %d: other bits before step %d", begin, step);
        if (step < VIOLENT_STEPS) expect_ok(tulle_world_step(world, STEP, NULL, &error), &error);
    }
}

/* What a saved state leaves out changes no bit of any later step, whether the world that loads it
 * has gone another way or is new. */
static void check_violent(violence kind) {
    tulle_world *const world = make_violent(kind, 6), *const other = make_violent(kind, 6);
    tulle_error error = {0};
    saved states[VIOLENT_STEPS];
    uint64_t hashes[VIOLENT_STEPS + 1];
    uint64_t substeps = 0, impacts = 0, contacts = 0, shortened = 0;
    for (int step = 0; step < VIOLENT_STEPS; step++) {
        saved *const state = &states[step];
        size_t const capacity = tulle_world_get_state_size(world);
        state->bytes = malloc(capacity);
        assert_non_null(state->bytes);
        expect_ok(
            tulle_world_save_state_into(world, state->bytes, capacity, &state->byte_count, &error),
            &error);
        assert_int_equal(state->byte_count, capacity);
        hashes[step] = tulle_world_get_state_hash(world);
        tulle_step_report report;
        expect_ok(tulle_world_step(world, STEP, &report, &error), &error);
        substeps += report.substeps;
        impacts += report.impact_rounds;
        contacts += report.contacts;
        shortened += report.rescue_global_scalings;
    }
    hashes[VIOLENT_STEPS] = tulle_world_get_state_hash(world);
    print_message("%d steps: %d substeps, %d rounds of impacts, %d contacts, %d shortened\n",
                  VIOLENT_STEPS, (int)substeps, (int)impacts, (int)contacts, (int)shortened);
    assert_true(contacts > 1000 && substeps > VIOLENT_STEPS);
    assert_true(kind == WITHOUT_IMPULSES ? shortened > 0 : impacts > VIOLENT_STEPS / 2);
    int const stride = getenv("TULLE_TEST_LONG") ? 4 : 9;
    for (int step = VIOLENT_STEPS - 1; step >= 0; step -= stride) {
        tulle_world *const fresh = make_violent(kind, 6);
        go_again(fresh, &states[step], hashes, step);
        go_again(world, &states[step], hashes, step);
        if (step % 2 == 0) expect_ok(tulle_world_step(other, 0.3 * STEP, NULL, &error), &error);
        go_again(other, &states[step], hashes, step);
        tulle_world_destroy(fresh);
    }
    for (int step = 0; step < VIOLENT_STEPS; step++) free(states[step].bytes);
    tulle_world_destroy(world);
    tulle_world_destroy(other);
}

static void a_loaded_state_goes_on_to_the_same_bits(void **state) {
    (void)state;
    check_violent(PLAIN);
    check_violent(HISTORY);
    check_violent(WITHOUT_IMPULSES);
}

/* A ball that never moves is not in the state, however many vertices it has. Both ways of saving
 * give the same bytes. */
static void static_obstacles_take_no_room(void **unused) {
    (void)unused;
    tulle_world *const coarse = make_violent(PLAIN, 3);
    tulle_world *const fine = make_violent(PLAIN, 20);
    size_t const size = tulle_world_get_state_size(fine);
    assert_int_equal(size, tulle_world_get_state_size(coarse));
    unsigned char *const into = malloc(size);
    assert_non_null(into);
    void *bytes = NULL;
    size_t byte_count = 0, into_count = 0;
    assert_int_equal(tulle_world_save_state(fine, &bytes, &byte_count, NULL), TULLE_OK);
    assert_int_equal(tulle_world_save_state_into(fine, into, size, &into_count, NULL), TULLE_OK);
    assert_int_equal(byte_count, size);
    assert_int_equal(into_count, size);
    assert_memory_equal(bytes, into, size);
    tulle_world_free_state(fine, bytes, byte_count);
    free(into);
    tulle_world_destroy(coarse);
    tulle_world_destroy(fine);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(late_news_lead_to_the_same_state),
                                       cmocka_unit_test(a_loaded_state_goes_on_to_the_same_bits),
                                       cmocka_unit_test(static_obstacles_take_no_room)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
