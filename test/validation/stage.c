/* stage.c - see stage.h. */
#include "validation/stage.h"

tulle_mesh *stage_make_sheet(validation_run *run, stage_sheet sheet) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    for (size_t i = 0; i < 2; i++) {
        shape.size[i] = sheet.size[i];
        shape.resolution[i] = sheet.counts[i];
    }
    tulle_mesh *const mesh = validate_make_shape(run, &shape);
    stage_move(mesh, sheet.middle[0], sheet.middle[1], sheet.middle[2]);
    return mesh;
}

void stage_move(tulle_mesh *mesh, double x, double y, double z) {
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        mesh->positions[3 * v] += x;
        mesh->positions[3 * v + 1] += y;
        mesh->positions[3 * v + 2] += z;
    }
}

tulle_cloth_def stage_cloth_def(const tulle_mesh *mesh) {
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.material.air_damping = 0.0;
    return def;
}

tulle_obstacle_id stage_add_obstacle(validation_run *run, tulle_world *world,
                                     const tulle_mesh *mesh, double friction) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.friction = friction;
    return validate_add_obstacle(run, world, &def);
}

tulle_keyframe stage_key(double time, double x, double y, double z) {
    return (tulle_keyframe){.time = time, .translation = {x, y, z}, .rotation_vector = {0, 0, 0}};
}

tulle_world *stage_make_woven_world(validation_run *run) {
    tulle_world_def def = validate_world_def(run);
    def.membrane = TULLE_MEMBRANE_WOVEN;
    return validate_make_world(run, &def);
}

tulle_material stage_take_fabric(validation_run *run, const char *name) {
    tulle_material material;
    if (tulle_material_preset(name, &material))
        validate_give_up(run, "there is no fabric '%s'", name);
    return material;
}
