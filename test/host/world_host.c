/* A program that embeds libtulle, as a host of any kind would: public headers, libc, nothing else.
 * Two sheets fall on a box and are pushed by one that moves; the program prints the hash of the
 * state after that, and fails when the judge finds an intersection. It is the world of
 * world/test_golden.c, so the hash is the golden one of that test, on every machine. */
#include <tulle/tulle.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

enum { THREADS = 2, STEPS = 24 };

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

static tulle_mesh make_shape(tulle_shape_def def, double x, double z) {
    tulle_mesh mesh = {0};
    require(tulle_shape_generate(&def, &mesh, &error));
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        mesh.positions[3 * v] += x;
        mesh.positions[3 * v + 2] += z;
    }
    return mesh;
}

static tulle_mesh make_sheet(double side, uint32_t resolution, double z) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = side;
    def.resolution[0] = def.resolution[1] = resolution;
    return make_shape(def, 0.0, z);
}

static size_t judge(const tulle_world *world, const tulle_mesh sheets[2],
                    const tulle_cloth_id cloths[2], const tulle_mesh *box) {
    tulle_check_body bodies[3] = {{.mesh = tulle_mesh_get_view(&sheets[0])},
                                  {.mesh = tulle_mesh_get_view(&sheets[1])},
                                  {.mesh = tulle_mesh_get_view(box), .is_obstacle = 1}};
    for (int k = 0; k < 2; k++)
        bodies[k].mesh.positions = tulle_cloth_get_positions(world, cloths[k], NULL);
    tulle_check_result verdict;
    require(tulle_check_intersections(bodies, 3, 0, &verdict, &error));
    size_t const count = verdict.pair_count;
    tulle_check_result_destroy(&verdict);
    return count;
}

int main(void) {
    tulle_mesh sheets[2] = {make_sheet(0.5, 11, 0.002), make_sheet(0.4, 9, 0.012)};
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.2;
    box.size[2] = 0.1;
    tulle_mesh boxes[2] = {make_shape(box, 0.0, -0.055), make_shape(box, 0.36, -0.055)};

    tulle_world_def def = tulle_world_def_default();
    def.threads = THREADS;
    tulle_world *world = NULL;
    require(tulle_world_create(&def, &world, &error));
    tulle_cloth_id cloths[2];
    for (int k = 0; k < 2; k++) {
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheets[k]);
        require(tulle_world_add_cloth(world, &cloth, &cloths[k], &error));
    }
    tulle_obstacle_def rest = tulle_obstacle_def_default(), pusher = tulle_obstacle_def_default();
    rest.mesh = tulle_mesh_get_view(&boxes[0]);
    require(tulle_world_add_obstacle(world, &rest, NULL, &error));
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}}, {0.3, {-0.1, 0, 0.05}, {0, 0, 0}}};
    pusher.mesh = tulle_mesh_get_view(&boxes[1]);
    pusher.motion = (tulle_motion){keys, 2, {0, 0, 0}, 0};
    require(tulle_world_add_obstacle(world, &pusher, NULL, &error));

    tulle_step_report report = {0};
    for (int step = 0; step < STEPS; step++)
        require(tulle_world_step(world, 1.0 / 90.0, &report, &error));
    printf("%016" PRIx64 "\n", tulle_world_get_state_hash(world));

    size_t const intersections = judge(world, sheets, cloths, &boxes[0]);
    tulle_world_destroy(world);
    for (int k = 0; k < 2; k++) {
        tulle_mesh_destroy(&sheets[k]);
        tulle_mesh_destroy(&boxes[k]);
    }
    return intersections > 0;
}
