/* Where the linear solve stands against this machine: time and bytes of an iteration of conjugate
 * gradients for square cloths of several sizes, with the matrix by rows and by diagonals, and in
 * the same rounds how fast arrays of those bytes are read and copied and how fast numbers are
 * multiplied and added in registers. Prints Markdown; least times of the rounds. Usage: bench_solve
 * [rounds] [most vertices a side] [threads]
 */
#include "base/hash.h"
#include "base/timer.h"
#include "dynamics/compute_forces.h"
#include "math/single_solve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FEW_ITERATIONS = 8, MANY_ITERATIONS = 40, FLOP_ROUNDS = 20000 };
static const size_t SIDES[] = {45, 99, 199, 400, 1000};
static const double STEP = 1.0 / 90.0; /* [s] */

typedef float lanes16 __attribute__((vector_size(64)));

/* A sheet that folds in waves of some cells: stretched here, compressed there. */
typedef struct bench_cloth {
    size_t side, vertex_count, triangle_count;
    double *rest, *positions, *velocities, *u, *inverse, *residual;
    uint32_t *triangles;
    memory heap;
    arena scratch;
    topology surface;
    cloth_model model;
    linear_system system;
    block_matrix by_rows;             /* the system's matrix, as one that has no diagonals */
    single_system singles[2];         /* by rows, by diagonals */
    nested_aggregates *aggregates[2]; /* likewise */
} bench_cloth;

static void *room(size_t count, size_t size) {
    void *const data = calloc(count + 16, size);
    if (data) return data;
    fprintf(stderr, "bench_solve: no memory left\n");
    exit(1);
}

static void make_mesh(bench_cloth *cloth) {
    size_t const n = cloth->side;
    cloth->vertex_count = n * n;
    cloth->triangle_count = 2 * (n - 1) * (n - 1);
    cloth->rest = room(3 * n * n, sizeof(double));
    cloth->positions = room(3 * n * n, sizeof(double));
    cloth->velocities = room(3 * n * n, sizeof(double));
    cloth->u = room(3 * n * n, sizeof(double));
    cloth->triangles = room(3 * cloth->triangle_count, sizeof(uint32_t));
    uint64_t random = 1;
    double const edge = 2.0 / 98.0; /* [m] as the scenes have it at 99 x 99 */
    for (size_t v = 0; v < n * n; v++) {
        double const at[3] = {edge * (double)(v % n), edge * (double)(v / n), 0.0};
        memcpy(cloth->rest + 3 * v, at, sizeof at);
        memcpy(cloth->positions + 3 * v, at, sizeof at);
        cloth->positions[3 * v] *= 0.97;
        cloth->positions[3 * v + 2] = 0.4 * edge * sin(9.0 * at[0]) * cos(7.0 * at[1]);
        for (size_t i = 0; i < 3; i++)
            cloth->velocities[3 * v + i] = 0.2 * random_uniform(&random) - 0.1;
    }
    uint32_t *to = cloth->triangles;
    for (uint32_t j = 0; j + 1 < n; j++)
        for (uint32_t i = 0; i + 1 < n; i++) {
            uint32_t const a = j * (uint32_t)n + i, b = a + (uint32_t)n;
            uint32_t const corners[6] = {a, a + 1, b + 1, a, b + 1, b};
            memcpy(to, corners, sizeof corners);
            to += 6;
        }
}

static void check(bool is_fine, const char *what) {
    if (is_fine) return;
    fprintf(stderr, "bench_solve: %s failed\n", what);
    exit(1);
}

