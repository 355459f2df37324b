/* Bodies that the host drives: forces, locks and drives against closed forms, and what contact
 * gives obstacles. */
#include "base/hash.h"
#include "support/body_world.h"
#include "support/test_support.h"
#include "tulle/tulle.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static const unsigned ALL = TULLE_LOCK_ALL;

static void fine(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("%s", error->message);
}

static void expect_near(double value, double wanted, double most) {
    if (!(fabs(value - wanted) <= most))
        fail_msg("%.17g is no %.17g: %.3g off, at most %.3g", value, wanted, value - wanted, most);
}

/* A world without gravity or with it, and a box of 0.2 x 0.3 x 0.4 m and 2 kg in it. */
typedef struct box_world {
    tulle_world *world;
    tulle_obstacle_id box;
} box_world;

static const double MASS = 2.0;

static box_world make_box_world(double gravity, tulle_integrator integrator) {
    tulle_world_def def = tulle_world_def_default();
    def.gravity[2] = gravity;
    def.integrator = integrator;
    box_world made = {bodies_make_world(&def, true), {0}};
    tulle_mesh box = bodies_make_box(0.2, 0.3, 0.4, (double[3]){0.5, 0.25, 1.0});
    tulle_body const body = {.is_dynamic = 1, .mass = MASS};
    made.box = bodies_add_obstacle(made.world, &box, 0.5, &body);
    tulle_mesh_destroy(&box);
    tulle_error error = {0};
    fine(tulle_world_start(made.world, &error), &error);
    return made;
}

static void set_drive(box_world *self, const tulle_body_drive *drive) {
    tulle_error error = {0};
    fine(tulle_obstacle_set_drive(self->world, self->box, drive, &error), &error);
}

static void set_locks(box_world *self, unsigned translations, unsigned rotations) {
    tulle_error error = {0};
    fine(tulle_obstacle_set_locks(self->world, self->box, translations, rotations, &error), &error);
}

static double get_drive_force(const box_world *self, int axis) {
    double force[3], torque[3];
    assert_int_equal(tulle_obstacle_get_drive_force(self->world, self->box, force, torque, NULL),
                     TULLE_OK);
    return axis < 3 ? force[axis] : torque[axis - 3];
}

/* A force of one step moves a free body by implicit Euler; the next step knows nothing of it. */
static void forces_act_for_one_step(void **state) {
    (void)state;
    box_world self = make_box_world(0.0, TULLE_INTEGRATOR_IMPLICIT_EULER);
    tulle_error error = {0};
    tulle_transform const start = bodies_get_transform(self.world, self.box);
    double const velocity[3] = {0.25, 0.0, -0.5}, force[3] = {3.0, -1.0, 2.0};
    fine(tulle_obstacle_set_velocity(self.world, self.box, velocity, NULL, &error), &error);
    for (int k = 0; k < 2; k++) /* they add up */
        fine(tulle_obstacle_add_force(self.world, self.box, NULL, force, &error), &error);
    for (int i = 1; i <= 2; i++) {
        bodies_step_by(self.world, STEP);
        tulle_transform const now = bodies_get_transform(self.world, self.box);
        for (int k = 0; k < 3; k++) {
            double const gained = 2.0 * force[k] * STEP / MASS;
            double const way = i * STEP * velocity[k] + gained * STEP * i;
            expect_near(now.velocity[k], velocity[k] + gained, 1e-14);
            expect_near(now.position[k], start.position[k] + way, 1e-14);
        }
    }
    tulle_world_destroy(self.world);
}

/* A torque about a principal axis, and a force off the centre, turn the box. */
static void torques_turn(void **state) {
    (void)state;
    box_world self = make_box_world(0.0, TULLE_INTEGRATOR_IMPLICIT_EULER);
    tulle_error error = {0};
    tulle_transform const start = bodies_get_transform(self.world, self.box);
    double const point[3] = {start.position[0] + 0.1, start.position[1], start.position[2]};
    double const force[3] = {0.0, 4.0, 0.0}, torque[3] = {0.0, 0.0, 0.25};
    fine(tulle_obstacle_add_force(self.world, self.box, point, force, &error), &error);
    fine(tulle_obstacle_add_torque(self.world, self.box, torque, &error), &error);
    bodies_step_by(self.world, STEP);
    tulle_transform const now = bodies_get_transform(self.world, self.box);
    double const inertia = MASS * (0.04 + 0.09) / 12.0;
    expect_near(now.angular_velocity[2], (0.1 * 4.0 + 0.25) * STEP / inertia, 1e-12);
    expect_near(now.velocity[1], 4.0 * STEP / MASS, 1e-14);
    tulle_world_destroy(self.world);
}

