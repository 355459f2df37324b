/* The time of a search goes to its stages, and stages that do not run take none. */
#include "support/paper_options.h"
#include "support/small_world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

/* Seconds of the stage of this name after a step of two sheets, one of which falls on the other. */
static double measure_stage(tulle_detect_method method, const char *name) {
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->detection.method = method;
    def.threads = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    for (int i = 0; i < 2; i++) {
        tulle_mesh sheet = small_sheet(0.5, 40, 0.02 * i);
        small_add_cloth(world, &sheet);
        tulle_mesh_destroy(&sheet);
    }
    tulle_step_report report;
    assert_int_equal(tulle_world_step(world, 1.0 / 90.0, &report, NULL), TULLE_OK);
    tulle_world_destroy(world);
    for (int k = 0; k < TULLE_STAGE_COUNT; k++)
        if (strcmp(tulle_stage_name(k), name) == 0) return report.stage_seconds[k];
    fail_msg("there is no stage %s", name);
    return 0.0;
}

static void each_stage_has_its_own_time(void **state) {
    (void)state;
    static const char *const names[] = {"build_trees", "find_pairs"};
    for (int i = 0; i < 2; i++) {
        assert_true(measure_stage(TULLE_DETECT_PATCHES, names[i]) > 0.0);
        assert_true(measure_stage(TULLE_DETECT_REFIT, names[i]) > 0.0);
    }
    assert_true(measure_stage(TULLE_DETECT_PATCHES, "update_patches") > 0.0);
    assert_true(measure_stage(TULLE_DETECT_REFIT, "update_patches") == 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_stage_has_its_own_time)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
