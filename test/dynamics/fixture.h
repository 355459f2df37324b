/* test/dynamics/fixture.h - meshes, a model with its state, and one step, for the tests of
 * dynamics.
 */
#ifndef TULLE_TEST_DYNAMICS_FIXTURE_H
#define TULLE_TEST_DYNAMICS_FIXTURE_H

#include "base/hash.h"
#include "dynamics/compute_forces.h"
#include "support/solve_aim.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A cloth with one step of history and everything that a step needs. */
typedef struct fixture {
    memory heap;
    arena scratch;
    topology surface;
    cloth_model model;
    linear_system system;
    size_t vertex_count;
    double *rest, *x, *v, *mean, *previous_mean, *previous_v, *next_v;
    double *diagonal; /* of the system, by fixture_find_diagonal */
    uint8_t *is_fixed;
    environment surroundings;
    double previous_step, time;
    int threads;
    double tolerance;
    int iterations; /* of the last solve */
} fixture;

static inline double *copy_doubles(const double *source, size_t count) {
    double *const copy = calloc(count ? count : 1, sizeof(double));
    if (source) memcpy(copy, source, count * sizeof(double));
    return copy;
}

/* Cloth that starts at rest_positions; the def's surface is that of the triangles. */
static inline fixture *fixture_make_def(cloth_model_def def, const uint32_t *triangles,
                                        size_t triangle_count) {
    fixture *const f = calloc(1, sizeof *f);
    size_t const vertex_count = def.vertex_count;
    const double *const rest = def.rest_positions;
    f->heap = memory_default();
    f->scratch = arena_make(&f->heap);
    f->vertex_count = vertex_count;
    assert_int_equal(topology_build(&f->heap, triangles, triangle_count, vertex_count, &f->surface),
                     TULLE_OK);
    tulle_error error;
    def.surface = &f->surface;
    assert_int_equal(cloth_model_build(&f->heap, &def, &f->model, &error), TULLE_OK);
    assert_int_equal(linear_system_build(&f->heap, &f->model, true, &f->system), TULLE_OK);
    size_t const n = 3 * vertex_count;
    f->rest = copy_doubles(rest, n);
    f->diagonal = copy_doubles(NULL, 3 * n);
    f->x = copy_doubles(rest, n);
    f->v = copy_doubles(NULL, n);
    f->mean = copy_doubles(NULL, n);
    f->previous_mean = copy_doubles(NULL, n);
    f->previous_v = copy_doubles(NULL, n);
    f->next_v = copy_doubles(NULL, n);
    f->is_fixed = calloc(vertex_count, 1);
    f->threads = 1;
    f->tolerance = 1e-10;
    f->surroundings.wind.gust_length = f->surroundings.wind.gust_time = 1.0;
    return f;
}

/* Woven cloth; null warps: springs. */
static inline fixture *fixture_make_woven(const double *rest, size_t vertex_count,
                                          const uint32_t *triangles, size_t triangle_count,
                                          tulle_material material, const double *warps) {
    cloth_model_def const def = {.vertex_count = vertex_count,
                                 .rest_positions = rest,
                                 .materials = &material,
                                 .material_count = 1,
                                 .membrane = warps ? TULLE_MEMBRANE_WOVEN : TULLE_MEMBRANE_SPRINGS,
                                 .warps = warps};
    return fixture_make_def(def, triangles, triangle_count);
}

static inline fixture *fixture_make(const double *rest, size_t vertex_count,
                                    const uint32_t *triangles, size_t triangle_count,
                                    tulle_material material) {
    return fixture_make_woven(rest, vertex_count, triangles, triangle_count, material, NULL);
}

static inline void fixture_free(fixture *f) {
    linear_system_destroy(&f->heap, &f->system);
    cloth_model_destroy(&f->heap, &f->model);
    topology_destroy(&f->heap, &f->surface);
    arena_destroy(&f->scratch);
    assert_int_equal(f->heap.bytes_held, 0);
    free(f->rest), free(f->x), free(f->v), free(f->mean), free(f->previous_mean);
    free(f->previous_v), free(f->next_v), free(f->is_fixed), free(f->diagonal), free(f);
}

