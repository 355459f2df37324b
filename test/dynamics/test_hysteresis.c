/* Hysteresis of woven cloth against closed forms and differences: loops of bending and of shear are
 * as wide as the material says, on any mesh; forces are those of an energy; motion that turns cloth
 * as a whole feels no slider; and no closed path gives energy. */
#include "dynamics/fixture.h"
#include "dynamics/hysteresis.h"

#include <math.h>
#include <stdio.h>

enum { PATTERNS = 3 };
static const double PI = 3.14159265358979323846;
/* K over the elastic stiffness, as hysteresis.c says. */
static const double RATIO = 5.0;

static tulle_material make_cotton(void) {
    tulle_material cotton = {.area_density = 0.2,
                             .warp = {4500.0, 0.05, 0.14},
                             .weft = {2800.0, 0.05, 0.14},
                             .shear = {60.0, 0.2, 0.5},
                             .poisson = 0.1,
                             .bend_warp = 1e-5,
                             .bend_weft = 0.7e-5,
                             .bend_twist = 0.4e-5,
                             .bend_hysteresis_warp = 5e-4,
                             .bend_hysteresis_weft = 3e-4,
                             .shear_hysteresis = 2.5,
                             .stretch_damping = 1e-3};
    return cotton;
}

/* The same with a thousandth of the membrane, so that forces of sliders are not lost beside it. */
static tulle_material make_soft(void) {
    tulle_material soft = make_cotton();
    soft.warp.stiffness *= 1e-3;
    soft.weft.stiffness *= 1e-3;
    soft.shear.stiffness *= 1e-3;
    soft.shear_hysteresis *= 1e-3;
    return soft;
}

/* A fixture with plastic parts. */
typedef struct slid {
    fixture *f;
    double *plastic;
    size_t count;
} slid;

static slid make_slid(grid g, tulle_material material, double angle) {
    slid cloth = {.f = fixture_weave_grid(g, material, angle)};
    cloth.count = hysteresis_count(&cloth.f->model);
    assert_int_equal(cloth.count, SLIDER_COUNT * cloth.f->model.triangle_count);
    cloth.plastic = calloc(cloth.count, sizeof(double));
    return cloth;
}

static void free_slid(slid *cloth) {
    free(cloth->plastic);
    fixture_free(cloth->f);
}

static slider_state get_state(const slid *cloth) {
    return (slider_state){cloth->f->x, cloth->f->threads, &cloth->f->scratch};
}

static void follow(slid *cloth) {
    assert_int_equal(hysteresis_follow(&cloth->f->model, get_state(cloth), cloth->plastic),
                     TULLE_OK);
}

/* The system with sliders or without. */
static void assemble(slid *cloth, tulle_integrator integrator, double h, const double *guess,
                     bool has_sliders) {
    fixture *const f = cloth->f;
    cloth_start state = fixture_state(f, h);
    state.guess = guess;
    state.plastic = has_sliders ? cloth->plastic : NULL;
    assert_int_equal(compute_forces(&f->model, &state, &f->surroundings,
                                    (force_options){integrator, f->threads, 0.0, true}, &f->scratch,
                                    &f->system),
                     TULLE_OK);
}

/* What sliders add to the forces [N]; 3 a vertex, to be freed. */
static double *find_slider_forces(slid *cloth) {
    fixture *const f = cloth->f;
    size_t const n = 3 * f->vertex_count;
    double *const forces = malloc(n * sizeof *forces);
    assemble(cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01, NULL, true);
    memcpy(forces, f->system.forces, n * sizeof *forces);
    assemble(cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01, NULL, false);
    for (size_t i = 0; i < n; i++) forces[i] -= f->system.forces[i];
    return forces;
}

/* A slider by itself. */
static double follow_slider(double strain, double stiffness, double most, double *plastic) {
    double const pull = stiffness * (strain - *plastic);
    if (pull > most) *plastic = strain - most / stiffness;
    if (pull < -most) *plastic = strain + most / stiffness;
    return fmin(fmax(pull, -most), most);
}

