/* Arguments of the functions of tulle/world.h (numbers out of range: world/test_fields.c): against
 * a world that has started, and a new one. */
#include "api/arguments.h"
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"

static const double STEP = 1.0 / 60.0;
static tulle_mesh sheet, plate, box;
static tulle_world *started, *fresh;
static tulle_cloth_id cloth;
static tulle_obstacle_id obstacle, body;

static tulle_cloth_def make_cloth_def(void) {
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    return def;
}

static tulle_obstacle_def make_obstacle_def(void) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&plate);
    return def;
}

static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    cloth = small_add_cloth(world, &sheet);
    obstacle = small_add_obstacle(world, &plate);
    tulle_obstacle_def dynamic = make_obstacle_def();
    dynamic.mesh = tulle_mesh_get_view(&box);
    dynamic.body = (tulle_body){.is_dynamic = 1, .density = 300.0};
    FINE(tulle_world_add_obstacle(world, &dynamic, &body, &error));
    return world;
}

static int set_up(void **unused) {
    (void)unused;
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    sheet = small_sheet(0.3, 4, 0.1);
    plate = small_shape(shape, 0.0, 0.0, -0.6);
    shape.size[0] = shape.size[1] = shape.size[2] = 0.2;
    box = small_shape(shape, 2.0, 0.0, 0.0);
    started = make_world();
    fresh = make_world();
    FINE(tulle_world_step(started, STEP, NULL, &error));
    return 0;
}

/* Nothing that was refused has changed the worlds. */
static int tear_down(void **unused) {
    (void)unused;
    tulle_world *const other = make_world();
    FINE(tulle_world_step(fresh, STEP, NULL, &error));
    FINE(tulle_world_step(other, STEP, NULL, &error));
    assert_true(tulle_world_get_state_hash(fresh) == tulle_world_get_state_hash(other));
    assert_true(tulle_world_get_state_hash(started) == tulle_world_get_state_hash(other));
    tulle_world_destroy(started);
    tulle_world_destroy(fresh);
    tulle_world_destroy(other);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&plate);
    tulle_mesh_destroy(&box);
    return 0;
}

static const tulle_cloth_id bad_cloths[] = {{0, 0}, {0, 2}, {1, 1}, {UINT32_MAX, 1}};
static const tulle_obstacle_id bad_obstacles[] = {{0, 0}, {0, 2}, {2, 1}, {UINT32_MAX, 1}};

ARGUMENTS_OF(tulle_world_def_default) { assert_true(tulle_world_def_default().cookie != 0); }
ARGUMENTS_OF(tulle_cloth_def_default) { assert_true(tulle_cloth_def_default().cookie != 0); }
ARGUMENTS_OF(tulle_obstacle_def_default) { assert_true(tulle_obstacle_def_default().cookie != 0); }

ARGUMENTS_OF(tulle_pin_default) {
    assert_true(tulle_pin_default().cookie != 0 && tulle_pin_default().release_time > 0.0);
}

ARGUMENTS_OF(tulle_material_preset) {
    tulle_material material;
    assert_int_equal(tulle_material_preset(NULL, &material), TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_material_preset("cotton", NULL), TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_material_preset("", &material), TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_material_preset("iron", &material), TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_material_preset("cotton", &material), TULLE_OK);
}
ARGUMENTS_OF(tulle_material_preset_name) {
    assert_null(tulle_material_preset_name(1000));
    assert_null(tulle_material_preset_name(SIZE_MAX));
}
ARGUMENTS_OF(tulle_material_preset_source) {
    assert_null(tulle_material_preset_source(1000));
    assert_null(tulle_material_preset_source(SIZE_MAX));
}
ARGUMENTS_OF(tulle_material_preset_thickness) {
    assert_true(tulle_material_preset_thickness(0) > 0.0);
    assert_true(tulle_material_preset_thickness(1000) == 0.0);
    assert_true(tulle_material_preset_thickness(SIZE_MAX) == 0.0);
}
ARGUMENTS_OF(tulle_material_preset_measured) {
    assert_int_equal(tulle_material_preset_measured(1000), 0);
    assert_int_equal(tulle_material_preset_measured(SIZE_MAX), 0);
}

static void refuse_world_def(const tulle_world_def *def) {
    tulle_world *world = NULL;
    REFUSED(tulle_world_create(def, &world, &error));
    assert_null(world);
}

