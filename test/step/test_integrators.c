/* Contact with every integrator: sheets that fall on a sphere and on needles come to rest without
 * intersection, rescue or tearing; a sheet on a slope stays below the critical angle and goes with
 * Coulomb's acceleration above it; what hangs free gains no energy; a collision keeps momentum. */
#include "support/small_world.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

static const char *const NAMES[] = {"implicit Euler", "Crank-Nicolson", "BDF2"};
static const double STEP = 1.0 / 90.0; /* [s] */
static const double GRAVITY = 9.81;
enum { INTEGRATORS = 3, BODIES_MAX = 10 };

/* A sheet, obstacles and what a run of them gave. */
typedef struct fall {
    tulle_world *world;
    tulle_mesh sheets[2], obstacles[BODIES_MAX];
    tulle_cloth_id ids[2];
    size_t sheet_count, obstacle_count;
    double first_energy, energy, least_energy, rise; /* [J]; of all kinds together */
    double kinetic, peak_kinetic, max_stretch;
    uint64_t rescues, contacts;
} fall;

static fall make_fall(int integrator, double slope) {
    fall made = {0};
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.wind.drag_coefficient = 0.0;
    def.integrator = (tulle_integrator)integrator;
    def.gravity[0] = GRAVITY * sin(slope);
    def.gravity[2] = -GRAVITY * cos(slope);
    def.friction_cloth_cloth = 0.0;
    if (slope > 0.0) def.contact_distance = 3e-3;
    assert_int_equal(tulle_world_create(&def, &made.world, NULL), TULLE_OK);
    return made;
}

static void add_sheet(fall *made, tulle_mesh mesh, double speed) {
    tulle_cloth_def def = tulle_cloth_def_default();
    made->sheets[made->sheet_count] = mesh;
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material.friction = 0.5;
    def.material.air_damping = speed != 0.0 ? 0.0 : def.material.air_damping;
    def.velocity[2] = speed;
    assert_int_equal(
        tulle_world_add_cloth(made->world, &def, &made->ids[made->sheet_count++], NULL), TULLE_OK);
}

static void add_obstacle(fall *made, tulle_mesh mesh) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    made->obstacles[made->obstacle_count++] = mesh;
    def.mesh = tulle_mesh_get_view(&mesh);
    def.friction = 0.5;
    assert_int_equal(tulle_world_add_obstacle(made->world, &def, NULL, NULL), TULLE_OK);
}

static void add_ground(fall *made) {
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    plane.size[0] = plane.size[1] = 6.0;
    add_obstacle(made, small_shape(plane, 0.0, 0.0, 0.0));
}

static void run(fall *made, double seconds) {
    long const steps = lround(seconds / STEP);
    for (long i = 0; i < steps; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(made->world, STEP, &report, &error) != TULLE_OK)
            fail_msg("step %ld: %s", i, error.message);
        made->energy = report.kinetic_energy + report.gravity_energy + report.elastic_energy;
        if (report.step == 0) made->first_energy = made->least_energy = made->energy;
        made->rise = fmax(made->rise, made->energy - made->least_energy);
        made->least_energy = fmin(made->least_energy, made->energy);
        made->kinetic = report.kinetic_energy;
        made->peak_kinetic = fmax(made->peak_kinetic, report.kinetic_energy);
        made->max_stretch = fmax(made->max_stretch, report.max_stretch);
        made->contacts += report.contacts;
        made->rescues += report.rescue_impact_zones + report.rescue_component_scalings +
                         report.rescue_global_scalings;
    }
    assert_int_equal(small_judge(made->world, made->sheets, made->sheet_count, made->obstacles,
                                 made->obstacle_count),
                     0);
}

static void end_fall(fall *made) {
    tulle_world_destroy(made->world);
    for (size_t i = 0; i < made->sheet_count; i++) tulle_mesh_destroy(&made->sheets[i]);
    for (size_t i = 0; i < made->obstacle_count; i++) tulle_mesh_destroy(&made->obstacles[i]);
}

/* Mean over a sheet's vertices of a component of positions or velocities. */
static double find_place(const fall *made, size_t sheet, size_t axis) {
    double sum = 0.0;
    const double *const x = tulle_cloth_get_positions(made->world, made->ids[sheet], NULL);
    for (size_t i = 0; i < made->sheets[sheet].vertex_count; i++) sum += x[3 * i + axis];
    return sum / (double)made->sheets[sheet].vertex_count;
}

/* Of the centre of mass: triangles of a sheet weigh the same, a third of it at each corner. */
static double find_speed(const fall *made, size_t sheet, size_t axis) {
    const tulle_mesh *const mesh = &made->sheets[sheet];
    double sum = 0.0;
    const double *const v = tulle_cloth_get_velocities(made->world, made->ids[sheet], NULL);
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) sum += v[3 * mesh->triangles[i] + axis];
    return sum / (3.0 * (double)mesh->triangle_count);
}

