/* Sheets that slide down a slope: as fast as Coulomb's law says, however stiff they are; and cloth
 * in two pieces of which one slides. */
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STEP (1.0 / 90.0)
static const double PI = 3.14159265358979323846;
static const double ANGLE = 25.0, FRICTION = 0.3, GRAVITY = 9.81; /* [deg], -, [m/s^2] */
static const double HEIGHT = 4e-3;                                /* [m] of sheets at the start */

/* In the system of the slope, which is turned about y. */
static void turn(tulle_mesh *mesh) {
    double const c = cos(ANGLE * PI / 180.0), s = sin(ANGLE * PI / 180.0);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const along = x[0], up = x[2];
        x[0] = c * along + s * up;
        x[2] = c * up - s * along;
    }
}

static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.wind.drag_coefficient = 0.0;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

static void add_ground(tulle_world *world, tulle_mesh *ground) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = 8.0;
    shape.size[2] = 0.2;
    *ground = small_shape(shape, 0.0, 0.0, -0.1);
    turn(ground);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(ground);
    obstacle.friction = obstacle.dynamic_friction = FRICTION;
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), TULLE_OK);
}

static tulle_cloth_id add_cloth(tulle_world *world, const tulle_mesh *sheet, double stiffness) {
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(sheet);
    cloth.material.air_damping = 0.0;
    cloth.material.friction = cloth.material.dynamic_friction = FRICTION;
    if (stiffness > 0.0) cloth.material.warp.stiffness = cloth.material.weft.stiffness = stiffness;
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, &id, NULL), TULLE_OK);
    return id;
}

/* Mean velocity of vertices begin to end - 1. */
static void find_velocity(const tulle_world *world, tulle_cloth_id cloth, size_t begin, size_t end,
                          double velocity[3]) {
    const double *const v = tulle_cloth_get_velocities(world, cloth, NULL);
    memset(velocity, 0, 3 * sizeof *velocity);
    for (size_t i = 3 * begin; i < 3 * end; i++) velocity[i % 3] += v[i] / (double)(end - begin);
}

static void take_steps(tulle_world *world, int count) {
    for (int i = 0; i < count; i++) {
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, NULL, &error) != TULLE_OK) fail_msg("%s", error.message);
    }
}

/* Penalties of rows on cloth of 1e6 N/m are 1e8 times its mass, so errors of solves that end late
 * could bring it to a halt. */
static void stiff_sheets_slide(void **state) {
    (void)state;
    static const double stiffnesses[] = {0.0, 9e5, 1e6, 1.5e6, 3e6}; /* 0: of the preset */
    double const angle = ANGLE * PI / 180.0;
    double const acceleration = GRAVITY * (sin(angle) - FRICTION * cos(angle));
    for (int i = 0; i < 5; i++) {
        tulle_world *const world = make_world();
        tulle_mesh sheet = small_sheet(0.4, 41, HEIGHT), ground;
        turn(&sheet);
        tulle_cloth_id const cloth = add_cloth(world, &sheet, stiffnesses[i]);
        add_ground(world, &ground);
        double before[3], after[3];
        take_steps(world, 12);
        find_velocity(world, cloth, 0, sheet.vertex_count, before);
        take_steps(world, 24);
        find_velocity(world, cloth, 0, sheet.vertex_count, after);
        double const found = (after[0] - before[0]) / (24 * STEP * cos(angle));
        print_message("%g N/m: %.4f m/s^2 of %.4f\n", stiffnesses[i], found, acceleration);
        /* within 1e-4; in single precision up to 4.5 % off at 3e6, or uphill */
        assert_true(fabs(found - acceleration) < 0.002 * acceleration);
        tulle_world_destroy(world);
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&ground);
    }
}

/* One cloth of two sheets: one slides, the other falls beside it. What friction misses of the one
 * is nothing to the other. */
static void pieces_do_not_share_friction(void **state) {
    (void)state;
    tulle_world *const world = make_world();
    tulle_mesh first = small_sheet(0.4, 25, 0.03), second = small_sheet(0.4, 25, 0.5), ground;
    size_t const count = first.vertex_count, triangles = first.triangle_count;
    tulle_mesh both = {.vertex_count = 2 * count, .triangle_count = 2 * triangles};
    both.positions = malloc(6 * count * sizeof(double));
    both.triangles = malloc(6 * triangles * sizeof(uint32_t));
    assert_true(both.positions && both.triangles);
    memcpy(both.positions, first.positions, 3 * count * sizeof(double));
    memcpy(both.positions + 3 * count, second.positions, 3 * count * sizeof(double));
    for (size_t i = 0; i < 3 * triangles; i++) {
        both.triangles[i] = first.triangles[i];
        both.triangles[3 * triangles + i] = second.triangles[i] + (uint32_t)count;
    }
    for (size_t v = count; v < 2 * count; v++) both.positions[3 * v + 1] += 1.0;
    turn(&both);
    turn(&second);
    tulle_cloth_id const cloth = add_cloth(world, &both, 0.0);
    add_ground(world, &ground);
    tulle_world *const other = make_world(); /* a sheet that falls alone */
    tulle_cloth_id const alone = add_cloth(other, &second, 0.0);
    take_steps(world, 24);
    take_steps(other, 24);
    double velocity[3], expected[3];
    find_velocity(world, cloth, count, 2 * count, velocity);
    find_velocity(other, alone, 0, count, expected);
    print_message("falls with %.6f and %.6f m/s, alone with %.6f\n", velocity[0], velocity[1],
                  expected[0]);
    /* rounds leave 1.2e-4; friction that is shared, 6.8e-4 */
    assert_true(fabs(velocity[0] - expected[0]) < 3e-4 && fabs(velocity[1]) < 3e-4);
    tulle_world_destroy(other);
    free(both.positions);
    free(both.triangles);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&first);
    tulle_mesh_destroy(&second);
    tulle_mesh_destroy(&ground);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stiff_sheets_slide),
        cmocka_unit_test(pieces_do_not_share_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
