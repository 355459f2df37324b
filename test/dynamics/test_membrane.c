/* One membrane element against its energy: forces and damping by differences, the system's matrix
 * definite and exact where it can be, the guess, and the same bits from all kernels. */
#include "dynamics/fixture.h"
#include "dynamics/membrane.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { ELEMENTS = 19, COORDINATES = 9, ROOM = ELEMENTS + 8 };

typedef struct bench {
    membrane_element elements[ELEMENTS];
    membrane_fabric fabrics[2];
    double x[ELEMENTS * COORDINATES], v[ELEMENTS * COORDINATES], guess[ELEMENTS * COORDINATES];
    symmetric3 blocks[3 * ROOM];
    vec3 forces[3 * ROOM], sources[3 * ROOM];
    membrane_motion motion;
} bench;

static membrane_curve make_curve(double stiffness, double knee, double limit) {
    return (membrane_curve){stiffness, knee > 0.0 ? 1.0 / (knee * knee) : 0.0, limit,
                            knee > 0.0 ? 0.5 * knee : (double)INFINITY};
}

/* Elements of their own three corners, strained by up to `strain` from a random place and turn. */
static bench *make_bench(double strain, uint64_t seed) {
    bench *const b = calloc(1, sizeof *b);
    assert_non_null(b);
    b->fabrics[0] =
        (membrane_fabric){{make_curve(5000.0, 0.05, 0.15), make_curve(2800.0, 0.04, 0.12)},
                          make_curve(60.0, 0.1, 0.3),
                          300.0,
                          1e-3};
    b->fabrics[1] = (membrane_fabric){{make_curve(300.0, 0.0, 1.0), make_curve(300.0, 0.0, 1.0)},
                                      make_curve(112.5, 0.0, 1.0),
                                      100.0,
                                      0.0};
    for (size_t e = 0; e < ELEMENTS; e++) {
        membrane_element *const element = &b->elements[e];
        double rest[3][2] = {{0.0, 0.0}, {0.02, 0.0}, {0.0, 0.02}};
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 2; k++) rest[i][k] += 0.004 * random_signed(&seed);
        double const a = rest[1][0] - rest[0][0], c = rest[1][1] - rest[0][1];
        double const d = rest[2][0] - rest[0][0], f = rest[2][1] - rest[0][1];
        double const det = a * f - c * d;
        *element = (membrane_element){.gradients = {{f / det, -d / det}, {-c / det, a / det}},
                                      .area = 0.5 * det,
                                      .fabric = (uint32_t)(e % 2)};
        double axes[2][3];
        for (int i = 0; i < 2; i++)
            for (int k = 0; k < 3; k++) axes[i][k] = random_signed(&seed);
        double const length =
            sqrt(axes[0][0] * axes[0][0] + axes[0][1] * axes[0][1] + axes[0][2] * axes[0][2]);
        for (int k = 0; k < 3; k++) axes[0][k] /= length;
        double const along =
            axes[0][0] * axes[1][0] + axes[0][1] * axes[1][1] + axes[0][2] * axes[1][2];
        for (int k = 0; k < 3; k++) axes[1][k] -= along * axes[0][k];
        double const across =
            sqrt(axes[1][0] * axes[1][0] + axes[1][1] * axes[1][1] + axes[1][2] * axes[1][2]);
        for (int k = 0; k < 3; k++) axes[1][k] /= across;
        for (int i = 0; i < 3; i++) {
            element->corners[i] = (uint32_t)(3 * e) + (uint32_t)i;
            for (int k = 0; k < 3; k++) {
                size_t const at = COORDINATES * e + 3 * (size_t)i + (size_t)k;
                b->x[at] = rest[i][0] * axes[0][k] + rest[i][1] * axes[1][k] +
                           0.02 * strain * random_signed(&seed);
                b->v[at] = random_signed(&seed);
                b->guess[at] = random_signed(&seed);
            }
        }
    }
    b->motion = (membrane_motion){.elements = b->elements,
                                  .fabrics = b->fabrics,
                                  .element_count = ELEMENTS,
                                  .vertex_count = 3 * ELEMENTS,
                                  .positions = b->x,
                                  .velocities = b->v,
                                  .start_velocities = b->v,
                                  .time_step = 0.01,
                                  .alpha = 0.0,
                                  .beta = 1.0,
                                  .mean_share = 1.0,
                                  .blocks = b->blocks,
                                  .sources = b->sources};
    return b;
}