/* Rolls the sheet onto a cylinder along z. */
static void roll(fixture *f, double curvature) {
    for (size_t v = 0; v < f->vertex_count; v++) {
        double const turn = curvature * f->rest[3 * v];
        bool const is_flat = fabs(curvature) < 1e-9;
        f->x[3 * v] = is_flat ? f->rest[3 * v] : sin(turn) / curvature;
        f->x[3 * v + 1] = is_flat ? 0.0 : (1.0 - cos(turn)) / curvature;
    }
}

/* [N] moment per width that sliders carry through the middle of a rolled sheet. */
static double measure_moment(slid *cloth, double middle, double width, double curvature) {
    fixture *const f = cloth->f;
    double *const forces = find_slider_forces(cloth);
    double const turn = curvature * middle;
    bool const is_flat = fabs(curvature) < 1e-9;
    double const x = is_flat ? middle : sin(turn) / curvature;
    double const y = is_flat ? 0.0 : (1.0 - cos(turn)) / curvature;
    double moment = 0.0;
    for (size_t v = 0; v < f->vertex_count; v++)
        if (f->rest[3 * v] > middle)
            moment -= (f->x[3 * v] - x) * forces[3 * v + 1] - (f->x[3 * v + 1] - y) * forces[3 * v];
    free(forces);
    return moment / width;
}

/* A strip that is bent to and fro by hand: its moment is that of one slider, all the way. Bent
 * along the warp or the weft. */
static void loops_of_bending_are_as_wide_as_they_should(void **state) {
    (void)state;
    enum { COLUMNS = 24, ROWS = 16, STEPS = 20 };
    double const length = 0.12, width = 0.08, largest = 20.0;
    for (int pattern = 0; pattern < PATTERNS; pattern++)
        for (int yarn = 0; yarn < 2; yarn++) {
            tulle_material const material = make_cotton();
            double const most =
                0.5 * (yarn ? material.bend_hysteresis_weft : material.bend_hysteresis_warp);
            double const stiffness = RATIO * (yarn ? material.bend_weft : material.bend_warp);
            slid cloth = make_slid(grid_make(COLUMNS, ROWS, length, width, pattern), material,
                                   yarn ? 0.5 * PI : 0.0);
            static const double turns[] = {0.0, 1.0, -1.0, 1.0, 0.0};
            double plastic = 0.0, up = 0.0, down = 0.0, worst = 0.0;
            for (int part = 0; part < 4; part++)
                for (int i = 1; i <= STEPS; i++) {
                    double const share = (double)i / STEPS;
                    double const curvature =
                        largest * (turns[part] + share * (turns[part + 1] - turns[part]));
                    roll(cloth.f, curvature);
                    double const found = measure_moment(&cloth, 0.503 * length, width, curvature);
                    double const wanted = follow_slider(curvature, stiffness, most, &plastic);
                    follow(&cloth);
                    worst = fmax(worst, fabs(found - wanted));
                    if (part == 1 && i == STEPS / 2) down = found;
                    if (part == 2 && i == STEPS / 2) up = found;
                }
            assert_true(fabs(up - down - 2.0 * most) < 0.02 * 2.0 * most);
            assert_true(worst < 0.03 * 2.0 * most);
            free_slid(&cloth);
        }
}

