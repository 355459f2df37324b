/* The end of a round: sums of friction by surface, and each bound that tells whether rounds may
 * end. Rows of one cloth vertex each on an obstacle that stands still; velocities as given. */
#include "contact/solve/end_round.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

enum { CLOTH_COUNT = 4, COUNT = 7, MANY_ITERATIONS = 100 };
static const double PENALTY = 10.0; /* [kg] */

typedef struct round_world {
    const solve_effort *effort;
    memory heap;
    arena scratch;
    double inverse_mass[COUNT], v0[3 * COUNT], u[3 * COUNT];
    uint32_t vertex_surface[COUNT];
    surface_range ranges[2];
    surface_set set;
    contact_scene scene;
    contact_row rows[CLOTH_COUNT];
    row_list list;
    friction_sums sums[2];
    round_result result;
} round_world;

/* Cloth of 4 kg at rest, rows that ask for nothing; bounds that hold whatever the rows do, and are
 * the same for costly rounds. */
static void make_world(round_world *world) {
    memset(world, 0, sizeof *world);
    world->heap = memory_default();
    world->scratch = arena_make(&world->heap);
    for (uint32_t v = 0; v < COUNT; v++) {
        world->inverse_mass[v] = v < CLOTH_COUNT ? 1.0 : 0.0;
        world->vertex_surface[v] = v >= CLOTH_COUNT;
    }
    world->ranges[0] = (surface_range){.vertex_end = CLOTH_COUNT, .is_present = true};
    world->ranges[1] = (surface_range){
        .vertex_begin = CLOTH_COUNT, .vertex_end = COUNT, .is_obstacle = true, .is_present = true};
    world->set = (surface_set){.surfaces = world->ranges, .surface_count = 2};
    world->scene = (contact_scene){.set = &world->set,
                                   .vertex_count = COUNT,
                                   .cloth_vertex_count = CLOTH_COUNT,
                                   .vertex_surface = world->vertex_surface,
                                   .inverse_mass = world->inverse_mass,
                                   .time_step = 0.01,
                                   .settings = default_contact_settings,
                                   .heap = &world->heap,
                                   .scratch = &world->scratch};
    contact_settings *const settings = &world->scene.settings;
    settings->settled_speed = settings->settled_drift = settings->settled_slip = 1e9;
    settings->settled_misfit = settings->settled_most = 1e9;
    world->effort = &solve_efforts[TULLE_QUALITY_EXACT];
    for (uint32_t r = 0; r < CLOTH_COUNT; r++)
        world->rows[r] = (contact_row){
            .frame = {.normal = {0.0, 0.0, 1.0},
                      .vertices = {r, CLOTH_COUNT, CLOTH_COUNT + 1, CLOTH_COUNT + 2},
                      .weights = {1.0, -0.5, -0.25, -0.25}},
            .solve = {.inverse_mass = 1.0, .friction_cap = -1.0, .stiffness = PENALTY},
            .law = {.friction_along = 1.0, .friction_across = 1.0}};
    world->list.rows.data = world->rows;
    world->list.rows.count = CLOTH_COUNT;
}

/* What the rows lie on becomes heavy cloth: what friction on obstacles misses has no bound. */
static void lie_on_cloth(round_world *world, bool is_on_cloth) {
    world->scene.cloth_vertex_count = is_on_cloth ? COUNT : CLOTH_COUNT;
    world->ranges[1].is_obstacle = !is_on_cloth;
    for (uint32_t v = CLOTH_COUNT; v < COUNT; v++)
        world->inverse_mass[v] = is_on_cloth ? 1e-9 : 0.0;
}

/* The row of vertex r pushes in the matrix and sticks, and its vertex slips along x at `slip`. The
 * solve took no friction for granted, so the misfit is all of it: -PENALTY slip. */
static void stick(round_world *world, uint32_t r, double slip) {
    world->rows[r].solve.is_in_matrix = world->rows[r].solve.is_hard = true;
    world->rows[r].solve.state = ROW_STICKS;
    world->rows[r].solve.slip_penalty = PENALTY;
    world->rows[r].law.bias = 1e-6;
    world->rows[r].law.friction = 1e6;
    world->u[3 * r] = slip;
}

static bool is_settled(const round_world *made, uint32_t iterations) {
    round_world world = *made; /* rows and velocities change */
    world.scene.set = &world.set;
    world.set.surfaces = world.ranges;
    world.scene.vertex_surface = world.vertex_surface;
    world.scene.inverse_mass = world.inverse_mass;
    if (made->scene.v0) world.scene.v0 = world.v0;
    world.list.rows.data = world.rows;
    assert_int_equal(end_round(&world.scene, get_round_effort(world.effort, iterations),
                               &world.list, world.sums, world.u, &world.result),
                     TULLE_OK);
    return world.result.has_settled;
}

