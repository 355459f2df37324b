/* What friction on obstacles missed, given to cloths as a whole: all of it where nothing holds a
 * cloth along it, the share that penalties leave where rows hold it, nothing to cloth with pins. */
#include "contact/solve/end_round.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

/* Cloth A of 1 kg and 3 kg, cloth B of 2 kg, and an obstacle. */
enum { COUNT = 5, CLOTH_COUNT = 3, ROWS = 2 };
static const double PENALTY = 10.0; /* [kg] */

typedef struct missed_world {
    double inverse_mass[COUNT], u[3 * COUNT];
    uint32_t vertex_surface[COUNT];
    surface_range ranges[3];
    surface_set set;
    contact_scene scene;
    contact_row rows[ROWS];
    row_list list;
    friction_sums sums[3];
} missed_world;

/* Loaded rows of A's vertices on the obstacle, which slide without any friction. */
static void make_world(missed_world *world) {
    static const uint32_t surfaces[COUNT] = {0, 0, 1, 2, 2};
    static const double inverse_mass[COUNT] = {1.0, 1.0 / 3.0, 0.5, 0.0, 0.0};
    memset(world, 0, sizeof *world);
    memcpy(world->vertex_surface, surfaces, sizeof surfaces);
    memcpy(world->inverse_mass, inverse_mass, sizeof inverse_mass);
    world->ranges[0] = (surface_range){.vertex_end = 2, .is_present = true};
    world->ranges[1] = (surface_range){.vertex_begin = 2, .vertex_end = 3, .is_present = true};
    world->ranges[2] = (surface_range){
        .vertex_begin = 3, .vertex_end = COUNT, .is_obstacle = true, .is_present = true};
    world->set = (surface_set){.surfaces = world->ranges, .surface_count = 3};
    world->scene = (contact_scene){.set = &world->set,
                                   .vertex_count = COUNT,
                                   .cloth_vertex_count = CLOTH_COUNT,
                                   .vertex_surface = world->vertex_surface,
                                   .inverse_mass = world->inverse_mass};
    for (uint32_t r = 0; r < ROWS; r++)
        world->rows[r] = (contact_row){.frame = {.normal = {0.0, 0.0, 1.0},
                                                 .vertices = {r, 3, 4, 4},
                                                 .weights = {1.0, -0.5, -0.25, -0.25}},
                                       .solve = {.impulse = {0.0, 0.0, 1.0},
                                                 .is_in_matrix = true,
                                                 .stiffness = PENALTY,
                                                 .slip_penalty = PENALTY}};
    world->list.rows.data = world->rows;
    world->list.rows.count = ROWS;
}

/* The rows of A hold it against slip in all directions, but for `free`. */
static void hold(missed_world *world, vec3 free) {
    for (int r = 0; r < ROWS; r++) {
        world->rows[r].solve.slip_pull = PENALTY;
        world->rows[r].solve.slip_free = free;
    }
}

static void assert_velocity(const missed_world *world, size_t vertex, vec3 expected) {
    vec3 const u = vec3_load(world->u, vertex);
    if (vec3_norm(vec3_sub(u, expected)) > 1e-15)
        fail_msg("vertex %zu: %g %g %g", vertex, u.x, u.y, u.z);
}

static void cloth_that_slides_gets_all(void **state) {
    (void)state;
    missed_world world;
    make_world(&world);
    world.u[1] = 0.5; /* stays what it is */
    world.sums[0].missed = vec3_make(0.4, 0.8, 0.0);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    assert_velocity(&world, 0, vec3_make(0.1, 0.7, 0.0));
    assert_velocity(&world, 1, vec3_make(0.1, 0.2, 0.0));
    for (size_t v = 2; v < COUNT; v++) assert_velocity(&world, v, vec3_make(0.0, 0.0, 0.0));
}

static void rows_answer(void **state) {
    (void)state;
    missed_world world;
    make_world(&world);
    world.sums[0].missed = vec3_make(0.0, 0.0, 0.4); /* against both normals: 4 + 20 kg */
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    assert_velocity(&world, 0, vec3_make(0.0, 0.0, 0.4 / 24.0));

    make_world(&world);
    hold(&world, vec3_make(0.0, 0.0, 0.0));
    world.sums[0].missed = vec3_make(0.4, -0.4, 0.0);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    assert_velocity(&world, 1, vec3_make(0.4 / 24.0, -0.4 / 24.0, 0.0));

    make_world(&world); /* they slide along x */
    hold(&world, vec3_make(1.0, 0.0, 0.0));
    world.sums[0].missed = vec3_make(0.4, 0.4, 0.0);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    assert_velocity(&world, 1, vec3_make(0.1, 0.4 / 24.0, 0.0));

    /* what is not in the matrix, or bears no load, holds nothing */
    world.rows[0].solve.is_in_matrix = false;
    world.rows[1].solve.impulse = vec3_make(0.0, 0.0, 0.0);
    memset(world.u, 0, sizeof world.u);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    assert_velocity(&world, 0, vec3_make(0.1, 0.1, 0.0));
}

/* A row counts with all vertices that a cloth has in it: one of a cloth on itself not at all. */
static void rows_hold_the_cloths_that_they_touch(void **state) {
    (void)state;
    missed_world world;
    make_world(&world);
    hold(&world, vec3_make(0.0, 0.0, 0.0));
    world.rows[0].frame = (row_frame){
        .normal = {0.0, 0.0, 1.0}, .vertices = {0, 1, 1, 1}, .weights = {1.0, -0.5, -0.25, -0.25}};
    world.rows[1].frame = (row_frame){
        .normal = {0.0, 0.0, 1.0}, .vertices = {0, 1, 2, 2}, .weights = {0.75, 0.25, -0.5, -0.5}};
    world.sums[0].missed = world.sums[1].missed = vec3_make(0.0, 0.6, 0.0);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    assert_velocity(&world, 0, vec3_make(0.0, 0.6 / 14.0, 0.0));
    assert_velocity(&world, 2, vec3_make(0.0, 0.6 / 12.0, 0.0));
}

/* Held by ten powers of ten more than its mass on a slope, cloth slides down as if on a plane. */
static void stiff_rows_leave_the_rest_exact(void **state) {
    (void)state;
    missed_world world;
    make_world(&world);
    vec3 const n = vec3_normalize(vec3_make(1.0, 2.0, -0.5));
    vec3 const along = vec3_normalize(vec3_cross(n, vec3_make(0.3, -1.0, 0.7)));
    for (int r = 0; r < ROWS; r++) {
        world.rows[r].frame.normal = n;
        world.rows[r].solve.impulse = n;
        world.rows[r].solve.stiffness = 2e10;
    }
    world.sums[0].missed = vec3_scale(along, 4.0);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    vec3 const gain = vec3_load(world.u, 0);
    assert_true(vec3_norm(vec3_sub(gain, along)) < 1e-5);
    assert_true(fabs(vec3_dot(gain, n)) < 1e-9);
}

static void pins_take_all(void **state) {
    (void)state;
    missed_world world;
    make_world(&world);
    world.inverse_mass[1] = 0.0;
    world.sums[0].missed = vec3_make(0.4, 0.0, 0.0);
    give_missed_friction(&world.scene, &world.list, world.sums, world.u);
    for (size_t v = 0; v < COUNT; v++) assert_velocity(&world, v, vec3_make(0.0, 0.0, 0.0));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_that_slides_gets_all),
        cmocka_unit_test(rows_answer),
        cmocka_unit_test(rows_hold_the_cloths_that_they_touch),
        cmocka_unit_test(stiff_rows_leave_the_rest_exact),
        cmocka_unit_test(pins_take_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
