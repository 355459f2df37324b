/* Cloth that follows targets, and what is put elsewhere between steps (tulle/live.h). */
#include "support/paper_options.h"
#include "support/recording.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "tulle/live.h"
#include "tulle/record.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 64.0; /* [s] */
enum { COUNT = 81 };
static tulle_error error;

static void expect(tulle_status wanted, tulle_status status) {
    if (status != wanted)
        fail_msg("status %d, not %d: %s", (int)status, (int)wanted, error.message);
}

/* A sheet of springs that do next to nothing, and a plate far below. */
typedef struct follower {
    tulle_mesh sheet, plate;
    tulle_world *world;
    tulle_cloth_id cloth;
    double targets[3 * COUNT], departures[3 * COUNT];
    unsigned char is_led[COUNT];
} follower;

static void make_follower(follower *made) {
    *made = (follower){.sheet = small_sheet(0.25, 9, 0.0)};
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    made->plate = small_shape(shape, 0.0, 0.0, -3.0);
    tulle_world_def world_def = tulle_world_def_default();
    memset(world_def.gravity, 0, sizeof world_def.gravity);
    world_def.wind.drag_coefficient = 0.0;
    world_def.membrane = TULLE_MEMBRANE_SPRINGS;
    change_paper(&world_def)->cg_tolerance = 1e-10;
    expect(TULLE_OK, tulle_world_create(&world_def, &made->world, &error));
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&made->sheet);
    def.velocity[0] = 3.0;
    def.material.springs = (tulle_springs){.stretch_stiffness = 1e-12, .bend_stiffness = 1e-2};
    def.material.stretch_damping = def.material.bend_damping = def.material.air_damping = 0.0;
    expect(TULLE_OK, tulle_world_add_cloth(made->world, &def, &made->cloth, &error));
    tulle_obstacle_def plate = tulle_obstacle_def_default();
    plate.mesh = tulle_mesh_get_view(&made->plate);
    plate.drive = TULLE_DRIVE_DEFORMING;
    expect(TULLE_OK, tulle_world_add_obstacle(made->world, &plate, NULL, &error));
    expect(TULLE_OK, tulle_world_start(made->world, &error));
    for (size_t v = 0; v < COUNT; v++) { /* twice as large, and wrinkled */
        const double *const x = made->sheet.positions + 3 * v;
        made->targets[3 * v] = 2.0 * x[0];
        made->targets[3 * v + 1] = 2.0 * x[1];
        made->targets[3 * v + 2] = 0.02 * (double)(v * 29 % 7);
    }
}

static void free_follower(follower *made) {
    tulle_world_destroy(made->world);
    tulle_mesh_destroy(&made->sheet);
    tulle_mesh_destroy(&made->plate);
}

static tulle_status follow(follower *made) {
    tulle_cloth_targets const targets = {made->targets, made->departures, made->is_led, COUNT};
    expect(TULLE_OK, tulle_cloth_set_targets(made->world, made->cloth, &targets, &error));
    return tulle_world_step(made->world, STEP, NULL, &error);
}

/* How far a vertex is from its target along z. */
static double get_departure(const follower *made, size_t vertex) {
    const double *const x = tulle_cloth_get_positions(made->world, made->cloth, NULL);
    return x[3 * vertex + 2] - made->targets[3 * vertex + 2];
}

/* Whatever its velocity, and however the targets are bent and stretched. */
static void cloth_goes_to_its_targets(void **state) {
    (void)state;
    follower made;
    make_follower(&made);
    for (int i = 0; i < 4; i++) {
        for (size_t k = 0; k < 3 * COUNT; k++) made.departures[k] = i == 3 ? 0.0625 : 0.0;
        expect(TULLE_OK, follow(&made));
        const double *const x = tulle_cloth_get_positions(made.world, made.cloth, NULL);
        for (size_t k = 0; k < 3 * COUNT; k++)
            assert_true(fabs(x[k] - made.targets[k] - made.departures[k]) < 1e-7);
        for (size_t k = 0; k < 3 * COUNT; k += 3) made.targets[k] += 0.125;
    }
    free_follower(&made);
} /* What is led is at its target to the bit; the departure of one other vertex spreads around it.
   */
