/* What a struct of zeros does, for each struct that a caller gives: it is refused in words that say
 * what is wrong, and with what call to begin where there is one; or zeros are what they say. A
 * struct that a header adds needs a line here. */
#include "api/arguments.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "tulle_io/tulle_io.h"

static const double STEP = 1.0 / 64.0;

/* The call is refused, and its message holds `words`. */
static void expect_words(tulle_status status, const char *words, int line) {
    if (status != TULLE_ERROR_INVALID_ARGUMENT && status != TULLE_ERROR_INVALID_MESH)
        fail_msg("line %d: status %d: %s", line, (int)status, error.message);
    if (!strstr(error.message, words))
        fail_msg("line %d: no '%s' in: %s", line, words, error.message);
    error = (tulle_error){0};
}
#define SAYS(words, call) expect_words((call), (words), __LINE__)

static tulle_mesh sheet, box;
static tulle_world *world; /* a sheet that is held at a corner; a driven box; a body */
static tulle_cloth_id held;
static tulle_obstacle_id driven, body;

static tulle_obstacle_def make_box(void) {
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    return def;
}

static tulle_cloth_def make_sheet(void) {
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    return def;
}

static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *made = NULL;
    FINE(tulle_world_create(&def, &made, &error));
    return made;
}

static int set_up(void **state) {
    (void)state;
    sheet = small_sheet(0.5, 4, 3.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box = small_shape(shape, 0.0, 0.0, 0.0);
    world = make_world();
    static const uint32_t corner[] = {0};
    tulle_pin pin = make_pin(corner, 1, (double)INFINITY);
    pin.motion = (tulle_motion){0};
    tulle_cloth_def cloth = make_sheet();
    cloth.pins = &pin;
    cloth.pin_count = 1;
    FINE(tulle_world_add_cloth(world, &cloth, &held, &error));
    tulle_obstacle_def def = make_box();
    def.drive = TULLE_DRIVE_RIGID;
    FINE(tulle_world_add_obstacle(world, &def, &driven, &error));
    tulle_mesh aside = small_shape(shape, 5.0, 0.0, 0.0);
    def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&aside);
    def.body.is_dynamic = 1;
    def.body.density = 1000.0;
    FINE(tulle_world_add_obstacle(world, &def, &body, &error));
    tulle_mesh_destroy(&aside);
    FINE(tulle_world_start(world, &error));
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
    return 0;
}

