/* Factors on the stiffness of triangles: what hangs and what bends beside closed forms, bits beside
 * a material of that stiffness, saved states, recordings. */
#include "support/small_world.h"
#include "tulle/paper.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* A strip in the plane z = 0 with square cells, longest along x from 0, and pinned where x is at
 * most `held` cells; gravity acts along `down`. */
typedef struct strip {
    uint32_t columns, rows; /* cells */
    double cell;            /* [m] */
    double held;            /* cells */
    double gravity[3];
    tulle_material material;
    tulle_membrane membrane;
    double first, second; /* factors of both halves of what is free */
    int has_factors, threads;
} strip;

static tulle_material make_material(void) {
    tulle_material material;
    assert_int_equal(tulle_material_preset("cotton", &material), TULLE_OK);
    material.air_damping = 20.0;
    material.poisson = 0.0;
    material.warp.knee = material.weft.knee = material.shear.knee = 0.0;
    return material;
}

static tulle_mesh make_mesh(const strip *s) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = s->columns * s->cell, shape.size[1] = s->rows * s->cell;
    shape.resolution[0] = s->columns + 1, shape.resolution[1] = s->rows + 1;
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_shape_generate(&shape, &mesh, NULL), TULLE_OK);
    for (size_t v = 0; v < mesh.vertex_count; v++) mesh.positions[3 * v] += 0.5 * shape.size[0];
    return mesh;
}

static tulle_world *start(const strip *s) {
    tulle_mesh mesh = make_mesh(s);
    uint32_t *const held = malloc(mesh.vertex_count * sizeof *held);
    double *const factors = malloc(mesh.triangle_count * sizeof *factors);
    assert_true(held && factors);
    tulle_pin pin = tulle_pin_default();
    pin.vertices = held;
    for (uint32_t v = 0; v < mesh.vertex_count; v++)
        if (mesh.positions[3 * v] < (s->held + 0.1) * s->cell) held[pin.vertex_count++] = v;
    double const middle = 0.5 * (s->held + s->columns) * s->cell;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        double x = 0.0;
        for (size_t k = 0; k < 3; k++)
            x += mesh.positions[3 * (size_t)mesh.triangles[3 * t + k]] / 3.0;
        factors[t] = x < middle ? s->first : s->second;
    }
    tulle_world_def def = tulle_world_def_default();
    for (int k = 0; k < 3; k++) def.gravity[k] = s->gravity[k];
    def.membrane = s->membrane;
    def.threads = s->threads;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&mesh);
    cloth.material = s->material;
    cloth.pins = &pin;
    cloth.pin_count = pin.vertex_count > 0;
    if (s->has_factors) cloth.stiffness_factors = factors;
    tulle_world *world = NULL;
    tulle_error error;
    assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_OK);
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, &id, &error), TULLE_OK);
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    free(held), free(factors);
    tulle_mesh_destroy(&mesh);
    return world;
}

static void step(tulle_world *world, int count) {
    tulle_error error;
    for (int i = 0; i < count; i++)
        assert_int_equal(tulle_world_step(world, 1.0 / 60.0, NULL, &error), TULLE_OK);
}

/* [m] The mean place of the free end along an axis, after ten seconds. */
static double measure_end(const strip *s, size_t axis) {
    tulle_world *const world = start(s);
    step(world, 600);
    size_t count;
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, &count);
    tulle_mesh mesh = make_mesh(s);
    double sum = 0.0;
    for (size_t v = 0; v < count; v++)
        if (mesh.positions[3 * v] > (s->columns - 0.1) * s->cell) sum += x[3 * v + axis];
    tulle_mesh_destroy(&mesh);
    tulle_world_destroy(world);
    return sum / (s->rows + 1);
}

/* Its own weight w per area pulls at s from the free end with w s, so a part from a to b stretches
 * by w (b^2 - a^2) / (2 k). */
