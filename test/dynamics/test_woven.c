/* Woven cloth as a whole: constants come out as they went in, on any mesh at any angle of the warp;
 * a strip pulled stays flat; derivatives and energies belong to the forces. */
#include "dynamics/fixture.h"

#include <math.h>
#include <stdio.h>

enum { PATTERNS = 3 };
static const double PI = 3.14159265358979323846;

static tulle_curve make_straight(double stiffness) { return (tulle_curve){stiffness, 0.0, 1.0}; }

static void set_bending(tulle_material *material, double rigidity) {
    material->bend_warp = material->bend_weft = rigidity;
    material->bend_twist = 0.5 * rigidity;
}

static tulle_material make_cotton(double rigidity) {
    tulle_material cotton = {.area_density = 0.2,
                             .warp = {4500.0, 0.05, 0.14},
                             .weft = {2800.0, 0.05, 0.14},
                             .shear = {60.0, 0.2, 0.5},
                             .stretch_damping = 1e-3};
    cotton.poisson = 300.0 / sqrt(cotton.warp.stiffness * cotton.weft.stiffness);
    set_bending(&cotton, rigidity);
    return cotton;
}

/* Moves the sheet by a displacement gradient in its plane. */
static void deform(fixture *f, const double by[2][2]) {
    for (size_t v = 0; v < f->vertex_count; v++) {
        double const x = f->rest[3 * v], z = f->rest[3 * v + 2];
        f->x[3 * v] = x + by[0][0] * x + by[0][1] * z;
        f->x[3 * v + 2] = z + by[1][0] * x + by[1][1] * z;
    }
}

/* [N/m] force per width on the side x = 0, in the directions x and z. */
static void pull(fixture *f, double height, double force[2]) {
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    force[0] = force[1] = 0.0;
    for (size_t v = 0; v < f->vertex_count; v++) {
        if (f->rest[3 * v] > 0.0) continue;
        force[0] += f->system.forces[3 * v] / height;
        force[1] += f->system.forces[3 * v + 2] / height;
    }
}

/* The same strain everywhere leaves no force within, and at the border that of the constants. */
static void constants_come_out_as_they_went_in(void **state) {
    (void)state;
    double const width = 0.5, height = 0.4, tiny = 1e-7;
    double const k1 = 4500.0, k2 = 2800.0, c = 300.0, g = 60.0;
    tulle_material const material = {.area_density = 0.2,
                                     .warp = make_straight(k1),
                                     .weft = make_straight(k2),
                                     .shear = make_straight(g),
                                     .poisson = c / sqrt(k1 * k2)};
    for (int pattern = 0; pattern < PATTERNS; pattern++)
        for (int turn = 0; turn < 8; turn++) {
            double const angle = turn * PI / 16.0, cosine = cos(angle), sine = sin(angle);
            fixture *const f =
                fixture_weave_grid(grid_make(7, 6, width, height, pattern), material, angle);
            for (int mode = 0; mode < 3; mode++) {
                /* strain [xx, zz, xz] and the stress that Hooke's law gives in the yarns' frame */
                double const exx = mode == 0, ezz = mode == 1, exz = mode == 2 ? 0.5 : 0.0;
                double const e1 =
                    exx * cosine * cosine + ezz * sine * sine + 2 * exz * sine * cosine;
                double const e2 =
                    exx * sine * sine + ezz * cosine * cosine - 2 * exz * sine * cosine;
                double const s =
                    2 * ((ezz - exx) * sine * cosine + exz * (cosine * cosine - sine * sine));
                double const t1 = k1 * e1 + c * e2, t2 = k2 * e2 + c * e1, q = g * s;
                double const txx = t1 * cosine * cosine + t2 * sine * sine - 2 * q * sine * cosine;
                double const txz = (t1 - t2) * sine * cosine + q * (cosine * cosine - sine * sine);
                double found[2][2];
                for (int sign = 0; sign < 2; sign++) { /* the linear part alone */
                    double const step = sign ? -tiny : tiny;
                    double const by[2][2] = {{step * exx, step * exz}, {step * exz, step * ezz}};
                    deform(f, by);
                    pull(f, height, found[sign]);
                    for (size_t v = 0; v < f->vertex_count; v++) {
                        double const x = f->rest[3 * v], z = f->rest[3 * v + 2];
                        if (x <= 0.0 || x >= width || z <= 0.0 || z >= height) continue;
                        for (size_t k = 0; k < 3; k++)
                            assert_true(fabs(f->system.forces[3 * v + k]) < 1e-12 * k1);
                    }
                }
                double const pulled = (found[0][0] - found[1][0]) / (2.0 * tiny);
                double const sheared = (found[0][1] - found[1][1]) / (2.0 * tiny);
                assert_true(fabs(pulled - txx) < 1e-8 * k1);
                assert_true(fabs(sheared - txz) < 1e-8 * k1);
            }
            fixture_free(f);
        }
}

