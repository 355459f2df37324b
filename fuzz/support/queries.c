/* support/queries.c - see queries.h. */
#include "support/queries.h"

#include "support/fuzz.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Rays, nearest points and boxes agree about a place that was found. */
static void check_hit(tulle_world *world, const tulle_hit *hit) {
    tulle_error error = {0};
    if (hit->object.kind == TULLE_OBJECT_NONE) return;
    tulle_object_info const info = tulle_object_get_info(world, hit->object);
    FUZZ_CHECK(hit->triangle < info.triangle_count && hit->distance >= 0.0);
    double *const x = calloc(3 * info.vertex_count, sizeof *x);
    FUZZ_CHECK(x);
    tulle_target const target = {x, 3 * info.vertex_count * sizeof *x, 0, TULLE_NUMBER_DOUBLE};
    FUZZ_CHECK_OK(
        tulle_object_copy_values(world, hit->object, TULLE_VALUES_POSITIONS, &target, &error),
        &error);
    double size = 1.0, low[3], high[3];
    for (size_t k = 0; k < 9; k++)
        size = fmax(size, fabs(x[3 * info.triangles[3 * hit->triangle + k / 3] + k % 3]));
    free(x);
    for (int k = 0; k < 3; k++) {
        low[k] = hit->position[k] - 1e-9 * size;
        high[k] = hit->position[k] + 1e-9 * size;
    }
    tulle_hit nearest;
    FUZZ_CHECK_OK(
        tulle_world_find_closest_point(world, hit->position, 1e-9 * size, 0, &nearest, &error),
        &error);
    FUZZ_CHECK(nearest.object.kind != TULLE_OBJECT_NONE);
    static tulle_found_triangle triangles[16384];
    tulle_found found = {triangles, 16384, 0};
    FUZZ_CHECK_OK(tulle_world_find_box_overlaps(world, low, high, 0, &found, &error), &error);
    bool is_found = found.count > found.capacity;
    for (size_t i = 0; i < found.count && i < found.capacity; i++)
        is_found |= memcmp(&triangles[i].object, &hit->object, sizeof hit->object) == 0 &&
                    triangles[i].triangle == hit->triangle;
    FUZZ_CHECK(is_found);
}

void queries_ask(tulle_world *world, const tulle_mesh *cloth, uint64_t chosen) {
    tulle_error error = {0};
    tulle_ray ray = {.skips_back_faces = (int)(chosen % 2)};
    for (int k = 0; k < 3; k++) {
        ray.from[k] = (double)(chosen >> (8 * k + 1) & 255) / 128.0 - 1.0;
        ray.to[k] = (double)(chosen >> (8 * k + 26) & 255) / 128.0 - 1.0;
    }
    bool const is_good = memcmp(ray.from, ray.to, sizeof ray.from) != 0;
    tulle_hit hit;
    tulle_status const status = tulle_world_cast_ray(world, &ray, &hit, &error);
    FUZZ_CHECK((status == TULLE_OK) == is_good);
    check_hit(world, &hit);
    FUZZ_CHECK_OK(
        tulle_world_find_closest_point(world, ray.from, (double)INFINITY, 0, &hit, &error), &error);
    FUZZ_CHECK(hit.object.kind != TULLE_OBJECT_NONE);
    check_hit(world, &hit);
    tulle_mesh_view mesh = tulle_mesh_get_view(cloth);
    mesh.positions = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    tulle_found none = {NULL, 0, 0};
    FUZZ_CHECK_OK(tulle_world_find_mesh_overlaps(world, mesh, 0, &none, &error), &error);
    FUZZ_CHECK(none.count >= mesh.triangle_count); /* it meets itself at the least */
}