/* Rounds of few iterations go on until no row is violated at all. */
static void cheap_rounds_mend_more(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    assert_true(is_settled(&world, 1));
    world.rows[2].law.bias = 1e-4; /* [m/s] that the row lacks */
    assert_false(is_settled(&world, 1));
    assert_false(is_settled(&world, 32));
    assert_true(is_settled(&world, 33));
    world.rows[2].law.bias = 1e-6;
    assert_true(is_settled(&world, 1));
    arena_destroy(&world.scratch);
}

static void violations_are_bounded(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    world.scene.settings.settled_speed = 1e-3; /* over four rows: 2e-3 of one of them */
    world.rows[1].law.bias = 1.9e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    world.rows[3].law.bias = 1.9e-3;
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.rows[3].law.bias = 0.0;
    world.rows[1].law.bias = 2.1e-3;
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.scene.settings.settled_speed = 1.0;
    world.scene.settings.settled_most = 2e-3;
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.scene.settings.settled_most = 2.2e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    assert_int_equal(
        end_round(&world.scene, &cheap_effort, &world.list, world.sums, world.u, &world.result),
        TULLE_OK);
    assert_true(world.result.largest_violation == 2.1e-3);
    assert_true(world.rows[1].solve.is_hard);
    assert_false(world.rows[0].solve.is_hard);
    arena_destroy(&world.scratch);
}

/* Costly rounds of cloth that is solved less exactly have wider bounds; cheap ones do not. */
static void bounds_of_costly_rounds_are_wider(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    solve_effort const loose = {.cheap_iterations = 32,
                                .looseness = 5.0,
                                .slip_share = 0.01,
                                .most_violation = (double)INFINITY};
    world.effort = &loose;
    world.scene.settings.settled_speed = 1e-3; /* over four rows: 2e-3 of one of them, or 1e-2 */
    world.rows[1].law.bias = 9e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    assert_false(is_settled(&world, 32));
    world.rows[1].law.bias = 11e-3;
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.rows[1].law.bias = 0.0;

    world.scene.settings.settled_drift = 1e-5; /* 4e-5 N s, or 2e-4 */
    lie_on_cloth(&world, true);
    stick(&world, 0, 1.9e-5);
    assert_true(is_settled(&world, MANY_ITERATIONS));
    assert_false(is_settled(&world, 32));
    stick(&world, 0, 2.1e-5);
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.scene.settings.settled_drift = 1e9;
    lie_on_cloth(&world, false);

    /* the cloth moves at 0.1 m/s, root mean square, so it may slip at 1e-3 m/s */
    world.scene.settings.settled_slip = 1e-4;
    world.u[3 * 3 + 1] = 0.2;
    stick(&world, 0, 0.9e-3);
    assert_true(is_settled(&world, MANY_ITERATIONS));
    assert_false(is_settled(&world, 32));
    stick(&world, 0, 1.1e-3);
    assert_false(is_settled(&world, MANY_ITERATIONS));
    arena_destroy(&world.scratch);
}

/* What just meets its bound has settled. */
static void bounds_are_met_by_equals(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    world.rows[1].law.bias = 0x1p-9;
    world.scene.settings.settled_speed = 0x1p-10; /* over four rows */
    world.scene.settings.settled_most = 0x1p-9;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    world.rows[1].law.bias = 0.0;
    stick(&world, 0, 0x1p-9);
    world.rows[0].law.bias = 0x1p-20;
    world.scene.settings.settled_misfit = 0x1p-9;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    arena_destroy(&world.scratch);
}

static void misfits_of_friction_are_bounded(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    stick(&world, 0, 1.9e-3);
    world.scene.settings.settled_speed = 1e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    stick(&world, 0, 2.1e-3);
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.scene.settings.settled_speed = 1.0;
    world.scene.settings.settled_misfit = 2e-3;
    assert_false(is_settled(&world, MANY_ITERATIONS));
    world.scene.settings.settled_misfit = 2.2e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    world.rows[0].solve.is_in_matrix = false; /* rows outside of the matrix have no misfit */
    world.scene.settings.settled_misfit = 2e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS));
    arena_destroy(&world.scratch);
}

/* Slips that cancel each other move no cloth. */
static void cloth_that_slips_as_a_whole_goes_on(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    world.scene.settings.settled_slip = 1e-4;
    stick(&world, 0, 2e-4);
    assert_false(is_settled(&world, MANY_ITERATIONS));
    stick(&world, 1, -2e-4);
    assert_true(is_settled(&world, MANY_ITERATIONS));
    stick(&world, 1, 0.5e-4); /* 1.25e-4 on average, */
    assert_false(is_settled(&world, MANY_ITERATIONS));
    stick(&world, 2, 0.0); /* and 0.83e-4 with a third row */
    assert_true(is_settled(&world, MANY_ITERATIONS));
    arena_destroy(&world.scratch);
}

/* Between cloths a misfit gives a cloth a speed: its mass times settled_drift is allowed, and a
 * hundredth of the momentum that the step gives it. */