/* df/dx of the system agrees with differences where nothing is dropped: taut cloth without shear,
 * coupled as shear is; and no state leaves it indefinite. */
static void matrix_belongs_to_the_forces(void **state) {
    (void)state;
    tulle_material material = make_cotton(0.0);
    material.poisson =
        material.shear.stiffness / sqrt(material.warp.stiffness * material.weft.stiffness);
    material.stretch_damping = 0.0;
    double const h = 0.01, step = 1e-7;
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        fixture *const f = fixture_weave_grid(grid_make(3, 3, 0.3, 0.3, pattern), material, 0.4);
        size_t const n = 3 * f->vertex_count;
        fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, h);
        double *const dense = fixture_dense(f);
        for (size_t j = 0; j < n; j++) {
            double const kept = f->x[j];
            double *const forces = malloc(n * sizeof *forces);
            f->x[j] = kept + step;
            fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, h);
            memcpy(forces, f->system.forces, n * sizeof *forces);
            f->x[j] = kept - step;
            fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, h);
            f->x[j] = kept;
            for (size_t i = 0; i < n; i++) {
                double const slope = (forces[i] - f->system.forces[i]) / (2.0 * step);
                double const mass = i == j ? f->model.masses[i / 3] : 0.0;
                assert_true(fabs(dense[i * n + j] - mass + h * h * slope) < 1e-4 * h * h * 4500.0);
            }
            free(forces);
        }
        free(dense);
        uint64_t seed = 3;
        for (int round = 0; round < 10; round++) {
            for (size_t i = 0; i < n; i++) f->x[i] = f->rest[i] + 0.2 * random_signed(&seed);
            fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, h);
            double *const shaken = fixture_dense(f);
            for (size_t i = 0; i < n; i++)
                for (size_t j = 0; j < i; j++) assert_true(shaken[i * n + j] == shaken[j * n + i]);
            assert_true(factor_cholesky(shaken, n));
            free(shaken);
        }
        fixture_free(f);
    }
}

/* Ends held and pulled apart by 5 %: the same tension on every mesh, and no zigzag. */
static void pulled_strip_stays_flat(void **state) {
    (void)state;
    enum { COLUMNS = 24, ROWS = 8, STEPS = 300 };
    double const length = 0.6, width = 0.2, strain = 0.05;
    tulle_material material = {.area_density = 0.2, /* E 300, nu 1/3 */
                               .warp = make_straight(337.5),
                               .weft = make_straight(337.5),
                               .shear = make_straight(112.5),
                               .poisson = 1.0 / 3.0,
                               .stretch_damping = 1e-3};
    set_bending(&material, 1e-6);
    double tensions[PATTERNS];
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        fixture *const f =
            fixture_weave_grid(grid_make(COLUMNS, ROWS, length, width, pattern), material, 0.0);
        uint64_t seed = 9;
        for (size_t v = 0; v < f->vertex_count; v++) {
            size_t const column = v % (COLUMNS + 1);
            f->x[3 * v] *= 1.0 + strain;
            f->is_fixed[v] = column == 0 || column == COLUMNS;
            if (!f->is_fixed[v]) f->x[3 * v + 1] += 1e-3 * random_signed(&seed);
        }
        for (int i = 0; i < STEPS; i++) {
            fixture_step(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.02);
            for (size_t k = 0; k < 3 * f->vertex_count; k++) f->v[k] *= 0.9;
        }
        double force[2], bump = 0.0;
        pull(f, width, force);
        for (size_t v = 0; v < f->vertex_count; v++) bump = fmax(bump, fabs(f->x[3 * v + 1]));
        print_message("pattern %d: %.5g N/m, bumps %.2g mm\n", pattern, force[0], 1e3 * bump);
        tensions[pattern] = force[0];
        assert_true(bump < 1e-5);
        fixture_free(f);
    }
    for (int pattern = 1; pattern < PATTERNS; pattern++)
        assert_true(fabs(tensions[pattern] / tensions[0] - 1.0) < 0.01);
}