/* The exact solution of backward Euler for m x'' = k (x* - x) + d (v* - x') + m g. */
static void a_drive_is_a_spring_and_a_damper(void **state) {
    (void)state;
    static const struct {
        double stiffness, damping;
    } cases[] = {{200.0, 5.0}, {0.0, 30.0}, {1e5, 1e3}, {1e12, 0.0}, {0.0, 1e12}, {1e12, 1e12}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        double const stiffness = cases[c].stiffness, damping = cases[c].damping;
        box_world self = make_box_world(-9.8125, TULLE_INTEGRATOR_IMPLICIT_EULER);
        tulle_body_drive drive = tulle_body_drive_default();
        double const target[3] = {0.75, 0.0, 1.5}, speed[3] = {0.5, 0.0, -0.25};
        double x[3], v[3] = {0.0, 0.0, 0.0};
        memcpy(x, bodies_get_transform(self.world, self.box).position, sizeof x);
        for (int k = 0; k < 3; k++) {
            drive.position[k] = target[k];
            drive.velocity[k] = speed[k];
            drive.stiffness[k] = stiffness;
            drive.damping[k] = damping;
        }
        set_drive(&self, &drive);
        double worst = 0.0, worst_force = 0.0;
        for (int i = 0; i < 60; i++) {
            bodies_step_by(self.world, STEP);
            tulle_transform const now = bodies_get_transform(self.world, self.box);
            for (int k = 0; k < 3; k++) {
                double const gain = STEP * (damping + STEP * stiffness);
                double const push = STEP * (stiffness * (target[k] - x[k]) + damping * speed[k]);
                double const fall = k == 2 ? -9.8125 * STEP : 0.0;
                double const before = v[k];
                v[k] = (MASS * (v[k] + fall) + push) / (MASS + gain);
                x[k] += STEP * v[k];
                double const force = MASS * (v[k] - before - fall) / STEP;
                worst =
                    fmax(worst, fmax(fabs(now.position[k] - x[k]), fabs(now.velocity[k] - v[k])));
                worst_force = fmax(worst_force, fabs(get_drive_force(&self, k) - force));
            }
        }
        /* what gains of 1e12 leave of a difference of two impulses */
        double const slack = 1e-16 * fmax(stiffness, damping);
        print_message("drive of %g N/m, %g N s/m: off by %.2g, its force by %.2g N\n", stiffness,
                      damping, worst, worst_force);
        assert_true(worst < 1e-12);
        assert_true(worst_force < 1e-9 + slack);
        tulle_world_destroy(self.world);
    }
}

/* The same for the turn about a principal axis, by less than half a turn. */
static void a_drive_turns(void **state) {
    (void)state;
    box_world self = make_box_world(0.0, TULLE_INTEGRATOR_IMPLICIT_EULER);
    tulle_body_drive drive = tulle_body_drive_default();
    double const target = 1.25, inertia = MASS * (0.04 + 0.09) / 12.0;
    double const stiffness = 3.0, damping = 0.125;
    drive.rotation[0] = cos(0.5 * target);
    drive.rotation[3] = sin(0.5 * target);
    for (int k = 0; k < 3; k++) {
        drive.angular_stiffness[k] = stiffness;
        drive.angular_damping[k] = damping;
    }
    set_drive(&self, &drive);
    double angle = 0.0, rate = 0.0, worst = 0.0;
    for (int i = 0; i < 40; i++) {
        tulle_step_report const report = bodies_step_by(self.world, STEP / 8.0);
        assert_int_equal(report.substeps, 1);
        double const h = STEP / 8.0;
        rate = (inertia * rate + h * stiffness * (target - angle)) /
               (inertia + h * (damping + h * stiffness));
        angle += h * rate;
        tulle_transform const now = bodies_get_transform(self.world, self.box);
        worst = fmax(worst, fabs(now.angular_velocity[2] - rate));
        expect_near(now.angular_velocity[0], 0.0, 1e-12);
    }
    print_message("turning drive: off by %.2g rad/s of %.3g\n", worst, rate);
    /* the turn itself is of fourth order in the step */
    assert_true(worst < 1e-5);
    tulle_world_destroy(self.world);
}

