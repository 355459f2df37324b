/* Energy of bodies in contact: what stands, hangs or swings gains none. */
#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What steps added to the energy and what they took [J]. */
typedef struct balance {
    double last, gained, lost;
    uint64_t contacts, rescues, solves;
} balance;

static void add_step(const tulle_step_report *report, balance *sum) {
    double const energy = report->kinetic_energy + report->gravity_energy + report->elastic_energy;
    if (report->step > 0) {
        sum->gained += fmax(energy - sum->last, 0.0);
        sum->lost += fmax(sum->last - energy, 0.0);
    }
    sum->last = energy;
    sum->contacts += report->contacts;
    sum->solves += report->solve_count;
    sum->rescues += report->rescue_component_scalings + report->rescue_global_scalings +
                    report->rescue_impact_zones;
}

static tulle_mesh make_ring(const double at[3], int is_turned) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_TORUS);
    def.radius = 0.05;
    def.inner_radius = 0.006;
    def.resolution[0] = 16;
    def.resolution[1] = 6;
    tulle_mesh ring = small_shape(def, 0.0, 0.0, 0.0);
    for (size_t i = 0; i < ring.vertex_count; i++) {
        double *const p = ring.positions + 3 * i; /* upright in the x-z or the y-z plane */
        double const x = p[0], y = p[1], z = p[2];
        p[0] = (is_turned ? z : x) + at[0];
        p[1] = (is_turned ? x : -z) + at[1];
        p[2] = y + at[2];
    }
    return ring;
}

/* Six rings hang from a seventh, slack and aslant; they fall taut and swing. Their contacts lie
 * inside the contact distance most of the time, and what makes room there lifts the rest. */
static void a_chain_gains_nothing(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = 0.002;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_body const body = {.is_dynamic = 1, .density = 7800.0};
    for (int i = 0; i < 7; i++) {
        double const at[3] = {0.012 * i, 0.0, -0.082 * i};
        tulle_mesh ring = make_ring(at, i % 2);
        bodies_add_obstacle(world, &ring, 0.3, i > 0 ? &body : NULL);
        tulle_mesh_destroy(&ring);
    }
    balance sum = {0};
    for (int i = 0; i < 270; i++) {
        tulle_step_report const report = bodies_step(world);
        add_step(&report, &sum);
    }
    print_message("chain: gained %.2g J, lost %.3g J, %llu contacts, %llu rescues, %.1f solves a "
                  "step\n",
                  sum.gained, sum.lost, (unsigned long long)sum.contacts,
                  (unsigned long long)sum.rescues, (double)sum.solves / 270.0);
    assert_true(sum.lost > 0.1);
    assert_true(sum.gained <= 1e-6 * sum.lost);
    assert_true(1000 * sum.rescues <= sum.contacts);
    tulle_world_destroy(world);
}

/* Boxes that stand nearer than the contact distance stay where they are. */
static void boxes_too_near_do_not_rise(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = 0.005;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh ground = bodies_make_box(1.0, 1.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_body const body = {.is_dynamic = 1, .density = 500.0};
    bodies_add_obstacle(world, &ground, 0.5, NULL);
    tulle_obstacle_id ids[3];
    for (int i = 0; i < 3; i++) {
        tulle_mesh box = bodies_make_box(0.2, 0.2, 0.1, (double[3]){0.0, 0.0, 0.051 + 0.101 * i});
        ids[i] = bodies_add_obstacle(world, &box, 0.5, &body);
        tulle_mesh_destroy(&box);
    }
    balance sum = {0};
    for (int i = 0; i < 90; i++) {
        tulle_step_report const report = bodies_step(world);
        add_step(&report, &sum);
    }
    double way = 0.0;
    for (int i = 0; i < 3; i++)
        way = fmax(way, fabs(bodies_get_transform(world, ids[i]).position[2] - 0.051 - 0.101 * i));
    print_message("boxes: gained %.2g J, way %.2g m, %.1f solves a step\n", sum.gained, way,
                  (double)sum.solves / 90.0);
    assert_true(sum.gained < 1e-9);
    assert_true(way < 1e-6);
    tulle_mesh_destroy(&ground);
    tulle_world_destroy(world);
}

/* A stack of three boxes on a sheet that is held at its corners, all as a scene has it by its
 * defaults: denim by its preset, and no damping of bodies. Nothing but the little damping of the
 * cloth, friction and the integrator's own take energy from the sheet's swing; then the stack
 * stays. */
static void an_undamped_stack_swings_out(void **state) {
    (void)state;
    int const is_long = getenv("TULLE_TEST_LONG") != NULL;
    int const steps = (is_long ? 38 : 8) * 90, rest = 8 * 90;
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(0.8, 13, 0.0);
    uint32_t const corners[4] = {0, 12, 156, 168};
    tulle_pin const pin = make_pin(corners, 4, INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    assert_int_equal(tulle_material_preset("denim", &cloth.material), TULLE_OK);
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_obstacle_id ids[3];
    for (int i = 0; i < 3; i++) {
        tulle_mesh box = bodies_make_box(0.2, 0.2, 0.1, (double[3]){0.0, 0.0, 0.06 + 0.106 * i});
        ids[i] = bodies_add_obstacle(world, &box, 0.5, &(tulle_body){.is_dynamic = 1, .mass = 0.1});
        tulle_mesh_destroy(&box);
    }
    tulle_transform before[3] = {{.mass = 0.0}};
    balance sum = {0};
    double creep = 0.0, at_two = 0.0, last = 0.0;
    for (int i = 1; i <= steps; i++) {
        tulle_step_report const report = bodies_step(world);
        add_step(&report, &sum);
        double fastest = 0.0;
        for (int b = 0; b < 3; b++) {
            tulle_transform const now = bodies_get_transform(world, ids[b]);
            if (i <= rest) before[b] = now;
            for (int k = 0; k < 3; k++) {
                creep = fmax(creep, fabs(now.position[k] - before[b].position[k]));
                fastest = fmax(fastest, fabs(now.velocity[k]));
            }
        }
        if (i > 90 && i <= 2 * 90) at_two = fmax(at_two, fastest);
        if (i > 7 * 90 && i <= 8 * 90) last = fmax(last, fastest);
        if (i % 450 == 0) print_message("%d s: %.2g m/s\n", i / 90, fastest);
    }
    double const rate = log(at_two / last) / 6.0;
    print_message("stack: dies out by %.2f 1/s, gained %.2g J, lost %.3g J, creeps by %.2g m, %d "
                  "rescues\n",
                  rate, sum.gained, sum.lost, creep, (int)sum.rescues);
    assert_true(rate > 0.4);
    assert_true(sum.gained < 1e-3 * sum.lost);
    assert_int_equal(sum.rescues, 0);
    assert_true(creep < 1e-5);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_chain_gains_nothing),
        cmocka_unit_test(boxes_too_near_do_not_rise),
        cmocka_unit_test(an_undamped_stack_swings_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
