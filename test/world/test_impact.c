/* Impact with restitution through the public interface: a sheet dropped flat on a plane, two sheets
 * in free flight, and laws set for pairs. */
#include "support/paper_options.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEP (1.0 / 90.0)

/* A square sheet in the plane z = height, its lower corner at (x, y). */
typedef struct sheet {
    double x, y, side, height;
    size_t cells;
} sheet;

static tulle_mesh make_sheet(const sheet *s) {
    tulle_mesh mesh = {0};
    size_t const row = s->cells + 1;
    mesh.vertex_count = row * row;
    mesh.triangle_count = 2 * s->cells * s->cells;
    mesh.positions = malloc(3 * mesh.vertex_count * sizeof(double));
    mesh.triangles = malloc(3 * mesh.triangle_count * sizeof(uint32_t));
    assert_true(mesh.positions && mesh.triangles);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        mesh.positions[3 * i] = s->x + s->side * (double)(i % row) / (double)s->cells;
        mesh.positions[3 * i + 1] = s->y + s->side * (double)(i / row) / (double)s->cells;
        mesh.positions[3 * i + 2] = s->height;
    }
    for (size_t c = 0; c < s->cells * s->cells; c++) {
        uint32_t const a = (uint32_t)(c / s->cells * row + c % s->cells), b = a + (uint32_t)row;
        uint32_t const corners[6] = {a, a + 1, b, a + 1, b + 1, b};
        for (int k = 0; k < 6; k++) mesh.triangles[6 * c + (size_t)k] = corners[k];
    }
    return mesh;
}

static void free_sheet(tulle_mesh *mesh) {
    free(mesh->positions);
    free(mesh->triangles);
}

static tulle_cloth_id add_sheet(tulle_world *world, const sheet *s, const double velocity[3],
                                double restitution) {
    tulle_error error = {0};
    tulle_mesh mesh = make_sheet(s);
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_cloth_id id;
    def.mesh =
        (tulle_mesh_view){mesh.positions, mesh.vertex_count, mesh.triangles, mesh.triangle_count};
    def.material.restitution = restitution;
    def.material.air_damping = 0.0;
    for (int k = 0; k < 3; k++) def.velocity[k] = velocity[k];
    if (tulle_world_add_cloth(world, &def, &id, &error) != TULLE_OK) fail_msg("%s", error.message);
    free_sheet(&mesh);
    return id;
}

