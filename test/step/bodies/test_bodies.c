/* Rigid bodies through the public interface: free motion, contact with obstacles, with each other
 * and with cloth, against closed forms and laws of conservation. */
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void get_spin(const tulle_transform *t, double spin[3]) {
    for (int i = 0; i < 3; i++) {
        spin[i] = 0.0;
        for (int k = 0; k < 3; k++) spin[i] += t->inertia[3 * i + k] * t->angular_velocity[k];
    }
}

/* A coordinate by the integrator, from its textbook form: dx/dt = v, dv/dt = pull - damping v. */
typedef struct coordinate {
    double x, v, x_before, v_before;
} coordinate;

static void integrate(tulle_integrator integrator, bool is_first, double pull, double damping,
                      coordinate *at) {
    double const h = BODIES_STEP;
    coordinate const old = *at;
    if (integrator == TULLE_INTEGRATOR_CRANK_NICOLSON) {
        double const share = 0.5 + 5.0 * h; /* damped by 10/s in the air */
        double const mean = (old.v + share * h * pull) / (1.0 + share * h * damping);
        at->v = old.v + (mean - old.v) / share;
        at->x = old.x + h * mean;
    } else if (integrator == TULLE_INTEGRATOR_BDF2 && !is_first) {
        double const part = 2.0 / 3.0 * h;
        at->v = (4.0 / 3.0 * old.v - old.v_before / 3.0 + part * pull) / (1.0 + part * damping);
        at->x = 4.0 / 3.0 * old.x - old.x_before / 3.0 + part * at->v;
    } else {
        at->v = (old.v + h * pull) / (1.0 + h * damping);
        at->x = old.x + h * at->v;
    }
    at->x_before = old.x;
    at->v_before = old.v;
}

/* Bodies go by the integrator that cloth goes by, to rounding: way and turn, with a torque about a
 * main axis and with damping. */
static void follows(tulle_integrator integrator, double damping) {
    tulle_world_def def = tulle_world_def_default();
    def.integrator = integrator;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh box = bodies_make_box(0.3, 0.2, 0.1, (double[3]){0.0, 0.0, 2.0});
    tulle_body const body = {.is_dynamic = 1,
                             .mass = 2.0,
                             .velocity = {1.0, 0.0, 3.0},
                             .angular_velocity = {0.0, 0.0, 0.7},
                             .linear_damping = damping,
                             .angular_damping = damping};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.3, &body);
    tulle_error error = {0};
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    double const inertia = bodies_get_transform(world, id).inertia[8], torque = 0.02;
    coordinate height = {.x = 2.0, .v = 3.0}, way = {.v = 1.0}, turn = {.v = 0.7};
    double off = 0.0;
    for (int i = 0; i < 90; i++) {
        assert_int_equal(
            tulle_obstacle_add_torque(world, id, (double[3]){0.0, 0.0, torque}, &error), TULLE_OK);
        bodies_step(world);
        integrate(integrator, i == 0, -9.81, damping, &height);
        integrate(integrator, i == 0, 0.0, damping, &way);
        integrate(integrator, i == 0, torque / inertia, damping, &turn);
        tulle_transform const now = bodies_get_transform(world, id);
        off = fmax(off, fabs(now.position[2] - height.x) + fabs(now.velocity[2] - height.v));
        off = fmax(off, fabs(now.position[0] - way.x) + fabs(now.velocity[0] - way.v));
        off = fmax(off, fabs(now.angular_velocity[2] - turn.v));
    }
    print_message("integrator %d, damping %g/s: off by %.2g\n", (int)integrator, damping, off);
    assert_true(off < 1e-11);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

static void bodies_follow_the_integrator(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++) {
        follows((tulle_integrator)integrator, 0.0);
        follows((tulle_integrator)integrator, 1.5);
    }
}

/* By implicit Euler the way of a fall is g t (t + h) / 2, and its energy falls by m (g h)^2 / 2 a
 * step. */