static void a_drift_is_bounded(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    world.scene.settings.settled_drift = 1e-5;
    stick(&world, 0, 4.1e-6);
    assert_true(is_settled(&world, MANY_ITERATIONS)); /* on an obstacle */
    lie_on_cloth(&world, true);
    stick(&world, 0, 3.9e-6); /* 3.9e-5 of 4e-5 N s */
    assert_true(is_settled(&world, MANY_ITERATIONS));
    stick(&world, 0, 4.1e-6);
    assert_false(is_settled(&world, MANY_ITERATIONS));
    stick(&world, 1, -4.1e-6);
    assert_true(is_settled(&world, MANY_ITERATIONS));
    /* vertices that gain 0.01 m/s upwards, from rest or from v0 */
    stick(&world, 1, 0.0);
    for (size_t v = 0; v < CLOTH_COUNT; v++) world.u[3 * v + 1] = 0.01;
    world.rows[0].solve.is_in_matrix = false;
    stick(&world, 0, 0.0);
    world.rows[0].solve.slip_penalty = world.rows[1].solve.slip_penalty = 4e-3;
    assert_true(is_settled(&world, MANY_ITERATIONS)); /* misfit 8e-5 of 4e-5 + 4e-4 */
    world.scene.v0 = world.v0;
    for (size_t v = 0; v < CLOTH_COUNT; v++) world.v0[3 * v + 1] = 0.01;
    assert_false(is_settled(&world, MANY_ITERATIONS)); /* of 4e-5 */
    world.v0[1] = world.v0[4] = 0.0;
    assert_true(is_settled(&world, MANY_ITERATIONS)); /* of 4e-5 + 2e-4 */
    world.v0[1] = world.v0[4] = 0.01;
    world.inverse_mass[3] = 0.1;                      /* 13 kg */
    assert_true(is_settled(&world, MANY_ITERATIONS)); /* of 1.3e-4 */
    world.inverse_mass[3] = 1.0;
    world.inverse_mass[2] = 0.0; /* a pin holds the cloth */
    assert_true(is_settled(&world, MANY_ITERATIONS));
    arena_destroy(&world.scratch);
}

static void sums_are_those_of_the_rows(void **state) {
    (void)state;
    round_world world;
    make_world(&world);
    stick(&world, 0, 1e-3);
    stick(&world, 1, 3e-3);
    stick(&world, 2, 5e-3);
    world.rows[1].frame.weights[0] = 0.5;
    world.rows[2].solve.is_in_matrix = false;
    memset(world.sums, 1, sizeof world.sums);
    assert_int_equal(
        end_round(&world.scene, &cheap_effort, &world.list, world.sums, world.u, &world.result),
        TULLE_OK);
    /* the second row sees half of its vertex's slip, and acts on it with half of its force */
    double const momentum = PENALTY * (1e-3 + 0.5 * 1.5e-3);
    assert_true(fabs(world.sums[0].missed.x + momentum) < 1e-15);
    assert_true(vec3_norm2(world.sums[0].misfit) == 0.0);
    assert_true(fabs(world.sums[0].slip.x - momentum) < 1e-15);
    assert_true(world.sums[0].held == 1.5 * PENALTY);
    assert_true(world.sums[0].slip.y == 0.0 && world.sums[0].slip.z == 0.0);
    assert_true(world.sums[1].held == 0.0 && vec3_norm2(world.sums[1].missed) == 0.0);
    arena_destroy(&world.scratch);
    /* cloth in pieces */
    make_world(&world);
    stick(&world, 0, 1e-3);
    world.ranges[0].is_in_pieces = true;
    assert_int_equal(
        end_round(&world.scene, &cheap_effort, &world.list, world.sums, world.u, &world.result),
        TULLE_OK);
    assert_true(vec3_norm2(world.sums[0].missed) == 0.0 && world.sums[0].misfit.x < -0.9e-2);
    arena_destroy(&world.scratch);
    /* on cloth, which gets the opposite */
    make_world(&world);
    stick(&world, 0, 1e-3);
    lie_on_cloth(&world, true);
    assert_int_equal(
        end_round(&world.scene, &cheap_effort, &world.list, world.sums, world.u, &world.result),
        TULLE_OK);
    assert_true(vec3_norm2(world.sums[0].missed) == 0.0 && world.sums[0].misfit.x < -0.9e-2);
    assert_true(fabs(world.sums[0].misfit.x + world.sums[1].misfit.x) < 1e-15);
    arena_destroy(&world.scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cheap_rounds_mend_more),
        cmocka_unit_test(violations_are_bounded),
        cmocka_unit_test(bounds_of_costly_rounds_are_wider),
        cmocka_unit_test(bounds_are_met_by_equals),
        cmocka_unit_test(misfits_of_friction_are_bounded),
        cmocka_unit_test(cloth_that_slips_as_a_whole_goes_on),
        cmocka_unit_test(a_drift_is_bounded),
        cmocka_unit_test(sums_are_those_of_the_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
