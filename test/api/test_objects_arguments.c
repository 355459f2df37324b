/* Arguments of the public functions of tulle/objects.h, against a world that has started and one
 * that has not: null, ids of nothing, of other worlds, and of what was removed before. */
#include "api/arguments.h"
#include "support/object_world.h"

static tulle_world *started, *fresh;
static tulle_object_id cloths[2], obstacles[2]; /* the second of each was removed */

static tulle_world *make_world(void) {
    tulle_world *const world = things_make_world(NULL);
    cloths[0] = things_add(world, THING_SHEET, 0.0);
    cloths[1] = things_add(world, THING_PINNED, 0.0);
    obstacles[0] = things_add(world, THING_GROUND, 0.0);
    obstacles[1] = things_add(world, THING_KEYS, 0.0);
    return world;
}

static int set_up(void **unused) {
    (void)unused;
    started = make_world();
    things_start(started);
    things_step(started, 1);
    fresh = make_world();
    tulle_world *const worlds[] = {started, fresh};
    for (int i = 0; i < 2; i++) {
        things_remove(worlds[i], cloths[1]);
        things_remove(worlds[i], obstacles[1]);
    }
    return 0;
}

/* What was refused has changed nothing. */
static int tear_down(void **unused) {
    (void)unused;
    tulle_world *const other = things_make_world(NULL);
    (void)things_add(other, THING_SHEET, 0.0);
    (void)things_add(other, THING_GROUND, 0.0);
    things_step(other, 1);
    things_step(fresh, 1);
    assert_true(tulle_world_get_state_hash(other) == tulle_world_get_state_hash(fresh));
    assert_true(tulle_world_get_counts(started).cloths == 1);
    assert_true(tulle_world_get_counts(started).obstacles == 1);
    tulle_world_destroy(started);
    tulle_world_destroy(fresh);
    tulle_world_destroy(other);
    return 0;
}

ARGUMENTS_OF(tulle_world_remove_cloth) {
    tulle_cloth_id const good = {cloths[0].index, cloths[0].generation};
    tulle_cloth_id const bad[] = {{0, 0},          {good.index, 2}, {good.index, UINT32_MAX},
                                  {1, 0},          {1, 1},          {1, 2},
                                  {UINT32_MAX, 1}, {2, 1},          {2, 0}};
    REFUSED(tulle_world_remove_cloth(NULL, good, &error));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        REFUSED(tulle_world_remove_cloth(started, bad[i], &error));
        REFUSED(tulle_world_remove_cloth(fresh, bad[i], &error));
        assert_int_equal(tulle_world_remove_cloth(started, bad[i], NULL),
                         TULLE_ERROR_INVALID_ARGUMENT);
    }
}

ARGUMENTS_OF(tulle_world_remove_obstacle) {
    tulle_obstacle_id const good = {obstacles[0].index, obstacles[0].generation};
    tulle_obstacle_id const bad[] = {{0, 0},          {good.index, 2}, {good.index, UINT32_MAX},
                                     {1, 0},          {1, 1},          {1, 2},
                                     {UINT32_MAX, 1}, {2, 1},          {2, 0}};
    REFUSED(tulle_world_remove_obstacle(NULL, good, &error));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        REFUSED(tulle_world_remove_obstacle(started, bad[i], &error));
        REFUSED(tulle_world_remove_obstacle(fresh, bad[i], &error));
        assert_int_equal(tulle_world_remove_obstacle(started, bad[i], NULL),
                         TULLE_ERROR_INVALID_ARGUMENT);
    }
}

