/* A world in which everything sleeps or stands passes its steps at once; not before what has just
 * stopped is known to stand. */
#include "support/small_world.h"
#include "support/test_support.h"

#include "tulle/live.h"

#include <math.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static const double MOVES_UNTIL = 1.0; /* [s] */
static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

static double measure_speed(const tulle_world *world, tulle_obstacle_id id) {
    size_t count = 0;
    const double *const v = tulle_obstacle_get_velocities(world, id, &count);
    double most = 0.0;
    for (size_t k = 0; k < 3 * count; k++) most = fmax(most, fabs(v[k]));
    return most;
}

/* A sheet floats and sleeps; far from it a ball goes along x for a second, and then stands. */
static void what_has_stopped_has_no_speed(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.gravity[2] = 0.0;
    def.sleep_speed = 0.01;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_mesh sheet = small_sheet(0.2, 5, 0.0);
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.1;
    tulle_mesh ball = small_shape(shape, 0.0, 5.0, 0.0);
    tulle_keyframe const keys[2] = {{0.0, {0, 0, 0}, {0, 0, 0}},
                                    {MOVES_UNTIL, {0.5, 0, 0}, {0, 0, 0}}};
    tulle_obstacle_def moving = tulle_obstacle_def_default();
    moving.mesh = tulle_mesh_get_view(&ball);
    moving.motion.keys = keys;
    moving.motion.key_count = 2;
    tulle_obstacle_id id;
    FINE(tulle_world_add_obstacle(world, &moving, &id, &error));
    for (int i = 1; i <= 70; i++) {
        double const begin = tulle_world_get_time(world);
        FINE(tulle_world_step(world, STEP, NULL, &error));
        double const speed = begin < MOVES_UNTIL ? 0.5 / MOVES_UNTIL : 0.0;
        if (!(fabs(measure_speed(world, id) - speed) < 1e-9))
            fail_msg("%g s: the ball goes %g m/s, not %g", begin, measure_speed(world, id), speed);
    }
    assert_true(tulle_cloth_is_asleep(world, cloth));
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_has_stopped_has_no_speed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
