/* run_scene - simulates a scene file for a number of frames and writes its first cloth as a mesh.
 * usage: run_scene SCENE.yaml FRAMES MESH (.obj, .ply or .stl) */
#include <tulle/tulle.h>
#include <tulle_io/tulle_io.h>

#include <stdio.h>
#include <stdlib.h>

static tulle_error error;
static tulle_scene_problems problems;

/* Steps the world to the end of the last frame. */
static tulle_status run(const tulle_scene *scene, tulle_world *world, long frames) {
    long const steps = frames * (long)tulle_scene_get_steps_per_frame(scene);
    tulle_status status = TULLE_OK;
    for (long step = 0; status == TULLE_OK && step < steps; step++)
        status = tulle_world_step(world, tulle_scene_get_time_step(scene), NULL, &error);
    return status;
}

/* Writes the first cloth with the positions that the world has for it. */
static tulle_status write_cloth(const tulle_scene *scene, const tulle_scene_world *built,
                                const char *path) {
    tulle_mesh_view mesh = tulle_scene_get_cloth_mesh(scene, 0);
    mesh.positions = tulle_cloth_get_positions(built->world, built->cloths[0], NULL);
    return tulle_mesh_write(path, mesh, &error);
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: run_scene SCENE.yaml FRAMES MESH\n");
        return 2;
    }
    tulle_scene *scene = NULL;
    if (tulle_scene_load(argv[1], NULL, 0, &scene, &problems) != TULLE_OK) {
        for (size_t i = 0; i < problems.count; i++)
            fprintf(stderr, "%s:%d: %s\n", problems.list[i].file, problems.list[i].line,
                    problems.list[i].message);
        return 2;
    }
    tulle_scene_world built = {0};
    tulle_status status = tulle_scene_build_world(scene, 0, NULL, &built, &error);
    if (status == TULLE_OK) status = run(scene, built.world, atol(argv[2]));
    if (status == TULLE_OK && built.cloth_count > 0) status = write_cloth(scene, &built, argv[3]);
    if (status == TULLE_OK)
        printf("%.3f s: wrote %s\n", tulle_world_get_time(built.world), argv[3]);
    else
        fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(scene);
    return status == TULLE_OK ? 0 : 2;
}
