/* Hard rows by themselves: what a row failed by, its multiplier after a solve, whether it sticks or
 * slides, and its matrix, against the formulas of hard_rows.c on a row of one vertex. */
#include "contact/solve/hard_rows.h"
#include "support/test_support.h"

#include <math.h>

enum { COUNT = 4 };
static const double STIFFNESS = 8.0, SLIP_PENALTY = 5.0; /* [kg] */
static const double FRICTION = 0.5;
static const double SPEED = 0.01; /* [m/s] that the row asks for */

/* Along z, between a vertex and a triangle that stands still. */
static contact_row make_row(void) {
    return (contact_row){
        .frame = {.normal = {0.0, 0.0, 1.0},
                  .vertices = {0, 1, 2, 3},
                  .weights = {1.0, -0.5, -0.25, -0.25}},
        .solve = {.inverse_mass = 1.0,
                  .friction_cap = -1.0,
                  .stiffness = STIFFNESS,
                  .slip_penalty = SLIP_PENALTY},
        .law = {
            .bias = SPEED, .friction = FRICTION, .friction_along = 1.0, .friction_across = 1.0}};
}

static void assert_vector(vec3 found, double x, double y, double z) {
    if (!(vec3_norm(vec3_sub(found, vec3_make(x, y, z))) < 1e-14))
        fail_msg("(%.17g %.17g %.17g) is not (%.17g %.17g %.17g)", found.x, found.y, found.z, x, y,
                 z);
}

static void assert_close(double found, double expected) {
    if (!(fabs(found - expected) < 1e-14)) fail_msg("%.17g is not %.17g", found, expected);
}

static void a_row_fails_by_what_it_lacks(void **state) {
    (void)state;
    double u[3 * COUNT] = {0.0, 0.0, 0.004};
    contact_row row = make_row();
    assert_close(harden_if_violated(&row, u), SPEED - 0.004);
    assert_true(row.solve.is_hard);
    row = make_row();
    u[2] = SPEED - 1e-6; /* too little to mind */
    assert_close(harden_if_violated(&row, u), 1e-6);
    assert_false(row.solve.is_hard);
    u[2] = 0.03; /* faster than asked for: fine, unless the row pushes */
    assert_true(harden_if_violated(&row, u) == 0.0);
    assert_false(row.solve.is_hard);
    row.solve.impulse.z = 0.1;
    assert_close(harden_if_violated(&row, u), 0.03 - SPEED);
    assert_true(row.solve.is_hard);
    /* In the matrix it pushes by 0.1 - 8 * 0.02 N s, which is a pull. */
    row.solve.is_in_matrix = true;
    row.solve.impulse.z = 0.1;
    assert_close(harden_if_violated(&row, u), (STIFFNESS * 0.02 - 0.1) / STIFFNESS);
    row.solve.impulse.z = 0.2;
    assert_close(harden_if_violated(&row, u), 0.02);
    /* Rows that a solve of cloth cannot mend do not become hard. */
    row = make_row();
    row.frame.is_without_cloth = true;
    u[2] = 0.0;
    assert_close(harden_if_violated(&row, u), SPEED);
    assert_false(row.solve.is_hard);
    row.frame.is_without_cloth = false;
    row.solve.stiffness = 0.0;
    assert_close(harden_if_violated(&row, u), SPEED);
    assert_false(row.solve.is_hard);
}

/* A row that was hard, between vertices of these inverse masses [1/kg]. */
static contact_row prepare_row(double inverse_mass) {
    double const inverse_masses[COUNT] = {inverse_mass, 0.0, 0.0, 0.0};
    double const u[3 * COUNT] = {0.0, 0.0, SPEED};
    double diagonal[9 * COUNT] = {0.0};
    for (size_t i = 0; i < 3; i++) diagonal[4 * i] = 2.0;
    contact_scene const scene = {.inverse_mass = inverse_masses,
                                 .cloth_vertex_count = COUNT,
                                 .vertex_count = COUNT,
                                 .settings = {.hard_stiffness = 3.0, .hard_friction = 0.5}};
    contact_row row = make_row();
    row.solve.is_hard = true;
    prepare_hard_rows(&scene, diagonal, &row, 1, u);
    return row;
}

/* A row that was hard in the step before is so again, unless nothing of it can move. */
static void only_what_moves_is_hard(void **state) {
    (void)state;
    contact_row const moving = prepare_row(1.0), held = prepare_row(0.0);
    assert_true(moving.solve.is_hard && !held.solve.is_hard);
    assert_close(moving.solve.stiffness, 3.0 * 2.0); /* over 1 / (2 kg) */
    assert_close(moving.solve.slip_penalty, 0.5 * 6.0);
    assert_true(held.solve.stiffness == 0.0);
}

/* A row in the matrix, with a multiplier of 0.2 N s and friction of 0.01 N s. */
static contact_row make_pushing_row(void) {
    contact_row row = make_row();
    row.solve.is_hard = row.solve.is_in_matrix = true;
    row.solve.state = ROW_STICKS;
    row.solve.impulse = vec3_make(0.01, 0.0, 0.2);
    return row;
}