/* A sheet that is sheared to and fro: the force along its side is that of one slider. */
static void loops_of_shear_are_as_wide_as_they_should(void **state) {
    (void)state;
    enum { STEPS = 20 };
    double const width = 0.2, largest = 0.1;
    tulle_material const material = make_cotton();
    double const most = 0.5 * material.shear_hysteresis, stiffness = RATIO * 60.0;
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        slid cloth = make_slid(grid_make(6, 5, width, 0.15, pattern), material, 0.0);
        fixture *const f = cloth.f;
        static const double turns[] = {0.0, 1.0, -1.0, 1.0};
        double plastic = 0.0;
        for (int part = 0; part < 3; part++)
            for (int i = 1; i <= STEPS; i++) {
                double const share = (double)i / STEPS;
                double const shear =
                    largest * (turns[part] + share * (turns[part + 1] - turns[part]));
                for (size_t v = 0; v < f->vertex_count; v++)
                    f->x[3 * v] = f->rest[3 * v] + shear * f->rest[3 * v + 2];
                double *const forces = find_slider_forces(&cloth);
                double found = 0.0;
                for (size_t v = 0; v < f->vertex_count; v++)
                    if (f->rest[3 * v + 2] <= 0.0) found += forces[3 * v] / width;
                free(forces);
                double const wanted = follow_slider(shear, stiffness, most, &plastic);
                follow(&cloth);
                assert_true(fabs(found - wanted) < 1e-9 * most);
            }
        free_slid(&cloth);
    }
}

/* Crumples cloth and lets its plastic parts be anything near. */
static void crumple(slid *cloth, double size, uint64_t *random) {
    fixture *const f = cloth->f;
    for (size_t i = 0; i < 3 * f->vertex_count; i++) {
        f->x[i] = f->rest[i] + size * random_signed(random);
        f->v[i] = random_signed(random);
    }
    follow(cloth);
    for (size_t k = 0; k < cloth->count; k++)
        cloth->plastic[k] +=
            (k % SLIDER_COUNT == SLIDER_SHEAR ? 0.008 : 10.0) * random_signed(random);
}

static double measure_energy(const slid *cloth) {
    double energies[2];
    assert_int_equal(
        hysteresis_measure(&cloth->f->model, get_state(cloth), cloth->plastic, energies), TULLE_OK);
    return energies[0] + energies[1];
}

/* Forces are minus the gradient of what sliders store and lose; they turn and push nothing as a
 * whole. Crumpled cloth holds sliders that stick and sliders that slide. */
static void forces_are_those_of_the_energy(void **state) {
    (void)state;
    uint64_t random = 5;
    double const step = 1e-8;
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        slid cloth = make_slid(grid_make(5, 4, 0.05, 0.04, pattern), make_soft(), 0.3);
        fixture *const f = cloth.f;
        crumple(&cloth, 0.002, &random);
        double *const forces = find_slider_forces(&cloth);
        double largest = 0.0;
        vec3 sum = {0.0, 0.0, 0.0}, torque = {0.0, 0.0, 0.0};
        for (size_t i = 0; i < 3 * f->vertex_count; i++) largest = fmax(largest, fabs(forces[i]));
        for (size_t i = 0; i < 3 * f->vertex_count; i++) {
            double const kept = f->x[i];
            f->x[i] = kept + step;
            double const after = measure_energy(&cloth);
            f->x[i] = kept - step;
            double const before = measure_energy(&cloth);
            f->x[i] = kept;
            assert_true(fabs((after - before) / (2.0 * step) + forces[i]) < 1e-5 * largest);
        }
        for (size_t v = 0; v < f->vertex_count; v++) {
            sum = vec3_add(sum, vec3_load(forces, v));
            torque = vec3_add(torque, vec3_cross(vec3_load(f->x, v), vec3_load(forces, v)));
        }
        assert_true(vec3_norm(sum) < 1e-12 * largest);
        assert_true(vec3_norm(torque) < 1e-12 * largest);
        free(forces);
        free_slid(&cloth);
    }
}

/* The system is symmetric and definite whatever sliders do. In flat cloth whose sliders stick it is
 * the derivative of the forces, across the sheet. */