/* ---- bending ---- */

/* The constant bending matrix, dense. */
static double *get_bending(const fixture *f) {
    const cloth_model *const model = &f->model;
    size_t const n = model->vertex_count;
    double *const dense = calloc(n * n, sizeof *dense);
    for (size_t v = 0; v < n; v++) {
        for (size_t k = model->block_begin[v]; k < model->block_begin[v + 1]; k++)
            dense[n * v + model->block_columns[k]] += model->bend_blocks[k];
        for (size_t k = model->scalar_begin[v]; k < model->scalar_begin[v + 1]; k++)
            dense[n * v + model->scalar_columns[k]] += model->bend_scalars[k];
    }
    return dense;
}

/* What a strip under load sags in its middle, its ends on supports, over what theory says. */
static double sag_of_strip(int pattern, size_t columns, size_t rows) {
    double const length = 0.2, width = 0.025, rigidity = 1e-5;
    tulle_material const material = make_cotton(rigidity);
    fixture *const f =
        fixture_weave_grid(grid_make(columns, rows, length, width, pattern), material, 0.3);
    size_t const n = f->vertex_count;
    double *const matrix = get_bending(f), *const heights = calloc(n, sizeof *heights);
    for (size_t v = 0; v < n; v++) {
        size_t const column = v % (columns + 1);
        heights[v] = f->model.masses[v] / material.area_density; /* load of 1 Pa */
        for (size_t i = 0; i < n; i++)
            if (fabs(matrix[n * v + i] - matrix[n * i + v]) > 1e-12 * matrix[n * v + v])
                fail_msg("not symmetric");
        if (column > 0 && column < columns) continue;
        heights[v] = 0.0;
        for (size_t i = 0; i < n; i++) matrix[n * v + i] = matrix[n * i + v] = i == v;
    }
    assert_true(factor_cholesky(matrix, n));
    solve_cholesky(matrix, n, heights);
    double sum = 0.0;
    size_t count = 0;
    for (size_t v = 0; v < n; v++) {
        double const x = f->rest[3 * v];
        if (fabs(x - 0.5 * length) > 0.51 * length / (double)columns) continue;
        double const exact =
            (x * x * x * x - 2.0 * length * x * x * x + length * length * length * x) /
            (24.0 * rigidity);
        sum += heights[v] / exact;
        count++;
    }
    free(matrix);
    free(heights);
    fixture_free(f);
    return sum / (double)count;
}

/* A strip is as stiff as theory says, on any mesh, its free borders included. */
static void strips_sag_as_theory_says(void **state) {
    (void)state;
    for (int pattern = 0; pattern < PATTERNS; pattern++)
        for (size_t rows = 1; rows <= 5; rows++) {
            double const ratio = sag_of_strip(pattern, 8 * rows, rows);
            print_message("pattern %d, %zu rows: %.4f\n", pattern, rows, ratio);
            assert_true(fabs(ratio - 1.0) < 0.015 / (double)(rows * rows) + 1e-3);
        }
}

/* The matrix times heights that are quadratic is zero but near the border, in every direction: a
 * constant moment does no work within the mesh. */