static void check_rest(const char *scene, int integrator, const fall *made) {
    print_message("%s, %s: kinetic energy %.2g of its peak, stretch %.3f, rise %.2g of what went\n",
                  scene, NAMES[integrator], made->kinetic / made->peak_kinetic, made->max_stretch,
                  made->rise / (made->first_energy - made->energy));
    assert_true(made->contacts > 1000);
    assert_true(made->rescues == 0);
    /* landings in which the last impulses stretch the cloth show as some per cent */
    assert_true(made->rise < 0.03 * (made->first_energy - made->energy));
    assert_true(made->kinetic < 5e-4 * made->peak_kinetic);
    assert_true(made->max_stretch < 1.5);
}

static void sheets_come_to_rest(void **state) {
    (void)state;
    tulle_shape_def needle = tulle_shape_def_default(TULLE_SHAPE_NEEDLE);
    needle.radius = 0.006;
    needle.height = 0.2;
    needle.tip_height = 0.06;
    tulle_shape_def sphere = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    sphere.radius = 0.2;
    sphere.resolution[0] = 8;
    for (int integrator = 0; integrator < INTEGRATORS; integrator++) {
        fall needles = make_fall(integrator, 0.0);
        add_sheet(&needles, small_sheet(1.0, 17, 0.3), 0.0);
        for (int i = 0; i < 9; i++)
            add_obstacle(&needles, small_shape(needle, 0.25 * (i % 3 - 1) - 0.013,
                                               0.25 * (i / 3 - 1) - 0.007, 0.0));
        add_ground(&needles);
        run(&needles, 2.5);
        check_rest("needles", integrator, &needles);
        end_fall(&needles);
        fall ball = make_fall(integrator, 0.0);
        add_sheet(&ball, small_sheet(0.8, 11, 0.5), 0.0);
        add_obstacle(&ball, small_shape(sphere, -0.013, -0.007, 0.25));
        add_ground(&ball);
        run(&ball, 2.5);
        check_rest("sphere", integrator, &ball);
        end_fall(&ball);
    }
}

static void slopes_stick_and_slip(void **state) {
    (void)state;
    double const degree = acos(-1.0) / 180.0;
    for (int integrator = 0; integrator < INTEGRATORS; integrator++) {
        for (int is_steep = 0; is_steep < 2; is_steep++) {
            double const angle = (is_steep ? 40.0 : 26.0) * degree;
            fall slope = make_fall(integrator, angle);
            add_sheet(&slope, small_sheet(0.3, 9, 3e-3), 1e-300); /* no air damping */
            add_ground(&slope);
            run(&slope, 0.1);
            double const x = find_place(&slope, 0, 0), v = find_speed(&slope, 0, 0);
            run(&slope, 0.5);
            double const way = find_place(&slope, 0, 0) - x, gain = find_speed(&slope, 0, 0) - v;
            double const expected = 0.5 * GRAVITY * (sin(angle) - 0.5 * cos(angle));
            if (is_steep)
                assert_true(fabs(gain / expected - 1.0) < 0.01);
            else
                assert_true(fabs(way) < 1e-9);
            end_fall(&slope);
        }
    }
}

static void collisions_keep_momentum(void **state) {
    (void)state;
    for (int integrator = 0; integrator < INTEGRATORS; integrator++) {
        fall flight = make_fall(integrator, 0.0);
        add_sheet(&flight, small_sheet(0.4, 11, 0.0), 1.0);
        add_sheet(&flight, small_sheet(0.4, 11, 0.06), -2.0); /* the same masses */
        run(&flight, STEP);
        long const steps = 20;
        double const before = find_speed(&flight, 0, 2) + find_speed(&flight, 1, 2);
        run(&flight, (double)steps * STEP);
        double const after = find_speed(&flight, 0, 2) + find_speed(&flight, 1, 2);
        assert_true(flight.contacts > 50);
        double const error = after - before + 2.0 * GRAVITY * (double)steps * STEP;
        print_message("%s: velocity missed after a collision %.2g m/s\n", NAMES[integrator], error);
        assert_true(fabs(error) < 1e-11);
        end_fall(&flight);
    }
}

/* What wakes in the step after it fell asleep begins from rest, by BDF2 too, which knows the step
 * before. */
static void a_sleeper_has_no_history(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.integrator = TULLE_INTEGRATOR_BDF2;
    def.sleep_speed = 1e-3;
    def.sleep_time = 0.5;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.3, 13, 0.01);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    tulle_mesh table = small_shape(shape, 0.0, 0.0, -0.5 * shape.size[2]);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    small_add_obstacle(world, &table);
    for (int i = 0; i == 0 || !tulle_cloth_is_asleep(world, cloth); i++) {
        assert_true(i < 1600);
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    }
    double *vectors[STATE_VECTORS_MAX];
    assert_int_equal(step_list_vectors(&world->now, vectors), STATE_VECTORS_MAX);
    for (int i = 1; i < STATE_VECTORS_MAX; i++)
        for (size_t k = 0; k < 3 * sheet.vertex_count; k++) assert_true(vectors[i][k] == 0.0);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&table);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sheets_come_to_rest), cmocka_unit_test(slopes_stick_and_slip),
        cmocka_unit_test(collisions_keep_momentum), cmocka_unit_test(a_sleeper_has_no_history)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