static void free_fall_of_implicit_euler(void **state) {
    (void)state;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh ball = bodies_make_ball(0.1, 2, (double[3]){0.0, 0.0, 2.0});
    tulle_body const body = {.is_dynamic = 1, .mass = 2.0, .velocity = {1.0, 0.0, 3.0}};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &ball, 0.3, &body);
    double energy = 0.0, off = 0.0;
    for (int i = 1; i <= 90; i++) {
        tulle_step_report const report = bodies_step(world);
        tulle_transform const now = bodies_get_transform(world, id);
        double const t = i * BODIES_STEP, total = report.kinetic_energy + report.gravity_energy;
        double const way = 3.0 * t - 0.5 * 9.81 * t * (t + BODIES_STEP);
        off = fmax(off, fabs(now.position[2] - (2.0 + way)));
        assert_true(fabs(now.position[0] - t) < 1e-12);
        assert_true(fabs(now.velocity[2] - (3.0 - 9.81 * t)) < 1e-12);
        double const loss = 9.81 * BODIES_STEP * 9.81 * BODIES_STEP; /* mass / 2 is 1 */
        if (i > 1) assert_true(fabs(total + loss - energy) < 1e-12 * energy);
        energy = total;
    }
    print_message("free fall: off by %.2g m\n", off);
    assert_true(off < 1e-12);
    tulle_mesh_destroy(&ball);
    tulle_world_destroy(world);
}

/* What damping slows down falls as it should, and never rises, however strong the damping is. Steps
 * of implicit Euler are off by up to 0.8 % of the way, and by half of that of the speed. */
static void damped_fall(tulle_integrator integrator, double damping, double most_off) {
    tulle_world_def def = tulle_world_def_default();
    def.integrator = integrator;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh ball = bodies_make_ball(0.1, 2, (double[3]){0.0, 0.0, 2.0});
    tulle_body const body = {.is_dynamic = 1,
                             .mass = 2.0,
                             .linear_damping = damping,
                             .angular_damping = damping,
                             .angular_velocity = {0.0, 0.0, 2.0}};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &ball, 0.3, &body);
    double const time = 60 * BODIES_STEP, speed = 9.81 / damping;
    double last = 2.0, way = 0.0;
    for (int i = 0; i < 60; i++) {
        bodies_step(world);
        double const height = bodies_get_transform(world, id).position[2];
        way = last - height;
        assert_true(way > 0.0);
        last = height;
    }
    tulle_transform const end = bodies_get_transform(world, id);
    double const exact = speed * (time - (1.0 - exp(-damping * time)) / damping);
    print_message("damped by %g/s, integrator %d: falls by %.6g m, exactly %.6g\n", damping,
                  (int)integrator, 2.0 - last, exact);
    assert_true(fabs(2.0 - last - exact) < most_off * exact);
    double const left =
        exp(-damping * time); /* of the speed that is still to come, and of the spin */
    assert_true(fabs(-end.velocity[2] - speed * (1.0 - left)) < 0.01 * speed);
    assert_true(fabs(way - BODIES_STEP * speed * (1.0 - left)) < 0.01 * BODIES_STEP * speed);
    assert_true(fabs(end.angular_velocity[2] - 2.0 * left) < 0.02);
    tulle_mesh_destroy(&ball);
    tulle_world_destroy(world);
}

static void damped_bodies_fall(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++) {
        damped_fall((tulle_integrator)integrator, 3.0, 0.01);
        damped_fall((tulle_integrator)integrator, 30.0, 0.01);
    }
    damped_fall(TULLE_INTEGRATOR_IMPLICIT_EULER, 200.0, 0.01);
    damped_fall(TULLE_INTEGRATOR_IMPLICIT_EULER, 1e6, 0.01);
}

