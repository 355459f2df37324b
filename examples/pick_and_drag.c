/* pick_and_drag - an editor's mouse: a ray from the eye picks what it meets, and that is dragged:
 * cloth by its handles, which are pins, a rigid body by a spring. */
#include <tulle/tulle.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 17, STEPS = 60, BODIES = 2 }; /* the last one: a category of objects */

static const double STEP = 1.0 / 60.0, STIFFNESS = 40.0; /* [s], [N/m] of the spring */
static const double EYE[3] = {0.0, 0.0, 2.0}, MOUSE[3] = {0.05, 0.04, -0.2}; /* [m] */
static const uint32_t HANDLES[2] = {0, SIDE - 1}; /* corners of the towel */
static tulle_error error;

static void require(tulle_status status) {
    if (status == TULLE_OK) return;
    fprintf(stderr, "%s: %s\n", tulle_status_text(status), error.message);
    exit(2);
}

/* A towel above a ball, where nothing falls. */
static tulle_world *make_world(void) {
    tulle_world *world;
    tulle_world_def def = tulle_world_def_default();
    def.gravity[2] = 0.0;
    require(tulle_world_create(&def, &world, &error));
    tulle_mesh mesh;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = shape.size[1] = 0.5, shape.resolution[0] = shape.resolution[1] = SIDE;
    require(tulle_shape_generate(&shape, &mesh, &error));
    for (size_t v = 0; v < mesh.vertex_count; v++) mesh.positions[3 * v + 2] += 0.3;
    tulle_pin pin = tulle_pin_default();
    pin.vertices = HANDLES;
    pin.vertex_count = 2;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.name = "towel";
    cloth.mesh = tulle_mesh_get_view(&mesh);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    require(tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_mesh_destroy(&mesh);
    shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.1;
    require(tulle_shape_generate(&shape, &mesh, &error));
    tulle_obstacle_id ball;
    tulle_obstacle_def ball_def = tulle_obstacle_def_default();
    ball_def.name = "ball";
    ball_def.mesh = tulle_mesh_get_view(&mesh);
    ball_def.body = (tulle_body){.is_dynamic = 1, .density = 50.0, .linear_damping = 8.0};
    require(tulle_world_add_obstacle(world, &ball_def, &ball, &error));
    tulle_mesh_destroy(&mesh);
    tulle_object_id const id = tulle_object_from_obstacle(ball);
    require(tulle_object_set_filter(world, id, BODIES, UINT32_MAX, &error));
    require(tulle_world_start(world, &error));
    return world;
}

/* Where the picked point is now [m]. */
static void follow(tulle_world *world, const tulle_hit *hit, double place[3]) {
    uint32_t const index = hit->object.index, generation = hit->object.generation;
    const uint32_t *const triangles = tulle_object_get_info(world, hit->object).triangles;
    const double *const positions =
        hit->object.kind == TULLE_OBJECT_CLOTH
            ? tulle_cloth_get_positions(world, (tulle_cloth_id){index, generation}, NULL)
            : tulle_obstacle_get_positions(world, (tulle_obstacle_id){index, generation}, NULL);
    place[0] = place[1] = place[2] = 0.0;
    for (size_t k = 0; k < 9; k++)
        place[k % 3] +=
            hit->weights[k / 3] * positions[3 * triangles[3 * hit->triangle + k / 3] + k % 3];
}

/* What the mouse points at, of objects in the mask. */
static tulle_hit pick(tulle_world *world, uint32_t mask) {
    tulle_ray ray = {.mask = mask};
    tulle_hit hit;
    for (int c = 0; c < 3; c++) ray.from[c] = EYE[c], ray.to[c] = MOUSE[c];
    require(tulle_world_cast_ray(world, &ray, &hit, &error));
    if (hit.object.kind == TULLE_OBJECT_NONE) exit(3);
    printf("picked the %s\n", tulle_object_get_info(world, hit.object).name);
    return hit;
}

/* Moves the handles by `way` [m] along x. */
static void drag_cloth(tulle_world *world, const tulle_hit *hit, double way) {
    tulle_cloth_id const cloth = {hit->object.index, hit->object.generation};
    for (int step = 0; step < STEPS; step++) {
        const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
        double targets[6];
        for (size_t k = 0; k < 6; k++)
            targets[k] = x[3 * HANDLES[k / 3] + k % 3] + (k % 3 == 0 ? way / STEPS : 0.0);
        require(tulle_cloth_set_pin_targets(world, cloth, 0, targets, 2, &error));
        require(tulle_world_step(world, STEP, NULL, &error));
    }
}

/* Pulls the picked point after a mouse that moves by `way` [m] along x. */
static void drag_body(tulle_world *world, const tulle_hit *hit, double way) {
    tulle_obstacle_id const body = {hit->object.index, hit->object.generation};
    for (int step = 0; step < STEPS; step++) {
        double place[3], impulse[3];
        follow(world, hit, place);
        for (int c = 0; c < 3; c++) impulse[c] = STEP * STIFFNESS * (hit->position[c] - place[c]);
        impulse[0] += STEP * STIFFNESS * way * step / STEPS;
        require(tulle_obstacle_add_impulse(world, body, place, impulse, &error));
        require(tulle_world_step(world, STEP, NULL, &error));
    }
}

int main(void) {
    tulle_world *const world = make_world();
    tulle_hit const first = pick(world, 0), second = pick(world, BODIES);
    drag_cloth(world, &first, -0.2);
    drag_body(world, &second, 0.3);
    double towel[3], ball[3];
    follow(world, &first, towel);
    follow(world, &second, ball);
    printf("dragged to x = %.3f m and %.3f m\n", towel[0], ball[0]);
    tulle_world_destroy(world);
    return !(towel[0] < first.position[0] - 0.1 && ball[0] > second.position[0] + 0.2);
}
