/* Cloth that lies on cloth: it sleeps no sooner than what carries it, however still it lies. */
#include "tulle/tulle.h"

#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

enum { SIDE = 17, STEPS = 320, SETTLED = 160 };
static const double STEP = 1.0 / 64.0; /* [s] */
static const tulle_cloth_id LOWER = {0, 1}, UPPER = {1, 1};

static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

/* A sheet on a table, one edge of which the host lifts by 4 mm and lowers again and again, and a
 * patch on its other end. */
static tulle_world *make_layers(double targets[3 * SIDE]) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.sleep_speed = 2e-3;
    world_def.sleep_time = 0.5;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&world_def, &world, &error));
    tulle_mesh sheet = small_sheet(0.8, SIDE, 0.006), patch = small_sheet(0.1, 5, 0.014);
    tulle_mesh table = bodies_make_box(2.0, 2.0, 0.1, (double[]){0.0, 0.0, -0.05});
    uint32_t edge[SIDE];
    size_t count = 0;
    for (uint32_t v = 0; v < sheet.vertex_count; v++)
        if (sheet.positions[3 * v] < -0.399) edge[count++] = v;
    assert_int_equal(count, SIDE);
    for (size_t k = 0; k < 3 * (size_t)SIDE; k++)
        targets[k] = sheet.positions[3 * edge[k / 3] + k % 3];
    for (uint32_t v = 0; v < patch.vertex_count; v++) patch.positions[3 * v] += 0.3;
    tulle_pin const pin = make_pin(edge, SIDE, (double)INFINITY);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    def.pins = &pin;
    def.pin_count = 1;
    FINE(tulle_world_add_cloth(world, &def, NULL, &error));
    def.pin_count = 0;
    def.mesh = tulle_mesh_get_view(&patch);
    FINE(tulle_world_add_cloth(world, &def, NULL, &error));
    bodies_add_obstacle(world, &table, 0.5, NULL);
    FINE(tulle_world_start(world, &error));
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&patch);
    tulle_mesh_destroy(&table);
    return world;
}

/* [m/s] The fastest vertex. */
static double measure_speed(const tulle_world *world, tulle_cloth_id id, double *last) {
    size_t count;
    const double *const now = tulle_cloth_get_positions(world, id, &count);
    double most = 0.0;
    for (size_t i = 0; i < 3 * count; i++) most = fmax(most, fabs(now[i] - last[i]) / STEP);
    memcpy(last, now, 3 * count * sizeof(double));
    return most;
}

static void a_patch_on_cloth_that_moves_stays_awake(void **unused) {
    (void)unused;
    double targets[3 * SIDE], moved[3 * SIDE], last[3 * 25] = {0.0}, quickest = 0.0;
    tulle_world *const world = make_layers(targets);
    for (int k = 0; k < STEPS; k++) {
        memcpy(moved, targets, sizeof moved);
        for (int i = 2; i < 3 * SIDE; i += 3) moved[i] += 0.002 * (1.0 - cos(4.0 * STEP * k));
        FINE(tulle_cloth_set_pin_targets(world, LOWER, 0, moved, SIDE, &error));
        FINE(tulle_world_step(world, STEP, NULL, &error));
        double const speed = measure_speed(world, UPPER, last);
        if (k < SETTLED) continue;
        quickest = fmax(quickest, speed);
        assert_false(tulle_cloth_is_asleep(world, LOWER));
        assert_false(tulle_cloth_is_asleep(world, UPPER));
    }
    print_message("the patch moves by %g m/s at most\n", quickest);
    assert_true(quickest < 1e-3); /* so that it would sleep by itself */
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_patch_on_cloth_that_moves_stays_awake),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