static inline cloth_start fixture_state(const fixture *f, double h) {
    return (cloth_start){.positions = f->x,
                         .velocities = f->v,
                         .previous_mean = f->previous_step > 0.0 ? f->previous_mean : NULL,
                         .previous_velocities = f->previous_step > 0.0 ? f->previous_v : NULL,
                         .time_step = h,
                         .previous_time_step = f->previous_step,
                         .time = f->time};
}

static inline void fixture_assemble(fixture *f, tulle_integrator integrator, double h) {
    cloth_start const state = fixture_state(f, h);
    assert_int_equal(compute_forces(&f->model, &state, &f->surroundings,
                                    (force_options){integrator, f->threads, 0.0, true}, &f->scratch,
                                    &f->system),
                     TULLE_OK);
}

/* The diagonal blocks of the system as assembled. */
static inline void fixture_find_diagonal(fixture *f) {
    block_matrix_get_diagonal(&f->system.matrix, f->diagonal, 2);
}

/* Solves the system as assembled, from the guess x; fixed vertices keep theirs. */
static inline void fixture_solve(fixture *f, double *x) {
    block_matrix_operator matrix = {&f->system.matrix, f->threads};
    fixture_find_diagonal(f);
    arena_mark const mark = arena_get_mark(&f->scratch);
    conjugate_gradients_problem problem = {.vertex_count = f->vertex_count,
                                           .apply = block_matrix_apply,
                                           .apply_context = &matrix,
                                           .right_hand_side = f->system.right_hand_side,
                                           .limit = 20000,
                                           .residual =
                                               ARENA_NEW(&f->scratch, double, 3 * f->vertex_count),
                                           .threads = f->threads};
    double *const inverse = ARENA_NEW(&f->scratch, double, BLOCK_NUMBERS * f->vertex_count);
    assert_true(problem.residual && inverse);
    conjugate_gradients_invert((preconditioner_source){f->diagonal, f->is_fixed}, f->vertex_count,
                               f->threads, inverse);
    problem.inverse = inverse;
    (void)aim_solve(&problem, x, f->tolerance, 0.0, &f->scratch);
    conjugate_gradients_result result;
    assert_int_equal(conjugate_gradients_solve(&problem, x, &f->scratch, &result), TULLE_OK);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
    f->iterations = result.iterations;
    arena_release(&f->scratch, mark);
}

/* One step without contact; fixed vertices stay. */
static inline void fixture_step(fixture *f, tulle_integrator integrator, double h) {
    size_t const n = 3 * f->vertex_count;
    fixture_assemble(f, integrator, h);
    for (size_t i = 0; i < n; i++) f->mean[i] = f->is_fixed[i / 3] ? 0.0 : f->v[i];
    fixture_solve(f, f->mean);
    cloth_start const state = fixture_state(f, h);
    finish_velocities(&f->system, &state, f->vertex_count, f->mean, f->next_v);
    for (size_t i = 0; i < n; i++)
        if (f->is_fixed[i / 3]) f->next_v[i] = f->mean[i];
    memcpy(f->previous_mean, f->mean, n * sizeof(double));
    memcpy(f->previous_v, f->v, n * sizeof(double));
    memcpy(f->v, f->next_v, n * sizeof(double));
    for (size_t i = 0; i < n; i++) f->x[i] += h * f->mean[i];
    f->previous_step = h;
    f->time += h;
}

/* A grid of columns x rows cells, size width x height in the xz plane (y up), z to the front.
 * pattern 0: all diagonals alike; 1: alternating; 2: random diagonals and jittered vertices, but
 * for the border and the second column. */
typedef struct grid {
    size_t vertex_count, triangle_count;
    double *positions;
    uint32_t *triangles;
} grid;