ARGUMENTS_OF(tulle_world_create) {
    tulle_world_def def = tulle_world_def_default();
    refuse_world_def(NULL);
    REFUSED(tulle_world_create(&def, NULL, &error));
    def = tulle_world_def_default();
    def.sleep_speed = 1e-3;
    change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    refuse_world_def(&def);
}

ARGUMENTS_OF(tulle_world_destroy) { tulle_world_destroy(NULL); }

static void refuse_cloth_def(const tulle_cloth_def *def) {
    REFUSED(tulle_world_add_cloth(fresh, def, NULL, &error));
    REFUSED(tulle_world_add_cloth(started, def, NULL, &error));
}

/* Directions of the warp, triangles at rest and creases; their numbers: world/test_fields.c. */
static void refuse_bad_rest(void) {
    tulle_cloth_def def = make_cloth_def();
    enum { TRIANGLES = 18 };
    assert_int_equal(def.mesh.triangle_count, TRIANGLES);
    double warps[3 * TRIANGLES], rest[9 * TRIANGLES];
    for (int i = 0; i < 3 * TRIANGLES; i++) warps[i] = i < 3 * TRIANGLES - 3;
    for (size_t t = 0; t < TRIANGLES; t++)
        memcpy(rest + 9 * t, (double[9]){0, 0, 0, 1, 0, 0, 0, t + 1 < TRIANGLES, 0},
               9 * sizeof(double));
    def.rest_corners = rest;
    refuse_cloth_def(&def);
    def.rest_corners = NULL;
    def.warps = warps;
    refuse_cloth_def(&def);
    def = make_cloth_def();
    def.crease_count = 1;
    refuse_cloth_def(&def);
    tulle_crease const crease = {{(uint32_t)def.mesh.vertex_count, 1}, 0.0};
    def.creases = &crease;
    refuse_cloth_def(&def);
}

ARGUMENTS_OF(tulle_world_add_cloth) {
    tulle_cloth_def def = make_cloth_def();
    tulle_cloth_id id;
    REFUSED(tulle_world_add_cloth(NULL, &def, &id, &error));
    refuse_cloth_def(NULL);
    def.mesh.positions = NULL;
    refuse_cloth_def(&def);
    def = make_cloth_def();
    def.mesh.triangles = NULL;
    refuse_cloth_def(&def);
    def = make_cloth_def();
    def.pin_count = 1;
    refuse_cloth_def(&def);
    uint32_t const vertices[2] = {0, UINT32_MAX};
    tulle_keyframe const nowhere = {0.0, {0, (double)NAN, 0}, {0, 0, 0}};
    tulle_motion const bad_motions[] = {
        {NULL, 1, {0, 0, 0}, 0}, {&nowhere, 1, {0, 0, 0}, 0}, {NULL, 0, {0, (double)NAN, 0}, 0}};
    tulle_pin bad_pins[] = {make_pin(NULL, 1, 1.0),
                            make_pin(vertices, 2, 1.0),
                            make_pin(vertices, 1, NAN),
                            make_pin(vertices, 1, 1.0),
                            make_pin(vertices, 1, 1.0),
                            make_pin(vertices, 1, 1.0),
                            {.vertices = vertices, .vertex_count = 1, .release_time = 1.0}};
    for (int i = 0; i < 3; i++) bad_pins[3 + i].motion = bad_motions[i];
    for (size_t i = 0; i < sizeof bad_pins / sizeof bad_pins[0]; i++) {
        def.pins = &bad_pins[i];
        refuse_cloth_def(&def);
    }
    refuse_bad_rest();
    def = make_cloth_def();
    def.material.shear.stiffness = 1e5; /* beyond that of the yarns */
    refuse_cloth_def(&def);
    def = make_cloth_def();
    def.contact_material = "";
    refuse_cloth_def(&def);
}

static void refuse_obstacle_def(const tulle_obstacle_def *def) {
    REFUSED(tulle_world_add_obstacle(fresh, def, NULL, &error));
    REFUSED(tulle_world_add_obstacle(started, def, NULL, &error));
}

static tulle_status read_nothing(void *context, uint32_t frame, double *positions,
                                 tulle_error *to) {
    (void)context, (void)frame, (void)positions, (void)to;
    return TULLE_OK;
}

