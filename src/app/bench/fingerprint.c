/* app/bench/fingerprint.c - a short simulation whose hash tells builds apart that compute other
 * things. A build that is only faster has the same one, so inputs captured before stay good. */
#include "app/bench/bench.h"

#include "tulle/shapes.h"

/* A steep sheet, large enough for solves in single precision, slides over a ball, a rigid box falls
 * on both: some tenths of a second. */
enum { STEP_COUNT = 30, SHEET_RESOLUTION = 35, BALL_RESOLUTION = 3 };
static const double TIME_STEP = 1.0 / 90.0; /* [s] */

static tulle_status make_sheet(tulle_mesh *mesh, tulle_error *error) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 0.4;
    def.resolution[0] = def.resolution[1] = SHEET_RESOLUTION;
    return tulle_shape_generate(&def, mesh, error);
}

static tulle_status make_ball(tulle_mesh *mesh, tulle_error *error) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = 0.08;
    def.resolution[0] = BALL_RESOLUTION;
    return tulle_shape_generate(&def, mesh, error);
}

/* Above the ball, steep enough to slide and fold. */
static void place_sheet(tulle_mesh *mesh) {
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double *const x = mesh->positions + 3 * i;
        x[2] = 0.16 + 0.4 * x[0];
        x[0] += 0.02;
    }
}

static tulle_status add_sheet(tulle_world *world, tulle_error *error) {
    tulle_mesh mesh = {0};
    tulle_status status = make_sheet(&mesh, error);
    if (status == TULLE_OK) {
        place_sheet(&mesh);
        tulle_cloth_def def = tulle_cloth_def_default();
        def.mesh = tulle_mesh_get_view(&mesh);
        status = tulle_material_preset("cotton", &def.material);
        tulle_cloth_id id;
        if (status == TULLE_OK) status = tulle_world_add_cloth(world, &def, &id, error);
    }
    tulle_mesh_destroy(&mesh);
    return status;
}

static tulle_status add_ball(tulle_world *world, tulle_error *error) {
    tulle_mesh mesh = {0};
    tulle_status status = make_ball(&mesh, error);
    if (status == TULLE_OK) {
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(&mesh);
        def.friction = 0.3;
        tulle_obstacle_id id;
        status = tulle_world_add_obstacle(world, &def, &id, error);
    }
    tulle_mesh_destroy(&mesh);
    return status;
}

static tulle_status add_box(tulle_world *world, tulle_error *error) {
    tulle_mesh mesh = {0};
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.06;
    tulle_status status = tulle_shape_generate(&shape, &mesh, error);
    if (status == TULLE_OK) {
        for (size_t i = 0; i < mesh.vertex_count; i++) mesh.positions[3 * i + 2] += 0.25;
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(&mesh);
        def.friction = 0.3;
        def.body.is_dynamic = 1;
        def.body.mass = 0.05;
        tulle_obstacle_id id;
        status = tulle_world_add_obstacle(world, &def, &id, error);
    }
    tulle_mesh_destroy(&mesh);
    return status;
}

tulle_status bench_find_fingerprint(uint64_t *fingerprint, tulle_error *error) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    tulle_status status = tulle_world_create(&def, &world, error);
    if (status == TULLE_OK) status = add_sheet(world, error);
    if (status == TULLE_OK) status = add_ball(world, error);
    if (status == TULLE_OK) status = add_box(world, error);
    for (int i = 0; i < STEP_COUNT && status == TULLE_OK; i++)
        status = tulle_world_step(world, TIME_STEP, NULL, error);
    if (status == TULLE_OK) *fingerprint = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    return status;
}