/* Drives stay at rest with any gains, by every integrator, and keep their limit. */
static void drives_are_stable(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++) {
        for (int is_limited = 0; is_limited < 2; is_limited++) {
            box_world self = make_box_world(-9.8125, (tulle_integrator)integrator);
            tulle_body_drive drive = tulle_body_drive_default();
            double const turn[4] = {0.8, 0.6, 0.0, 0.0};
            memcpy(drive.rotation, turn, sizeof turn);
            for (int k = 0; k < 3; k++) {
                drive.position[k] = 0.5;
                drive.stiffness[k] = drive.angular_stiffness[k] = 1e6;
                drive.damping[k] = drive.angular_damping[k] = 1e5;
                if (is_limited) drive.force_limit[k] = 30.0, drive.torque_limit[k] = 0.125;
            }
            set_drive(&self, &drive);
            double most[2] = {0.0, 0.0};
            for (int i = 0; i < 400; i++) {
                bodies_step_by(self.world, STEP);
                for (int k = 0; k < 6; k++)
                    most[k / 3] = fmax(most[k / 3], fabs(get_drive_force(&self, k)));
            }
            tulle_transform const end = bodies_get_transform(self.world, self.box);
            if (is_limited) { /* exactly */
                assert_true(most[0] == 30.0);
                assert_true(most[1] == 0.125);
            }
            for (int k = 0; k < 3; k++) expect_near(end.position[k], 0.5, 1e-3);
            for (int k = 0; k < 4; k++) expect_near(end.rotation[k], turn[k], 1e-2);
            tulle_world_destroy(self.world);
        }
    }
}

/* With a limit the box speeds up and brakes as constant forces have it. */
static void the_limit_is_a_constant_force(void **state) {
    (void)state;
    box_world self = make_box_world(0.0, TULLE_INTEGRATOR_IMPLICIT_EULER);
    tulle_body_drive drive = tulle_body_drive_default();
    drive.position[0] = 1000.0;
    drive.stiffness[0] = 1e6;
    drive.force_limit[0] = 3.0;
    set_drive(&self, &drive);
    for (int i = 1; i <= 30; i++) {
        bodies_step_by(self.world, STEP);
        tulle_transform const now = bodies_get_transform(self.world, self.box);
        expect_near(now.velocity[0], i * STEP * 3.0 / MASS, 1e-12);
        assert_true(get_drive_force(&self, 0) == 3.0);
    }
    tulle_world_destroy(self.world);
}

/* Locked coordinates keep their bits; what is free answers as the closed form of a hinge or a rail
 * has it. */