static void cloth_bends_by_its_departures(void **state) {
    (void)state;
    follower made;
    make_follower(&made);
    enum { MIDDLE = 40, BESIDE = 41 };
    for (size_t v = 0; v < COUNT; v++) made.is_led[v] = v < 27 || v >= 54;
    made.departures[3 * MIDDLE + 2] = 0.01;
    made.departures[2] = 0.01; /* it is led */
    expect(TULLE_OK, follow(&made));
    const double *const x = tulle_cloth_get_positions(made.world, made.cloth, NULL);
    for (size_t v = 0; v < COUNT; v++)
        if (made.is_led[v]) assert_memory_equal(x + 3 * v, made.targets + 3 * v, 3 * sizeof *x);
    double const middle = get_departure(&made, MIDDLE), beside = get_departure(&made, BESIDE);
    assert_true(middle > 0.0 && middle < 0.005 && beside > 0.25 * middle && beside < middle);
    free_follower(&made);
} /* Without targets it is cloth as ever, which bends by its shape. Loading lets go of targets. */
static void targets_are_for_one_step(void **state) {
    (void)state;
    follower made;
    make_follower(&made);
    void *here = NULL;
    size_t byte_count = 0;
    expect(TULLE_OK, tulle_world_save_state(made.world, &here, &byte_count, &error));
    expect(TULLE_OK, follow(&made));
    uint64_t const hash = tulle_world_get_state_hash(made.world);
    expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error));
    expect(TULLE_OK, tulle_world_step(made.world, STEP, NULL, &error));
    assert_true(fabs(get_departure(&made, 40)) > 1e-3); /* wrinkles come out */
    tulle_cloth_targets const targets = {.positions = made.targets, .vertex_count = COUNT};
    expect(TULLE_OK, tulle_cloth_set_targets(made.world, made.cloth, &targets, &error));
    expect(TULLE_OK, tulle_world_load_state(made.world, here, byte_count, &error));
    expect(TULLE_OK, follow(&made));
    assert_true(hash == tulle_world_get_state_hash(made.world));
    tulle_world_free_state(made.world, here, byte_count);
    free_follower(&made);
}

/* All is where it is put, at rest; what intersects is refused, and all is as it was. */
static void all_can_be_placed(void **state) {
    (void)state;
    follower made;
    make_follower(&made);
    size_t const count = COUNT + made.plate.vertex_count;
    double *const places = malloc(3 * count * sizeof *places);
    assert_non_null(places);
    for (size_t i = 0; i < 3 * COUNT; i++) places[i] = made.targets[i] + 0.5;
    for (size_t i = 3 * COUNT; i < 3 * count; i++)
        places[i] = made.plate.positions[i - 3 * COUNT] - 0.25;
    expect(TULLE_OK, tulle_world_place(made.world, places, count, &error));
    const double *const x = tulle_cloth_get_positions(made.world, made.cloth, NULL);
    const double *const v = tulle_cloth_get_velocities(made.world, made.cloth, NULL);
    assert_memory_equal(x, places, 3 * COUNT * sizeof *x);
    for (size_t i = 0; i < 3 * COUNT; i++) assert_true(v[i] == 0.0);
    assert_memory_equal(tulle_obstacle_get_positions(made.world, (tulle_obstacle_id){0, 1}, NULL),
                        places + 3 * COUNT, 3 * made.plate.vertex_count * sizeof *x);
    uint64_t const hash = tulle_world_get_state_hash(made.world);
    for (size_t i = 0; i < 3 * COUNT; i++) places[i] = made.plate.positions[i % 3] - 0.25;
    memcpy(places, made.targets, sizeof made.targets);
    for (size_t k = 0; k < 3; k++)
        places[3 * 40 + k] = places[3 * COUNT + k]; /* a corner of the plate */
    places[3 * 40 + 2] -= 0.1;
    expect(TULLE_ERROR_INTERSECTING_START, tulle_world_place(made.world, places, count, &error));
    assert_true(hash == tulle_world_get_state_hash(made.world));
    expect(TULLE_OK, follow(&made));
    free(places);
    free_follower(&made);
}

/* A recording leads to the same states, with and without departures, led vertices and places. */
static void targets_are_recorded(void **state) {
    (void)state;
    tulle_world_def const world_def = tulle_world_def_default();
    tulle_world *world = NULL;
    recording bytes;
    expect(TULLE_OK, tulle_world_create(&world_def, &world, &error));
    tulle_record_writer const writer = recording_begin(&bytes);
    expect(TULLE_OK, tulle_world_record(world, &writer, &error));
    tulle_mesh sheet = small_sheet(0.3, 9, 0.0);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    expect(TULLE_OK, tulle_world_start(world, &error));
    unsigned char const is_led[COUNT] = {1, 1, 1};
    double departures[3 * COUNT];
    for (size_t i = 0; i < 3 * COUNT; i++) departures[i] = 1e-3 * sin((double)i);
    for (int i = 0; i < 6; i++) {
        tulle_cloth_targets const targets = {sheet.positions, i < 2 ? NULL : departures,
                                             i == 0 ? NULL : is_led, COUNT};
        if (i == 3) expect(TULLE_OK, tulle_world_place(world, sheet.positions, COUNT, &error));
        expect(TULLE_OK, tulle_cloth_set_targets(world, cloth, &targets, &error));
        expect(TULLE_OK, tulle_world_step(world, STEP, NULL, &error));
        for (size_t k = 0; k < 3 * COUNT; k += 3) sheet.positions[k] += 1e-3;
    }
    uint64_t const hash = tulle_world_get_state_hash(world);
    expect(TULLE_OK, tulle_world_record(world, NULL, &error));
    tulle_replay_report report;
    expect(TULLE_OK, tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, &error));
    assert_true(report.is_whole && !report.is_different && report.hash == hash);
    assert_int_equal(report.steps, 6);
    free(bytes.bytes);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_goes_to_its_targets),
        cmocka_unit_test(cloth_bends_by_its_departures),
        cmocka_unit_test(targets_are_for_one_step),
        cmocka_unit_test(all_can_be_placed),
        cmocka_unit_test(targets_are_recorded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