static bench_cloth *make_cloth(size_t side, int threads) {
    bench_cloth *const cloth = room(1, sizeof *cloth);
    cloth->side = side;
    cloth->heap = memory_default();
    cloth->scratch = arena_make(&cloth->heap);
    make_mesh(cloth);
    tulle_material cotton;
    tulle_error error;
    check(tulle_material_preset("cotton", &cotton) == TULLE_OK, "the preset");
    check(topology_build(&cloth->heap, cloth->triangles, cloth->triangle_count, cloth->vertex_count,
                         &cloth->surface) == TULLE_OK,
          "the topology");
    cloth_model_def const def = {.vertex_count = cloth->vertex_count,
                                 .surface = &cloth->surface,
                                 .rest_positions = cloth->rest,
                                 .materials = &cotton,
                                 .material_count = 1};
    check(cloth_model_build(&cloth->heap, &def, &cloth->model, &error) == TULLE_OK, "the model");
    check(linear_system_build(&cloth->heap, &cloth->model, false, &cloth->system) == TULLE_OK,
          "the system");
    cloth_start const state = {
        .positions = cloth->positions, .velocities = cloth->velocities, .time_step = STEP};
    environment const still = {.gravity = {0.0, 0.0, -9.81},
                               .wind = {.gust_length = 1.0, .gust_time = 1.0}};
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, threads, 0.0, false};
    check(compute_forces(&cloth->model, &state, &still, options, &cloth->scratch, &cloth->system) ==
              TULLE_OK,
          "the forces");
    const block_matrix *const matrix = &cloth->system.matrix;
    double *const diagonal = room(9 * cloth->vertex_count, sizeof(double));
    cloth->inverse = room(BLOCK_NUMBERS * cloth->vertex_count, sizeof(double));
    cloth->residual = room(3 * cloth->vertex_count, sizeof(double));
    block_matrix_get_diagonal(matrix, diagonal, 2);
    conjugate_gradients_invert((preconditioner_source){.diagonal = diagonal}, cloth->vertex_count,
                               2, cloth->inverse);
    free(diagonal);
    cloth->by_rows = *matrix;
    cloth->by_rows.diagonals = (matrix_diagonals){0};
    const block_matrix *const matrices[2] = {&cloth->by_rows, matrix};
    for (int way = 0; way < 2; way++)
        check(single_system_make(matrices[way], &cloth->scratch, &cloth->singles[way]) &&
                  single_system_set_terms(&cloth->singles[way], NULL, 0, threads, &cloth->scratch),
              "the copy");
    check(cloth->singles[1].diagonals.pattern != NULL, "the copy by diagonals");
    for (int way = 0; way < 2; way++) {
        nested_aggregates *const aggregates =
            nested_aggregates_build(&cloth->heap, matrices[way], &cloth->scratch);
        check(aggregates != NULL, "the aggregates");
        aggregated_system const all = {.matrix = matrices[way]};
        check(nested_aggregates_set(aggregates, &all, threads, &cloth->scratch),
              "the numbers of aggregates");
        cloth->aggregates[way] = aggregates;
    }
    return cloth;
}

static void destroy_cloth(bench_cloth *cloth) {
    for (int way = 0; way < 2; way++)
        nested_aggregates_destroy(&cloth->heap, cloth->aggregates[way]);
    linear_system_destroy(&cloth->heap, &cloth->system);
    cloth_model_destroy(&cloth->heap, &cloth->model);
    topology_destroy(&cloth->heap, &cloth->surface);
    arena_destroy(&cloth->scratch);
    free(cloth->inverse);
    free(cloth->residual);
    free(cloth->rest), free(cloth->positions), free(cloth->velocities), free(cloth->u);
    free(cloth->triangles), free(cloth);
}

/* ---- what the machine does ---- */

/* For several vector widths, one of which is chosen when the program loads. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__linux__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TULLE_VECTOR_CLONES __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define TULLE_VECTOR_CLONES
#endif

/* Reads as the product does: sixteen lanes of single precision. */
TULLE_VECTOR_CLONES
static float read_all(const float *data, size_t count) {
    lanes16 sums[4] = {{0.0F}, {0.0F}, {0.0F}, {0.0F}};
    for (size_t i = 0; i + 64 <= count; i += 64)
        for (size_t k = 0; k < 4; k++) sums[k] += *(const lanes16 *)(data + i + 16 * k);
    lanes16 const sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    return sum[0] + sum[7];
}

