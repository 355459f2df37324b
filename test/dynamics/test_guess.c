/* Springs linearised about a guess: at the guess itself the linear system must be the true equation
 * of implicit Euler, and excess energy must vanish. */
#include "dynamics/excess_kernel.h"
#include "dynamics/fixture.h"

#include <math.h>

/* A crumpled grid with velocities, and a random guess. Stiffening cloth has one whose strains it is
 * still linearised about. */
static fixture *make_case(double stiffening_strain, double guess[3 * 30]) {
    tulle_material material;
    assert_int_equal(tulle_material_preset("cotton", &material), TULLE_OK);
    material.springs.stiffening_strain = stiffening_strain;
    material.bend_damping = 0.0; /* its true force turns with the normal */
    grid sheet = grid_make(5, 4, 0.1, 0.08, 1);
    assert_int_equal(sheet.vertex_count, 30);
    fixture *const f = fixture_make(sheet.positions, sheet.vertex_count, sheet.triangles,
                                    sheet.triangle_count, material);
    grid_free(&sheet);
    f->surroundings.gravity = vec3_make(0.1, -9.81, 0.2);
    uint64_t random = 7;
    for (size_t i = 0; i < 3 * f->vertex_count; i++) {
        f->x[i] += 0.005 * random_signed(&random);
        f->v[i] = random_signed(&random);
        guess[i] = random_signed(&random) * (stiffening_strain > 0.0 ? 0.03 : 1.0);
    }
    return f;
}

/* Forces and system of implicit Euler. */
static void assemble(fixture *f, const cloth_start *state) {
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, 1, 0.0, true};
    assert_int_equal(
        compute_forces(&f->model, state, &f->surroundings, options, &f->scratch, &f->system),
        TULLE_OK);
}

/* The system with springs linearised about the guess. */
static void assemble_about(fixture *f, double h, const double *guess) {
    cloth_start now = fixture_state(f, h);
    now.guess = guess;
    assemble(f, &now);
}

static void check_exact_at_the_guess(double stiffening_strain) {
    double const h = 0.01;
    double u[3 * 30], residual[3 * 30];
    fixture *const f = make_case(stiffening_strain, u);
    assemble_about(f, h, u);
    block_matrix_operator matrix = {&f->system.matrix, 1};
    block_matrix_apply(&matrix, u, residual);
    for (size_t i = 0; i < 90; i++) residual[i] -= f->system.right_hand_side[i];

    double x1[3 * 30], largest = 0.0, worst = 0.0;
    for (size_t i = 0; i < 90; i++) x1[i] = f->x[i] + h * u[i];
    cloth_start const end = {.positions = x1, .velocities = u, .time_step = h};
    assemble(f, &end);
    for (size_t i = 0; i < 90; i++) {
        double const truth = f->model.masses[i / 3] * (u[i] - f->v[i]) - h * f->system.forces[i];
        largest = fmax(largest, fabs(truth));
        worst = fmax(worst, fabs(residual[i] - truth));
    }
    assert_true(largest > 1e-3);
    assert_true(worst < 1e-12 * largest);
    fixture_free(f);
}

static void system_is_exact_at_the_guess(void **state) {
    (void)state;
    check_exact_at_the_guess(0.0);
    check_exact_at_the_guess(0.1);
}

/* One step of Newton's method from the guess u. */
static void solve_about(fixture *f, double h, double u[3 * 30]) {
    double guess[3 * 30];
    memcpy(guess, u, sizeof guess);
    assemble_about(f, h, guess);
    fixture_solve(f, u);
}

/* Sum of squares of what is missing in the equation of implicit Euler at u, over masses [J]. */
static double measure_residual(fixture *f, double h, const double u[3 * 30]) {
    double x1[3 * 30], sum = 0.0;
    for (size_t i = 0; i < 90; i++) x1[i] = f->x[i] + h * u[i];
    cloth_start const end = {.positions = x1, .velocities = u, .time_step = h};
    assemble(f, &end);
    for (size_t i = 0; i < 90; i++) {
        double const mass = f->model.masses[i / 3];
        double const residual = mass * (u[i] - f->v[i]) - h * f->system.forces[i];
        sum += residual * residual / mass;
    }
    return sum;
}

/* A sheet whose parts fly apart by half an edge in a step: from a guess that knows nothing of the
 * springs, stiffening cloth comes near its solution within the few turns that a world takes. With
 * springs linearised about the guess itself, however long it makes them, they leave 60 to 300 J of
 * 500,000. */