static void pad(const double *from, double *to) {
    for (size_t i = 0; i < ELEMENTS * COORDINATES; i++) to[i / 3 * 4 + i % 3] = from[i];
}

/* The system of the elements from `begin` on. Their forces are its sources without a w. */
static void fill_from(bench *b, size_t begin) {
    enum { PADDED = ELEMENTS * COORDINATES / 3 * 4 };
    double x[PADDED] = {0.0}, v[PADDED] = {0.0}, guess[PADDED] = {0.0}, none[PADDED] = {0.0};
    membrane_motion motion = b->motion;
    pad(b->x, x);
    pad(b->v, v);
    if (motion.guess) pad(motion.guess, guess);
    motion.positions = x;
    motion.velocities = v;
    motion.start_velocities = none;
    motion.guess = NULL;
    motion.sources = b->forces;
    TULLE_PICK_KERNEL(fill_membrane)(&motion, begin, ELEMENTS, 0, 0);
    motion.start_velocities = v;
    motion.guess = b->motion.guess ? guess : NULL;
    motion.sources = b->sources;
    TULLE_PICK_KERNEL(fill_membrane)(&motion, begin, ELEMENTS, 0, 0);
}

static void fill(bench *b) { fill_from(b, 0); }

/* ---- the energy, written down as the header has it ---- */

static double curve_energy(const membrane_curve *curve, double e) {
    double const knee2 = curve->inv_knee2, bent = fmin(e, curve->limit), taut = fmax(bent, 0.0);
    double const more = knee2 * taut * taut, beyond = e - bent;
    return curve->stiffness * (0.5 * bent * bent * (1.0 + 0.5 * more) +
                               (bent * (1.0 + more) + 0.5 * (1.0 + 3.0 * more) * beyond) * beyond);
}

typedef struct strain_state {
    double f[2][3], e[2], s;
} strain_state;

static strain_state find_strain(const membrane_element *element, const double *x) {
    strain_state state = {.s = 0.0};
    for (int a = 0; a < 2; a++) {
        double squares = 0.0;
        for (int k = 0; k < 3; k++) {
            state.f[a][k] = element->gradients[0][a] * (x[3 + k] - x[k]) +
                            element->gradients[1][a] * (x[6 + k] - x[k]);
            squares += state.f[a][k] * state.f[a][k];
        }
        state.e[a] = sqrt(squares) - 1.0;
    }
    for (int k = 0; k < 3; k++) state.s += state.f[0][k] * state.f[1][k];
    return state;
}

static double energy(const bench *b, size_t e, const double *x) {
    const membrane_element *const element = &b->elements[e];
    const membrane_fabric *const fabric = &b->fabrics[element->fabric];
    strain_state const at = find_strain(element, x);
    return element->area *
           (curve_energy(&fabric->yarns[0], at.e[0]) + curve_energy(&fabric->yarns[1], at.e[1]) +
            curve_energy(&fabric->shear, fabs(at.s)) + fabric->coupling * at.e[0] * at.e[1]);
}

static size_t count_overstretched(const bench *b) {
    size_t count = 0;
    for (size_t e = 0; e < ELEMENTS; e++) {
        const membrane_fabric *const fabric = &b->fabrics[b->elements[e].fabric];
        strain_state const at = find_strain(&b->elements[e], b->x + COORDINATES * e);
        count += at.e[0] > fabric->yarns[0].limit || at.e[1] > fabric->yarns[1].limit;
    }
    assert_in_range(count, 1, ELEMENTS - 1);
    return count;
}

