/* Materials, thickness and pins that the host changes while the world runs, against worlds that
 * have them from the start, and through saved states. */
#include "tulle/live.h"
#include "tulle/paper.h"

#include "base/hash.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static const tulle_cloth_id CLOTH = {0, 1};
enum { SIDE = 9 };

static void expect(tulle_status wanted, tulle_status status, const tulle_error *error) {
    if (status != wanted)
        fail_msg("status %d, not %d: %s", (int)status, (int)wanted, error->message);
}

static void step(tulle_world *world, int count) {
    tulle_error error = {0};
    for (int i = 0; i < count; i++)
        expect(TULLE_OK, tulle_world_step(world, STEP, NULL, &error), &error);
}

static tulle_material get_material(const char *name) {
    tulle_material material;
    assert_int_equal(tulle_material_preset(name, &material), TULLE_OK);
    return material;
}

static void set_material(tulle_world *world, const char *name) {
    tulle_material const material = get_material(name);
    tulle_error error = {0};
    expect(TULLE_OK, tulle_cloth_set_material(world, CLOTH, &material, &error), &error);
}

/* A sheet over a ball, on a pin of two rows that lets go when it is told to. */
static tulle_world *make_world(const char *material, double release_time, int threads) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = threads;
    tulle_world *world;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    tulle_mesh sheet = small_sheet(0.4, SIDE, 0.16);
    uint32_t rows[2 * SIDE];
    for (uint32_t i = 0; i < 2 * SIDE; i++) rows[i] = i;
    tulle_pin const pin = make_pin(rows, 2 * SIDE, release_time);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    tulle_material const cotton = cloth.material;
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material = get_material(material);
    /* contact has the friction of one material in all of them */
    cloth.material.friction = cotton.friction;
    cloth.material.dynamic_friction = cotton.dynamic_friction;
    cloth.pins = &pin;
    cloth.pin_count = 1;
    expect(TULLE_OK, tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.15;
    shape.resolution[0] = 6;
    tulle_mesh ball = small_shape(shape, 0.0, 0.0, 0.0);
    small_add_obstacle(world, &ball);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    expect(TULLE_OK, tulle_world_start(world, &error), &error);
    return world;
}

static void assert_same_positions(const tulle_world *a, const tulle_world *b) {
    size_t count;
    const double *const x = tulle_cloth_get_positions(a, CLOTH, &count);
    const double *const y = tulle_cloth_get_positions(b, CLOTH, &count);
    assert_memory_equal(x, y, 3 * count * sizeof *x);
}

/* What was told before the first step is as what was told before the start. */
static void told_late_is_told_early(void **state) {
    (void)state;
    for (int threads = 1; threads < 3; threads++) {
        tulle_world *const early = make_world("denim", 0.0, threads);
        tulle_world *const late = make_world("cotton", (double)INFINITY, threads);
        set_material(late, "denim");
        tulle_error error = {0};
        expect(TULLE_OK, tulle_cloth_release_pin(late, CLOTH, 0, &error), &error);
        for (int i = 0; i < 6; i++) {
            step(early, 8);
            step(late, 8);
            assert_same_positions(early, late);
        }
        assert_true(tulle_cloth_get_fineness(early, CLOTH).bending_length ==
                    tulle_cloth_get_fineness(late, CLOTH).bending_length);
        tulle_world_destroy(early);
        tulle_world_destroy(late);
    }
}

/* What is changed hangs otherwise; what is set back leaves nothing behind. */
static void changes_act_and_are_undone(void **state) {
    (void)state;
    tulle_world *const world = make_world("silk", (double)INFINITY, 1);
    tulle_world *const plain = make_world("silk", (double)INFINITY, 1);
    step(world, 8);
    step(plain, 8);
    uint64_t const before = tulle_world_get_state_hash(world);
    set_material(world, "denim");
    assert_true(tulle_world_get_state_hash(world) != before);
    set_material(world, "silk");
    assert_true(tulle_world_get_state_hash(world) == before);
    step(world, 4);
    step(plain, 4);
    assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(plain));
    set_material(world, "denim");
    step(world, 96);
    step(plain, 96);
    size_t count;
    const double *const stiff = tulle_cloth_get_positions(world, CLOTH, &count);
    const double *const soft = tulle_cloth_get_positions(plain, CLOTH, &count);
    double farthest = 0.0;
    for (size_t k = 0; k < 3 * count; k++) farthest = fmax(farthest, fabs(stiff[k] - soft[k]));
    assert_true(farthest > 0.005);
    tulle_world_destroy(world);
    tulle_world_destroy(plain);
}

