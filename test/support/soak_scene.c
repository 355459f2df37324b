/* support/soak_scene.c - see soak_scene.h. */
#include "support/soak_scene.h"

#include "support/body_world.h"
#include "support/pins.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum {
    SIDE = 11,            /* vertices along a side of a cloth */
    FRAMES_PER_CYCLE = 32 /* of the ball */
};
static const double PERIOD = SOAK_STEPS_PER_CYCLE / 64.0; /* [s] of a cycle */
static const double TOSS_SPEED = 1.0;                     /* [m/s] */

/* A keyframe at each half of a cycle: at rest, and away by `way` [m], turned about z by `angle`. */
static tulle_keyframe *make_keys(size_t count, const double way[3], double angle) {
    tulle_keyframe *const keys = calloc(count, sizeof *keys);
    assert_non_null(keys);
    for (size_t i = 0; i < count; i++) {
        keys[i].time = 0.5 * PERIOD * (double)i;
        if (i % 2 == 0) continue;
        memcpy(keys[i].translation, way, 3 * sizeof(double));
        keys[i].rotation_vector[2] = angle;
    }
    return keys;
}

soak_scene soak_scene_make(size_t cycles) {
    soak_scene scene = {.key_count = 2 * cycles + 1};
    scene.cloths[0] = small_sheet(0.6, SIDE, 0.0);
    scene.cloths[1] = small_sheet(0.5, SIDE, 0.0);
    for (size_t v = 0; v < scene.cloths[1].vertex_count; v++) { /* upright */
        double *const x = scene.cloths[1].positions + 3 * v;
        x[2] = x[0];
        x[0] = 1.0;
    }
    scene.obstacles[0] = bodies_make_box(0.06, 0.06, 0.06, (const double[]){0.08, 0.0, 0.06});
    scene.obstacles[1] = bodies_make_box(0.08, 0.05, 0.04, (const double[]){-0.06, 0.05, 0.12});
    scene.obstacles[2] = bodies_make_ball(0.1, 8, (const double[]){0.0, 0.0, -0.3});
    scene.obstacles[3] = bodies_make_box(0.3, 0.04, 0.04, (const double[]){0.7, 0.0, -0.15});
    scene.keys[0] = make_keys(scene.key_count, (const double[]){0.0, 0.23, 0.0}, 0.0);
    scene.keys[1] = make_keys(scene.key_count, (const double[]){0.0, -0.23, 0.0}, 0.0);
    scene.keys[2] = make_keys(scene.key_count, (const double[]){0.3, 0.05, 0.1}, 0.6);
    return scene;
}

void soak_scene_destroy(soak_scene *scene) {
    for (size_t i = 0; i < SOAK_CLOTHS; i++) tulle_mesh_destroy(&scene->cloths[i]);
    for (size_t i = 0; i < SOAK_OBSTACLES; i++) tulle_mesh_destroy(&scene->obstacles[i]);
    for (size_t i = 0; i < 3; i++) free(scene->keys[i]);
}

/* The ball goes round upright: up into the hammock and down. */
static tulle_status read_ball(void *context, uint32_t frame, double *positions,
                              tulle_error *error) {
    (void)error;
    const tulle_mesh *const ball = context;
    double const angle = 6.283185307179586 * (frame % FRAMES_PER_CYCLE) / FRAMES_PER_CYCLE;
    for (size_t v = 0; v < ball->vertex_count; v++) {
        positions[3 * v] = ball->positions[3 * v] + 0.1 * sin(angle);
        positions[3 * v + 1] = ball->positions[3 * v + 1];
        positions[3 * v + 2] = ball->positions[3 * v + 2] + 0.11 * (1.0 - cos(angle));
    }
    return TULLE_OK;
}

