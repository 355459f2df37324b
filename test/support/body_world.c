#include "support/body_world.h"
#include "support/pins.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

/* A world has cloth: a little sheet far off, all of it pinned. Its mean edge gives a contact
 * distance of 5 mm unless the def has another. */
tulle_world *bodies_make_world(const tulle_world_def *def, bool has_far_cloth) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    if (tulle_world_create(def, &world, &error) != TULLE_OK) fail_msg("%s", error.message);
    if (!has_far_cloth) return world;
    tulle_mesh sheet = small_sheet(0.1, 3, 0.0);
    uint32_t all[9];
    for (uint32_t i = 0; i < 9; i++) {
        all[i] = i;
        sheet.positions[3 * i] += 4.0;
    }
    tulle_cloth_def cloth = tulle_cloth_def_default();
    tulle_pin const pin = make_pin(all, 9, (double)INFINITY);
    cloth.mesh = (tulle_mesh_view){sheet.positions, sheet.vertex_count, sheet.triangles,
                                   sheet.triangle_count};
    cloth.pins = &pin;
    cloth.pin_count = 1;
    if (tulle_world_add_cloth(world, &cloth, NULL, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    tulle_mesh_destroy(&sheet);
    return world;
}

tulle_mesh bodies_make_box(double x, double y, double z, const double at[3]) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = x;
    def.size[1] = y;
    def.size[2] = z;
    def.resolution[0] = 2;
    def.resolution[1] = 2;
    return small_shape(def, at[0], at[1], at[2]);
}

tulle_mesh bodies_make_ball(double radius, unsigned resolution, const double at[3]) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = resolution;
    return small_shape(def, at[0], at[1], at[2]);
}

tulle_obstacle_id bodies_add_obstacle(tulle_world *world, const tulle_mesh *mesh, double friction,
                                      const tulle_body *body) {
    tulle_error error = {0};
    tulle_obstacle_id id = {0};
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = (tulle_mesh_view){mesh->positions, mesh->vertex_count, mesh->triangles,
                                 mesh->triangle_count};
    def.friction = friction;
    if (body) def.body = *body;
    if (tulle_world_add_obstacle(world, &def, &id, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return id;
}

void bodies_rotate_mesh(tulle_mesh *mesh, double angle) {
    double const c = cos(angle), s = sin(angle);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double *const p = mesh->positions + 3 * i;
        double const x = c * p[0] + s * p[2], z = -s * p[0] + c * p[2];
        p[0] = x;
        p[2] = z;
    }
}

tulle_step_report bodies_step_by(tulle_world *world, double time_step) {
    tulle_error error = {0};
    tulle_step_report report;
    if (tulle_world_step(world, time_step, &report, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return report;
}

tulle_step_report bodies_step(tulle_world *world) { return bodies_step_by(world, BODIES_STEP); }

tulle_transform bodies_get_transform(const tulle_world *world, tulle_obstacle_id id) {
    tulle_transform transform;
    assert_int_equal(tulle_obstacle_get_transform(world, id, &transform, NULL), TULLE_OK);
    return transform;
}

tulle_cloth_id bodies_add_cloth(tulle_world *world, const tulle_mesh *mesh, double area_density,
                                int has_pinned_corners) {
    tulle_error error = {0};
    tulle_cloth_id id = {0};
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.material.area_density = area_density;
    def.material.air_damping = has_pinned_corners ? 2.0 : 0.0; /* what hangs comes to rest */
    uint32_t const last = (uint32_t)mesh->vertex_count - 1;
    uint32_t const row = (uint32_t)(sqrt((double)mesh->vertex_count) + 0.5);
    uint32_t const corners[4] = {0, row - 1, last - row + 1, last};
    tulle_pin const pin = make_pin(corners, 4, INFINITY);
    def.pins = has_pinned_corners ? &pin : NULL;
    def.pin_count = has_pinned_corners ? 1 : 0;
    if (tulle_world_add_cloth(world, &def, &id, &error) != TULLE_OK) fail_msg("%s", error.message);
    return id;
}

size_t bodies_judge(const tulle_world *world, const tulle_mesh *cloths, size_t cloth_count,
                    const tulle_mesh *obstacles, size_t obstacle_count) {
    tulle_check_body bodies[32];
    tulle_check_result result = {0};
    size_t count = 0;
    for (size_t i = 0; i < cloth_count; i++) {
        bodies[count].mesh = tulle_mesh_get_view(&cloths[i]);
        bodies[count].mesh.positions =
            tulle_cloth_get_positions(world, (tulle_cloth_id){(uint32_t)i, 1}, NULL);
        bodies[count++].is_obstacle = 0;
    }
    for (size_t i = 0; i < obstacle_count; i++) {
        bodies[count].mesh = tulle_mesh_get_view(&obstacles[i]);
        bodies[count].mesh.positions =
            tulle_obstacle_get_positions(world, (tulle_obstacle_id){(uint32_t)i, 1}, NULL);
        bodies[count++].is_obstacle = 0; /* so that they are judged with one another */
    }
    assert_int_equal(tulle_check_intersections(bodies, count, 1, &result, NULL), TULLE_OK);
    size_t const pairs = result.pair_count;
    tulle_check_result_destroy(&result);
    return pairs;
}
