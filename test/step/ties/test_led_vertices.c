/* What a rigid attachment leads, in steps that have many substeps: it goes evenly through all of
 * them. A body that spins far away cuts the steps. */
#include "tulle/attach.h"
#include "tulle/tulle.h"

#include "support/body_world.h"
#include "support/test_support.h"

#include <math.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static const double WAY = 0.0625;      /* [m] of the points in a step */

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

static tulle_error error;

/* A triangle without weight, held at points, and a box that spins with 200 rad/s. */
static tulle_world *make_world(tulle_cloth_id *cloth, tulle_attachment_id *held) {
    static const double corners[9] = {0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.1, 0.2, 0.0};
    static const uint32_t three[3] = {0, 1, 2};
    tulle_world_def def = tulle_world_def_default();
    def.gravity[2] = 0.0;
    def.threads = 1;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_cloth_def sheet = tulle_cloth_def_default();
    sheet.mesh = (tulle_mesh_view){corners, 3, three, 1};
    FINE(tulle_world_add_cloth(world, &sheet, cloth, &error));
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){5.0, 0.0, 0.0});
    tulle_obstacle_def spinning = tulle_obstacle_def_default();
    spinning.mesh = tulle_mesh_get_view(&box);
    spinning.body.is_dynamic = 1;
    spinning.body.density = 500.0;
    spinning.body.angular_velocity[2] = 200.0;
    FINE(tulle_world_add_obstacle(world, &spinning, NULL, &error));
    tulle_mesh_destroy(&box);
    FINE(tulle_world_start(world, &error));
    tulle_attachment_def tie = tulle_attachment_def_default();
    tie.cloth = *cloth;
    tie.vertices = three;
    tie.vertex_count = 3;
    tie.points = corners;
    FINE(tulle_world_attach(world, &tie, held, &error));
    return world;
}

/* At the end of a step its velocity is that of the whole step: way over time. Going there at once
 * and standing still then would leave none, and tear at the cloth beside it. */
static void goes_evenly_through_all_substeps(void **state) {
    (void)state;
    tulle_cloth_id cloth;
    tulle_attachment_id held;
    tulle_world *const world = make_world(&cloth, &held);
    double points[9];
    memcpy(points, tulle_cloth_get_positions(world, cloth, NULL), sizeof points);
    for (int i = 0; i < 5; i++) {
        for (int k = 0; k < 9; k += 3) points[k] += WAY;
        FINE(tulle_attachment_set_points(world, held, points, 3, &error));
        tulle_step_report report = {0};
        FINE(tulle_world_step(world, STEP, &report, &error));
        assert_true(report.substeps >= 4);
        const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
        const double *const v = tulle_cloth_get_velocities(world, cloth, NULL);
        for (int k = 0; k < 9; k++) {
            assert_true(fabs(x[k] - points[k]) < 1e-14);
            double const speed = k % 3 == 0 ? WAY / STEP : 0.0;
            if (!(fabs(v[k] - speed) < 1e-9)) fail_msg("speed %g m/s, not %g", v[k], speed);
        }
    }
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(goes_evenly_through_all_substeps)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
