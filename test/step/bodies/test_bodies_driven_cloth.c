/* Bodies that are driven or locked, with what they touch: as rails they are like obstacles on a
 * script, for cloth and for other bodies. */
#include "support/body_world.h"
#include "support/paper_options.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */

static void fine(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("%s", error->message);
}

/* What holds the table: it stands or moves on a script, or is a body that is locked or driven. */
typedef enum table_kind { TABLE_SCRIPTED, TABLE_LOCKED, TABLE_DRIVEN } table_kind;

typedef struct table_world {
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id table;
    tulle_mesh sheet, top;
} table_world;

/* A sheet above a table that goes sideways with `speed` [m/s]. */
static table_world make_table(table_kind kind, double speed, int threads) {
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = 0.005;
    def.quality = TULLE_QUALITY_EXACT;
    change_paper(&def)->cg_tolerance = 1e-10;
    def.threads = threads;
    table_world made = {.world = bodies_make_world(&def, false),
                        .sheet = small_sheet(0.2, 9, 0.01),
                        .top = bodies_make_box(0.4, 0.4, 0.1, (double[]){0.0, 0.0, -0.05})};
    tulle_error error = {0};
    made.cloth = bodies_add_cloth(made.world, &made.sheet, 0.3, 0);
    tulle_obstacle_def table = tulle_obstacle_def_default();
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {10.0, {10.0 * speed, 0.0, 0.0}, {0, 0, 0}}};
    table.mesh = tulle_mesh_get_view(&made.top);
    table.friction = 0.5;
    if (kind == TABLE_SCRIPTED)
        table.motion = (tulle_motion){.keys = keys, .key_count = 2};
    else
        table.body = (tulle_body){.is_dynamic = 1, .mass = 1.0};
    fine(tulle_world_add_obstacle(made.world, &table, &made.table, &error), &error);
    fine(tulle_world_start(made.world, &error), &error);
    if (kind == TABLE_LOCKED)
        fine(tulle_obstacle_set_locks(made.world, made.table, TULLE_LOCK_ALL, TULLE_LOCK_ALL,
                                      &error),
             &error);
    return made;
}

static void step_table(table_world *self, table_kind kind, double speed) {
    tulle_error error = {0};
    if (kind == TABLE_DRIVEN) {
        tulle_body_drive drive = tulle_body_drive_default();
        for (int k = 0; k < 3; k++) drive.stiffness[k] = drive.angular_stiffness[k] = 1e10;
        drive.position[0] = speed * (tulle_world_get_time(self->world) + STEP);
        drive.position[2] = -0.05;
        fine(tulle_obstacle_set_drive(self->world, self->table, &drive, &error), &error);
    }
    fine(tulle_world_step(self->world, STEP, NULL, &error), &error);
}

static void destroy_table(table_world *self) {
    tulle_world_destroy(self->world);
    tulle_mesh_destroy(&self->sheet);
    tulle_mesh_destroy(&self->top);
}

/* How far two sheets come from each other [m] within `count` steps. */
static double compare(table_world *a, table_kind kind_a, table_world *b, table_kind kind_b,
                      double speed, int count) {
    double worst = 0.0;
    for (int i = 0; i < count; i++) {
        step_table(a, kind_a, speed);
        step_table(b, kind_b, speed);
        size_t n;
        const double *const x = tulle_cloth_get_positions(a->world, a->cloth, &n);
        const double *const y = tulle_cloth_get_positions(b->world, b->cloth, NULL);
        for (size_t k = 0; k < 3 * n; k++) worst = fmax(worst, fabs(x[k] - y[k]));
    }
    return worst;
}

static void a_locked_body_is_an_obstacle_to_cloth(void **state) {
    (void)state;
    table_world a = make_table(TABLE_SCRIPTED, 0.0, 1), b = make_table(TABLE_LOCKED, 0.0, 1);
    double const worst = compare(&a, TABLE_SCRIPTED, &b, TABLE_LOCKED, 0.0, 64);
    double of_a[3], of_b[3], moment[3];
    tulle_error error = {0};
    fine(tulle_obstacle_get_contact_impulse(a.world, a.table, of_a, moment, &error), &error);
    fine(tulle_obstacle_get_contact_impulse(b.world, b.table, of_b, moment, &error), &error);
    print_message("sheet on a locked table: %.2g m from that on an obstacle; %.6g and %.6g N\n",
                  worst, of_b[2] / STEP, of_a[2] / STEP);
    assert_true(worst < 1e-6);
    assert_true(of_a[2] < 0.0 && fabs(of_a[2] - of_b[2]) < 1e-4 * fabs(of_a[2]));
    destroy_table(&a);
    destroy_table(&b);
}

static void a_drive_is_a_rail_to_cloth(void **state) {
    (void)state;
    double const speed = 0.3;
    table_world a = make_table(TABLE_SCRIPTED, speed, 1), b = make_table(TABLE_DRIVEN, speed, 1);
    double const worst = compare(&a, TABLE_SCRIPTED, &b, TABLE_DRIVEN, speed, 64);
    print_message("sheet on a driven table: %.2g m from that on a script\n", worst);
    assert_true(worst < 1e-4);
    destroy_table(&a);
    destroy_table(&b);
}