/* Half of what damping takes [W]: its gradient by velocity is minus the force. */
static double dissipation(const bench *b, size_t e, const double *x, const double *v) {
    const membrane_element *const element = &b->elements[e];
    const membrane_fabric *const fabric = &b->fabrics[element->fabric];
    double const tiny = 1e-6;
    double more[COORDINATES], less[COORDINATES];
    for (int i = 0; i < COORDINATES; i++)
        more[i] = x[i] + tiny * v[i], less[i] = x[i] - tiny * v[i];
    strain_state const after = find_strain(element, more), before = find_strain(element, less);
    double const warp = (after.e[0] - before.e[0]) / (2.0 * tiny);
    double const weft = (after.e[1] - before.e[1]) / (2.0 * tiny);
    double const shear = (after.s - before.s) / (2.0 * tiny);
    return 0.5 * element->area * fabric->damping *
           (fabric->yarns[0].stiffness * warp * warp + fabric->yarns[1].stiffness * weft * weft +
            fabric->shear.stiffness * shear * shear);
}

/* ---- what the slots say ---- */

static double get_force(const vec3 forces[3], int corner, int axis) {
    return (&forces[corner].x)[axis];
}

/* The matrix of an element, 9 x 9: minus the blocks off the diagonal, whose rows sum to zero. */
static void get_matrix(const symmetric3 blocks[3], double matrix[COORDINATES][COORDINATES]) {
    static const int places[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    memset(matrix, 0, COORDINATES * sizeof *matrix);
    for (int k = 0; k < 3; k++) {
        int const a = 3 * k, b = 3 * ((k + 1) % 3);
        for (int p = 0; p < 9; p++) {
            double const value = blocks[k].m[places[p]];
            int const row = p / 3, column = p % 3;
            matrix[a + row][a + column] += value;
            matrix[b + row][b + column] += value;
            matrix[a + row][b + column] -= value;
            matrix[b + row][a + column] -= value;
        }
    }
}

/* x . M x for many x is not negative, but for rounding. */
static void assert_definite(double matrix[COORDINATES][COORDINATES]) {
    double trace = 0.0, rows[COORDINATES][COORDINATES];
    for (int i = 0; i < COORDINATES; i++) trace += matrix[i][i];
    /* Cholesky's method on the matrix with a little more on the diagonal ends only if it is
     * definite. */
    for (int i = 0; i < COORDINATES; i++)
        for (int j = 0; j <= i; j++) {
            double sum = matrix[i][j] + (i == j ? 1e-12 * trace : 0.0);
            for (int k = 0; k < j; k++) sum -= rows[i][k] * rows[j][k];
            if (i == j) assert_true(sum > 0.0);
            rows[i][j] = i == j ? sqrt(sum) : sum / rows[j][j];
        }
}

static void forces_are_the_slope_of_the_energy(void **state) {
    (void)state;
    static const double strains[] = {0.001, 0.05, 0.3, 1.0};
    for (size_t n = 0; n < 4; n++) {
        bench *const b = make_bench(strains[n], 3 + n);
        memset(b->v, 0, sizeof b->v);
        fill(b);
        for (size_t e = 0; e < ELEMENTS; e++) {
            double *const x = b->x + COORDINATES * e;
            double most = 1e-6;
            for (int i = 0; i < COORDINATES; i++)
                most = fmax(most, fabs(get_force(b->forces + 3 * e, i / 3, i % 3)));
            for (int i = 0; i < COORDINATES; i++) {
                double const kept = x[i], step = 1e-8;
                x[i] = kept + step;
                double const more = energy(b, e, x);
                x[i] = kept - step;
                double const slope = (more - energy(b, e, x)) / (2.0 * step);
                x[i] = kept;
                double const force = get_force(b->forces + 3 * e, i / 3, i % 3);
                double const source = get_force(b->sources + 3 * e, i / 3, i % 3);
                assert_true(fabs(force + slope) < 1e-5 * most);
                assert_true(fabs(source - force) < 1e-12 * most);
            }
        }
        free(b);
    }
}

static void damping_takes_what_it_says(void **state) {
    (void)state;
    bench *const b = make_bench(0.2, 11), *const still = make_bench(0.2, 11);
    memset(still->v, 0, sizeof still->v);
    fill(b);
    fill(still);
    for (size_t e = 0; e < ELEMENTS; e++) {
        const double *const x = b->x + COORDINATES * e;
        double *const v = b->v + COORDINATES * e;
        double const least = 1e-6 * (1.0 + dissipation(b, e, x, v));
        for (int i = 0; i < COORDINATES; i++) {
            double const kept = v[i], step = 1e-3;
            v[i] = kept + step;
            double const more = dissipation(b, e, x, v);
            v[i] = kept - step;
            double const slope = (more - dissipation(b, e, x, v)) / (2.0 * step);
            v[i] = kept;
            double const force = get_force(b->forces + 3 * e, i / 3, i % 3) -
                                 get_force(still->forces + 3 * e, i / 3, i % 3);
            assert_true(fabs(force + slope) < least + 1e-5 * fabs(slope));
        }
    }
    free(b);
    free(still);
}

/* Definite in every state: compressed, torn apart, sheared, folded to nothing. */
static void matrix_is_definite(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 400; round++) {
        bench *const b = make_bench(pow(10.0, 2.0 * random_signed(&seed)), 100 + (uint64_t)round);
        b->motion.alpha = round % 3 ? 0.01 : 0.0;
        b->motion.guess = round % 2 ? b->guess : NULL;
        if (round % 7 == 0)
            for (size_t e = 0; e < ELEMENTS; e++) /* two corners in one place, or all */
                for (int i = 0; i < (e % 3 ? 6 : 9); i++)
                    b->x[COORDINATES * e + (size_t)i] = (double)(i % 3);
        fill(b);
        for (size_t e = 0; e < ELEMENTS; e++) {
            double matrix[COORDINATES][COORDINATES];
            get_matrix(b->blocks + 3 * e, matrix);
            for (int i = 0; i < COORDINATES; i++)
                for (int j = 0; j < COORDINATES; j++) assert_true(isfinite(matrix[i][j]));
            assert_definite(matrix);
        }
        free(b);
    }
}

