/* record_calls - a program that embeds the library writes down its calls, so that others can repeat
 * them: `tulle replay FILE`. A cloth falls on a ball that the host swings.
 * usage: record_calls FILE */
#include <tulle/tulle.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEPS = 60 };

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* Each block reaches the system before the call goes on: a crash loses none. */
static int write_block(void *file, const void *bytes, size_t byte_count) {
    return fwrite(bytes, 1, byte_count, file) == byte_count && fflush(file) == 0;
}

static tulle_mesh make_mesh(tulle_shape shape, double height) {
    tulle_shape_def def = tulle_shape_def_default(shape);
    if (shape == TULLE_SHAPE_RECTANGLE)
        def.resolution[0] = def.resolution[1] = 17;
    else
        def.radius = 0.2;
    tulle_mesh mesh;
    require(tulle_shape_generate(&def, &mesh, &error));
    for (size_t v = 0; v < mesh.vertex_count; v++) mesh.positions[3 * v + 2] += height;
    return mesh;
}

int main(int argc, char **argv) {
    FILE *const file = argc == 2 ? fopen(argv[1], "wb") : NULL;
    if (!file) {
        fputs("usage: record_calls FILE\n", stderr);
        return 2;
    }
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world;
    tulle_record_writer const writer = {write_block, file};
    require(tulle_world_create(&def, &world, &error));
    require(tulle_world_record(world, &writer, &error)); /* before anything is added */

    tulle_mesh sheet = make_mesh(TULLE_SHAPE_RECTANGLE, 0.25),
               ball = make_mesh(TULLE_SHAPE_SPHERE, 0.0);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    require(tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&ball);
    obstacle.drive = TULLE_DRIVE_RIGID;
    tulle_obstacle_id id;
    require(tulle_world_add_obstacle(world, &obstacle, &id, &error));
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);

    require(tulle_world_start(world, &error));
    for (int i = 1; i <= STEPS; i++) {
        double const to[3] = {0.2 * sin(0.1 * i), 0.0, 0.0}, rotation[4] = {1.0, 0.0, 0.0, 0.0};
        require(
            tulle_obstacle_set_next_transform(world, id, to, rotation, TULLE_TRAVEL_MOVE, &error));
        require(tulle_world_step(world, 1.0 / 60.0, NULL, &error));
    }
    printf("state %016llx\n", (unsigned long long)tulle_world_get_state_hash(world));
    require(tulle_world_record(world, NULL, &error));
    tulle_world_destroy(world);
    return fclose(file) == 0 ? 0 : 2;
}