static void stiffening_cloth_takes_few_turns(void **state) {
    (void)state;
    for (int trial = 0; trial < 20; trial++) {
        double u[3 * 30];
        fixture *const f = make_case(0.1, u);
        memcpy(f->x, f->rest, 90 * sizeof(double));
        uint64_t random = (uint64_t)trial + 1;
        for (size_t i = 0; i < 90; i++) u[i] = f->v[i] = random_signed(&random);
        double const start = measure_residual(f, 0.01, u);
        for (int turn = 0; turn < 3; turn++) solve_about(f, 0.01, u);
        double const end = measure_residual(f, 0.01, u);
        assert_true(end < 1e-5 * start);
        fixture_free(f);
    }
}

static void excess_is_energy_beyond_the_model(void **state) {
    (void)state;
    double u[3 * 30];
    fixture *const f = make_case(0.1, u);
    cloth_start now = fixture_state(f, 0.01);
    linear_excess excess;
    now.guess = u;
    assert_int_equal(measure_linear_excess(&f->model, &now, u, 1, &f->scratch, &excess), TULLE_OK);
    assert_true(fabs(excess.springs) < 1e-12 && excess.curvature == 0.0); /* no way at all */
    double inertia = 0.0;
    for (size_t i = 0; i < 90; i++)
        inertia += 0.5 * f->model.masses[i / 3] * (u[i] - f->v[i]) * (u[i] - f->v[i]);
    assert_true(fabs(excess.inertia - inertia) < 1e-12 * inertia);
    /* One vertex leaves the plane of a flat sheet: to the linear system that costs nothing. */
    memcpy(f->x, f->rest, 90 * sizeof(double));
    memset(u, 0, 90 * sizeof(double));
    u[3 * 8 + 1] = 1.0;
    now.guess = NULL;
    assert_int_equal(measure_linear_excess(&f->model, &now, u, 1, &f->scratch, &excess), TULLE_OK);
    double x1[3 * 30];
    for (size_t i = 0; i < 90; i++) x1[i] = f->x[i] + 0.01 * u[i];
    cloth_energies energies;
    assert_int_equal(
        compute_energies(&f->model, x1, u, (energy_options){.threads = 1}, &f->scratch, &energies),
        TULLE_OK);
    assert_true(energies.elastic.stretch > 0.0);
    assert_true(fabs(excess.springs - energies.elastic.stretch) < 1e-9 * energies.elastic.stretch);
    fixture_free(f);
}

/* [J] What an implicit step to the mean velocity u makes least. */
static double measure_objective(fixture *f, const double *u, double h) {
    double x1[3 * 30], inertia = 0.0;
    for (size_t i = 0; i < 90; i++) {
        x1[i] = f->x[i] + h * u[i];
        inertia += 0.5 * f->model.masses[i / 3] * (u[i] - f->v[i]) * (u[i] - f->v[i]);
    }
    cloth_energies energies;
    assert_int_equal(
        compute_energies(&f->model, x1, u, (energy_options){.threads = 1}, &f->scratch, &energies),
        TULLE_OK);
    return inertia + energies.elastic.stretch + energies.elastic.bend;
}

/* A descent solves its equation; where nothing is known it goes the whole way, and from springs
 * that no number can hold the least part. */
static void descents_lower_the_energy(void **state) {
    (void)state;
    double const shares[] = {0.9, 0.5, 0.2, 0.05};
    for (size_t i = 0; i < 4; i++) {
        double const t = shares[i];
        linear_excess const excess = {3.0 * (1.0 - t) / (4.0 * t * t * t), 1.0, 3.0};
        assert_true(fabs(choose_descent(&excess) - t) < 1e-9);
    }
    assert_true(choose_descent(&(linear_excess){-1.0, 1.0, 1.0}) == 1.0);
    assert_true(choose_descent(&(linear_excess){1.0, 1.0, 0.0}) == 1.0);
    assert_true(choose_descent(&(linear_excess){(double)NAN, 1.0, 1.0}) == 1.0);
    assert_true(choose_descent(&(linear_excess){(double)INFINITY, 1.0, 1.0}) == 0.05);

    /* Vertices of a flat sheet leave its plane, which costs nothing to the system. */
    double const h = 0.01;
    int overshot = 0;
    for (int trial = 0; trial < 20; trial++) {
        double u[3 * 30], guess[3 * 30] = {0.0}, chosen[3 * 30];
        fixture *const f = make_case(trial % 2 ? 0.1 : 0.0, u);
        f->surroundings = (environment){0};
        memcpy(f->x, f->rest, 90 * sizeof(double));
        memset(f->v, 0, 90 * sizeof(double));
        memset(u, 0, sizeof u);
        uint64_t random = (uint64_t)trial + 1;
        for (size_t v = 0; v < 30; v++)
            f->v[3 * v + 1] = (1 + trial) * 0.4 * random_signed(&random);
        solve_about(f, h, u);
        cloth_start now = fixture_state(f, h);
        now.guess = guess;
        linear_excess excess;
        assert_int_equal(measure_linear_excess(&f->model, &now, u, 1, &f->scratch, &excess),
                         TULLE_OK);
        double const share = choose_descent(&excess);
        for (size_t i = 0; i < 90; i++) chosen[i] = guess[i] + share * (u[i] - guess[i]);
        double const from = measure_objective(f, guess, h);
        overshot += measure_objective(f, u, h) > from;
        assert_true(measure_objective(f, chosen, h) < from);
        fixture_free(f);
    }
    assert_int_equal(overshot, 20);
}

