/* What one linearisation costs (the stage compute_forces), part by part: a sheet of springs and a
 * woven one, on one thread. A part is the difference between the whole and the whole without it.
 * Rounds go through all cases in turn, so that other work on the machine meets them alike. Each is
 * linearised twice in a row: the second time its data are in the caches, as far as these reach, and
 * that is what parts are told of. Prints Markdown. Usage: bench_forces [rounds] [vertices a side]
 * [case] [vector width: 0, 1, 2]
 *
 * With a case (0 ..) that one alone runs: run it under callgrind with two numbers of rounds to
 * count the instructions of a round. The hash is that of all systems: the same bits on every vector
 * width. */
#include "base/hash.h"
#include "base/timer.h"
#include "dynamics/compute_forces.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double STEP = 1.0 / 90.0;   /* [s] */
static const double EDGE = 2.0 / 98.0;   /* [m] */
static const double DRAG = 0.7;          /* [kg/m^3] */
static const double GUST_STRENGTH = 2.0; /* [m/s] */

typedef struct bench_case {
    const char *name;
    bool has_gusts, has_wind, has_bend_damping, has_bending, is_later;
} bench_case;

enum { CASE_COUNT = 6, MEMBRANE_COUNT = 2 };
static const bench_case CASES[CASE_COUNT] = {
    {"all, in gusts", true, true, true, true, false},
    {"all", false, true, true, true, false},
    {"no wind", false, false, true, true, false},
    {"no damping of bending", false, false, false, true, false},
    {"no bending", false, false, false, false, false},
    {"a later one", false, true, true, true, true}};
static const char *const MEMBRANES[MEMBRANE_COUNT] = {"woven", "springs"};

/* A sheet that folds in waves of some cells: stretched here, compressed there. */
typedef struct bench_sheet {
    size_t vertex_count, triangle_count;
    double *rest, *positions, *velocities;
    uint32_t *triangles;
    topology surface;
} bench_sheet;

/* A cloth of the sheet for one case. */
typedef struct bench_cloth {
    memory heap;
    arena scratch;
    cloth_model model;
    linear_system system;
    size_t model_bytes, system_bytes;
} bench_cloth;

static void check(bool is_fine, const char *what) {
    if (is_fine) return;
    fprintf(stderr, "bench_forces: %s failed\n", what);
    exit(1);
}

static void *room(size_t count, size_t size) {
    void *const data = calloc(count, size);
    check(data != NULL, "memory");
    return data;
}

static void make_sheet(bench_sheet *sheet, memory *heap, size_t side) {
    size_t const n = side;
    sheet->vertex_count = n * n;
    sheet->triangle_count = 2 * (n - 1) * (n - 1);
    sheet->rest = room(3 * n * n, sizeof(double));
    sheet->positions = room(3 * n * n, sizeof(double));
    sheet->velocities = room(3 * n * n, sizeof(double));
    sheet->triangles = room(3 * sheet->triangle_count, sizeof(uint32_t));
    uint64_t random = 1;
    for (size_t v = 0; v < n * n; v++) {
        double const at[3] = {EDGE * (double)(v % n), EDGE * (double)(v / n), 0.0};
        memcpy(sheet->rest + 3 * v, at, sizeof at);
        double const height = 0.4 * EDGE * sin(9.0 * at[0]) * cos(7.0 * at[1]);
        double const moved[3] = {0.97 * at[0], at[1], height};
        memcpy(sheet->positions + 3 * v, moved, sizeof moved);
        for (size_t i = 0; i < 3; i++)
            sheet->velocities[3 * v + i] = 0.2 * random_uniform(&random) - 0.1;
    }
    uint32_t *to = sheet->triangles;
    for (uint32_t j = 0; j + 1 < n; j++)
        for (uint32_t i = 0; i + 1 < n; i++) {
            uint32_t const a = j * (uint32_t)n + i, b = a + (uint32_t)n;
            uint32_t const corners[6] = {a, a + 1, b + 1, a, b + 1, b};
            memcpy(to, corners, sizeof corners);
            to += 6;
        }
    check(topology_build(heap, sheet->triangles, sheet->triangle_count, sheet->vertex_count,
                         &sheet->surface) == TULLE_OK,
          "the topology");
}