static void threads_change_no_bit(void **state) {
    (void)state;
    table_world a = make_table(TABLE_DRIVEN, 0.5, 1), b = make_table(TABLE_DRIVEN, 0.5, 3);
    for (int i = 0; i < 40; i++) {
        step_table(&a, TABLE_DRIVEN, 0.5);
        step_table(&b, TABLE_DRIVEN, 0.5);
        assert_true(tulle_world_get_state_hash(a.world) == tulle_world_get_state_hash(b.world));
    }
    destroy_table(&a);
    destroy_table(&b);
}

/* A box on a platform that is driven upwards with a constant force, turns locked: both gain speed
 * as Newton has it, and the box presses with its share. No substep is refused for the energy. */
static void a_lift_gives_what_newton_says(void **state) {
    (void)state;
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh plate = bodies_make_box(1.0, 1.0, 0.1, (double[]){0.0, 0.0, -0.05});
    tulle_mesh box = bodies_make_box(0.2, 0.2, 0.2, (double[]){0.1, 0.0, 0.1045});
    tulle_body body = {.is_dynamic = 1, .mass = 3.0};
    tulle_obstacle_id const lift = bodies_add_obstacle(world, &plate, 0.5, &body);
    body.mass = 2.0;
    tulle_obstacle_id const load = bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_error error = {0};
    fine(tulle_world_start(world, &error), &error);
    fine(tulle_obstacle_set_locks(world, lift, TULLE_LOCK_X | TULLE_LOCK_Y, TULLE_LOCK_ALL, &error),
         &error);
    tulle_body_drive drive = tulle_body_drive_default();
    drive.position[2] = 100.0;
    drive.stiffness[2] = 1e4;
    drive.force_limit[2] = 60.0;
    fine(tulle_obstacle_set_drive(world, lift, &drive, &error), &error);
    double const rise = (60.0 - 5.0 * 9.81) / 5.0;
    double worst = 0.0;
    for (int i = 0; i < 60; i++) {
        double const before = bodies_get_transform(world, lift).velocity[2];
        tulle_step_report const report = bodies_step_by(world, STEP);
        assert_int_equal(report.substeps, 1);
        double force[3], torque[3], impulse[3], moment[3];
        fine(tulle_obstacle_get_drive_force(world, lift, force, torque, &error), &error);
        fine(tulle_obstacle_get_contact_impulse(world, load, impulse, moment, &error), &error);
        assert_true(force[2] == 60.0);
        if (i < 10) continue; /* the box settles */
        tulle_transform const now = bodies_get_transform(world, lift);
        worst = fmax(worst, fabs((now.velocity[2] - before) / STEP - rise) / rise);
        worst = fmax(worst, fabs(impulse[2] / STEP - 2.0 * (9.81 + rise)) / (2.0 * 9.81));
        assert_true(now.position[0] == bodies_get_transform(world, lift).position[0]);
    }
    print_message("a lift with 60 N: off by %.2g of its acceleration and load\n", worst);
    assert_true(worst < 1e-6);
    tulle_mesh_destroy(&plate);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
}

/* Two boxes stand nearer than the contact distance, and are locked along what would part them: as
 * between two obstacles nothing pushes, and one slides along the other on its rail. */
static void rails_pass_each_other(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.gravity[2] = 0.0;
    tulle_world *const world = bodies_make_world(&def, true);
    tulle_mesh meshes[2] = {bodies_make_box(0.2, 0.2, 0.2, (double[]){0.0, 0.0, 0.0}),
                            bodies_make_box(0.2, 0.2, 0.2, (double[]){-0.1, 0.203, 0.0})};
    tulle_body const body = {.is_dynamic = 1, .mass = 1.0};
    tulle_obstacle_id const post = bodies_add_obstacle(world, &meshes[0], 0.5, &body);
    tulle_obstacle_id const cart = bodies_add_obstacle(world, &meshes[1], 0.5, &body);
    tulle_error error = {0};
    fine(tulle_world_start(world, &error), &error);
    fine(tulle_obstacle_set_locks(world, post, TULLE_LOCK_ALL, TULLE_LOCK_ALL, &error), &error);
    fine(tulle_obstacle_set_locks(world, cart, TULLE_LOCK_Y | TULLE_LOCK_Z, TULLE_LOCK_ALL, &error),
         &error);
    fine(tulle_obstacle_set_velocity(world, cart, (double[]){1.0, 0.0, 0.0}, NULL, &error), &error);
    for (int i = 0; i < 64; i++) {
        bodies_step_by(world, STEP);
        tulle_transform const now = bodies_get_transform(world, cart);
        assert_true(fabs(now.velocity[0] - 1.0) < 1e-12);
        assert_true(now.position[1] == bodies_get_transform(world, cart).position[1]);
    }
    assert_int_equal(bodies_judge(world, NULL, 0, meshes, 2), 0);
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&meshes[k]);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_locked_body_is_an_obstacle_to_cloth),
        cmocka_unit_test(a_drive_is_a_rail_to_cloth),
        cmocka_unit_test(threads_change_no_bit),
        cmocka_unit_test(a_lift_gives_what_newton_says),
        cmocka_unit_test(rails_pass_each_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