/* At rest nothing is dropped but that the coupling is that of shear. With one that is, the matrix
 * is the derivative of the forces. */
static void matrix_is_exact_at_rest(void **state) {
    (void)state;
    bench *const b = make_bench(0.0, 21), *const moved = make_bench(0.0, 21);
    for (int f = 0; f < 2; f++)
        b->fabrics[f].coupling = moved->fabrics[f].coupling = b->fabrics[f].shear.stiffness;
    memset(b->v, 0, sizeof b->v);
    memset(moved->v, 0, sizeof moved->v);
    fill(b);
    for (size_t e = 0; e < ELEMENTS; e++) {
        double matrix[COORDINATES][COORDINATES], most = 0.0;
        get_matrix(b->blocks + 3 * e, matrix);
        for (int i = 0; i < COORDINATES; i++) most = fmax(most, matrix[i][i]);
        for (int j = 0; j < COORDINATES; j++) {
            double *const x = &moved->x[COORDINATES * e + (size_t)j];
            double const kept = *x, step = 1e-7;
            double slopes[COORDINATES];
            *x = kept + step;
            fill(moved);
            for (int i = 0; i < COORDINATES; i++)
                slopes[i] = get_force(moved->forces + 3 * e, i / 3, i % 3);
            *x = kept - step;
            fill(moved);
            for (int i = 0; i < COORDINATES; i++)
                slopes[i] =
                    (slopes[i] - get_force(moved->forces + 3 * e, i / 3, i % 3)) / (2.0 * step);
            *x = kept;
            for (int i = 0; i < COORDINATES; i++)
                assert_true(fabs(slopes[i] + matrix[i][j]) < 2e-4 * most);
        }
    }
    free(b);
    free(moved);
}

