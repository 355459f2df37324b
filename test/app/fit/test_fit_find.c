/* What `tulle fit` finds: bending against the elastica, simulated drape coefficients of known
 * fabrics found again, measures that contradict each other, material files that load. */
#define _POSIX_C_SOURCE 200809L
#include "app/fit/fit.h"
#include "scene/scene.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static const fit_measures nothing_measured = {.drape = (double)NAN,
                                              .drape_error = 1.0,
                                              .lengths = {(double)NAN, (double)NAN},
                                              .length_error = 0.5e-3,
                                              .density = (double)NAN,
                                              .shear = (double)NAN};
/* Coarse, for time: what is found again is what these meshes have, not what the fabric has. */
static const fit_method coarse = {
    .cell = 15e-3, .samples = 2, .pattern = DRAPE_IRREGULAR_RINGS, .threads = 2};

static tulle_material take_fabric(const char *name) {
    tulle_material material;
    assert_int_equal(tulle_material_preset(name, &material), TULLE_OK);
    return material;
}

static fit_found find(const char *fabric, const fit_measures *measures, const fit_method *method) {
    tulle_material const start = take_fabric(fabric);
    fit_found found;
    tulle_error error = {0};
    assert_int_equal(fit_find(&start, measures, method, &found, &error), TULLE_OK);
    assert_true(found.tests <= fit_count_tests(measures, method));
    return found;
}

/* ---- bending ---- */

/* Slope at the tip of a strip of unit length that starts level with curvature `curvature` and
 * carries `weight` = w g L^3 / B: B theta'' = w g (1 - s) cos theta, by the midpoint rule; *chord
 * is the angle of the line from clamp to tip. Returns the curvature at the tip, where no moment
 * acts. */
static double hang_strip(double weight, double curvature, double *chord) {
    enum { STEPS = 20000 };
    double const h = 1.0 / STEPS;
    double angle = 0.0, x = 0.0, y = 0.0;
    for (int i = 0; i < STEPS; i++) {
        double const s = (i + 0.5) * h, middle = angle + 0.5 * h * curvature;
        double const middle_curvature = curvature - 0.5 * h * weight * (1.0 - i * h) * cos(angle);
        x += h * cos(middle), y += h * sin(middle);
        curvature -= h * weight * (1.0 - s) * cos(middle);
        angle += h * middle_curvature;
    }
    *chord = atan2(y, x);
    return curvature;
}

/* A strip of the rigidity that is found for a bending length hangs by 41.5 degrees over twice that
 * length: the definition of the length, within what the elastica leaves of it. */
static void rigidity_is_that_of_the_cantilever(void **state) {
    (void)state;
    static const double lengths[] = {8e-3, 19e-3, 45e-3}, densities[] = {0.04, 0.15, 0.9};
    for (size_t i = 0; i < 3; i++) {
        double const rigidity = fit_compute_rigidity(lengths[i], densities[i]);
        double const weight = densities[i] * 9.81 * pow(2.0 * lengths[i], 3.0) / rigidity;
        double low = 0.0, high = weight, chord = 0.0; /* of the curvature at the clamp */
        for (int k = 0; k < 60; k++) {
            double const middle = 0.5 * (low + high);
            if (hang_strip(weight, middle, &chord) > 0.0)
                high = middle;
            else
                low = middle;
        }
        assert_true(fabs(chord * 180.0 / 3.14159265358979323846 - 41.5) < 1.0);
        assert_true(fabs(fit_compute_bending_length(rigidity, densities[i]) / lengths[i] - 1.0) <
                    1e-12);
    }
}

static void bending_lengths_alone_need_no_simulation(void **state) {
    (void)state;
    fit_measures measures = nothing_measured;
    measures.lengths[0] = 24e-3, measures.lengths[1] = 18e-3;
    measures.density = 0.2;
    fit_found const both = find("cotton-broadcloth", &measures, &coarse);
    tulle_material const start = take_fabric("cotton-broadcloth");
    assert_int_equal(both.tests, 0);
    assert_true(fabs(both.material.bend_warp - 0.2 * 9.81 * 1.3824e-5) < 1e-12);
    assert_true(fabs(both.material.bend_weft - 0.2 * 9.81 * 5.832e-6) < 1e-12);
    assert_true(fabs(both.bend_error - 3.0 * 0.5 / 18.0) < 1e-12);
    /* Loops keep their width over the rigidity; what was not measured is the start's. */
    assert_true(fabs(both.material.bend_hysteresis_warp / both.material.bend_warp -
                     start.bend_hysteresis_warp / start.bend_warp) < 1e-9);
    assert_true(start.bend_hysteresis_warp > 0.0);
    assert_true(fabs(both.material.shear.stiffness - start.shear.stiffness) < 1e-12);

    measures.lengths[0] = (double)NAN;
    fit_found const one = find("cotton-broadcloth", &measures, &coarse);
    assert_true(fabs(one.material.bend_warp / one.material.bend_weft -
                     start.bend_warp / start.bend_weft) < 1e-12);
    assert_true(fabs(one.material.bend_weft - both.material.bend_weft) < 1e-15);
}

/* ---- drape ---- */

/* Mean drape coefficient of a material that nobody told the search about, on other meshes and with
 * other starts. */
static double simulate_drape(const tulle_material *material, drape_pattern pattern, double cell) {
    enum { SAMPLES = 3 };
    drape_test tests[SAMPLES];
    double mean = 0.0;
    tulle_error error = {0};
    for (uint32_t i = 0; i < SAMPLES; i++)
        tests[i] =
            (drape_test){.material = *material, .pattern = pattern, .cell = cell, .seed = 101 + i};
    assert_int_equal(drape_test_run(tests, SAMPLES, 2, &error), TULLE_OK);
    for (size_t i = 0; i < SAMPLES; i++) mean += tests[i].coefficient / SAMPLES;
    return mean;
}