static void locks_are_exact(void **state) {
    (void)state;
    double const impulse[3] = {3.0, 4.0, 5.0}; /* at a corner */
    double const inertia = MASS * (0.04 + 0.09) / 12.0;
    for (int kind = 0; kind < 3; kind++) {
        box_world self = make_box_world(-9.8125, TULLE_INTEGRATOR_IMPLICIT_EULER);
        tulle_error error = {0};
        size_t count;
        bodies_step_by(self.world, STEP); /* falls and turns by then */
        fine(tulle_obstacle_set_velocity(self.world, self.box, NULL, (double[3]){2, 1, -3}, &error),
             &error);
        bodies_step_by(self.world, STEP);
        unsigned const translations[3] = {ALL, TULLE_LOCK_Y | TULLE_LOCK_Z, ALL};
        unsigned const rotations[3] = {ALL, ALL, TULLE_LOCK_X | TULLE_LOCK_Y};
        set_locks(&self, translations[kind], rotations[kind]);
        tulle_transform const start = bodies_get_transform(self.world, self.box);
        const double *x = tulle_obstacle_get_positions(self.world, self.box, &count);
        double before[24], corner[3];
        assert_int_equal(count, 8);
        memcpy(before, x, sizeof before);
        memcpy(corner, x, sizeof corner);
        fine(tulle_obstacle_set_velocity(self.world, self.box, (double[3]){0, 0, 0},
                                         (double[3]){0, 0, 0}, &error),
             &error);
        fine(tulle_obstacle_add_impulse(self.world, self.box, corner, impulse, &error), &error);
        fine(tulle_obstacle_add_force(self.world, self.box, corner, (double[3]){0, 7, 7}, &error),
             &error);
        tulle_transform const hit = bodies_get_transform(self.world, self.box);
        if (kind == 2) { /* a hinge along z */
            const double *const i = start.inertia;
            double const moment = (corner[0] - start.position[0]) * impulse[1] -
                                  (corner[1] - start.position[1]) * impulse[0];
            expect_near(hit.angular_velocity[2], moment / i[8], 1e-12);
            assert_true(fabs(i[8] - inertia) < 0.05); /* it has turned a little before */
        }
        for (int n = 0; n < 50; n++) bodies_step_by(self.world, STEP);
        tulle_transform const now = bodies_get_transform(self.world, self.box);
        x = tulle_obstacle_get_positions(self.world, self.box, NULL);
        for (int k = 0; k < 3; k++) {
            if (translations[kind] >> k & 1u) assert_true(now.position[k] == start.position[k]);
            if (rotations[kind] >> k & 1u) assert_true(now.angular_velocity[k] == 0.0);
        }
        if (kind == 0) assert_memory_equal(x, before, sizeof before);
        if (kind == 1) {
            expect_near(now.velocity[0], impulse[0] / MASS, 1e-14);
            for (int v = 0; v < 8; v++) {
                expect_near(x[3 * v + 1], before[3 * v + 1], 1e-15);
                expect_near(x[3 * v + 2], before[3 * v + 2], 1e-15);
            }
        }
        if (kind == 2) {
            assert_true(fabs(now.angular_velocity[2]) > 1.0);
            for (int v = 0; v < 8; v++) expect_near(x[3 * v + 2], before[3 * v + 2], 1e-13);
        }
        tulle_world_destroy(self.world);
    }
}

/* A finger on a rail squeezes a box against a wall: when all is at rest, the wall and the box feel
 * the limit of its drive; on the way there nothing gives more. */
static void a_finger_squeezes_with_its_limit(void **state) {
    (void)state;
    for (int is_obstacle = 0; is_obstacle < 2; is_obstacle++) {
        tulle_world_def def = tulle_world_def_default();
        def.gravity[2] = 0.0;
        tulle_world *const world = bodies_make_world(&def, true);
        tulle_body const body = {.is_dynamic = 1, .mass = 0.5};
        tulle_mesh meshes[3] = {bodies_make_box(0.1, 0.4, 0.4, (double[3]){0.3, 0.0, 0.0}),
                                bodies_make_box(0.1, 0.1, 0.1, (double[3]){0.15, 0.0, 0.0}),
                                bodies_make_box(0.1, 0.1, 0.1, (double[3]){-0.1, 0.0, 0.0})};
        tulle_obstacle_id const wall = bodies_add_obstacle(world, &meshes[0], 0.5, NULL);
        if (!is_obstacle) bodies_add_obstacle(world, &meshes[1], 0.5, &body);
        tulle_obstacle_id const finger = bodies_add_obstacle(world, &meshes[2], 0.5, &body);
        tulle_error error = {0};
        fine(tulle_world_start(world, &error), &error);
        fine(tulle_obstacle_set_locks(world, finger, TULLE_LOCK_Y | TULLE_LOCK_Z, ALL, &error),
             &error);
        tulle_body_drive drive = tulle_body_drive_default();
        drive.position[0] = 1.0;
        drive.stiffness[0] = 1e5;
        drive.damping[0] = 50.0;
        drive.force_limit[0] = 12.5;
        fine(tulle_obstacle_set_drive(world, finger, &drive, &error), &error);
        double impulse[3], moment[3], force[3], torque[3];
        for (int i = 0; i < 120; i++) {
            bodies_step_by(world, STEP);
            fine(tulle_obstacle_get_drive_force(world, finger, force, torque, &error), &error);
            assert_true(fabs(force[0]) <= 12.5);
        }
        fine(tulle_obstacle_get_contact_impulse(world, finger, impulse, moment, &error), &error);
        double const on_finger = impulse[0];
        fine(tulle_obstacle_get_contact_impulse(world, wall, impulse, moment, &error), &error);
        print_message("squeezed with 12.5 N: %.12g N on the finger, %.12g N on the wall\n",
                      on_finger / STEP, impulse[0] / STEP);
        assert_true(force[0] == 12.5);
        expect_near(on_finger, -12.5 * STEP, 1e-6 * 12.5 * STEP);
        expect_near(impulse[0], 12.5 * STEP, 1e-6 * 12.5 * STEP);
        for (int i = 0; i < 3; i++) tulle_mesh_destroy(&meshes[i]);
        tulle_world_destroy(world);
    }
}

