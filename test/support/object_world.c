#include "support/object_world.h"

#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void things_fine(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("%s", error->message);
}

/* Frames of a box that rises and falls; context is the box. */
static tulle_status things_read(void *context, uint32_t frame, double *positions,
                                tulle_error *error) {
    const tulle_mesh *const box = context;
    (void)error;
    memcpy(positions, box->positions, 3 * box->vertex_count * sizeof *positions);
    for (size_t v = 0; v < box->vertex_count; v++)
        positions[3 * v + 2] += 0.002 * (double)(frame % 7);
    return TULLE_OK;
}

/* The mesh of a thing, made once. */
static const tulle_mesh *get_mesh(thing what) {
    static const double places[][3] = {
        [THING_GROUND] = {0.0, 0.0, -0.1}, [THING_BOX] = {-0.4, 0.0, 0.06},
        [THING_BALL] = {0.0, 0.05, 0.12},  [THING_KEYS] = {-0.4, 0.4, 0.2},
        [THING_FRAMES] = {0.4, 0.4, 0.1},  [THING_RIGID] = {0.4, -0.4, 0.1},
        [THING_VERTICES] = {0.4, 0.0, 0.1}};
    static tulle_mesh meshes[THING_COUNT];
    tulle_mesh *const mesh = &meshes[what];
    double const size = what == THING_BOX ? 0.1 : 0.05;
    if (mesh->positions) return mesh;
    switch (what) {
    case THING_SHEET: *mesh = small_sheet(0.3, 9, 0.03); break;
    case THING_PINNED: *mesh = small_sheet(0.2, 6, 0.6); break;
    case THING_GROUND: *mesh = bodies_make_box(2.0, 2.0, 0.2, places[what]); break;
    case THING_BALL: *mesh = bodies_make_ball(0.03, 2, places[what]); break;
    default: *mesh = bodies_make_box(size, size, size, places[what]); break;
    }
    return mesh;
}

/* The same, x [m] aside; its positions are the caller's. */
static tulle_mesh_view make_view(thing what, double x) {
    const tulle_mesh *const mesh = get_mesh(what);
    size_t const bytes = 3 * mesh->vertex_count * sizeof *mesh->positions;
    double *const positions = malloc(bytes);
    assert_non_null(positions);
    memcpy(positions, mesh->positions, bytes);
    for (size_t v = 0; v < mesh->vertex_count; v++) positions[3 * v] += x;
    return (tulle_mesh_view){positions, mesh->vertex_count, mesh->triangles, mesh->triangle_count};
}

bool thing_is_body(thing what) { return what == THING_BOX || what == THING_BALL; }

static bool thing_is_cloth(thing what) { return what <= THING_PINNED; }

tulle_status things_try_cloth(tulle_world *world, thing what, double x, tulle_cloth_id *id,
                              tulle_error *error) {
    static const uint32_t held[] = {0, 1}, moved[] = {5, 11};
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {0.5, {0.0, 0.05, 0.02}, {0, 0, 0}}};
    tulle_pin pins[] = {make_pin(held, 2, (double)INFINITY), make_pin(moved, 2, 0.4)};
    pins[1].motion = (tulle_motion){.keys = keys, .key_count = 2};
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = make_view(what, x);
    if (what == THING_PINNED) {
        def.pins = pins;
        def.pin_count = 2;
        def.material.bend_hysteresis_warp = 20.0 * def.material.bend_warp;
        def.material.bend_hysteresis_weft = 30.0 * def.material.bend_weft;
    }
    if (tulle_world_get_paper_options(world).response == TULLE_RESPONSE_PAPER)
        def.material.springs.stiffening_strain = 0.0;
    def.velocity[0] = 0.1;
    tulle_status const status = tulle_world_add_cloth(world, &def, id, error);
    free((double *)(uintptr_t)def.mesh.positions);
    return status;
}

