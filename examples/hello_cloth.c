/* hello_cloth - a square metre of cotton falls on a ball; ends with a report and the judge's
 * verdict. */
#include <tulle/tulle.h>

#include <stdio.h>
#include <stdlib.h>

static tulle_error error;

/* Every call returns a status; this program ends where one is not TULLE_OK. */
static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

static tulle_mesh make_sheet(double height) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 1.0;
    def.resolution[0] = def.resolution[1] = 31;
    tulle_mesh mesh = {0};
    require(tulle_shape_generate(&def, &mesh, &error));
    tulle_mesh_transform(&mesh, (double[]){1, 1, 1}, (double[]){1, 0, 0, 0},
                         (double[]){0, 0, height});
    return mesh;
}

static tulle_mesh make_ball(double radius) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    tulle_mesh mesh = {0};
    require(tulle_shape_generate(&def, &mesh, &error));
    return mesh;
}

int main(void) {
    tulle_mesh sheet = make_sheet(0.35), ball = make_ball(0.3);

    tulle_world *world = NULL;
    tulle_world_def world_def = tulle_world_def_default();
    require(tulle_world_create(&world_def, &world, &error));

    tulle_cloth_id cloth;
    tulle_cloth_def cloth_def = tulle_cloth_def_default();
    cloth_def.mesh = tulle_mesh_get_view(&sheet);
    require(tulle_material_preset("cotton", &cloth_def.material));
    require(tulle_world_add_cloth(world, &cloth_def, &cloth, &error));

    tulle_obstacle_id obstacle;
    tulle_obstacle_def ball_def = tulle_obstacle_def_default();
    ball_def.mesh = tulle_mesh_get_view(&ball);
    require(tulle_world_add_obstacle(world, &ball_def, &obstacle, &error));

    tulle_step_report report = {0};
    for (int step = 0; step < 60; step++)
        require(tulle_world_step(world, 1.0 / 90.0, &report, &error));
    printf("%.3f s: %llu contacts, smallest gap %.3g mm, greatest stretch %.3f\n", report.time,
           (unsigned long long)report.contacts, 1e3 * report.smallest_gap, report.max_stretch);

    tulle_mesh_view draped = cloth_def.mesh;
    draped.positions = tulle_cloth_get_positions(world, cloth, NULL);
    tulle_check_body bodies[2] = {{.mesh = draped}, {.mesh = ball_def.mesh, .is_obstacle = 1}};
    tulle_check_result verdict;
    require(tulle_check_intersections(bodies, 2, 0, &verdict, &error));
    printf("%zu intersections\n", verdict.pair_count);

    int const exit_code = verdict.pair_count > 0;
    tulle_check_result_destroy(&verdict);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    return exit_code;
}
