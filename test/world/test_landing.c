/* A sheet falls on three spike tips, through the public interface. Where exactly the tips meet the
 * mesh decides how hard the landing is, so several places are tried, and each one counts: no edge
 * stretches by a half, no state intersects, no rescue. A sheet far stiffer than any fabric lands
 * too, and is not thrown about. */
#include "support/small_world.h"
#include "support/test_support.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define STEP (1.0 / 90.0)
static const double STRETCH_MAX = 1.5;  /* of any edge at any step: what a landing may do */
static const double MEAN_MAX = 1.25;    /* of the peaks of all places: landings are no worse */
static const double SETTLED_MAX = 1.05; /* of any edge, when the sheet lies over the tips */
/* Of what the fall gives, what a step may gain at most. Substeps of a quarter of a step are taken
 * whatever they gain, so there are gains: up to a half. A solve that goes astray gives up to a
 * million times as much. */
static const double GAIN_SHARE = 1.0;
enum { PLACES = 5, SPIKES = 3, STEPS = 60, JUDGE_EVERY = 10 };

static void add_spikes(tulle_world *world, int place, tulle_mesh spikes[SPIKES]) {
    static const double feet[SPIKES][2] = {{-0.1, 0.013}, {0.011, -0.03}, {0.12, 0.05}};
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_TETRAHEDRON);
    shape.radius = 0.06;
    shape.height = 0.2;
    for (int i = 0; i < SPIKES; i++) {
        spikes[i] =
            small_shape(shape, feet[i][0] - 0.0023 * place, feet[i][1] - 0.0031 * place, 0.0);
        small_add_obstacle(world, &spikes[i]);
    }
}

/* Peak stretch of one landing. */
static double land(int place) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.5, 21, 0.24);
    tulle_mesh spikes[SPIKES];
    small_add_cloth(world, &sheet);
    add_spikes(world, place, spikes);
    double peak = 0.0;
    tulle_step_report report = {0};
    for (int i = 1; i <= STEPS; i++) {
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        assert_int_equal(report.rescue_impact_zones + report.rescue_component_scalings +
                             report.rescue_global_scalings,
                         0);
        peak = fmax(peak, report.max_stretch);
        if (i % JUDGE_EVERY == 0)
            assert_int_equal(small_judge(world, &sheet, 1, spikes, SPIKES), 0);
    }
    assert_true(report.contacts > 0); /* it did land */
    assert_true(report.max_stretch < SETTLED_MAX);
    for (int i = 0; i < SPIKES; i++) tulle_mesh_destroy(&spikes[i]);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
    return peak;
}

static void sheet_lands_on_tips(void **state) {
    (void)state;
    double mean = 0.0;
    for (int place = 0; place < PLACES; place++) {
        double const peak = land(place);
        print_message("place %d: peak stretch %.3f\n", place, peak);
        assert_true(peak < STRETCH_MAX);
        mean += peak / PLACES;
    }
    assert_true(mean < MEAN_MAX);
}

static double sum_energies(const tulle_step_report *report) {
    return report->kinetic_energy + report->gravity_energy + report->elastic_energy;
}

/* Nothing but gravity moves it, so its energy by the report may only fall. */
static void land_stiff(int place) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.5, 21, 0.24);
    tulle_mesh spikes[SPIKES];
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.warp.stiffness = cloth.material.weft.stiffness = 1e6;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    add_spikes(world, place, spikes);
    double least = (double)INFINITY, least_gravity = (double)INFINITY, first_gravity = 0.0;
    bool has_landed = false;
    for (int i = 0; i < STEPS; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        assert_true(report.cg_converged);
        if (i == 0) first_gravity = report.gravity_energy;
        double const energy = sum_energies(&report);
        double const fall = first_gravity - least_gravity; /* until this step */
        if (i > 1 && energy - least > GAIN_SHARE * fall)
            fail_msg("place %d, step %d: gains %g J of %g", place, i, energy - least, fall);
        least = fmin(least, energy);
        least_gravity = fmin(least_gravity, report.gravity_energy);
        has_landed |= report.contacts > 0;
    }
    assert_true(has_landed);
    assert_int_equal(small_judge(world, &sheet, 1, spikes, SPIKES), 0);
    for (int i = 0; i < SPIKES; i++) tulle_mesh_destroy(&spikes[i]);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

static void stiff_sheet_is_not_thrown_about(void **state) {
    (void)state;
    int const places = getenv("TULLE_TEST_LONG") ? PLACES : 2;
    for (int place = 0; place < places; place++) land_stiff(place);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(sheet_lands_on_tips),
                                       cmocka_unit_test(stiff_sheet_is_not_thrown_about)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