/* A box that spins about its middle axis: it flips, and keeps spin and energy. */
static void top_keeps_spin_and_energy(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.gravity[2] = 0.0;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh box = bodies_make_box(0.3, 0.2, 0.1, (double[3]){0.0, 0.0, 0.0});
    tulle_body const body = {
        .is_dynamic = 1, .density = 500.0, .angular_velocity = {0.001, 6.0, 0.0}};
    tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.3, &body);
    tulle_error error;
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    tulle_transform start = bodies_get_transform(world, id);
    assert_true(fabs(start.mass - 3.0) < 1e-12);
    double spin[3], size2 = 0.0, worst = 0.0, energy = 0.0, drift = 0.0, least = 1.0;
    get_spin(&start, spin);
    for (int k = 0; k < 3; k++) size2 += spin[k] * spin[k];
    bool const is_long = getenv("TULLE_TEST_LONG") != NULL;
    for (int i = 0; i < (is_long ? 10000 : 2000); i++) {
        tulle_step_report const report = bodies_step(world);
        tulle_transform const now = bodies_get_transform(world, id);
        double now_spin[3], change2 = 0.0;
        get_spin(&now, now_spin);
        for (int k = 0; k < 3; k++) change2 += (now_spin[k] - spin[k]) * (now_spin[k] - spin[k]);
        worst = fmax(worst, sqrt(change2 / size2));
        if (i == 0) energy = report.kinetic_energy;
        drift = fmax(drift, fabs(report.kinetic_energy - energy) / energy);
        const double *const q = now.rotation;
        least = fmin(least, 1.0 - 2.0 * (q[1] * q[1] + q[3] * q[3])); /* y axis on itself */
    }
    print_message("top: spin drifts by %.2g, energy by %.2g; least cosine of its axis %.3f\n",
                  worst, drift, least);
    assert_true(worst < 1e-9 && drift < 1e-9);
    assert_true(least < -0.9); /* it has flipped */
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* How far a box goes down a slope in `time`; friction 0.5 on both. */
static double slide_box(double degrees, double time, double *speed) {
    tulle_world_def def = tulle_world_def_default();
    double const angle = degrees * acos(-1.0) / 180.0;
    def.contact_distance = 0.002;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh floor = bodies_make_box(8.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.1, (double[3]){0.0, 0.0, 0.052});
    bodies_rotate_mesh(&floor, angle);
    bodies_rotate_mesh(&box, angle);
    tulle_body const body = {.is_dynamic = 1, .mass = 1.0};
    bodies_add_obstacle(world, &floor, 0.5, NULL);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_error error;
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    tulle_transform const start = bodies_get_transform(world, id);
    uint64_t rescues = 0;
    for (int i = 0; i < (int)(time / BODIES_STEP + 0.5); i++) {
        tulle_step_report const report = bodies_step(world);
        rescues += report.rescue_component_scalings + report.rescue_global_scalings;
    }
    tulle_transform const end = bodies_get_transform(world, id);
    double way = 0.0;
    for (int k = 0; k < 3; k++)
        way += (end.position[k] - start.position[k]) * (end.position[k] - start.position[k]);
    *speed = sqrt(end.velocity[0] * end.velocity[0] + end.velocity[2] * end.velocity[2]);
    print_message("box on %g degrees: way %.6g m, speed %.3g m/s, spin %.2g, rescues %d\n", degrees,
                  sqrt(way), *speed, end.angular_velocity[1], (int)rescues);
    assert_int_equal(rescues, 0);
    tulle_mesh_destroy(&floor);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
    return sqrt(way);
}

static void box_sticks_and_slides(void **state) {
    (void)state;
    double speed;
    double const still = slide_box(25.0, 2.0, &speed);
    assert_true(still < 1e-4 && speed < 1e-6);
    double const angle = 40.0 * acos(-1.0) / 180.0;
    double const acceleration = 9.81 * (sin(angle) - 0.5 * cos(angle));
    double const way = slide_box(40.0, 1.0, &speed);
    assert_true(fabs(speed - acceleration) < 0.01 * acceleration);
    assert_true(fabs(way - 0.5 * acceleration) < 0.02 * acceleration);
}

/* A ball with so many meridians about the y axis, about which it rolls: each facet that lands takes
 * a share of the spin, in proportion to its angle. */
