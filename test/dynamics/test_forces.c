/* Forces against their energies, Jacobians against finite differences, momenta, and positive
 * definiteness of the system in every state. */
#include "dynamics/bending.h"
#include "dynamics/fixture.h"
#include "dynamics/spring.h"
#include "dynamics/wind.h"

enum { COLUMNS = 4, ROWS = 3 };

/* Moves every vertex by up to `size`. */
static void shake(double *values, size_t count, double size, uint64_t seed) {
    for (size_t i = 0; i < count; i++) values[i] += size * random_signed(&seed);
}

static double largest(const double *values, size_t count) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++) most = fmax(most, fabs(values[i]));
    return most;
}

/* df/dx (or df/dv) of the whole system's forces by central differences, n x n. */
static double *difference_forces(fixture *f, double *variable, double step) {
    size_t const n = 3 * f->vertex_count;
    double *const jacobian = malloc(n * n * sizeof(double));
    for (size_t j = 0; j < n; j++) {
        double const kept = variable[j];
        variable[j] = kept + step;
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
        for (size_t i = 0; i < n; i++) jacobian[i * n + j] = f->system.forces[i] / (2.0 * step);
        variable[j] = kept - step;
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
        for (size_t i = 0; i < n; i++) jacobian[i * n + j] -= f->system.forces[i] / (2.0 * step);
        variable[j] = kept;
    }
    return jacobian;
}

/* A spring at positions x and velocities v. */
static spring_response evaluate_at(const cloth_spring *spring, const double *x, const double *v) {
    return spring_evaluate(spring, spring_get_difference(spring, x),
                           spring_get_difference(spring, v));
}