/* Products and sums that wait for nothing but their own lane. */
TULLE_VECTOR_CLONES
static float multiply_and_add(float start, size_t rounds) {
    lanes16 sums[10], factor = {0.0F};
    factor += 0.999F;
    for (size_t k = 0; k < 10; k++) sums[k] = factor * (start + (float)k);
    for (size_t i = 0; i < rounds; i++)
        for (size_t k = 0; k < 10; k++) sums[k] = sums[k] * factor + factor;
    float sum = 0.0F;
    for (size_t k = 0; k < 10; k++) sum += sums[k][0];
    return sum;
}

/* ---- measures ---- */

typedef struct bench_times {
    double product, product_double, plain, aggregated, read, copy; /* [s], least */
} bench_times;

static volatile float sink; /* so that nothing is left out */

static void keep_least(double *least, double start) { *least = fmin(*least, timer_now() - start); }

static double time_iterations(bench_cloth *cloth, single_system *single, bool has_aggregates,
                              int iterations, int threads) {
    block_matrix_operator matrix = {&cloth->system.matrix, threads};
    conjugate_gradients_problem const problem = {.vertex_count = cloth->vertex_count,
                                                 .apply = block_matrix_apply,
                                                 .apply_context = &matrix,
                                                 .right_hand_side = cloth->system.right_hand_side,
                                                 .inverse = cloth->inverse,
                                                 .target = 1e-12,
                                                 .late_target = 1e-12,
                                                 .limit = iterations,
                                                 .residual = cloth->residual,
                                                 .threads = threads};
    single->aggregates = has_aggregates ? cloth->aggregates[single - cloth->singles] : NULL;
    memset(cloth->u, 0, 3 * cloth->vertex_count * sizeof(double));
    memcpy(cloth->residual, problem.right_hand_side, 3 * cloth->vertex_count * sizeof(double));
    conjugate_gradients_result result;
    double const start = timer_now();
    check(single_solve(&problem, single, NULL, cloth->u, &cloth->scratch, &result) == TULLE_OK,
          "a solve");
    double const seconds = timer_now() - start;
    check(result.iterations == iterations, "a solve of that many iterations");
    return seconds;
}

/* Of one iteration: the difference of a long solve and a short one. */
static void time_iteration(bench_cloth *cloth, single_system *single, bool has_aggregates,
                           int threads, double *least) {
    double const few = time_iterations(cloth, single, has_aggregates, FEW_ITERATIONS, threads);
    double const many = time_iterations(cloth, single, has_aggregates, MANY_ITERATIONS, threads);
    *least = fmin(*least, (many - few) / (MANY_ITERATIONS - FEW_ITERATIONS));
}

static size_t get_matrix_bytes(const block_matrix *matrix) {
    const matrix_diagonals *const d = &matrix->diagonals;
    if (d->count > 0)
        return matrix->row_count * sizeof(float) *
               (SINGLE_BLOCK * d->block_count + (d->count - d->block_count));
    return matrix->block_count * (SINGLE_BLOCK * sizeof(float) + sizeof(uint32_t)) +
           matrix->scalar_count * (sizeof(float) + sizeof(uint32_t)) +
           2 * matrix->row_count * sizeof(uint32_t);
}

/* Vectors of an iteration by blocks of the diagonal, each time one is read or written: product 2,
 * advance 9 with the inverse as 2, turn 3. */
static size_t get_iteration_bytes(const block_matrix *matrix) {
    return get_matrix_bytes(matrix) + matrix->row_count * 14 * 3 * sizeof(float);
}

