/* Times queries of a world (tulle/query.h) on a sphere of about a million triangles over a sheet:
 * making the trees, fitting their boxes, then rays, nearest points and boxes, with what they found;
 * and copies of values. Prints counts beside minimum and median times as CSV. The world never
 * steps. Usage: bench_queries [rounds] */
#include "base/hash.h"
#include "base/sort.h"
#include "base/timer.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { QUERIES = 10000, MOST_ROUNDS = 101, FOUND_MAX = 4096, RESOLUTION = 224 };

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s\n", error.message);
    exit(2);
}

typedef enum question {
    RAYS_HIT,
    RAYS_MISS,
    NEAREST_NEAR,
    NEAREST_FAR,
    BOXES,
    QUESTION_COUNT
} question;
static const char *const names[] = {"ray that hits", "ray that misses", "nearest point, 1 cm away",
                                    "nearest point, 0.5 m away", "box of 1 cm"};

static void pick_direction(uint64_t *seed, double way[3]) {
    double square;
    do {
        square = 0.0;
        for (int k = 0; k < 3; k++) {
            way[k] = 2.0 * random_uniform(seed) - 1.0;
            square += way[k] * way[k];
        }
    } while (square > 1.0 || square < 0.01);
    for (int k = 0; k < 3; k++) way[k] /= sqrt(square);
}

/* Asks once; returns what was found. */
static size_t ask(tulle_world *world, question kind, uint64_t *seed) {
    static tulle_found_triangle triangles[FOUND_MAX];
    double way[3], other[3], point[3];
    pick_direction(seed, way);
    pick_direction(seed, other);
    tulle_hit hit;
    if (kind == RAYS_HIT || kind == RAYS_MISS) {
        tulle_ray ray = {.mask = 0};
        for (int k = 0; k < 3; k++) {
            ray.from[k] = 2.0 * way[k];
            ray.to[k] = kind == RAYS_HIT ? 0.9 * other[k] : 2.0 * way[k] + other[k];
        }
        require(tulle_world_cast_ray(world, &ray, &hit, &error));
        return hit.object.kind != TULLE_OBJECT_NONE;
    }
    double const radius = kind == NEAREST_NEAR ? 1.01 : kind == NEAREST_FAR ? 1.5 : 1.0;
    for (int k = 0; k < 3; k++) point[k] = radius * way[k];
    if (kind != BOXES) {
        require(tulle_world_find_closest_point(world, point, (double)INFINITY, 0, &hit, &error));
        return hit.object.kind != TULLE_OBJECT_NONE;
    }
    double low[3], high[3];
    for (int k = 0; k < 3; k++) {
        low[k] = point[k] - 0.005;
        high[k] = point[k] + 0.005;
    }
    tulle_found found = {triangles, FOUND_MAX, 0};
    require(tulle_world_find_box_overlaps(world, low, high, 0, &found, &error));
    return found.count;
}

static void print_line(const char *name, double *times, size_t rounds, double each, double count) {
    sort_in_place(times, rounds, sizeof *times, compare_doubles);
    printf("%s,%.4g,%.4g,%.4g\n", name, 1e6 * times[0] / each, 1e6 * times[rounds / 2] / each,
           count);
}

int main(int argc, char **argv) {
    size_t rounds = argc > 1 ? (size_t)strtoul(argv[1], NULL, 10) : 5;
    if (rounds < 1 || rounds > MOST_ROUNDS) rounds = 5;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.resolution[0] = RESOLUTION;
    shape.radius = 1.0;
    tulle_mesh ball, sheet;
    require(tulle_shape_generate(&shape, &ball, &error));
    shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.resolution[0] = shape.resolution[1] = 3;
    require(tulle_shape_generate(&shape, &sheet, &error));
    tulle_mesh_transform(&sheet, (double[]){1, 1, 1}, (double[]){1, 0, 0, 0}, (double[]){0, 0, 20});
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    tulle_obstacle_id id;
    require(tulle_world_create(&def, &world, &error));
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    require(tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&ball);
    obstacle.drive = TULLE_DRIVE_DEFORMING; /* so that its boxes are fitted after each step */
    require(tulle_world_add_obstacle(world, &obstacle, &id, &error));
    require(tulle_world_start(world, &error));
    printf("# %zu triangles, %zu queries a round, %zu rounds\n", ball.triangle_count,
           (size_t)QUERIES, rounds);
    printf("what,minimum [us],median [us],found\n");

    double times[MOST_ROUNDS], start = timer_now();
    require(tulle_world_update_queries(world, &error));
    times[0] = timer_now() - start;
    print_line("trees and boxes", times, 1, 1.0, 0.0);
    for (size_t i = 0; i < rounds; i++) {
        require(tulle_world_step(world, 1e-3, NULL, &error));
        start = timer_now();
        require(tulle_world_update_queries(world, &error));
        times[i] = timer_now() - start;
    }
    print_line("boxes", times, rounds, 1.0, 0.0);
    for (int kind = 0; kind < QUESTION_COUNT; kind++) {
        size_t found = 0;
        for (size_t i = 0; i < rounds; i++) {
            uint64_t seed = 7;
            start = timer_now();
            found = 0;
            for (int k = 0; k < QUERIES; k++) found += ask(world, (question)kind, &seed);
            times[i] = timer_now() - start;
        }
        print_line(names[kind], times, rounds, QUERIES, (double)found / QUERIES);
    }

    static const char *const value_names[] = {"positions", "velocities", "normals",
                                              "contact forces"};
    float *const copied = malloc(3 * ball.vertex_count * sizeof *copied);
    if (!copied) return 2;
    tulle_target const target = {copied, 3 * ball.vertex_count * sizeof *copied, 0,
                                 TULLE_NUMBER_FLOAT};
    for (int values = 0; values < 4; values++) {
        for (size_t i = 0; i < rounds; i++) {
            start = timer_now();
            require(tulle_object_copy_values(world, tulle_object_from_obstacle(id),
                                             (tulle_values)values, &target, &error));
            times[i] = timer_now() - start;
        }
        print_line(value_names[values], times, rounds, 1.0, (double)ball.vertex_count);
    }
    free(copied);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&sheet);
    return 0;
}