/* Cloth on a table that stands, or rises evenly on a script, presses on it with its weight; the
 * moment is that of its centre of mass. So does a box that has fallen asleep. */
static void a_table_feels_the_weight(void **state) {
    (void)state;
    for (int rises = 0; rises < 2; rises++) {
        tulle_world_def def = tulle_world_def_default();
        def.contact_distance = 0.005;
        def.wind.drag_coefficient = 0.0;
        def.quality = TULLE_QUALITY_EXACT;
        tulle_world *const world = bodies_make_world(&def, false);
        tulle_mesh sheet = small_sheet(0.4, 9, 0.004);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.material.air_damping = 0.0;
        tulle_error error = {0};
        fine(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
        tulle_mesh top = bodies_make_box(1.0, 1.0, 0.1, (double[3]){0.0, 0.0, -0.05});
        tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                        {8.0, {0.0, 0.0, 1.0}, {0, 0, 0}}};
        tulle_obstacle_def table = tulle_obstacle_def_default();
        table.mesh = tulle_mesh_get_view(&top);
        table.motion = (tulle_motion){.keys = keys, .key_count = rises ? 2 : 0};
        tulle_obstacle_id id;
        fine(tulle_world_add_obstacle(world, &table, &id, &error), &error);
        for (int i = 0; i < 160; i++) bodies_step_by(world, STEP);
        double impulse[3], moment[3];
        fine(tulle_obstacle_get_contact_impulse(world, id, impulse, moment, &error), &error);
        double const weight = 9.81 * cloth.material.area_density * 0.16;
        print_message("weight on a table that %s: %.6f of %.6f N\n", rises ? "rises" : "stands",
                      -impulse[2] / STEP, weight);
        expect_near(-impulse[2] / STEP, weight, 1e-6 * weight);
        for (int k = 0; k < 2; k++) {
            expect_near(impulse[k] / STEP, 0.0, 1e-6 * weight);
            expect_near(moment[k] / STEP, 0.0, 1e-6 * weight);
        }
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&top);
        tulle_world_destroy(world);
    }
}

/* However much the air damps a body, at rest it weighs what it weighs: on a table, and at a spring,
 * by all integrators. */