static tulle_obstacle_id add_floor(tulle_world *world, double restitution) {
    tulle_error error = {0};
    sheet const floor = {-1.0, -1.03, 2.0, 0.0, 7};
    tulle_mesh mesh = make_sheet(&floor);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_obstacle_id id;
    def.mesh =
        (tulle_mesh_view){mesh.positions, mesh.vertex_count, mesh.triangles, mesh.triangle_count};
    def.restitution = restitution;
    if (tulle_world_add_obstacle(world, &def, &id, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    free_sheet(&mesh);
    return id;
}

static tulle_world *make_world(double gravity, double friction) {
    tulle_world_def def = tulle_world_def_default();
    tulle_world *world;
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.wind.drag_coefficient = 0.0;
    def.gravity[2] = -gravity;
    def.friction_cloth_cloth = friction;
    def.contact_distance = 3e-3;
    def.threads = 1;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

static tulle_step_report take_step_of(tulle_world *world, double time_step) {
    tulle_error error = {0};
    tulle_step_report report = {0};
    if (tulle_world_step(world, time_step, &report, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return report;
}

static tulle_step_report take_step(tulle_world *world) { return take_step_of(world, STEP); }

static double mean_speed_up(const tulle_world *world, tulle_cloth_id id) {
    size_t count;
    const double *const v = tulle_cloth_get_velocities(world, id, &count);
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += v[3 * i + 2];
    return sum / (double)count;
}

/* Speed after the first bounce of a sheet that starts at a height over the floor with a speed. */
static double bounce(double gravity, double restitution, const tulle_contact_law *law) {
    tulle_world *const world = make_world(gravity, 0.3);
    sheet const s = {-0.3, -0.3, 0.6, gravity > 0.0 ? 0.7 : 0.1, 12};
    double const velocity[3] = {0.0, 0.0, gravity > 0.0 ? 0.0 : -2.0};
    tulle_cloth_id const id = add_sheet(world, &s, velocity, restitution);
    tulle_obstacle_id const floor = add_floor(world, restitution);
    if (law) assert_int_equal(tulle_world_set_cloth_obstacle_law(world, id, floor, law, NULL), 0);
    double before = 0.0, after = 0.0, energy = INFINITY;
    for (int i = 0; i < 90; i++) {
        tulle_step_report const report = take_step(world);
        double const now = report.kinetic_energy + report.gravity_energy + report.elastic_energy;
        assert_true(now <= energy + 1e-9);
        energy = now;
        assert_int_equal(report.rescue_component_scalings + report.rescue_impact_zones, 0);
        if (report.stick_contacts + report.slip_contacts == 0 && mean_speed_up(world, id) < 0.0)
            before = mean_speed_up(world, id);
        if (before < 0.0 && after == 0.0 && report.stick_contacts + report.slip_contacts > 0) {
            after = mean_speed_up(world, id);
            take_step(world); /* an impact that does not rebound may take a second step */
            after = fmax(after, mean_speed_up(world, id));
            break;
        }
    }
    double const impact = gravity > 0.0 ? -sqrt(2.0 * gravity * (0.7 - 3e-3)) : -2.0;
    print_message("gravity %.2f, k %.2f: %.5g m/s before, %.5g expected, %.5g after: ratio %.5g\n",
                  gravity, restitution, before, impact, after, -after / impact);
    tulle_world_destroy(world);
    return -after / impact;
}

static void a_flat_sheet_rebounds_as_the_law_says(void **state) {
    (void)state;
    double const restitutions[] = {0.0, 0.5, 1.0};
    for (int i = 0; i < 3; i++) {
        double const k = restitutions[i];
        assert_true(fabs(bounce(0.0, k, NULL) - k) < 1e-6 + 1e-3 * k);
        assert_true(fabs(bounce(9.81, k, NULL) - k) < 0.02);
    }
}

static void a_pair_has_its_own_law(void **state) {
    (void)state;
    tulle_contact_law const law = {0.4, -1.0, 0.8};
    assert_true(fabs(bounce(0.0, 0.0, &law) - 0.8) < 1e-3);
    tulle_world *const world = make_world(0.0, 0.3);
    double const still[3] = {0.0};
    sheet const a = {0.0, 0.0, 0.1, 0.1, 2}, b = {0.0, 0.0, 0.1, 0.2, 2};
    tulle_cloth_id const first = add_sheet(world, &a, still, 0.0);
    tulle_cloth_id const second = add_sheet(world, &b, still, 0.0);
    tulle_obstacle_id const none = {0, 1};
    tulle_error error = {0};
    tulle_contact_law const bad[] = {
        {-0.1, -1.0, 0.0}, {0.4, 0.5, 0.0}, {0.4, 0.4, 1.1}, {NAN, 0.0, 0.0}, {0.4, NAN, 0.0}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(tulle_world_set_cloth_cloth_law(world, first, second, &bad[i], &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, first, first, &law, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_cloth_obstacle_law(world, first, none, &law, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, first, second, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, second, first, &law, &error), TULLE_OK);
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, first, second, &law, &error), TULLE_OK);
    take_step(world);
    /* while the world runs, too: bad ones change nothing, the same one neither, another one does */
    uint64_t const hash = tulle_world_get_state_hash(world);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(tulle_world_set_cloth_cloth_law(world, first, second, &bad[i], &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, second, first, &law, &error), TULLE_OK);
    assert_true(tulle_world_get_state_hash(world) == hash);
    tulle_contact_law const other = {0.3, -1.0, 0.8};
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, first, second, &other, &error),
                     TULLE_OK);
    assert_true(tulle_world_get_state_hash(world) != hash);
    tulle_world_destroy(world);
}

/* All vertices of a sheet have nearly the same mass share: momenta by masses from the area. */
typedef struct momenta {
    double linear[3], angular[3];
} momenta;

static void add_momenta(const tulle_world *world, tulle_cloth_id id, const double *masses,
                        momenta *sum) {
    size_t count;
    const double *const x = tulle_cloth_get_positions(world, id, &count);
    const double *const v = tulle_cloth_get_velocities(world, id, &count);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            int const l = (k + 1) % 3, m = (k + 2) % 3;
            sum->linear[k] += masses[i] * v[3 * i + (size_t)k];
            sum->angular[k] += masses[i] * (x[3 * i + (size_t)l] * v[3 * i + (size_t)m] -
                                            x[3 * i + (size_t)m] * v[3 * i + (size_t)l]);
        }
}

/* A third of the area around each vertex, as the model has it. */
static double *make_masses(const sheet *s) {
    tulle_mesh mesh = make_sheet(s);
    double *const masses = calloc(mesh.vertex_count, sizeof(double));
    assert_non_null(masses);
    double const cell = s->side / (double)s->cells;
    for (size_t t = 0; t < 3 * mesh.triangle_count; t++)
        masses[mesh.triangles[t]] += cell * cell / 6.0;
    free_sheet(&mesh);
    return masses;
}

typedef struct collision {
    double restitution, friction;
    sheet high;
    double energy_growth; /* the largest, of the first energy: linearised springs gain some */
} collision;

static void collide(const collision *c) {
    tulle_world *const world = make_world(0.0, c->friction);
    sheet const low = {-0.3, -0.3, 0.6, 0.0, 12};
    double const up[3] = {0.0, 0.0, 0.5}, down[3] = {0.4, 0.0, -1.0};
    tulle_cloth_id const a = add_sheet(world, &low, up, c->restitution);
    tulle_cloth_id const b = add_sheet(world, &c->high, down, c->restitution);
    double *const mass_a = make_masses(&low), *const mass_b = make_masses(&c->high);
    momenta start = {0};
    double energy = 0.0, first_energy = 0.0, growth = 0.0, linear = 0.0, angular = 0.0;
    uint64_t contacts = 0, rescues = 0;
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    add_momenta(world, a, mass_a, &start);
    add_momenta(world, b, mass_b, &start);
    for (int i = 0; i < 60; i++) {
        tulle_step_report const report = take_step_of(world, 1.0 / 900.0);
        double const now = report.kinetic_energy + report.elastic_energy;
        if (i == 0) first_energy = now;
        if (i > 0) growth = fmax(growth, (now - energy) / first_energy);
        energy = now;
        contacts += report.stick_contacts + report.slip_contacts;
        rescues += report.rescue_impact_zones + report.rescue_component_scalings;
        momenta sum = {0};
        add_momenta(world, a, mass_a, &sum);
        add_momenta(world, b, mass_b, &sum);
        for (int k = 0; k < 3; k++) {
            linear = fmax(linear, fabs(sum.linear[k] - start.linear[k]));
            angular = fmax(angular, fabs(sum.angular[k] - start.angular[k]));
        }
    }
    print_message("k %.1f friction %.1f: contacts %llu, rescues %llu, energy %.5g of %.5g, growth "
                  "%.3g, speeds %.4g %.4g, linear momentum off by %.3g, angular by %.3g\n",
                  c->restitution, c->friction, (unsigned long long)contacts,
                  (unsigned long long)rescues, energy, first_energy, growth,
                  mean_speed_up(world, a), mean_speed_up(world, b), linear, angular);
    assert_true(contacts > 0 && rescues == 0);
    assert_true(linear < 1e-14);
    assert_true(growth <= c->energy_growth);
    free(mass_a);
    free(mass_b);
    tulle_world_destroy(world);
}

static void sheets_collide_in_free_flight(void **state) {
    (void)state;
    sheet const aligned = {-0.3, -0.3, 0.6, 0.02, 12}, apart = {-0.22, -0.17, 0.4, 0.02, 9};
    collision const cases[] = {{0.0, 0.0, aligned, 1e-5}, {0.5, 0.0, aligned, 1e-5},
                               {1.0, 0.0, aligned, 1e-5}, {0.5, 0.5, aligned, 1e-5},
                               {1.0, 0.5, aligned, 1e-5}, {0.0, 0.3, apart, 1e-3},
                               {0.5, 0.3, apart, 1e-3},   {1.0, 0.3, apart, 1e-3}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) collide(&cases[i]);
}

static void a_grain_without_direction_is_refused(void **state) {
    (void)state;
    tulle_error error = {0};
    tulle_world_def const world_def = tulle_world_def_default();
    tulle_world *world;
    double positions[9] = {0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0};
    uint32_t triangle[3] = {0, 1, 2};
    assert_int_equal(tulle_world_create(&world_def, &world, &error), TULLE_OK);
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_cloth_id id;
    def.mesh = (tulle_mesh_view){positions, 3, triangle, 1};
    double const grains[][3] = {{0.0, 0.0, 0.0},  {1e-200, 0.0, 0.0}, {0.0, 0.0, 2.0},
                                {1e-8, 0.0, 1.0}, {1e-9, 0.0, 0.0},   {1e-5, 0.0, 1.0}};
    for (int i = 0; i < 6; i++) {
        memcpy(def.grain, grains[i], sizeof def.grain);
        def.material.friction_across = 0.5;
        int const is_refused = tulle_world_add_cloth(world, &def, &id, &error) != TULLE_OK;
        assert_int_equal(is_refused, i < 4);
        if (is_refused) assert_non_null(strstr(error.message, "grain"));
        def.material.friction_across = 1.0;
        assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_OK);
    }
    tulle_world_destroy(world);
}

/* Messages name what is wrong as the user wrote it. */
static void values_out_of_range_are_named(void **state) {
    (void)state;
    tulle_error error = {0};
    tulle_world *world;
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->motion_space = (tulle_motion_space)-1;
    assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "motion_space is -1; "));
    def = tulle_world_def_default();
    def.dynamic_friction_cloth_cloth = 0.5;
    assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "dynamic_friction_cloth_cloth is 0.5; dynamic "
                                          "friction may not exceed static friction, 0.3"));
    def.dynamic_friction_cloth_cloth = -50.0; /* any negative one is the same as the static */
    assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_OK);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flat_sheet_rebounds_as_the_law_says),
        cmocka_unit_test(a_pair_has_its_own_law),
        cmocka_unit_test(a_grain_without_direction_is_refused),
        cmocka_unit_test(values_out_of_range_are_named),
        cmocka_unit_test(sheets_collide_in_free_flight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
