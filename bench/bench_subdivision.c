/* Times Loop subdivision of a regular and an irregular sheet and of a sphere, 1 to 4 levels: making
 * the operator, and applying it to positions, in ns for each vertex of the result, minimum and
 * median; beside them the counts and, as a scale, what copying the result takes. CSV. Usage:
 * bench_subdivision [rounds] */
#include "base/sort.h"
#include "base/timer.h"
#include "subdivision/loop_subdivision.h"
#include "tulle/shapes.h"
#include "tulle_io/subdivision.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 101, LEVELS = 4 };

typedef struct bench_case {
    const char *name;
    tulle_shape shape;
    uint32_t resolution;
    int is_irregular;
} bench_case;

/* minimum and median, in ns for each vertex */
static void print_times(double *times, int count, size_t vertex_count) {
    double const scale = 1e9 / (double)vertex_count;
    qsort(times, (size_t)count, sizeof *times, compare_doubles);
    printf(",%.2f,%.2f", scale * times[0], scale * times[count / 2]);
}

static size_t count_entries(const tulle_subdivision *subdivision) {
    size_t count = 0;
    for (size_t i = 0; i < subdivision->step_count; i++) count += subdivision->steps[i].entry_count;
    return count;
}

static void run_case(const bench_case *of, const tulle_mesh *mesh, int levels, int rounds) {
    double create[MOST_ROUNDS], apply[MOST_ROUNDS], copy[MOST_ROUNDS];
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = levels;
    tulle_subdivision *made = NULL;
    for (int i = 0; i < rounds; i++) {
        tulle_subdivision_destroy(made);
        double const begin = timer_now();
        if (tulle_subdivision_create(tulle_mesh_get_view(mesh), &def, &made, NULL) != TULLE_OK)
            exit(4);
        create[i] = timer_now() - begin;
    }
    size_t const count = tulle_subdivision_get_vertex_count(made);
    double *const result = calloc(3 * count, sizeof *result);
    double *const other = calloc(3 * count, sizeof *other);
    if (!result || !other) exit(4);
    for (int i = 0; i < rounds; i++) {
        double const begin = timer_now();
        if (tulle_subdivision_apply(made, mesh->positions, 3, result, NULL) != TULLE_OK) exit(4);
        double const middle = timer_now();
        memcpy(other, result, 3 * count * sizeof *result);
        copy[i] = timer_now() - middle;
        apply[i] = middle - begin;
    }
    printf("%s,%d,%zu,%zu,%zu,%zu", of->name, levels, mesh->triangle_count, count,
           tulle_subdivision_get_triangle_count(made), count_entries(made));
    print_times(create, rounds, count);
    print_times(apply, rounds, count);
    print_times(copy, rounds, count);
    putchar('\n');
    free(result);
    free(other);
    tulle_subdivision_destroy(made);
}

int main(int argc, char **argv) {
    int rounds = argc > 1 ? atoi(argv[1]) : 7;
    if (rounds < 1 || rounds > MOST_ROUNDS) rounds = 7;
    bench_case const cases[] = {{"regular_sheet", TULLE_SHAPE_RECTANGLE, 71, 0},
                                {"irregular_sheet", TULLE_SHAPE_RECTANGLE, 71, 1},
                                {"sphere", TULLE_SHAPE_SPHERE, 22, 0}};
    printf("mesh,levels,base_triangles,vertices,triangles,entries,create_min_ns,create_median_ns,"
           "apply_min_ns,apply_median_ns,copy_min_ns,copy_median_ns\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        tulle_shape_def shape = tulle_shape_def_default(cases[i].shape);
        shape.resolution[0] = cases[i].resolution;
        shape.resolution[1] = cases[i].shape == TULLE_SHAPE_SPHERE ? 0 : cases[i].resolution;
        shape.is_irregular = cases[i].is_irregular;
        tulle_mesh mesh;
        if (tulle_shape_generate(&shape, &mesh, NULL) != TULLE_OK) return 4;
        for (int levels = 1; levels <= LEVELS; levels++) run_case(&cases[i], &mesh, levels, rounds);
        tulle_mesh_destroy(&mesh);
    }
    return 0;
}
