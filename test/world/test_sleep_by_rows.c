/* What a host's allocator hands out decides no bit: sleeping cloth whose matrix lies by rows,
 * beside cloth that is awake and a rigid body, in a world that goes on from a state. */
#include "base/hash.h"
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 33, BEFORE = 8, AFTER = 3 };

static void *allocate_filled(void *fill, size_t byte_count) {
    void *const data = malloc(byte_count);
    if (data) memset(data, *(int *)fill, byte_count);
    return data;
}

static void release(void *fill, void *data, size_t byte_count) {
    (void)fill, (void)byte_count;
    free(data);
}

/* A sheet whose vertices are numbered in no order; pinned at its first corner, or free. */
static void add_shuffled(tulle_world *world, double height, double speed, bool is_pinned) {
    tulle_mesh mesh = small_sheet(0.5, SIDE, height);
    size_t const count = mesh.vertex_count;
    uint32_t *const places = malloc(count * sizeof *places);
    double *const positions = malloc(3 * count * sizeof *positions);
    uint64_t random = 5;
    for (uint32_t i = 0; i < count; i++) places[i] = i;
    for (size_t i = count - 1; i > 0; i--) {
        size_t const j = (size_t)(random_uniform(&random) * (double)(i + 1));
        uint32_t const place = places[i];
        places[i] = places[j];
        places[j] = place;
    }
    for (size_t i = 0; i < count; i++)
        memcpy(positions + 3 * (size_t)places[i], mesh.positions + 3 * i, 3 * sizeof *positions);
    memcpy(mesh.positions, positions, 3 * count * sizeof *positions);
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        mesh.triangles[i] = places[mesh.triangles[i]];
    tulle_pin const pin = make_pin(places, 1, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&mesh);
    cloth.velocity[2] = -speed;
    cloth.pins = &pin;
    cloth.pin_count = is_pinned;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    free(places), free(positions);
    tulle_mesh_destroy(&mesh);
}

/* One sheet at rest, one that flaps, and a ball far away. */
static tulle_world *make_world(int *fill) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.gravity[2] = 0.0;
    def.sleep_speed = 0.01;
    def.sleep_time = 0.03;
    def.allocator = (tulle_allocator){allocate_filled, release, fill, 0};
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    add_shuffled(world, 0.0, 0.0, false);
    add_shuffled(world, 1.0, 2.0, true);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.1;
    tulle_mesh ball = small_shape(shape, 3.0, 0.0, 0.0);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&ball);
    obstacle.body = (tulle_body){.is_dynamic = 1, .density = 300.0, .velocity = {0.0, 0.0, 0.1}};
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), TULLE_OK);
    tulle_mesh_destroy(&ball);
    return world;
}

static void steps_do_not_read_what_memory_held(void **state) {
    (void)state;
    static int fills[] = {0x00, 0xff};
    uint64_t hashes[2][AFTER];
    for (int k = 0; k < 2; k++) {
        tulle_world *world = make_world(&fills[k]);
        tulle_step_report report;
        void *bytes = NULL;
        size_t byte_count = 0;
        for (int i = 0; i < BEFORE; i++)
            assert_int_equal(tulle_world_step(world, 1.0 / 90.0, &report, NULL), TULLE_OK);
        assert_int_equal(tulle_world_save_state(world, &bytes, &byte_count, NULL), TULLE_OK);
        tulle_world *const other = make_world(&fills[k]);
        assert_int_equal(tulle_world_start(other, NULL), TULLE_OK);
        assert_int_equal(tulle_world_load_state(other, bytes, byte_count, NULL), TULLE_OK);
        for (int i = 0; i < AFTER; i++) {
            assert_int_equal(tulle_world_step(other, 1.0 / 90.0, &report, NULL), TULLE_OK);
            hashes[k][i] = tulle_world_get_state_hash(other);
        }
        tulle_world_free_state(world, bytes, byte_count);
        tulle_world_destroy(world);
        tulle_world_destroy(other);
    }
    assert_memory_equal(hashes[0], hashes[1], sizeof hashes[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_do_not_read_what_memory_held)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
