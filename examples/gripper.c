/* gripper - two fingers close on a towel with a force that is told, lift it off a table and carry
 * it away. `gripper 2` closes with 2 N, which holds; with `gripper 0.02` the towel slips out. */
#include <tulle/tulle.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ACROSS = 17 }; /* vertices along a side of the towel */
static const double STEP = 1.0 / 90.0, SIDE = 0.3, GRIP_HEIGHT = 0.28; /* [s], [m], [m] */
static const double HANDED_OVER = 0.4;                                 /* [s] */

static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

static tulle_mesh make_box(double x, double y, double z, const double at[3]) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = x, def.size[1] = y, def.size[2] = z;
    tulle_mesh mesh = {0};
    require(tulle_shape_generate(&def, &mesh, &error));
    tulle_mesh_transform(&mesh, (double[]){1, 1, 1}, (double[]){1, 0, 0, 0}, at);
    return mesh;
}

/* A towel that hangs upright over the table, held by its upper corners until it is handed over. */
static tulle_cloth_id add_towel(tulle_world *world) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = shape.size[1] = SIDE;
    shape.resolution[0] = shape.resolution[1] = ACROSS;
    tulle_mesh mesh = {0};
    require(tulle_shape_generate(&shape, &mesh, &error));
    double const upright[4] = {sqrt(0.5), sqrt(0.5), 0.0, 0.0};
    tulle_mesh_transform(&mesh, (double[]){1, 1, 1}, upright, (double[]){0, 0, 0.5 * SIDE + 0.01});
    uint32_t const corners[2] = {ACROSS * (ACROSS - 1), ACROSS * ACROSS - 1};
    tulle_pin pin = tulle_pin_default();
    pin.vertices = corners;
    pin.vertex_count = 2;
    pin.release_time = HANDED_OVER;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.pins = &pin;
    def.pin_count = 1;
    tulle_cloth_id id;
    require(tulle_world_add_cloth(world, &def, &id, &error));
    tulle_mesh_destroy(&mesh);
    return id;
}

static tulle_obstacle_id add_finger(tulle_world *world, double side) {
    tulle_mesh mesh = make_box(0.06, 0.02, 0.03, (double[]){0.0, 0.03 * side, GRIP_HEIGHT});
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.friction = 0.6;
    def.body = (tulle_body){.is_dynamic = 1, .mass = 0.2};
    tulle_obstacle_id id;
    require(tulle_world_add_obstacle(world, &def, &id, &error));
    tulle_mesh_destroy(&mesh);
    return id;
}

/* Part of a way, gently from 0 at `begin` to 1 at `end`. */
static double ease(double time, double begin, double end) {
    double const s = fmin(fmax((time - begin) / (end - begin), 0.0), 1.0);
    return s * s * (3.0 - 2.0 * s);
}

/* A finger closes along y with at most `grip` newtons, and goes along x and z like on a rail. */
static void drive_finger(tulle_world *world, tulle_obstacle_id id, double side, double grip) {
    double const end = tulle_world_get_time(world) + STEP;
    tulle_body_drive drive = tulle_body_drive_default();
    drive.position[0] = 0.25 * ease(end, 1.2, 2.0);
    drive.position[2] = GRIP_HEIGHT + 0.3 * ease(end, 0.5, 1.2);
    drive.stiffness[0] = drive.stiffness[2] = 1e9;
    drive.velocity[1] = -0.1 * side;
    drive.damping[1] = 1e3;
    drive.force_limit[1] = grip;
    require(tulle_obstacle_set_drive(world, id, &drive, &error));
}

int main(int count, char **arguments) {
    double const grip = count > 1 ? atof(arguments[1]) : 2.0; /* [N] */
    tulle_world_def def = tulle_world_def_default();
    tulle_world *world = NULL;
    require(tulle_world_create(&def, &world, &error));
    tulle_cloth_id const towel = add_towel(world);
    tulle_mesh const top = make_box(1.0, 1.0, 0.1, (double[]){0.0, 0.0, -0.05});
    tulle_obstacle_def table = tulle_obstacle_def_default();
    table.mesh = tulle_mesh_get_view(&top);
    require(tulle_world_add_obstacle(world, &table, NULL, &error));
    tulle_obstacle_id const fingers[2] = {add_finger(world, 1.0), add_finger(world, -1.0)};
    require(tulle_world_start(world, &error));
    for (int k = 0; k < 2; k++) /* no finger turns */
        require(tulle_obstacle_set_locks(world, fingers[k], 0, TULLE_LOCK_ALL, &error));

    double force[3], torque[3], most = 0.0;
    while (tulle_world_get_time(world) < 2.5) {
        for (int k = 0; k < 2; k++) drive_finger(world, fingers[k], k == 0 ? 1.0 : -1.0, grip);
        require(tulle_world_step(world, STEP, NULL, &error));
        require(tulle_obstacle_get_drive_force(world, fingers[0], force, torque, &error));
        most = fmax(most, fabs(force[1]));
    }
    /* the middle of the towel's upper edge, where the fingers hold it */
    size_t vertex_count;
    const double *const x = tulle_cloth_get_positions(world, towel, &vertex_count);
    const double *const held = x + 3 * (vertex_count - 1 - ACROSS / 2);
    printf("at most %.3g N; the towel's edge is at %.3f, %.3f, %.3f m: it %s\n", most, held[0],
           held[1], held[2], held[2] > 0.5 && held[0] > 0.2 ? "holds" : "slips");
    tulle_world_destroy(world);
    return 0;
}
