/* Laws of pairs of contact materials through the public interface: which law a pair of surfaces
 * has, and that cloth slides on cloth by it. */
#include "support/failing_heap.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "world/world_state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define GRAVITY 9.81
#define DEGREE 0.017453292519943295
static const double STEP = 1.0 / 90.0; /* [s] */
static const tulle_contact_law SLIPPERY = {0.1, 0.05, 0.2}, ROUGH = {0.9, -1.0, 0.0},
                               SPECIAL = {0.35, 0.3, 0.7};

static tulle_world *make_world(void) {
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

static tulle_cloth_id add_cloth(tulle_world *world, const char *material, double height) {
    tulle_mesh mesh = small_sheet(0.3, 4, height);
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_cloth_id id = {0};
    def.mesh = tulle_mesh_get_view(&mesh);
    def.contact_material = material;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, NULL), TULLE_OK);
    tulle_mesh_destroy(&mesh);
    return id;
}

static tulle_obstacle_id add_obstacle(tulle_world *world, const char *material, double height,
                                      int is_dynamic) {
    tulle_shape_def const shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    tulle_mesh mesh = small_shape(shape, 0.0, 0.0, height);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    tulle_obstacle_id id = {0};
    def.mesh = tulle_mesh_get_view(&mesh);
    def.contact_material = material;
    def.body.is_dynamic = is_dynamic;
    def.body.mass = is_dynamic;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    tulle_mesh_destroy(&mesh);
    return id;
}

static void set(tulle_world *world, const char *a, const char *b, const tulle_contact_law *law) {
    tulle_error error = {0};
    if (tulle_world_set_material_law(world, a, b, law, &error) != TULLE_OK)
        fail_msg("%s", error.message);
}

/* The law of two surfaces in force, in both orders. */
static void expect(const tulle_world *world, size_t a, size_t b, const double expected[3]) {
    size_t const count = world->work.set.surface_count;
    for (int i = 0; i < 2; i++) {
        const contact_law *const law = &world->model.laws[i == 0 ? a * count + b : b * count + a];
        if (law->static_friction != expected[0] || law->dynamic_friction != expected[1] ||
            law->restitution != expected[2])
            fail_msg("%zu and %zu: %g, %g, %g", a, b, law->static_friction, law->dynamic_friction,
                     law->restitution);
    }
}

/* Surfaces: 0 silk, 1 silk, 2 felt, 3 cloth without a name; 4 wood, 5 wood that is a body, 6
 * without a name. */