static void matrix_is_definite(void **state) {
    (void)state;
    uint64_t random = 11;
    double const h = 0.01, step = 1e-7;
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        slid cloth = make_slid(grid_make(4, 4, 0.04, 0.04, pattern), make_cotton(), 0.4);
        fixture *const f = cloth.f;
        size_t const n = 3 * f->vertex_count;
        assemble(&cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, h, NULL, true);
        double *const with = fixture_dense(f);
        assemble(&cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, h, NULL, false);
        double *const without = fixture_dense(f);
        double largest = 0.0;
        for (size_t i = 0; i < n * n; i++) largest = fmax(largest, fabs(with[i] - without[i]));
        for (size_t j = 1; j < n; j += 3) {
            f->x[j] += step;
            double *const forces = find_slider_forces(&cloth);
            f->x[j] -= step;
            for (size_t i = 1; i < n; i += 3) {
                double const found = with[i * n + j] - without[i * n + j];
                assert_true(fabs(found + h * h * forces[i] / step) < 1e-5 * largest);
            }
            free(forces);
        }
        free(with), free(without);
        for (int round = 0; round < 8; round++) {
            crumple(&cloth, round < 4 ? 0.001 : 0.01, &random);
            assemble(&cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, h, round % 2 ? f->v : NULL, true);
            double *const dense = fixture_dense(f);
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < i; j++)
                    assert_true(fabs(dense[i * n + j] - dense[j * n + i]) < 1e-15);
            assert_true(factor_cholesky(dense, n));
            free(dense);
        }
        free_slid(&cloth);
    }
}

/* A u - b of the system. */
static double *find_residual(fixture *f, const double *u) {
    double *const residual = malloc(3 * f->vertex_count * sizeof *residual);
    block_matrix_operator matrix = {&f->system.matrix, 1};
    block_matrix_apply(&matrix, u, residual);
    for (size_t i = 0; i < 3 * f->vertex_count; i++) residual[i] -= f->system.right_hand_side[i];
    return residual;
}

/* At its guess the system is the true equation: sliders pull as at the end of the step, and by
 * Crank-Nicolson as the mean of both ends. */
static void system_is_exact_at_its_guess(void **state) {
    (void)state;
    uint64_t random = 3;
    double const h = 0.01;
    for (int integrator = 0; integrator < 2; integrator++) {
        tulle_integrator const by =
            integrator ? TULLE_INTEGRATOR_CRANK_NICOLSON : TULLE_INTEGRATOR_IMPLICIT_EULER;
        slid cloth = make_slid(grid_make(5, 4, 0.05, 0.04, 2), make_soft(), 0.3);
        fixture *const f = cloth.f;
        size_t const n = 3 * f->vertex_count;
        crumple(&cloth, 0.001, &random);
        follow(&cloth);
        double *const guess = malloc(n * sizeof *guess);
        for (size_t i = 0; i < n; i++) guess[i] = 0.1 * random_signed(&random);
        double *residuals[2];
        for (int sliders = 0; sliders < 2; sliders++) {
            assemble(&cloth, by, h, guess, sliders);
            residuals[sliders] = find_residual(f, guess);
        }
        double *const first = find_slider_forces(&cloth);
        for (size_t i = 0; i < n; i++) f->x[i] += h * guess[i];
        double *const last = find_slider_forces(&cloth);
        double largest = 0.0, change = 0.0;
        for (size_t i = 0; i < n; i++) {
            largest = fmax(largest, fabs(last[i]));
            change = fmax(change, fabs(last[i] - first[i]));
        }
        assert_true(change > 0.1 * largest);
        for (size_t i = 0; i < n; i++) {
            double const wanted = integrator ? 0.25 * h * (first[i] + last[i]) : h * last[i];
            double const found = residuals[0][i] - residuals[1][i];
            assert_true(fabs(found - wanted) < 1e-9 * h * largest);
        }
        free(guess), free(first), free(last), free(residuals[0]), free(residuals[1]);
        free_slid(&cloth);
    }
}