static bench_cloth *make_cloth(const bench_sheet *sheet, tulle_membrane membrane,
                               const bench_case *what) {
    bench_cloth *const cloth = room(1, sizeof *cloth);
    cloth->heap = memory_default();
    cloth->scratch = arena_make(&cloth->heap);
    tulle_material cotton;
    tulle_error error;
    check(tulle_material_preset("cotton", &cotton) == TULLE_OK, "the preset");
    if (!what->has_bend_damping) cotton.bend_damping = 0.0;
    if (!what->has_bending)
        cotton.bend_warp = cotton.bend_weft = cotton.bend_twist = cotton.springs.bend_stiffness =
            0.0;
    cloth_model_def const def = {.vertex_count = sheet->vertex_count,
                                 .surface = &sheet->surface,
                                 .rest_positions = sheet->rest,
                                 .materials = &cotton,
                                 .material_count = 1,
                                 .membrane = membrane};
    check(cloth_model_build(&cloth->heap, &def, &cloth->model, &error) == TULLE_OK, "the model");
    cloth->model_bytes = cloth->heap.bytes_held;
    check(linear_system_build(&cloth->heap, &cloth->model, true, &cloth->system) == TULLE_OK,
          "the system");
    cloth->system_bytes = cloth->heap.bytes_held - cloth->model_bytes;
    return cloth;
}

static void destroy_cloth(bench_cloth *cloth) {
    linear_system_destroy(&cloth->heap, &cloth->system);
    cloth_model_destroy(&cloth->heap, &cloth->model);
    arena_destroy(&cloth->scratch);
    free(cloth);
}

/* [s] of one linearisation. A later one has a guess, and the terms of the first. */
static double time_linearisation(bench_cloth *cloth, const bench_sheet *sheet,
                                 const bench_case *what) {
    environment const surroundings = {
        .gravity = {0.0, 0.0, -9.81},
        .wind = {.drag_coefficient = what->has_wind ? DRAG : 0.0,
                 .gust_strength = what->has_gusts ? GUST_STRENGTH : 0.0,
                 .gust_length = 1.0,
                 .gust_time = 1.0}};
    force_options const options = {TULLE_INTEGRATOR_IMPLICIT_EULER, 1, 0.0, false};
    force_terms terms = {0};
    cloth_start state = {.positions = sheet->positions,
                         .velocities = sheet->velocities,
                         .time_step = STEP,
                         .terms = what->is_later ? &terms : NULL};
    arena_mark const mark = arena_get_mark(&cloth->scratch);
    double start = 0.0;
    for (int pass = 0; pass <= (what->is_later ? 1 : 0); pass++) {
        state.guess = pass == 1 ? sheet->velocities : NULL;
        start = timer_now();
        check(compute_forces(&cloth->model, &state, &surroundings, options, &cloth->scratch,
                             &cloth->system) == TULLE_OK,
              "the forces");
    }
    double const seconds = timer_now() - start;
    arena_release(&cloth->scratch, mark);
    return seconds;
}