static void spring_derivatives_are_exact(void **state) {
    (void)state;
    uint64_t random = 1;
    for (int trial = 0; trial < 200; trial++) {
        cloth_spring const spring = {.vertices = {0, 1},
                                     .rest_length = 0.5 + random_uniform(&random),
                                     .stiffness = 300.0,
                                     .stiffening = trial % 2 ? 0.7 : 0.0,
                                     .damping = 2.0};
        double x[6], v[6];
        for (int i = 0; i < 6; i++) x[i] = random_signed(&random), v[i] = random_signed(&random);
        spring_response const r = evaluate_at(&spring, x, v);
        symmetric3 const k = symmetric3_make(r.across, r.axial - r.across, r.direction);
        symmetric3 const d = symmetric3_make(0.0, spring.damping, r.direction);
        static const int place[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
        for (int column = 0; column < 3; column++) {
            double *const arrays[2] = {x, v};
            for (int which = 0; which < 2; which++) {
                double const step = 1e-6, kept = arrays[which][column];
                arrays[which][column] = kept + step;
                spring_response const more = evaluate_at(&spring, x, v);
                arrays[which][column] = kept - step;
                spring_response const less = evaluate_at(&spring, x, v);
                arrays[which][column] = kept;
                vec3 const difference = which == 0
                                            ? vec3_sub(more.elastic_force, less.elastic_force)
                                            : vec3_sub(more.damping_force, less.damping_force);
                vec3 const slope = vec3_scale(difference, 0.5 / step);
                double const slopes[3] = {slope.x, slope.y, slope.z};
                const double *const m = which == 0 ? k.m : d.m;
                for (int row = 0; row < 3; row++)
                    assert_true(fabs(slopes[row] + m[place[3 * row + column]]) < 2e-5);
            }
        }
    }
}

/* Stretched by its stiffening strain, cloth pulls twice as hard as linear cloth, by thrice of it
 * ten times; pressed together no harder. */
static void springs_stiffen(void **state) {
    (void)state;
    tulle_material material = plain_material();
    fixture *const linear = fixture_make_grid(2, 2, 0.4, 0.3, 0, material);
    material.springs.stiffening_strain = 0.1;
    fixture *const stiff = fixture_make_grid(2, 2, 0.4, 0.3, 0, material);
    for (size_t s = 0; s < stiff->model.edge_count; s++) {
        const cloth_spring *const a = &linear->model.springs[s], *const b =
                                                                     &stiff->model.springs[s];
        static const double strains[3] = {0.1, 0.3, -0.3}, factors[3] = {2.0, 10.0, 1.0};
        for (int k = 0; k < 3; k++) {
            double const extension = strains[k] * a->rest_length;
            double const ratio =
                spring_compute_law(b, extension).tension / spring_compute_law(a, extension).tension;
            assert_true(fabs(ratio - factors[k]) < 1e-12 * factors[k]);
        }
        double energy = 0.0; /* the tension summed up */
        enum { PARTS = 1000 };
        double const extension = 0.6 * b->rest_length;
        for (int i = 0; i < PARTS; i++)
            energy +=
                spring_compute_law(b, (i + 0.5) * extension / PARTS).tension * extension / PARTS;
        assert_true(fabs(spring_compute_law(b, extension).energy / energy - 1.0) < 1e-5);
    }
    fixture_free(linear);
    fixture_free(stiff);
}

/* The largest of all edges, wherever it is. */
static void the_largest_stretch_is_found(void **state) {
    (void)state;
    fixture *const f = fixture_make_grid(60, 50, 0.6, 0.5, 0, plain_material());
    energy_options const options = {.threads = 2};
    cloth_energies energies;
    size_t const corners[] = {0, f->vertex_count - 1};
    for (size_t i = 0; i < 2; i++) {
        size_t const x = 3 * corners[i];
        double const kept = f->x[x];
        assert_int_equal(compute_energies(&f->model, f->x, f->v, options, &f->scratch, &energies),
                         TULLE_OK);
        assert_true(fabs(energies.elastic.max_stretch - 1.0) < 1e-12);
        f->x[x] += i == 0 ? -0.003 : 0.003; /* of an edge of 1 cm */
        assert_int_equal(compute_energies(&f->model, f->x, f->v, options, &f->scratch, &energies),
                         TULLE_OK);
        assert_true(fabs(energies.elastic.max_stretch - 1.3) < 1e-12);
        f->x[x] = kept;
    }
    fixture_free(f);
}

/* The force is the negative gradient of the energy that compute_energies reports. */
static void check_gradient(fixture *f, double tolerance) {
    size_t const n = 3 * f->vertex_count;
    double *const gradient = malloc(n * sizeof(double));
    double const step = 1e-6;
    cloth_energies more, less;
    energy_options const options = {.threads = 1};
    for (size_t i = 0; i < n; i++) {
        double const kept = f->x[i];
        f->x[i] = kept + step;
        compute_energies(&f->model, f->x, f->v, options, &f->scratch, &more);
        f->x[i] = kept - step;
        compute_energies(&f->model, f->x, f->v, options, &f->scratch, &less);
        f->x[i] = kept;
        gradient[i] =
            (more.elastic.stretch + more.elastic.bend - less.elastic.stretch - less.elastic.bend) /
            (2.0 * step);
    }
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    double const scale = largest(f->system.forces, n);
    assert_true(scale > 0.0);
    for (size_t i = 0; i < n; i++)
        assert_true(fabs(f->system.forces[i] + gradient[i]) < tolerance * scale);
    free(gradient);
}

static fixture *make_curved(tulle_material material) {
    grid g = grid_make(COLUMNS, ROWS, 0.4, 0.3, 2);
    for (size_t v = 0; v < g.vertex_count; v++) {
        double *const p = g.positions + 3 * v;
        double const angle = p[0] / 0.2;
        p[0] = 0.2 * sin(angle);
        p[1] = 0.2 * cos(angle) + 0.1 * p[2] * p[2];
    }
    fixture *const f =
        fixture_make(g.positions, g.vertex_count, g.triangles, g.triangle_count, material);
    grid_free(&g);
    return f;
}

/* Folded about a line of vertices, by [degrees]. */
static fixture *make_folded(double angle, tulle_material material) {
    grid g = grid_make(COLUMNS, ROWS, 0.4, 0.3, 0);
    double const turn = angle * acos(-1.0) / 180.0;
    for (size_t v = 0; v < g.vertex_count; v++) {
        double *const p = g.positions + 3 * v;
        double const beyond = p[0] - 0.2;
        if (!(beyond > 0.01)) continue;
        p[0] = 0.2 + beyond * cos(turn);
        p[1] = beyond * sin(turn);
    }
    fixture *const f =
        fixture_make(g.positions, g.vertex_count, g.triangles, g.triangle_count, material);
    grid_free(&g);
    return f;
}

/* About these angles at rest, one of which needs no help and one only a little. */
static double const folds[] = {150.0, 173.0, 175.0, 178.5, 179.9, -178.5};
enum { FOLDS = sizeof folds / sizeof *folds };

static void force_is_gradient_of_energy(void **state) {
    (void)state;
    tulle_material bending = plain_material();
    bending.springs.stretch_stiffness = 1e-9;
    for (int pattern = 0; pattern < 3; pattern++) {
        tulle_material material = plain_material();
        material.springs.stiffening_strain = pattern * 0.15;
        fixture *f = fixture_make_grid(COLUMNS, ROWS, 0.4, 0.3, pattern, material);
        shake(f->x, 3 * f->vertex_count, 0.05, 3);
        check_gradient(f, 1e-6);
        fixture_free(f);
        f = fixture_make_grid(COLUMNS, ROWS, 0.4, 0.3, pattern, bending);
        shake(f->x, 3 * f->vertex_count, 0.05, 3);
        check_gradient(f, 1e-6);
        fixture_free(f);
    }
    fixture *const f = make_curved(bending);
    assert_true(f->model.has_curved_rest);
    shake(f->x, 3 * f->vertex_count, 0.01, 4);
    check_gradient(f, 1e-5);
    fixture_free(f);
    for (int k = 0; k < FOLDS; k++) {
        fixture *const folded = make_folded(folds[k], bending);
        shake(folded->x, 3 * folded->vertex_count, 1e-4, 5);
        check_gradient(folded, 1e-4);
        fixture_free(folded);
    }
}

/* A curved rest shape is at rest, and a flat one too. */
static void rest_shape_has_no_forces(void **state) {
    (void)state;
    fixture *const curved = make_curved(plain_material());
    fixture_assemble(curved, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    assert_true(largest(curved->system.forces, 3 * curved->vertex_count) < 1e-12);
    shake(curved->x, 3 * curved->vertex_count, 0.01, 4);
    fixture_assemble(curved, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    assert_true(largest(curved->system.forces, 3 * curved->vertex_count) > 1e-3);
    fixture_free(curved);
    fixture *const flat = fixture_make_grid(COLUMNS, ROWS, 0.4, 0.3, 2, plain_material());
    assert_false(flat->model.has_curved_rest);
    fixture_assemble(flat, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    assert_true(largest(flat->system.forces, 3 * flat->vertex_count) < 1e-12);
    fixture_free(flat);
    for (int k = 0; k < FOLDS; k++) {
        fixture *const folded = make_folded(folds[k], plain_material());
        cloth_energies energies;
        assert_true(folded->model.has_curved_rest);
        fixture_assemble(folded, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
        assert_true(largest(folded->system.forces, 3 * folded->vertex_count) < 1e-12);
        assert_int_equal(compute_energies(&folded->model, folded->x, folded->v,
                                          (energy_options){.threads = 1}, &folded->scratch,
                                          &energies),
                         TULLE_OK);
        assert_true(energies.elastic.bend < 1e-20);
        fixture_free(folded);
    }
}

/* In tension nothing is clamped: the matrix is M - h D - h^2 K of the exact derivatives. */
static void matrix_matches_finite_differences(void **state) {
    (void)state;
    tulle_material material = plain_material();
    material.air_damping = 0.7;
    material.stretch_damping = 1e-2;
    material.springs.stiffening_strain = 0.5;
    fixture *const f = fixture_make_grid(COLUMNS, ROWS, 0.4, 0.3, 2, material);
    size_t const n = 3 * f->vertex_count;
    for (size_t i = 0; i < n; i++) f->x[i] *= 1.5;
    shake(f->x, n, 0.01, 5);
    /* Still: damping has then no derivative by positions. */
    double *const by_position = difference_forces(f, f->x, 1e-6);
    double *const by_velocity = difference_forces(f, f->v, 1e-4);
    tulle_integrator const integrators[] = {TULLE_INTEGRATOR_IMPLICIT_EULER,
                                            TULLE_INTEGRATOR_CRANK_NICOLSON, TULLE_INTEGRATOR_BDF2};
    double const h = 0.02;
    double const alpha[] = {h, h / 2, 2 * h / 3}, beta[] = {h * h, h * h / 4, 4 * h * h / 9};
    f->previous_step = h;
    for (int k = 0; k < 3; k++) {
        fixture_assemble(f, integrators[k], h);
        assert_int_equal(f->system.integrator, integrators[k]);
        double *const dense = fixture_dense(f);
        for (size_t i = 0; i < n; i++)
            for (size_t j = 0; j < n; j++) {
                double const mass = i == j ? f->model.masses[i / 3] : 0.0;
                double const expected =
                    mass - alpha[k] * by_velocity[i * n + j] - beta[k] * by_position[i * n + j];
                assert_true(fabs(dense[i * n + j] - expected) < 1e-6);
                assert_true(fabs(dense[i * n + j] - dense[j * n + i]) < 1e-15);
            }
        fixture_find_diagonal(f);
        for (size_t v = 0; v < f->vertex_count; v++)
            for (size_t i = 0; i < 9; i++)
                assert_true(f->diagonal[9 * v + i] == dense[(3 * v + i / 3) * n + 3 * v + i % 3]);
        free(dense);
    }
    assert_true(largest(by_position, n * n) > 100.0 && largest(by_velocity, n * n) > 0.1);
    free(by_position), free(by_velocity);
    fixture_free(f);
}

/* Drag is exact along the normal, and the matrix holds it. */
static void drag_matches_finite_differences(void **state) {
    (void)state;
    uint64_t random = 9;
    for (int trial = 0; trial < 200; trial++) {
        vec3 corners[3],
            w = {random_signed(&random), random_signed(&random), random_signed(&random)};
        for (int k = 0; k < 3; k++)
            corners[k] =
                vec3_make(random_signed(&random), random_signed(&random), random_signed(&random));
        wind_response const r = wind_evaluate(1.7, corners, w);
        vec3 const more = wind_evaluate(1.7, corners, vec3_add_scaled(w, r.normal, 1e-6)).force;
        vec3 const less = wind_evaluate(1.7, corners, vec3_add_scaled(w, r.normal, -1e-6)).force;
        double const slope = vec3_dot(r.normal, vec3_sub(more, less)) / 2e-6;
        assert_true(fabs(slope + r.drag) < 1e-6);
        /* The closed form of the paper, and no power gained from still air. */
        double const area = 0.5 * vec3_norm(vec3_cross(vec3_sub(corners[1], corners[0]),
                                                       vec3_sub(corners[2], corners[0])));
        vec3 const expected =
            vec3_scale(r.normal, -1.7 * area * vec3_norm(w) * vec3_dot(r.normal, w));
        assert_true(vec3_norm(vec3_sub(expected, r.force)) < 1e-14);
        assert_true(vec3_dot(r.force, w) <= 0.0);
    }
    /* A flat sheet moving along its normal: the whole derivative is along it. */
    fixture *const f = fixture_make_grid(2, 2, 0.4, 0.3, 0, plain_material());
    size_t const n = 3 * f->vertex_count;
    f->surroundings.wind.drag_coefficient = 1.3;
    for (size_t v = 0; v < f->vertex_count; v++) f->v[3 * v + 1] = -2.0;
    double *const by_velocity = difference_forces(f, f->v, 1e-5);
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 1.0);
    double *const with_wind = fixture_dense(f);
    f->surroundings.wind.drag_coefficient = 0.0;
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 1.0);
    double *const without = fixture_dense(f);
    for (size_t i = 0; i < n * n; i++) {
        bool const along = i / n % 3 == 1 && i % n % 3 == 1;
        double const drag = with_wind[i] - without[i];
        assert_true(fabs(drag - (along ? -by_velocity[i] : 0.0)) < 1e-7);
    }
    assert_true(fabs(by_velocity[n + 1]) > 1e-3);
    free(by_velocity), free(with_wind), free(without);
    fixture_free(f);
}

/* Bending damping D takes power only, and v^T D v <= 2 v^T (D_matrix + M / h) v: it is stable in
 * any state. Nearly flat, the matrix alone bounds it. */
static void bend_damping_is_bounded_by_its_matrix(void **state) {
    (void)state;
    tulle_material material = plain_material(), undamped = plain_material();
    material.bend_damping = 0.3;
    fixture *const f = fixture_make_grid(COLUMNS, ROWS, 0.4, 0.3, 2, material);
    fixture *const g = fixture_make_grid(COLUMNS, ROWS, 0.4, 0.3, 2, undamped);
    size_t const n = 3 * f->vertex_count;
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 1.0);
    fixture_assemble(g, TULLE_INTEGRATOR_IMPLICIT_EULER, 1.0);
    double *const damped_matrix = fixture_dense(f), *const plain_matrix = fixture_dense(g);
    double *const product = calloc(n, sizeof(double));
    for (uint64_t trial = 0; trial < 100; trial++) {
        memcpy(f->x, f->rest, n * sizeof(double));
        /* A rigid rotation of a bent sheet, then random motion of nearly flat ones. */
        bool const is_rigid = trial == 0;
        if (is_rigid)
            for (size_t v = 0; v < f->vertex_count; v++) {
                double const angle = f->rest[3 * v] / 0.2;
                f->x[3 * v] = 0.2 * sin(angle), f->x[3 * v + 1] = 0.2 * cos(angle);
            }
        else
            shake(f->x, n, trial % 2 ? 0.004 : 0.1, trial);
        memset(f->v, 0, n * sizeof(double));
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 1.0);
        double *const elastic = copy_doubles(f->system.forces, n);
        shake(f->v, n, 1.0, trial + 1000);
        vec3 const spin = {0.3, -0.5, 0.8};
        for (size_t v = 0; is_rigid && v < f->vertex_count; v++)
            vec3_store(f->v, v, vec3_cross(spin, vec3_load(f->x, v)));
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 1.0);
        double true_power = 0.0, matrix_power = 0.0, inertia = 0.0;
        for (size_t i = 0; i < n; i++) {
            inertia += f->model.masses[i / 3] * f->v[i] * f->v[i]; /* h is 1 s */
            true_power -= f->v[i] * (f->system.forces[i] - elastic[i]);
            for (size_t j = 0; j < n; j++)
                matrix_power +=
                    f->v[i] * (damped_matrix[i * n + j] - plain_matrix[i * n + j]) * f->v[j];
        }
        free(elastic);
        if (is_rigid)
            assert_true(fabs(true_power) < 1e-12);
        else if (trial % 2)
            assert_true(true_power > 0.0 && true_power < 1.2 * matrix_power);
        else
            assert_true(true_power > 0.0 && true_power <= 2.0 * (matrix_power + inertia));
    }
    free(damped_matrix), free(plain_matrix), free(product);
    fixture_free(f), fixture_free(g);
}

