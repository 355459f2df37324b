/* tear_off - a banner hangs on a bar that a host moves. Each vertex of its upper border bears some
 * newtons. The wind rises until the banner tears off and falls. */
#include <tulle/tulle.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ACROSS = 17, DOWN = 13, STEPS = 345 };
static const double STEP = 1.0 / 60.0; /* [s] */

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* The banner lies level beside the bar at first. `border`: its vertices along the bar. */
static tulle_cloth_id add_banner(tulle_world *world, uint32_t border[ACROSS]) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.resolution[0] = ACROSS;
    shape.resolution[1] = DOWN;
    shape.size[0] = 0.8;
    shape.size[1] = 0.6;
    tulle_mesh mesh;
    require(tulle_shape_generate(&shape, &mesh, &error));
    size_t found = 0;
    for (size_t v = 0; v < mesh.vertex_count; v++) mesh.positions[3 * v + 1] += 0.325;
    for (uint32_t v = 0; v < mesh.vertex_count && found < ACROSS; v++)
        if (mesh.positions[3 * (size_t)v + 1] < 0.026) border[found++] = v;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.name = "banner";
    def.mesh = tulle_mesh_get_view(&mesh);
    tulle_cloth_id id;
    require(tulle_world_add_cloth(world, &def, &id, &error));
    tulle_mesh_destroy(&mesh);
    return id;
}

static tulle_obstacle_id add_bar(tulle_world *world) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    shape.size[0] = 0.9;
    shape.size[1] = shape.size[2] = 0.04;
    tulle_mesh mesh;
    require(tulle_shape_generate(&shape, &mesh, &error));
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.drive = TULLE_DRIVE_RIGID;
    tulle_obstacle_id id;
    require(tulle_world_add_obstacle(world, &def, &id, &error));
    tulle_mesh_destroy(&mesh);
    return id;
}

int main(void) {
    tulle_world_def world_def = tulle_world_def_default();
    tulle_world *world;
    require(tulle_world_create(&world_def, &world, &error));
    uint32_t border[ACROSS];
    tulle_cloth_id const banner = add_banner(world, border);
    tulle_obstacle_id const bar = add_bar(world);
    require(tulle_world_start(world, &error));

    tulle_attachment_def held = tulle_attachment_def_default();
    held.cloth = banner;
    held.vertices = border;
    held.vertex_count = ACROSS;
    held.obstacle = bar;
    held.break_force = 4.0; /* [N] each */
    tulle_attachment_id seam;
    require(tulle_world_attach(world, &held, &seam, &error));

    size_t before = ACROSS;
    for (int step = 0; step < STEPS; step++) {
        double const time = step * STEP;
        double const place[3] = {0.1 * sin(2.0 * time), 0.0, 0.0};
        double const turn[4] = {1.0, 0.0, 0.0, 0.0};
        require(
            tulle_obstacle_set_next_transform(world, bar, place, turn, TULLE_TRAVEL_MOVE, &error));
        tulle_wind wind = world_def.wind;
        wind.velocity[1] = 8.0 * time; /* [m/s] */
        require(tulle_world_set_wind(world, &wind, &error));
        require(tulle_world_step(world, STEP, NULL, &error));

        tulle_attachment_report const report = tulle_attachment_get_report(world, seam);
        if (report.held_count < before)
            printf("%.2f s: %s\n", time, tulle_world_last_message(world));
        before = report.held_count;
    }
    printf("%zu of %d vertices are held\n", before, ACROSS);
    tulle_world_destroy(world);
    return before == 0 ? 0 : 1;
}