static int compare_seconds(const void *a, const void *b) {
    double const left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

typedef struct bench_time {
    double least, median; /* [ms] */
} bench_time;

static uint64_t hash_system(const bench_cloth *cloth, uint64_t hash) {
    const linear_system *const system = &cloth->system;
    size_t const count = 3 * system->vertex_count * sizeof(double);
    hash = hash_bytes(hash, system->matrix.values,
                      BLOCK_NUMBERS * system->matrix.block_count * sizeof(double));
    hash = hash_bytes(hash, system->right_hand_side, count);
    return hash_bytes(hash, system->forces, count);
}

/* `colds` are those of first times. */
static void print_times(const bench_sheet *sheet, const bench_cloth *const *cloths,
                        const bench_time *times, const bench_time *colds) {
    for (size_t m = 0; m < MEMBRANE_COUNT; m++) {
        const bench_time *const of = times + m * CASE_COUNT;
        const char *const parts[] = {"gusts", "wind", "damping of bending", "bending",
                                     "membrane, rows of the matrix"};
        printf("\n%s, %zu triangles:\n\n| part | least ms | median ms |\n|---|---|---|\n",
               MEMBRANES[m], sheet->triangle_count);
        printf("| all | %.3f | %.3f |\n", of[1].least, of[1].median);
        for (int k = 0; k < 4; k++)
            printf("| %s | %.3f | %.3f |\n", parts[k], of[k].least - of[k + 1].least,
                   of[k].median - of[k + 1].median);
        printf("| %s | %.3f | %.3f |\n", parts[4], of[4].least, of[4].median);
        printf("| all of a later linearisation | %.3f | %.3f |\n", of[5].least, of[5].median);
        const bench_time *const cold = colds + m * CASE_COUNT + 1;
        printf("| all, data not in the caches | %.3f | %.3f |\n", cold->least, cold->median);
        const bench_cloth *const cloth = cloths[m * CASE_COUNT + 1];
        uint64_t hash = HASH_SEED;
        for (size_t k = 0; k < CASE_COUNT; k++)
            hash = hash_system(cloths[m * CASE_COUNT + k], hash);
        double const count = (double)sheet->vertex_count;
        printf("\nBytes a particle: model %.0f, system %.0f, scratch %.0f; numbers of the bending "
               "matrix beside the blocks %.1f. Hash %016" PRIx64 ".\n",
               (double)cloth->model_bytes / count, (double)cloth->system_bytes / count,
               (double)cloth->scratch.most_used / count, (double)cloth->model.scalar_count / count,
               hash);
    }
}

int main(int argc, char **argv) {
    size_t const rounds = argc > 1 ? (size_t)atoi(argv[1]) : 100;
    size_t const side = argc > 2 ? (size_t)atoi(argv[2]) : 99;
    int const only = argc > 3 ? atoi(argv[3]) : -1;
    enum { ALL_CASES = MEMBRANE_COUNT * CASE_COUNT };
    check(argc < 5 || kernel_target_force((kernel_target)atoi(argv[4])), "that vector width");
    check(rounds > 0 && side > 1 && only < ALL_CASES, "the reading of the numbers given");
    memory heap = memory_default();
    bench_sheet sheet;
    make_sheet(&sheet, &heap, side);
    bench_cloth *cloths[ALL_CASES];
    for (int k = 0; k < ALL_CASES; k++) {
        bool const is_woven = k < CASE_COUNT;
        cloths[k] = make_cloth(&sheet, is_woven ? TULLE_MEMBRANE_WOVEN : TULLE_MEMBRANE_SPRINGS,
                               &CASES[k % CASE_COUNT]);
    }
    bench_time times[2][ALL_CASES];
    double *const seconds = room(2 * ALL_CASES * rounds, sizeof(double));
    for (size_t r = 0; r < rounds; r++)
        for (size_t k = 0; k < ALL_CASES; k++)
            for (size_t turn = 0; turn < 2 && (only < 0 || k == (size_t)only); turn++)
                seconds[(2 * k + turn) * rounds + r] =
                    time_linearisation(cloths[k], &sheet, &CASES[k % CASE_COUNT]);
    for (size_t k = 0; k < 2 * ALL_CASES; k++) {
        double *const of = seconds + k * rounds;
        qsort(of, rounds, sizeof *of, compare_seconds);
        times[k % 2][k / 2] = (bench_time){1e3 * of[0], 1e3 * of[rounds / 2]};
    }
    print_times(&sheet, (const bench_cloth *const *)cloths, times[1], times[0]);
    free(seconds);
    for (int k = 0; k < ALL_CASES; k++) destroy_cloth(cloths[k]);
    topology_destroy(&heap, &sheet.surface);
    free(sheet.rest), free(sheet.positions), free(sheet.velocities), free(sheet.triangles);
    return 0;
}
