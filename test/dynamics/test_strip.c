/* A strip held at both ends and pulled: the tension by strain that the page on materials gives, and
 * how much of a straight line's work it takes. */
#include "dynamics/fixture.h"

#include <math.h>
#include <stdio.h>

enum { COLUMNS = 16, ROWS = 4, STEPS_MAX = 400 };
static const double LENGTH = 0.4, WIDTH = 0.1; /* [m] */
static const double STEP = 0.05;               /* [s] */
static const double SLOWED = 0.9;              /* part of the velocities kept from step to step */

typedef struct strip_pull {
    double tension; /* [N/m] */
    double energy;  /* [J/m^2] */
} strip_pull;

/* Longer by `strain`, the sides free, at rest. */
static strip_pull pull_strip(tulle_material material, double strain) {
    material.springs.bend_stiffness = 0.0;
    fixture *const f = fixture_make_grid(COLUMNS, ROWS, LENGTH, WIDTH, 1, material);
    for (size_t v = 0; v < f->vertex_count; v++) {
        size_t const column = v % (COLUMNS + 1);
        f->x[3 * v] *= 1.0 + strain;
        f->is_fixed[v] = column == 0 || column == COLUMNS;
    }
    for (int i = 0; i < STEPS_MAX; i++) {
        fixture_step(f, TULLE_INTEGRATOR_IMPLICIT_EULER, STEP);
        for (size_t k = 0; k < 3 * f->vertex_count; k++) f->v[k] *= SLOWED;
    }
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, STEP);
    double force = 0.0, unrest = 0.0;
    for (size_t v = 0; v < f->vertex_count; v++) {
        double const pull = f->system.forces[3 * v];
        if (v % (COLUMNS + 1) == 0) force += pull;
        if (!f->is_fixed[v]) unrest = fmax(unrest, fabs(pull));
    }
    assert_true(unrest < 1e-4 * force);
    cloth_energies energies;
    assert_int_equal(compute_energies(&f->model, f->x, f->v, (energy_options){.threads = 1},
                                      &f->scratch, &energies),
                     TULLE_OK);
    fixture_free(f);
    return (strip_pull){force / WIDTH, energies.elastic.stretch / (LENGTH * WIDTH)};
}

static void presets_pull_as_told(void **state) {
    (void)state;
    static const double strains[4] = {0.02, 0.1, 0.2, 0.3};
    static const struct {
        const char *name;
        double stretch, tensions[4]; /* [N/m] */
    } told[3] = {{"cotton", 300.0, {7.4, 67.5, 324.0, 958.0}},
                 {"denim", 900.0, {22.2, 203.0, 971.0, 2874.0}},
                 {"rubber-sheet", 1500.0, {35.8, 182.0, 371.0, 565.0}}};
    for (int n = 0; n < 3; n++) {
        tulle_material material;
        assert_int_equal(tulle_material_preset(told[n].name, &material), TULLE_OK);
        assert_true(material.springs.stretch_stiffness == told[n].stretch);
        for (int k = 0; k < 4; k++) {
            double const tension = pull_strip(material, strains[k]).tension;
            print_message("%s, strain %g: %.5g N/m\n", told[n].name, strains[k], tension);
            assert_true(fabs(tension / told[n].tensions[k] - 1.0) < 0.01);
        }
    }
}

/* Tension and energy go together, and their curve sags as that of woven cloth does. */
static void curve_sags(void **state) {
    (void)state;
    tulle_material cotton;
    assert_int_equal(tulle_material_preset("cotton", &cotton), TULLE_OK);
    double const strain = 0.2345;
    strip_pull const less = pull_strip(cotton, strain - 0.005), at = pull_strip(cotton, strain),
                     more = pull_strip(cotton, strain + 0.005);
    assert_true(fabs((more.energy - less.energy) / 0.01 / at.tension - 1.0) < 0.005);
    double const linearity = at.energy / (0.5 * at.tension * strain);
    print_message("%.4g N/m at a strain of %g, linearity %.3g\n", at.tension, strain, linearity);
    assert_true(fabs(at.tension / 490.0 - 1.0) < 0.01);
    assert_true(fabs(linearity - 0.59) < 0.01);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(presets_pull_as_told),
                                       cmocka_unit_test(curve_sags)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