static inline grid grid_make(size_t columns, size_t rows, double width, double height,
                             int pattern) {
    grid g = {(columns + 1) * (rows + 1), 2 * columns * rows, NULL, NULL};
    g.positions = malloc(3 * g.vertex_count * sizeof(double));
    g.triangles = malloc(3 * g.triangle_count * sizeof(uint32_t));
    uint64_t random = 7;
    for (size_t j = 0; j <= rows; j++)
        for (size_t i = 0; i <= columns; i++) {
            bool const inner = i > 1 && i < columns && j > 0 && j < rows;
            double const dx = random_uniform(&random) - 0.5, dz = random_uniform(&random) - 0.5;
            double const jitter = pattern == 2 && inner ? 0.5 : 0.0;
            double *const p = g.positions + 3 * (j * (columns + 1) + i);
            p[0] = ((double)i + jitter * dx) * width / (double)columns;
            p[1] = 0.0;
            p[2] = ((double)j + jitter * dz) * height / (double)rows;
        }
    uint32_t *t = g.triangles;
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < columns; i++) {
            uint32_t const a = (uint32_t)(j * (columns + 1) + i), b = a + 1;
            uint32_t const c = a + (uint32_t)columns + 1, d = c + 1;
            bool const flip =
                pattern == 1 ? (i + j) % 2 == 1 : pattern == 2 && random_uniform(&random) < 0.5;
            uint32_t const straight[6] = {a, d, b, a, c, d}, flipped[6] = {a, c, b, b, c, d};
            memcpy(t, flip ? flipped : straight, sizeof straight);
            t += 6;
        }
    return g;
}

static inline void grid_free(grid *g) { free(g->positions), free(g->triangles); }

static inline fixture *fixture_make_grid(size_t columns, size_t rows, double width, double height,
                                         int pattern, tulle_material material) {
    grid g = grid_make(columns, rows, width, height, pattern);
    fixture *const f =
        fixture_make(g.positions, g.vertex_count, g.triangles, g.triangle_count, material);
    grid_free(&g);
    return f;
}

/* Woven cloth on a grid, which is freed; its warp at `angle` [rad] from x towards z. */
static inline fixture *fixture_weave_grid(grid g, tulle_material material, double angle) {
    double *const warps = malloc(3 * g.triangle_count * sizeof(double));
    for (size_t t = 0; t < g.triangle_count; t++) {
        warps[3 * t] = cos(angle);
        warps[3 * t + 1] = 0.0;
        warps[3 * t + 2] = sin(angle);
    }
    fixture *const f = fixture_make_woven(g.positions, g.vertex_count, g.triangles,
                                          g.triangle_count, material, warps);
    free(warps);
    grid_free(&g);
    return f;
}

static inline tulle_material plain_material(void) {
    return (tulle_material){
        .area_density = 0.2, .springs.stretch_stiffness = 500.0, .springs.bend_stiffness = 1e-4};
}

/* The matrix of the fixture's system, dense, 3 * vertex_count squared, row-major. */
static inline double *fixture_dense(fixture *f) {
    size_t const n = 3 * f->vertex_count;
    double *const dense = malloc(n * n * sizeof(double));
    double *const unit = calloc(n, sizeof(double)), *const column = calloc(n, sizeof(double));
    block_matrix_operator matrix = {&f->system.matrix, 1};
    for (size_t j = 0; j < n; j++) {
        unit[j] = 1.0;
        block_matrix_apply(&matrix, unit, column);
        for (size_t i = 0; i < n; i++) dense[i * n + j] = column[i];
        unit[j] = 0.0;
    }
    free(unit), free(column);
    return dense;
}

/* Cholesky factorisation in place (lower triangle); false where a pivot is not positive. */
static inline bool factor_cholesky(double *a, size_t n) {
    for (size_t j = 0; j < n; j++) {
        for (size_t k = 0; k < j; k++)
            for (size_t i = j; i < n; i++) a[i * n + j] -= a[i * n + k] * a[j * n + k];
        if (!(a[j * n + j] > 0.0)) return false;
        double const root = sqrt(a[j * n + j]);
        for (size_t i = j; i < n; i++) a[i * n + j] /= root;
    }
    return true;
}

static inline void solve_cholesky(const double *factor, size_t n, double *b) {
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++) b[i] -= factor[i * n + k] * b[k];
        b[i] /= factor[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++) b[i] -= factor[k * n + i] * b[k];
        b[i] /= factor[i * n + i];
    }
}

/* Uniform in [-1, 1]. */
static inline double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

#endif