/* Inner forces add up to nothing, and so do their moments, in any state. */
static void inner_forces_keep_momentum(void **state) {
    (void)state;
    tulle_material material = plain_material();
    material.stretch_damping = material.bend_damping = 0.01;
    for (uint64_t trial = 0; trial < 20; trial++) {
        fixture *const f = make_curved(material);
        size_t const n = 3 * f->vertex_count;
        shake(f->x, n, 0.1, trial);
        shake(f->v, n, 1.0, trial + 50);
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
        vec3 force = {0}, moment = {0};
        double scale = 0.0;
        for (size_t v = 0; v < f->vertex_count; v++) {
            vec3 const part = vec3_load(f->system.forces, v);
            force = vec3_add(force, part);
            moment = vec3_add(moment, vec3_cross(vec3_load(f->x, v), part));
            scale += vec3_norm(part);
        }
        assert_true(vec3_norm(force) < 1e-13 * scale);
        assert_true(vec3_norm(moment) < 1e-13 * scale);
        fixture_free(f);
    }
}

/* Cholesky succeeds on crushed, folded, inverted and collapsed states. */
static void system_is_positive_definite_in_any_state(void **state) {
    (void)state;
    tulle_material material = plain_material();
    material.springs.stretch_stiffness = 5000.0;
    material.area_density = 0.05;
    material.bend_damping = material.stretch_damping = 0.01;
    int compressed = 0;
    for (uint64_t trial = 0; trial < 40; trial++) {
        fixture *const f = fixture_make_grid(5, 4, 0.5, 0.4, (int)(trial % 3), material);
        size_t const n = 3 * f->vertex_count;
        double const crush[] = {0.3, 0.01, 0.0, 2.0};
        for (size_t i = 0; i < n; i++) f->x[i] *= crush[trial % 4];
        shake(f->x, n, trial % 8 == 2 ? 0.0 : 0.02 * (double)(trial % 5), trial);
        shake(f->v, n, 3.0, trial + 9);
        f->surroundings.wind.drag_coefficient = 2.0;
        f->previous_step = 0.05;
        fixture_assemble(f, (tulle_integrator)(trial % 3), 0.05);
        for (size_t s = 0; s < f->model.edge_count; s++)
            compressed += evaluate_at(&f->model.springs[s], f->x, f->v).across < 0.0;
        double *const dense = fixture_dense(f);
        assert_true(factor_cholesky(dense, n));
        free(dense);
        fixture_free(f);
    }
    assert_true(compressed > 500);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spring_derivatives_are_exact),
        cmocka_unit_test(springs_stiffen),
        cmocka_unit_test(the_largest_stretch_is_found),
        cmocka_unit_test(force_is_gradient_of_energy),
        cmocka_unit_test(rest_shape_has_no_forces),
        cmocka_unit_test(matrix_matches_finite_differences),
        cmocka_unit_test(drag_matches_finite_differences),
        cmocka_unit_test(bend_damping_is_bounded_by_its_matrix),
        cmocka_unit_test(inner_forces_keep_momentum),
        cmocka_unit_test(system_is_positive_definite_in_any_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