/* Cloth that turns as a whole, bent and sheared: sliders change nothing but by their force. */
static void turning_feels_no_slider(void **state) {
    (void)state;
    double const h = 0.01;
    vec3 const spin = {3.0, -7.0, 5.0};
    slid cloth = make_slid(grid_make(8, 6, 0.08, 0.06, 2), make_cotton(), 0.3);
    fixture *const f = cloth.f;
    size_t const n = 3 * f->vertex_count;
    roll(f, 40.0);
    for (size_t v = 0; v < f->vertex_count; v++) {
        f->x[3 * v + 2] += 0.02 * f->x[3 * v];
        vec3_store(f->v, v, vec3_cross(spin, vec3_load(f->x, v)));
    }
    double *residuals[2];
    for (int sliders = 0; sliders < 2; sliders++) {
        assemble(&cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, h, NULL, sliders);
        residuals[sliders] = find_residual(f, f->v);
    }
    double *const forces = find_slider_forces(&cloth);
    double largest = 0.0;
    for (size_t i = 0; i < n; i++) largest = fmax(largest, fabs(forces[i]));
    for (size_t i = 0; i < n; i++)
        assert_true(fabs(residuals[0][i] - residuals[1][i] - h * forces[i]) < 1e-9 * h * largest);
    free(forces), free(residuals[0]), free(residuals[1]);
    free_slid(&cloth);
}

/* Along a closed path sliders take energy. They give none back but what they stored. */
static void closed_paths_take_energy(void **state) {
    (void)state;
    enum { STEPS = 200 };
    uint64_t random = 17;
    slid cloth = make_slid(grid_make(5, 4, 0.05, 0.04, 2), make_cotton(), 0.3);
    fixture *const f = cloth.f;
    size_t const n = 3 * f->vertex_count;
    double *const ways[2] = {malloc(n * sizeof(double)), malloc(n * sizeof(double))};
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < n; i++) ways[k][i] = 0.001 * random_signed(&random);
    double work = 0.0, stored = 0.0;
    for (int i = 1; i <= 2 * STEPS; i++) {
        double const turn = 2.0 * PI * i / STEPS;
        double *const before = copy_doubles(f->x, n);
        for (size_t k = 0; k < n; k++)
            f->x[k] = f->rest[k] + (cos(turn) - 1.0) * ways[0][k] + sin(turn) * ways[1][k];
        double *const forces = find_slider_forces(&cloth);
        for (size_t k = 0; k < n; k++) work -= forces[k] * (f->x[k] - before[k]);
        double const energy = measure_energy(&cloth); /* stored, and lost in this step */
        follow(&cloth);
        stored = measure_energy(&cloth);
        assert_true(stored <= energy * (1.0 + 1e-12));
        assert_true(work > stored - 0.02 * fabs(work));
        free(before), free(forces);
    }
    assert_true(work > 10.0 * stored);
    free(ways[0]), free(ways[1]);
    free_slid(&cloth);
}

/* Plastic parts begin at the rest shape: what was bent since then has slid. */
static void sliders_begin_at_the_rest_shape(void **state) {
    (void)state;
    slid cloth = make_slid(grid_make(12, 8, 0.06, 0.04, 2), make_cotton(), 0.0);
    double const width = 0.04, middle = 0.0303;
    for (int i = 0; i < 2; i++) {
        double const curvature = i ? -30.0 : 2.0; /* slides; sticks */
        roll(cloth.f, curvature);
        assert_int_equal(hysteresis_start(&cloth.f->model, get_state(&cloth), cloth.plastic),
                         TULLE_OK);
        double const wanted = fmax(RATIO * 1e-5 * curvature, -2.5e-4);
        double const found = measure_moment(&cloth, middle, width, curvature);
        assert_true(fabs(found - wanted) < 0.02 * fabs(wanted));
    }
    free_slid(&cloth);
}

/* A sheet that is folded at rest, hardly short of flat, has the kink of its fold. What creases it
 * further or opens it a little changes that kink by little. */
