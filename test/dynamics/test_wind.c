/* Gusts: statistics, smoothness, seeds; and that wind carries a sheet to its own speed. */
#include "dynamics/fixture.h"
#include "dynamics/wind.h"

static tulle_wind gusty(uint64_t seed) {
    return (tulle_wind){.velocity = {3.0, -1.0, 0.5},
                        .gust_strength = 2.0,
                        .gust_length = 0.4,
                        .gust_time = 0.7,
                        .seed = seed,
                        .drag_coefficient = 1.0};
}

static vec3 sample(const tulle_wind *wind, vec3 place, double time) {
    gust_cell cell = {0};
    return wind_compute_velocity(wind, place, time, &cell);
}

static vec3 random_place(uint64_t *random) {
    return vec3_make(100.0 * random_signed(random), 100.0 * random_signed(random),
                     100.0 * random_signed(random));
}

/* Mean and standard deviation of each component; no component knows the others. */
static void moments_are_as_asked(void **state) {
    (void)state;
    enum { SAMPLES = 200000 };
    tulle_wind const wind = gusty(5);
    uint64_t random = 1;
    double sum[3] = {0}, product[3][3] = {{0}};
    for (int i = 0; i < SAMPLES; i++) {
        vec3 const v = sample(&wind, random_place(&random), 1000.0 * random_uniform(&random));
        double const gust[3] = {v.x - 3.0, v.y + 1.0, v.z - 0.5};
        for (int a = 0; a < 3; a++) {
            sum[a] += gust[a] / SAMPLES;
            for (int b = 0; b < 3; b++) product[a][b] += gust[a] * gust[b] / SAMPLES;
        }
    }
    for (int a = 0; a < 3; a++) {
        assert_true(fabs(sum[a]) < 0.03);
        for (int b = 0; b < 3; b++) assert_true(fabs(product[a][b] - (a == b ? 4.0 : 0.0)) < 0.06);
    }
}

/* Correlation with a place `distance` lengths away along one axis, or times in time (axis 3). */
static double measure_correlation(int axis, double distance) {
    enum { SAMPLES = 100000 };
    tulle_wind wind = gusty(6);
    wind.velocity[0] = wind.velocity[1] = wind.velocity[2] = 0.0;
    uint64_t random = 2;
    double sum = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        vec3 const place = random_place(&random);
        double const time = 1000.0 * random_uniform(&random);
        vec3 other = place;
        double const shift = distance * (axis == 3 ? wind.gust_time : wind.gust_length);
        other.x += axis == 0 ? shift : 0.0;
        other.y += axis == 1 ? shift : 0.0;
        other.z += axis == 2 ? shift : 0.0;
        vec3 const a = sample(&wind, place, time);
        vec3 const b = sample(&wind, other, time + (axis == 3 ? shift : 0.0));
        sum += vec3_dot(a, b) / (3.0 * 4.0 * SAMPLES);
    }
    return sum;
}

static void correlation_falls_to_one_over_e(void **state) {
    (void)state;
    for (int axis = 0; axis < 4; axis++) {
        assert_true(fabs(measure_correlation(axis, 1.0) - exp(-1.0)) < 0.015);
        assert_true(measure_correlation(axis, 0.1) > 0.95);
        assert_true(fabs(measure_correlation(axis, 3.0)) < 0.015);
    }
}

static void gusts_are_smooth_and_seeded(void **state) {
    (void)state;
    tulle_wind const wind = gusty(7), other = gusty(8);
    uint64_t random = 3;
    gust_cell shared = {0};
    double difference = 0.0;
    for (int i = 0; i < 2000; i++) {
        /* Also just across lattice planes, and with a cell that was used elsewhere. */
        vec3 place = random_place(&random);
        double const plane = 1.215 * wind.gust_length * floor(place.x);
        if (i % 2) place.x = plane - 1e-9;
        double const time = 100.0 * random_uniform(&random);
        vec3 const here = sample(&wind, place, time);
        vec3 const again = wind_compute_velocity(&wind, place, time, &shared);
        assert_true(here.x == again.x && here.y == again.y && here.z == again.z);
        place.x += 2e-9;
        assert_true(vec3_norm(vec3_sub(sample(&wind, place, time), here)) < 1e-6);
        difference += vec3_norm(vec3_sub(sample(&other, place, time), here)) / 2000.0;
    }
    assert_true(difference > 2.0);
    /* Places and times without meaning give a finite wind. */
    vec3 const far = sample(&wind, vec3_make(1e300, -1e300, 0.0), 1e300);
    assert_true(isfinite(far.x) && isfinite(far.y) && isfinite(far.z));
}

/* Every mesh of a sheet across the wind takes the same force, k A |w|^2. */
static void total_drag_does_not_depend_on_the_mesh(void **state) {
    (void)state;
    for (size_t cells = 2; cells <= 16; cells *= 2)
        for (int pattern = 0; pattern < 3; pattern++) {
            fixture *const f = fixture_make_grid(cells, cells, 0.6, 0.5, pattern, plain_material());
            f->surroundings.wind = (tulle_wind){.velocity = {0.0, 3.0, 0.0},
                                                .gust_length = 1.0,
                                                .gust_time = 1.0,
                                                .drag_coefficient = 0.7};
            fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
            double force = 0.0;
            for (size_t v = 0; v < f->vertex_count; v++) force += f->system.forces[3 * v + 1];
            assert_true(fabs(force - 0.7 * 0.3 * 9.0) < 1e-12);
            fixture_free(f);
        }
}

/* m v' = -k A (v - w)^2 from rest: 1 / (w - v) grows by k A / m a second. */
static void wind_drives_a_sheet_as_in_closed_form(void **state) {
    (void)state;
    fixture *const f = fixture_make_grid(4, 4, 0.5, 0.5, 2, plain_material());
    f->surroundings.wind = (tulle_wind){
        .velocity = {0.0, 2.0, 0.0}, .gust_length = 1.0, .gust_time = 1.0, .drag_coefficient = 0.1};
    for (int i = 0; i < 400; i++) fixture_step(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 5e-3);
    /* By area: k / rho = 0.5 1/m, t = 2 s. */
    double const expected = 2.0 - 1.0 / (0.5 + 0.5 * 2.0);
    double momentum = 0.0, mass = 0.0;
    for (size_t v = 0; v < f->vertex_count; v++) {
        momentum += f->model.masses[v] * f->v[3 * v + 1];
        mass += f->model.masses[v];
    }
    assert_true(fabs(momentum / mass - expected) < 0.003);
    fixture_free(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_are_as_asked),
        cmocka_unit_test(correlation_falls_to_one_over_e),
        cmocka_unit_test(gusts_are_smooth_and_seeded),
        cmocka_unit_test(total_drag_does_not_depend_on_the_mesh),
        cmocka_unit_test(wind_drives_a_sheet_as_in_closed_form),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