static void constant_moments_do_no_work_within(void **state) {
    (void)state;
    double const rigidity = 1e-5, size = 1.0;
    tulle_material const material = make_cotton(rigidity);
    enum { CELLS = 16, DIRECTIONS = 8 };
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        fixture *const f =
            fixture_weave_grid(grid_make(CELLS, CELLS, size, size, pattern), material, 0.3);
        size_t const n = f->vertex_count;
        double *const matrix = get_bending(f);
        double most = 0.0;
        for (size_t v = 0; v < n; v++) most = fmax(most, matrix[n * v + v]);
        for (int turn = 0; turn < DIRECTIONS; turn++) {
            double const angle = turn * PI / DIRECTIONS;
            double *const heights = calloc(n, sizeof *heights);
            for (size_t v = 0; v < n; v++) {
                double const u = cos(angle) * f->rest[3 * v] + sin(angle) * f->rest[3 * v + 2];
                heights[v] = 0.5 * u * u;
            }
            for (size_t v = 0; v < n; v++) {
                size_t const column = v % (CELLS + 1), row = v / (CELLS + 1);
                if (column < 3 || column + 3 > CELLS || row < 3 || row + 3 > CELLS) continue;
                double force = 0.0;
                for (size_t i = 0; i < n; i++) force += matrix[n * v + i] * heights[i];
                assert_true(fabs(force) < 1e-9 * most);
            }
            free(heights);
        }
        free(matrix);
        fixture_free(f);
    }
}

static const bool IS_FLAT = true;

/* A pattern: each triangle lies at rest anywhere in the plane, with its warp. */
typedef struct pattern {
    grid g;
    double *corners, *warps; /* of all triangles */
} pattern;

static pattern cut_pattern(double scale, bool is_turned) {
    pattern p = {.g = grid_make(6, 5, 0.3, 0.2, 2)};
    p.corners = malloc(9 * p.g.triangle_count * sizeof(double));
    p.warps = malloc(3 * p.g.triangle_count * sizeof(double));
    uint64_t random = 11;
    for (size_t t = 0; t < p.g.triangle_count; t++) {
        double const angle = is_turned ? PI * random_signed(&random) : 0.0;
        double const away[2] = {is_turned ? random_signed(&random) : 0.0,
                                is_turned ? random_signed(&random) : 0.0};
        double const c = cos(angle), s = sin(angle);
        p.warps[3 * t] = c, p.warps[3 * t + 1] = 0.0, p.warps[3 * t + 2] = s;
        for (size_t k = 0; k < 3; k++) {
            const double *const from = p.g.positions + 3 * (size_t)p.g.triangles[3 * t + k];
            double *const to = p.corners + 9 * t + 3 * k;
            to[0] = scale * (c * from[0] - s * from[2]) + away[0];
            to[1] = 0.0;
            to[2] = scale * (s * from[0] + c * from[2]) + away[1];
        }
    }
    return p;
}

static void free_pattern(pattern *p) {
    grid_free(&p->g);
    free(p->corners);
    free(p->warps);
}

/* Forces, in a random shape, of cloth with this rest shape; 3 * vertex_count. */
static double *find_forces(const grid *g, const double *rest, const double *corners,
                           const double *warps) {
    tulle_material const cotton = make_cotton(1e-3);
    cloth_model_def const def = {.vertex_count = g->vertex_count,
                                 .rest_positions = rest,
                                 .rest_corners = corners,
                                 .has_flat_rest = corners ? &IS_FLAT : NULL,
                                 .materials = &cotton,
                                 .material_count = 1,
                                 .membrane = TULLE_MEMBRANE_WOVEN,
                                 .warps = warps};
    fixture *const f = fixture_make_def(def, g->triangles, g->triangle_count);
    uint64_t random = 5;
    for (size_t i = 0; i < 3 * g->vertex_count; i++)
        f->x[i] = g->positions[i] + 2e-3 * random_signed(&random);
    fixture_assemble(f, TULLE_INTEGRATOR_IMPLICIT_EULER, 0.01);
    double *const forces = copy_doubles(f->system.forces, 3 * g->vertex_count);
    fixture_free(f);
    return forces;
}