static void a_strip_hangs_as_two_would(void **state) {
    (void)state;
    static const double factors[][2] = {{1.0, 8.0}, {8.0, 1.0}, {0.5, 2.0}};
    for (int membrane = 0; membrane < 2; membrane++)
        for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
            strip s = {.columns = 40, .rows = 4, .cell = 0.025, .gravity = {30.0, 0.0, 0.0}};
            s.membrane = membrane == 0 ? TULLE_MEMBRANE_WOVEN : TULLE_MEMBRANE_SPRINGS;
            s.material = make_material();
            s.material.area_density = 1.0;
            s.material.warp.stiffness = s.material.weft.stiffness = 1000.0;
            s.material.springs.stretch_stiffness = 1000.0;
            s.material.springs.stiffening_strain = 0.0;
            s.has_factors = 1, s.first = s.second = 1.0;
            double const plain = measure_end(&s, 0) - 1.0;
            s.first = factors[i][0], s.second = factors[i][1];
            double const stretched = measure_end(&s, 0) - 1.0;
            double const wanted = 0.75 / s.first + 0.25 / s.second;
            if (!(fabs(stretched / plain / wanted - 1.0) < 0.02))
                fail_msg("%s, %g and %g: %g of the plain strip's stretch, not %g",
                         membrane == 0 ? "woven" : "springs", s.first, s.second, stretched / plain,
                         wanted);
            if (membrane == 0 && !(fabs(plain / 0.015 - 1.0) < 0.02)) fail_msg("plain: %g", plain);
        }
}

/* The end of an overhang sinks by w / 2 times the integral of s^3 / B, s from the free end. The row
 * of triangles at the jump bends as if that were up to half a cell elsewhere: it is held between
 * the two. */
static void an_overhang_bends_as_two_would(void **state) {
    (void)state;
    static const double factors[][2] = {{1.0, 1.0}, {1.0, 10.0}, {10.0, 1.0}};
    for (int membrane = 0; membrane < 2; membrane++)
        for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
            strip s = {.columns = 26, .rows = 4, .cell = 0.005, .held = 2.0};
            s.membrane = membrane == 0 ? TULLE_MEMBRANE_WOVEN : TULLE_MEMBRANE_SPRINGS;
            s.material = make_material();
            s.material.bend_warp = s.material.bend_weft = 2e-5;
            s.material.bend_twist = 1e-5;
            s.material.springs.bend_stiffness = 2e-5;
            s.has_factors = 1, s.first = factors[i][0], s.second = factors[i][1];
            double const length = 0.12, sink = 0.02 * length;
            double shares[3];
            for (int k = 0; k < 3; k++) {
                double const part = pow(0.5 + 0.5 * (k - 1) / 24.0, 4.0);
                shares[k] = (1.0 - part) / s.first + part / s.second;
            }
            s.gravity[2] =
                -sink * 8.0 * 2e-5 / (s.material.area_density * pow(length, 4.0) * shares[1]);
            double const share = -measure_end(&s, 2) / sink;
            /* springs know no clamp: half a cell more bends */
            double const wanted = membrane == 0 ? 1.0 : pow(1.0 + 0.5 / 24.0, 4.0);
            double const low = fmin(shares[0], shares[2]), high = fmax(shares[0], shares[2]);
            if (!(share > 0.97 * wanted * low / shares[1] &&
                  share < 1.03 * wanted * high / shares[1]))
                fail_msg("%s, %g and %g: sinks by %g of what theory says",
                         membrane == 0 ? "woven" : "springs", s.first, s.second, share);
        }
}

/* Cloth that moves, shears, and has hysteresis and damping. */
static strip make_lively(tulle_membrane membrane) {
    strip s = {.columns = 40, .rows = 30, .cell = 0.02, .held = 1.0};
    s.membrane = membrane;
    s.gravity[1] = -4.0, s.gravity[2] = -9.0;
    assert_int_equal(tulle_material_preset("cotton", &s.material), TULLE_OK);
    tulle_material *const m = &s.material;
    m->bend_damping = m->stretch_damping = 1e-3;
    m->bend_hysteresis_warp = m->bend_hysteresis_weft = 20.0 * m->bend_warp;
    m->shear_hysteresis = 0.05 * m->shear.stiffness;
    return s;
}

static uint64_t run_lively(const strip *s) {
    tulle_world *const world = start(s);
    step(world, 25);
    uint64_t const hash = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    return hash;
}