static tulle_mesh make_roller(double radius, uint32_t meridians, uint32_t rings) {
    tulle_mesh mesh = {0};
    mesh.vertex_count = (size_t)meridians * rings + 2;
    mesh.triangle_count = 2 * (size_t)meridians * rings;
    mesh.positions = malloc(3 * mesh.vertex_count * sizeof(double));
    mesh.triangles = malloc(3 * mesh.triangle_count * sizeof(uint32_t));
    assert_true(mesh.positions && mesh.triangles);
    double const pi = acos(-1.0);
    uint32_t const south = meridians * rings, north = south + 1;
    for (uint32_t r = 0; r < rings; r++) {
        double const angle = pi * ((double)(r + 1) / (double)(rings + 1) - 0.5);
        for (uint32_t m = 0; m < meridians; m++) {
            double const turn = 2.0 * pi * (double)m / (double)meridians;
            double *const p = mesh.positions + 3 * ((size_t)r * meridians + m);
            p[0] = radius * cos(angle) * cos(turn);
            p[1] = radius * sin(angle);
            p[2] = -radius * cos(angle) * sin(turn);
        }
    }
    for (int k = 0; k < 6; k++) mesh.positions[3 * (size_t)south + (size_t)k] = 0.0;
    mesh.positions[3 * (size_t)south + 1] = -radius;
    mesh.positions[3 * (size_t)north + 1] = radius;
    size_t t = 0;
    for (uint32_t m = 0; m < meridians; m++) {
        uint32_t const next = (m + 1) % meridians, top = (rings - 1) * meridians;
        uint32_t const caps[6] = {south, next, m, north, top + m, top + next};
        for (int k = 0; k < 6; k++) mesh.triangles[t++] = caps[k];
        for (uint32_t r = 0; r + 1 < rings; r++) {
            uint32_t const a = r * meridians + m, b = r * meridians + next;
            uint32_t const quad[6] = {a, b, a + meridians, b, b + meridians, a + meridians};
            for (int k = 0; k < 6; k++) mesh.triangles[t++] = quad[k];
        }
    }
    return mesh;
}

/* A ball on a slope rolls with 5/7 g sin(angle). */
static void ball_rolls(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    double const angle = 15.0 * acos(-1.0) / 180.0, c = 0.002, radius = 0.1;
    def.contact_distance = c;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh floor = bodies_make_box(12.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_mesh ball = make_roller(radius, 1440, 7);
    bodies_rotate_mesh(&floor, angle);
    for (size_t i = 0; i < ball.vertex_count; i++) {
        ball.positions[3 * i] += (radius + c) * sin(angle);
        ball.positions[3 * i + 2] += (radius + c) * cos(angle);
    }
    tulle_body const body = {.is_dynamic = 1, .density = 1000.0};
    bodies_add_obstacle(world, &floor, 0.8, NULL);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &ball, 0.8, &body);
    uint64_t rescues = 0, substeps = 0;
    for (int i = 0; i < 90; i++) {
        tulle_step_report const report = bodies_step(world);
        rescues += report.rescue_component_scalings + report.rescue_global_scalings;
        substeps += report.substeps;
    }
    tulle_transform const end = bodies_get_transform(world, id);
    double const speed = hypot(end.velocity[0], end.velocity[2]);
    double const share = end.inertia[4] / (end.mass * radius * radius); /* 2/5 of a true ball */
    double const expected = 9.81 * sin(angle) / (1.0 + share);
    double const of_true_ball = 5.0 / 7.0 * 9.81 * sin(angle);
    print_message("ball: speed %.5g m/s (%.5g; true ball %.5g), spin %.5g, rescues %d, "
                  "substeps %d\n",
                  speed, expected, of_true_ball, end.angular_velocity[1], (int)rescues,
                  (int)substeps);
    assert_true(fabs(speed - expected) < 0.01 * expected);
    assert_true(fabs(speed - of_true_ball) < 0.01 * of_true_ball);
    assert_true(fabs(end.angular_velocity[1] * radius - speed) < 0.01 * speed);
    assert_int_equal(rescues, 0);
    free(ball.positions);
    free(ball.triangles);
    tulle_mesh_destroy(&floor);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_follow_the_integrator),
        cmocka_unit_test(free_fall_of_implicit_euler),
        cmocka_unit_test(damped_bodies_fall),
        cmocka_unit_test(top_keeps_spin_and_energy),
        cmocka_unit_test(box_sticks_and_slides),
        cmocka_unit_test(ball_rolls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