/* Those with a call that makes them say so. */
static void defs_are_refused(void **state) {
    (void)state;
    tulle_world *made = NULL;
    tulle_attachment_id attachment;
    SAYS("tulle_world_def_default", tulle_world_create(&(tulle_world_def){0}, &made, &error));
    SAYS("tulle_cloth_def_default",
         tulle_world_add_cloth(world, &(tulle_cloth_def){0}, NULL, &error));
    SAYS("tulle_obstacle_def_default",
         tulle_world_add_obstacle(world, &(tulle_obstacle_def){0}, NULL, &error));
    SAYS("tulle_attachment_def_default",
         tulle_world_attach(world, &(tulle_attachment_def){0}, &attachment, &error));
    tulle_pin const pin = {0};
    tulle_cloth_def cloth = make_sheet();
    cloth.pins = &pin;
    cloth.pin_count = 1;
    SAYS("tulle_pin_default", tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_mesh mesh;
    SAYS("tulle_shape_def_default", tulle_shape_generate(&(tulle_shape_def){0}, &mesh, &error));
    tulle_detector *detector = NULL;
    SAYS("tulle_detect_def_default",
         tulle_detector_create(&(tulle_detect_def){0}, &detector, &error));
    tulle_subdivision *subdivision = NULL;
    SAYS("tulle_subdivision_def_default",
         tulle_subdivision_create(tulle_mesh_get_view(&sheet), &(tulle_subdivision_def){0},
                                  &subdivision, &error));
    tulle_run_writer *writer = NULL;
    SAYS("tulle_run_def_default",
         tulle_run_create(&(tulle_run_def){0}, TULLE_RUN_REFUSE, &writer, &error));
    SAYS("tulle_animation_def_default",
         tulle_animation_write("none.glb", &(tulle_animation_def){0}, &error));
    SAYS("tulle_event_watch_default",
         tulle_world_watch_events(world, &(tulle_event_watch){0}, &error));
    SAYS("no kinds", tulle_world_watch_events(world, &(tulle_event_watch){.capacity = 9}, &error));
    SAYS("tulle_body_drive_default",
         tulle_obstacle_set_drive(world, body, &(tulle_body_drive){0}, &error));
}

static void materials_are_refused(void **state) {
    (void)state;
    tulle_cloth_def cloth = make_sheet();
    cloth.material = (tulle_material){0};
    SAYS("tulle_material_preset", tulle_world_add_cloth(world, &cloth, NULL, &error));
    SAYS("tulle_material_preset",
         tulle_cloth_set_material(world, held, &(tulle_material){0}, &error));
    cloth = make_sheet();
    cloth.material.warp = (tulle_curve){0};
    SAYS("warp", tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    tulle_world *made = NULL;
    FINE(tulle_world_create(&def, &made, &error));
    cloth = make_sheet();
    cloth.material.springs = (tulle_springs){0};
    SAYS("stretch", tulle_world_add_cloth(made, &cloth, NULL, &error));
    tulle_world_destroy(made);
}

static void wind_is_refused(void **state) {
    (void)state;
    SAYS("tulle_world_def_default", tulle_world_set_wind(world, &(tulle_wind){0}, &error));
    SAYS("tulle_world_def_default",
         tulle_world_set_wind(world, &(tulle_wind){.velocity = {5.0, 0.0, 0.0}}, &error));
    tulle_world_def def = tulle_world_def_default();
    def.wind = (tulle_wind){.velocity = {5.0, 0.0, 0.0}};
    tulle_world *made = NULL;
    SAYS("tulle_world_def_default", tulle_world_create(&def, &made, &error));
}

/* Without a call that makes them: the message names what is missing. */
static void others_are_refused(void **state) {
    (void)state;
    tulle_cloth_def cloth = make_sheet();
    tulle_crease const crease = {0};
    cloth.creases = &crease;
    cloth.crease_count = 1;
    SAYS("edge", tulle_world_add_cloth(world, &cloth, NULL, &error));
    cloth = make_sheet();
    cloth.mesh = (tulle_mesh_view){0};
    SAYS("no triangles", tulle_world_add_cloth(world, &cloth, NULL, &error));
    tulle_keyframe const keys[2] = {{.time = 0.0}, {.time = 0.0}};
    tulle_obstacle_def def = make_box();
    def.motion = (tulle_motion){.keys = keys, .key_count = 2};
    SAYS("keyframe", tulle_world_add_obstacle(world, &def, NULL, &error));
    def = make_box();
    def.body = (tulle_body){.is_dynamic = 1};
    SAYS("mass", tulle_world_add_obstacle(world, &def, NULL, &error));
    tulle_keyframe const way[2] = {{.time = 0.0}, {.time = 1.0}};
    def.body = (tulle_body){.is_dynamic = 1, .mass = 1.0}; /* free from 0 s on */
    def.motion = (tulle_motion){.keys = way, .key_count = 2};
    SAYS("start_time", tulle_world_add_obstacle(world, &def, NULL, &error));
    def.body.start_time = 0.5; /* its motion has it move */
    def.body.angular_velocity[1] = 1.0;
    SAYS("leave its own velocity out", tulle_world_add_obstacle(world, &def, NULL, &error));
    static const uint32_t triangle[] = {0, 1, 2};
    tulle_detect_surface const surface = {0};
    tulle_detect_def detect = tulle_detect_def_default();
    detect.triangles = triangle;
    detect.triangle_count = 1;
    detect.vertex_count = 3;
    detect.surfaces = &surface;
    detect.surface_count = 1;
    tulle_detector *detector = NULL;
    SAYS("must cover all 3 vertices", tulle_detector_create(&detect, &detector, &error));
    detect.surfaces = NULL;
    detect.surface_count = 0;
    FINE(tulle_detector_create(&detect, &detector, &error));
    static const double x[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    tulle_detect_result result;
    SAYS("receive",
         tulle_detector_stream_events(detector, x, x, (tulle_detect_receiver){0}, &result, &error));
    tulle_detector_destroy(detector);
    tulle_hit hit;
    SAYS("ray", tulle_world_cast_ray(world, &(tulle_ray){0}, &hit, &error));
    SAYS("null", tulle_object_copy_values(world, tulle_world_get_object(world, 0),
                                          TULLE_VALUES_POSITIONS, &(tulle_target){0}, &error));
    SAYS("no such", tulle_object_copy_values(world, (tulle_object_id){0}, TULLE_VALUES_POSITIONS,
                                             &(tulle_target){0}, &error));
    SAYS("no such cloth", tulle_world_remove_cloth(world, (tulle_cloth_id){0}, &error));
    SAYS("no such obstacle", tulle_world_remove_obstacle(world, (tulle_obstacle_id){0}, &error));
    tulle_transform const transform = {0};
    SAYS("quaternion",
         tulle_obstacle_set_next_transform(world, driven, transform.position, transform.rotation,
                                           TULLE_TRAVEL_MOVE, &error));
    tulle_world *made = make_world();
    SAYS("no function", tulle_world_record(made, &(tulle_record_writer){0}, &error));
    SAYS("no function", tulle_world_set_tasks(made, &(tulle_tasks){0}, &error));
    small_add_cloth(made, &sheet);
    SAYS("positions", tulle_world_start_at(made, &(tulle_moment){0}, &error));
    tulle_world_destroy(made);
    SAYS("null", tulle_worlds_step(&(tulle_world_batch){.count = 1}, STEP, &error));
}

/* What zeros mean where they are fine. */
static void zeros_that_are_meant(void **state) {
    (void)state;
    /* a keyframe: at rest at 0 s; a motion without any: none; a body: the obstacle is none */
    tulle_world *made = make_world();
    tulle_keyframe const key = {0};
    tulle_obstacle_def def = make_box();
    def.motion = (tulle_motion){.keys = &key, .key_count = 1};
    tulle_obstacle_id on_key, still;
    FINE(tulle_world_add_obstacle(made, &def, &on_key, &error));
    def = make_box();
    def.motion = (tulle_motion){0};
    def.body = (tulle_body){0};
    FINE(tulle_world_add_obstacle(made, &def, &still, &error));
    tulle_cloth_id const cloth = small_add_cloth(made, &sheet);
    /* a law: no friction, no rebound */
    FINE(tulle_world_set_cloth_obstacle_law(made, cloth, still, &(tulle_contact_law){0}, &error));
    FINE(tulle_world_start(made, &error));
    for (int i = 0; i < 3; i++) FINE(tulle_world_step(made, STEP, NULL, &error));
    const tulle_obstacle_id ids[2] = {on_key, still};
    for (int k = 0; k < 2; k++) {
        const double *const x = tulle_obstacle_get_positions(made, ids[k], NULL);
        assert_memory_equal(x, box.positions, 3 * box.vertex_count * sizeof *x);
    }
    /* patches of the shape as it is; nothing found has room; a batch of none */
    uint32_t *const labels = calloc(sheet.triangle_count, sizeof *labels);
    size_t patch_count = 0;
    FINE(tulle_cloth_get_patches(made, cloth, &(tulle_patch_options){0}, labels, &patch_count,
                                 &error));
    assert_true(patch_count > 0);
    free(labels);
    tulle_found found = {0};
    static const double low[3] = {-9, -9, -9}, high[3] = {9, 9, 9};
    FINE(tulle_world_find_box_overlaps(made, low, high, 0, &found, &error));
    assert_true(found.count > 0);
    FINE(tulle_worlds_step(&(tulle_world_batch){0}, STEP, &error));
    tulle_world_destroy(made);
    /* a motion of zeros holds the pin; an allocator: malloc, by which all worlds here are made */
    double const height = tulle_cloth_get_positions(world, held, NULL)[2];
    for (int i = 0; i < 3; i++) FINE(tulle_world_step(world, STEP, NULL, &error));
    assert_true(tulle_cloth_get_positions(world, held, NULL)[2] == height);
    /* a body to check: empty */
    tulle_check_result result;
    FINE(tulle_check_intersections(&(tulle_check_body){0}, 1, 1, &result, &error));
    assert_int_equal(result.pair_count, 0);
    tulle_check_result_destroy(&result);
    tulle_mesh empty = {0};
    tulle_mesh_destroy(&empty);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defs_are_refused),     cmocka_unit_test(materials_are_refused),
        cmocka_unit_test(wind_is_refused),      cmocka_unit_test(others_are_refused),
        cmocka_unit_test(zeros_that_are_meant),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
