/* Recordings of several obstacles whose frames the host reads: each gets its own ones again. */
#include "tulle/record.h"

#include "support/body_world.h"
#include "support/recording.h"
#include "support/test_support.h"

enum { STEPS = 6, SIGNS = 2 };
static const double STEP = 1.0 / 60.0; /* [s] */

static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

/* A sign that moves to its own side. */
typedef struct sign {
    const tulle_mesh *mesh;
    double speed; /* [m] a frame */
} sign;

static tulle_status read_sign(void *context, uint32_t frame, double *positions,
                              tulle_error *fault) {
    (void)fault;
    const sign *const self = context;
    for (size_t i = 0; i < 3 * self->mesh->vertex_count; i++)
        positions[i] = self->mesh->positions[i] + (i % 3 == 0 ? self->speed * frame : 0.0);
    return TULLE_OK;
}

static void each_obstacle_gets_its_own_frames(void **unused) {
    (void)unused;
    tulle_world_def const world_def = tulle_world_def_default();
    tulle_world *world = NULL;
    FINE(tulle_world_create(&world_def, &world, &error));
    recording bytes;
    tulle_record_writer const writer = recording_begin(&bytes);
    FINE(tulle_world_record(world, &writer, &error));
    tulle_mesh sheet = small_sheet(0.3, 6, 0.3);
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.0, 0.0, 0.0});
    small_add_cloth(world, &sheet);
    sign signs[SIGNS] = {{&box, 0.01}, {&box, -0.02}};
    for (int i = 0; i < SIGNS; i++) {
        tulle_obstacle_def def = tulle_obstacle_def_default();
        def.mesh = tulle_mesh_get_view(&box);
        def.read_frame = read_sign;
        def.frame_context = &signs[i];
        def.frame_count = STEPS;
        def.frame_interval = STEP;
        FINE(tulle_world_add_obstacle(world, &def, NULL, &error));
    }
    for (int k = 0; k < STEPS; k++) FINE(tulle_world_step(world, STEP, NULL, &error));
    FINE(tulle_world_record(world, NULL, &error));
    tulle_replay_report report;
    FINE(tulle_replay(bytes.bytes, bytes.byte_count, NULL, &report, &error));
    if (report.is_different) fail_msg("step %d: %s", (int)report.steps, report.message);
    assert_true(report.is_whole);
    assert_int_equal(report.steps, STEPS);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
    free(bytes.bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_obstacle_gets_its_own_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