static void a_damped_box_keeps_its_weight(void **state) {
    (void)state;
    tulle_body const body = {
        .is_dynamic = 1, .mass = MASS, .linear_damping = 20.0, .angular_damping = 10.0};
    for (int integrator = 0; integrator < 3; integrator++) {
        tulle_world_def def = tulle_world_def_default();
        def.integrator = (tulle_integrator)integrator;
        tulle_world *const world = bodies_make_world(&def, true);
        tulle_mesh ground = bodies_make_box(2.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1});
        tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.5, 0.25, 0.104});
        tulle_mesh other = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.0, 0.0, 1.0});
        tulle_obstacle_id const table = bodies_add_obstacle(world, &ground, 0.5, NULL);
        bodies_add_obstacle(world, &box, 0.5, &body);
        tulle_obstacle_id const hung = bodies_add_obstacle(world, &other, 0.5, &body);
        tulle_error error = {0};
        fine(tulle_world_start(world, &error), &error);
        tulle_body_drive drive = tulle_body_drive_default();
        double const stiffness = 400.0, weight = 9.81 * MASS;
        drive.position[2] = 1.0;
        drive.stiffness[2] = stiffness;
        fine(tulle_obstacle_set_drive(world, hung, &drive, &error), &error);
        for (int i = 0; i < 640; i++) bodies_step_by(world, STEP);
        double impulse[3], moment[3];
        fine(tulle_obstacle_get_contact_impulse(world, table, impulse, moment, &error), &error);
        double const height = bodies_get_transform(world, hung).position[2];
        print_message("integrator %d: a damped box of %.2f N weighs %.6f N and hangs by %.6f m\n",
                      integrator, weight, -impulse[2] / STEP, 1.0 - height);
        expect_near(-impulse[2] / STEP, weight, 1e-6 * weight);
        expect_near(moment[0] / STEP, -0.25 * weight, 1e-6 * weight);
        expect_near(1.0 - height, weight / stiffness, 1e-9);
        tulle_mesh_destroy(&ground);
        tulle_mesh_destroy(&box);
        tulle_mesh_destroy(&other);
        tulle_world_destroy(world);
    }
}

static void a_table_feels_what_sleeps_on_it(void **state) {
    (void)state;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh ground = bodies_make_box(2.0, 2.0, 0.2, (double[3]){0.0, 0.0, -0.1});
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[3]){0.5, 0.25, 0.104});
    tulle_body const body = {
        .is_dynamic = 1, .mass = MASS, .sleep_speed = 0.01, .sleep_time = 0.25};
    tulle_obstacle_id const table = bodies_add_obstacle(world, &ground, 0.5, NULL);
    tulle_obstacle_id const sleeper = bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_error error = {0};
    double const weight = 9.81 * MASS;
    int slept = 0;
    for (int i = 0; i < 100; i++) {
        bodies_step_by(world, STEP);
        slept += tulle_obstacle_is_asleep(world, sleeper);
        if (slept != 1 && slept != 20) continue;
        double impulse[3], moment[3];
        fine(tulle_obstacle_get_contact_impulse(world, table, impulse, moment, &error), &error);
        expect_near(-impulse[2] / STEP, weight, 1e-6 * weight);
        expect_near(moment[0] / STEP, -0.25 * weight, 1e-6 * weight);
        expect_near(moment[1] / STEP, 0.5 * weight, 1e-6 * weight);
    }
    assert_true(slept > 20);
    /* a body that is driven stays awake */
    tulle_body_drive drive = tulle_body_drive_default();
    drive.damping[0] = 1.0;
    fine(tulle_obstacle_set_drive(world, sleeper, &drive, &error), &error);
    for (int i = 0; i < 50; i++) bodies_step_by(world, STEP);
    assert_false(tulle_obstacle_is_asleep(world, sleeper));
    tulle_mesh_destroy(&ground);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* Locks and drives are state; forces are not, and what they did is. */