/* One spring's, by the words of linear_excess.c. */
static way_energies find_energies(const cloth_spring *spring, const excess_motion *motion) {
    vec3 ends[3][2], step[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (size_t k = 0; k < 2; k++) {
        size_t const v = spring->vertices[k];
        ends[0][k] = vec3_load(motion->positions, v);
        ends[1][k] = motion->guess ? vec3_load(motion->guess, v) : step[0];
        ends[2][k] = vec3_load(motion->mean, v);
    }
    vec3 const start = vec3_sub(ends[0][1], ends[0][0]);
    for (int k = 0; k < 2; k++)
        step[k] =
            vec3_add_scaled(start, vec3_sub(ends[k + 1][1], ends[k + 1][0]), motion->time_step);
    vec3 const from = spring_limit_guess(spring, start, step[0]), to = step[1];
    double const length = vec3_norm(from), rest = spring->rest_length;
    if (!(length > 0.0)) return (way_energies){0.0, 0.0};
    vec3 const d = vec3_sub(to, from);
    double const along = vec3_dot(from, d) / length;
    spring_law const law = spring_compute_law(spring, length - rest);
    double const curvature =
        law.slope * along * along +
        fmax(law.tension / length, 0.0) * fmax(vec3_norm2(d) - along * along, 0.0);
    double const reckoned = law.energy + law.tension * along + 0.5 * curvature;
    return (way_energies){spring_compute_law(spring, vec3_norm(to) - rest).energy - reckoned,
                          curvature};
}

/* Springs of any length, some far too long, some of none, of any number: the same bits as one at a
 * time, on every width. */
static void excess_is_the_same_on_every_width(void **state) {
    (void)state;
    enum { VERTICES = 40, SPRINGS = 70 };
    uint64_t random = 5;
    double x[3 * VERTICES], guess[3 * VERTICES], mean[3 * VERTICES];
    cloth_spring springs[SPRINGS];
    for (int i = 0; i < 3 * VERTICES; i++) {
        x[i] = random_signed(&random);
        guess[i] = 3.0 * random_signed(&random);
        mean[i] = 3.0 * random_signed(&random);
    }
    for (int i = 0; i < 3; i++) x[3 + i] = x[i], guess[3 + i] = guess[i];
    for (uint32_t s = 0; s < SPRINGS; s++)
        springs[s] = (cloth_spring){
            .vertices = {s % 11 == 0 ? 0 : s % VERTICES, s % 11 == 0 ? 1 : (7 * s + 3) % VERTICES},
            .rest_length = 0.1 + 1.5 * random_uniform(&random),
            .stiffness = 100.0 + s,
            .stiffening = s % 3 == 0 ? 0.0 : 30.0 * random_uniform(&random)};
    kernel_target const usual = kernel_target_get();
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (size_t count = 0; count <= SPRINGS; count++)
            for (int k = 0; k < 2; k++) {
                excess_motion const motion = {x, k ? guess : NULL, mean, 0.1};
                way_energies sum = {0.0, 0.0};
                for (size_t s = 0; s < count; s++) {
                    way_energies const one = find_energies(&springs[s], &motion);
                    sum.excess += one.excess;
                    sum.curvature += one.curvature;
                }
                way_energies const measured =
                    TULLE_PICK_KERNEL(sum_excess)(springs, count, &motion);
                assert_memory_equal(&measured, &sum, sizeof sum);
            }
    }
    assert_true(kernel_target_force(usual));
}

/* A system in numbers: blocks, right-hand side and forces. */
typedef struct system_numbers {
    double *values;
    size_t count;
} system_numbers;

static system_numbers copy_system(const fixture *f) {
    size_t const blocks = BLOCK_NUMBERS * f->system.matrix.block_count, n = 3 * f->vertex_count;
    system_numbers all = {malloc((blocks + 2 * n) * sizeof(double)), blocks + 2 * n};
    memcpy(all.values, f->system.matrix.values, blocks * sizeof(double));
    memcpy(all.values + blocks, f->system.right_hand_side, n * sizeof(double));
    memcpy(all.values + blocks + n, f->system.forces, n * sizeof(double));
    return all;
}

