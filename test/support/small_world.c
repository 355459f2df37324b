#include "support/small_world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

tulle_mesh small_shape(tulle_shape_def def, double x, double y, double z) {
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    tulle_status const status = tulle_shape_generate(&def, &mesh, &error);
    if (status != TULLE_OK) fail_msg("shape: %s", error.message);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        mesh.positions[3 * v] += x;
        mesh.positions[3 * v + 1] += y;
        mesh.positions[3 * v + 2] += z;
    }
    return mesh;
}

tulle_mesh small_sheet(double side, unsigned n, double z) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = side;
    def.resolution[0] = def.resolution[1] = n;
    return small_shape(def, 0.0, 0.0, z);
}

tulle_cloth_id small_add_cloth(tulle_world *world, const tulle_mesh *mesh) {
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    tulle_cloth_id id = {0};
    tulle_error error = {0};
    tulle_status const status = tulle_world_add_cloth(world, &def, &id, &error);
    if (status != TULLE_OK) fail_msg("cloth: %s", error.message);
    return id;
}

tulle_obstacle_id small_add_obstacle(tulle_world *world, const tulle_mesh *mesh) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    tulle_obstacle_id id = {0};
    tulle_error error = {0};
    tulle_status const status = tulle_world_add_obstacle(world, &def, &id, &error);
    if (status != TULLE_OK) fail_msg("obstacle: %s", error.message);
    return id;
}

size_t small_judge(const tulle_world *world, const tulle_mesh *cloths, size_t cloth_count,
                   const tulle_mesh *obstacles, size_t obstacle_count) {
    tulle_check_body bodies[16];
    size_t body_count = 0;
    for (size_t i = 0; i < cloth_count; i++) {
        tulle_check_body *const body = &bodies[body_count++];
        body->mesh = tulle_mesh_get_view(&cloths[i]);
        body->mesh.positions =
            tulle_cloth_get_positions(world, (tulle_cloth_id){(uint32_t)i, 1}, NULL);
        body->is_obstacle = 0;
    }
    for (size_t i = 0; i < obstacle_count; i++) {
        tulle_obstacle_id const id = {(uint32_t)i, 1};
        if (!tulle_obstacle_is_present(world, id)) continue;
        tulle_check_body *const body = &bodies[body_count++];
        body->mesh = tulle_mesh_get_view(&obstacles[i]);
        body->mesh.positions = tulle_obstacle_get_positions(world, id, NULL);
        body->is_obstacle = 1;
    }
    tulle_check_result result = {0};
    tulle_error error = {0};
    if (tulle_check_intersections(bodies, body_count, 1, &result, &error) != TULLE_OK) {
        fail_msg("judge: %s", error.message);
    }
    size_t const count = result.pair_count;
    tulle_check_result_destroy(&result);
    return count;
}
