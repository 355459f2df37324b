/* Free rigid bodies: what is kept, the flips of the intermediate axis, order of accuracy, impulses.
 */
#include "dynamics/rigid_body.h"

#include "base/hash.h"
#include "support/test_support.h"

#include <string.h>

static const double STEP = 1.0 / 90.0;

static double draw(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

static quaternion draw_rotation(uint64_t *random) {
    return quaternion_normalize(
        (quaternion){draw(random), draw(random), draw(random), draw(random)});
}

static rigid_body make_body(double x, double y, double z) {
    return (rigid_body){.mass = 1.7, .moments = {x, y, z}};
}

static double get_rotation_energy(const rigid_body *body, const rigid_state *state) {
    return 0.5 * vec3_dot(state->spin, rigid_compute_angular_velocity(body, state));
}

static void drift(const rigid_body *body, double h, rigid_state *state) {
    assert_true(rigid_drift(body, state->velocity, h, state));
}

static void test_top_keeps_energy_and_spin(void **context) {
    (void)context;
    static const double speeds[] = {0.3, 5.0, 60.0};
    uint64_t random = 11;
    for (int i = 0; i < 3; i++) {
        rigid_body const body = make_body(0.01, 0.02, 0.027);
        rigid_state state = {.orientation = draw_rotation(&random)};
        state.spin = rigid_compute_spin(&body, state.orientation,
                                        vec3_make(0.2 * speeds[i], speeds[i], 0.4 * speeds[i]));
        vec3 const spin = state.spin;
        double const energy = get_rotation_energy(&body, &state);
        for (int step = 0; step < 10000; step++) {
            drift(&body, STEP, &state);
            assert_true(fabs(get_rotation_energy(&body, &state) / energy - 1.0) < 1e-11);
        }
        assert_memory_equal(&state.spin, &spin, sizeof spin);
        assert_true(fabs(quaternion_norm(state.orientation) - 1.0) < 1e-15);
    }
}

/* d/dt of (q, P) by Euler's equations, for the oracle. */
static void find_rates(const rigid_body *body, const double y[7], double rate[7]) {
    double const w[3] = {y[4] / body->moments.x, y[5] / body->moments.y, y[6] / body->moments.z};
    quaternion const turn =
        quaternion_multiply(quaternion_load(y), (quaternion){0.0, w[0] / 2, w[1] / 2, w[2] / 2});
    memcpy(rate, &turn, sizeof turn);
    rate[4] = y[5] * w[2] - y[6] * w[1];
    rate[5] = y[6] * w[0] - y[4] * w[2];
    rate[6] = y[4] * w[1] - y[5] * w[0];
}

/* Runge and Kutta's classical method in small steps. */
static quaternion integrate(const rigid_body *body, const rigid_state *start, double time) {
    vec3 const own = quaternion_rotate(quaternion_conjugate(start->orientation), start->spin);
    double y[7], k[4][7], at[7];
    memcpy(y, &start->orientation, sizeof(quaternion));
    memcpy(y + 4, &own, sizeof own);
    int const count = 40000;
    double const h = time / count;
    static const double part[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    for (int i = 0; i < count; i++) {
        for (int s = 0; s < 4; s++) {
            for (int c = 0; c < 7; c++) at[c] = y[c] + (s > 0 ? h * part[s] * k[s - 1][c] : 0.0);
            find_rates(body, at, k[s]);
        }
        for (int c = 0; c < 7; c++)
            for (int s = 0; s < 4; s++) y[c] += h / 6.0 * weight[s] * k[s][c];
    }
    return quaternion_normalize(quaternion_load(y));
}

static double get_angle(quaternion a, quaternion b) {
    quaternion const c = quaternion_multiply(quaternion_conjugate(a), b);
    return 2.0 * asin(fmin(1.0, sqrt(c.x * c.x + c.y * c.y + c.z * c.z)));
}

static void test_order_of_accuracy(void **context) {
    (void)context;
    rigid_body const body = make_body(0.01, 0.02, 0.027);
    rigid_state start = {.orientation = {1.0, 0.0, 0.0, 0.0}, .spin = {0.02, 0.1, -0.05}};
    quaternion const truth = integrate(&body, &start, 2.0);
    double error[3];
    for (int i = 0; i < 3; i++) {
        int const count = 200 << i; /* the turns of a step stay under the length of a part */
        rigid_state state = start;
        for (int step = 0; step < count; step++) drift(&body, 2.0 / count, &state);
        error[i] = get_angle(truth, state.orientation);
    }
    print_message(
        "orientation after 2 s in steps of 10, 5 and 2.5 ms: off by %.2g, %.2g, %.2g rad\n",
        error[0], error[1], error[2]);
    assert_true(error[0] < 1e-3);
    assert_true(error[1] < error[0] / 13.0 && error[2] < error[1] / 13.0);
    /* one long step is cut up */
    rigid_state state = start;
    drift(&body, 2.0, &state);
    assert_true(get_angle(truth, state.orientation) < 2e-3);
}

static double find_elliptic_k(double m) {
    double a = 1.0, b = sqrt(1.0 - m);
    for (int i = 0; i < 40; i++) {
        double const next = 0.5 * (a + b);
        b = sqrt(a * b);
        a = next;
    }
    return 3.141592653589793 / (2.0 * a);
}

/* Spun about the intermediate axis, with a little about the others, a body turns over every
 * 2 K(m) / p seconds: Jacobi's solution. */
static void test_intermediate_axis_flips(void **context) {
    (void)context;
    double const i1 = 0.01, i2 = 0.02, i3 = 0.027;
    rigid_body const body = make_body(i1, i2, i3);
    rigid_state state = {.orientation = {1.0, 0.0, 0.0, 0.0}, .spin = {1e-5, i2 * 6.0, 2e-5}};
    double const w1 = 1e-5 / i1, w2 = 6.0, w3 = 2e-5 / i3;
    double const twice = i1 * w1 * w1 + i2 * w2 * w2 + i3 * w3 * w3;
    double const spin2 = vec3_norm2(state.spin);
    double a = i1, b = i3; /* the modulus is under 1 for one of both orders */
    if (spin2 < twice * i2) a = i3, b = i1;
    double const m = (i2 - a) * (twice * b - spin2) / ((b - i2) * (spin2 - twice * a));
    double const p = sqrt((b - i2) * (spin2 - twice * a) / (i1 * i2 * i3));
    assert_true(m > 0.0 && m < 1.0);
    double const half_period = 2.0 * find_elliptic_k(m) / p;
    double last = 1.0, first_flip = 0.0, last_flip = 0.0;
    int flips = 0;
    for (int step = 1; step <= 90 * 120; step++) {
        drift(&body, STEP, &state);
        double const own = quaternion_rotate(quaternion_conjugate(state.orientation), state.spin).y;
        if (own * last < 0.0) {
            double const when = STEP * (step - fabs(own) / (fabs(own) + fabs(last)));
            if (flips++ == 0) first_flip = when;
            last_flip = when;
        }
        last = own;
    }
    double const ratio = (last_flip - first_flip) / (flips - 1) / half_period;
    print_message("flips: %d, period over Jacobi's %.6f\n", flips, ratio);
    assert_true(flips >= 10);
    assert_true(fabs(ratio - 1.0) < 2e-3);
    /* about the other two axes it does not */
    const vec3 stable[2] = {{i1 * 6.0, 1e-5, 2e-5}, {1e-5, 2e-5, i3 * 6.0}};
    for (int i = 0; i < 2; i++) {
        state = (rigid_state){.orientation = {1.0, 0.0, 0.0, 0.0}, .spin = stable[i]};
        for (int step = 0; step < 5000; step++) {
            drift(&body, STEP, &state);
            vec3 const own = quaternion_rotate(quaternion_conjugate(state.orientation), state.spin);
            assert_true(vec3_norm(vec3_sub(own, stable[i])) < 1e-2 * vec3_norm(stable[i]));
        }
    }
}

static void test_symmetric_top_precesses(void **context) {
    (void)context;
    /* the axis of a symmetric top goes round the spin with |L| / I_across */
    rigid_body const body = make_body(0.02, 0.02, 0.035);
    rigid_state state = {.orientation = {1.0, 0.0, 0.0, 0.0}, .spin = {0.03, 0.0, 0.2}};
    vec3 const spin = state.spin, axis = vec3_make(0.0, 0.0, 1.0);
    vec3 const along = vec3_normalize(spin);
    double const rate = vec3_norm(spin) / 0.02, time = 3.0;
    for (int step = 0; step < 270; step++) drift(&body, STEP, &state);
    vec3 const flat = vec3_add_scaled(axis, along, -vec3_dot(axis, along));
    vec3 const side = vec3_cross(along, flat);
    vec3 expected = vec3_scale(along, vec3_dot(axis, along));
    expected = vec3_add_scaled(expected, flat, cos(rate * time));
    expected = vec3_add_scaled(expected, side, sin(rate * time));
    vec3 const got = quaternion_rotate(state.orientation, axis);
    double const off = vec3_norm(vec3_sub(got, expected));
    print_message("precession: axis off by %.2g rad after %.3g turns\n", off,
                  rate * time / (2.0 * 3.141592653589793));
    assert_true(off < 1e-3);
}

/* The midpoint rule is solved to rounding, so that it runs back to where it came from. */
static void test_drift_runs_back(void **context) {
    (void)context;
    uint64_t random = 17;
    double largest = 0.0;
    for (int i = 0; i < 300; i++) { /* rods of some thickness, along each axis */
        double const thin = i % 2 ? 0.01 : 0.1;
        double moments[3] = {0.99, 1.0, 0.985};
        moments[i % 3] = thin * (1.0 + random_uniform(&random));
        rigid_body const body = make_body(moments[0], moments[1], moments[2]);
        rigid_state const start = {.orientation = draw_rotation(&random)};
        rigid_state state = start;
        state.spin = rigid_compute_spin(
            &body, start.orientation,
            vec3_make(5.0 * draw(&random), 5.0 * draw(&random), 5.0 * draw(&random)));
        drift(&body, STEP, &state);
        state.spin = vec3_scale(state.spin, -1.0);
        drift(&body, STEP, &state);
        largest = fmax(largest, get_angle(start.orientation, state.orientation));
    }
    print_message("there and back: off by %.2g rad\n", largest);
    assert_true(largest < 1e-12);
}

static double measure_kinetic_energy(const rigid_body *body, const rigid_state *state) {
    return 0.5 * body->mass * vec3_norm2(state->velocity) +
           0.5 * vec3_dot(state->spin, rigid_compute_angular_velocity(body, state));
}

static void apply_impulse(const rigid_body *body, rigid_state *state, vec3 point, vec3 impulse) {
    state->velocity = vec3_add_scaled(state->velocity, impulse, 1.0 / body->mass);
    state->spin = vec3_add(state->spin, vec3_cross(vec3_sub(point, state->position), impulse));
}

static void test_impulses_and_fall(void **context) {
    (void)context;
    uint64_t random = 3;
    for (int round = 0; round < 300; round++) {
        rigid_body body = make_body(0.1 + random_uniform(&random), 0.2, 0.3);
        rigid_state state = {.orientation = draw_rotation(&random),
                             .position = {draw(&random), draw(&random), draw(&random)},
                             .velocity = {draw(&random), draw(&random), draw(&random)},
                             .spin = {draw(&random), draw(&random), draw(&random)}};
        rigid_state const before = state;
        vec3 const point = vec3_make(draw(&random), draw(&random), draw(&random));
        vec3 const impulse = vec3_make(draw(&random), draw(&random), draw(&random));
        apply_impulse(&body, &state, point, impulse);
        /* the work of an impulse: its product with the mean speed of the point */
        vec3 const arm = vec3_sub(point, state.position);
        vec3 const w0 = rigid_compute_angular_velocity(&body, &before);
        vec3 const w1 = rigid_compute_angular_velocity(&body, &state);
        vec3 const mean = vec3_scale(vec3_add(vec3_add(before.velocity, vec3_cross(w0, arm)),
                                              vec3_add(state.velocity, vec3_cross(w1, arm))),
                                     0.5);
        double const gained =
            measure_kinetic_energy(&body, &state) - measure_kinetic_energy(&body, &before);
        assert_true(fabs(gained - vec3_dot(impulse, mean)) < 1e-12 * (1.0 + fabs(gained)));
        mat3 const inverse = rigid_compute_inverse_inertia(&body, state.orientation);
        vec3 const again = mat3_multiply_vec3(&inverse, state.spin);
        assert_true(vec3_norm(vec3_sub(again, w1)) < 1e-13 * (1.0 + vec3_norm(w1)));
        vec3 const spin = rigid_compute_spin(&body, state.orientation, w1);
        assert_true(vec3_norm(vec3_sub(spin, state.spin)) < 1e-13 * (1.0 + vec3_norm(spin)));
    }
    rigid_body const body = make_body(1.0, 1.0, 1.0);
    rigid_state state = {.orientation = {1.0, 0.0, 0.0, 0.0}, .velocity = {0.5, 0.0, 3.0}};
    vec3 const gravity = vec3_make(0.0, 0.0, -9.81);
    for (int step = 0; step < 180; step++) {
        vec3 const before = state.velocity;
        state.velocity = vec3_add_scaled(state.velocity, gravity, STEP);
        assert_true(rigid_drift(&body, vec3_lerp(before, state.velocity, 0.5), STEP, &state));
    }
    assert_true(fabs(state.position.z - (3.0 * 2.0 - 0.5 * 9.81 * 4.0)) < 1e-12);
    assert_true(fabs(state.position.x - 1.0) < 1e-13);
}

static void test_refusals(void **context) {
    (void)context;
    rigid_body body = make_body(0.1, 0.2, 0.3);
    rigid_state state = {
        .orientation = {1.0, 0.0, 0.0, 0.0}, .velocity = {1.0, 0.0, 0.0}, .spin = {0.0, 1.0, 0.0}};
    rigid_state before = state;
    state.spin.x = before.spin.x = 1e9;
    assert_false(rigid_drift(&body, state.velocity, STEP, &state));
    assert_memory_equal(&state, &before, sizeof state);
    state.spin.x = before.spin.x = NAN;
    assert_false(rigid_drift(&body, state.velocity, STEP, &state));
    state.spin.x = 0.0;
    assert_false(rigid_drift(&body, vec3_make(INFINITY, 0, 0), STEP, &state));
}

static void test_places(void **context) {
    (void)context;
    rigid_state const state = {.position = {1, 2, 3},
                               .orientation = {0.5, 0.5, 0.5, 0.5}}; /* x to y to z to x */
    const double points[6] = {1, 0, 0, 0, 0.5, -1};
    double placed[6];
    rigid_place(&state, points, 2, placed);
    const double expected[6] = {1, 3, 3, 0, 2, 3.5};
    for (int i = 0; i < 6; i++) assert_true(fabs(placed[i] - expected[i]) < 1e-15);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_top_keeps_energy_and_spin),
                                       cmocka_unit_test(test_order_of_accuracy),
                                       cmocka_unit_test(test_intermediate_axis_flips),
                                       cmocka_unit_test(test_symmetric_top_precesses),
                                       cmocka_unit_test(test_drift_runs_back),
                                       cmocka_unit_test(test_impulses_and_fall),
                                       cmocka_unit_test(test_refusals),
                                       cmocka_unit_test(test_places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