tulle_status things_try_obstacle(tulle_world *world, thing what, double x, tulle_obstacle_id *id,
                                 tulle_error *error) {
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {1.0, {0.0, 0.0, 0.1}, {0, 0, 0}}};
    tulle_obstacle_def def = tulle_obstacle_def_default();
    if (what == THING_FRAMES) {
        def.read_frame = things_read;
        def.frame_context = (void *)(uintptr_t)get_mesh(what);
        def.frame_count = 1000;
        def.frame_interval = THING_STEP;
    }
    def.mesh = make_view(what, what == THING_FRAMES ? 0.0 : x);
    if (thing_is_body(what))
        def.body =
            (tulle_body){.is_dynamic = 1, .density = 300.0, .sleep_speed = 0.02, .sleep_time = 0.2};
    if (what == THING_KEYS) def.motion = (tulle_motion){.keys = keys, .key_count = 2};
    if (what == THING_RIGID) def.drive = TULLE_DRIVE_RIGID;
    if (what == THING_VERTICES) def.drive = TULLE_DRIVE_DEFORMING;
    tulle_status const status = tulle_world_add_obstacle(world, &def, id, error);
    free((double *)(uintptr_t)def.mesh.positions);
    return status;
}

tulle_status things_try(tulle_world *world, thing what, double x, tulle_object_id *id,
                        tulle_error *error) {
    tulle_cloth_id cloth = {0};
    tulle_obstacle_id obstacle = {0};
    tulle_status const status = thing_is_cloth(what)
                                    ? things_try_cloth(world, what, x, &cloth, error)
                                    : things_try_obstacle(world, what, x, &obstacle, error);
    *id = thing_is_cloth(what) ? tulle_object_from_cloth(cloth)
                               : tulle_object_from_obstacle(obstacle);
    return status;
}

tulle_object_id things_add(tulle_world *world, thing what, double x) {
    tulle_error error = {0};
    tulle_object_id id;
    things_fine(things_try(world, what, x, &id, &error), &error);
    return id;
}

tulle_status things_try_remove(tulle_world *world, tulle_object_id id, tulle_error *error) {
    if (id.kind == TULLE_OBJECT_CLOTH)
        return tulle_world_remove_cloth(world, (tulle_cloth_id){id.index, id.generation}, error);
    return tulle_world_remove_obstacle(world, (tulle_obstacle_id){id.index, id.generation}, error);
}

void things_remove(tulle_world *world, tulle_object_id id) {
    tulle_error error = {0};
    things_fine(things_try_remove(world, id, &error), &error);
}

tulle_world *things_make_world(const tulle_world_def *wanted) {
    tulle_world_def def = wanted ? *wanted : tulle_world_def_default();
    if (!wanted) def.threads = 1;
    tulle_world *world = NULL;
    tulle_error error = {0};
    things_fine(tulle_world_create(&def, &world, &error), &error);
    return world;
}

void things_start(tulle_world *world) {
    tulle_error error = {0};
    things_fine(tulle_world_start(world, &error), &error);
}

void things_step(tulle_world *world, int count) {
    tulle_error error = {0};
    for (int i = 0; i < count; i++)
        things_fine(tulle_world_step(world, THING_STEP, NULL, &error), &error);
}

/* Pairs of triangles that intersect now, of all that is present. */
size_t things_judge(const tulle_world *world) {
    tulle_counts const counts = tulle_world_get_counts(world);
    size_t const count = counts.cloths + counts.obstacles;
    tulle_check_body *const bodies = calloc(count + 1, sizeof *bodies);
    size_t body_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        tulle_object_id const id = tulle_world_get_object(world, i);
        tulle_object_info const info = tulle_object_get_info(world, id);
        bool const is_cloth = id.kind == TULLE_OBJECT_CLOTH;
        tulle_cloth_id const cloth = {id.index, id.generation};
        tulle_obstacle_id const obstacle = {id.index, id.generation};
        if (!is_cloth && !tulle_obstacle_is_present(world, obstacle)) continue;
        bodies[body_count++] = (tulle_check_body){
            .mesh = {is_cloth ? tulle_cloth_get_positions(world, cloth, NULL)
                              : tulle_obstacle_get_positions(world, obstacle, NULL),
                     info.vertex_count, info.triangles, info.triangle_count},
            .is_obstacle = !is_cloth};
    }
    tulle_check_result result = {0};
    tulle_error error = {0};
    things_fine(tulle_check_intersections(bodies, body_count, 1, &result, &error), &error);
    size_t const pairs = result.pair_count;
    tulle_check_result_destroy(&result);
    free(bodies);
    return pairs;
}