static void bending_is_found_again(void **state) {
    (void)state;
    tulle_material hidden = take_fabric("cotton");
    hidden.bend_warp *= 1.6, hidden.bend_weft *= 1.6, hidden.bend_twist *= 1.6;
    fit_measures measures = nothing_measured;
    measures.drape = simulate_drape(&hidden, DRAPE_RINGS, coarse.cell);
    fit_found const found = find("cotton", &measures, &coarse);
    assert_int_equal(found.unknown, FIT_BENDING);
    assert_int_equal(found.search.verdict, SEARCH_FOUND);
    assert_true(found.search.low < hidden.bend_warp && found.search.high > hidden.bend_warp);
    assert_true(found.search.high < 2.5 * found.search.low); /* and says so with some precision */
    assert_true(found.search.slope > 5.0);
}

static void threads_do_not_change_a_bit(void **state) {
    (void)state;
    double alone[3];
    for (int threads = 1; threads <= 3; threads += 2) {
        drape_test tests[3];
        tulle_error error = {0};
        for (uint32_t i = 0; i < 3; i++)
            tests[i] = (drape_test){.material = take_fabric("wool"),
                                    .pattern = (drape_pattern)i,
                                    .cell = 20e-3,
                                    .seed = i};
        assert_int_equal(drape_test_run(tests, 3, threads, &error), TULLE_OK);
        for (int i = 0; i < 3; i++) {
            if (threads == 1) alone[i] = tests[i].coefficient;
            assert_memory_equal(&tests[i].coefficient, &alone[i], sizeof(double));
            assert_true(tests[i].is_at_rest && alone[i] > 20.0 && alone[i] < 90.0);
        }
    }
}

/* Cloth that bends by 30 mm does not hang as cotton does, whatever its shear. */
static void measures_that_contradict_are_refused(void **state) {
    (void)state;
    fit_measures measures = nothing_measured;
    measures.lengths[0] = measures.lengths[1] = 30e-3;
    measures.drape = 60.0;
    fit_method quick = coarse;
    quick.samples = 1;
    fit_found const found = find("cotton", &measures, &quick);
    assert_int_equal(found.unknown, FIT_SHEAR);
    assert_int_equal(found.search.verdict, SEARCH_TOO_LOW);
    assert_false(fit_is_possible(&found));
    double const fits = fit_compute_bending_length(found.advice.unknown, 0.15);
    assert_true(fits > 12e-3 && fits < 24e-3);

    measures.shear = 50.0;
    measures.drape = 98.0;
    fit_found const compared = find("cotton", &measures, &quick);
    assert_int_equal(compared.unknown, FIT_DRAPE);
    assert_int_equal(compared.search.verdict, SEARCH_TOO_HIGH);
}

/* Denim whose shear is far below the preset's drapes by 4 % less. */
static void soft_shear_is_found_again(void **state) {
    (void)state;
    if (!getenv("TULLE_TEST_LONG")) skip(); /* a minute on two cores, on the meshes of the method */
    tulle_material hidden = take_fabric("denim");
    hidden.shear.stiffness = 10.0;
    fit_measures measures = nothing_measured;
    measures.lengths[0] = measures.lengths[1] =
        fit_compute_bending_length(hidden.bend_warp, hidden.area_density);
    measures.length_error = 0.0;
    measures.drape_error = 0.5;
    measures.drape = simulate_drape(&hidden, DRAPE_RINGS, 6e-3);
    fit_method const fine = {.samples = 3, .pattern = DRAPE_IRREGULAR_RINGS, .threads = 2};
    fit_found const found = find("denim", &measures, &fine);
    assert_int_equal(found.unknown, FIT_SHEAR);
    assert_true(found.search.low < 10.0 && found.search.high > 10.0);
    assert_true(found.search.high < 100.0 && !found.keeps_shear);
    assert_true(found.material.shear.stiffness < 30.0);
}

/* ---- the file ---- */

static void the_written_file_loads(void **state) {
    (void)state;
    char path[] = "/tmp/tulle_fit_XXXXXX";
    int const file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    for (const char *const *fabric = (const char *const[]){"cotton", "denim-soft", "felt", NULL};
         *fabric; fabric++) {
        fit_measures measures = nothing_measured;
        measures.lengths[0] = 21e-3;
        measures.shear = 77.125;
        fit_found const found = find(*fabric, &measures, &coarse);
        fit_story const story = {
            .measures = &measures, .found = &found, .start = "the file a\nb: {", .path = path};
        tulle_error error = {0};
        assert_int_equal(fit_write_material(&story, &error), TULLE_OK);
        tulle_material loaded;
        tulle_scene_problems *const problems = calloc(1, sizeof *problems);
        assert_non_null(problems);
        assert_int_equal(scene_load_material(path, &loaded, problems), TULLE_OK);
        free(problems);
        /* Its members are doubles alone. */
        const double *const a = (const double *)&loaded;
        const double *const b = (const double *)&found.material;
        for (size_t i = 0; i < sizeof loaded / sizeof *a; i++)
            assert_true(fabs(a[i] - b[i]) <= 1e-3 * fabs(b[i]));
    }
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rigidity_is_that_of_the_cantilever),
        cmocka_unit_test(bending_lengths_alone_need_no_simulation),
        cmocka_unit_test(bending_is_found_again),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(measures_that_contradict_are_refused),
        cmocka_unit_test(soft_shear_is_found_again),
        cmocka_unit_test(the_written_file_loads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