/* A system linearised about a guess has, at the guess, the force that the cloth has there. */
static void guesses_meet_the_force_there(void **state) {
    (void)state;
    bench *const b = make_bench(0.02, 31), *const there = make_bench(0.02, 31);
    memset(b->v, 0, sizeof b->v);
    memset(there->v, 0, sizeof there->v);
    for (size_t i = 0; i < ELEMENTS * COORDINATES; i++) {
        b->guess[i] *= 0.01; /* little enough that no curve is cut short */
        there->x[i] += b->motion.time_step * b->guess[i];
    }
    b->motion.guess = b->guess;
    fill(b);
    fill(there);
    for (size_t e = 0; e < ELEMENTS; e++) {
        double matrix[COORDINATES][COORDINATES];
        get_matrix(b->blocks + 3 * e, matrix);
        for (int i = 0; i < COORDINATES; i++) {
            double force = get_force(b->sources + 3 * e, i / 3, i % 3);
            for (int j = 0; j < COORDINATES; j++)
                force -= matrix[i][j] * b->motion.time_step * b->guess[COORDINATES * e + (size_t)j];
            double const expected = get_force(there->forces + 3 * e, i / 3, i % 3);
            assert_true(fabs(force - expected) < 1e-9 + 1e-10 * fabs(expected));
        }
    }
    free(b);
    free(there);
}

/* V(x1) less what the system expects, V(x*) - f(x*) d + d M d / 2 with d from x* to x1; and V(x0).
 */
static void excess_is_what_was_not_linear(void **state) {
    (void)state;
    for (int round = 0; round < 4; round++) {
        bench *const b = make_bench(0.05, 51), *const there = make_bench(0.05, 51);
        memset(b->v, 0, sizeof b->v);
        memset(there->v, 0, sizeof there->v);
        double mean[ELEMENTS * COORDINATES], end[ELEMENTS * COORDINATES], total = 0.0;
        way_energies sum = {0.0, 0.0};
        uint64_t seed = 52;
        double const h = b->motion.time_step;
        b->motion.guess = round % 2 ? b->guess : NULL;
        for (size_t i = 0; i < ELEMENTS * COORDINATES; i++) {
            mean[i] = 0.1 * random_signed(&seed);
            end[i] = b->x[i] + h * mean[i];
            b->guess[i] *= 0.005;
            if (b->motion.guess) there->x[i] += h * b->guess[i];
        }
        fill(b);
        fill(there);
        for (size_t e = 0; e < ELEMENTS; e++) {
            double matrix[COORDINATES][COORDINATES];
            size_t const at = COORDINATES * e;
            get_matrix(b->blocks + 3 * e, matrix);
            double excess = energy(b, e, end + at) - energy(b, e, there->x + at), curvature = 0.0;
            total += energy(b, e, b->x + at);
            for (int i = 0; i < COORDINATES; i++) {
                double const d = end[at + (size_t)i] - there->x[at + (size_t)i];
                excess += get_force(there->forces + 3 * e, i / 3, i % 3) * d;
                for (int j = 0; j < COORDINATES; j++)
                    curvature +=
                        d * matrix[i][j] * (end[at + (size_t)j] - there->x[at + (size_t)j]);
            }
            sum.excess += excess - 0.5 * curvature;
            sum.curvature += curvature;
        }
        way_energies const found =
            TULLE_PICK_KERNEL(sum_membrane_excess)(&b->motion, mean, 0, ELEMENTS);
        membrane_energy const all = TULLE_PICK_KERNEL(sum_membrane_energy)(&b->motion, 0, ELEMENTS);
        assert_true(fabs(sum.excess) > 1e-6 * total && sum.curvature > 1e-3 * total);
        assert_true(fabs(found.excess - sum.excess) < 1e-9 * total);
        assert_true(fabs(found.curvature - sum.curvature) < 1e-9 * total);
        assert_true(fabs(all.energy - total) < 1e-12 * total);
        assert_true(all.max_stretch > 1.0 && all.max_stretch < 1.2);
        free(b);
        free(there);
    }
}

/* Corners that are thrown metres off, by squeezed vertices in a rough solve, are linearised no
 * farther off than a few lengths: then twice as far is next to the same. */
static void far_guesses_are_brought_near(void **state) {
    (void)state;
    bench *const b = make_bench(0.0, 47);
    symmetric3 near[3 * ELEMENTS];
    double far[ELEMENTS * COORDINATES] = {0.0};
    for (int times = 1; times <= 2; times++) {
        for (size_t e = 0; e < ELEMENTS; e++)
            for (size_t k = 0; k < 3; k++)
                far[COORDINATES * e + 6 + k] = 2000.0 * times * b->guess[COORDINATES * e + k];
        b->motion.guess = far;
        fill(b);
        if (times == 1) memcpy(near, b->blocks, sizeof near);
    }
    for (size_t i = 0; i < 3 * ELEMENTS; i++) {
        double most = 0.0;
        for (int k = 0; k < 6; k++) most = fmax(most, fabs(near[i].m[k]));
        assert_true(most > 0.0);
        for (int k = 0; k < 6; k++)
            assert_true(fabs(near[i].m[k] - b->blocks[i].m[k]) < 0.02 * most);
    }
    free(b);
}