static void states_hold_locks_and_drives(void **state) {
    (void)state;
    tulle_error error = {0};
    box_world self = make_box_world(-9.8125, TULLE_INTEGRATOR_IMPLICIT_EULER);
    void *plain, *driven;
    size_t plain_size, driven_size;
    uint64_t const plain_hash = tulle_world_get_state_hash(self.world);
    fine(tulle_world_save_state(self.world, &plain, &plain_size, &error), &error);
    tulle_body_drive drive = tulle_body_drive_default();
    drive.position[0] = 2.0;
    drive.stiffness[0] = 100.0;
    drive.force_limit[0] = 5.0;
    set_drive(&self, &drive);
    set_locks(&self, TULLE_LOCK_Z, TULLE_LOCK_X);
    uint64_t const driven_hash = tulle_world_get_state_hash(self.world);
    assert_true(driven_hash != plain_hash);
    fine(tulle_world_save_state(self.world, &driven, &driven_size, &error), &error);
    fine(tulle_obstacle_add_torque(self.world, self.box, (double[3]){0, 1, 0}, &error), &error);
    assert_true(tulle_world_get_state_hash(self.world) == driven_hash);
    fine(tulle_world_load_state(self.world, driven, driven_size, &error), &error); /* lets go */
    bodies_step_by(self.world, STEP);
    assert_true(get_drive_force(&self, 0) == 5.0);
    uint64_t const went = tulle_world_get_state_hash(self.world);
    /* a fresh world goes the same way from there; one put back to the start falls */
    box_world other = make_box_world(-9.8125, TULLE_INTEGRATOR_IMPLICIT_EULER);
    fine(tulle_world_load_state(other.world, driven, driven_size, &error), &error);
    assert_true(tulle_world_get_state_hash(other.world) == driven_hash);
    assert_true(get_drive_force(&other, 0) == 0.0);
    bodies_step_by(other.world, STEP);
    assert_true(tulle_world_get_state_hash(other.world) == went);
    fine(tulle_world_load_state(self.world, plain, plain_size, &error), &error);
    assert_true(tulle_world_get_state_hash(self.world) == plain_hash);
    bodies_step_by(self.world, STEP);
    tulle_transform const now = bodies_get_transform(self.world, self.box);
    expect_near(now.velocity[2], -9.8125 * STEP, 1e-14);
    assert_true(now.velocity[0] == 0.0);
    tulle_world_free_state(self.world, plain, plain_size);
    tulle_world_free_state(self.world, driven, driven_size);
    tulle_world_destroy(self.world);
    tulle_world_destroy(other.world);
}

/* Bytes of locks and drives that no call makes are refused; the world stays as it was. */
static void crafted_drives_are_refused(void **state) {
    (void)state;
    tulle_error error = {0};
    box_world self = make_box_world(0.0, TULLE_INTEGRATOR_IMPLICIT_EULER);
    tulle_body_drive drive = tulle_body_drive_default();
    drive.stiffness[1] = 7.0;
    set_drive(&self, &drive);
    void *bytes;
    size_t size;
    fine(tulle_world_save_state(self.world, &bytes, &size, &error), &error);
    uint64_t const hash = tulle_world_get_state_hash(self.world);
    unsigned char *const control = (unsigned char *)bytes + size - sizeof(body_control);
    body_control right;
    memcpy(&right, control, sizeof right);
    assert_true(right.drive.stiffness[1] == 7.0 && right.is_driven == 1);
    for (int kind = 0; kind < 7; kind++) {
        body_control wrong = right;
        if (kind == 0) wrong.locks = 64;
        if (kind == 1) wrong.is_driven = 2;
        if (kind == 2) wrong.drive.stiffness[1] = (double)NAN;
        if (kind == 3) wrong.drive.damping[0] = -1.0;
        if (kind == 4) wrong.drive.rotation[0] = 0.5;
        if (kind == 5) wrong.drive.force_limit[2] = -1.0;
        if (kind == 6) wrong.drive.position[0] = 1e101;
        memcpy(control, &wrong, sizeof wrong);
        uint64_t const new_hash = hash_block((unsigned char *)bytes + 16, size - 16);
        memcpy((unsigned char *)bytes + 8, &new_hash, sizeof new_hash);
        assert_int_equal(tulle_world_load_state(self.world, bytes, size, &error),
                         TULLE_ERROR_PARSE);
        assert_non_null(strstr(error.message, "drives"));
        assert_true(tulle_world_get_state_hash(self.world) == hash);
    }
    tulle_world_free_state(self.world, bytes, size);
    tulle_world_destroy(self.world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_act_for_one_step),
        cmocka_unit_test(torques_turn),
        cmocka_unit_test(a_drive_is_a_spring_and_a_damper),
        cmocka_unit_test(a_drive_turns),
        cmocka_unit_test(drives_are_stable),
        cmocka_unit_test(the_limit_is_a_constant_force),
        cmocka_unit_test(locks_are_exact),
        cmocka_unit_test(a_finger_squeezes_with_its_limit),
        cmocka_unit_test(a_table_feels_the_weight),
        cmocka_unit_test(a_damped_box_keeps_its_weight),
        cmocka_unit_test(a_table_feels_what_sleeps_on_it),
        cmocka_unit_test(states_hold_locks_and_drives),
        cmocka_unit_test(crafted_drives_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