/* Loaded into the same world, which has gone another way, and into a fresh one. */
static void states_hold_changes(void **state) {
    (void)state;
    tulle_world *worlds[2];
    for (int i = 0; i < 2; i++) worlds[i] = make_world("cotton", (double)INFINITY, 1);
    tulle_error error = {0};
    step(worlds[0], 4);
    set_material(worlds[0], "denim");
    step(worlds[0], 4);
    expect(TULLE_OK, tulle_cloth_release_pin(worlds[0], CLOTH, 0, &error), &error);
    double const thickness = 0.5 * worlds[0]->model.contact_distance;
    expect(TULLE_OK, tulle_cloth_set_thickness(worlds[0], CLOTH, thickness, &error), &error);
    step(worlds[0], 4);
    void *bytes;
    size_t size;
    expect(TULLE_OK, tulle_world_save_state(worlds[0], &bytes, &size, &error), &error);
    step(worlds[0], 24);
    uint64_t const later = tulle_world_get_state_hash(worlds[0]);
    set_material(worlds[0], "cotton");
    step(worlds[0], 3);
    for (int i = 0; i < 2; i++) {
        expect(TULLE_OK, tulle_world_load_state(worlds[i], bytes, size, &error), &error);
        step(worlds[i], 24);
        assert_true(tulle_world_get_state_hash(worlds[i]) == later);
    }
    assert_same_positions(worlds[0], worlds[1]);

    /* bytes that no world has */
    unsigned char *const saved = bytes;
    enum { HASH_AT = 8, HASHED_FROM = 16 };
    size_t const settings_at = size - sizeof(world_settings);
    size_t const release_at = settings_at - sizeof(double);
    size_t const material_at = release_at - sizeof(tulle_material);
    size_t const law_at = material_at - 4 * sizeof(contact_law);
    double const bad = -1.0, wide = 1.0, nan = (double)NAN;
    double const sliding = 30.0; /* hysteresis */
    uint64_t const parts = 8;
    struct {
        size_t at;
        const void *value;
    } const cases[] = {{material_at + offsetof(tulle_material, area_density), &bad},
                       {material_at + offsetof(tulle_material, shear_hysteresis), &sliding},
                       {release_at, &nan},
                       {law_at + offsetof(contact_law, contact_distance), &wide},
                       {law_at + offsetof(contact_law, separation_distance), &bad},
                       {settings_at + offsetof(world_settings, parts), &parts}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned char old[8];
        memcpy(old, saved + cases[i].at, sizeof old);
        memcpy(saved + cases[i].at, cases[i].value, sizeof old);
        uint64_t hash = hash_block(saved + HASHED_FROM, size - HASHED_FROM);
        memcpy(saved + HASH_AT, &hash, sizeof hash);
        uint64_t const before = tulle_world_get_state_hash(worlds[1]);
        if (tulle_world_load_state(worlds[1], saved, size, &error) != TULLE_ERROR_PARSE)
            fail_msg("case %zu was loaded", i);
        assert_true(tulle_world_get_state_hash(worlds[1]) == before);
        memcpy(saved + cases[i].at, old, sizeof old);
    }
    tulle_world_free_state(worlds[0], bytes, size);
    for (int i = 0; i < 2; i++) tulle_world_destroy(worlds[i]);
}

/* A sheet lies as far from the ground as it is thick; where it is pushed out, a little less: what
 * pushes gives under the weight. */
static void thickness_keeps_its_distance(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    tulle_mesh sheet = small_sheet(0.4, SIDE, 0.007);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.thickness = 0.006;
    expect(TULLE_OK, tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    tulle_mesh ground = small_shape(tulle_shape_def_default(TULLE_SHAPE_PLANE), 0.0, 0.0, 0.0);
    small_add_obstacle(world, &ground);
    static const double thicknesses[] = {0.006, 0.002, 0.005};
    step(world, 64);
    for (size_t i = 0; i < 3; i++) {
        expect(TULLE_OK, tulle_cloth_set_thickness(world, CLOTH, thicknesses[i], &error), &error);
        step(world, 192);
        size_t count;
        const double *const x = tulle_cloth_get_positions(world, CLOTH, &count);
        for (size_t v = 0; v < count; v++)
            if (!(fabs(x[3 * v + 2] - thicknesses[i]) < (i < 2 ? 1e-5 : 2e-4)))
                fail_msg("height %g m, not %g", x[3 * v + 2], thicknesses[i]);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ground);
}

/* Two cloths over the ground, one of this thickness. */
static tulle_world *make_layers(double thickness, double separation) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.separation_distance = separation;
    tulle_world *world;
    tulle_error error = {0};
    expect(TULLE_OK, tulle_world_create(&def, &world, &error), &error);
    for (int i = 0; i < 2; i++) {
        tulle_mesh sheet = small_sheet(0.4, SIDE, 0.02 + 0.02 * i);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.thickness = i == 0 ? thickness : 0.007;
        expect(TULLE_OK, tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
        tulle_mesh_destroy(&sheet);
    }
    tulle_mesh ground = small_shape(tulle_shape_def_default(TULLE_SHAPE_PLANE), 0.0, 0.0, 0.0);
    small_add_obstacle(world, &ground);
    tulle_mesh_destroy(&ground);
    expect(TULLE_OK, tulle_world_start(world, &error), &error);
    return world;
}

/* Laws are those of a world that has the thickness from the start, to the bit, and those of the
 * start again once it is set back; also where the separation distance is given. */
static void thickness_makes_the_laws_of_the_start(void **state) {
    (void)state;
    static const double separations[] = {0.0, 0.009};
    for (int i = 0; i < 2; i++) {
        tulle_world *const world = make_layers(0.0061, separations[i]);
        tulle_world *const thin = make_layers(0.0023, separations[i]);
        uint64_t const before = tulle_world_get_state_hash(world);
        size_t const size = world->work.set.surface_count * world->work.set.surface_count *
                            sizeof *world->model.laws;
        tulle_error error = {0};
        expect(TULLE_OK, tulle_cloth_set_thickness(world, CLOTH, 0.0023, &error), &error);
        assert_memory_equal(world->model.laws, thin->model.laws, size);
        expect(TULLE_OK, tulle_cloth_set_thickness(world, CLOTH, 0.007, &error), &error);
        expect(TULLE_OK, tulle_cloth_set_thickness(world, CLOTH, 0.0061, &error), &error);
        assert_true(tulle_world_get_state_hash(world) == before);
        tulle_world_destroy(world);
        tulle_world_destroy(thin);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(told_late_is_told_early),
        cmocka_unit_test(changes_act_and_are_undone),
        cmocka_unit_test(states_hold_changes),
        cmocka_unit_test(thickness_keeps_its_distance),
        cmocka_unit_test(thickness_makes_the_laws_of_the_start),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