/* The growth of the header, element by element, by the strains of this file. */
static void growth_is_that_of_the_longest_yarn(void **state) {
    (void)state;
    bench *const b = make_bench(0.15, 53), *const last = make_bench(0.25, 53);
    size_t grown = 0;
    double most = 0.0;
    for (size_t e = 0; e < ELEMENTS; e++) {
        const membrane_element *const element = &b->elements[e];
        strain_state const before = find_strain(element, b->x + COORDINATES * e);
        strain_state const after = find_strain(element, last->x + COORDINATES * e);
        double own = 0.0;
        for (int a = 0; a < 2; a++) {
            double const limit = b->fabrics[element->fabric].yarns[a].limit;
            own = fmax(own, (after.e[a] - fmax(before.e[a], 0.4 * limit)) / limit);
        }
        double const found = TULLE_PICK_KERNEL(find_yarn_growth)(&b->motion, last->x, e, e + 1);
        assert_true(fabs(found - own) < 1e-12);
        grown += own > 0.0;
        most = fmax(most, own);
    }
    assert_in_range(grown, 1, ELEMENTS - 1);
    double const all = TULLE_PICK_KERNEL(find_yarn_growth)(&b->motion, last->x, 0, ELEMENTS);
    assert_true(fabs(all - most) < 1e-12);
    free(b);
    free(last);
}

static void all_kernels_give_the_same_bits(void **state) {
    (void)state;
    kernel_target const widest = kernel_target_get();
    bench *const b = make_bench(0.3, 41);
    b->motion.guess = b->guess;
    b->motion.alpha = 0.01;
    bench *const first = make_bench(0.3, 41);
    double sums[KERNEL_TARGET_COUNT][3];
    assert_true(kernel_target_force(KERNEL_BASE));
    fill(b);
    size_t const block_bytes = 3 * ELEMENTS * sizeof *b->blocks;
    size_t const force_bytes = 3 * ELEMENTS * sizeof *b->forces;
    memcpy(first->blocks, b->blocks, block_bytes);
    memcpy(first->forces, b->forces, force_bytes);
    memcpy(first->sources, b->sources, force_bytes);
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (size_t begin = 0; begin < ELEMENTS; begin++) fill_from(b, begin); /* in any lane */
        assert_memory_equal(first->blocks, b->blocks, block_bytes);
        assert_memory_equal(first->forces, b->forces, force_bytes);
        assert_memory_equal(first->sources, b->sources, force_bytes);
        way_energies const way =
            TULLE_PICK_KERNEL(sum_membrane_excess)(&b->motion, b->v, 0, ELEMENTS);
        sums[target][0] = way.excess;
        sums[target][2] = way.curvature;
        membrane_energy const sum = TULLE_PICK_KERNEL(sum_membrane_energy)(&b->motion, 0, ELEMENTS);
        sums[target][1] = sum.energy;
        assert_memory_equal(sums[KERNEL_BASE], sums[target], sizeof sums[target]);
        assert_int_equal(sum.overstretched, count_overstretched(b));
    }
    kernel_target_force(widest);
    free(b);
    free(first);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_are_the_slope_of_the_energy),
        cmocka_unit_test(damping_takes_what_it_says),
        cmocka_unit_test(matrix_is_definite),
        cmocka_unit_test(matrix_is_exact_at_rest),
        cmocka_unit_test(guesses_meet_the_force_there),
        cmocka_unit_test(excess_is_what_was_not_linear),
        cmocka_unit_test(far_guesses_are_brought_near),
        cmocka_unit_test(growth_is_that_of_the_longest_yarn),
        cmocka_unit_test(all_kernels_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
