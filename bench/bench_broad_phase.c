/* Times building of trees and search on made-up motions of a 99 x 99 cloth over a sphere of 5,472
 * triangles: flat in the air, draped in folds, and three sheets piled up. Prints counts beside
 * minimum and median times [ms] as CSV. Usage: bench_broad_phase [rounds] */
#include "base/hash.h"
#include "base/sort.h"
#include "base/timer.h"
#include "detect/trees/broad_phase.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 99, RINGS = 37, SECTORS = 76, MOST_ROUNDS = 101 };

typedef struct bench_scene {
    double *rest, *x0, *x1;
    uint32_t *triangles;
    size_t vertex_count, triangle_count, surface_count;
    surface_range surfaces[4];
    topology topo;
    surface_set set;
} bench_scene;

typedef enum cloth_pose { POSE_FLAT, POSE_DRAPED, POSE_PILED } cloth_pose;

static const char *const pose_names[] = {"flat", "draped", "piled"};
static double const pi = 3.14159265358979323846;
static double const edge = 1.0 / (SIDE - 1); /* [m] */

/* Where a cloth vertex is: flat above the sphere; or laid over it, the rest hanging in folds that
 * touch one another. */
static vec3 pose_vertex(cloth_pose pose, int sheet, double u, double v) {
    double const lift = 0.3 * edge * sheet;
    if (pose != POSE_DRAPED) return vec3_make(u, v, 0.27 + lift);
    double const radius = 0.26, angle = atan2(v, u), reach = sqrt(u * u + v * v);
    if (reach < 0.5 * pi * radius)
        return vec3_make(radius * sin(reach / radius) * cos(angle),
                         radius * sin(reach / radius) * sin(angle), radius * cos(reach / radius));
    double const drop = reach - 0.5 * pi * radius;
    double const fold = radius + 0.5 * drop * sin(14.0 * angle);
    double const twist = angle + 0.4 * drop * sin(28.0 * angle);
    return vec3_make(fold * cos(twist), fold * sin(twist), -drop * 0.8);
}

static void begin_surface(bench_scene *to, bool is_obstacle) {
    to->surfaces[to->surface_count] =
        (surface_range){.vertex_begin = (uint32_t)to->vertex_count,
                        .triangle_begin = (uint32_t)to->triangle_count,
                        .is_obstacle = is_obstacle,
                        .is_static = is_obstacle,
                        .is_present = true};
}

static void end_surface(bench_scene *to) {
    surface_range *const range = &to->surfaces[to->surface_count++];
    range->vertex_end = (uint32_t)to->vertex_count;
    range->triangle_end = (uint32_t)to->triangle_count;
}

static void add_vertex(bench_scene *to, vec3 rest, vec3 start, vec3 end) {
    vec3_store(to->rest, to->vertex_count, rest);
    vec3_store(to->x0, to->vertex_count, start);
    vec3_store(to->x1, to->vertex_count++, end);
}

static void add_triangle(bench_scene *to, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t corners[3] = {a, b, c};
    memcpy(to->triangles + 3 * to->triangle_count++, corners, sizeof corners);
}

static void add_cloth(bench_scene *to, cloth_pose pose, int sheet, uint64_t *seed) {
    begin_surface(to, false);
    uint32_t const base = (uint32_t)to->vertex_count;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        double const u = (i % SIDE) * edge - 0.5, v = (i / SIDE) * edge - 0.5;
        vec3 const start = pose_vertex(pose, sheet, u, v);
        vec3 move = vec3_make(0.0, 0.0, -0.05);
        move.x += 0.05 * (random_uniform(seed) - 0.5);
        move.y += 0.05 * (random_uniform(seed) - 0.5);
        add_vertex(to, vec3_make(u, v, 0.0), start, vec3_add_scaled(start, move, edge));
    }
    for (uint32_t i = 0; i < SIDE * (SIDE - 1); i++) {
        if (i % SIDE == SIDE - 1) continue;
        uint32_t const at = base + i;
        add_triangle(to, at, at + 1, at + SIDE);
        add_triangle(to, at + 1, at + SIDE + 1, at + SIDE);
    }
    end_surface(to);
}

static void add_sphere(bench_scene *to) {
    begin_surface(to, true);
    uint32_t const base = (uint32_t)to->vertex_count;
    for (uint32_t i = 0; i < RINGS * SECTORS; i++) {
        double const height = pi * (i / SECTORS + 0.5) / RINGS;
        double const angle = 2.0 * pi * (i % SECTORS) / SECTORS;
        vec3 const x = vec3_make(0.25 * sin(height) * cos(angle), 0.25 * sin(height) * sin(angle),
                                 0.25 * cos(height));
        add_vertex(to, x, x, x);
    }
    for (uint32_t i = 0; i < (RINGS - 1) * SECTORS; i++) {
        uint32_t const at = base + i;
        uint32_t const next = base + i / SECTORS * SECTORS + (i + 1) % SECTORS;
        add_triangle(to, at, at + SECTORS, next);
        add_triangle(to, next, at + SECTORS, next + SECTORS);
    }
    end_surface(to);
}