static void objects_go_before_materials_and_these_before_defaults(void **state) {
    (void)state;
    tulle_world *const world = make_world();
    tulle_cloth_id cloths[4];
    tulle_obstacle_id obstacles[3];
    const char *const names[] = {"silk", "silk", "felt", NULL};
    for (int i = 0; i < 4; i++) cloths[i] = add_cloth(world, names[i], 10.0 + i);
    for (int i = 0; i < 3; i++)
        obstacles[i] = add_obstacle(world, i < 2 ? "wood" : NULL, 20.0 + 5.0 * i, i == 1);
    set(world, "silk", "silk", &SLIPPERY);
    set(world, "wood", "silk", &SLIPPERY);
    set(world, "silk", "wood", &ROUGH); /* takes the place of the one before */
    set(world, "wood", "wood", &SLIPPERY);
    assert_int_equal(
        tulle_world_set_cloth_obstacle_law(world, cloths[1], obstacles[1], &SPECIAL, NULL),
        TULLE_OK);
    assert_int_equal(tulle_world_set_cloth_cloth_law(world, cloths[0], cloths[2], &SPECIAL, NULL),
                     TULLE_OK);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    double const slippery[] = {0.1, 0.05, 0.2}, rough[] = {0.9, 0.9, 0.0},
                 special[] = {0.35, 0.3, 0.7}, cloth[] = {0.3, 0.3, 0.0},
                 mean[] = {sqrt(0.4 * 0.3), sqrt(0.4 * 0.3), 0.0};
    expect(world, 0, 0, slippery); /* folds of one cloth */
    expect(world, 0, 1, slippery);
    expect(world, 0, 2, special);
    expect(world, 1, 2, cloth);
    expect(world, 2, 2, cloth);
    expect(world, 0, 3, cloth);
    expect(world, 0, 4, rough);
    expect(world, 1, 4, rough);
    expect(world, 1, 5, special);
    expect(world, 0, 6, mean);
    expect(world, 2, 4, mean);
    expect(world, 3, 5, mean);
    expect(world, 4, 5, slippery);
    double const bodies[] = {0.3, 0.3, 0.0};
    expect(world, 5, 6, bodies);
    assert_int_equal(tulle_world_set_material_law(world, "silk", "silk", &ROUGH, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT); /* it has started */
    tulle_world_destroy(world);
}

/* Names are of objects and presets only; messages tell which there are. */
static void unknown_names_are_refused(void **state) {
    (void)state;
    tulle_world *const world = make_world();
    add_obstacle(world, "oak", 0.0, 0);
    tulle_error error = {0};
    assert_int_equal(tulle_world_set_material_law(world, "silk", "wood", &ROUGH, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "'wood' is the contact material of no cloth or obstacle "
                                          "and no preset; there are oak, cotton, silk, "));
    const char *preset;
    for (size_t i = 0; (preset = tulle_material_preset_name(i)); i++)
        assert_non_null(strstr(error.message, preset));
    set(world, "silk", "oak", &ROUGH); /* a preset that nothing is made of */
    const char *const wrong[][2] = {{NULL, "silk"}, {"silk", NULL}, {"", "silk"}, {"Silk", "oak"}};
    for (int i = 0; i < 4; i++)
        assert_int_equal(
            tulle_world_set_material_law(world, wrong[i][0], wrong[i][1], &ROUGH, &error),
            TULLE_ERROR_INVALID_ARGUMENT);
    tulle_contact_law const bad[] = {{-0.1, -1.0, 0.0}, {0.3, 0.4, 0.0}, {0.3, 0.3, 1.5}};
    for (int i = 0; i < 3; i++)
        assert_int_equal(tulle_world_set_material_law(world, "silk", "oak", &bad[i], &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_material_law(world, "silk", "oak", NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_set_material_law(NULL, "silk", "oak", &ROUGH, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    char name[90];
    memset(name, 'x', sizeof name);
    tulle_mesh mesh = small_sheet(0.3, 4, 0.0);
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_cloth_id id;
    def.mesh = tulle_mesh_get_view(&mesh);
    def.contact_material = name;
    for (size_t length = 79; length < 82; length++) {
        name[length] = '\0';
        int const is_good = tulle_world_add_cloth(world, &def, &id, &error) == TULLE_OK;
        assert_int_equal(is_good, length == 79);
        name[length] = 'x';
    }
    name[0] = '\0';
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "contact material has 0 bytes"));
    tulle_mesh_destroy(&mesh);
    tulle_world_destroy(world);
}

/* The call fails or not with its first allocations; then it can be made again. */
static void a_failed_allocation_leaves_the_world_as_it_was(void **state) {
    (void)state;
    int failures = 0;
    for (int allowed = 0; allowed < 3; allowed++) {
        int left = 1000;
        tulle_world_def def = tulle_world_def_default();
        tulle_world *world = NULL;
        def.allocator = (tulle_allocator){failing_heap_allocate, failing_heap_release, &left, 0};
        assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
        add_cloth(world, "felt", 0.0);
        left = allowed;
        tulle_status const status =
            tulle_world_set_material_law(world, "denim", "felt", &SLIPPERY, NULL);
        failures += status == TULLE_ERROR_OUT_OF_MEMORY;
        assert_int_equal(world->rules.material_laws.count, status == TULLE_OK);
        left = 1000;
        set(world, "felt", "felt", &ROUGH);
        assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
        expect(world, 0, 0, (double[3]){0.9, 0.9, 0.0});
        tulle_world_destroy(world);
    }
    assert_in_range(failures, 1, 2);
}

/* [m/s^2] Mean of a patch on a cloth that is pinned all over, down a slope. */
static double slide_on_cloth(double degrees, const char *upper, const char *lower) {
    tulle_world_def world_def = tulle_world_def_default();
    tulle_world *world = NULL;
    world_def.contact_distance = 3e-3;
    world_def.gravity[0] = GRAVITY * sin(degrees * DEGREE);
    world_def.gravity[2] = -GRAVITY * cos(degrees * DEGREE);
    assert_int_equal(tulle_world_create(&world_def, &world, NULL), TULLE_OK);
    tulle_mesh patch = small_sheet(0.3, 11, 3e-3), bed = small_sheet(1.5, 14, 0.0);
    uint32_t all[196];
    for (uint32_t v = 0; v < 196; v++) all[v] = v;
    tulle_pin const pin = make_pin(all, 196, (double)INFINITY);
    tulle_cloth_def def = tulle_cloth_def_default();
    tulle_cloth_id id;
    def.mesh = tulle_mesh_get_view(&patch);
    def.material.air_damping = 0.0;
    def.contact_material = upper;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, NULL), TULLE_OK);
    def.mesh = tulle_mesh_get_view(&bed);
    def.contact_material = lower;
    def.pins = &pin;
    def.pin_count = 1;
    tulle_cloth_id unused;
    assert_int_equal(tulle_world_add_cloth(world, &def, &unused, NULL), TULLE_OK);
    set(world, "silk", "silk", &(tulle_contact_law){0.2, 0.2, 0.0});
    set(world, "rubber-sheet", "silk", &(tulle_contact_law){0.5, 0.4, 0.0});
    double speed[2] = {0.0, 0.0};
    int const steps = 45;
    for (int i = 0; i < steps; i++) {
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        size_t count;
        const double *const velocities = tulle_cloth_get_velocities(world, id, &count);
        double mean = 0.0;
        for (size_t v = 0; v < count; v++) mean += velocities[3 * v] / (double)count;
        if (i == steps - 31) speed[0] = mean;
        speed[1] = mean;
    }
    print_message("%s on %s, %g degrees: %.6g m/s^2\n", upper, lower, degrees,
                  (speed[1] - speed[0]) / (30 * STEP));
    tulle_mesh_destroy(&patch);
    tulle_mesh_destroy(&bed);
    tulle_world_destroy(world);
    return (speed[1] - speed[0]) / (30 * STEP);
}

static double slide(double degrees, double friction) {
    return GRAVITY * (sin(degrees * DEGREE) - friction * cos(degrees * DEGREE));
}

/* Critical angles: atan 0.2 = 11.3, atan 0.5 = 26.6, by default atan 0.3 = 16.7 degrees. */
static void cloth_slides_on_cloth_by_their_materials(void **state) {
    (void)state;
    assert_true(fabs(slide_on_cloth(14.0, "silk", "silk") / slide(14.0, 0.2) - 1.0) < 0.01);
    assert_true(fabs(slide_on_cloth(26.0, "silk", "rubber-sheet")) < 1e-5);
    assert_true(fabs(slide_on_cloth(26.0, "rubber-sheet", "silk")) < 1e-5);
    assert_true(fabs(slide_on_cloth(28.0, "silk", "rubber-sheet") / slide(28.0, 0.4) - 1.0) < 0.01);
    assert_true(
        fabs(slide_on_cloth(26.0, "rubber-sheet", "rubber-sheet") / slide(26.0, 0.3) - 1.0) < 0.01);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(objects_go_before_materials_and_these_before_defaults),
        cmocka_unit_test(unknown_names_are_refused),
        cmocka_unit_test(a_failed_allocation_leaves_the_world_as_it_was),
        cmocka_unit_test(cloth_slides_on_cloth_by_their_materials),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
