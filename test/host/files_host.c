/* A program that embeds libtulle_io: it loads a scene file, runs its world for some steps, writes
 * a mesh and reads it again. It prints the hash of the world's state. */
#include <tulle_io/tulle_io.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEPS = 3 };

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* A scene file and where to write a mesh. */
int main(int count, char **arguments) {
    if (count != 3) return 2;
    static tulle_scene_problems problems;
    tulle_scene *scene = NULL;
    if (tulle_scene_load(arguments[1], NULL, 0, &scene, &problems) != TULLE_OK) {
        const tulle_error *const first = &problems.list[0];
        fprintf(stderr, "%s:%d:%d: %s\n", first->file, first->line, first->column, first->message);
        return 1;
    }
    tulle_scene_world built;
    require(tulle_scene_build_world(scene, 1, NULL, &built, &error));
    for (int step = 0; step < STEPS; step++)
        require(tulle_world_step(built.world, tulle_scene_get_time_step(scene), NULL, &error));
    printf("%016" PRIx64 "\n", tulle_world_get_state_hash(built.world));

    tulle_mesh_view const cloth = tulle_scene_get_cloth_mesh(scene, 0);
    require(tulle_mesh_write(arguments[2], cloth, &error));
    tulle_mesh mesh = {0};
    require(tulle_mesh_read(arguments[2], &mesh, &error));
    int const is_same = mesh.vertex_count == cloth.vertex_count;

    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = 1;
    tulle_subdivision *subdivision = NULL;
    require(tulle_subdivision_create(cloth, &def, &subdivision, &error));
    int const is_finer =
        tulle_subdivision_get_triangle_count(subdivision) == 4 * cloth.triangle_count;

    tulle_subdivision_destroy(subdivision);
    tulle_mesh_destroy(&mesh);
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(scene);
    return !is_same || !is_finer;
}