/* Linearised about x0 and then about u, with terms that are kept in between or without. */
static system_numbers assemble_twice(fixture *f, tulle_integrator integrator, const double *u,
                                     force_terms *terms) {
    force_options const options = {integrator, 2, 0.25, true};
    cloth_start now = fixture_state(f, 0.01);
    now.terms = terms;
    arena_mark const mark = arena_get_mark(&f->scratch);
    for (int k = 0; k < 2; k++) {
        size_t const used = f->scratch.used;
        assert_int_equal(
            compute_forces(&f->model, &now, &f->surroundings, options, &f->scratch, &f->system),
            TULLE_OK);
        size_t const kept = f->scratch.used - used;
        if (terms && k == 0)
            assert_in_range(kept, measure_force_terms(&f->model, &f->surroundings.wind),
                            measure_force_terms(&f->model, &f->surroundings.wind) + 6 * 64);
        else
            assert_int_equal(kept, 0);
        now.guess = u;
    }
    arena_release(&f->scratch, mark);
    return copy_system(f);
}

/* Kept terms save time alone: the same bits, flat at rest or curved, in wind or without. */
static void kept_terms_give_the_same_system(void **state) {
    (void)state;
    for (int k = 0; k < 24; k++) {
        double u[3 * 30];
        fixture *f = make_case(k & 1 ? 0.1 : 0.0, u);
        tulle_material material;
        assert_int_equal(tulle_material_preset("cotton", &material), TULLE_OK);
        if (k & 2) f->x[3 * 7 + 1] += 0.03;
        fixture *const curved =
            fixture_make(k & 2 ? f->x : f->rest, 30, f->surface.triangles,
                         f->surface.triangle_count, material); /* with damping of bending */
        memcpy(curved->x, f->x, 90 * sizeof(double));
        memcpy(curved->v, f->v, 90 * sizeof(double));
        fixture_free(f);
        f = curved;
        assert_int_equal(f->model.has_curved_rest, (k & 2) != 0);
        assert_true(f->model.has_bend_damping);
        for (size_t i = 0; i < 90; i++) f->x[i] += 0.001 * f->v[i];
        for (size_t i = 0; i < 90; i++) f->previous_mean[i] = f->previous_v[i] = 0.9 * f->v[i];
        f->previous_step = 0.01;
        if (k & 4) {
            f->surroundings.wind.drag_coefficient = 0.6;
            f->surroundings.wind.gust_strength = 1.0;
        }
        tulle_integrator const integrator = k < 8    ? TULLE_INTEGRATOR_IMPLICIT_EULER
                                            : k < 16 ? TULLE_INTEGRATOR_CRANK_NICOLSON
                                                     : TULLE_INTEGRATOR_BDF2;
        force_terms terms = {0};
        system_numbers const made = assemble_twice(f, integrator, u, NULL);
        system_numbers const kept = assemble_twice(f, integrator, u, &terms);
        assert_true(terms.is_complete);
        assert_memory_equal(made.values, kept.values, made.count * sizeof(double));
        free(made.values), free(kept.values);
        fixture_free(f);
    }
}

/* u . (b - A u) of the system with wind less that of the system without. */
static void wind_works_as_the_system_reckons(void **state) {
    (void)state;
    double u[3 * 30], product[3 * 30], force_work[2] = {0.0, 0.0}, work;
    fixture *const f = make_case(0.0, u);
    cloth_start const now = fixture_state(f, 0.01);
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, 1, 0.0, true};
    block_matrix_operator matrix = {&f->system.matrix, 1};
    for (int k = 0; k < 2; k++) {
        wind_work_options const wind = {&f->surroundings.wind, 1};
        assert_int_equal(measure_wind_work(&f->model, &now, u, wind, &f->scratch, &work), TULLE_OK);
        if (k == 0) assert_true(work == 0.0);
        assert_int_equal(
            compute_forces(&f->model, &now, &f->surroundings, options, &f->scratch, &f->system),
            TULLE_OK);
        block_matrix_apply(&matrix, u, product);
        for (size_t i = 0; i < 90; i++)
            force_work[k] += u[i] * (f->system.right_hand_side[i] - product[i]);
        f->surroundings.wind = (tulle_wind){.velocity = {3.0, -1.0, 2.0},
                                            .drag_coefficient = 0.6,
                                            .gust_strength = 1.0,
                                            .gust_length = 0.1,
                                            .gust_time = 1.0};
    }
    assert_true(fabs(work) > 1e-6);
    assert_true(fabs(force_work[1] - force_work[0] - work) < 1e-11 * fabs(force_work[0]));
    fixture_free(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(system_is_exact_at_the_guess),
                                       cmocka_unit_test(stiffening_cloth_takes_few_turns),
                                       cmocka_unit_test(descents_lower_the_energy),
                                       cmocka_unit_test(excess_is_energy_beyond_the_model),
                                       cmocka_unit_test(excess_is_the_same_on_every_width),
                                       cmocka_unit_test(kept_terms_give_the_same_system),
                                       cmocka_unit_test(wind_works_as_the_system_reckons)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