static void add_cloths(const soak_scene *scene, tulle_world *world) {
    uint32_t const last = SIDE * SIDE - 1;
    const uint32_t corners[4] = {0, SIDE - 1, last - (SIDE - 1), last};
    tulle_pin const held = make_pin(corners, 4, INFINITY);
    tulle_cloth_def hammock = tulle_cloth_def_default();
    hammock.mesh = tulle_mesh_get_view(&scene->cloths[0]);
    hammock.pins = &held;
    hammock.pin_count = 1;
    tulle_cloth_def curtain = tulle_cloth_def_default();
    curtain.mesh = tulle_mesh_get_view(&scene->cloths[1]);
    tulle_pin rods[2];
    uint32_t tops[2] = {0, 0};
    for (uint32_t v = 0; v < curtain.mesh.vertex_count; v++) { /* the two highest, by y */
        const double *const x = curtain.mesh.positions + 3 * v;
        if (x[2] < 0.25 - 1e-9) continue;
        if (x[1] < -0.25 + 1e-9) tops[0] = v;
        if (x[1] > 0.25 - 1e-9) tops[1] = v;
    }
    for (size_t i = 0; i < 2; i++) {
        rods[i] = make_pin(&tops[i], 1, INFINITY);
        rods[i].motion = (tulle_motion){scene->keys[i], scene->key_count, {0.0, 0.0, 0.0}, 1};
    }
    curtain.pins = rods;
    curtain.pin_count = 2;
    tulle_error error = {0};
    if (tulle_world_add_cloth(world, &hammock, NULL, &error) != TULLE_OK ||
        tulle_world_add_cloth(world, &curtain, NULL, &error) != TULLE_OK)
        fail_msg("%s", error.message);
}

static void add_obstacles(const soak_scene *scene, tulle_world *world) {
    for (size_t i = 0; i < SOAK_OBSTACLES; i++) {
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(&scene->obstacles[i]);
        if (i < SOAK_BODIES) {
            def.body = (tulle_body){
                .is_dynamic = 1, .density = 150.0, .linear_damping = 0.1, .angular_damping = 0.1};
        } else if (i == SOAK_BODIES) {
            def.read_frame = read_ball;
            def.frame_context = (void *)&scene->obstacles[i];
            def.frame_count = 1000000000; /* the most */
            def.frame_interval = PERIOD / FRAMES_PER_CYCLE;
        } else {
            def.motion = (tulle_motion){scene->keys[2], scene->key_count, {0.55, 0.0, -0.15}, 1};
        }
        tulle_error error = {0};
        if (tulle_world_add_obstacle(world, &def, NULL, &error) != TULLE_OK)
            fail_msg("%s", error.message);
    }
}

tulle_world *soak_scene_build(const soak_scene *scene, const tulle_allocator *heap) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.allocator = *heap;
    def.wind = (tulle_wind){.velocity = {0.5, 0.2, 0.0},
                            .gust_strength = 1.0,
                            .gust_length = 0.5,
                            .gust_time = 0.5,
                            .seed = 7,
                            .drag_coefficient = 0.6};
    tulle_world *world = NULL;
    tulle_error error = {0};
    if (tulle_world_create(&def, &world, &error) != TULLE_OK) fail_msg("%s", error.message);
    add_cloths(scene, world);
    add_obstacles(scene, world);
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    return world;
}

void soak_scene_push(tulle_world *world) {
    for (uint32_t i = 0; i < SOAK_BODIES; i++) {
        tulle_obstacle_id const id = {i, 1};
        tulle_transform const body = bodies_get_transform(world, id);
        bool const is_tossed = tulle_world_get_step_count(world) % SOAK_STEPS_PER_CYCLE == 64 * i;
        double impulse[3] = {0.0, 0.0, is_tossed ? body.mass * TOSS_SPEED : 0.0};
        for (int axis = 0; axis < 2; axis++) /* a spring of 2 Hz beyond 8 cm, damped */
            if (fabs(body.position[axis]) > 0.08)
                impulse[axis] = -body.mass * SOAK_STEP *
                                (150.0 * body.position[axis] + 5.0 * body.velocity[axis]);
        assert_int_equal(tulle_obstacle_add_impulse(world, id, body.position, impulse, NULL),
                         TULLE_OK);
    }
}

size_t soak_scene_judge(const soak_scene *scene, const tulle_world *world) {
    return bodies_judge(world, scene->cloths, SOAK_CLOTHS, scene->obstacles, SOAK_OBSTACLES);
}