ARGUMENTS_OF(tulle_world_add_obstacle) {
    tulle_obstacle_def def = make_obstacle_def();
    tulle_obstacle_id id;
    REFUSED(tulle_world_add_obstacle(NULL, &def, &id, &error));
    refuse_obstacle_def(NULL);
    def.mesh.positions = NULL;
    refuse_obstacle_def(&def);
    def = make_obstacle_def();
    def.mesh.triangles = NULL;
    refuse_obstacle_def(&def);
    def = make_obstacle_def();
    def.motion.key_count = 1;
    refuse_obstacle_def(&def);
    def = make_obstacle_def();
    def.read_frame = read_nothing; /* without frames */
    refuse_obstacle_def(&def);
}

/* A law of `fresh` that is good, and one that is not. */
static const tulle_contact_law good_law = {0.5, 0.4, 0.1};
static const tulle_contact_law bad_law = {(double)NAN, -1, 0};

ARGUMENTS_OF(tulle_world_set_cloth_cloth_law) {
    REFUSED(tulle_world_set_cloth_cloth_law(NULL, cloth, cloth, &good_law, &error));
    REFUSED(tulle_world_set_cloth_cloth_law(fresh, cloth, cloth, &good_law, &error));
    for (int i = 0; i < 4; i++) {
        REFUSED(tulle_world_set_cloth_cloth_law(fresh, cloth, bad_cloths[i], &good_law, &error));
        REFUSED(tulle_world_set_cloth_cloth_law(fresh, bad_cloths[i], cloth, NULL, &error));
    }
}

ARGUMENTS_OF(tulle_world_set_cloth_obstacle_law) {
    tulle_world *const w = fresh;
    REFUSED(tulle_world_set_cloth_obstacle_law(NULL, cloth, obstacle, &good_law, &error));
    REFUSED(tulle_world_set_cloth_obstacle_law(w, cloth, obstacle, NULL, &error));
    REFUSED(tulle_world_set_cloth_obstacle_law(started, cloth, obstacle, &bad_law, &error));
    for (int i = 0; i < 4; i++) {
        REFUSED(tulle_world_set_cloth_obstacle_law(w, bad_cloths[i], obstacle, &good_law, &error));
        REFUSED(tulle_world_set_cloth_obstacle_law(w, cloth, bad_obstacles[i], &good_law, &error));
    }
    REFUSED(tulle_world_set_cloth_obstacle_law(w, cloth, obstacle, &bad_law, &error));
}

ARGUMENTS_OF(tulle_world_set_obstacle_obstacle_law) {
    REFUSED(tulle_world_set_obstacle_obstacle_law(NULL, obstacle, body, &good_law, &error));
    REFUSED(tulle_world_set_obstacle_obstacle_law(fresh, obstacle, body, NULL, &error));
    REFUSED(tulle_world_set_obstacle_obstacle_law(fresh, body, body, &good_law, &error));
    for (int i = 0; i < 4; i++) {
        tulle_obstacle_id const bad = bad_obstacles[i];
        REFUSED(tulle_world_set_obstacle_obstacle_law(fresh, body, bad, &good_law, &error));
        REFUSED(tulle_world_set_obstacle_obstacle_law(fresh, bad, body, &good_law, &error));
    }
}

ARGUMENTS_OF(tulle_world_set_material_law) {
    REFUSED(tulle_world_set_material_law(NULL, "silk", "wool", &good_law, &error));
    REFUSED(tulle_world_set_material_law(fresh, NULL, "wool", &good_law, &error));
    REFUSED(tulle_world_set_material_law(fresh, "silk", NULL, &good_law, &error));
    REFUSED(tulle_world_set_material_law(fresh, "silk", "wool", NULL, &error));
    REFUSED(tulle_world_set_material_law(fresh, "silk", "", &good_law, &error));
    REFUSED(tulle_world_set_material_law(fresh, "silk", "wool", &bad_law, &error));
}

ARGUMENTS_OF(tulle_world_start) {
    REFUSED(tulle_world_start(NULL, &error));
    FINE(tulle_world_start(started, NULL));
}

ARGUMENTS_OF(tulle_world_set_stop_request) {
    tulle_world_set_stop_request(NULL, NULL, NULL);
    tulle_world_set_stop_request(started, NULL, &error);
}