static void a_row_that_holds_grows_by_its_slip(void **state) {
    (void)state;
    double const u[3 * COUNT] = {0.003, 0.001, SPEED - 0.005};
    contact_row row = make_pushing_row();
    row.law.return_velocity = vec3_make(0.001, 0.0, 0.0);
    row.solve.slip_pull = 2.0;                          /* [kg] the solve reckoned with this, */
    row.solve.slip_target = vec3_make(0.0, 0.002, 0.0); /* from here */
    vec3 const misfit = update_hard_row(&row, u);
    double const x = 0.01 - SLIP_PENALTY * 0.002, y = -SLIP_PENALTY * 0.001;
    assert_vector(row.solve.impulse, x, y, 0.2 + STIFFNESS * 0.005);
    assert_vector(misfit, x - (0.01 - 2.0 * 0.003), y - (-2.0 * -0.001), 0.0);
    assert_close(row.solve.friction_cap, 0.2 + STIFFNESS * 0.005);
    assert_int_equal(row.solve.state, ROW_STICKS);
    assert_true(row.solve.slip_pull == SLIP_PENALTY);
    assert_vector(row.solve.slip_free, 0.0, 0.0, 0.0);
    assert_vector(row.solve.slip_target, 0.001, 0.0, 0.0);
    assert_true(row.solve.is_hard);
}

static void a_row_over_its_bound_slides(void **state) {
    (void)state;
    double const u[3 * COUNT] = {0.0, 0.05, SPEED};
    contact_row row = make_pushing_row();
    row.solve.impulse.x = 0.0;
    (void)update_hard_row(&row, u);
    double const bound = FRICTION * 0.2, trial = SLIP_PENALTY * 0.05;
    assert_vector(row.solve.impulse, 0.0, -bound, 0.2);
    assert_int_equal(row.solve.state, ROW_SLIDES);
    assert_vector(row.solve.slip_free, 0.0, -1.0, 0.0);
    assert_vector(row.solve.slip_target, 0.0, 0.05, 0.0);
    assert_close(row.solve.slip_pull, SLIP_PENALTY * bound / (bound + (trial - bound)));
    /* The next solve turns it back: it holds, with the friction that it had. */
    double const back[3 * COUNT] = {0.0, -0.07, SPEED};
    (void)update_hard_row(&row, back);
    assert_vector(row.solve.impulse, 0.0, -bound, 0.2);
    assert_int_equal(row.solve.state, ROW_STICKS);
    assert_true(row.solve.slip_pull == SLIP_PENALTY);
}

static void a_row_that_pulls_opens(void **state) {
    (void)state;
    double const u[3 * COUNT] = {0.0, 0.0, SPEED + 0.03};
    contact_row row = make_pushing_row();
    (void)update_hard_row(&row, u);
    assert_vector(row.solve.impulse, 0.0, 0.0, 0.0);
    assert_true(row.solve.friction_cap == 0.0);
    assert_int_equal(row.solve.state, ROW_OPEN);
    assert_false(row.solve.is_hard);
}

/* [N s] The row's matrix times a velocity. */
static vec3 pull(const contact_row *row, double x, double y, double z) {
    return mat3_multiply_vec3(&row->solve.pull, vec3_make(x, y, z));
}

static void a_new_row_holds_unless_it_comes_with_slip(void **state) {
    (void)state;
    double u[3 * COUNT] = {0.5 * default_contact_settings.slip_speed};
    contact_row row = make_row();
    row.solve.impulse.z = 0.2;
    make_pull(&default_contact_settings, &row, u);
    assert_int_equal(row.solve.state, ROW_STICKS);
    assert_true(row.solve.friction_cap == 0.2);
    assert_vector(pull(&row, 1.0, 0.0, 0.0), SLIP_PENALTY, 0.0, 0.0);
    assert_vector(pull(&row, 0.0, 0.0, 1.0), 0.0, 0.0, STIFFNESS);
    /* Fast, it slides against its slip; the matrix lets it go on along that. */
    u[0] = 0.05;
    row = make_row();
    row.solve.impulse.z = 0.2;
    make_pull(&default_contact_settings, &row, u);
    assert_int_equal(row.solve.state, ROW_SLIDES);
    assert_vector(row.solve.impulse, -FRICTION * 0.2, 0.0, 0.2);
    assert_vector(pull(&row, 1.0, 0.0, 0.0), 0.0, 0.0, 0.0);
    double const across = SLIP_PENALTY * (FRICTION * 0.2) / (SLIP_PENALTY * 0.05);
    assert_vector(pull(&row, 0.0, 1.0, 0.0), 0.0, across, 0.0);
    assert_vector(pull(&row, 0.0, 0.0, 1.0), 0.0, 0.0, STIFFNESS);
    /* One that stuck in the step before holds however fast it comes. */
    row = make_row();
    row.solve.impulse = vec3_make(0.02, 0.0, 0.2);
    row.solve.state = ROW_STICKS;
    make_pull(&default_contact_settings, &row, u);
    assert_int_equal(row.solve.state, ROW_STICKS);
    assert_vector(row.solve.impulse, 0.02, 0.0, 0.2);
    /* Without friction it slides and feels no slip. */
    row = make_row();
    row.law.friction = 0.0;
    row.solve.impulse.z = 0.2;
    make_pull(&default_contact_settings, &row, u);
    assert_int_equal(row.solve.state, ROW_SLIDES);
    assert_vector(pull(&row, 0.0, 1.0, 0.0), 0.0, 0.0, 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_fails_by_what_it_lacks),
        cmocka_unit_test(only_what_moves_is_hard),
        cmocka_unit_test(a_row_that_holds_grows_by_its_slip),
        cmocka_unit_test(a_row_over_its_bound_slides),
        cmocka_unit_test(a_row_that_pulls_opens),
        cmocka_unit_test(a_new_row_holds_unless_it_comes_with_slip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
