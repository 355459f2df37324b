/* Contacts of cloth that is tied: the tie leaves out pairs with what holds the cloth, no others. */
#include "tulle/attach.h"
#include "tulle/tulle.h"

#include "support/body_world.h"
#include "support/test_support.h"

enum { SIDE = 9, STEPS = 20 };
static const double STEP = 1.0 / 64.0; /* [s] */

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

static tulle_error error;

/* A sheet lies on a table and is tied to a post beside it by one corner. */
static void what_it_lies_on_carries_it(void **state) {
    (void)state;
    tulle_world_def const world_def = tulle_world_def_default();
    tulle_world *world = NULL;
    FINE(tulle_world_create(&world_def, &world, &error));
    tulle_mesh sheet = small_sheet(0.4, SIDE, 0.005);
    tulle_mesh table = bodies_make_box(1.0, 1.0, 0.1, (double[]){0.0, 0.0, -0.05});
    tulle_mesh post = bodies_make_box(0.05, 0.05, 0.2, (double[]){-0.27, -0.27, 0.11});
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    small_add_obstacle(world, &table);
    tulle_obstacle_id const pole = small_add_obstacle(world, &post);
    FINE(tulle_world_start(world, &error));
    uint32_t const corner = 0;
    tulle_attachment_def tie = tulle_attachment_def_default();
    tulle_attachment_id id;
    tie.cloth = cloth;
    tie.vertices = &corner;
    tie.vertex_count = 1;
    tie.obstacle = pole;
    FINE(tulle_world_attach(world, &tie, &id, &error));
    tulle_step_report report = {0};
    for (int k = 0; k < STEPS; k++) {
        FINE(tulle_world_step(world, STEP, &report, &error));
        assert_int_equal(report.impact_rounds, 0);
    }
    assert_true(report.contacts >= SIDE * SIDE - 1);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&table);
    tulle_mesh_destroy(&post);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_it_lies_on_carries_it)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