ARGUMENTS_OF(tulle_world_get_intersections) {
    size_t count = 7;
    assert_null(tulle_world_get_intersections(NULL, &count));
    assert_int_equal(count, 0);
    assert_null(tulle_world_get_intersections(NULL, NULL));
    (void)tulle_world_get_intersections(started, NULL);
}

ARGUMENTS_OF(tulle_world_get_overlaps) {
    size_t count = 7;
    assert_null(tulle_world_get_overlaps(NULL, &count));
    assert_int_equal(count, 0);
    assert_null(tulle_world_get_overlaps(started, NULL));
}

ARGUMENTS_OF(tulle_world_get_untangle_report) {
    assert_int_equal(tulle_world_get_untangle_report(NULL).rounds, 0);
}

ARGUMENTS_OF(tulle_stage_name) {
    for (int i = 0; i < NO_CHOICE_COUNT; i++) assert_null(tulle_stage_name(no_choices[i]));
    assert_null(tulle_stage_name(TULLE_STAGE_COUNT));
}

ARGUMENTS_OF(tulle_world_step) {
    tulle_step_report report;
    REFUSED(tulle_world_step(NULL, STEP, &report, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++)
        REFUSED(tulle_world_step(started, no_numbers[i], &report, &error));
    double const steps[] = {0.0, -0.0, -STEP, 1.5};
    for (int i = 0; i < 4; i++) REFUSED(tulle_world_step(started, steps[i], NULL, &error));
    tulle_world *const other = make_world();
    assert_int_equal(tulle_world_step(other, STEP, NULL, NULL), TULLE_OK);
    tulle_world_destroy(other);
}

ARGUMENTS_OF(tulle_world_get_step_progress) {
    assert_int_equal(tulle_world_get_step_progress(NULL).is_under_way, 0);
}
ARGUMENTS_OF(tulle_world_get_time) { assert_true(tulle_world_get_time(NULL) == 0.0); }
ARGUMENTS_OF(tulle_world_get_step_count) { assert_int_equal(tulle_world_get_step_count(NULL), 0); }

ARGUMENTS_OF(tulle_world_get_distances) {
    double values[3] = {1, 1, 1};
    tulle_world_get_distances(NULL, NULL, NULL, NULL);
    tulle_world_get_distances(started, NULL, NULL, NULL);
    tulle_world_get_distances(NULL, &values[0], &values[1], &values[2]);
    for (int i = 0; i < 3; i++) assert_true(values[i] == 0.0);
}

ARGUMENTS_OF(tulle_paper_options_default) {
    tulle_paper_options options = tulle_paper_options_default();
    tulle_world_def def = tulle_world_def_default();
    tulle_world *made = NULL;
    def.paper = &options;
    FINE(tulle_world_create(&def, &made, &error));
    tulle_world_destroy(made);
    options = (tulle_paper_options){0};
    REFUSED(tulle_world_create(&def, &made, &error));
}

ARGUMENTS_OF(tulle_world_get_paper_options) {
    tulle_paper_options const options = tulle_world_get_paper_options(NULL);
    assert_true(options.cg_tolerance == tulle_paper_options_default().cg_tolerance);
    assert_int_equal(tulle_world_get_paper_options(started).impact_rounds, options.impact_rounds);
}

ARGUMENTS_OF(tulle_world_last_message) { assert_string_equal(tulle_world_last_message(NULL), ""); }

typedef const double *(*cloth_reader)(const tulle_world *, tulle_cloth_id, size_t *);
typedef const double *(*obstacle_reader)(const tulle_world *, tulle_obstacle_id, size_t *);

static void check_cloth_reader(cloth_reader get) {
    size_t count = 7;
    assert_null(get(NULL, cloth, &count));
    assert_int_equal(count, 0);
    assert_non_null(get(started, cloth, NULL));
    for (int i = 0; i < 4; i++) {
        count = 7;
        assert_null(get(started, bad_cloths[i], &count));
        assert_int_equal(count, 0);
        assert_null(get(fresh, bad_cloths[i], NULL));
    }
}

static void check_obstacle_reader(obstacle_reader get) {
    size_t count = 7;
    assert_null(get(NULL, obstacle, &count));
    assert_int_equal(count, 0);
    assert_non_null(get(started, obstacle, NULL));
    for (int i = 0; i < 4; i++) {
        count = 7;
        assert_null(get(started, bad_obstacles[i], &count));
        assert_int_equal(count, 0);
        assert_null(get(fresh, bad_obstacles[i], NULL));
    }
}

ARGUMENTS_OF(tulle_cloth_get_positions) { check_cloth_reader(tulle_cloth_get_positions); }
ARGUMENTS_OF(tulle_cloth_get_velocities) { check_cloth_reader(tulle_cloth_get_velocities); }
ARGUMENTS_OF(tulle_obstacle_get_positions) { check_obstacle_reader(tulle_obstacle_get_positions); }
ARGUMENTS_OF(tulle_obstacle_get_velocities) {
    check_obstacle_reader(tulle_obstacle_get_velocities);
}

ARGUMENTS_OF(tulle_obstacle_is_present) {
    assert_int_equal(tulle_obstacle_is_present(NULL, obstacle), 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(tulle_obstacle_is_present(started, bad_obstacles[i]), 0);
}
ARGUMENTS_OF(tulle_obstacle_is_asleep) {
    assert_int_equal(tulle_obstacle_is_asleep(NULL, body), 0);
    assert_int_equal(tulle_obstacle_is_asleep(fresh, body), 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(tulle_obstacle_is_asleep(started, bad_obstacles[i]), 0);
}

ARGUMENTS_OF(tulle_obstacle_get_transform) {
    tulle_transform transform;
    REFUSED(tulle_obstacle_get_transform(NULL, body, &transform, &error));
    REFUSED(tulle_obstacle_get_transform(started, body, NULL, &error));
    REFUSED(tulle_obstacle_get_transform(started, obstacle, &transform, &error));
    REFUSED(tulle_obstacle_get_transform(fresh, body, &transform, &error));
    for (int i = 0; i < 4; i++)
        REFUSED(tulle_obstacle_get_transform(started, bad_obstacles[i], &transform, &error));
}

ARGUMENTS_OF(tulle_obstacle_add_impulse) {
    double const zero[3] = {0, 0, 0};
    REFUSED(tulle_obstacle_add_impulse(NULL, body, zero, zero, &error));
    REFUSED(tulle_obstacle_add_impulse(started, body, NULL, zero, &error));
    REFUSED(tulle_obstacle_add_impulse(started, body, zero, NULL, &error));
    REFUSED(tulle_obstacle_add_impulse(fresh, body, zero, zero, &error));
    for (int i = 0; i < 3; i++) {
        double const bad[3] = {0, no_numbers[i], 0};
        REFUSED(tulle_obstacle_add_impulse(started, body, bad, zero, &error));
        REFUSED(tulle_obstacle_add_impulse(started, body, zero, bad, &error));
    }
    for (int i = 0; i < 4; i++)
        REFUSED(tulle_obstacle_add_impulse(started, bad_obstacles[i], zero, zero, &error));
}

ARGUMENTS_OF(tulle_obstacle_get_contact_impulse) {
    double a[3], b[3];
    REFUSED(tulle_obstacle_get_contact_impulse(NULL, body, a, b, &error));
    REFUSED(tulle_obstacle_get_contact_impulse(started, body, NULL, b, &error));
    REFUSED(tulle_obstacle_get_contact_impulse(started, body, a, NULL, &error));
    for (int i = 0; i < 4; i++)
        REFUSED(tulle_obstacle_get_contact_impulse(started, bad_obstacles[i], a, b, &error));
}

ARGUMENTS_OF(tulle_obstacle_wake) {
    REFUSED(tulle_obstacle_wake(NULL, body, &error));
    for (int i = 0; i < 4; i++) REFUSED(tulle_obstacle_wake(started, bad_obstacles[i], &error));
}

ARGUMENTS_OF(tulle_world_get_contacts) {
    const tulle_contact *contacts;
    size_t count;
    REFUSED(tulle_world_get_contacts(NULL, &contacts, &count, &error));
    REFUSED(tulle_world_get_contacts(started, NULL, &count, &error));
    REFUSED(tulle_world_get_contacts(started, &contacts, NULL, &error));
}

ARGUMENTS_OF(tulle_world_find_largest_stretch) {
    assert_true(tulle_world_find_largest_stretch(NULL).stretch == 0.0);
}

ARGUMENTS_OF(tulle_cloth_get_fineness) {
    assert_true(tulle_cloth_get_fineness(NULL, cloth).mean_edge == 0.0);
    assert_true(tulle_cloth_get_fineness(fresh, cloth).mean_edge == 0.0);
    assert_true(tulle_cloth_get_fineness(started, cloth).mean_edge > 0.0);
    for (int i = 0; i < 4; i++)
        assert_true(tulle_cloth_get_fineness(started, bad_cloths[i]).mean_edge == 0.0);
}

ARGUMENTS_OF(tulle_world_get_numerical_damping) {
    static double const refused[] = {0.0, -1.0, (double)NAN, (double)INFINITY};
    assert_true(tulle_world_get_numerical_damping(NULL, 0.01, 1.0) == 0.0);
    assert_true(tulle_world_get_numerical_damping(fresh, 0.01, 1.0) > 0.0);
    for (size_t i = 0; i < 4; i++) {
        assert_true(tulle_world_get_numerical_damping(started, refused[i], 1.0) == 0.0);
        assert_true(tulle_world_get_numerical_damping(started, 0.01, refused[i]) == 0.0);
    }
    assert_true(isfinite(tulle_world_get_numerical_damping(started, 1e300, 1e-300)));
}

ARGUMENTS_OF(tulle_cloth_get_patches) {
    tulle_patch_options const good = {0};
    uint32_t labels[32];
    size_t count = 0;
    assert_true(sheet.triangle_count <= 32);
    REFUSED(tulle_cloth_get_patches(NULL, cloth, &good, labels, &count, &error));
    REFUSED(tulle_cloth_get_patches(started, cloth, NULL, labels, &count, &error));
    REFUSED(tulle_cloth_get_patches(started, cloth, &good, NULL, &count, &error));
    REFUSED(tulle_cloth_get_patches(started, cloth, &good, labels, NULL, &error));
    REFUSED(tulle_cloth_get_patches(fresh, cloth, &good, labels, &count, &error));
    for (int i = 0; i < 4; i++)
        REFUSED(tulle_cloth_get_patches(started, bad_cloths[i], &good, labels, &count, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        tulle_patch_options const steps = {no_numbers[i], 0.0, 0}, angles = {0.0, no_numbers[i], 0};
        REFUSED(tulle_cloth_get_patches(started, cloth, &steps, labels, &count, &error));
        REFUSED(tulle_cloth_get_patches(started, cloth, &angles, labels, &count, &error));
    }
    FINE(tulle_cloth_get_patches(started, cloth, &good, labels, &count, NULL));
}

ARGUMENTS_OF(tulle_world_get_state_hash) {
    assert_true(tulle_world_get_state_hash(NULL) == tulle_world_get_state_hash(fresh));
}

ARGUMENTS_OF(tulle_world_save_state) {
    void *bytes = NULL;
    size_t count = 0;
    REFUSED(tulle_world_save_state(NULL, &bytes, &count, &error));
    REFUSED(tulle_world_save_state(started, NULL, &count, &error));
    REFUSED(tulle_world_save_state(started, &bytes, NULL, &error));
    REFUSED(tulle_world_save_state(fresh, &bytes, &count, &error));
    assert_null(bytes);
}

ARGUMENTS_OF(tulle_world_free_state) {
    tulle_world_free_state(NULL, NULL, 0);
    tulle_world_free_state(NULL, &error, 1);
    tulle_world_free_state(started, NULL, SIZE_MAX);
}

ARGUMENTS_OF(tulle_world_load_state) {
    void *bytes = NULL;
    size_t count = 0;
    FINE(tulle_world_save_state(started, &bytes, &count, &error));
    REFUSED(tulle_world_load_state(NULL, bytes, count, &error));
    REFUSED_WITH(TULLE_ERROR_PARSE, tulle_world_load_state(started, bytes, 0, &error));
    REFUSED(tulle_world_load_state(started, NULL, count, &error));
    REFUSED(tulle_world_load_state(started, NULL, 0, &error));
    FINE(tulle_world_load_state(started, bytes, count, NULL));
    tulle_world_free_state(started, bytes, count);
}

int main(void) {
    return run_arguments(HEADERS("tulle/world.h", "tulle/paper.h"), set_up, tear_down);
}