static void run_round(bench_cloth *cloth, single_system *single, int threads, float *from,
                      float *to, bench_times *times) {
    const block_matrix *const matrix = single->matrix;
    size_t const count = get_matrix_bytes(matrix) / sizeof(float);
    arena_mark const mark = arena_get_mark(&cloth->scratch);
    single_vectors v;
    check(single_vectors_make(single, &cloth->scratch, &v), "memory for vectors");
    for (size_t i = 0; i < 3 * matrix->row_count; i++)
        v.direction[i / 3 * v.vertex_step + i % 3 * v.number_step] = (float)cloth->velocities[i];
    for (int i = 0; i < 3; i++) {
        double start = timer_now();
        sink = single_system_multiply(single, &v, 0, matrix->row_count);
        keep_least(&times->product, start);
    }
    arena_release(&cloth->scratch, mark);
    for (int i = 0; i < 3; i++) {
        double start = timer_now();
        sink = read_all(from, count);
        keep_least(&times->read, start);
    }
    for (int i = 0; i < 3; i++) {
        double start = timer_now();
        memcpy(to, from, count / 2 * sizeof(float));
        keep_least(&times->copy, start);
        sink = to[count / 4];
    }
    block_matrix_operator product = {matrix, 1};
    double start = timer_now();
    block_matrix_apply(&product, cloth->velocities, cloth->u);
    keep_least(&times->product_double, start);
    time_iteration(cloth, single, false, threads, &times->plain);
    time_iteration(cloth, single, true, threads, &times->aggregated);
}

static void measure(bench_cloth *cloth, int rounds, int threads, bench_times times[2]) {
    size_t const count = get_matrix_bytes(&cloth->by_rows) / sizeof(float);
    float *const from = aligned_alloc(64, (count / 16 + 1) * 64);
    float *const to = aligned_alloc(64, (count / 16 + 1) * 64);
    check(from && to, "memory");
    for (size_t i = 0; i < count; i++) from[i] = to[i] = 1e-3F * (float)(i % 100);
    double const never = (double)INFINITY;
    for (int way = 0; way < 2; way++)
        times[way] = (bench_times){never, never, never, never, never, never};
    for (int r = 0; r < rounds; r++)
        for (int way = 0; way < 2; way++)
            run_round(cloth, &cloth->singles[way], threads, from, to, &times[way]);
    free(from), free(to);
}

static void print_cloth(const bench_cloth *cloth, int way, const bench_times *times, int threads) {
    const block_matrix *const matrix = cloth->singles[way].matrix;
    double const bytes = (double)get_matrix_bytes(matrix);
    double const operations =
        18.0 * (double)matrix->block_count + 6.0 * (double)matrix->scalar_count;
    printf("| %zu, by %s | %.2f | %.2f | %.3f | %.1f | %.1f | %.1f | %.2f | %.1f | %.3f | %d: "
           "%.3f, %.3f |\n",
           cloth->vertex_count, way == 0 ? "rows" : "diagonals", 1e-6 * bytes,
           1e-6 * (double)get_iteration_bytes(matrix), 1e3 * times->product,
           1e-9 * bytes / times->product, 1e-9 * bytes / times->read, 1e-9 * bytes / times->copy,
           times->product / times->read, 1e-9 * operations / times->product,
           1e3 * times->product_double, threads, 1e3 * times->plain, 1e3 * times->aggregated);
    fflush(stdout);
}

int main(int argc, char **argv) {
    int const rounds = argc > 1 ? atoi(argv[1]) : 15;
    size_t const most = argc > 2 ? (size_t)atoi(argv[2]) : 400;
    int const threads = argc > 3 ? atoi(argv[3]) : 1;
    check(rounds > 0 && most >= SIDES[0] && threads > 0, "the reading of the numbers given");
    double least = (double)INFINITY;
    for (int r = 0; r < rounds; r++) {
        double const start = timer_now();
        sink = multiply_and_add((float)r, FLOP_ROUNDS);
        keep_least(&least, start);
    }
    printf("Products and sums in registers: %.0f G operations/s.\n\n",
           1e-9 * 2.0 * 16.0 * 10.0 * FLOP_ROUNDS / least);
    printf("| vertices | matrix MB | iteration MB | product ms | GB/s | read GB/s | copy GB/s | "
           "product / read | G operations/s | in double ms | threads: iteration, with aggregates "
           "ms |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof SIDES / sizeof *SIDES && SIDES[i] <= most; i++) {
        bench_cloth *const cloth = make_cloth(SIDES[i], threads);
        bench_times times[2];
        measure(cloth, rounds, threads, times);
        for (int way = 0; way < 2; way++) print_cloth(cloth, way, &times[way], threads);
        destroy_cloth(cloth);
    }
    return 0;
}