static void make_scene(memory *heap, bench_scene *to, cloth_pose pose) {
    uint64_t seed = 31;
    int const sheets = pose == POSE_PILED ? 3 : 1;
    size_t const vertices = (size_t)sheets * SIDE * SIDE + RINGS * SECTORS;
    *to = (bench_scene){0};
    to->rest = malloc(9 * vertices * sizeof *to->rest);
    to->triangles = malloc(6 * vertices * sizeof *to->triangles);
    if (!to->rest || !to->triangles) exit(4);
    to->x0 = to->rest + 3 * vertices;
    to->x1 = to->x0 + 3 * vertices;
    for (int s = 0; s < sheets; s++) add_cloth(to, pose, s, &seed);
    add_sphere(to);
    if (topology_build(heap, to->triangles, to->triangle_count, to->vertex_count, &to->topo) !=
        TULLE_OK)
        exit(4);
    uint32_t at = 0;
    for (size_t s = 0; s < to->surface_count; s++) {
        to->surfaces[s].edge_begin = at;
        while (at < to->topo.edge_count &&
               to->topo.edges[2 * (size_t)at] < to->surfaces[s].vertex_end)
            at++;
        to->surfaces[s].edge_end = at;
    }
    to->set = (surface_set){
        .topo = &to->topo, .surfaces = to->surfaces, .surface_count = to->surface_count};
}

/* min and median, in milliseconds */
static void print_times(double *times, int count) {
    qsort(times, (size_t)count, sizeof *times, compare_doubles);
    printf(",%.2f,%.2f", 1e3 * times[0], 1e3 * times[count / 2]);
}

static void run_method(memory *heap, const bench_scene *of, cloth_pose pose,
                       broad_phase_method method, int threads, int rounds) {
    double build[MOST_ROUNDS], find[MOST_ROUNDS];
    double const margin = 0.5 * edge;
    broad_phase *broad;
    pair_list pairs = {0};
    search_counts found_counts;
    if (broad_phase_create(heap, &of->set, of->rest, method, &broad) != TULLE_OK) exit(4);
    for (int round = -2; round < rounds; round++) {
        double const start = timer_now();
        if (build_trees(broad, &of->set, of->x0, of->x1, margin, threads) != TULLE_OK) exit(4);
        double const built = timer_now();
        if (find_pairs(broad, &of->set, threads, PAIRS_SORTED, &pairs, NULL) != TULLE_OK) exit(4);
        double const found = timer_now();
        if (round < 0) continue;
        build[round] = built - start;
        find[round] = found - built;
    }
    if (find_pairs(broad, &of->set, threads, PAIRS_SORTED, &pairs, &found_counts) != TULLE_OK)
        exit(4);
    printf("%s,%s,%d,%zu,%llu,%zu,%zu", pose_names[pose],
           method == BROAD_PHASE_REFIT ? "refit" : "bvox", threads, of->triangle_count,
           (unsigned long long)found_counts.leaf_pair_count, pairs.vertex_triangle.count,
           pairs.edge_edge.count);
    print_times(build, rounds);
    print_times(find, rounds);
    printf("\n");
    ARRAY_FREE(heap, &pairs.vertex_triangle);
    ARRAY_FREE(heap, &pairs.edge_edge);
    broad_phase_destroy(broad);
}

int main(int argument_count, char **arguments) {
    int rounds = argument_count > 1 ? atoi(arguments[1]) : 21;
    rounds = rounds < 1 ? 1 : rounds > MOST_ROUNDS ? MOST_ROUNDS : rounds;
    memory heap = memory_default();
    printf("scene,method,threads,triangles,leaf_pairs,vertex_triangle,edge_edge,"
           "build_min,build_median,find_min,find_median\n");
    for (int pose = 0; pose < 3; pose++) {
        bench_scene scene;
        make_scene(&heap, &scene, (cloth_pose)pose);
        for (int method = 0; method < 2; method++)
            for (int threads = 1; threads <= 2; threads++)
                run_method(&heap, &scene, (cloth_pose)pose, (broad_phase_method)method, threads,
                           rounds);
        topology_destroy(&heap, &scene.topo);
        free(scene.rest);
        free(scene.triangles);
    }
    return 0;
}
