/* For all distances that a world allows, patches are certified so widely that no pair within one
 * could be a row of stage 5 or a hit of stages 8 and 9, the tolerance of a hit included. */
#include "support/small_world.h"
#include "world/world_state.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* A test calls a pair a hit up to a twentieth of its separation above it. */
static const double HIT = 1.05;

static void check_reaches(double contact, double separation, double gap) {
    tulle_mesh sheet = small_sheet(1.0, 12, 0.0);
    tulle_world_def def = tulle_world_def_default();
    def.contact_distance = contact;
    def.separation_distance = separation;
    def.minimum_gap = gap;
    tulle_world *world = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_world_create(&def, &world, &error), TULLE_OK);
    small_add_cloth(world, &sheet);
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    tulle_world_get_distances(world, &contact, &separation, &gap);
    double const reach = world->work.patch_rules.reach, hold = world->work.hold_reach;
    assert_true(gap > 0.0 && contact > 0.0 && separation >= contact);
    assert_true(2.0 * reach > separation);
    assert_true(2.0 * reach > HIT * contact);
    assert_true(2.0 * hold > HIT * gap);
    assert_true(hold <= reach && hold >= 0.25 * reach);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

static void reaches_exceed_all_hits(void **state) {
    (void)state;
    static const double contacts[] = {1e-3, 6e-3, 0.05};
    static const double separations[] = {0.0, 1.0, 1.02, 1.5, 3.0}; /* over contact; 0: derived */
    static const double gaps[] = {0.0, 0.001, 0.1, 0.23, 0.25, 0.3, 0.4, 0.5};
    for (size_t i = 0; i < sizeof contacts / sizeof *contacts; i++)
        for (size_t j = 0; j < sizeof separations / sizeof *separations; j++)
            for (size_t k = 0; k < sizeof gaps / sizeof *gaps; k++)
                check_reaches(contacts[i], separations[j] * contacts[i], gaps[k] * contacts[i]);
    check_reaches(0.0, 0.0, 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(reaches_exceed_all_hits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