static void bits_are_those_of_such_a_material(void **state) {
    (void)state;
    for (int membrane = 0; membrane < 2; membrane++) {
        strip s = make_lively(membrane == 0 ? TULLE_MEMBRANE_WOVEN : TULLE_MEMBRANE_SPRINGS);
        uint64_t const plain = run_lively(&s);
        s.has_factors = 1, s.first = s.second = 1.0;
        assert_true(run_lively(&s) == plain);
        s.first = s.second = 2.0;
        uint64_t const doubled = run_lively(&s);
        assert_true(doubled != plain);
        s.threads = 3;
        assert_true(run_lively(&s) == doubled);
        s.has_factors = 0;
        tulle_material *const m = &s.material;
        double *const values[] = {&m->warp.stiffness,
                                  &m->weft.stiffness,
                                  &m->shear.stiffness,
                                  &m->bend_warp,
                                  &m->bend_weft,
                                  &m->bend_twist,
                                  &m->bend_hysteresis_warp,
                                  &m->bend_hysteresis_weft,
                                  &m->shear_hysteresis,
                                  &m->springs.bend_stiffness,
                                  &m->springs.stretch_stiffness};
        for (size_t i = 0; i < sizeof values / sizeof *values; i++) *values[i] *= 2.0;
        assert_true(run_lively(&s) == doubled);
    }
}

/* Forces follow from the energy: without damping, a strip that swings keeps what it has, whatever
 * its factors. */
static void factors_make_no_energy(void **state) {
    (void)state;
    strip s = make_lively(TULLE_MEMBRANE_WOVEN);
    s.has_factors = 1, s.first = 30.0, s.second = 0.1;
    tulle_world *const world = start(&s);
    tulle_error error;
    tulle_step_report report;
    double most = -(double)INFINITY, first = 0.0;
    for (int i = 0; i < 90; i++) {
        assert_int_equal(tulle_world_step(world, 1.0 / 120.0, &report, &error), TULLE_OK);
        double const sum = report.kinetic_energy + report.gravity_energy + report.elastic_energy;
        if (i == 0) first = sum;
        most = fmax(most, sum);
    }
    assert_true(most <= first + 1e-6 * fabs(first));
    tulle_world_destroy(world);
}

static void a_saved_state_knows_its_factors(void **state) {
    (void)state;
    strip s = make_lively(TULLE_MEMBRANE_WOVEN);
    s.has_factors = 1, s.first = 5.0, s.second = 0.5;
    tulle_world *const world = start(&s), *const same = start(&s);
    s.second = 0.51;
    tulle_world *const other = start(&s);
    void *saved = NULL;
    size_t size = 0;
    tulle_error error;
    step(world, 5);
    assert_int_equal(tulle_world_save_state(world, &saved, &size, &error), TULLE_OK);
    assert_int_equal(tulle_world_load_state(other, saved, size, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_load_state(same, saved, size, &error), TULLE_OK);
    step(world, 5);
    step(same, 5);
    assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(same));
    tulle_world_free_state(world, saved, size);
    tulle_world_destroy(world);
    tulle_world_destroy(same);
    tulle_world_destroy(other);
}

/* A material that a host sets later has the same factors, and the fineness is that of the softest
 * place. */
static void factors_stay_with_the_cloth(void **state) {
    (void)state;
    strip s = make_lively(TULLE_MEMBRANE_WOVEN);
    tulle_cloth_id const id = {0, 1};
    tulle_world *const plain = start(&s);
    s.has_factors = 1, s.first = 8.0, s.second = 0.125;
    tulle_world *const world = start(&s);
    double const length = tulle_cloth_get_fineness(plain, id).bending_length;
    assert_true(fabs(tulle_cloth_get_fineness(world, id).bending_length - 0.5 * length) < 1e-12);
    tulle_error error;
    s.material.air_damping = 3.0;
    assert_int_equal(tulle_cloth_set_material(world, id, &s.material, &error), TULLE_OK);
    tulle_world *const direct = start(&s);
    step(world, 10);
    step(direct, 10);
    const double *const a = tulle_cloth_get_positions(world, id, NULL);
    const double *const b = tulle_cloth_get_positions(direct, id, NULL);
    assert_memory_equal(a, b, 3 * 41 * 31 * sizeof(double));
    tulle_world_destroy(plain);
    tulle_world_destroy(world);
    tulle_world_destroy(direct);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_strip_hangs_as_two_would),
        cmocka_unit_test(an_overhang_bends_as_two_would),
        cmocka_unit_test(bits_are_those_of_such_a_material),
        cmocka_unit_test(factors_make_no_energy),
        cmocka_unit_test(a_saved_state_knows_its_factors),
        cmocka_unit_test(factors_stay_with_the_cloth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