static void a_pattern_may_lie_anywhere(void **state) {
    (void)state;
    pattern whole = cut_pattern(1.0, false), cut = cut_pattern(1.0, true);
    double *const plain = find_forces(&whole.g, whole.g.positions, NULL, whole.warps);
    double *const same = find_forces(&whole.g, whole.g.positions, whole.corners, whole.warps);
    double *const cut_up = find_forces(&cut.g, cut.g.positions, cut.corners, cut.warps);
    double largest = 0.0;
    for (size_t i = 0; i < 3 * whole.g.vertex_count; i++) largest = fmax(largest, fabs(plain[i]));
    assert_memory_equal(same, plain, 3 * whole.g.vertex_count * sizeof(double));
    for (size_t i = 0; i < 3 * whole.g.vertex_count; i++)
        assert_true(fabs(cut_up[i] - plain[i]) < 1e-10 * largest);
    free(plain), free(same), free(cut_up);
    free_pattern(&whole);
    free_pattern(&cut);
}

static void a_pattern_may_be_smaller_than_the_start(void **state) {
    (void)state;
    double const scale = 0.9;
    pattern whole = cut_pattern(1.0, false), small = cut_pattern(scale, true);
    double *const rest = copy_doubles(whole.g.positions, 3 * whole.g.vertex_count);
    for (size_t i = 0; i < 3 * whole.g.vertex_count; i++) rest[i] *= scale;
    double *const plain = find_forces(&whole.g, rest, NULL, whole.warps);
    double *const cut_up = find_forces(&small.g, small.g.positions, small.corners, small.warps);
    double largest = 0.0;
    for (size_t i = 0; i < 3 * whole.g.vertex_count; i++) largest = fmax(largest, fabs(plain[i]));
    for (size_t i = 0; i < 3 * whole.g.vertex_count; i++)
        assert_true(fabs(cut_up[i] - plain[i]) < 1e-10 * largest);
    free(plain), free(cut_up), free(rest);
    free_pattern(&whole);
    free_pattern(&small);
}

/* Rolled up, its lengths those of the flat pattern: the fold is that of the rest positions. */
static void folds_are_those_of_the_rest_positions(void **state) {
    (void)state;
    pattern p = cut_pattern(1.0, false);
    double const radius = 0.2;
    tulle_material material = make_cotton(1e-3);
    double energies[4]; /* the last: of flat cloth that is rolled up */
    for (int way = 0; way < 4; way++) {
        double *const rolled = copy_doubles(p.g.positions, 3 * p.g.vertex_count);
        for (size_t v = 0; v < p.g.vertex_count; v++) {
            double const angle = p.g.positions[3 * v] / radius;
            rolled[3 * v] = radius * sin(angle);
            rolled[3 * v + 1] = radius * (1.0 - cos(angle));
        }
        cloth_model_def const def = {.vertex_count = p.g.vertex_count,
                                     .rest_positions = way == 3 ? p.g.positions : rolled,
                                     .rest_corners = way == 1 || way == 2 ? p.corners : NULL,
                                     .has_flat_rest = way == 2 ? &IS_FLAT : NULL,
                                     .materials = &material,
                                     .material_count = 1,
                                     .membrane = TULLE_MEMBRANE_WOVEN,
                                     .warps = p.warps};
        fixture *const f = fixture_make_def(def, p.g.triangles, p.g.triangle_count);
        memcpy(f->x, rolled, 3 * p.g.vertex_count * sizeof(double));
        cloth_energies found = {0};
        assert_int_equal(compute_energies(&f->model, f->x, f->v, (energy_options){.threads = 1},
                                          &f->scratch, &found),
                         TULLE_OK);
        energies[way] = found.elastic.bend;
        fixture_free(f);
        free(rolled);
    }
    double const flat = energies[3];
    assert_true(flat > 0.0);
    assert_true(energies[0] < 1e-12 * flat);
    assert_true(energies[1] < 1e-3 * flat);
    assert_true(fabs(energies[2] - flat) < 1e-12 * flat);
    free_pattern(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pattern_may_lie_anywhere),
        cmocka_unit_test(a_pattern_may_be_smaller_than_the_start),
        cmocka_unit_test(folds_are_those_of_the_rest_positions),
        cmocka_unit_test(constants_come_out_as_they_went_in),
        cmocka_unit_test(matrix_belongs_to_the_forces),
        cmocka_unit_test(pulled_strip_stays_flat),
        cmocka_unit_test(strips_sag_as_theory_says),
        cmocka_unit_test(constant_moments_do_no_work_within),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