/* Every call that takes an id refuses that of what was removed, with words. */
static void stale_ids_are_refused(void **unused) {
    (void)unused;
    tulle_cloth_id const cloth = {cloths[1].index, cloths[1].generation};
    tulle_cloth_id const sheet = {cloths[0].index, cloths[0].generation};
    tulle_obstacle_id const obstacle = {obstacles[1].index, obstacles[1].generation};
    tulle_contact_law const law = {0.1, -1.0, 0.0};
    tulle_material const material = tulle_cloth_def_default().material;
    double const numbers[9] = {0};
    double out[3], more[3];
    for (int i = 0; i < 2; i++) {
        tulle_world *const world = i == 0 ? started : fresh;
        tulle_transform transform;
        tulle_attachment_def def = tulle_attachment_def_default();
        tulle_attachment_id made;
        uint32_t labels[128];
        uint32_t const vertex = 0;
        size_t count;
        tulle_patch_options const options = {0};
        tulle_contact contact;
        tulle_target const target = {out, sizeof out, 0, TULLE_NUMBER_DOUBLE};
        assert_null(tulle_cloth_get_positions(world, cloth, &count));
        assert_null(tulle_cloth_get_velocities(world, cloth, &count));
        assert_null(tulle_obstacle_get_positions(world, obstacle, &count));
        assert_null(tulle_obstacle_get_velocities(world, obstacle, &count));
        assert_int_equal(tulle_obstacle_is_present(world, obstacle), 0);
        assert_int_equal(tulle_obstacle_is_asleep(world, obstacle), 0);
        assert_true(tulle_cloth_get_fineness(world, cloth).mean_edge == 0.0);
        assert_null(tulle_object_get_info(world, cloths[1]).name);
        assert_null(tulle_object_get_user_data(world, obstacles[1]));
        REFUSED(tulle_object_set_user_data(world, cloths[1], NULL, &error));
        REFUSED(tulle_object_set_filter(world, obstacles[1], 1, 1, &error));
        REFUSED(tulle_object_copy_contacts(world, cloths[1], &contact, 1, &count, &error));
        REFUSED(
            tulle_object_copy_values(world, obstacles[1], TULLE_VALUES_POSITIONS, &target, &error));
        REFUSED(tulle_world_set_cloth_cloth_law(world, sheet, cloth, &law, &error));
        REFUSED(tulle_world_set_cloth_obstacle_law(world, sheet, obstacle, &law, &error));
        REFUSED(tulle_world_set_obstacle_obstacle_law(world, obstacle, obstacle, &law, &error));
        REFUSED(tulle_cloth_set_material(world, cloth, &material, &error));
        REFUSED(tulle_cloth_set_thickness(world, cloth, 1e-3, &error));
        REFUSED(tulle_cloth_release_pin(world, cloth, 0, &error));
        REFUSED(tulle_cloth_set_pin_targets(world, cloth, 0, numbers, 2, &error));
        REFUSED(tulle_cloth_get_patches(world, cloth, &options, labels, &count, &error));
        REFUSED(tulle_obstacle_set_next_transform(world, obstacle, numbers, numbers,
                                                  TULLE_TRAVEL_MOVE, &error));
        REFUSED(tulle_obstacle_set_next_positions(world, obstacle, numbers, 1, TULLE_TRAVEL_MOVE,
                                                  &error));
        REFUSED(tulle_obstacle_get_transform(world, obstacle, &transform, &error));
        REFUSED(tulle_obstacle_add_impulse(world, obstacle, numbers, numbers, &error));
        REFUSED(tulle_obstacle_get_contact_impulse(world, obstacle, out, more, &error));
        REFUSED(tulle_obstacle_wake(world, obstacle, &error));
        REFUSED(tulle_obstacle_set_velocity(world, obstacle, numbers, NULL, &error));
        REFUSED(tulle_obstacle_add_force(world, obstacle, NULL, numbers, &error));
        REFUSED(tulle_obstacle_add_torque(world, obstacle, numbers, &error));
        REFUSED(tulle_obstacle_set_locks(world, obstacle, 0, 0, &error));
        REFUSED(tulle_obstacle_set_drive(world, obstacle, NULL, &error));
        REFUSED(tulle_obstacle_get_drive_force(world, obstacle, out, more, &error));
        def.vertices = &vertex;
        def.vertex_count = 1;
        def.cloth = cloth;
        def.points = numbers;
        REFUSED(tulle_world_attach(world, &def, &made, &error));
        def.cloth = sheet;
        def.points = NULL;
        def.obstacle = obstacle;
        REFUSED(tulle_world_attach(world, &def, &made, &error));
        def.obstacle = (tulle_obstacle_id){0, 0};
        def.other_cloth = cloth;
        REFUSED(tulle_world_attach(world, &def, &made, &error));
    }
}

int main(void) {
    const struct CMUnitTest last[] = {cmocka_unit_test(stale_ids_are_refused)};
    int const failed = run_arguments(HEADERS("tulle/objects.h"), set_up, NULL);
    return cmocka_run_group_tests(last, NULL, tear_down) + failed;
}