static void folds_keep_their_kink(void **state) {
    (void)state;
    double const degree = acos(-1.0) / 180.0;
    slid cloth = make_slid(grid_make(12, 8, 0.06, 0.04, 0), make_cotton(), 0.0);
    fixture *const f = cloth.f;
    size_t folded = 0;
    for (double angle = 170.0; angle < 179.95; angle += 0.5) {
        for (size_t v = 0; v < f->vertex_count; v++) {
            double const beyond = f->rest[3 * v] - 0.03;
            f->x[3 * v] = beyond > 1e-3 ? 0.03 + beyond * cos(angle * degree) : f->rest[3 * v];
            f->x[3 * v + 1] = beyond > 1e-3 ? beyond * sin(angle * degree) : 0.0;
        }
        for (size_t h = 0; h < f->model.hinge_count; h++) {
            const cloth_hinge *const hinge = &f->model.hinges[h];
            const double *const a = f->rest + 3 * (size_t)hinge->vertices[0];
            const double *const b = f->rest + 3 * (size_t)hinge->vertices[1];
            double const kink = hysteresis_measure_kink(&f->model, h, f->x).value;
            bool const is_folded = fabs(a[0] - 0.03) < 1e-9 && fabs(b[0] - 0.03) < 1e-9;
            double const wanted = is_folded ? 2.0 * sin(0.5 * angle * degree) * 0.005 : 0.0;
            assert_true(fabs(fabs(kink) - wanted) < 1e-12);
            folded += is_folded;
        }
    }
    assert_int_equal(folded, 8 * 20);
    free_slid(&cloth);
}

/* The same bits for any number of threads. */
static void threads_change_nothing(void **state) {
    (void)state;
    uint64_t hashes[3];
    for (int threads = 1; threads <= 3; threads++) {
        uint64_t random = 23;
        slid cloth = make_slid(grid_make(60, 50, 0.3, 0.25, 1), make_cotton(), 0.3);
        fixture *const f = cloth.f;
        f->threads = threads;
        crumple(&cloth, 0.001, &random);
        assemble(&cloth, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01, NULL, true);
        double const energy = measure_energy(&cloth);
        size_t const n = 3 * f->vertex_count;
        uint64_t hash = hash_bytes(HASH_SEED, f->system.forces, n * sizeof(double));
        hash = hash_bytes(hash, f->system.right_hand_side, n * sizeof(double));
        hash = hash_bytes(hash, f->system.matrix.values,
                          BLOCK_NUMBERS * f->system.matrix.block_count * sizeof(double));
        hash = hash_bytes(hash, f->system.slider_scalars, f->system.scalar_count * sizeof(double));
        hash = hash_bytes(hash, cloth.plastic, cloth.count * sizeof(double));
        hashes[threads - 1] = hash_bytes(hash, &energy, sizeof energy);
        free_slid(&cloth);
    }
    assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
}

/* Without hysteresis there is nothing of it, nor with springs. */
static void nothing_is_made_without_it(void **state) {
    (void)state;
    tulle_material material = make_cotton();
    fixture *f = fixture_make_grid(4, 4, 0.1, 0.1, 0, plain_material());
    assert_null(f->model.sliders);
    fixture_free(f);
    material.bend_hysteresis_warp = material.bend_hysteresis_weft = 0.0;
    f = fixture_weave_grid(grid_make(4, 4, 0.1, 0.1, 0), material, 0.0);
    assert_false(f->model.sliders->has_bend);
    assert_null(f->system.slider_scalars);
    fixture_free(f);
    material.shear_hysteresis = 0.0;
    f = fixture_weave_grid(grid_make(4, 4, 0.1, 0.1, 0), material, 0.0);
    assert_null(f->model.sliders);
    assert_int_equal(hysteresis_count(&f->model), 0);
    fixture_free(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loops_of_bending_are_as_wide_as_they_should),
        cmocka_unit_test(loops_of_shear_are_as_wide_as_they_should),
        cmocka_unit_test(forces_are_those_of_the_energy),
        cmocka_unit_test(matrix_is_definite),
        cmocka_unit_test(system_is_exact_at_its_guess),
        cmocka_unit_test(turning_feels_no_slider),
        cmocka_unit_test(closed_paths_take_energy),
        cmocka_unit_test(sliders_begin_at_the_rest_shape),
        cmocka_unit_test(folds_keep_their_kink),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(nothing_is_made_without_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
